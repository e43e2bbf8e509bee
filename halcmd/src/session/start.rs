//! The start of an instance: requests that come before time passes, and the end of its scripts.

use super::{Error, Outcome, Request, Session};

impl Session<'_> {
    /// Adds a request that is sent before the threads are first started or the clock is first moved.
    pub fn before_start(&mut self, request: Request) {
        self.before_start.push(request);
    }

    /// Sends the requests of [`Self::before_start`] that have not been sent yet.
    pub(crate) fn send_pending(&mut self) -> Result<(), Error> {
        let pending = core::mem::take(&mut self.before_start);
        pending.into_iter().try_for_each(|request| self.call(request).map(|_| ()))
    }

    /// Ends the start, whose scripts have this outcome. If it is good, the requests that wait are sent.
    pub fn settle(&mut self, outcome: Outcome) -> Outcome {
        self.link.set_starting(false);
        if outcome != Outcome::Good {
            return outcome;
        }
        let result = self.send_pending();
        self.outcome_of(result)
    }
}
