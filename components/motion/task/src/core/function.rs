//! Functions in Python that a program calls: their steps, which the job does not wait for at rest.

use super::{Core, READ_AHEAD, Reading};
use crate::outside::Outside;
use hal_gcode::{Answer, Request};
use hal_remap::Progress;

impl Core {
    /// Follows the function that the interpreter has called. Returns true if it has made a step.
    pub(super) fn step_function(&mut self, out: &mut impl Outside) -> bool {
        let has_room = self.queue.len() < READ_AHEAD;
        let Some(job) = self.job.as_mut().filter(|_| has_room) else { return false };
        if !matches!(job.reading, Reading::Asked(Request::Function { .. })) {
            return false;
        }
        let begun = match job.is_stepping_function {
            true => Ok(()),
            false => out.begin_function(&self.interpreter.state, &self.world),
        };
        job.is_stepping_function = true;
        let answer = match begun {
            Err(why) => Answer::Failed(why.into()),
            Ok(()) => match out.function() {
                Progress::Pending => return false,
                Progress::Step(reply) => Answer::Function(reply),
                Progress::Failed(why) => Answer::Failed(why.into()),
            },
        };
        job.is_stepping_function = false;
        self.keep_answer(&answer, out);
        let mut calls = Vec::new();
        let step = self.interpreter.answer(&answer, &self.world, &mut calls);
        self.keeping.enter(&self.interpreter.state);
        self.take_line(step, calls);
        true
    }
}
