//! Kinematics of machines whose joints each move along one axis.
#![forbid(unsafe_code)]

mod map;

use hal_component::{
    Arg, Builder, Component, Error, Kinematics, KinematicsKind, Pose, Solution, Solved, Touch,
    abi::{ArgSpec, component_flags},
};
use map::Map;

/// `loadrt trivkins`.
#[derive(Debug)]
pub struct Trivkins;

impl Component for Trivkins {
    const NAME: &'static str = "trivkins";
    const DOC: &'static str = "\
Kinematics of a machine whose joints each move along one axis.

`coordinates=XYZ` gives joint 0 to X, joint 1 to Y and joint 2 to Z. A letter may occur more than
once: with `XYYZ` joints 1 and 2 both follow Y, and the position of Y is read from joint 1. It has
no pins and no functions; load it before `motmod`.

# Example

```hal
loadrt trivkins coordinates=XYZ
loadrt motmod num_joints=3
addf motion-command-handler servo-thread
addf motion-controller servo-thread
start
run 10ms
getp motion.on-soft-limit # -> FALSE
```";
    const FLAGS: u32 = component_flags::ONCE | component_flags::PARALLEL;
    const ARGS: &'static [&'static ArgSpec] = &[
        &Arg::text(
            "coordinates",
            "One letter per joint out of X Y Z A B C U V W, in either case, at most 16; spaces \
             between them do not count.",
        )
        .or("XYZABCUVW"),
        &Arg::text(
            "kinstype",
            "What it calls itself, by its first letter: 1 identity, b both ways, f forward only, \
             i inverse only.",
        )
        .or("1"),
    ];

    fn create(b: &mut Builder<'_>) -> Result<(), Error> {
        let map = Map::parse(&b.arg_text("coordinates").unwrap_or_default()).map_err(Error::new)?;
        let kind = kind(&b.arg_text("kinstype").unwrap_or_default())?;
        b.offer_kinematics(Service { map, kind })
    }
}

fn kind(text: &str) -> Result<KinematicsKind, Error> {
    match text.chars().next() {
        Some('1') => Ok(KinematicsKind::Identity),
        Some('b' | 'B') => Ok(KinematicsKind::Both),
        Some('f' | 'F') => Ok(KinematicsKind::ForwardOnly),
        Some('i' | 'I') => Ok(KinematicsKind::InverseOnly),
        _ => Err(Error::new(format!(
            "kinstype '{text}' is none of 1 (identity), b (both), f (forward only) and i \
             (inverse only)"
        ))),
    }
}

/// Kinematics service, which computes both directions whatever `kinstype` says.
#[derive(Touch)]
struct Service {
    #[state]
    map: Map,
    #[state]
    kind: KinematicsKind,
}

impl Kinematics for Service {
    fn joints(&self) -> usize {
        self.map.joints()
    }

    fn kind(&self) -> KinematicsKind {
        self.kind
    }

    fn joint_of(&self, letter: usize) -> Option<usize> {
        self.map.joint_of(letter)
    }

    fn forward(&self, joints: &[f64], pose: &mut Pose) -> Solution {
        self.map.forward(joints, pose);
        Ok(Solved::Regular)
    }

    fn inverse(&self, pose: &Pose, joints: &mut [f64]) -> Solution {
        self.map.inverse(pose, joints);
        Ok(Solved::Regular)
    }
}

hal_component::export!(Trivkins);

#[cfg(test)]
mod tests {
    use super::*;
    use hal_bench::Bench;
    use hal_component::{In, Period, Update};

    /// Component that runs the kinematics of the bench on pins, as `motmod` would.
    struct User;

    #[derive(Touch)]
    struct Both {
        k: hal_component::KinematicsRef,
        letters: Vec<In<f64>>,
        joints: Vec<hal_component::Out<f64>>,
        back: Vec<hal_component::Out<f64>>,
    }

    impl Update for Both {
        fn update(&mut self, _: Period) {
            let mut pose: Pose = [0.0; 9];
            for (p, pin) in pose.iter_mut().zip(&self.letters) {
                *p = pin.get();
            }
            let mut joints = [0.0; 16];
            self.k.inverse(&pose, &mut joints).unwrap();
            let mut back = [-1.0; 9];
            // Actual joint positions: a duplicate lags behind.
            for (i, j) in joints.iter_mut().enumerate() {
                *j += i as f64 * 0.125;
            }
            self.k.forward(&joints, &mut back).unwrap();
            self.joints.iter().zip(joints).for_each(|(pin, j)| pin.set(j));
            self.back.iter().zip(back).for_each(|(pin, p)| pin.set(p));
        }
    }

    impl Component for User {
        const NAME: &'static str = "user";
        const DOC: &'static str = "Uses kinematics.";
        const FLAGS: u32 = component_flags::ONCE;
        fn create(b: &mut Builder<'_>) -> Result<(), Error> {
            let k = b.kinematics()?;
            let (mut letters, mut joints, mut back) = (Vec::new(), Vec::new(), Vec::new());
            for l in 0..9 {
                letters.push(b.item(&format!("l{l}"), "Pose in.", 0.0)?);
                back.push(b.item(&format!("b{l}"), "Pose back.", 0.0)?);
            }
            for j in 0..16 {
                joints.push(b.item(&format!("j{j}"), "Joint.", 0.0)?);
            }
            b.function("both", "Both ways.", Both { k, letters, joints, back })
        }
    }

    fn run(args: &[&str]) -> (Vec<f64>, Vec<f64>) {
        let mut bench = Bench::new();
        bench.load::<Trivkins>(args).unwrap();
        bench.load::<User>(&[]).unwrap();
        for l in 0..9 {
            bench.set(&format!("l{l}"), f64::from(10 * (l + 1)));
        }
        bench.run("both", 1_000_000);
        let all = |c: char, n: usize| (0..n).map(|i| bench.get(&format!("{c}{i}"))).collect();
        (all('j', 5), all('b', 9))
    }

    #[test]
    fn both_ways() {
        let all = run(&[]);
        assert_eq!(all.0, [10.0, 20.125, 30.25, 40.375, 50.5]);
        assert_eq!(all.1, [10.0, 20.125, 30.25, 40.375, 50.5, 60.625, 70.75, 80.875, 91.0]);
        // Joints 1 and 2 follow Y, which is read from joint 1; letters without a joint keep their values.
        let gantry = run(&["coordinates=xyyz", "kinstype=Both"]);
        assert_eq!(gantry.0, [10.0, 20.125, 20.25, 30.375, 0.5]);
        assert_eq!(gantry.1, [10.0, 20.125, 30.375, -1.0, -1.0, -1.0, -1.0, -1.0, -1.0]);
    }

    #[test]
    fn refusals_are_named() {
        for (args, text) in [
            ("coordinates=xyzq", "coordinates 'xyzq': 'q' is none of X Y Z A B C U V W"),
            ("coordinates=X,Y", "coordinates 'X,Y': ',' is none of X Y Z A B C U V W"),
            (
                "coordinates=XYZABCUVWXYZABCUVW",
                "coordinates 'XYZABCUVWXYZABCUVW' name 18 joints, at most 16 are possible",
            ),
            (
                "kinstype=z",
                "kinstype 'z' is none of 1 (identity), b (both), f (forward only) and i \
                 (inverse only)",
            ),
        ] {
            assert_eq!(Bench::new().load::<Trivkins>(&[args]).unwrap_err(), text);
        }
    }

    #[test]
    fn what_it_calls_itself() {
        for (text, expected) in [
            ("1", KinematicsKind::Identity),
            ("b", KinematicsKind::Both),
            ("Forward", KinematicsKind::ForwardOnly),
            ("I", KinematicsKind::InverseOnly),
        ] {
            assert_eq!(kind(text).unwrap(), expected, "{text}");
        }
    }
}
