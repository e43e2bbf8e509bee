//! `genserkins`.

use crate::{
    arms::dh::{Chain, Link},
    arms::search::{every_way, search},
    letters::{ANY, Letters, Rule},
    model::{Found, Joints, Model, is_finite, pass},
    names::{example, names},
    rotation::{Matrix, Vector, from_abc, near, to_abc},
    switch::{COORDINATES, SPARM, Switched},
};
use hal_component::{
    Arg, Builder, Decl, Error, In, Out, Pose, Solution, Solved, Touch, Unsolved, Ways, abi::ArgSpec,
};

const DOC: &str = concat!(
    "\
Kinematics of any arm of six turning joints, by its Denavit-Hartenberg parameters.

A-N, ALPHA-N and D-N are the parameters of joint N in the form of Craig (Introduction to Robotics,
section 3.4): first A and ALPHA from the axis before, then D and the joint's angle along and about
its own. The pose is the last frame's place X Y Z and how it is turned: roll A, pitch B, yaw C about
the fixed axes; joints 6 to 8 are U V W.

From a pose to joints it searches from where the joints are, by Newton's method (Wampler, Manipulator
inverse kinematic solutions, 1986), at most max-iterations steps of half a radian: the way found is
the one that goes on from there. What is farther than all links together is out of reach; elsewhere a
search may end without an answer. All ways to a pose, up to sixteen, are searched for from many
places; that is not for a thread. With `min_limits=` and `max_limits=` ways beyond a joint's limits do
not count.

In types 1 and 2 every joint is an axis; `motion.switchkins-type` says which type is in force.",
    example!(
        "genserkins",
        9,
        "setp genserkins.D-5 100\n",
        "motion.jog joint=1 velocity=20 position=-60\nmotion.jog joint=4 velocity=20 position=40\n\
         run 10s\nmotion.move x=300 y=100 velocity=20 --wait\nshow pin joint.*.pos-cmd\n"
    )
);

const ARGS: &[&ArgSpec] = &[
    &COORDINATES.or("XYZABCUVW"),
    &SPARM,
    &Arg::texts(
        "min_limits",
        "The lowest angle of each of the six joints, in degrees, such as -90,-90,-90,-90,-90,-90.",
    ),
    &Arg::texts(
        "max_limits",
        "The highest angle of each of the six joints, in degrees, such as 90,90,90,90,90,90.",
    ),
];

names! {
    DOC, ARGS, create;
    /// `loadrt genserkins`.
    Genserkins = "genserkins";
}

fn create(b: &mut Builder<'_>) -> Result<(), Error> {
    let rule = Rule { twice: false, most: 9, ..ANY };
    let letters = Letters::parse(&b.arg_text("coordinates").unwrap_or_default(), rule)?;
    let arm = Arm::make(b)?;
    let kinematics = Switched::usual(b, arm, letters)?;
    b.offer_kinematics(kinematics)
}

/// Denavit-Hartenberg parameters of one joint.
#[derive(Debug, Touch)]
struct JointPins {
    a: In<f64>,
    alpha: In<f64>,
    d: In<f64>,
    unrotate: In<i32>,
}

#[derive(Debug, Touch)]
struct Arm {
    joints: Vec<JointPins>,
    max_iterations: In<u32>,
    last_iterations: Out<u32>,
    #[state]
    limits: [(f64, f64); 6],
}

/// Default A and D in units and ALPHA in radians of each joint: those of the Puma 560.
const PUMA: [[f64; 3]; 6] = [
    [0.0, 0.0, 0.0],
    [0.0, -core::f64::consts::FRAC_PI_2, 0.0],
    [300.0, 0.0, 70.0],
    [50.0, -core::f64::consts::FRAC_PI_2, 400.0],
    [0.0, core::f64::consts::FRAC_PI_2, 0.0],
    [0.0, -core::f64::consts::FRAC_PI_2, 0.0],
];

impl Arm {
    fn make(b: &mut Builder<'_>) -> Result<Self, Error> {
        let mut joints = Vec::new();
        for (n, [a, alpha_0, d]) in PUMA.iter().enumerate() {
            let mut float = |name: &str, doc: &str, first: f64| {
                b.declare(Decl::new(&format!("genserkins.{name}-{n}"), doc), first)
            };
            let a =
                float("A", "From the axis of the joint before across to this one, in units.", *a)?;
            let alpha = "From the axis of the joint before to this one, in radians.";
            let alpha = float("ALPHA", alpha, *alpha_0)?;
            let d = float("D", "Along the axis of this joint, in units.", *d)?;
            let unrotate = b.declare(
                Decl::new(
                    &format!("genserkins.unrotate-{n}"),
                    "How many times the angle of the joint before is taken off this one's, where \
                     its motor turns along; joint 0 has none before it.",
                ),
                0,
            )?;
            joints.push(JointPins { a, alpha, d, unrotate });
        }
        let max = "The most steps of a search from a pose to joints, 1 to 1000.";
        let last = "How many steps the last search took that found its answer.";
        Ok(Self {
            joints,
            max_iterations: b.declare(Decl::new("genserkins.max-iterations", max), 100)?,
            last_iterations: b.declare(Decl::new("genserkins.last-iterations", last), 0)?,
            limits: limits(b)?,
        })
    }
}

fn limits(b: &Builder<'_>) -> Result<[(f64, f64); 6], Error> {
    let mut out = [(f64::NEG_INFINITY, f64::INFINITY); 6];
    let read = |name: &str| {
        let list = b.arg_texts(name);
        if !list.is_empty() && list.len() != 6 {
            let n = list.len();
            return Err(Error::new(format!("{name} has {n} angles, one for each of 6 joints")));
        }
        let numbers = list.iter().map(|text| {
            let number = text.trim().parse::<f64>().ok().filter(|x| !x.is_nan());
            number.ok_or_else(|| Error::new(format!("{name}: '{text}' is no angle in degrees")))
        });
        numbers.collect::<Result<Vec<f64>, Error>>()
    };
    let (min, max) = (read("min_limits")?, read("max_limits")?);
    for (place, value) in out.iter_mut().zip(min) {
        place.0 = value;
    }
    for (place, value) in out.iter_mut().zip(max) {
        place.1 = value;
    }
    if let Some((n, (low, high))) = out.iter().enumerate().find(|(_, (low, high))| low > high) {
        return Err(Error::new(format!("joint {n}: its limits are {low} and {high}")));
    }
    Ok(out)
}

/// Link chain, and the fraction of the previous joint's angle that each joint's angle contains.
struct Geometry {
    chain: Chain,
    unrotate: [f64; 6],
}

impl Geometry {
    /// Returns the angles about the axes, in radians.
    fn about_axes(&self, joints: &Joints) -> [f64; 6] {
        let mut out = [0.0; 6];
        let mut before = 0.0;
        for ((to, joint), times) in out.iter_mut().zip(joints).zip(self.unrotate) {
            before = joint - times * before;
            *to = before.to_radians();
        }
        out
    }

    /// Returns the joints near the guess, in degrees.
    fn joints(&self, angles: &[f64; 6], guess: &Joints) -> Joints {
        let mut out = *guess;
        let (mut before, mut before_guess) = (0.0, 0.0);
        let angles = angles.iter().zip(self.unrotate);
        for ((to, last), (angle, times)) in out.iter_mut().zip(guess).zip(angles) {
            let was = last - times * before_guess;
            let is = near(angle.to_degrees(), was);
            *to = is + times * before;
            (before, before_guess) = (is, was);
        }
        out
    }
}

impl Arm {
    /// Adds full turns that bring each joint within its limits, nearest to the guess.
    fn turned_within(&self, mut joints: Joints, guess: &Joints) -> Option<Joints> {
        for (((low, high), j), last) in self.limits.iter().zip(&mut joints).zip(guess) {
            let over = libm::floor((*high - *j) / 360.0) * 360.0;
            let under = libm::ceil((*low - *j) / 360.0) * 360.0;
            let middle = *j;
            let fits = |x: f64| x.is_finite() && *low <= x && x <= *high;
            let nearest = [middle, middle + over, middle + under]
                .into_iter()
                .filter(|x| fits(*x))
                .min_by(|a, b| libm::fabs(a - last).total_cmp(&libm::fabs(b - last)));
            *j = nearest?;
        }
        Some(joints)
    }
}

fn target(pose: &Pose) -> (Vector, Matrix) {
    (Vector::new(pose[0], pose[1], pose[2]), from_abc([pose[3], pose[4], pose[5]]))
}

impl Model for Arm {
    type Geometry = Geometry;

    fn joints(&self) -> usize {
        9
    }

    fn geometry(&self) -> Option<Geometry> {
        let mut links = [Link { a: 0.0, alpha: 0.0, d: 0.0 }; 6];
        let mut unrotate = [0.0; 6];
        for ((n, pins), (link, times)) in
            self.joints.iter().enumerate().zip(links.iter_mut().zip(&mut unrotate))
        {
            *link = Link { a: pins.a.get(), alpha: pins.alpha.get(), d: pins.d.get() };
            if !is_finite(&[link.a, link.alpha, link.d]) {
                return None;
            }
            if n > 0 {
                *times = f64::from(pins.unrotate.get());
            }
        }
        let chain = Chain(links);
        (chain.reach() > 0.0).then_some(Geometry { chain, unrotate })
    }

    fn forward(&self, g: &Geometry, joints: &Joints, guess: &Pose) -> Found<Pose> {
        let (place, turned) = g.chain.end(&g.about_axes(joints));
        let mut pose = *guess;
        (pose[0], pose[1], pose[2]) = (place.x, place.y, place.z);
        [pose[3], pose[4], pose[5]] = to_abc(&turned, guess[5]);
        pass(joints, 6, &mut pose, 6, 3);
        Ok((pose, Solved::Regular))
    }

    fn inverse(&self, g: &Geometry, pose: &Pose, guess: &Joints) -> Found<Joints> {
        let (place, turned) = target(pose);
        let steps = self.max_iterations.get().min(1000);
        let from = g.about_axes(guess);
        let (angles, took) = search(&g.chain, &place, &turned, &from, steps)?;
        self.last_iterations.set(took);
        let mut joints =
            self.turned_within(g.joints(&angles, guess), guess).ok_or(Unsolved::Limits)?;
        pass(pose, 6, &mut joints, 6, 3);
        let solved =
            if is_singular(&g.chain, &angles) { Solved::Singular } else { Solved::Regular };
        Ok((joints, solved))
    }

    fn solutions(&self, g: &Geometry, pose: &Pose, ways: &mut Ways<'_>) -> Solution {
        let (place, turned) = target(pose);
        if place.norm() > g.chain.reach() * (1.0 + 1e-10) {
            return Err(Unsolved::Unreachable);
        }
        let mut solved = Solved::Regular;
        let found = every_way(&g.chain, &place, &turned, |angles| {
            let none = [0.0; 16];
            let Some(mut joints) = self.turned_within(g.joints(angles, &none), &none) else {
                return;
            };
            if is_singular(&g.chain, angles) {
                solved = Solved::Singular;
            }
            pass(pose, 6, &mut joints, 6, 3);
            ways.push(&joints);
        });
        match (found, ways.count()) {
            (0, _) => Err(Unsolved::NotFound),
            (_, 0) => Err(Unsolved::Limits),
            _ => Ok(solved),
        }
    }
}

/// Returns whether the joint rates would be unbounded, judged by the pivots of the Jacobian.
fn is_singular(chain: &Chain, angles: &[f64; 6]) -> bool {
    let size = chain.reach();
    let mut j = chain.jacobian(angles);
    for mut row in j.row_iter_mut().take(3) {
        row /= size;
    }
    let pivots = j.full_piv_lu().u().diagonal();
    pivots.iter().any(|p| crate::rotation::is_straight(*p))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{
        arms::pumakins::Pumakins,
        testing::{Joint, Rig, Space, close, serial},
    };
    use hal_bench::Random;

    const LINE: Joint = Joint::linear(100.0);
    const TURN: Joint = Joint::rotary(180.0);
    const SPACE: Space<'static> = Space {
        size: 800.0,
        joints: &[TURN, TURN, TURN, TURN, TURN, TURN, LINE, LINE, LINE],
        abc: true,
        least: 3900,
        aside: 0.02,
        ..Space::DEFAULT
    };

    #[test]
    fn both_ways() {
        serial::<Genserkins>(&[], &SPACE);
        // Arm whose last axes do not intersect.
        let set = &[
            ("genserkins.D-0", 100.0),
            ("genserkins.A-1", 60.0),
            ("genserkins.A-4", 40.0),
            ("genserkins.D-4", 70.0),
            ("genserkins.ALPHA-2", 0.3),
            ("genserkins.D-5", 90.0),
        ];
        serial::<Genserkins>(&[], &Space { set, size: 1000.0, ..SPACE });
    }

    #[test]
    fn all_ways_are_those_of_the_closed_form() {
        let (puma, general) = (Rig::new::<Pumakins>(&[]), Rig::new::<Genserkins>(&[]));
        general.bench.set("genserkins.D-5", 70.0);
        let mut random = Random::new(5);
        for _ in 0..10 {
            let joints: Vec<f64> = (0..6).map(|_| random.between(-150.0, 150.0)).collect();
            let pose = puma.pose(&joints);
            #[expect(clippy::cast_possible_truncation, reason = "whole degrees")]
            let whole = |angle: &f64| libm::remainder(*angle, 360.0).round() as i64;
            let key = |way: &Vec<f64>| way.iter().take(6).map(whole).collect();
            let sorted = |rig: &Rig| {
                let mut list: Vec<Vec<i64>> = rig.ways(&pose).iter().map(key).collect();
                list.sort();
                list
            };
            assert_eq!(sorted(&puma), sorted(&general), "{joints:?}");
        }
    }

    #[test]
    fn limits_hold() {
        let args = ["min_limits=-90,-170,-100,-90,-90,0", "max_limits=90,0,100,90,90,400"];
        let rig = Rig::new::<Genserkins>(&args);
        let wanted = [10., -60., 40., 50., 60., 300., 1., 2., 3.];
        let pose = rig.pose(&wanted);
        let mut joints = [12., -58., 42., 48., 58., -58., 0., 0., 0.];
        rig.k.inverse(&pose, &mut joints).unwrap();
        close(&joints, &wanted, 1e-6);
        let ways = rig.ways(&pose);
        assert_eq!(ways.len(), 1, "{ways:?}");
        close(&ways[0], &wanted, 1e-6);
        let pose = rig.pose(&[10., 20., 40., 50., 60., 30., 0., 0., 0.]);
        let mut joints = [10., 19., 40., 50., 60., 30., 0., 0., 0.];
        assert_eq!(rig.k.inverse(&pose, &mut joints), Err(Unsolved::Limits));
        for (args, text) in [
            (["min_limits=1,2"], "min_limits has 2 angles, one for each of 6 joints"),
            (["max_limits=1,2,x,4,5,6"], "max_limits: 'x' is no angle in degrees"),
            (["max_limits=1,2,nan,4,5,6"], "max_limits: 'nan' is no angle in degrees"),
        ] {
            let refused = hal_bench::Bench::new().load::<Genserkins>(&args);
            assert_eq!(refused.unwrap_err(), text);
        }
    }

    #[test]
    fn a_search_is_bounded() {
        let rig = Rig::new::<Genserkins>(&[]);
        let far = [1e4, 0., 0., 0., 0., 0., 0., 0., 0.];
        assert_eq!(rig.no_joints(far), Unsolved::Unreachable);
        let pose = rig.pose(&[10., -60., 40., 50., 60., 70., 0., 0., 0.]);
        rig.bench.set("genserkins.max-iterations", 1_u32);
        assert_eq!(rig.no_joints(pose), Unsolved::NotFound);
        rig.bench.set("genserkins.max-iterations", u32::MAX);
        let inside = [20., 10., 0., 0., 0., 0., 0., 0., 0.];
        assert_eq!(rig.no_joints(inside), Unsolved::NotFound);
        let mut joints = [12., -58., 42., 48., 58., 68., 0., 0., 0.];
        rig.k.inverse(&pose, &mut joints).unwrap();
        let took: u32 = rig.bench.get("genserkins.last-iterations");
        assert!((1..10).contains(&took), "{took}");
    }

    #[test]
    fn motors_that_turn_along() {
        let rig = Rig::new::<Genserkins>(&[]);
        let still = rig.pose(&[10., -60., 40., 50., 60., 70., 0., 0., 0.]);
        rig.bench.set("genserkins.unrotate-2", 1_i32);
        rig.bench.set("genserkins.unrotate-5", -2_i32);
        let along = [10., -60., 40. - 60., 50., 60., 70. - 120., 0., 0., 0.];
        close(&rig.pose(&along), &still, 1e-9);
        let mut joints = along.map(|j| j + 0.5);
        rig.k.inverse(&still, &mut joints).unwrap();
        close(&joints[..6], &along[..6], 1e-6);
    }
}
