//! `genhexkins`.

use crate::{
    model::{Found, Joints, Model, is_finite},
    names::{example, names},
    parallel::genhexpins::Pins,
    parallel::struts::{Bounds, Look, find, is_singular},
    rotation::{Matrix, Vector, about, from_abc, to_abc},
    switch::{COORDINATES, SPARM, Switched},
};
use hal_component::{Builder, Error, In, Pose, Solved, Unsolved, abi::ArgSpec};
use libm::{atan2, fabs, sqrt};
use nalgebra::{Matrix6, Vector6};

const DOC: &str = concat!(
    "\
Kinematics of a hexapod: a platform on six struts of changing length (Stewart and Gough's).

Strut N runs from base.N to platform.N; joint N is its length. The pose is the platform's place X Y Z
and how it is turned: roll A, pitch B, yaw C about the fixed axes; with a tool-offset it is the tool's
tip.

From lengths to a pose it searches by Newton's method from where the platform was (Merlet, Parallel
Robots, sections 3.2 and 4.4), at most limit-iterations steps, and from above the middle of the base
when that leads nowhere. A search that does not end leaves the pose as it was and sets fwd-kins-fail.
Where the platform could move though no strut does, the place is singular.

A strut of which one end is a screw that turns with it gets longer as its joints turn it:
`screw-lead` corrects that from the axes of the joints at both ends, up to half a turn either way.

In types 1 and 2 every joint is an axis; `motion.switchkins-type` says which type is in force.",
    example!(
        "genhexkins",
        6,
        "setp genhexkins.limit-iterations 50\n",
        "motion.jog joint=0 velocity=50 position=40\nmotion.jog joint=1 velocity=50 position=40\n\
         motion.jog joint=2 velocity=50 position=40\nmotion.jog joint=3 velocity=50 position=40\n\
         motion.jog joint=4 velocity=50 position=40\nmotion.jog joint=5 velocity=50 position=40\n\
         run 2s\nmotion.move x=2 y=1 a=3 velocity=5 --wait\nshow pin joint.*.pos-cmd\n"
    )
);

const ARGS: &[&ArgSpec] = &[&COORDINATES.or("XYZABC"), &SPARM];

names! {
    DOC, ARGS, create;
    /// `loadrt genhexkins`.
    Genhexkins = "genhexkins";
}

fn create(b: &mut Builder<'_>) -> Result<(), Error> {
    Switched::offer_six(b, Pins::make)
}

/// Ends of one strut, and the axes of the joints there.
#[derive(Clone, Copy, Default)]
struct Strut {
    base: Vector,
    platform: Vector,
    base_axis: Vector,
    platform_axis: Vector,
}

/// Geometry of the machine, read from the pins.
pub(crate) struct Hexapod {
    struts: [Strut; 6],
    /// Extension of a strut per turn of its screw, in units.
    lead: f64,
    bounds: Bounds,
}

/// Position and orientation of the platform.
type PlatformPose = (Vector, Matrix);

impl Hexapod {
    fn read(pins: &Pins) -> Option<Self> {
        let up = Vector::new(0.0, 0.0, pins.general.spindle_offset.get() + pins.general.tool.get());
        let mut struts = [Strut::default(); 6];
        for (strut, pins) in struts.iter_mut().zip(&pins.struts) {
            let read = |at: &[In<f64>; 3]| Vector::new(at[0].get(), at[1].get(), at[2].get());
            *strut = Strut {
                base: read(&pins.base) + up,
                platform: read(&pins.platform) + up,
                base_axis: read(&pins.base_axis),
                platform_axis: read(&pins.platform_axis),
            };
            let s = &strut;
            for v in [&s.base, &s.platform, &s.base_axis, &s.platform_axis] {
                if !is_finite(v.as_slice()) {
                    return None;
                }
            }
        }
        let g = &pins.general;
        let lead = g.screw_lead.get();
        let bounds = Bounds::new(g.criterion.get(), g.max_error.get(), g.limit_iterations.get())?;
        is_finite(&[lead]).then_some(Self { struts, lead, bounds })
    }

    /// Returns the length of a strut, its direction, the vector from the platform's origin to its end, and the
    /// extension by its screw. Returns `None` if its length is 0.
    fn strut(&self, s: &Strut, (at, turned): &PlatformPose) -> Option<(f64, Vector, Vector, f64)> {
        let arm = turned * s.platform;
        let way = at + arm - s.base;
        let length = way.norm();
        let has_length = length > 0.0;
        if !has_length {
            return None;
        }
        let along = way / length;
        Some((length, along, arm, self.screwed(s, &along, turned)))
    }

    /// Returns the extension of a strut by the relative rotation of its two parts: the angle between the axes of the
    /// end joints, seen along the strut, times the lead.
    fn screwed(&self, s: &Strut, along: &Vector, turned: &Matrix) -> f64 {
        if self.lead == 0.0 {
            return 0.0;
        }
        let lower = s.base_axis.cross(along);
        let upper = along.cross(&(turned * s.platform_axis));
        let angle = atan2(lower.cross(&upper).dot(along), lower.dot(&upper));
        self.lead * angle / TURN
    }

    /// Returns the errors of the strut lengths, and the Jacobian for the pose of the platform.
    fn look(&self, joints: &Joints, place: &PlatformPose) -> Option<Look<6>> {
        let mut off = Vector6::zeros();
        let mut jacobian = Matrix6::zeros();
        let rows = jacobian.row_iter_mut().zip(off.iter_mut());
        for ((s, joint), (mut row, off)) in self.struts.iter().zip(joints).zip(rows) {
            let (length, along, arm, screwed) = self.strut(s, place)?;
            *off = joint - length - screwed;
            let turn = arm.cross(&along);
            row.copy_from_slice(&[along.x, along.y, along.z, turn.x, turn.y, turn.z]);
        }
        if self.lead != 0.0 {
            self.add_screws(&mut jacobian, place)?;
        }
        Some((off, jacobian))
    }

    /// Adds the effect of the screws to the Jacobian, by finite differences.
    fn add_screws(&self, jacobian: &mut Matrix6<f64>, place: &PlatformPose) -> Option<()> {
        let size = self.size();
        for (n, mut column) in jacobian.column_iter_mut().enumerate() {
            let step = if n < 3 { BESIDE * size } else { BESIDE };
            let mut way = Vector6::zeros();
            *way.get_mut(n)? = step;
            let (ahead, behind) = (moved(place, &way), moved(place, &-way));
            for (s, slope) in self.struts.iter().zip(column.iter_mut()) {
                let (.., more) = self.strut(s, &ahead)?;
                let (.., less) = self.strut(s, &behind)?;
                *slope += (more - less) / (2.0 * step);
            }
        }
        Some(())
    }

    fn search(&self, joints: &Joints, from: PlatformPose) -> Result<(PlatformPose, u32), Unsolved> {
        find(from, self.bounds, |place| self.look(joints, place), moved)
    }

    /// Returns a start for the search: above the middle of the base, at the height that the strut lengths give.
    fn middle(&self, joints: &Joints) -> PlatformPose {
        let (mut height, mut middle) = (0.0, Vector::zeros());
        for (s, joint) in self.struts.iter().zip(joints) {
            let way = s.platform - s.base;
            let up = joint * joint - way.x * way.x - way.y * way.y;
            height += if up > 0.0 { sqrt(up) } else { 0.0 } - way.z;
            middle += s.base;
        }
        (Vector::new(middle.x / 6.0, middle.y / 6.0, height / 6.0), Matrix::identity())
    }

    /// Returns the size of the platform in units, by which lengths and angles are compared.
    fn size(&self) -> f64 {
        let sizes = self.struts.iter().map(|s| s.platform.norm());
        let size = sizes.fold(0.0, |m: f64, x| if x > m { x } else { m });
        if size > 0.0 { size } else { 1.0 }
    }
}

/// Moves the platform by a step: a translation, and a rotation vector in radians.
fn moved((at, turned): &PlatformPose, step: &Vector6<f64>) -> PlatformPose {
    let [x, y, z, a, b, c] = (*step).into();
    let axis = Vector::new(a, b, c);
    let angle = axis.norm();
    let turn = if angle > 0.0 { about(&(axis / angle), angle) } else { Matrix::identity() };
    (at + Vector::new(x, y, z), turn * turned)
}

/// Step of the finite differences, as a fraction of the platform's size and in radians.
const BESIDE: f64 = 1e-6;
const TURN: f64 = 2.0 * core::f64::consts::PI;

impl Model for Pins {
    type Geometry = Hexapod;

    fn joints(&self) -> usize {
        6
    }

    fn geometry(&self) -> Option<Hexapod> {
        Hexapod::read(self)
    }

    fn forward(&self, g: &Hexapod, joints: &Joints, guess: &Pose) -> Found<Pose> {
        if joints.iter().take(6).any(|j| *j <= 0.0) {
            self.general.failed.set(true);
            return Err(Unsolved::Unreachable);
        }
        let near =
            (Vector::new(guess[0], guess[1], guess[2]), from_abc([guess[3], guess[4], guess[5]]));
        let found = g.search(joints, near).or_else(|_| g.search(joints, g.middle(joints)));
        self.general.failed.set(found.is_err());
        let (place, took) = found?;
        self.note_steps(took);
        let mut pose = *guess;
        (pose[0], pose[1], pose[2]) = (place.0.x, place.0.y, place.0.z);
        [pose[3], pose[4], pose[5]] = to_abc(&place.1, guess[5]);
        self.show(&pose);
        let singular = g.look(joints, &place).is_none_or(|(_, mut jacobian)| {
            let size = g.size();
            jacobian.columns_mut(3, 3).scale_mut(1.0 / size);
            is_singular(&jacobian)
        });
        Ok((pose, if singular { Solved::Singular } else { Solved::Regular }))
    }

    fn inverse(&self, g: &Hexapod, pose: &Pose, guess: &Joints) -> Found<Joints> {
        let place = (Vector::new(pose[0], pose[1], pose[2]), from_abc([pose[3], pose[4], pose[5]]));
        let mut joints = *guess;
        let mut corrections = [0.0; 6];
        for ((s, joint), correction) in g.struts.iter().zip(&mut joints).zip(&mut corrections) {
            let (length, .., screwed) = g.strut(s, &place).ok_or(Unsolved::Undetermined)?;
            *joint = length + screwed;
            *correction = screwed;
        }
        if g.lead != 0.0 {
            for (pin, correction) in self.struts.iter().zip(corrections) {
                if fabs(correction) <= fabs(g.lead) {
                    pin.correction.set(correction);
                }
            }
        }
        Ok((joints, Solved::Regular))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::{Joint, Rig, Space, close, parallel};

    const SPACE: Space<'static> = Space {
        size: 40.0,
        joints: &[Joint::linear_from(20.0, 60.0); 6],
        letters: &[0, 1, 2, 3, 4, 5],
        abc: true,
        poses: &[(-8., 8.), (-8., 8.), (20., 40.), (-20., 20.), (-20., 20.), (-20., 20.)],
        least: 3990,
        aside: 0.05,
        ..Space::DEFAULT
    };

    #[test]
    fn both_ways() {
        parallel::<Genhexkins>(&[], &SPACE);
    }

    #[test]
    fn both_ways_with_tool_and_screws() {
        let set = &[
            ("genhexkins.tool-offset", 5.0),
            ("genhexkins.spindle-offset", 3.0),
            ("genhexkins.screw-lead", 2.0),
        ];
        // Farther out, a screw passes half a turn from its start, and its correction jumps.
        let poses = &[(-5., 5.), (-5., 5.), (25., 40.), (-8., 8.), (-8., 8.), (-8., 8.)];
        parallel::<Genhexkins>(&[], &Space { set, poses, ..SPACE });
    }

    #[test]
    fn a_search_without_a_guess_begins_above_the_middle() {
        let rig = Rig::new::<Genhexkins>(&[]);
        let pose = [1., 2., 30., 4., 5., 6., 0., 0., 0.];
        let joints = rig.joints(pose);
        close(&rig.pose(&joints[..6]), &pose, 1e-9);
        assert!(!rig.bench.get::<bool>("genhexkins.fwd-kins-fail"));
        let steps: u32 = rig.bench.get("genhexkins.last-iterations");
        assert!((1..20).contains(&steps), "{steps}");
        assert_eq!(rig.bench.get::<u32>("genhexkins.max-iterations"), steps);
        close(&[rig.bench.get("genhexkins.x"), rig.bench.get("skgui.c")], &[1.0, 6.0], 1e-9);
    }

    #[test]
    fn a_search_that_fails_is_told() {
        let rig = Rig::new::<Genhexkins>(&[]);
        assert_eq!(rig.no_pose(&[30., 30., 30., 30., 30., 500.]), Unsolved::NotFound);
        assert!(rig.bench.get::<bool>("genhexkins.fwd-kins-fail"));
        assert_eq!(rig.no_pose(&[-1.0; 6]), Unsolved::Unreachable);
        let joints = rig.joints([1., 2., 30., 4., 5., 6., 0., 0., 0.]);
        rig.bench.set("genhexkins.limit-iterations", 0_u32);
        assert_eq!(rig.no_pose(&joints[..6]), Unsolved::NotFound);
        for (pin, value) in [
            ("convergence-criterion", 0.0),
            ("max-error", f64::NAN),
            ("base.3.y", f64::INFINITY),
            ("platform-n.5.z", f64::NAN),
            ("screw-lead", f64::NAN),
        ] {
            let rig = Rig::new::<Genhexkins>(&[]);
            rig.bench.set(&format!("genhexkins.{pin}"), value);
            assert_eq!(rig.no_pose(&joints[..6]), Unsolved::Geometry, "{pin}");
        }
    }
}
