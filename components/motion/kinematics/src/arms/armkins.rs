//! `armkins`.

use crate::{
    model::{Found, Joints, Model, is_finite},
    names::{example, names},
    rotation::to_abc,
    switch::{COORDINATES, SPARM, Switched},
};
use hal_arm::{Arm, CONFIGURATIONS, Frame, Miss, Way};
use hal_component::{
    Arg, Builder, Error, In, Out, ParamRw, Pose, Solution, Solved, Touch, Unsolved, Ways,
    abi::ArgSpec,
};

const DOC: &str = concat!(
    "\
Kinematics of a robot arm of six turning joints with limits, solved in closed form.

The arm has its last three axes in one point, the wrist. Its dimensions are Denavit-Hartenberg
parameters: A1 from the axis of joint 1 to that of joint 2, A2 the upper arm, A3 the offset of the
elbow, D1 the height of joint 2, D4 the forearm, D6 from the wrist to the flange. `model=` selects
defaults: `rx90` (985 mm) or `rs03n` (620 mm). The model's angle of a joint is offset-N + sign-N times
its position; joints are counted from 0.

The pose is the tool's tip X Y Z and how it is turned: roll A, pitch B, yaw C about the fixed axes, in
the frame `armkins.frame`. A pose has up to eight solutions; their numbers are 4 if the arm reaches
backwards, plus 2 if the elbow is down, plus 1 if the wrist is flipped. `armkins.config` selects one;
with -1 the one nearest to the joints counts. Positions that differ by whole turns are chosen within
min-N and max-N, near the joints. A solution beyond a limit does not count. With a straight wrist
joint 3 stays, with the wrist above the base joint 0 does: these are singular places, and so is a
stretched elbow. (Pieper, The Kinematics of Manipulators under Computer Control, 1968.)

The output pins show the last computation of joints, by the planner too.

In types 1 and 2 every joint is an axis; `motion.switchkins-type` says which type is in force.",
    example!(
        "armkins",
        6,
        "setp armkins.tool.z 100\n",
        "motion.jog joint=1 velocity=50 position=-60\nmotion.jog joint=2 velocity=50 position=120\n\
         motion.jog joint=4 velocity=50 position=45\nrun 10s\ngetp motion.in-position # -> TRUE\n\
         motion.move x=700 y=100 z=200 velocity=20 --wait\ngetp armkins.solution # -> 0\n\
         show pin joint.*.pos-cmd\n"
    )
);

const ARGS: &[&ArgSpec] = &[
    &COORDINATES.or("XYZABC"),
    &SPARM,
    &Arg::text("model", "The arm whose dimensions and limits are the defaults: rx90 or rs03n.")
        .or("rx90"),
];

names! {
    DOC, ARGS, create;
    /// `loadrt armkins`.
    Armkins = "armkins";
}

fn create(b: &mut Builder<'_>) -> Result<(), Error> {
    let model = b.arg_text("model").unwrap_or_default();
    let arm = match model.as_str() {
        "rx90" => Arm::RX90,
        "rs03n" => Arm::RS03N,
        _ => return Err(Error::new(format!("model is '{model}', must be rx90 or rs03n"))),
    };
    Switched::offer_six(b, |b| Pins::make(b, &arm))
}

/// Pins and parameters of the arm.
#[derive(Debug, Touch)]
struct Pins {
    lengths: [ParamRw<f64>; 6],
    joints: Vec<Joint>,
    tool: FramePins,
    frame: FramePins,
    config: In<i32>,
    solution: Out<i32>,
    margin: Out<f64>,
    singular: Out<bool>,
    unreachable: Out<bool>,
}

/// Parameters of a joint.
#[derive(Debug, Touch)]
struct Joint {
    offset: ParamRw<f64>,
    sign: ParamRw<i32>,
    min: ParamRw<f64>,
    max: ParamRw<f64>,
}

/// Pins that hold a frame.
#[derive(Debug, Touch)]
struct FramePins {
    numbers: [In<f64>; 6],
}

impl FramePins {
    fn make(b: &mut Builder<'_>, name: &str, what: &str) -> Result<Self, Error> {
        let mut pin = |letter, about| {
            b.item(&format!("armkins.{name}.{letter}"), &format!("{about} of {what}."), 0.0)
        };
        Ok(Self {
            numbers: [
                pin("x", "Position along X, in units,")?,
                pin("y", "Position along Y, in units,")?,
                pin("z", "Position along Z, in units,")?,
                pin("a", "Roll about the fixed X axis, in degrees,")?,
                pin("b", "Pitch about the fixed Y axis, in degrees,")?,
                pin("c", "Yaw about the fixed Z axis, in degrees,")?,
            ],
        })
    }

    fn get(&self) -> Option<Frame> {
        let numbers = self.numbers.each_ref().map(In::get);
        is_finite(&numbers).then(|| Frame::from_xyzabc(numbers))
    }
}

impl Pins {
    fn make(b: &mut Builder<'_>, arm: &Arm) -> Result<Self, Error> {
        let mut length = |name, about: &str, value| {
            b.item(&format!("armkins.{name}"), &format!("{about}, in units."), value)
        };
        let lengths = [
            length("A1", "Distance between the axes of joints 0 and 1", arm.a1)?,
            length("A2", "Length of the upper arm, above 0", arm.a2)?,
            length("A3", "Distance from the axis of joint 2 to the forearm's", arm.a3)?,
            length("D1", "Height of the axis of joint 1", arm.d1)?,
            length("D4", "Length of the forearm, up to the wrist", arm.d4)?,
            length("D6", "Distance from the wrist to the flange", arm.d6)?,
        ];
        let mut joints = Vec::new();
        let of = |list: &[f64; 6], n: usize| list.get(n).copied().unwrap_or(0.0);
        for n in 0..6 {
            let mut angle = |name, about: &str, value| {
                b.item(
                    &format!("armkins.{name}-{n}"),
                    &format!("{about} joint {n}, in degrees."),
                    value,
                )
            };
            let offset =
                angle("offset", "Angle of the model at position 0 of", of(&arm.offset, n))?;
            let min = angle("min", "Lowest position of", of(&arm.min, n))?;
            let max = angle("max", "Highest position of", of(&arm.max, n))?;
            let doc = format!("Direction of joint {n}: 1 or -1.");
            let sign = if of(&arm.sign, n) < 0.0 { -1 } else { 1 };
            let sign = b.item(&format!("armkins.sign-{n}"), &doc, sign)?;
            joints.push(Joint { offset, sign, min, max });
        }
        Ok(Self {
            lengths,
            joints,
            tool: FramePins::make(b, "tool", "the tool's tip relative to the flange")?,
            frame: FramePins::make(b, "frame", "the frame of poses relative to the arm's base")?,
            config: b.item("armkins.config", "Solution to use, 0 to 7; -1 for the nearest.", -1)?,
            solution: b.item("armkins.solution", "Number of the last solution, 0 to 7.", 0)?,
            margin: b.item(
                "armkins.margin",
                "Distance of the last solution to the nearest limit of a joint, in degrees.",
                0.0,
            )?,
            singular: b.item(
                "armkins.singular",
                "TRUE if the last solution is singular.",
                false,
            )?,
            unreachable: b.item("armkins.unreachable", "TRUE if the last pose has none.", false)?,
        })
    }

    /// Returns the solution that `config` selects, with its number.
    fn choose(
        &self,
        g: &Geometry,
        flange: &Frame,
        guess: &[f64; 6],
    ) -> Result<(usize, Way), Unsolved> {
        let config = self.config.get();
        if config != -1 {
            let number = usize::try_from(config).ok().filter(|n| *n < CONFIGURATIONS);
            let number = number.ok_or(Unsolved::NotFound)?;
            return g.arm.solve(flange, number, guess).map(|way| (number, way)).map_err(why);
        }
        let mut best: Option<(f64, usize, Way)> = None;
        let found = g.arm.each(flange, guess, |number, way| {
            let turns = way.joints.iter().zip(guess).map(|(a, b)| libm::fabs(a - b));
            let far = turns.fold(0.0, f64::max);
            if best.is_none_or(|(least, ..)| far < least) {
                best = Some((far, number, *way));
            }
        });
        match (found, best) {
            (Err(miss), _) => Err(why(miss)),
            (Ok(()), Some((_, number, way))) => Ok((number, way)),
            (Ok(()), None) => Err(Unsolved::Unreachable),
        }
    }
}

/// Arm, frame and tool.
struct Geometry {
    arm: Arm,
    frame: Frame,
    tool: Frame,
}

impl Geometry {
    /// Returns the flange for a pose of the tip.
    fn flange(&self, pose: &Pose) -> Frame {
        let [x, y, z, a, b, c, ..] = *pose;
        self.frame.then(&Frame::from_xyzabc([x, y, z, a, b, c])).then(&self.tool.inverse())
    }
}

/// Returns the first six joints.
fn six(joints: &Joints) -> [f64; 6] {
    let [a, b, c, d, e, f, ..] = *joints;
    [a, b, c, d, e, f]
}

fn why(miss: Miss) -> Unsolved {
    match miss {
        Miss::Reach { .. } => Unsolved::Unreachable,
        Miss::Limit { .. } => Unsolved::Limits,
    }
}

fn solved(is_singular: bool) -> Solved {
    if is_singular { Solved::Singular } else { Solved::Regular }
}

impl Model for Pins {
    type Geometry = Geometry;

    fn joints(&self) -> usize {
        6
    }

    fn geometry(&self) -> Option<Geometry> {
        let [a1, a2, a3, d1, d4, d6] = self.lengths.each_ref().map(ParamRw::get);
        let mut arm = Arm { a1, a2, a3, d1, d4, d6, ..Arm::RX90 };
        let lists = [&mut arm.offset, &mut arm.sign, &mut arm.min, &mut arm.max];
        for (list, get) in lists.into_iter().zip([
            |j: &Joint| j.offset.get(),
            |j: &Joint| f64::from(j.sign.get()),
            |j: &Joint| j.min.get(),
            |j: &Joint| j.max.get(),
        ]) {
            for (to, joint) in list.iter_mut().zip(&self.joints) {
                *to = get(joint);
            }
        }
        arm.is_valid().then_some(())?;
        Some(Geometry { arm, frame: self.frame.get()?, tool: self.tool.get()? })
    }

    fn forward(&self, g: &Geometry, joints: &Joints, guess: &Pose) -> Found<Pose> {
        let flange = g.arm.flange(&six(joints));
        let tip = g.frame.inverse().then(&flange).then(&g.tool);
        let mut pose = *guess;
        (pose[0], pose[1], pose[2]) = (tip.origin.x, tip.origin.y, tip.origin.z);
        [pose[3], pose[4], pose[5]] = to_abc(&tip.turn, guess[5]);
        Ok((pose, Solved::Regular))
    }

    fn inverse(&self, g: &Geometry, pose: &Pose, guess: &Joints) -> Found<Joints> {
        let found = self.choose(g, &g.flange(pose), &six(guess));
        self.unreachable.set(found.is_err());
        let (number, way) = found?;
        self.solution.set(i32::try_from(number).unwrap_or(0));
        self.margin.set(g.arm.margin(&way.joints).1);
        self.singular.set(way.is_singular);
        let mut joints = *guess;
        for (to, from) in joints.iter_mut().zip(way.joints) {
            *to = from;
        }
        Ok((joints, solved(way.is_singular)))
    }

    fn solutions(&self, g: &Geometry, pose: &Pose, ways: &mut Ways<'_>) -> Solution {
        let mut is_singular = false;
        let found = g.arm.each(&g.flange(pose), &[0.0; 6], |_, way| {
            is_singular |= way.is_singular;
            ways.push(&way.joints);
        });
        found.map_err(why).map(|()| solved(is_singular))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{
        arms::genserkins::Genserkins,
        testing::{Joint as Range, Rig, Space, close, serial},
    };
    use hal_bench::Random;

    const SPACE: Space<'static> = Space {
        size: 985.0,
        joints: &[Range::rotary(170.0); 6],
        letters: &[0, 1, 2, 3, 4, 5],
        abc: true,
        least: 3900,
        set: &[
            ("armkins.min-0", -180.0),
            ("armkins.max-0", 180.0),
            ("armkins.min-1", -180.0),
            ("armkins.max-1", 180.0),
            ("armkins.min-2", -180.0),
            ("armkins.max-2", 180.0),
            ("armkins.min-3", -180.0),
            ("armkins.max-3", 180.0),
            ("armkins.min-4", -180.0),
            ("armkins.max-4", 180.0),
            ("armkins.min-5", -180.0),
            ("armkins.max-5", 180.0),
        ],
        ..Space::DEFAULT
    };

    #[test]
    fn both_ways() {
        serial::<Armkins>(&[], &SPACE);
        serial::<Armkins>(&["model=rs03n"], &Space { size: 700.0, ..SPACE });
    }

    #[test]
    fn tool_and_frame_move_the_pose() {
        let rig = Rig::new::<Armkins>(&[]);
        let joints = [30., -60., 120., 20., 45., -30.];
        let bare = rig.pose(&joints);
        let (tool, frame) = ([5., -7., 275., 10., 20., 30.], [500., 100., -100., 0., 5., 60.]);
        for (n, letter) in ["x", "y", "z", "a", "b", "c"].into_iter().enumerate() {
            rig.bench.set(&format!("armkins.tool.{letter}"), tool[n]);
            rig.bench.set(&format!("armkins.frame.{letter}"), frame[n]);
        }
        let pose = rig.pose(&joints);
        let of = |p: &Pose| Frame::from_xyzabc([p[0], p[1], p[2], p[3], p[4], p[5]]);
        let tip = Frame::from_xyzabc(frame).then(&of(&pose));
        let expected = of(&bare).then(&Frame::from_xyzabc(tool));
        assert!((tip.origin - expected.origin).amax() < 1e-9);
        assert!((tip.turn - expected.turn).amax() < 1e-12);
        let mut back = [0.0; 16];
        back[..6].copy_from_slice(&[29., -61., 121., 21., 44., -31.]);
        rig.k.inverse(&pose, &mut back).unwrap();
        close(&back[..6], &joints, 1e-9);
    }

    #[test]
    fn config_selects_and_limits_refuse() {
        let rig = Rig::new::<Armkins>(&[]);
        let pose = rig.pose(&[30., -60., 120., 20., 45., -30.]);
        assert_eq!(rig.ways(&pose).len(), 8);
        for config in 0..8 {
            rig.bench.set("armkins.config", config);
            let joints = rig.joints(pose);
            assert_eq!(rig.bench.get::<i32>("armkins.solution"), config);
            assert!(!rig.bench.get::<bool>("armkins.unreachable"));
            let expected = if config < 4 { 30.0 } else { -150.0 };
            close(&joints[..1], &[expected], 1e-9);
        }
        let margin: f64 = rig.bench.get("armkins.margin");
        close(&[margin], &[10.0], 1e-9);
        rig.bench.set("armkins.config", 8);
        assert_eq!(rig.no_joints(pose), Unsolved::NotFound);
        rig.bench.set("armkins.config", 0);
        rig.bench.set("armkins.max-0", 29.0);
        assert_eq!(rig.no_joints(pose), Unsolved::Limits);
        assert!(rig.bench.get::<bool>("armkins.unreachable"));
        rig.bench.set("armkins.config", -1);
        close(&rig.joints(pose)[..1], &[-150.0], 1e-9);
        assert_eq!(rig.no_joints([2000., 0., 0., 0., 0., 0., 0., 0., 0.]), Unsolved::Unreachable);
        for (pin, value) in [("A2", 0.0), ("D6", f64::NAN), ("min-3", 271.0)] {
            let rig = Rig::new::<Armkins>(&[]);
            rig.bench.set(&format!("armkins.{pin}"), value);
            assert_eq!(rig.no_joints(pose), Unsolved::Geometry);
        }
        let mut bench = hal_bench::Bench::new();
        let refused = bench.load::<Armkins>(&["model=rx91"]);
        assert_eq!(refused.unwrap_err(), "model is 'rx91', must be rx90 or rs03n");
    }

    #[test]
    fn genserkins_finds_the_same_solutions() {
        let (arm, general) = (Rig::new::<Armkins>(&[]), Rig::new::<Genserkins>(&[]));
        arm.set(SPACE.set);
        let quarter = core::f64::consts::FRAC_PI_2;
        for (pin, values) in [
            ("A", [0.0, 0.0, 450.0, 0.0, 0.0, 0.0]),
            ("ALPHA", [0.0, -quarter, 0.0, quarter, -quarter, quarter]),
            ("D", [0.0, 0.0, 0.0, 450.0, 0.0, 85.0]),
        ] {
            for (n, value) in values.into_iter().enumerate() {
                general.bench.set(&format!("genserkins.{pin}-{n}"), value);
            }
        }
        let mut random = Random::new(3);
        for _ in 0..10 {
            let joints: Vec<f64> = (0..6).map(|_| random.between(-150.0, 150.0)).collect();
            let pose = arm.pose(&joints);
            assert!(SPACE.apart(&general.pose(&joints), &pose).iter().all(|a| a.abs() < 1e-9));
            let (own, other) = (arm.ways(&pose), general.ways(&pose));
            assert_eq!(own.len(), other.len(), "{joints:?}");
            for way in &own {
                let same = |other: &&Vec<f64>| {
                    let mut pairs = way.iter().zip(*other);
                    pairs.all(|(a, b)| libm::remainder(a - b, 360.0).abs() < 1e-3)
                };
                assert_eq!(other.iter().filter(same).count(), 1, "{way:?}");
            }
        }
    }
}
