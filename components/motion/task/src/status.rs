//! The snapshot `task.status`, and the lines of the command of this name.

use crate::{
    codes,
    core::{Core, Interpreting, awaited::WaitRecord, file_name, restart::Shown},
    outside::{Level, MotionState},
};
use hal_component::{IoState, Plain, abi::OperatorView};
use hal_gcode::{
    axis::{Axis, Position},
    canon::Direction,
    state::codes::G_CODES,
};
use std::sync::Arc;

/// Version of [`TaskStatus`].
pub(crate) const VERSION: u32 = 7;
/// Number of words of a text.
const TEXT: usize = 32;
/// Number of spindles.
const SPINDLES: usize = 8;
/// Number of calls whose lines are in the record.
const CALLS: usize = 10;

/// State of the task. Lengths are in machine units.
#[derive(Clone, Copy, Debug, PartialEq, Plain)]
pub(crate) struct TaskStatus {
    /// State of the machine: 0 e-stop, 1 off, 2 on.
    pub(crate) state: u32,
    /// Mode: 0 manual, 1 auto, 2 MDI.
    pub(crate) mode: u32,
    /// State of the interpreter: 0 idle, 1 reading, 2 paused, 3 waiting for the machine.
    pub(crate) interpreter: u32,
    /// True while single steps are in force.
    pub(crate) stepping: bool,
    /// True while M1 pauses.
    pub(crate) optional_stop: bool,
    /// True while lines that begin with / are left out.
    pub(crate) block_delete: bool,
    /// Number of jobs that have ended.
    pub(crate) jobs: u32,
    /// Number of jobs that have failed or were aborted.
    pub(crate) jobs_failed: u32,
    /// Number of times that something was stopped: by an abort, also without a job, or because the machine was no longer on.
    pub(crate) stops: u32,
    /// Machine time of the current or last job in seconds, at the last change.
    pub(crate) job_time: f64,
    /// Estimate of the seconds until the program ends; -1 while it is not known.
    pub(crate) time_left: f64,
    /// Line in execution; 0 without one.
    pub(crate) line: u32,
    /// Line that was read last.
    pub(crate) line_read: u32,
    /// Number of calls in progress where the program is read.
    pub(crate) calls: u32,
    /// Lines of these calls, the outermost first.
    pub(crate) call_lines: [u32; CALLS],
    /// Number of steps that wait in the task.
    pub(crate) queue: u32,
    /// Number of lines of MDI that wait.
    pub(crate) mdi_queue: u32,
    /// Tool in the spindle; 0 for none.
    pub(crate) tool: i32,
    /// Tool that is prepared; 0 for none.
    pub(crate) tool_prepared: i32,
    /// Tool that the job waits for; -1 if it waits for none.
    pub(crate) tool_awaited: i32,
    /// True while mist coolant is on.
    pub(crate) mist: bool,
    /// True while flood coolant is on.
    pub(crate) flood: bool,
    /// True while lubrication is on.
    pub(crate) lube: bool,
    /// Programmed feed, in units of the program.
    pub(crate) feed: f64,
    /// Programmed speeds of the spindles.
    pub(crate) speed: [f64; SPINDLES],
    /// Directions of the spindles: 0 stopped, 1 clockwise, -1 counterclockwise.
    pub(crate) direction: [i32; SPINDLES],
    /// Feed override.
    pub(crate) feed_override: f64,
    /// Overrides of the spindles.
    pub(crate) spindle_override: [f64; SPINDLES],
    /// G codes in force, times ten.
    pub(crate) g_codes: [u32; G_CODES],
    /// Coordinate system: 1 for G54, 9 for G59.3.
    pub(crate) system: u32,
    /// Offset of the coordinate system.
    pub(crate) g5x_offset: [f64; 9],
    /// Rotation of the coordinate system about Z in degrees.
    pub(crate) rotation: f64,
    /// Offset of G92.
    pub(crate) g92_offset: [f64; 9],
    /// Offset of the tool.
    pub(crate) tool_offset: [f64; 9],
    /// Number of messages.
    pub(crate) messages: u32,
    /// Path of the program, eight bytes in each word, the first lowest.
    pub(crate) file: [u64; TEXT],
    /// Last message, as the path of the program.
    pub(crate) message: [u64; TEXT],
    /// Importance of the last message: 0 a message of the program, 1 an error.
    pub(crate) message_level: u32,
    /// Seconds that a pause of G4 still takes; 0 without one.
    pub(crate) delay_left: f64,
    /// True from the end of a wait for an input (M66) that came too late, until the next one ends.
    pub(crate) input_timeout: bool,
    /// True while there is enough lubricant.
    pub(crate) lube_level: bool,
    /// True while the overrides of feeds and rapid moves count (M50).
    pub(crate) feed_override_counts: bool,
    /// True for a spindle whose override counts (M51).
    pub(crate) spindle_override_counts: [bool; SPINDLES],
    /// Line of MDI in execution, as the path of the program.
    pub(crate) command: [u64; TEXT],
    /// Override of rapid moves.
    pub(crate) rapid_override: f64,
    /// Wait of the job, or of motion without a job, as a number of the table of waits.
    pub(crate) wait: u32,
    /// Spindle, tool, input or user code that it waits for.
    pub(crate) wait_number: i32,
    /// Machine time in seconds since which it waits.
    pub(crate) wait_since: f64,
    /// Machine time in seconds at which the wait ends by itself; -1 if that is not known.
    pub(crate) wait_until: f64,
    /// True if the wait ends by itself, whatever anybody does.
    pub(crate) wait_ends: bool,
    /// Text that says who is waited for and how to go on, encoded as the path of the program.
    pub(crate) wait_text: [u64; TEXT],
    /// End of the last job: 0 none has ended, 1 complete, 2 an error, 3 an abort, 4 an e-stop, 5 switched off.
    pub(crate) ended_by: u32,
}

/// The state of the task, with its texts.
#[derive(Clone, Debug, Default)]
pub(crate) struct Report {
    pub(crate) status: Option<TaskStatus>,
    pub(crate) message: String,
    wait: WaitRecord,
    file: String,
    velocity: f64,
    /// The start that waits for its confirmation.
    pub(crate) start: Option<Arc<Shown>>,
}

impl Report {
    pub(crate) fn of(core: &Core, motion: &MotionState, io: &IoState, now: f64) -> Self {
        let file = core.program.as_deref().map(file_name).unwrap_or_default();
        Self {
            status: Some(status(core, io, now)),
            message: core.message.to_string(),
            wait: core.wait_record().clone(),
            file,
            velocity: motion.velocity,
            start: core.shown_start(),
        }
    }

    /// Returns the lines of the command `task.status`.
    pub(crate) fn lines(&self) -> Vec<String> {
        let Some(s) = &self.status else { return vec!["task state=unknown".to_owned()] };
        let name = |names: &[&'static str], n: u32| *names.get(n as usize).unwrap_or(&"?");
        let bit = |on: bool| if on { "TRUE" } else { "FALSE" };
        let mut lines = vec![
            format!(
                "task state={} mode={} interpreter={} queue={} mdi-queue={} jobs={} failed={}",
                name(&["estop", "off", "on"], s.state),
                name(&["manual", "auto", "mdi"], s.mode),
                name(&["idle", "reading", "paused", "waiting"], s.interpreter),
                s.queue,
                s.mdi_queue,
                s.jobs,
                s.jobs_failed,
            ),
            format!(
                "program file={} line={} read={} time={:.3} left={} velocity={:.3} optional-stop={} \
                 block-delete={} stepping={} ended-by={}",
                self.file,
                s.line,
                s.line_read,
                s.job_time,
                if s.time_left < 0.0 {
                    "unknown".to_owned()
                } else {
                    format!("{:.1}", s.time_left)
                },
                self.velocity,
                bit(s.optional_stop),
                bit(s.block_delete),
                bit(s.stepping),
                name(&["nothing", "end", "error", "abort", "estop", "off"], s.ended_by),
            ),
            format!(
                "tool number={} prepared={} waits-for={} mist={} flood={} lube={}",
                s.tool,
                s.tool_prepared,
                match s.tool_awaited {
                    ..0 => "nothing".to_owned(),
                    tool => tool.to_string(),
                },
                bit(s.mist),
                bit(s.flood),
                bit(s.lube),
            ),
            format!("modal {}", codes::joined(&s.g_codes)),
        ];
        lines.extend(self.wait.line());
        lines.push(format!("message number={} {}", s.messages, self.message));
        lines
    }
}

fn status(core: &Core, io: &IoState, now: f64) -> TaskStatus {
    let state = &core.interpreter.state;
    let modal = &state.modal;
    let frame = &state.frame;
    let k = frame.unit.to(state.settings.unit);
    let pose = |p: Position| Axis::ALL.map(|a| p.scaled(k)[a]);
    let mut call_lines = [0; CALLS];
    let calls = core.interpreter.places();
    for (place, call) in call_lines.iter_mut().zip(&calls) {
        *place = call.line;
    }
    let (mut speed, mut direction) = ([0.0; SPINDLES], [0; SPINDLES]);
    for ((speed, direction), s) in speed.iter_mut().zip(&mut direction).zip(&modal.spindles) {
        *speed = s.speed;
        *direction = match s.direction {
            Direction::Stopped => 0,
            Direction::Clockwise => 1,
            Direction::Counterclockwise => -1,
        };
    }
    let count = |n: usize| u32::try_from(n).unwrap_or(u32::MAX);
    let wait = core.wait_record();
    TaskStatus {
        state: core.power as u32,
        mode: core.mode as u32,
        interpreter: core.interpreting() as u32,
        stepping: core.is_stepping(),
        optional_stop: core.optional_stop,
        block_delete: state.settings.block_delete,
        jobs: core.jobs.0,
        jobs_failed: core.jobs.1,
        stops: core.stops,
        job_time: core.job_time,
        time_left: core.time_left().unwrap_or(-1.0),
        line: core.line(),
        line_read: state.line,
        calls: count(calls.len().saturating_sub(1)),
        call_lines,
        queue: count(core.queue_len()),
        mdi_queue: count(core.mdi_len()),
        tool: io.tool,
        tool_prepared: io.prepared,
        tool_awaited: core.awaited_tool().unwrap_or(-1),
        mist: io.mist,
        flood: io.flood,
        lube: io.lube,
        feed: modal.feed,
        speed,
        direction,
        feed_override: core.feed.scale,
        spindle_override: core.spindle_scale,
        g_codes: state.g_codes(),
        system: modal.system.into(),
        g5x_offset: pose(frame.g5x),
        rotation: frame.rotation,
        g92_offset: pose(frame.g92),
        tool_offset: pose(frame.tool),
        messages: core.messages,
        file: packed(&core.program.as_ref().map(|p| p.to_string_lossy()).unwrap_or_default()),
        message: packed(&core.message),
        message_level: u32::from(core.message_level == Level::Error),
        delay_left: core.delay_left(now),
        input_timeout: core.input_was_late,
        lube_level: io.lube_level,
        feed_override_counts: core.feed.counts,
        spindle_override_counts: core.spindle_counts,
        command: packed(core.mdi_line()),
        rapid_override: core.feed.rapid,
        wait: wait.kind as u32,
        wait_number: wait.number,
        wait_since: wait.since,
        wait_until: wait.until.unwrap_or(-1.0),
        wait_ends: wait.ends,
        wait_text: packed(&wait.text),
        ended_by: core.ended_by as u32,
    }
}

/// Returns what an operator's lamps show.
pub(crate) fn operator_view(core: &Core, io: &IoState) -> OperatorView {
    let state = &core.interpreter.state;
    let k = state.frame.unit.to(state.settings.unit);
    let zero = state.frame.machine(Position::default()).scaled(k);
    let in_spindle = core.world.machine.tools.tools.iter().find(|t| t.number == io.tool);
    OperatorView {
        mode: core.mode as u32,
        program: match core.interpreting() {
            Interpreting::Idle => 0,
            Interpreting::Reading | Interpreting::Waiting => 1,
            Interpreting::Paused => 2,
        },
        optional_stop: core.optional_stop.into(),
        block_delete: state.settings.block_delete.into(),
        tool_diameter: in_spindle.map_or(0.0, |tool| tool.diameter),
        zero: Axis::ALL.map(|a| zero[a]),
        rotation: state.frame.rotation,
        ..OperatorView::IDLE
    }
}

/// Returns a text as words of eight bytes each, cut where they end.
fn packed(text: &str) -> [u64; TEXT] {
    let end = text.floor_char_boundary(TEXT * 8);
    let bytes = text.as_bytes().get(..end).unwrap_or_default();
    let mut out = [0; TEXT];
    for (word, chunk) in out.iter_mut().zip(bytes.chunks(8)) {
        *word = (0u32..).zip(chunk).fold(0, |sum, (n, byte)| sum | u64::from(*byte) << (8 * n));
    }
    out
}
