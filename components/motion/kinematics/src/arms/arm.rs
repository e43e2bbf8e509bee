//! Realtime. Closed-form solution for six-joint arms whose last three axes intersect in the wrist.
//!
//! Pieper, The Kinematics of Manipulators under Computer Control (1968). The names of the lengths are those of the
//! Denavit-Hartenberg parameters as in Craig (Introduction to Robotics, sections 3.4 and 4.6).

use crate::{
    arms::dh::{Chain, Link},
    model::{Found, Joints, Model},
    parallel::circles::{bend, shoulder},
    rotation::{Matrix, Vector, about_x, about_y, about_z, from_abc, is_straight, near, to_abc},
};
use core::f64::consts::{FRAC_PI_2, PI};
use hal_component::{Pose, Solution, Solved, Touch, Unsolved, Ways};
use libm::{atan2, fabs, hypot, sqrt};

/// Lengths of the arm, in units.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Arm {
    /// Distance between the axes of the body and the shoulder.
    pub(crate) a1: f64,
    /// Length of the upper arm.
    pub(crate) a2: f64,
    /// Distance from the elbow to the axis of the forearm.
    pub(crate) a3: f64,
    /// Height of the shoulder.
    pub(crate) d1: f64,
    /// Lateral offset of the arm from the axis of the body.
    pub(crate) d3: f64,
    /// Length of the forearm.
    pub(crate) d4: f64,
    /// Distance from the wrist to the tool tip.
    pub(crate) d6: f64,
}

/// Pins that hold the lengths of an arm.
pub(crate) trait Lengths: Touch + Send + Sync + 'static {
    /// Reads the lengths from the pins. Returns `None` if they are invalid.
    fn arm(&self) -> Option<Arm>;
}

impl<L: Lengths> Model for L {
    type Geometry = Arm;

    fn joints(&self) -> usize {
        6
    }

    fn geometry(&self) -> Option<Arm> {
        self.arm()
    }

    fn forward(&self, arm: &Arm, joints: &Joints, guess: &Pose) -> Found<Pose> {
        arm.forward(joints, guess)
    }

    fn inverse(&self, arm: &Arm, pose: &Pose, guess: &Joints) -> Found<Joints> {
        arm.inverse(pose, guess)
    }

    fn solutions(&self, arm: &Arm, pose: &Pose, ways: &mut Ways<'_>) -> Solution {
        arm.solutions(pose, ways)
    }
}

/// Joint angles of one solution, and whether the arm is singular there.
#[derive(Clone, Copy, Debug)]
struct Way {
    joints: [f64; 6],
    solved: Solved,
}

impl Arm {
    /// Returns the chain of the arm's links.
    pub(crate) fn chain(&self) -> Chain {
        let link = |a, alpha, d| Link { a, alpha, d };
        Chain([
            link(0.0, 0.0, self.d1),
            link(self.a1, -FRAC_PI_2, 0.0),
            link(self.a2, 0.0, self.d3),
            link(self.a3, -FRAC_PI_2, self.d4),
            link(0.0, FRAC_PI_2, 0.0),
            link(0.0, -FRAC_PI_2, self.d6),
        ])
    }

    pub(crate) fn forward(&self, joints: &Joints, guess: &Pose) -> Found<Pose> {
        let (place, turned) = self.chain().end(&angles(joints));
        let mut pose = *guess;
        (pose[0], pose[1], pose[2]) = (place.x, place.y, place.z);
        [pose[3], pose[4], pose[5]] = to_abc(&turned, guess[5]);
        Ok((pose, Solved::Regular))
    }

    /// Returns the solution nearest to the guess.
    pub(crate) fn inverse(&self, pose: &Pose, guess: &Joints) -> Found<Joints> {
        let mut best: Option<(f64, Way)> = None;
        let why = self.each(pose, guess, |way| {
            let ways = way.joints.iter().zip(guess).map(|(a, b)| fabs(a - b));
            let far = ways.sum::<f64>();
            if best.is_none_or(|(least, _)| far < least) {
                best = Some((far, way));
            }
        });
        let Some((_, way)) = best else {
            return Err(why.err().unwrap_or(Unsolved::Unreachable));
        };
        let mut joints = *guess;
        for (to, from) in joints.iter_mut().zip(way.joints) {
            *to = from;
        }
        Ok((joints, way.solved))
    }

    pub(crate) fn solutions(&self, pose: &Pose, ways: &mut Ways<'_>) -> Solution {
        let mut all = Solved::Regular;
        self.each(pose, &[0.0; 16], |way| {
            if way.solved == Solved::Singular {
                all = Solved::Singular;
            }
            ways.push(&way.joints);
        })?;
        Ok(all)
    }

    /// Calls `take` with each of up to eight solutions: two each for shoulder, elbow and wrist.
    fn each(&self, pose: &Pose, guess: &Joints, mut take: impl FnMut(Way)) -> Result<(), Unsolved> {
        let turned = from_abc([pose[3], pose[4], pose[5]]);
        let wrist =
            Vector::new(pose[0], pose[1], pose[2]) - turned * Vector::new(0.0, 0.0, self.d6);
        let size = self.size();
        // Seen along the axis of the body, the wrist has a lateral offset of d3.
        let out = (wrist.x * wrist.x + wrist.y * wrist.y) - self.d3 * self.d3;
        if out < -1e-12 * size * size {
            return Err(Unsolved::Unreachable);
        }
        let out = if out > 0.0 { sqrt(out) } else { 0.0 };
        let at_axis = is_straight(out / size);
        let mut found = false;
        for side in [out, -out] {
            let body = if hypot(wrist.x, wrist.y) > 1e-14 * size {
                atan2(wrist.y, wrist.x) - atan2(self.d3, side)
            } else {
                guess[0].to_radians()
            };
            let (x, z) = (side - self.a1, self.d1 - wrist.z);
            let fore = hypot(self.a3, self.d4);
            let Ok(elbow) = bend(x * x + z * z, self.a2, fore) else { continue };
            found = true;
            let kink = atan2(self.d4, self.a3);
            for angle in [elbow.elbow, -elbow.elbow] {
                let upper = shoulder(x, z, self.a2, fore, angle);
                let arm = [body, upper, angle - kink];
                let base = about_z(body) * about_x(-FRAC_PI_2) * about_z(upper + angle - kink);
                let hand = about_x(FRAC_PI_2) * base.transpose() * turned;
                let singular = at_axis || elbow.solved == Solved::Singular;
                for (wrist, straight) in wrists(&hand, guess).into_iter().flatten() {
                    let solved =
                        if singular || straight { Solved::Singular } else { Solved::Regular };
                    let mut joints = [0.0; 6];
                    let angles = arm.iter().chain(&wrist);
                    for ((to, angle), last) in joints.iter_mut().zip(angles).zip(guess) {
                        *to = near(angle.to_degrees(), *last);
                    }
                    take(Way { joints, solved });
                }
                if elbow.solved == Solved::Singular && angle == 0.0 {
                    break;
                }
            }
            if out == 0.0 {
                break;
            }
        }
        if found { Ok(()) } else { Err(Unsolved::Unreachable) }
    }

    /// Returns an upper bound of the reach, in units.
    fn size(&self) -> f64 {
        [self.a1, self.a2, self.a3, self.d3, self.d4].iter().map(|l| fabs(*l)).sum()
    }
}

/// Returns both solutions for the three wrist angles, and whether the wrist is straight. A straight wrist has one
/// solution, which keeps joint 3 at the guess (Euler angles Z-Y-Z; Craig, section 2.8).
fn wrists(hand: &Matrix, guess: &Joints) -> [Option<([f64; 3], bool)>; 2] {
    let sine = hypot(hand[(0, 2)], hand[(1, 2)]);
    let straight = is_straight(sine);
    let way = |fourth: f64, fifth: f64| {
        let rest = about_y(fifth) * about_z(-fourth) * hand;
        ([fourth, fifth, atan2(rest.m21, rest.m11)], straight)
    };
    if sine < STRAIGHT {
        let fifth = if hand[(2, 2)] > 0.0 { 0.0 } else { PI };
        return [Some(way(guess[3].to_radians(), fifth)), None];
    }
    let fourth = atan2(-hand[(1, 2)], -hand[(0, 2)]);
    let fifth = atan2(sine, hand[(2, 2)]);
    [Some(way(fourth, fifth)), Some(way(fourth + PI, -fifth))]
}

/// Sine of the wrist's bend below which the wrist counts as straight.
const STRAIGHT: f64 = 1e-10;

/// Converts the first six joints to radians.
pub(crate) fn angles(joints: &Joints) -> [f64; 6] {
    [joints[0], joints[1], joints[2], joints[3], joints[4], joints[5]].map(f64::to_radians)
}
