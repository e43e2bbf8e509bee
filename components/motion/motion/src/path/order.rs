//! Values that pass between the realtime side of a path and its planner.

use crate::{
    commands::command::{Follows, Output, Probe, Sync},
    commands::refusal::Refusal,
    setup::MAX_JOINTS,
};
use crossbeam::queue::ArrayQueue;
use hal_component::{Plain, Pose};
use hal_trajectory::{
    Cell, Curve, Follower, Limits, Mode, Path as TrajectoryPath, Pursuer, Reader, Scales, Shape,
    Track,
};
use std::sync::atomic::{AtomicU32, AtomicU64, Ordering};

/// Capacity of the queue of orders to the planner.
const ORDERS: usize = 256;

/// Capacity of the queue of new paths. The queue of old ones has room for all of them.
const PATHS: usize = 8;

/// Kind of a move, with the numbers of the pin `motion.motion-type`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) enum Kind {
    #[default]
    None = 0,
    Rapid = 1,
    Feed = 2,
    Arc = 3,
    Probe = 5,
}

impl Kind {
    /// Returns the override that counts for a move of this kind.
    pub(crate) const fn scale(self, scales: &Scales) -> f64 {
        match self {
            Self::Rapid => scales.rapid,
            Self::None | Self::Feed | Self::Arc | Self::Probe => scales.feed,
        }
    }
}

/// A programmed move whose shape is complete.
#[derive(Clone, Copy, Debug)]
pub(crate) struct PathMove {
    pub(crate) shape: Shape,
    pub(crate) kind: Kind,
    pub(crate) mode: Mode,
    pub(crate) probe: Option<Probe>,
    /// Units per second, or the duration in seconds if `is_time`.
    pub(crate) feed: f64,
    pub(crate) is_time: bool,
    /// Highest acceleration along the path.
    pub(crate) acceleration: f64,
    /// Line of the program.
    pub(crate) line: u32,
    pub(crate) sync: Option<Sync>,
    /// Turns per second of that spindle as the move was given.
    pub(crate) turns: f64,
}

impl PathMove {
    /// Returns whether the move is a rigid tap.
    pub(crate) const fn is_tap(&self) -> bool {
        matches!(self.sync, Some(Sync { follows: Follows::Tap { .. }, .. }))
    }
}

/// An element of a path.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Item {
    Move(PathMove),
    /// An output that changes when the motion gets there.
    Output(Output),
}

/// Work for the planner, in order.
#[expect(
    clippy::large_enum_variant,
    reason = "nearly all are moves, and realtime code makes no boxes"
)]
#[derive(Clone, Copy, Debug)]
pub(crate) enum Order {
    /// Begins a path at rest, with the latest [`PathSetup`].
    Begin {
        generation: u32,
    },
    Move {
        generation: u32,
        id: u32,
        order: PathMove,
    },
    /// Plans the moves so far to their end.
    Finish {
        generation: u32,
    },
    /// Accepts moves again, after one was refused.
    Resume {
        generation: u32,
    },
}

/// A move that the planner refuses. It skips the moves that follow until [`Order::Resume`].
#[derive(Clone, Copy, Debug)]
pub(crate) struct Report {
    pub(crate) generation: u32,
    pub(crate) id: u32,
    pub(crate) why: Refusal,
}

/// The realtime half of a path.
#[derive(Debug)]
pub(crate) struct Session {
    pub(crate) generation: u32,
    pub(crate) rider: Rider,
    pub(crate) way: Way,
}

/// Mover along the path of a session.
#[derive(Debug)]
pub(crate) enum Rider {
    /// Moves at the speeds of the path.
    Follower(Follower),
    /// Moves as a spindle turns.
    Pursuer(Pursuer),
}

impl Session {
    /// Returns the cell of the motion, and the distance from its start.
    pub(crate) fn input(&self) -> (u64, f64) {
        match &self.rider {
            Rider::Follower(follower) => follower.input(&self.way),
            Rider::Pursuer(pursuer) => pursuer.input(&self.way),
        }
    }

    /// Returns the limits along the path at the motion's place, if it follows a spindle and has a path.
    pub(crate) fn limits(&mut self) -> Option<Limits> {
        match &mut self.rider {
            Rider::Follower(_) => None,
            Rider::Pursuer(pursuer) => pursuer.limits(&self.way),
        }
    }

    /// Returns whether the motion rests at the end of the path.
    pub(crate) fn is_done(&self) -> bool {
        match &self.rider {
            Rider::Follower(follower) => follower.is_done(&self.way),
            Rider::Pursuer(pursuer) => pursuer.is_done(&self.way),
        }
    }
}

/// Planned path of a session.
#[derive(Debug)]
pub(crate) enum Way {
    /// Shared with the planner, which goes on planning.
    Shared(Reader),
    /// Complete, so that the motion may turn at any time.
    Own(Box<Track>),
}

impl TrajectoryPath for Way {
    fn cell(&self, number: u64) -> Option<Cell> {
        match self {
            Self::Shared(reader) => reader.cell(number),
            Self::Own(track) => track.cell(number).copied(),
        }
    }

    fn has(&self, number: u64) -> bool {
        match self {
            Self::Shared(reader) => reader.has(number),
            Self::Own(track) => track.has(number),
        }
    }

    fn curve(&self, number: u64) -> Option<Curve> {
        match self {
            Self::Shared(reader) => reader.curve(number),
            Self::Own(track) => track.curve(number).copied(),
        }
    }

    fn may_turn(&self, reverse: bool) -> bool {
        match self {
            Self::Shared(reader) => reader.may_turn(reverse),
            Self::Own(_) => true,
        }
    }

    fn release(&self, oldest: u64) {
        if let Self::Shared(reader) = self {
            reader.release(oldest);
        }
    }
}

/// Queues between the realtime side and the planner.
#[derive(Debug)]
pub(crate) struct HandOver {
    pub(crate) orders: ArrayQueue<Order>,
    pub(crate) reports: ArrayQueue<Report>,
    pub(crate) made: ArrayQueue<Box<Session>>,
    /// Paths that the planner frees.
    pub(crate) old: ArrayQueue<Box<Session>>,
    /// Latest generation; orders of earlier ones are void.
    latest: AtomicU32,
    /// Generation, and the number of the last move to whose end the path is published.
    finished: AtomicU64,
    /// Cell of the follower's input, and the distance from its start. Each is of some recent cycle.
    cell: AtomicU64,
    gone: AtomicU64,
}

impl HandOver {
    pub(crate) fn new() -> Self {
        Self {
            orders: ArrayQueue::new(ORDERS),
            reports: ArrayQueue::new(16),
            made: ArrayQueue::new(PATHS),
            old: ArrayQueue::new(2 * PATHS),
            latest: AtomicU32::new(0),
            finished: AtomicU64::new(0),
            cell: AtomicU64::new(0),
            gone: AtomicU64::new(0),
        }
    }

    pub(crate) fn latest(&self) -> u32 {
        self.latest.load(Ordering::Relaxed)
    }

    pub(crate) fn set_latest(&self, generation: u32) {
        self.latest.store(generation, Ordering::Relaxed);
    }

    /// Reports the place of the follower's input.
    pub(crate) fn set_input(&self, (cell, gone): (u64, f64)) {
        self.cell.store(cell, Ordering::Relaxed);
        self.gone.store(gone.to_bits(), Ordering::Relaxed);
    }

    /// Planner: returns the place of the follower's input.
    pub(crate) fn input(&self) -> (u64, f64) {
        (self.cell.load(Ordering::Relaxed), f64::from_bits(self.gone.load(Ordering::Relaxed)))
    }

    /// Planner: reports that the path is published up to the end of this move.
    pub(crate) fn finish(&self, generation: u32, id: u32) {
        // Pairs with `is_finished`: the path is published before.
        self.finished.store(u64::from(generation) << 32 | u64::from(id), Ordering::Release);
    }

    /// Returns whether the path of this generation is published to the end of this move.
    pub(crate) fn is_finished(&self, generation: u32, id: u32) -> bool {
        let finished = self.finished.load(Ordering::Acquire); // Pairs with `finish`.
        finished >> 32 == u64::from(generation) && !is_after(id, finished)
    }
}

#[expect(clippy::cast_possible_truncation, reason = "the lower half")]
const fn is_after(id: u32, finished: u64) -> bool {
    comes_after(id, finished as u32)
}

/// Returns whether one number of a move comes after another; numbers wrap.
pub(crate) const fn comes_after(id: u32, other: u32) -> bool {
    id.wrapping_sub(other).cast_signed() > 0
}

/// Limits and place of the machine at the start of a path, in machine units and seconds.
#[derive(Clone, Copy, Debug, Plain)]
pub(crate) struct PathSetup {
    /// Generation of the path.
    pub(crate) generation: u32,
    /// Servo period.
    pub(crate) period: f64,
    /// Pose at rest.
    pub(crate) start: Pose,
    /// Joint positions at rest.
    pub(crate) places: [f64; MAX_JOINTS],
    /// True for joints that are configured and follow the kinematics.
    pub(crate) joint_active: [bool; MAX_JOINTS],
    /// Lowest positions of joints; negative infinity while a joint is not homed.
    pub(crate) joint_min: [f64; MAX_JOINTS],
    /// Highest positions of joints; infinity while a joint is not homed.
    pub(crate) joint_max: [f64; MAX_JOINTS],
    /// Highest velocities of joints.
    pub(crate) joint_velocity: [f64; MAX_JOINTS],
    /// Highest accelerations of joints.
    pub(crate) joint_acceleration: [f64; MAX_JOINTS],
    /// Highest jerks of joints.
    pub(crate) joint_jerk: [f64; MAX_JOINTS],
    /// Lowest positions of axes.
    pub(crate) axis_min: Pose,
    /// Highest positions of axes.
    pub(crate) axis_max: Pose,
    /// Highest velocities of axes.
    pub(crate) axis_velocity: Pose,
    /// Highest accelerations of axes.
    pub(crate) axis_acceleration: Pose,
    /// Highest jerks of axes.
    pub(crate) axis_jerk: Pose,
    /// Highest velocity along the path.
    pub(crate) path_velocity: f64,
    /// Highest jerk along the path.
    pub(crate) path_jerk: f64,
    /// Highest feed override for which the path is planned.
    pub(crate) max_override: f64,
    /// Length of the exact tolerance.
    pub(crate) exact_tolerance: f64,
    /// True if the moves follow a spindle.
    pub(crate) is_bound: bool,
    /// Distance by which a tap may overrun its depth and its start; 0 without a tap.
    pub(crate) overrun: f64,
}

impl PathSetup {
    /// Setup of a machine without limits, at zero.
    pub(crate) const NONE: Self = Self {
        generation: 0,
        period: 1e-3,
        start: [0.0; 9],
        places: [0.0; MAX_JOINTS],
        joint_active: [false; MAX_JOINTS],
        joint_min: [f64::NEG_INFINITY; MAX_JOINTS],
        joint_max: [f64::INFINITY; MAX_JOINTS],
        joint_velocity: [f64::INFINITY; MAX_JOINTS],
        joint_acceleration: [f64::INFINITY; MAX_JOINTS],
        joint_jerk: [f64::INFINITY; MAX_JOINTS],
        axis_min: [f64::NEG_INFINITY; 9],
        axis_max: [f64::INFINITY; 9],
        axis_velocity: [f64::INFINITY; 9],
        axis_acceleration: [f64::INFINITY; 9],
        axis_jerk: [f64::INFINITY; 9],
        path_velocity: f64::INFINITY,
        path_jerk: f64::INFINITY,
        max_override: 1.0,
        exact_tolerance: 2e-3,
        is_bound: false,
        overrun: 0.0,
    };
}
