//! Execution: steps go to motion and iocontrol in their order.

use super::{Core, Entry, Flight, Reading, Surface, Waiting, overrides::Scale};
use crate::{
    convert::Action,
    outside::{Level, Order, Outside, Refusal, Rights},
};
use hal_component::{IoRequest, Wait};
use hal_gcode::{Call, tool::Tool};

/// Number of moves that motion may hold.
const MAX_FLIGHT: usize = 1000;
/// Top speed in calls of G96 without D.
const NO_TOP_SPEED: f64 = 1e30;
/// Difference of surface speeds' turns, as a share, from which a new speed is sent.
const SPEED_STEP: f64 = 0.001;

impl Core {
    /// Does one thing for the job. Returns false if nothing can be done now.
    pub(super) fn pump(&mut self, out: &mut impl Outside) -> bool {
        if self.job.is_none() || !self.land(out) || !self.prepared(out) {
            return false;
        }
        self.watch_speed(out);
        if self.ending.is_some() || !self.wait(out) {
            return false;
        }
        let Some(job) = self.job.as_ref() else { return false };
        if job.paused {
            return false;
        }
        if self.read() {
            return true;
        }
        let has_done = match self.queue.front().cloned() {
            Some(entry) => self.admits(&entry, out) && self.execute(entry, out),
            None => self.pause_or_end(out),
        };
        // The worker waits for a function, so all that can be sent goes first.
        has_done || self.step_function(out)
    }

    /// Returns whether the step may begin now: in single steps, each line waits for the operator.
    fn admits(&mut self, entry: &Entry, out: &mut impl Outside) -> bool {
        let at_rest = self.is_at_rest(out);
        let Some(job) = &mut self.job else { return false };
        match job.stepping {
            None => true,
            Some(None) => {
                job.stepping = Some(Some(entry.origin.serial));
                true
            }
            Some(Some(serial)) if serial == entry.origin.serial => true,
            Some(Some(_)) => {
                if at_rest {
                    (job.stepping, job.paused, job.why_paused) = (None, true, Wait::Step);
                }
                false
            }
        }
    }

    /// Returns whether motion has finished everything that it was sent.
    pub(super) fn is_at_rest(&self, out: &impl Outside) -> bool {
        let motion = out.motion();
        self.flight.is_empty() && motion.in_position && motion.queue == 0
    }

    /// Does what is due behind the last step: answers the interpreter, or ends the job.
    fn pause_or_end(&mut self, out: &mut impl Outside) -> bool {
        if !self.is_at_rest(out) || self.preparing.is_some() {
            return false;
        }
        match self.job.as_ref().map(|j| j.reading.clone()) {
            Some(Reading::Asked(request)) => self.answer(&request, out),
            Some(Reading::Ended) => {
                self.complete(out);
                false
            }
            Some(Reading::Lines) | None => false,
        }
    }

    /// Executes the first step. Returns false if it cannot begin yet.
    fn execute(&mut self, entry: Entry, out: &mut impl Outside) -> bool {
        if let Action::Path(order) = &entry.action {
            if self.flight.len() >= MAX_FLIGHT {
                return false;
            }
            return match out.order(order, self.job_epoch(out)) {
                Ok(id) => {
                    self.flight.push_back(Flight { id, origin: entry.origin });
                    self.queue.pop_front();
                    true
                }
                Err(Refusal::Why(why)) if self.flight.is_empty() => {
                    self.current = Some(entry.origin);
                    self.fail(&why, out);
                    false
                }
                // The moves before a refused one end first.
                Err(Refusal::Full | Refusal::Why(_)) => false,
            };
        }
        let joins = matches!(entry.action, Action::Message(_) | Action::Prepare(_))
            || matches!(entry.action, Action::Oriented { .. });
        if !joins && !self.is_at_rest(out) {
            return false;
        }
        // A change needs the tool, and another tool is prepared after the one before.
        let needs_io = matches!(
            entry.action,
            Action::Prepare(_) | Action::Change(_) | Action::SetTool(_) | Action::End
        );
        if needs_io && self.preparing.is_some() {
            return false;
        }
        let serial = entry.origin.serial;
        let before = self.current.replace(entry.origin);
        match self.begin(&entry.action, out) {
            Ok(true) => {
                self.queue.pop_front();
                if self.flight.is_empty() {
                    self.undo.executed(serial);
                }
                true
            }
            Ok(false) => {
                self.current = before;
                false
            }
            Err(why) => {
                self.fail(&why, out);
                false
            }
        }
    }

    /// Begins a step. Returns false if nothing takes it now.
    fn begin(&mut self, action: &Action, out: &mut impl Outside) -> Result<bool, String> {
        match action {
            Action::Path(_) => {}
            Action::Rest(order) => {
                if let Order::Spindle { spindle, .. } = order {
                    self.take_stopped_spindle(*spindle, out);
                }
                match out.order(order, self.job_epoch(out)) {
                    Ok(id) if matches!(order, Order::Orient { .. }) => {
                        // A following wait, and everything else at rest, waits for it.
                        let origin = self.current.clone().ok_or("no line")?;
                        self.flight.push_back(Flight { id, origin });
                    }
                    Ok(id) => self.waiting = Some(Waiting::Order(id)),
                    Err(Refusal::Full) => return Ok(false),
                    Err(Refusal::Why(why)) => return Err(why.into()),
                }
            }
            Action::Dwell(seconds) => {
                self.waiting = Some(Waiting::Dwell { until: out.now() + seconds });
            }
            Action::Prepare(tool) => {
                let request = self.prepare(*tool);
                let Some(id) = out.request(request) else { return Ok(false) };
                self.preparing = Some(id);
            }
            Action::Change(tool) => return self.begin_change(*tool, out),
            Action::SetTool(tool) => {
                self.take_tool(*tool, out)?;
                let pocket = self.world.machine.tools.find(*tool).map_or(0, |t| t.pocket);
                return Ok(self.ask_io(IoRequest::SetTool { tool: *tool, pocket }, out));
            }
            Action::Coolant { mist, flood } => {
                let request = IoRequest::Coolant { mist: *mist, flood: *flood, lube: None };
                return Ok(self.ask_io(request, out));
            }
            Action::ToolEntry(call) => self.set_tool_entry(call, out)?,
            Action::ReloadTools => {
                self.world.machine.reload_tools()?;
                self.interpreter.state.changed_tools.clear();
            }
            Action::Input { index, analog, mode, timeout } => {
                let before = *index < 64 && out.motion().digital_in >> index & 1 != 0;
                let (index, analog, mode) = (*index, *analog, *mode);
                let until = out.now() + timeout;
                self.waiting = Some(Waiting::Input { index, analog, mode, until, before });
            }
            Action::Oriented { timeout } => {
                self.waiting = Some(Waiting::Oriented { until: out.now() + timeout });
            }
            Action::SurfaceSpeed { spindle, speed } => {
                let unbounded = speed.is_some_and(|(_, top)| top >= NO_TOP_SPEED);
                let has_top = self.rules.has_top_speed.get(usize::from(*spindle));
                if unbounded && has_top != Some(&true) {
                    return Err("G96 needs D, its top speed: the INI file has none".into());
                }
                self.take_stopped_spindle(*spindle, out);
                if let Some(slot) = self.surface.get_mut(usize::from(*spindle)) {
                    *slot = speed.map(|(speed, top)| Surface { speed, top, sent: f64::NAN });
                }
                self.follow_surface(out);
            }
            Action::FeedOverride(on) => {
                let before = core::mem::replace(&mut self.feed.counts, *on);
                let sent = self.send_scale(Scale::FeedAndRapid, out);
                // Without the order, motion's override is still that of before.
                if sent != Ok(true) {
                    self.feed.counts = before;
                }
                return sent;
            }
            Action::SpeedOverride { spindle, on } => {
                let before = self.spindle_counts;
                if let Some(counts) = self.spindle_counts.get_mut(usize::from(*spindle)) {
                    *counts = *on;
                }
                let sent = self.send_scale(Scale::Spindle(*spindle), out);
                if sent != Ok(true) {
                    self.spindle_counts = before;
                }
                return sent;
            }
            Action::UserCode { code, p, q } => {
                let rights = match self.is_job_from_afar && !self.rules.has_full_codes {
                    true => Rights::FromAfar,
                    false => Rights::Owner,
                };
                out.begin_program(*code, *p, *q, rights).map_err(|why| why.to_string())?;
                self.waiting = Some(Waiting::Program(*code));
            }
            Action::Pause(why) => {
                if (*why != Wait::OptionalStop || self.optional_stop)
                    && let Some(job) = &mut self.job
                {
                    (job.paused, job.why_paused) = (true, *why);
                }
            }
            Action::Message(text) => self.tell(Level::Notice, text, out),
            Action::End => self.try_to_save(out)?,
            Action::File(file) => out.file(file, self.program.as_deref())?,
            Action::Refuse(why) => return Err(why.to_string()),
        }
        Ok(true)
    }

    fn ask_io(&mut self, request: IoRequest, out: &mut impl Outside) -> bool {
        self.waiting = out.request(request).map(Waiting::Io);
        self.waiting.is_some()
    }

    fn prepare(&self, tool: i32) -> IoRequest {
        let tools = &self.world.machine.tools.tools;
        let found = tools.iter().position(|t| t.number == tool);
        let pocket = found.and_then(|at| tools.get(at)).map_or(0, |t| t.pocket);
        let random = self.world.machine.settings.random_changer;
        // A fixed changer numbers its places from 1 in the table's order.
        let index = found.and_then(|at| i32::try_from(at).ok()).unwrap_or(0);
        let index = if random { pocket } else { index + i32::from(found.is_some()) };
        IoRequest::Prepare { tool, pocket, index }
    }

    fn set_tool_entry(&mut self, call: &Call, out: &mut impl Outside) -> Result<(), String> {
        let Call::SetToolTableEntry { pocket, tool, offset, diameter, front, back, orientation } =
            call
        else {
            return Ok(());
        };
        // A table that somebody has edited stays as it is, in the file and here.
        self.world.machine.check_table()?;
        let tools = &mut self.world.machine.tools;
        let known = tools.find(*tool).cloned().unwrap_or_default();
        let new = Tool {
            number: *tool,
            pocket: i32::try_from(*pocket).unwrap_or(0),
            offset: *offset,
            diameter: *diameter,
            front: *front,
            back: *back,
            orientation: *orientation,
            remark: known.remark,
        };
        match tools.tools.iter_mut().find(|t| t.number == *tool) {
            Some(slot) => *slot = new,
            None => tools.tools.push(new),
        }
        self.save_tools(out)
    }

    /// Keeps spindles at constant surface speed: their turns depend on the distance of X from the axis.
    pub(super) fn follow_surface(&mut self, out: &mut impl Outside) {
        let given = self.job_epoch(out);
        let motion = out.motion();
        let ([x, ..], stopped) = (motion.pose, motion.spindles_stopped);
        let frame = &self.converter.frame;
        let offset = frame.g5x.x + frame.tool.x + frame.g92.x;
        let radius = (x - offset * frame.unit.to(self.world.machine.settings.unit)).abs();
        for (spindle, slot) in (0u8..).zip(&mut self.surface) {
            let Some(surface) = slot else { continue };
            if stopped >> spindle & 1 != 0 {
                // Only a resume turns it again.
                surface.sent = f64::NAN;
                continue;
            }
            let turns = surface.speed.abs() / (core::f64::consts::TAU * radius);
            // S0 on the axis has no quotient: the spindle rests.
            let turns = if turns.is_nan() { 0.0 } else { turns.min(surface.top) };
            let speed = turns.copysign(surface.speed);
            // NaN, before the first one, is always a change.
            let is_near = (speed - surface.sent).abs() <= SPEED_STEP * turns;
            if !is_near && out.order(&Order::Spindle { spindle, speed }, given).is_ok() {
                surface.sent = speed;
            }
        }
    }
}
