//! `pentakins`.

use crate::{
    model::{Found, Joints, Model, Service, is_finite},
    names::{example, names},
    parallel::struts::{Bounds, Look, find, is_singular},
    rotation::{Matrix, Vector, about_x, about_y},
};
use hal_component::{
    Builder, Decl, Error, In, Io, Out, ParamRw, Pose, Solved, Touch, Unsolved, pins,
};
use libm::{hypot, sqrt};
use nalgebra::{SMatrix, SVector};

const DOC: &str = concat!(
    "\
Kinematics of a pentapod: a slender effector held by five struts, each on a ring that turns about it.

Strut N runs from base.N to the nearest point of a ring about the effector's axis, of radius
effector.N.r, effector.N.z above its tip; joint N is its length. The pose is the tip X Y Z, and A and B
in degrees: tilted about X first, then about the fixed Y. Turning about its own axis is not determined
and left alone.

From lengths to a pose it searches by Newton's method from where the effector was (Merlet, Parallel
Robots, section 4.4), at most limit-iterations steps; a search that does not end leaves the pose as it
was. Where the effector could move though no strut does, the place is singular.",
    example!(
        "pentakins",
        5,
        "setp pentakins.tool-offset 0\n",
        "motion.jog joint=0 velocity=90 position=734\nmotion.jog joint=1 velocity=90 position=713\n\
         motion.jog joint=2 velocity=90 position=645\nmotion.jog joint=3 velocity=90 position=626\n\
         motion.jog joint=4 velocity=90 position=581\nrun 10s\nshow pin joint.*.pos-cmd\n"
    )
);

names! {
    DOC, &[], create;
    /// `loadrt pentakins`.
    Pentakins = "pentakins";
}

fn create(b: &mut Builder<'_>) -> Result<(), Error> {
    let pins = Pins::make(b)?;
    b.offer_kinematics(Service(pins))
}

pins! {
    /// Pins for the whole machine.
    struct General {
        /// Tool length along the effector's axis, from its tip to the tool tip, in units; the pose is that of the tool
        /// tip. Change it only while the effector is upright.
        tool: In<f64> = "tool-offset", 0.0;
        /// Error, summed over the lengths of all struts, at which a search succeeds, in units; above 0.
        criterion: Io<f64> = "convergence-criterion", 1e-9;
        /// Maximum number of steps of a search from lengths to a pose; values above 1000 count as 1000.
        limit_iterations: Io<u32> = "limit-iterations", 120;
        /// Error, summed over the lengths of all struts, above which a search fails, in units; above 0.
        max_error: Io<f64> = "max-error", 100.0;
        /// Number of steps of the last successful search.
        last_iterations: Out<u32> = "last-iterations", 0;
        /// Largest number of steps of any search.
        max_iterations: Out<u32> = "max-iterations", 0;
    }
}

/// Parameters of one strut.
#[derive(Debug, Touch)]
struct StrutPins {
    base: [ParamRw<f64>; 3],
    ring: [ParamRw<f64>; 2],
}

#[derive(Debug, Touch)]
struct Pins {
    general: General,
    struts: Vec<StrutPins>,
}

/// Defaults: end of each strut on the base, and radius and height of its ring.
const FIRST: [([f64; 3], [f64; 2]); 5] = [
    ([-418.03, 324.56, 895.56], [80.32, -185.5]),
    ([417.96, 324.56, 895.56], [80.32, -159.5]),
    ([-418.03, -325.44, 895.56], [80.32, -67.5]),
    ([417.96, -325.44, 895.56], [80.32, -41.5]),
    ([-0.06, -492.96, 895.56], [80.32, -14.0]),
];

impl Pins {
    fn make(b: &mut Builder<'_>) -> Result<Self, Error> {
        let general = General::make(b, "pentakins")?;
        let mut struts = Vec::new();
        for (n, ([x, y, z], [radius, height])) in FIRST.iter().enumerate() {
            let mut one = |name: &str, doc: &str, first: f64| {
                let name = format!("pentakins.{name}");
                b.declare(Decl::new(&name, doc), first)
            };
            let mut base = |letter: char, first: f64| {
                let doc = format!(
                    "{} of the end of strut {n} on the base, in units.",
                    letter.to_ascii_uppercase()
                );
                one(&format!("base.{n}.{letter}"), &doc, first)
            };
            let base = [base('x', *x)?, base('y', *y)?, base('z', *z)?];
            let r = format!("Radius of the ring of strut {n} about the effector, in units.");
            let h = format!("Height of the ring of strut {n} above the effector's tip, in units.");
            let ring = [
                one(&format!("effector.{n}.r"), &r, *radius)?,
                one(&format!("effector.{n}.z"), &h, *height)?,
            ];
            struts.push(StrutPins { base, ring });
        }
        Ok(Self { general, struts })
    }
}

/// End of one strut on the base, and its ring.
#[derive(Clone, Copy, Default)]
struct Strut {
    base: Vector,
    radius: f64,
    height: f64,
}

struct Pentapod {
    struts: [Strut; 5],
    bounds: Bounds,
}

/// Position of the tip, and A and B in radians.
type PlatformPose = (Vector, f64, f64);

/// Returns the length of a strut, and its gradient with respect to the base's end in the effector's frame.
fn reach(s: &Strut, seen: &Vector) -> Option<(f64, Vector)> {
    let out = hypot(seen.x, seen.y);
    let (across, up) = (out - s.radius, seen.z - s.height);
    let length = hypot(across, up);
    if !(length > 0.0 && out > 0.0) {
        return None;
    }
    let share = across / (length * out);
    Some((length, Vector::new(share * seen.x, share * seen.y, up / length)))
}

fn turned(a: f64, b: f64) -> Matrix {
    about_y(b) * about_x(a)
}

impl Pentapod {
    fn look(&self, joints: &Joints, (tip, a, b): &PlatformPose) -> Option<Look<5>> {
        let turned = turned(*a, *b);
        let back = turned.transpose();
        let (about_a, about_b) = (Vector::x(), about_x(-*a) * Vector::y());
        let mut off = SVector::<f64, 5>::zeros();
        let mut jacobian = SMatrix::<f64, 5, 5>::zeros();
        let rows = jacobian.row_iter_mut().zip(off.iter_mut());
        for ((s, joint), (mut row, off)) in self.struts.iter().zip(joints).zip(rows) {
            let seen = back * (s.base - tip);
            let (length, slope) = reach(s, &seen)?;
            *off = joint - length;
            let moved = -(turned * slope);
            let tilt = |axis: &Vector| -slope.dot(&axis.cross(&seen));
            row.copy_from_slice(&[moved.x, moved.y, moved.z, tilt(&about_a), tilt(&about_b)]);
        }
        Some((off, jacobian))
    }

    /// Returns a start for the search: between the ends on the base, as low as the struts are long.
    fn middle(&self, joints: &Joints) -> PlatformPose {
        let mut middle = Vector::zeros();
        for s in &self.struts {
            middle += s.base / 5.0;
        }
        let mut height = 0.0;
        for (s, joint) in self.struts.iter().zip(joints) {
            let across = hypot(s.base.x - middle.x, s.base.y - middle.y) - s.radius;
            let down = joint * joint - across * across;
            height += (s.base.z - s.height - if down > 0.0 { sqrt(down) } else { 0.0 }) / 5.0;
        }
        (Vector::new(middle.x, middle.y, height), 0.0, 0.0)
    }

    fn search(&self, joints: &Joints, from: PlatformPose) -> Result<(PlatformPose, u32), Unsolved> {
        find(
            from,
            self.bounds,
            |place| self.look(joints, place),
            |(tip, a, b), step| {
                let [[x, y, z, da, db]] = step.data.0;
                (tip + Vector::new(x, y, z), a + da, b + db)
            },
        )
    }
}

impl Model for Pins {
    type Geometry = Pentapod;

    fn joints(&self) -> usize {
        5
    }

    fn geometry(&self) -> Option<Pentapod> {
        let g = &self.general;
        let tool = g.tool.get();
        let mut struts = [Strut::default(); 5];
        for (strut, pins) in struts.iter_mut().zip(&self.struts) {
            let [x, y, z] = [0, 1, 2].map(|i| pins.base.get(i).map_or(0.0, ParamRw::get));
            let [radius, height] = [&pins.ring[0], &pins.ring[1]].map(ParamRw::get);
            if !is_finite(&[x, y, z, radius, height, tool]) {
                return None;
            }
            let base = Vector::new(x, y, z + tool);
            *strut = Strut { base, radius, height: height + tool };
        }
        let bounds = Bounds::new(g.criterion.get(), g.max_error.get(), g.limit_iterations.get())?;
        Some(Pentapod { struts, bounds })
    }

    fn forward(&self, g: &Pentapod, joints: &Joints, guess: &Pose) -> Found<Pose> {
        if joints.iter().take(5).any(|j| *j <= 0.0) {
            return Err(Unsolved::Unreachable);
        }
        let near = (
            Vector::new(guess[0], guess[1], guess[2]),
            guess[3].to_radians(),
            guess[4].to_radians(),
        );
        let (place, took) =
            g.search(joints, near).or_else(|_| g.search(joints, g.middle(joints)))?;
        let pins = &self.general;
        pins.last_iterations.set(took);
        if took > pins.max_iterations.get() {
            pins.max_iterations.set(took);
        }
        let mut pose = *guess;
        (pose[0], pose[1], pose[2]) = (place.0.x, place.0.y, place.0.z);
        (pose[3], pose[4]) = (place.1.to_degrees(), place.2.to_degrees());
        let singular = g.look(joints, &place).is_none_or(|(_, mut jacobian)| {
            let sizes = g.struts.iter().map(|s| libm::fabs(s.height) + libm::fabs(s.radius));
            let size = sizes.fold(0.0, f64::max);
            jacobian.columns_mut(3, 2).scale_mut(1.0 / size);
            is_singular(&jacobian)
        });
        Ok((pose, if singular { Solved::Singular } else { Solved::Regular }))
    }

    fn inverse(&self, g: &Pentapod, pose: &Pose, guess: &Joints) -> Found<Joints> {
        let tip = Vector::new(pose[0], pose[1], pose[2]);
        let back = turned(pose[3].to_radians(), pose[4].to_radians()).transpose();
        let mut joints = *guess;
        for (joint, s) in joints.iter_mut().zip(&g.struts) {
            let (length, _) = reach(s, &(back * (s.base - tip))).ok_or(Unsolved::Undetermined)?;
            *joint = length;
        }
        Ok((joints, Solved::Regular))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::{Joint, Rig, Space, close, parallel};

    const SPACE: Space<'static> = Space {
        size: 600.0,
        joints: &[Joint::linear_from(400.0, 1200.0); 5],
        letters: &[0, 1, 2, 3, 4],
        poses: &[(-100., 100.), (-100., 100.), (200., 450.), (-15., 15.), (-15., 15.)],
        least: 3900,
        aside: 0.01,
        ..Space::DEFAULT
    };

    #[test]
    fn both_ways() {
        parallel::<Pentakins>(&[], &SPACE);
        let set = &[("pentakins.tool-offset", 40.0)];
        parallel::<Pentakins>(&[], &Space { set, ..SPACE });
    }

    #[test]
    fn the_effector_upright() {
        let rig = Rig::new::<Pentakins>(&[]);
        let pose = [0., 0., 500., 0., 0., 0., 0., 0., 0.];
        let joints = rig.joints(pose);
        let across = 418.03_f64.hypot(324.56) - 80.32;
        close(&joints[..1], &[across.hypot(895.56 - 314.5)], 1e-9);
        let mut again = [3., -2., 490., 1., 1., 7., 0., 0., 0.];
        rig.k.forward(&joints, &mut again).unwrap();
        close(&again, &[0., 0., 500., 0., 0., 7., 0., 0., 0.], 1e-7);
        assert_eq!(rig.no_pose(&[500., 500., 500., 500., 50.]), Unsolved::NotFound);
        assert_eq!(rig.no_pose(&[0.0; 5]), Unsolved::Unreachable);
        rig.bench.set("pentakins.limit-iterations", 0_u32);
        assert_eq!(rig.no_pose(&joints[..5]), Unsolved::NotFound);
        rig.bench.set("pentakins.convergence-criterion", f64::NAN);
        assert_eq!(rig.no_pose(&joints[..5]), Unsolved::Geometry);
    }
}
