//! The closed form: known poses, all solutions of random poses, limits.
#![expect(clippy::unwrap_used, clippy::indexing_slicing, reason = "tests")]

use crate::random;

use hal_arm::{
    Arm, CONFIGURATIONS, Frame, Joints, Miss,
    rotation::{Vector, from_zyz, to_zyz},
};
use random::Random;

#[track_caller]
fn close(a: &[f64], b: &[f64], within: f64) {
    assert_eq!(a.len(), b.len());
    assert!(a.iter().zip(b).all(|(a, b)| (a - b).abs() <= within), "{a:?} is not {b:?}");
}

fn flange(place: [f64; 3], zyz: [f64; 3]) -> Frame {
    Frame { origin: Vector::from(place), turn: from_zyz(zyz) }
}

/// Arm without limits, other than that a joint makes no full turn.
fn free(arm: Arm) -> Arm {
    Arm { min: [-180.0; 6], max: [180.0; 6], ..arm }
}

#[test]
fn known_joints_give_known_poses() {
    let rx: &[(Joints, [f64; 3], [f64; 3])] = &[
        ([0.0; 6], [450.0, 0.0, 535.0], [0.0; 3]),
        ([0.0, -90.0, 90.0, 0.0, 0.0, 0.0], [0.0, 0.0, 985.0], [0.0; 3]),
        ([0.0, -45.0, 135.0, 0.0, 90.0, 0.0], [768.1981, 0.0, 233.1981], [0.0, 180.0, 0.0]),
        (
            [30.0, -60.0, 120.0, 20.0, 45.0, -30.0],
            [591.6116, 365.3041, 595.8509],
            [44.3608, 102.82, -12.3158],
        ),
    ];
    let rs: &[(Joints, [f64; 3], [f64; 3])] = &[
        ([0.0; 6], [0.0, 120.0, 576.5], [0.0; 3]),
        ([-90.0, 0.0, 0.0, 0.0, 0.0, 0.0], [-120.0, 0.0, 576.5], [0.0, 0.0, 90.0]),
        ([0.0, 0.0, 0.0, 0.0, 90.0, 0.0], [0.0, 43.5, 500.0], [-90.0, 90.0, 90.0]),
        (
            [20.0, 30.0, -80.0, 10.0, -60.0, 40.0],
            [157.994, 467.7214, 56.6093],
            [110.1694, 166.5183, -5.5794],
        ),
    ];
    for (arm, rows) in [(Arm::RX90, rx), (Arm::RS03N, rs)] {
        for (joints, place, zyz) in rows {
            let found = arm.flange(joints);
            close(found.origin.as_slice(), place, 1e-4);
            close(&to_zyz(&found.turn), zyz, 1e-4);
        }
    }
}

#[test]
fn eight_ways_to_one_pose() {
    let joints = [30.0, -60.0, 120.0, 20.0, 45.0, -30.0];
    let pose = Arm::RX90.flange(&joints);
    let expected: [Joints; 8] = [
        joints,
        [30.0, -60.0, 120.0, -160.0, -45.0, 150.0],
        [30.0, -30.0, 60.0, 14.5919, 73.7314, -19.7384],
        [30.0, -30.0, 60.0, -165.4081, -73.7314, 160.2616],
        [-150.0, -120.0, 60.0, -160.0, 45.0, -30.0],
        [-150.0, -120.0, 60.0, 20.0, -45.0, 150.0],
        [-150.0, -150.0, 120.0, -165.4081, 73.7314, -19.7384],
        [-150.0, -150.0, 120.0, 14.5919, -73.7314, 160.2616],
    ];
    for (configuration, expected) in expected.iter().enumerate() {
        let way = Arm::RX90.solve(&pose, configuration, &[0.0; 6]).unwrap();
        close(&way.joints, expected, 1e-4);
        assert_eq!(Arm::RX90.configuration(&way.joints), configuration);
    }
}

#[test]
fn the_milling_arm_reaches_its_prism() {
    let down = |place| flange(place, [-90.0, 180.0, 0.0]);
    for (place, expected) in [
        ([-400.0, 0.0, -30.0], [-90.0, 25.1588, -110.8242, 0.0, -44.017, 0.0]),
        ([-550.0, 250.0, 40.0], [-65.556, 71.3076, -10.3254, 0.0, -98.367, -24.444]),
        ([-250.0, 0.0, -100.0], [-90.0, 25.5669, -149.3595, 0.0, -5.0736, 0.0]),
    ] {
        let found = (0..CONFIGURATIONS).filter_map(|c| {
            let way = Arm::RS03N.solve(&down(place), c, &[0.0; 6]).ok()?;
            way.joints.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-4).then_some(c)
        });
        assert!(found.count() > 0, "{place:?}");
    }
    let failures = |d6: f64, tool: f64| {
        let arm = Arm { d6, ..Arm::RS03N };
        let mut failed = [0; 9];
        let mut points = 0;
        for (i, j, k) in
            (0..13).flat_map(|i| (0..21).flat_map(move |j| (0..8).map(move |k| (i, j, k))))
        {
            let (x, y) = (-550.0 + 25.0 * f64::from(i), -250.0 + 25.0 * f64::from(j));
            let z = -100.0 + 20.0 * f64::from(k) + tool;
            points += 1;
            let mut all = true;
            for (c, failed) in failed.iter_mut().enumerate().take(8) {
                let missed = arm.solve(&down([x, y, z]), c, &[0.0; 6]).is_err();
                *failed += u32::from(missed);
                all &= missed;
            }
            failed[8] += u32::from(all);
        }
        (points, failed)
    };
    for d6 in [71.5, 76.5, 80.0] {
        let (points, failed) = failures(d6, 0.0);
        assert_eq!(points, 2184);
        assert_eq!(failed[..2], [0, 0], "{d6}");
    }
    assert_eq!(failures(85.0, 0.0).1[..2], [2, 2]);
    assert_eq!(failures(76.5, 200.0).1[8], 232);
}

#[test]
fn a_miss_says_by_how_much() {
    let tool = Frame { origin: Vector::new(0.0, 0.0, 275.0), ..Frame::identity() };
    let tip = |place| flange(place, [0.0, 180.0, 180.0]).then(&tool.inverse());
    let miss = |place, c| Arm::RX90.solve(&tip(place), c, &[0.0; 6]);
    for c in 0..CONFIGURATIONS {
        let Err(Miss::Reach { by }) = miss([900.0, 0.0, -300.0], c) else { panic!("{c}") };
        close(&[by], &[2.0], 5e-3);
        // Joint 5 fails in all, whatever joint 1 does.
        let mut body = Arm::RX90;
        (body.min[0], body.max[0]) = (-180.0, 180.0);
        let way = body.solve(&tip([100.0, 0.0, 300.0]), c, &[0.0; 6]);
        assert!(matches!(way, Err(Miss::Limit { joint: 4, .. })), "{c}: {way:?}");
        match (c, miss([800.0, 0.0, -560.0], c)) {
            (0 | 1, way) => assert!(way.is_ok()),
            (2 | 3, Err(Miss::Limit { joint, angle, limit })) => {
                assert_eq!(joint, 1);
                close(&[angle, limit], &[37.65, 35.0], 5e-3);
            }
            (c, way) => assert!(c > 3, "{c}: {way:?}"),
        }
        match (c, miss([845.0, 0.0, -300.0], c)) {
            (3, Err(Miss::Limit { joint, angle, limit })) => {
                assert_eq!(joint, 4);
                close(&[angle, limit], &[-113.8, -105.0], 5e-2);
            }
            (4.., Err(Miss::Limit { joint, .. })) => assert_eq!(joint, 0),
            (c, way) => assert!(c < 3, "{c}: {way:?}"),
        }
    }
}

/// Asserts for random joints that exactly the solutions of their pose are found, and that each leads back to it.
fn random_poses(arm: &Arm, rounds: u32, seed: u64) {
    let size = arm.a1 + arm.a2 + arm.d4 + arm.d6;
    let mut random = Random(seed);
    let mut counts = [0_u32; CONFIGURATIONS + 1];
    for round in 0..rounds {
        let joints: Joints = core::array::from_fn(|n| random.between(arm.min[n], arm.max[n]));
        let pose = arm.flange(&joints);
        let mut ways = Vec::new();
        let found = arm.each(&pose, &joints, |configuration, way| {
            let again = arm.flange(&way.joints);
            let off = (again.origin - pose.origin).amax() / size;
            let turned = (again.turn - pose.turn).amax();
            assert!(
                off < 1e-9 && turned < 1e-9,
                "{round} {configuration}: {joints:?} {off} {turned}"
            );
            let regular = !way.is_singular;
            assert!(!regular || arm.configuration(&way.joints) == configuration, "{round} {way:?}");
            assert!(arm.margin(&way.joints).1 >= 0.0);
            ways.push(way.joints);
        });
        assert!(found.is_ok(), "{round}: {joints:?}");
        let own = arm.configuration(&joints);
        let way = arm.solve(&pose, own, &joints).unwrap();
        let apart = |a: &Joints, b: &Joints| {
            a.iter().zip(b).map(|(a, b)| libm::remainder(a - b, 360.0).abs()).fold(0.0, f64::max)
        };
        assert!(
            way.is_singular || apart(&way.joints, &joints) < 1e-4,
            "{round}: {joints:?} {way:?}"
        );
        for (n, a) in ways.iter().enumerate() {
            let twice = ways[..n].iter().any(|b| apart(a, b) < 1e-9);
            assert!(!twice, "{round}: {a:?} twice");
        }
        // The wrist's distances to both shoulders decide alone how many there are.
        let wrist = pose.origin - pose.turn * Vector::new(0.0, 0.0, arm.d6);
        let across = wrist.x.hypot(wrist.y);
        let reaches = [across, -across].map(|out| {
            let far = (out - arm.a1).hypot(wrist.z - arm.d1);
            let fore = arm.a3.hypot(arm.d4);
            (far - (arm.a2 - fore).abs()).min(arm.a2 + fore - far)
        });
        let is_free = arm.max.iter().zip(&arm.min).all(|(a, b)| a - b >= 360.0);
        if is_free && reaches.iter().all(|r| r.abs() > 1e-6 * size) {
            let expected = 4 * reaches.iter().filter(|r| **r > 0.0).count();
            assert_eq!(ways.len(), expected, "{round}: {joints:?}");
        }
        counts[ways.len()] += 1;
    }
    assert!(counts[8] > 0 && counts[0] == 0, "{counts:?}");
}

#[test]
fn all_solutions_and_no_others() {
    for (n, arm) in [Arm::RX90, Arm::RS03N].into_iter().enumerate() {
        random_poses(&arm, 5_000, n as u64);
        random_poses(&free(arm), 5_000, 10 + n as u64);
    }
    let odd = Arm { a3: -70.0, d1: 300.0, d4: 380.0, ..free(Arm::RS03N) };
    random_poses(&odd, 5_000, 20);
}

#[test]
#[ignore = "50 times the poses that every run has: cargo test -p hal-arm -- --ignored a_million"]
fn a_million_poses() {
    for (n, arm) in [Arm::RX90, Arm::RS03N].into_iter().enumerate() {
        random_poses(&arm, 250_000, 100 + n as u64);
        random_poses(&free(arm), 250_000, 110 + n as u64);
    }
}

#[test]
fn singular_frames_keep_the_undetermined_joints() {
    // A straight wrist.
    let joints = [10.0, -70.0, 100.0, 25.0, 0.0, 30.0];
    let pose = Arm::RX90.flange(&joints);
    let way = Arm::RX90.solve(&pose, 0, &[10.0, -70.0, 100.0, 11.0, 0.0, 0.0]).unwrap();
    assert!(way.is_singular);
    close(&way.joints, &[10.0, -70.0, 100.0, 11.0, 0.0, 44.0], 1e-6);
    let mut count = 0;
    free(Arm::RX90).each(&pose, &joints, |_, _| count += 1).unwrap();
    assert_eq!(count, 6, "the wrist is straight for one elbow in front and one at the back");
    // A wrist above the axis of joint 1.
    let joints = [40.0, -135.0, 180.0, 30.0, 50.0, 20.0];
    let pose = Arm::RX90.flange(&joints);
    let way = Arm::RX90.solve(&pose, Arm::RX90.configuration(&joints), &joints).unwrap();
    assert!(way.is_singular);
    close(&way.joints, &joints, 1e-6);
    // A wrist bent back by half a turn is beyond the limits of both arms.
    let pose = Arm::RX90.flange(&[10.0, -70.0, 100.0, 25.0, 180.0, 30.0]);
    let miss = Arm::RX90.solve(&pose, 0, &[0.0; 6]);
    assert!(matches!(miss, Err(Miss::Limit { joint: 4, .. })), "{miss:?}");
}
