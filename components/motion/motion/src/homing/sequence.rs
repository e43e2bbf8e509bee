//! Realtime. Homing of several joints: their order, and the end of all.

use crate::{
    commands::command::{Joints, Mode},
    commands::config::HomeConfig,
    commands::refusal::Refusal,
    homing::one_joint,
    state::State,
};
use hal_component::TicketHandle;

/// Joints that are being homed.
#[derive(Debug)]
pub(crate) struct Round {
    /// Joints that are homing now.
    now: Joints,
    /// Joints that follow later.
    later: Joints,
    ticket: TicketHandle,
}

impl Round {
    pub(crate) fn fail(self, why: &'static str) {
        self.ticket.fail(why);
    }
}

impl State {
    /// Begins to home joints; the ticket is done when all are homed.
    pub(crate) fn home(&mut self, set: Joints, ticket: TicketHandle) -> Result<(), Refusal> {
        self.needs_enabled("cannot home: the machine is not enabled")?;
        if self.inputs.homing_inhibit {
            return Err(Refusal::new("homing denied by motion.homing-inhibit"));
        }
        if self.round.is_some() {
            return Err(Refusal::new("cannot home: homing is under way"));
        }
        let set = self.with_partners(self.wanted(set)?);
        for (n, joint) in self.joints.iter().enumerate().filter(|(n, _)| has(set, *n)) {
            if let Some(why) = cannot(&joint.config.home, joint.senses.at_home) {
                return Err(Refusal::joint(why.0, why.1, n));
            }
        }
        self.set_mode(Mode::Free)?;
        self.round = Some(Round { now: 0, later: set, ticket });
        self.next_joints();
        Ok(())
    }

    /// Returns the set, with all joints that are homed together with one of them.
    fn with_partners(&self, set: Joints) -> Joints {
        let sequence = |n: usize| self.joints.get(n).map_or(0, |j| j.config.home.sequence);
        let together = |n: &usize| {
            let own = sequence(*n);
            own < 0 && (0..self.joints.len()).any(|m| has(set, m) && sequence(m) == own)
        };
        let active = |n: &usize| self.joints.get(*n).is_some_and(|j| j.active);
        (0..self.joints.len()).filter(active).filter(together).fold(set, |set, n| set | 1 << n)
    }

    /// Starts the next joints in the sequence; returns false if there are none.
    fn next_joints(&mut self) -> bool {
        let Some(round) = &mut self.round else { return false };
        let turn = |c: &HomeConfig| c.sequence.unsigned_abs();
        let waiting = self.joints.iter().enumerate().filter(|(n, _)| has(round.later, *n));
        let Some(first) = waiting.map(|(_, j)| turn(&j.config.home)).min() else { return false };
        round.now = 0;
        for (n, joint) in self.joints.iter_mut().enumerate() {
            if has(round.later, n) && turn(&joint.config.home) == first {
                joint.free.stop("homing began", None);
                joint.homing.begin();
                round.now |= 1 << n;
            }
        }
        round.later &= !round.now;
        true
    }

    /// Runs one cycle of all joints that are being homed.
    pub(crate) fn homing_cycle(&mut self, dt: f64) {
        let Some(round) = &self.round else { return };
        let now = round.now;
        let is_together = |n: usize, c: &HomeConfig| has(now, n) && c.sequence < 0;
        let mut together =
            self.joints.iter().enumerate().filter(|(n, j)| is_together(*n, &j.config.home));
        let ready = together.all(|(_, j)| j.homing.is_at_final_move());
        for (n, joint) in self.joints.iter_mut().enumerate().filter(|(n, _)| has(now, *n)) {
            let may_finish = ready || !is_together(n, &joint.config.home);
            if let Err(why) = one_joint::cycle(joint, dt, may_finish) {
                self.say.error(why.say(), &[n as f64, f64::from(joint.homing.code())]);
                return self.end_homing(why.text());
            }
        }
        let is_over =
            |(n, j): (usize, &crate::joint::Joint)| !has(now, n) || !j.homing.is_under_way();
        if self.joints.iter().enumerate().all(is_over)
            && !self.next_joints()
            && let Some(round) = self.round.take()
        {
            round.ticket.done();
        }
    }

    /// Aborts homing, and brakes.
    pub(crate) fn end_homing(&mut self, why: &'static str) {
        for joint in self.joints.iter_mut().filter(|j| j.homing.is_under_way()) {
            joint.homing.abort();
            joint.free.stop(why, None);
        }
        if let Some(round) = self.round.take() {
            round.fail(why);
        }
    }

    pub(crate) fn unhome(&mut self, set: Joints) -> Result<(), Refusal> {
        let set = self.wanted(set)?;
        if !self.is_idle() {
            return Err(Refusal::new("cannot unhome while the machine moves"));
        }
        if self.enabled {
            self.set_mode(Mode::Free)?;
        }
        for (n, joint) in self.joints.iter_mut().enumerate() {
            if has(set, n) {
                joint.homing.homed = false;
            }
        }
        Ok(())
    }
}

const fn has(set: Joints, n: usize) -> bool {
    set >> n & 1 == 1
}

/// Returns the reasons, for the ticket and for the operator, why a joint cannot be homed with its configuration.
fn cannot(c: &HomeConfig, is_on: bool) -> Option<(&'static str, &'static str)> {
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
        return Some((
            "Cannot home while shared home switch is closed",
            "Cannot home while shared home switch is closed j={}",
        ));
    }
    None
}
