//! Ownership of motion: the token and its claim, and the orders of the owner.

use super::{Core, Interpreting, MAX_KNOWN, Machine, MotionEnd, MotionToken};

impl Machine {
    /// Forgets orders that have ended well and that the core does not ask for.
    pub(super) fn forget_orders(&mut self) {
        if self.orders.len() > MAX_KNOWN {
            let motion = &self.motion;
            self.orders.retain(|_, id| {
                !matches!(motion.poll(*id), MotionEnd::Done | MotionEnd::Forgotten)
            });
        }
    }

    /// Returns the proof of ownership; without one, asks for it.
    pub(super) fn token(&mut self) -> Option<MotionToken> {
        if self.token.is_none() {
            self.token = self.motion.acquire("task").ok();
        }
        self.token
    }

    /// Forgets a proof of ownership that is void, and the claim that ended with it.
    pub(super) fn lose_token(&mut self) {
        (self.token, self.claimed) = (None, false);
    }

    /// Keeps others from moving while a job runs; a paused one lets an operator jog.
    pub(in crate::worker) fn claim(&mut self, core: &Core) {
        let wanted = core.has_work() && core.interpreting() != Interpreting::Paused;
        if wanted != self.claimed
            && let Some(token) = self.token()
        {
            if self.motion.claim(token, wanted) {
                self.claimed = wanted;
            } else {
                self.lose_token();
            }
        }
    }
}
