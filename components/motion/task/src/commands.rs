//! Commands `task.*`.

use crate::{
    core::{Mode, user::Command},
    worker::{Given, Shared},
};
use hal_component::{Arg, Builder, Call, Error, StopEpoch, abi::ArgSpec};
use hal_job::dry_run::Target;

/// Largest number of commands that wait for the worker.
const MAX_WAITING: usize = 64;

/// A command that the worker executes.
struct Row {
    name: &'static str,
    doc: &'static str,
    args: &'static [&'static ArgSpec],
    read: fn(&Call<'_>) -> Result<Command, Error>,
}

const ON: ArgSpec = Arg::bit("on", "TRUE or FALSE.").required();
const EPOCH: ArgSpec = Arg::int(
    "epoch",
    "Stop epoch in which the order was given, as motion.status has it: after a stop since then it is refused. -1 is now.",
)
.or("-1");
const JSON: ArgSpec = Arg::bit("json", "As JSON, in one line.").or("FALSE");
const SCALE: ArgSpec = Arg::float("scale", "Factor, 0 or more; 1 is as programmed.").required();

const ROWS: &[Row] = &[
    Row {
        name: "task.estop",
        doc: "Puts the machine into e-stop; the job ends.",
        args: &[],
        read: |_| Ok(Command::Estop),
    },
    Row {
        name: "task.estop-reset",
        doc: "Leaves e-stop, if nothing outside holds it.",
        args: &[&EPOCH],
        read: |_| Ok(Command::EstopReset),
    },
    Row {
        name: "task.on",
        doc: "Switches the machine on.",
        args: &[&EPOCH],
        read: |_| Ok(Command::On),
    },
    Row {
        name: "task.off",
        doc: "Switches the machine off; the job ends.",
        args: &[],
        read: |_| Ok(Command::Off),
    },
    Row {
        name: "task.mode",
        doc: "Changes the mode, while no job runs.",
        args: &[&Arg::text(
            "mode",
            "manual (jogs and homing), auto (programs) or mdi (single lines).",
        )
        .required()],
        read: |call| {
            let text = call.text("mode").unwrap_or_default();
            let all = [Mode::Manual, Mode::Auto, Mode::Mdi];
            let found = all.into_iter().find(|m| m.name() == text);
            let why = || Error::new(format!("mode '{text}' is none of manual, auto and mdi"));
            found.map(Command::Mode).ok_or_else(why)
        },
    },
    Row {
        name: "task.home",
        doc: "Homes joints, in mode manual.",
        args: &[&Arg::text("joint", "Number of the joint, from 0, or all.").required(), &EPOCH],
        read: |call| {
            let text = call.text("joint").unwrap_or_default();
            if text == "all" {
                return Ok(Command::Home(None));
            }
            let number = text.parse::<u32>();
            let why = |_| Error::new(format!("joint '{text}' is neither a number nor all"));
            number.map(|n| Command::Home(Some(n))).map_err(why)
        },
    },
    Row {
        name: "task.open",
        doc: "Opens a program; task.run runs it.",
        args: &[&Arg::text("file", "The program's file.").required()],
        read: |call| Ok(Command::Open(call.text("file").unwrap_or_default().into())),
    },
    Row {
        name: "task.run",
        doc: "\
Runs the program that is open, from its first line, in mode auto.

The command ends with the program. A refusal has every reason.",
        args: &[
            &Arg::int("stops", "Refuses the run unless field stops of task.status is this number. -1: any.").or("-1"),
            &EPOCH,
        ],
        read: |call| match call.int("stops").unwrap_or(-1) {
            -1 => Ok(Command::Run),
            given => {
                let why = |_| Error::new(format!("stops is {given}, must be -1 to {}", u32::MAX));
                u32::try_from(given).map(Command::RunUnlessStopped).map_err(why)
            }
        },
    },
    Row {
        name: "task.run-from",
        doc: "\
Proposes a start in the middle of the program that is open; nothing moves.

A dry run of the program from its first line makes the state before the line: modal codes, offsets, tool, spindles,
coolant and position. What only the machine knows (probes, M66, values of HAL) is refused with its line, and so is
a line in the middle of cutter compensation, of a series of canned cycles or of a NURBS. When the command has ended,
task.start shows the state and the moves of the entry, and task.confirm begins them.",
        args: &[
            &Arg::int("line", "Number of the line, from 1.").required(),
            &Arg::int("pass", "Number of the time that the line is reached, from 1.").or("1"),
            &Arg::text("in", "File of the line, if it is a subroutine's.").or(""),
        ],
        read: |call| {
            let number = |name: &str, value: i64| {
                let number = u32::try_from(value).ok().filter(|n| *n > 0);
                number.ok_or_else(|| Error::new(format!("{name} is {value}, must be 1 or more")))
            };
            let line = number("line", call.int("line").unwrap_or(0))?;
            let pass = number("pass", call.int("pass").unwrap_or(1))?;
            let file = call.text("in").filter(|f| !f.is_empty()).map(Into::into);
            Ok(Command::RunFrom(Target::Line { file, line, pass }))
        },
    },
    Row {
        name: "task.recover",
        doc: "\
Proposes a start at the place where the last job broke off, from its journal; nothing moves.

The program, its subroutines, offsets and tools must be those of the job. The place is the first line that was not
finished, or a line before it from which a start is possible. task.start shows the proposal, task.confirm begins.",
        args: &[],
        read: |_| Ok(Command::Recover),
    },
    Row {
        name: "task.confirm",
        doc: "\
Begins the start that task.run-from or task.recover has proposed, in mode auto: its entry, and then the program.

It is refused if machine, tool or program have changed since. The command ends with the program.",
        args: &[
            &Arg::int("token", "Token of the proposal, which task.start shows.").required(),
            &EPOCH,
        ],
        read: |call| {
            let given = call.int("token").unwrap_or(0);
            let why = |_| Error::new(format!("token {given} is not that of a proposal"));
            u32::try_from(given).map(Command::Confirm).map_err(why)
        },
    },
    Row {
        name: "task.pause",
        doc: "\
Pauses the job: motion brakes along its path, and nothing of the job begins.

Meanwhile axes can be jogged; task.resume first returns them to the path.",
        args: &[],
        read: |_| Ok(Command::Pause),
    },
    Row {
        name: "task.resume",
        doc: "Goes on after task.pause, motion.pause, single steps, M0, M1 and M60.",
        args: &[&EPOCH],
        read: |_| Ok(Command::Resume),
    },
    Row {
        name: "task.step",
        doc: "\
Executes the next line of the job, and pauses at rest.

Without a job it begins the program that is open.",
        args: &[&EPOCH],
        read: |_| Ok(Command::Step),
    },
    Row {
        name: "task.abort",
        doc: "\
Ends the job at once: motion brakes, and spindles and coolant stop.

Lines of MDI that wait are forgotten. Modal state and numbered parameters are those of the line in
execution. Nothing goes on by itself.",
        args: &[],
        read: |_| Ok(Command::Abort),
    },
    Row {
        name: "task.mdi",
        doc: "Executes a line of G-code, in mode mdi, after at most ten lines that wait already.",
        args: &[&Arg::text("text", "The line.").required(), &EPOCH],
        read: |call| Ok(Command::Mdi(unquoted(&call.text("text").unwrap_or_default()).into())),
    },
    Row {
        name: "task.mdi-brief",
        doc: "Executes a line of G-code in whatever mode, while no job runs, and returns to that mode.",
        args: &[&Arg::text("text", "The line.").required(), &EPOCH],
        read: |call| Ok(Command::BriefMdi(unquoted(&call.text("text").unwrap_or_default()).into())),
    },
    Row {
        name: "task.optional-stop",
        doc: "Sets whether M1 pauses the program; at first it does.",
        args: &[&ON],
        read: |call| Ok(Command::OptionalStop(call.bit("on").unwrap_or(true))),
    },
    Row {
        name: "task.block-delete",
        doc: "Sets whether lines that begin with / are left out; at first they are.",
        args: &[&ON],
        read: |call| Ok(Command::BlockDelete(call.bit("on").unwrap_or(true))),
    },
    Row {
        name: "task.feed-override",
        doc: "Changes the feed override. It counts unless the program forbids it (M48 to M50).",
        args: &[&SCALE],
        read: |call| Ok(Command::FeedOverride(scale(call)?)),
    },
    Row {
        name: "task.rapid-override",
        doc: "Changes the override of rapid moves. It counts unless the program forbids it (M48 to M50).",
        args: &[&Arg::float("scale", "Factor, 0 to 1.").required()],
        read: |call| match scale(call)? {
            scale if scale > 1.0 => Err(Error::new(format!("scale is {scale}, must be 0 to 1"))),
            scale => Ok(Command::RapidOverride(scale)),
        },
    },
    Row {
        name: "task.spindle-override",
        doc: "Changes a spindle's override. It counts unless the program forbids it (M48 to M51).",
        args: &[&Arg::int("spindle", "Number of the spindle, from 0.").or("0"), &SCALE],
        read: |call| {
            let given = call.int("spindle").unwrap_or(0);
            let why = |_| Error::new(format!("there is no spindle {given}"));
            let spindle = u8::try_from(given).map_err(why)?;
            Ok(Command::SpindleOverride { spindle, scale: scale(call)? })
        },
    },
];

/// Returns a text without the quotes around it, which a line of a script keeps.
fn unquoted(text: &str) -> &str {
    let inner = |quote| text.strip_prefix(quote).and_then(|t| t.strip_suffix(quote));
    inner('\'').or_else(|| inner('"')).unwrap_or(text)
}

fn scale(call: &Call<'_>) -> Result<f64, Error> {
    let scale = call.float("scale").unwrap_or(1.0);
    if scale.is_finite() && 0.0 <= scale {
        return Ok(scale);
    }
    Err(Error::new(format!("scale is {scale}, must be 0 or more")))
}

/// Declares all commands. `epoch` returns the stop epoch of now.
pub(crate) fn open(
    b: &mut Builder<'_>,
    shared: &Shared,
    epoch: impl Fn() -> StopEpoch + Clone + Send + 'static,
) -> Result<(), Error> {
    for row in ROWS {
        let (shared, read, epoch) = (shared.clone(), row.read, epoch.clone());
        b.command(row.name, row.doc, row.args, move |call| {
            let command = read(call)?;
            let given = call.int("epoch").and_then(|n| StopEpoch::of(u64::try_from(n).ok()?));
            let given = given.unwrap_or_else(&epoch);
            let mut shared_state = shared.lock();
            if shared_state.inbox.len() >= MAX_WAITING {
                return Err(Error::new("too many commands wait for the task"));
            }
            let given = Given { epoch: given, is_from_afar: call.is_from_afar() };
            shared_state.inbox.push_back((command, given, call.ticket()?));
            Ok(())
        })?;
    }
    let start = shared.clone();
    let doc = "\
Shows the start that task.run-from or task.recover has proposed: the state before the line, and the steps of the entry.";
    b.command("task.start", doc, &[&JSON], move |call| {
        let shared_state = start.lock();
        let shown = shared_state.report.start.as_ref();
        let shown =
            shown.ok_or_else(|| Error::new("no start is proposed: task.run-from line=…"))?;
        match call.bit("json").unwrap_or(false) {
            true => call.reply(&shown.json),
            false => shown.lines.iter().for_each(|line| call.reply(line)),
        }
        Ok(())
    })?;
    let shared = shared.clone();
    let doc = "Tells state, mode, line, tool, modal codes and the last message.";
    b.command("task.status", doc, &[], move |call| {
        let lines = shared.lock().report.lines();
        lines.iter().for_each(|line| call.reply(line));
        Ok(())
    })
}
