//! The end of a job: complete, failed or aborted.

use super::{Core, EndedBy, Ending, Job, Origin, Reading};
use crate::outside::{FileAction, FileKind, Level, Order, Outside, Progress, Refusal};
use hal_component::{IoRequest, StopEpoch, Wait};
use hal_gcode::{
    canon::Direction,
    parameters::number,
    state::{Compensation, Cycle},
};
use std::collections::VecDeque;

impl Core {
    /// Begins a job, which the interpreter has loaded.
    pub(super) fn begin_job(
        &mut self,
        is_program: bool,
        ticket: Option<super::Ticket>,
        given: StopEpoch,
        stepping: bool,
        out: &mut impl Outside,
    ) {
        self.forget_dry_run("another job has begun", out);
        self.leave_entry();
        self.job = Some(Job {
            is_program,
            reading: Reading::Lines,
            ticket,
            given,
            paused: false,
            why_paused: Wait::Pause,
            stepping: stepping.then_some(None),
            held: false,
            input: 0.0,
            questions: Vec::new(),
            user_code: Ok(()),
            is_stepping_function: false,
            began: out.now(),
        });
        self.current = None;
        self.job_time = 0.0;
        self.checking = super::Checking::default();
        self.last_tag = None;
        self.undo.clear();
        drop(self.interpreter.state.numbered.take_changes());
    }

    /// Ends a job whose last step is done.
    pub(super) fn complete(&mut self, out: &mut impl Outside) {
        if let Err(why) = self.try_to_save(out) {
            return self.fail(&why, out);
        }
        self.note_end(EndedBy::End);
        self.keep_end(out);
        self.interpreter.state.rs274d.before = None;
        self.leave_entry();
        self.checking = super::Checking::default();
        let Some(job) = self.job.take() else { return };
        if job.is_program {
            self.close_files(out);
        }
        self.current = None;
        self.jobs.0 = self.jobs.0.wrapping_add(1);
        if let Some(ticket) = job.ticket {
            out.finish(ticket, Ok(()));
        }
    }

    /// Ends the job with an error, at the line of the step in execution.
    pub(super) fn fail(&mut self, why: &str, out: &mut impl Outside) {
        let is_program = self.job.as_ref().is_some_and(|j| j.is_program);
        let text = match &self.current {
            // Errors of the interpreter name their place.
            Some(Origin { line, tag, .. }) if is_program && !why.starts_with(&*tag.file) => {
                format!("{}:{line}: {why}", tag.file)
            }
            _ => why.to_owned(),
        };
        self.tell(Level::Error, &text, out);
        self.note_end(EndedBy::Error);
        self.end_job(&text, out);
    }

    /// Stops everything: motion, the job, lines of MDI that wait, coolant and spindles.
    pub(super) fn end_job(&mut self, why: &str, out: &mut impl Outside) {
        self.end_all(why, false, out);
    }

    /// Ends everything that was given before a stop, if motion `is_stopped` already, or everything.
    pub(super) fn end_all(&mut self, why: &str, is_stopped: bool, out: &mut impl Outside) {
        self.keep_break(out);
        self.leave_entry();
        let job = self.job.take();
        let now = out.epoch();
        let given = job.as_ref().map(|job| job.given).or_else(|| self.checking.given());
        // Motion that is stopped needs no second stop, which would end what is ordered since the first.
        let is_stopped = is_stopped || given.is_some_and(|given| given.is_stopped_by(now));
        if job.is_some() {
            self.jobs.0 = self.jobs.0.wrapping_add(1);
            self.jobs.1 = self.jobs.1.wrapping_add(1);
        }
        self.forget_dry_run(why, out);
        self.forget_check(why, out);
        let tickets = job.and_then(|j| j.ticket).into_iter();
        let (ended, later) = core::mem::take(&mut self.mdi)
            .into_iter()
            .partition::<VecDeque<_>, _>(|line| !is_stopped || line.given.is_stopped_by(now));
        self.mdi = later;
        for ticket in tickets.chain(ended.into_iter().map(|line| line.ticket)) {
            out.finish(ticket, Err(why.to_owned()));
        }
        let flight = self.flight.front().map(|f| f.origin.clone());
        let origin = flight.or_else(|| self.current.take());
        let origin = origin.or_else(|| self.ending.take().and_then(|e| e.origin));
        self.current = None;
        self.queue.clear();
        self.flight.clear();
        self.waiting = None;
        self.preparing = None;
        self.at_speed_since = None;
        self.surface.fill(None);
        out.end_program();
        out.end_functions();
        self.close_files(out);
        // The machine is in e-stop or iocontrol is full: then its outputs are off, or a later abort follows.
        let sent = out.request(IoRequest::Abort).is_some();
        self.ending = Some(Ending { is_stopped, order: None, sent, origin });
        self.finish_ending(out);
    }

    /// Follows an abort, and brings the interpreter to the state of the machine once it is at rest.
    pub(super) fn finish_ending(&mut self, out: &mut impl Outside) {
        let Some(ending) = &mut self.ending else { return };
        if !ending.sent {
            ending.sent = out.request(IoRequest::Abort).is_some();
        }
        let ended = match ending.order {
            None if ending.is_stopped => true,
            Some(id) => out.ordered(id) != Progress::Pending,
            None => match out.order(&Order::Abort, out.epoch()) {
                Ok(id) => {
                    ending.order = Some(id);
                    // The task's own stop tells it nothing.
                    self.seen = out.epoch();
                    false
                }
                Err(Refusal::Full) => false,
                // Motion is off.
                Err(Refusal::Why(_)) => true,
            },
        };
        let motion = out.motion();
        let is_off = !motion.enabled;
        if !(ended && ending.sent && (motion.in_position && motion.queue == 0 || is_off)) {
            return;
        }
        let origin = self.ending.take().and_then(|e| e.origin);
        self.keep_rest(out);
        self.reset(origin, out);
        self.save_parameters(out);
    }

    /// Sets the interpreter to the modal state and the parameters of the line that was in execution, at rest and
    /// without calls.
    fn reset(&mut self, origin: Option<Origin>, out: &mut impl Outside) {
        self.return_from_entry();
        let io = out.io();
        let tools = &self.world.machine.tools;
        let state = &mut self.interpreter.state;
        if let Some(Origin { tag, serial, .. }) = origin {
            self.undo.restore(serial, &mut state.numbered);
            state.modal = tag.modal.clone();
            state.frame = tag.frame;
            state.numbered.put(number::SYSTEM, f64::from(state.modal.system));
        }
        // The table has the entries that were executed.
        state.changed_tools.clear();
        state.levels.clear();
        state.pending = None;
        state.ended = true;
        state.compensation = Compensation::default();
        state.cycle = Cycle::default();
        for spindle in &mut state.modal.spindles {
            spindle.direction = Direction::Stopped;
        }
        (state.modal.mist, state.modal.flood) = (false, false);
        if state.tool.number != io.tool {
            state.tool = tools.find(io.tool).cloned().unwrap_or_default();
        }
        state.selected = (io.prepared != 0).then_some(io.prepared);
        self.interpreter.leave_program();
        self.take_over(out);
    }

    /// Makes interpreter and converter go on from the place of the machine.
    pub(super) fn take_over(&mut self, out: &impl Outside) {
        let motion = out.motion();
        self.synchronise(&motion);
        self.converter.restart(&self.interpreter.state, motion.pose);
    }

    /// Writes the parameter file.
    pub(super) fn try_to_save(&mut self, out: &mut impl Outside) -> Result<(), String> {
        let saved = out.save_parameters(&self.interpreter.state.numbered);
        self.is_unsaved = saved.is_err();
        saved
    }

    /// Writes the parameter file behind a job that has failed, and tells once that it cannot.
    fn save_parameters(&mut self, out: &mut impl Outside) {
        let is_known = self.is_unsaved;
        if let Err(why) = self.try_to_save(out)
            && !is_known
        {
            self.tell(Level::Error, &why, out);
        }
    }

    /// Closes the files of a program, which ends.
    fn close_files(&mut self, out: &mut impl Outside) {
        for kind in [FileKind::Log, FileKind::Probe] {
            if let Err(why) = out.file(&FileAction::Close(kind), None) {
                self.tell(Level::Error, &why, out);
            }
        }
    }
}
