//! The fake machine as the outside of the core.

use super::*;
use crate::{error::UserProgramError, outside::Rights};
use hal_component::StopEpoch;
use hal_gcode::{Environment, State};

impl Outside for Fake {
    fn now(&self) -> f64 {
        self.now
    }
    fn motion(&self) -> MotionState {
        self.motion
    }
    fn io(&self) -> IoState {
        self.io
    }
    fn epoch(&self) -> StopEpoch {
        self.motion.epoch
    }
    fn order(&mut self, order: &Order, given: StopEpoch) -> Result<u64, Refusal> {
        if given.is_stopped_by(self.motion.epoch) {
            return Err(Refusal::Why("a stop has come meanwhile".into()));
        }
        match order {
            Order::Abort | Order::Disable => self.motion.epoch.stops += 1,
            Order::Pause => self.motion.epoch.pauses += 1,
            _ => {}
        }
        if let Some(refusal) = self.refuse.take() {
            return Err(refusal);
        }
        self.next += 1;
        let id = self.next;
        self.log.push(match order {
            Order::Move(m) => {
                let [x, y, z, ..] = m.to;
                let kind = match m.shape {
                    Shape::Line => "line",
                    Shape::Arc { .. } => "arc",
                    Shape::Probe { .. } => "probe",
                    Shape::Tap { .. } => "tap",
                };
                format!("{}: {kind} {x} {y} {z}", m.line)
            }
            other => format!("{other:?}"),
        });
        match order {
            Order::Move(m) => {
                let from = self.moves.back().map_or(self.now, |(_, _, end)| *end);
                self.moves.push_back((id, *m, from + self.move_time));
                self.ends.insert(id, Progress::Pending);
                (self.motion.in_position, self.motion.queue) = (false, 1);
            }
            Order::Abort => {
                for (id, ..) in self.moves.drain(..) {
                    self.ends.insert(id, Progress::Failed("aborted".to_owned()));
                }
                self.paused = false;
                (self.motion.in_position, self.motion.queue) = (true, 0);
                self.ends.insert(id, Progress::Done);
            }
            other => {
                match other {
                    Order::Pause => self.paused = true,
                    Order::Resume => self.paused = false,
                    Order::FeedScale { feed, rapid } => {
                        let motion = &mut self.motion;
                        motion.feed_override = feed.unwrap_or(motion.feed_override);
                        motion.rapid_override = rapid.unwrap_or(motion.rapid_override);
                    }
                    Order::SpindleScale { spindle, scale } => {
                        self.motion.spindle_override[usize::from(*spindle)] = *scale;
                    }
                    Order::Enable => self.motion.enabled = true,
                    Order::Disable => {
                        self.motion.enabled = false;
                        for (id, ..) in self.moves.drain(..) {
                            self.ends.insert(id, Progress::Failed("off".to_owned()));
                        }
                        (self.motion.in_position, self.motion.queue) = (true, 0);
                    }
                    _ => {}
                }
                self.ends.insert(id, Progress::Done);
            }
        }
        Ok(id)
    }
    fn ordered(&mut self, id: u64) -> Progress {
        self.ends.get(&id).cloned().unwrap_or(Progress::Done)
    }
    fn request(&mut self, request: IoRequest) -> Option<u64> {
        self.next += 1;
        let id = self.next;
        self.log.push(format!("{request:?}"));
        match request {
            IoRequest::Prepare { .. } | IoRequest::Change => {
                if request == IoRequest::Change && self.io.tool != self.io.prepared {
                    let record = self.spindles.as_ref().unwrap().last();
                    assert!(
                        matches!(record, Some(Spindle::Changing { .. })),
                        "asked before it is written"
                    );
                }
                self.ends.insert(id, Progress::Pending);
                self.changer.push_back((id, request));
                return Some(id);
            }
            IoRequest::Abort => {
                for (id, request) in self.changer.drain(..) {
                    if request == IoRequest::Change {
                        self.io.tool = hal_job::spindle::UNKNOWN;
                    }
                    self.ends.insert(id, Progress::Failed("aborted".to_owned()));
                }
            }
            IoRequest::SetTool { tool, .. } => self.io.tool = tool,
            IoRequest::Estop => self.io.estop.commanded = true,
            _ => {}
        }
        self.ends.insert(id, Progress::Done);
        Some(id)
    }
    fn requested(&mut self, id: u64) -> Progress {
        self.ordered(id)
    }
    fn ask_value(&mut self, name: &str) -> u64 {
        self.next += 1;
        self.log.push(format!("value of {name}"));
        self.questions.insert(self.next, (self.now, name.to_owned()));
        self.next
    }
    fn take_value(&mut self, question: u64) -> Option<Option<f64>> {
        // The control side answers in a later cycle.
        let (asked, name) = self.questions.get(&question)?.clone();
        if asked == self.now {
            return None;
        }
        self.questions.remove(&question);
        Some(self.hal.get(&name).copied())
    }
    fn begin_program(
        &mut self,
        code: u16,
        p: f64,
        q: f64,
        rights: Rights,
    ) -> Result<(), UserProgramError> {
        let rights = if rights == Rights::Owner { "" } else { " from afar" };
        self.log.push(format!("M{code} {p} {q}{rights}"));
        self.program = Progress::Pending;
        Ok(())
    }
    fn program(&mut self) -> Progress {
        self.program.clone()
    }
    fn end_program(&mut self) {
        self.program = Progress::Done;
    }
    fn begin_function(&mut self, state: &State, env: &dyn Environment) -> Result<(), String> {
        self.functions.as_mut().ok_or("no functions")?.begin(state, env)
    }
    fn function(&mut self) -> hal_remap::Progress {
        self.looks += 1;
        let functions = self.functions.as_mut().unwrap();
        loop {
            let wait = if self.is_patient { 100 } else { 1 };
            match functions.progress(std::time::Duration::from_millis(wait)) {
                hal_remap::Progress::Pending if self.is_patient => {}
                end => return end,
            }
        }
    }
    fn end_functions(&mut self) {
        if let Some(functions) = self.functions.as_mut().filter(|f| f.is_busy()) {
            functions.end();
        }
    }
    fn say(&mut self, level: Level, text: &str) {
        self.levels.push(level);
        self.messages.push(text.to_owned());
    }
    fn finish(&mut self, ticket: Ticket, result: Result<(), String>) {
        assert!(self.results.insert(ticket.0, result).is_none(), "a ticket ends once");
    }
    fn save_parameters(&mut self, numbered: &Numbered) -> Result<(), String> {
        if self.is_unwritable {
            return Err("v.var: No space left on device".to_owned());
        }
        self.saves += 1;
        self.saved = Some(numbered.get(5221));
        Ok(())
    }
    fn journal(&mut self, record: &Record) -> Result<(), String> {
        if self.disk_is_full {
            return Err("job.journal: No space left on device".to_owned());
        }
        if matches!(record, Record::Begin(_)) {
            self.journal.clear();
        }
        self.journal.push_str(&record.line());
        Ok(())
    }
    fn read_journal(&self) -> Result<Vec<u8>, String> {
        Ok(self.journal.clone().into_bytes())
    }
    fn save_tools(&mut self, tools: &ToolTable) -> Result<(), String> {
        self.tables.push(tools.print());
        Ok(())
    }
    fn file(&mut self, action: &FileAction, _: Option<&Path>) -> Result<(), String> {
        if let FileAction::Open { name, .. } = action
            && &**name == "full"
        {
            return Err("full: No space left on device".to_owned());
        }
        self.lines.push(format!("{action:?}"));
        Ok(())
    }
    fn save_spindle(&mut self, before: Spindle, now: Spindle) -> Result<(), String> {
        assert_ne!(before, now, "each record is written once");
        let records = self.spindles.as_mut().ok_or("no space left on device")?;
        records.push(now);
        Ok(())
    }
}
