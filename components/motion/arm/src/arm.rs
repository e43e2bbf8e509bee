//! Realtime. Closed form of arms of six turning joints whose last three axes intersect in the wrist.
//!
//! Denavit and Hartenberg, A kinematic notation for lower-pair mechanisms (1955); Pieper, The Kinematics of Manipulators
//! under Computer Control (1968).

use crate::{
    frame::Frame,
    rotation::{Matrix, Vector, about_x, about_z, is_straight},
};
use core::f64::consts::{FRAC_PI_2, PI};
use libm::{atan2, ceil, cos, fabs, floor, hypot, remainder, sin, sqrt};

/// Angles of the joints in degrees.
pub type Joints = [f64; 6];

/// Number of configurations: two each for arm, elbow and wrist.
pub const CONFIGURATIONS: usize = 8;

/// Dimensions and limits of an arm, in units and degrees.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Arm {
    /// Distance between the axes of joints 1 and 2.
    pub a1: f64,
    /// Length of the upper arm; above 0.
    pub a2: f64,
    /// Distance from the axis of joint 3 to the axis of the forearm.
    pub a3: f64,
    /// Height of the axis of joint 2.
    pub d1: f64,
    /// Length of the forearm, up to the wrist.
    pub d4: f64,
    /// Distance from the wrist to the flange.
    pub d6: f64,
    /// Angle of the model at which a joint is at 0.
    pub offset: Joints,
    /// Direction of each joint: 1 or -1.
    pub sign: Joints,
    /// Lowest angle of each joint.
    pub min: Joints,
    /// Highest angle of each joint.
    pub max: Joints,
}

/// Joint positions of one configuration.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Way {
    /// Joint positions, all within their limits.
    pub joints: Joints,
    /// True if other joint positions are equally valid, or neighbouring poses need unbounded joint speed.
    pub is_singular: bool,
}

/// Reason why a configuration does not reach a pose.
#[derive(Clone, Copy, PartialEq, Debug)]
pub enum Miss {
    /// The wrist would have to be farther from the shoulder, or nearer to it, than the arm allows.
    Reach {
        /// Missing length, in units.
        by: f64,
    },
    /// A joint would have to be beyond its limit; of several, the one that is the farthest beyond.
    Limit {
        /// Index of the joint, from 0.
        joint: usize,
        /// Angle that is needed.
        angle: f64,
        /// Limit that forbids it.
        limit: f64,
    },
}

impl Arm {
    /// Six-joint arm with a reach of 985 mm, the Stäubli RX-90.
    pub const RX90: Self = Self {
        a1: 0.0,
        a2: 450.0,
        a3: 0.0,
        d1: 0.0,
        d4: 450.0,
        d6: 85.0,
        offset: [0.0; 6],
        sign: [1.0; 6],
        min: [-160.0, -200.0, -52.5, -270.0, -105.0, -270.0],
        max: [160.0, 35.0, 232.5, 270.0, 120.0, 270.0],
    };

    /// Six-joint arm with a reach of 620 mm, the Kawasaki RS03N.
    pub const RS03N: Self = Self {
        a1: 120.0,
        a2: 250.0,
        a3: 0.0,
        d1: 0.0,
        d4: 250.0,
        d6: 76.5,
        offset: [90.0, -90.0, 90.0, 0.0, 0.0, -90.0],
        sign: [-1.0, 1.0, -1.0, 1.0, -1.0, 1.0],
        min: [-160.0, -60.0, -150.0, -360.0, -135.0, -360.0],
        max: [160.0, 150.0, 120.0, 360.0, 135.0, 360.0],
    };

    /// Returns whether the dimensions describe an arm.
    #[must_use]
    pub fn is_valid(&self) -> bool {
        let numbers = [self.a1, self.a2, self.a3, self.d1, self.d4, self.d6];
        let is_number = |x: &f64| fabs(*x) < LARGEST;
        let limits = self.min.iter().zip(&self.max);
        numbers.iter().all(is_number)
            && self.a2 > SMALLEST
            && hypot(self.a3, self.d4) > SMALLEST
            && self.offset.iter().all(is_number)
            && self.sign.iter().all(|s| fabs(*s) == 1.0)
            && limits.clone().all(|(low, high)| low <= high)
            && limits.flat_map(|(low, high)| [low, high]).all(is_number)
    }

    /// Returns the number of ways in which whole turns of its joints, as far as the limits allow them, reach the same place.
    #[must_use]
    pub fn turns(&self) -> usize {
        // The plan looks at two turns to either side.
        let of = |(low, high): (&f64, &f64)| {
            (0..5).take_while(|n| 360.0 * f64::from(*n) <= high - low).count()
        };
        self.min.iter().zip(&self.max).map(of).product()
    }

    /// Returns the flange at these joints.
    #[must_use]
    pub fn flange(&self, joints: &Joints) -> Frame {
        let [.., flange] = self.frames(joints);
        flange
    }

    /// Returns the points of a drawing of the arm: base, shoulder, elbow, wrist and flange.
    #[must_use]
    pub fn skeleton(&self, joints: &Joints) -> [Vector; 5] {
        let [shoulder, elbow, _, _, wrist, flange] = self.frames(joints).map(|f| f.origin);
        [Vector::new(0.0, 0.0, shoulder.z), shoulder, elbow, wrist, flange]
    }

    /// Returns the frames of the links.
    fn frames(&self, joints: &Joints) -> [Frame; 6] {
        let links = [
            (-FRAC_PI_2, self.a1, self.d1),
            (0.0, self.a2, 0.0),
            (FRAC_PI_2, self.a3, 0.0),
            (-FRAC_PI_2, 0.0, self.d4),
            (FRAC_PI_2, 0.0, 0.0),
            (0.0, 0.0, self.d6),
        ];
        let mut frame = Frame::identity();
        let mut out = [frame; 6];
        for (((alpha, a, d), angle), out) in
            links.into_iter().zip(self.angles(joints)).zip(&mut out)
        {
            let turn = about_z(angle);
            let origin = turn * Vector::new(a, 0.0, d);
            frame = frame.then(&Frame { origin, turn: turn * about_x(alpha) });
            *out = frame;
        }
        out
    }

    /// Returns the configuration of these joints: 4 if the arm reaches backwards, 2 if the elbow is down, 1 if the wrist
    /// is flipped.
    #[must_use]
    pub fn configuration(&self, joints: &Joints) -> usize {
        let [_, shoulder, elbow, _, wrist, _] = self.angles(joints);
        let both = shoulder + elbow;
        let out = self.a1 + self.a2 * cos(shoulder) + self.a3 * cos(both) + self.d4 * sin(both);
        let bend = sin(elbow - FRAC_PI_2 + atan2(self.a3, self.d4));
        let is_back = out < 0.0;
        let is_down = if is_back { bend > 0.0 } else { bend < 0.0 };
        4 * usize::from(is_back) + 2 * usize::from(is_down) + usize::from(sin(wrist) < 0.0)
    }

    /// Returns the joints that bring the flange to a frame in one configuration; turns and singular joints stay near
    /// `last`.
    ///
    /// # Errors
    /// The configuration does not reach the frame.
    pub fn solve(&self, flange: &Frame, configuration: usize, last: &Joints) -> Result<Way, Miss> {
        let front = if configuration & 4 == 0 { 1.0 } else { -1.0 };
        let up = if configuration & 2 == 0 { front } else { -front };
        let wrist = flange.origin - flange.turn * Vector::new(0.0, 0.0, self.d6);
        let last = self.angles(last);
        let fore = hypot(self.a3, self.d4);
        let size = self.a2 + fore;
        let across = hypot(wrist.x, wrist.y);
        let body = if across > UNDETERMINED * size {
            atan2(front * wrist.y, front * wrist.x)
        } else {
            last[0]
        };
        let (out, down) = (front * across - self.a1, self.d1 - wrist.z);
        let far = hypot(out, down);
        // Cosine of the elbow's bend, and its distance to the ends of its range as a product of lengths: nothing cancels.
        let cosine = (far * far - self.a2 * self.a2 - fore * fore) / (2.0 * self.a2 * fore);
        let square = (size - far) * (size + far) * (far - self.a2 + fore) * (far + self.a2 - fore);
        if cosine > 1.0 + CLAMPED {
            return Err(Miss::Reach { by: far - size });
        }
        if cosine < -1.0 - CLAMPED {
            return Err(Miss::Reach { by: fabs(self.a2 - fore) - far });
        }
        let sine = if square > 0.0 { sqrt(square) / (2.0 * self.a2 * fore) } else { 0.0 };
        let bend = up * atan2(sine, cosine);
        let shoulder = atan2(down, out) - atan2(fore * sin(bend), self.a2 + fore * cos(bend));
        let elbow = bend + FRAC_PI_2 - atan2(self.a3, self.d4);
        let base =
            about_z(body) * about_x(-FRAC_PI_2) * about_z(shoulder + elbow) * about_x(FRAC_PI_2);
        let hand = base.transpose() * flange.turn;
        let (wrists, is_straight_wrist) = wrists(&hand, configuration & 1 != 0, last[3]);
        let is_singular = is_straight(across / size) || is_straight(sine) || is_straight_wrist;
        let [first, second, third] = wrists;
        let joints = self.within([body, shoulder, elbow, first, second, third], &last)?;
        Ok(Way { joints, is_singular })
    }

    /// Calls `take` with the number and the joints of each configuration that reaches a frame. Configurations that
    /// coincide, as they do at singular frames, count once. Returns the first reason if there is none.
    ///
    /// # Errors
    /// No configuration reaches the frame. A limit is the reason if any configuration reaches it except for a limit.
    pub fn each(
        &self,
        flange: &Frame,
        last: &Joints,
        mut take: impl FnMut(usize, &Way),
    ) -> Result<(), Miss> {
        let mut known: [Option<Joints>; CONFIGURATIONS] = [None; CONFIGURATIONS];
        let mut miss = None;
        for configuration in 0..CONFIGURATIONS {
            match self.solve(flange, configuration, last) {
                Err(why) => {
                    if miss.is_none()
                        || matches!((miss, why), (Some(Miss::Reach { .. }), Miss::Limit { .. }))
                    {
                        miss = Some(why);
                    }
                }
                Ok(way) => {
                    let is_same = |other: &Joints| {
                        let pairs = way.joints.iter().zip(other);
                        way.is_singular
                            && pairs.clone().all(|(a, b)| fabs(remainder(a - b, 360.0)) < SAME)
                    };
                    if !known.iter().flatten().any(is_same) {
                        take(configuration, &way);
                    }
                    if let Some(place) = known.get_mut(configuration) {
                        *place = Some(way.joints);
                    }
                }
            }
        }
        match miss {
            Some(why) if known.iter().all(Option::is_none) => Err(why),
            _ => Ok(()),
        }
    }

    /// Returns the joint that is nearest to one of its limits, and the distance in degrees; below 0 beyond the limit.
    #[must_use]
    pub fn margin(&self, joints: &Joints) -> (usize, f64) {
        let mut least = (0, f64::INFINITY);
        for (joint, (angle, (low, high))) in
            joints.iter().zip(self.min.iter().zip(&self.max)).enumerate()
        {
            let room = f64::min(angle - low, high - angle);
            if room < least.1 {
                least = (joint, room);
            }
        }
        least
    }

    /// Returns the angles of the model in radians.
    fn angles(&self, joints: &Joints) -> [f64; 6] {
        let mut out = [0.0; 6];
        for ((out, joint), (offset, sign)) in
            out.iter_mut().zip(joints).zip(self.offset.iter().zip(&self.sign))
        {
            *out = (offset + sign * joint).to_radians();
        }
        out
    }

    /// Returns the joints with these angles of the model in radians, turned within their limits and near the last.
    fn within(&self, angles: [f64; 6], last: &[f64; 6]) -> Result<Joints, Miss> {
        let mut joints = [0.0; 6];
        let mut worst: Option<(f64, Miss)> = None;
        for (n, joint) in joints.iter_mut().enumerate() {
            let all = [&angles, last, &self.offset, &self.sign, &self.min, &self.max];
            let [angle, last, offset, sign, min, max] =
                all.map(|list| list.get(n).copied().unwrap_or(0.0));
            let of = |radians: f64| (radians.to_degrees() - offset) / sign;
            let near = of(last) + remainder(of(angle) - of(last), 360.0);
            match turned(near, min, max) {
                Ok(angle) => *joint = angle,
                Err((angle, limit)) => {
                    let by = fabs(angle - limit);
                    if worst.is_none_or(|(most, _)| by > most) {
                        worst = Some((by, Miss::Limit { joint: n, angle, limit }));
                    }
                }
            }
        }
        if let Some((_, miss)) = worst {
            return Err(miss);
        }
        Ok(joints)
    }
}

/// Returns an angle, or the nearest to it within the limits that differs by full turns. Otherwise returns the angle that
/// is beyond a limit by the least, and that limit.
fn turned(angle: f64, min: f64, max: f64) -> Result<f64, (f64, f64)> {
    let first = ceil((min - EDGE - angle) / 360.0);
    let last = floor((max + EDGE - angle) / 360.0);
    if first <= last {
        let turns = if first > 0.0 {
            first
        } else if last < 0.0 {
            last
        } else {
            0.0
        };
        return Ok(f64::max(min, f64::min(angle + 360.0 * turns, max)));
    }
    let (above, below) = (angle + 360.0 * first, angle + 360.0 * last);
    if above - max <= min - below { Err((above, max)) } else { Err((below, min)) }
}

/// Returns the angles of the wrist in radians, and whether it is straight. A straight wrist keeps joint 4 (Euler angles
/// Z-Y-Z; Craig, Introduction to Robotics, section 2.8).
fn wrists(hand: &Matrix, is_flipped: bool, last: f64) -> ([f64; 3], bool) {
    let sine = hypot(hand[(0, 2)], hand[(1, 2)]);
    if sine < UNDETERMINED {
        let rest = about_z(-last) * hand;
        let (middle, third) = if hand[(2, 2)] > 0.0 {
            (0.0, atan2(rest.m21, rest.m11))
        } else {
            (PI, atan2(rest.m12, rest.m22))
        };
        return ([last, middle, third], true);
    }
    let flip = if is_flipped { -1.0 } else { 1.0 };
    let angles = [
        atan2(flip * hand[(1, 2)], flip * hand[(0, 2)]),
        atan2(flip * sine, hand[(2, 2)]),
        atan2(flip * hand[(2, 1)], -flip * hand[(2, 0)]),
    ];
    (angles, is_straight(sine))
}

/// Largest magnitude of a number.
const LARGEST: f64 = 1e30;
/// Smallest length.
const SMALLEST: f64 = 1e-30;
/// Sine, or share of the arm's size, below which a joint is undetermined and stays where it was.
const UNDETERMINED: f64 = 1e-10;
/// Distance by which the cosine of the elbow may be beyond ±1.
const CLAMPED: f64 = 1e-9;
/// Distance in degrees by which rounding may move an angle beyond a limit.
const EDGE: f64 = 1e-9;
/// Difference in degrees below which solutions are the same.
const SAME: f64 = 1e-4;
