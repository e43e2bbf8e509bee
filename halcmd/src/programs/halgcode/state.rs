//! `halgcode state`: the interpreter's state before a line.

use super::{filter, help::usage_of, language};
use crate::{
    Stdio, Terminal,
    programs::options::{Opt, mixed, plain, usage},
};
use hal_gcode::{
    Interpreter, State,
    axis::{Axis, Position},
    canon::{Direction, PathMode, Plane, Unit},
    interpret::codes::shown,
    state::{FeedMode, LevelKind, Side},
};
use hal_job::{
    machine::{Files, Machine},
    run::{Answers, start, step},
    world::World,
};
use std::{
    collections::BTreeMap,
    path::{Path, PathBuf},
    process::ExitCode,
};

/// Arguments of the command.
pub(super) const ARGUMENTS: &str = "--line N [options] FILE";
/// Purpose of the command.
pub(super) const HELP: &str = "the interpreter's state before a line";

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Id {
    Line,
    In,
    Pass,
    Json,
    Ini,
    Table,
    Parameters,
    BlockDelete,
    Dialect,
    Help,
}

const OPTIONS: &[Opt<Id>] = &[
    Opt {
        long: Some("line"),
        help: "the line that would run next",
        ..Opt::short_with(Id::Line, 'n', "N")
    },
    Opt {
        long: Some("in"),
        help: "the file of the line, if it is a subroutine's",
        ..Opt::short_with(Id::In, 'f', "FILE")
    },
    Opt {
        long: Some("pass"),
        help: "how often the line is reached; 1 is the first time (the default)",
        ..Opt::short_with(Id::Pass, 'p', "N")
    },
    Opt {
        long: Some("json"),
        help: "the whole state as JSON, which hal-gcode goes on from",
        ..Opt::flag(Id::Json, 'j')
    },
    Opt { help: "the machine's INI file", ..Opt::short_with(Id::Ini, 'i', "INI") },
    Opt { help: "the tool table", ..Opt::short_with(Id::Table, 't', "TABLE") },
    Opt {
        help: "the parameter file; it is only read",
        ..Opt::short_with(Id::Parameters, 'v', "FILE")
    },
    Opt { help: "lines that begin with / are not run", ..Opt::flag(Id::BlockDelete, 'b') },
    language::option(Id::Dialect),
    Opt { long: Some("help"), help: "print this", ..Opt::flag(Id::Help, 'h') },
];

/// Returns the options for completion.
pub(super) fn completable() -> Vec<Opt<()>> {
    plain(OPTIONS)
}

/// Runs `state` with these words. The status is 1 if the line is not reached.
pub(super) fn main(words: &[String]) -> Result<ExitCode, String> {
    let (given, rest) = mixed("halgcode", OPTIONS, words).map_err(|e| e.to_string())?;
    let value = |wanted| given.iter().rev().find(|(id, _)| *id == wanted)?.1.as_deref();
    let path = |wanted| value(wanted).map(PathBuf::from);
    let is_given = |wanted| given.iter().any(|(id, _)| *id == wanted);
    if is_given(Id::Help) {
        Stdio.out(&usage_of("state", ARGUMENTS, HELP, &usage(OPTIONS)))?;
        return Ok(ExitCode::SUCCESS);
    }
    let [file] = rest.as_slice() else {
        return Err("which file? halgcode state --line N [options] FILE".into());
    };
    let number = |wanted| {
        let text = value(wanted);
        let parse = |t: &str| t.parse::<u32>().ok().filter(|n| *n > 0);
        text.map(|t| parse(t).ok_or_else(|| format!("'{t}': a number from 1"))).transpose()
    };
    let line = number(Id::Line)?.ok_or("which line? halgcode state --line N FILE")?;
    let pass = number(Id::Pass)?.unwrap_or(1);
    let (ini, table, parameters) = (path(Id::Ini), path(Id::Table), path(Id::Parameters));
    let mut machine = Machine::read(&Files {
        ini: ini.as_deref(),
        table: table.as_deref(),
        parameters: parameters.as_deref(),
        ..Files::default()
    })?;
    machine.settings.block_delete = is_given(Id::BlockDelete);
    language::set(&mut machine, value(Id::Dialect))?;
    let world = World::with_functions(machine, BTreeMap::new());
    let text = filter::load(Path::new(file), &world.machine)?;
    let machine = &world.machine;
    let mut it = Interpreter::new(machine.settings.clone(), machine.numbered.clone());
    start(&mut it, &world)?;
    it.load(file, text);
    let within = value(Id::In).unwrap_or(file);
    match seek(&mut it, &world, within, line, pass) {
        Ok(true) => {}
        Ok(false) => {
            return Err(format!(
                "{within}:{line}: the program does not reach this line {pass} times"
            ));
        }
        Err(error) => return Err(format!("before {within}:{line}: {error}")),
    }
    let out = if is_given(Id::Json) {
        let mut text = serde_json::to_string_pretty(&it.state).map_err(|e| e.to_string())?;
        text.push('\n');
        text
    } else {
        describe(&it.state)
    };
    Stdio.out(&out)?;
    Ok(ExitCode::SUCCESS)
}

/// Runs until a line would run next, for the given time.
fn seek(
    it: &mut Interpreter,
    world: &World,
    file: &str,
    line: u32,
    pass: u32,
) -> Result<bool, hal_gcode::Error> {
    let mut seen = 0;
    let mut out = Vec::new();
    loop {
        let here = it.state.levels.last().is_some_and(|l| {
            let same = &*l.file == file || l.file.as_ref() == file.trim_end_matches(".ngc");
            same && l.cursor.line + 1 == line
        });
        if here {
            seen += 1;
            if seen == pass {
                return Ok(true);
            }
        }
        out.clear();
        if !step(
            it,
            world,
            Answers { probe_trips: true, functions: world.functions.as_ref() },
            &mut out,
        )? {
            return Ok(false);
        }
    }
}

/// Describes a state in lines.
fn describe(state: &State) -> String {
    let mut out = String::new();
    let mut row = |name: &str, value: String| out.push_str(&format!("{name:<10} {value}\n"));
    for (depth, level) in state.levels.iter().enumerate() {
        let name = if depth == 0 { "program" } else { "call" };
        let mut value = format!("{}:{}", level.file, level.cursor.line + 1);
        if level.kind == LevelKind::Sub {
            value.push_str(&format!(" in o<{}>", level.label));
        }
        if level.remapped.is_some() {
            value.push_str(", a remapped code");
        }
        for open in &level.open {
            value.push_str(&format!(", o<{}> {:?}", open.label, open.kind));
        }
        row(name, value);
        let locals: Vec<String> = level.locals.iter().map(|(n, v)| format!("#<{n}>={v}")).collect();
        if !locals.is_empty() {
            row("", locals.join(" "));
        }
    }
    row("codes", codes(state));
    row("feed", format!("F{}", state.modal.feed));
    for (n, s) in state.modal.spindles.iter().enumerate() {
        let direction = match s.direction {
            Direction::Stopped => "M5",
            Direction::Clockwise => "M3",
            Direction::Counterclockwise => "M4",
        };
        row("spindle", format!("{n}: {direction} S{}{}", s.speed, if s.css { " G96" } else { "" }));
    }
    let selected = state.selected.map_or_else(|| "none".to_owned(), |t| t.to_string());
    row("tool", format!("{} in the spindle, selected {selected}", state.tool.number));
    row("offset", place(state.frame.tool));
    row("system", format!("{} rotated by {}", place(state.frame.g5x), state.frame.rotation));
    row("G92", place(state.frame.g92));
    row("position", place(state.position));
    row("machine", format!("{} (mm)", place(state.frame.machine_mm(state.position))));
    let globals: Vec<String> = state.globals.iter().map(|(n, v)| format!("#<{n}>={v}")).collect();
    if !globals.is_empty() {
        row("globals", globals.join(" "));
    }
    let numbered: Vec<String> = (1..=30)
        .filter(|n| state.numbered.get(*n) != 0.0)
        .map(|n| format!("#{n}={}", state.numbered.get(n)))
        .collect();
    if !numbered.is_empty() {
        row("parameters", numbered.join(" "));
    }
    out
}

fn place(position: Position) -> String {
    let mut out = Vec::new();
    for axis in Axis::ALL {
        let basic = matches!(axis, Axis::X | Axis::Y | Axis::Z);
        if basic || position[axis] != 0.0 {
            out.push(format!("{}{:.4}", axis.letter().to_ascii_uppercase(), position[axis]));
        }
    }
    out.join(" ")
}

/// Returns the modal codes in force.
fn codes(state: &State) -> String {
    let m = &state.modal;
    let mut out: Vec<String> = Vec::new();
    let mut add = |code: &str| out.push(code.to_owned());
    add(&match m.motion {
        800 => "G80".to_owned(),
        code => shown(code).to_uppercase(),
    });
    add(match m.plane {
        Plane::Xy => "G17",
        Plane::Xz => "G18",
        Plane::Yz => "G19",
        Plane::Uv => "G17.1",
        Plane::Uw => "G18.1",
        Plane::Vw => "G19.1",
    });
    add(if m.unit == Unit::Inch { "G20" } else { "G21" });
    add(match state.compensation.side() {
        Side::Off => "G40",
        Side::Left => "G41",
        Side::Right => "G42",
    });
    add(if m.tool_offset { "G43" } else { "G49" });
    add(&match m.system {
        n @ 0..=6 => format!("G{}", 53 + n),
        n => format!("G59.{}", n - 6),
    });
    add(&match m.path {
        PathMode::ExactPath => "G61".to_owned(),
        PathMode::ExactStop => "G61.1".to_owned(),
        PathMode::Continuous { tolerance } => format!("G64 P{tolerance} Q{}", m.naive_tolerance),
    });
    add(if m.absolute { "G90" } else { "G91" });
    add(if m.ijk_absolute { "G90.1" } else { "G91.1" });
    add(match m.feed_mode {
        FeedMode::InverseTime => "G93",
        FeedMode::PerMinute => "G94",
        FeedMode::PerRevolution => "G95",
    });
    add(if m.retract_old { "G98" } else { "G99" });
    add(if m.diameter { "G7" } else { "G8" });
    for (on, code) in [(m.mist, "M7"), (m.flood, "M8")] {
        if on {
            add(code);
        }
    }
    if !m.mist && !m.flood {
        add("M9");
    }
    add(if m.feed_override { "M50" } else { "M50 P0" });
    if m.adaptive_feed {
        add("M52");
    }
    if !m.feed_hold {
        add("M53 P0");
    }
    out.join(" ")
}
