//! Edge-case tests that all kinematics share.

use crate::testing::{Rig, Space};
use hal_bench::Random;
use hal_component::{Component, Pose, Solved, Unsolved};

/// Asserts that odd inputs produce finite numbers or an error, and that an error changes nothing.
pub(crate) fn edges<C: Component>(args: &[&str], space: &Space<'_>) {
    const ODD: [f64; 9] =
        [0.0, f64::NAN, f64::INFINITY, f64::NEG_INFINITY, 1e300, -1e300, 1e-300, -1.0, 1e9];
    let rig = Rig::new::<C>(args);
    rig.set(space.set);
    assert!(rig.k.switch(space.switch));
    let ask = |joints: &[f64], pose: &Pose| {
        let mut to = *pose;
        match rig.k.forward(joints, &mut to) {
            Ok(_) => assert!(to.iter().all(|p| p.is_finite()), "{joints:?}: {to:?}"),
            Err(_) => assert_eq!(to.map(f64::to_bits), pose.map(f64::to_bits)),
        }
        let mut to = joints.to_vec();
        match rig.k.inverse(pose, &mut to) {
            Ok(_) => assert!(to.iter().all(|p| p.is_finite()), "{pose:?}: {to:?}"),
            Err(_) => {
                let bits = |list: &[f64]| list.iter().map(|x| x.to_bits()).collect::<Vec<_>>();
                assert_eq!(bits(&to), bits(joints));
            }
        }
    };
    let mut random = Random::new(1);
    let n = rig.k.joints();
    let any = |random: &mut Random| {
        let mut joints: Vec<f64> =
            space.joints.iter().map(|j| random.between(j.range.0, j.range.1)).collect();
        joints.resize(n, 0.0);
        let mut pose = [0.0; 9];
        for (i, l) in space.letters.iter().enumerate() {
            let most = if (3..6).contains(l) { 180.0 } else { space.size };
            let (low, high) = *space.poses.get(i).unwrap_or(&(-most, most));
            pose[*l] = random.between(low, high);
        }
        (joints, pose)
    };
    for odd in ODD {
        for i in 0..16 {
            let (mut joints, mut pose) = any(&mut random);
            for list in [&mut joints[..], &mut pose[..]] {
                if let Some(place) = list.get_mut(i) {
                    *place = odd;
                }
            }
            ask(&joints, &pose);
        }
    }
    // Too few joints.
    let mut pose = [0.5; 9];
    assert_eq!(rig.k.forward(&vec![0.0; n - 1], &mut pose), Err(Unsolved::NoNumber));
    // Random poses of any size, most of which are out of reach.
    for _ in 0..500 {
        let (joints, mut pose) = any(&mut random);
        for p in &mut pose {
            *p *= 10f64.powf(random.between(-3.0, 3.0));
        }
        ask(&joints, &pose);
    }
    // Odd values for each length of the machine, one at a time.
    for line in rig.bench.names() {
        let mut words = line.split_whitespace();
        let (name, ty, dir) = (words.next().unwrap(), words.next().unwrap(), words.next().unwrap());
        if ty != "float" || dir == "OUT" || dir == "RO" {
            continue;
        }
        let before: f64 = rig.bench.get(name);
        for odd in ODD {
            for _ in 0..8 {
                rig.bench.set(name, odd);
                let (joints, pose) = any(&mut random);
                ask(&joints, &pose);
                if !odd.is_finite() && !name.starts_with("skgui") {
                    let mut to = pose;
                    let solved = rig.k.forward(&joints, &mut to);
                    assert!(
                        solved != Ok(Solved::Regular) || to == pose || is_output(name),
                        "{name} {odd}"
                    );
                }
            }
        }
        rig.bench.set(name, before);
    }
}

/// Returns whether the kinematics write this pin, or do not read it.
fn is_output(name: &str) -> bool {
    let last = name.rsplit('.').next().unwrap_or_default();
    ["x", "y", "z", "a", "b", "c", "param-rw"].contains(&last)
}
