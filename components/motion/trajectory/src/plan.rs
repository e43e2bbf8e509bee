//! The planner: from moves to cells with proved limits.

use crate::{
    blend::{Blend, Joint},
    certificate::{Certificate, Rejection},
    curve::Curve,
    erosion::Erosion,
    error::Error,
    join::Join,
    kinematics::Kinematics,
    machine::{Limits, Machine},
    moves::{Mode, Move},
    pose::Pose,
    segment::{Segment, Tolerances, UNBOUNDED},
    speed::Law,
    track::Track,
};

mod cells;
mod reach;
mod rounding;
pub(crate) mod spline;
mod window;

use cells::Span;
use window::Window;

/// Number of cells that a track holds; further moves are refused until the follower has advanced.
pub const CAPACITY: usize = 16384;

/// Number of cells that a planner with a hand-over holds besides those that it has handed over.
pub(crate) const STAGED: usize = 2048;

/// Largest angle of an arc in one cell, in radians.
const ARC_CELL: f64 = 0.25;

/// Length of the cells of a long blend.
const BLEND_CELL: f64 = 0.5;

/// Plans a path move by move. Everything that is published can be followed at once and ends at rest.
#[derive(Clone, Debug)]
pub struct Planner<K> {
    machine: Machine,
    kinematics: K,
    direct: bool,
    law: Law,
    track: Track,
    erosion: Erosion,
    certificate: Certificate,
    /// End of the last accepted move.
    position: Pose,
    /// Last segment, whose end depends on the next one, and the coordinate up to which it is used.
    held: Option<(Segment, f64)>,
    /// Lines that wait to be joined to a spline.
    join: Join,
    window: Window,
    /// Number of cells beyond which moves are refused.
    room: usize,
    /// Highest acceleration and jerk along the path.
    acceleration: f64,
    jerk: f64,
    /// Largest distance from the programmed path so far, if it is watched.
    deviation: Option<Deviation>,
}

/// Largest distance of a planned path from the programmed one.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Deviation {
    /// Distance in length units: of a blend from its corner, in XYZ or UVW; of joined lines, a bound that is at most twice as
    /// large.
    pub distance: f64,
    /// Line of the program before the corner, 0 if the path is the programmed one everywhere.
    pub line: u32,
}

impl<K: Kinematics> Planner<K> {
    /// Planner for a machine at rest at a pose.
    pub fn new(machine: Machine, kinematics: K, start: Pose) -> Result<Self, Error> {
        machine.check()?;
        if !start.is_usable() {
            return Err(Error::NotFinite { line: 0 });
        }
        let mut axes = machine.axes;
        let map = kinematics.axes_of_joints();
        for (axis, limits) in map.iter().flatten().zip(&machine.joints) {
            if let Some(slot) = axis.and_then(|k| axes.get_mut(k)) {
                *slot = tighter(slot, limits);
            }
        }
        let law = Law::new(&machine, axes);
        Ok(Self {
            machine,
            kinematics,
            direct: map.is_some(),
            law,
            track: Track::default(),
            erosion: Erosion::default(),
            certificate: Certificate::default(),
            position: start,
            held: None,
            join: Join::default(),
            window: Window::default(),
            room: CAPACITY,
            acceleration: f64::INFINITY,
            jerk: f64::INFINITY,
            deviation: None,
        })
    }

    /// Limits the acceleration along the path of all further moves, in units per second squared; infinity is no limit. If
    /// the limit changes, the moves so far end in a stop.
    pub fn limit_acceleration(&mut self, acceleration: f64) {
        let acceleration = if acceleration >= 1e-6 { acceleration } else { 1e-6 };
        if acceleration.to_bits() != self.acceleration.to_bits() {
            self.finish();
            self.acceleration = acceleration;
        }
    }

    /// Limits the jerk along the path, in units per second cubed, of a machine whose axes have limits of jerk; infinity is
    /// no limit. Call it before the first move.
    pub const fn limit_jerk(&mut self, jerk: f64) {
        self.jerk = if jerk >= 1e-6 { jerk } else { 1e-6 };
    }

    /// Adds a move. A refused move changes nothing.
    pub fn push(&mut self, next: &Move) -> Result<(), Error> {
        self.push_for(next, f64::INFINITY)
    }

    /// Adds a move whose speed something else decides while it moves, such as a spindle: its feed is the highest one, and its
    /// corners are rounded as `speed` needs it, in units of the feed. A refused move changes nothing.
    pub fn push_for(&mut self, next: &Move, speed: f64) -> Result<(), Error> {
        if self.track.len() >= self.room {
            return Err(Error::Full);
        }
        let Some(mut segment) = next.segment(&self.position)? else {
            // Too short to be a move: its length becomes part of the next one.
            if next.mode == Mode::ExactStop
                && !self.join.stop()
                && let Some((held, _)) = &mut self.held
            {
                held.mode = Mode::ExactStop;
            }
            return Ok(());
        };
        segment.rounded_for = segment.rounded_for.min(speed);
        if !self.direct {
            self.check_reach(&segment)?;
        }
        self.position = segment.curve.pose(segment.length);
        self.add(&segment);
        self.publish();
        Ok(())
    }

    /// Joins the segment to the lines before it, or adds it as it is.
    fn add(&mut self, segment: &Segment) {
        if self.join.continues(segment) {
            if self.join.is_full() {
                self.flush(true);
            }
            self.join.push(segment);
            return;
        }
        self.flush(false);
        if Join::is_dense(segment) {
            self.join.push(segment);
        } else {
            self.place(Some(segment));
        }
    }

    /// Adds the lines that wait to be joined.
    fn flush(&mut self, goes_on: bool) {
        let mut join = core::mem::take(&mut self.join);
        for segment in &self.join_lines(&mut join, goes_on) {
            self.place(Some(segment));
        }
        self.join = join;
    }

    /// Ends the path for now: publishes everything, with a stop at the end.
    pub fn finish(&mut self) {
        self.flush(false);
        self.place(None);
        self.stop();
        self.publish();
    }

    /// Returns the track that the follower reads.
    pub const fn track(&self) -> &Track {
        &self.track
    }

    /// Forgets cells before this number. Call it while the follower moves forward or rests.
    pub fn forget(&mut self, number: u64) {
        let _ = self.track.forget(number);
    }

    /// Forgets cells before this number, which have been handed over.
    pub(crate) fn hand_over(&mut self, number: u64) {
        self.room = STAGED;
        self.forget(number);
    }

    /// Returns the memory in use, in bytes.
    pub fn memory(&self) -> usize {
        self.track.memory() + self.erosion.memory() + self.certificate.memory()
    }

    /// Measures from now on how far the path is from the programmed one. A plan that is only computed can afford the time.
    pub const fn watch_deviation(&mut self) {
        self.deviation = Some(Deviation { distance: 0.0, line: 0 });
    }

    /// Returns the largest distance from the programmed path since [`Self::watch_deviation`].
    pub const fn deviation(&self) -> Option<Deviation> {
        self.deviation
    }

    /// Returns the end of the last accepted move.
    pub const fn position(&self) -> &Pose {
        &self.position
    }

    /// Returns how many cells the certificate has rejected, and the last of them.
    pub const fn rejections(&self) -> (u64, Option<Rejection>) {
        (self.certificate.rejections, self.certificate.last)
    }

    /// Returns the tolerances of a mode.
    fn tolerance(&self, mode: &Mode) -> Tolerances {
        let linear = match mode {
            Mode::Blend(p) if *p >= 1e-6 => p.min(UNBOUNDED),
            Mode::Blend(_) | Mode::Exact | Mode::ExactStop => self.machine.exact_tolerance,
        };
        Tolerances { linear, angular: self.machine.angular_tolerance }
    }

    /// Returns the tolerances at the joint between two segments: the tighter of theirs, without the share in use.
    fn tolerances(&self, a: &Segment, b: &Segment) -> Tolerances {
        let (x, y) = (self.tolerance(&a.mode), self.tolerance(&b.mode));
        let rest = 1.0 - a.off.max(b.off);
        Tolerances { linear: x.linear.min(y.linear) * rest, angular: x.angular * rest }
    }

    /// Lays the held segment on the track up to its joint with the next, and holds the next.
    fn place(&mut self, next: Option<&Segment>) {
        let Some((a, begun)) = self.held.take() else {
            self.held = next.map(|b| (*b, 0.0));
            return;
        };
        let joint = match next {
            Some(b) if a.mode != Mode::ExactStop => self.joint(&a, b),
            _ => Joint::Stop,
        };
        let half = if let Joint::Blend(blend) = &joint { blend.half } else { 0.0 };
        let (from, to) = (begun, a.length - half);
        if to > from {
            let pieces = match &a.curve {
                Curve::Line { .. } => 1,
                Curve::Arc { rate, .. } => count((to - from) * rate.abs() / ARC_CELL),
                Curve::Poly { .. } => 2,
            };
            self.add_span(&Span { curve: a.curve, from, to, pieces }, &a, None);
        }
        if let (Joint::Blend(blend), Some(b)) = (&joint, next) {
            self.note_corner(blend, b, a.line);
            let pieces = pieces(blend);
            let span = Span { curve: blend.curve, from: 0.0, to: 2.0 * half, pieces };
            self.add_span(&span, &a, Some(b));
        }
        if joint == Joint::Stop {
            self.stop();
        }
        self.held = next.map(|b| (*b, half));
    }

    /// Ends the run with a stop.
    fn stop(&mut self) {
        self.drain(f64::INFINITY);
        self.track.stop_at_end();
        self.erosion.restart();
        self.certificate.restart();
    }

    fn publish(&mut self) {
        let _ = self.track.sweep();
    }
}

/// Returns the tighter of two limits, value by value.
const fn tighter(a: &Limits, b: &Limits) -> Limits {
    Limits {
        velocity: a.velocity.min(b.velocity),
        acceleration: a.acceleration.min(b.acceleration),
        jerk: a.jerk.min(b.jerk),
    }
}

/// Returns the number of cells of a blend.
fn pieces(blend: &Blend) -> u16 {
    let wide = count(2.0 * blend.half / BLEND_CELL).min(16);
    if wide > 4 { wide } else { 4 }
}

/// Returns the next whole number, from 1 to 60000.
fn count(x: f64) -> u16 {
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "1 to 60000")]
    let whole = if x > 1.0 { x.ceil().min(60000.0) as u16 } else { 1 };
    whole
}
