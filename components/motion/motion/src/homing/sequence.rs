//! Realtime. The joints that are being homed, in their sequence.

use crate::{
    commands::{command::Joints, config::HomeConfig, refusal::Refusal},
    homing::error::{HomingError, SHARED},
    homing::one_joint,
    joint::Joint,
};
use hal_component::TicketHandle;

/// Joints that are being homed.
#[derive(Debug)]
pub(crate) struct HomingSequence {
    /// Joints that are homing now.
    now: Joints,
    /// Joints that follow later.
    later: Joints,
    ticket: TicketHandle,
}

/// Progress of a homing sequence.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Progress {
    UnderWay,
    Done,
    /// A joint could not be homed.
    Failed(usize, HomingError),
}

impl HomingSequence {
    /// Begins to home the joints of a set; the ticket is done when all are homed.
    pub(crate) fn begin(joints: &mut [Joint], set: Joints, ticket: TicketHandle) -> Self {
        let mut sequence = Self { now: 0, later: set, ticket };
        sequence.next_joints(joints);
        sequence
    }

    pub(crate) fn done(self) {
        self.ticket.done();
    }

    pub(crate) fn fail(self, why: &'static str) {
        self.ticket.fail(why);
    }

    /// Starts the next joints in the sequence; returns false if there are none.
    fn next_joints(&mut self, joints: &mut [Joint]) -> bool {
        let turn = |c: &HomeConfig| c.sequence.unsigned_abs();
        let waiting = joints.iter().enumerate().filter(|(n, _)| has(self.later, *n));
        let Some(first) = waiting.map(|(_, j)| turn(&j.config.home)).min() else { return false };
        self.now = 0;
        for (n, joint) in joints.iter_mut().enumerate() {
            if has(self.later, n) && turn(&joint.config.home) == first {
                joint.free.stop("homing began", None);
                joint.homing.begin();
                self.now |= 1 << n;
            }
        }
        self.later &= !self.now;
        true
    }

    /// Runs one cycle of all joints that are being homed.
    pub(crate) fn cycle(&mut self, joints: &mut [Joint], dt: f64) -> Progress {
        let now = self.now;
        let is_together = |n: usize, c: &HomeConfig| has(now, n) && c.sequence < 0;
        let mut together =
            joints.iter().enumerate().filter(|(n, j)| is_together(*n, &j.config.home));
        let ready = together.all(|(_, j)| j.homing.is_at_final_move());
        for (n, joint) in joints.iter_mut().enumerate().filter(|(n, _)| has(now, *n)) {
            let may_finish = ready || !is_together(n, &joint.config.home);
            if let Err(why) = one_joint::cycle(joint, dt, may_finish) {
                return Progress::Failed(n, why);
            }
        }
        let is_over = |(n, j): (usize, &Joint)| !has(now, n) || !j.homing.is_under_way();
        if joints.iter().enumerate().all(is_over) && !self.next_joints(joints) {
            Progress::Done
        } else {
            Progress::UnderWay
        }
    }
}

/// Returns the set, with all joints that are homed together with one of them.
pub(crate) fn with_partners(joints: &[Joint], set: Joints) -> Joints {
    let sequence = |n: usize| joints.get(n).map_or(0, |j| j.config.home.sequence);
    let together = |n: &usize| {
        let own = sequence(*n);
        own < 0 && (0..joints.len()).any(|m| has(set, m) && sequence(m) == own)
    };
    let active = |n: &usize| joints.get(*n).is_some_and(|j| j.active);
    (0..joints.len()).filter(active).filter(together).fold(set, |set, n| set | 1 << n)
}

/// Refuses a set with a joint that cannot be homed.
pub(crate) fn check(joints: &[Joint], set: Joints) -> Result<(), Refusal> {
    for (n, joint) in joints.iter().enumerate().filter(|(n, _)| has(set, *n)) {
        if let Some(why) = cannot(&joint.config.home, joint.inputs.at_home, joint.lock.exists) {
            return Err(Refusal::joint(why.0, why.1, n));
        }
    }
    Ok(())
}

/// Returns whether a set contains a joint.
pub(crate) const fn has(set: Joints, n: usize) -> bool {
    set >> n & 1 == 1
}

/// Returns the reasons, for the ticket and for the operator, why a joint cannot be homed with its configuration.
fn cannot(c: &HomeConfig, is_on: bool, has_lock: bool) -> Option<(&'static str, &'static str)> {
    if c.search_vel != 0.0 && c.latch_vel == 0.0 {
        return Some((
            "cannot home: home-search-vel needs a home-latch-vel that is not 0",
            "cannot home joint {}: home-search-vel needs a home-latch-vel that is not 0",
        ));
    }
    if c.search_vel == 0.0 && c.latch_vel != 0.0 && !c.use_index {
        return Some((
            "cannot home: home-latch-vel needs a home-search-vel that is not 0, or home-use-index",
            "cannot home joint {}: home-latch-vel needs a home-search-vel that is not 0, or \
             home-use-index",
        ));
    }
    if c.is_shared && is_on {
        return Some(SHARED);
    }
    if c.is_locking && !has_lock {
        return Some((
            "cannot home: locking-indexer needs the joint in unlock_joints_mask",
            "cannot home joint {}: locking-indexer needs the joint in unlock_joints_mask",
        ));
    }
    None
}
