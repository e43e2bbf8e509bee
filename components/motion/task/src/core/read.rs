//! Reading ahead: lines become steps, as far as the interpreter needs no answer.

use super::{Core, Entry, Origin, READ_AHEAD, Reading, Tag};
use crate::{
    convert::Action,
    outside::{FileAction, FileKind, MotionState, Outside},
};
use hal_component::Wait;
use hal_gcode::{
    Answer, Error, Request, Step,
    axis::{Axis, Position},
    parameters::number,
};
use std::sync::Arc;

impl Core {
    /// Reads one line if there is room for its steps. Returns false if there is nothing to read now.
    pub(super) fn read(&mut self) -> bool {
        let reads = self.job.as_ref().is_some_and(|j| j.reading == Reading::Lines);
        if !reads || self.queue.len() >= READ_AHEAD {
            return false;
        }
        if self.checking.pauses_before(self.interpreter.state.lines_run) {
            let line = self.interpreter.state.levels.last().map_or(0, |l| l.cursor.line + 1);
            let (tag, number) = (self.tag(), self.interpreter.state.lines_run);
            self.serial += 1;
            let origin = Origin { line, serial: self.serial, number, tag };
            self.queue.push_back(Entry { action: Action::Pause(Wait::Pause), origin });
        }
        let mut calls = Vec::new();
        let step = self.interpreter.next(&self.world, &mut calls);
        self.keeping.enter(&self.interpreter.state);
        self.take_line(step, calls);
        true
    }

    /// Answers the interpreter's question from the state of the machine. Returns false while the answer is not known.
    pub(super) fn answer(&mut self, request: &Request, out: &mut impl Outside) -> bool {
        let motion = out.motion();
        let Some(job) = self.job.as_mut() else { return false };
        let answer = match request {
            Request::Hal { names } => match super::values::answer(&mut job.questions, names, out) {
                Some(answer) => answer,
                None => return false,
            },
            Request::Probe => Answer::Probe {
                tripped_at: self.millimetres(if motion.probe_found {
                    motion.probe_measured
                } else {
                    motion.pose
                }),
                stopped_at: self.millimetres(motion.pose),
                tripped: motion.probe_found,
            },
            Request::ToolChange { .. } => {
                let moved = self.rules.change_position.is_some();
                Answer::ToolChange { position: moved.then(|| self.millimetres(motion.pose)) }
            }
            Request::Input { .. } => Answer::Input(job.input),
            // Its steps do not wait for the machine.
            Request::Function { .. } => return false,
            Request::Finish => Answer::Done,
            Request::UserCode { .. } => match &job.user_code {
                Ok(()) => Answer::Done,
                Err(why) => Answer::Failed(why.as_str().into()),
            },
        };
        self.keep_answer(&answer, out);
        let probed = matches!(answer, Answer::Probe { tripped: true, .. });
        let mut calls = Vec::new();
        let step = self.interpreter.answer(&answer, &self.world, &mut calls);
        self.keeping.enter(&self.interpreter.state);
        if probed && self.interpreter.state.probe_file {
            let line = self.probe_line();
            if let Err(why) = out.file(&FileAction::Line(FileKind::Probe, line), None) {
                self.fail(&why, out);
                return true;
            }
        }
        // The lines before are executed, and the answer is a fact.
        self.undo.clear();
        drop(self.interpreter.state.numbered.take_changes());
        self.take_line(step, calls);
        true
    }

    /// Returns the line of a probe file: the nine coordinates where the probe tripped, as parameters 5061 to 5069 have them.
    fn probe_line(&self) -> Box<str> {
        let numbered = &self.interpreter.state.numbered;
        let values: Vec<String> =
            (0..9).map(|n| format!("{:.6}", numbered.get(number::PROBE + n))).collect();
        values.join(" ").into()
    }

    pub(super) fn take_line(&mut self, step: Result<Step, Error>, calls: Vec<hal_gcode::Issued>) {
        self.serial += 1;
        let serial = self.serial;
        let tag = self.tag();
        let number = self.interpreter.state.lines_run.saturating_sub(1);
        let origin = |line| Origin { line, serial, number, tag: tag.clone() };
        let before = self.queue.len();
        let mut actions = Vec::new();
        for issued in calls {
            self.converter.convert(issued.call, issued.line, &mut actions);
            for action in actions.drain(..) {
                self.queue.push_back(Entry { action, origin: origin(issued.line) });
            }
        }
        let reading = match step {
            Ok(Step::Line) => Reading::Lines,
            Ok(Step::Ask(request)) => Reading::Asked(request),
            Ok(Step::Ended) => Reading::Ended,
            Err(error) => {
                // The lines before it are executed; the job then ends with the error.
                let action = Action::Refuse(error.to_string().into());
                self.queue.push_back(Entry { action, origin: origin(error.place.line) });
                Reading::Ended
            }
        };
        let changes = self.interpreter.state.numbered.take_changes();
        self.undo.add(serial, changes, self.queue.len() > before);
        if let Some(job) = &mut self.job {
            job.reading = reading;
        }
    }

    /// Returns the modal state behind the line that was read last.
    pub(super) fn tag(&mut self) -> Arc<Tag> {
        let state = &self.interpreter.state;
        let file = state.levels.last().map(|l| &*l.file).unwrap_or_default();
        if let Some(last) = &self.last_tag
            && last.modal == state.modal
            && last.frame == state.frame
            && &*last.file == file
        {
            return last.clone();
        }
        let tag =
            Arc::new(Tag { file: file.into(), modal: state.modal.clone(), frame: state.frame });
        self.last_tag = Some(tag.clone());
        tag
    }

    /// Returns a pose of motion in millimetres and degrees.
    fn millimetres(&self, pose: [f64; 9]) -> Position {
        let k = self.world.machine.settings.unit.millimetres();
        position(pose).scaled(k)
    }

    /// Sets the interpreter's position to that of the machine.
    pub(super) fn synchronise(&mut self, motion: &MotionState) {
        let at = self.millimetres(motion.pose);
        self.interpreter.synchronise(at);
    }
}

fn position(pose: [f64; 9]) -> Position {
    let mut out = Position::default();
    for (axis, value) in Axis::ALL.into_iter().zip(pose) {
        out[axis] = value;
    }
    out
}
