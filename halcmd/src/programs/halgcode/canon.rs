//! `halgcode canon`: the canonical calls, with the options and in the form of `rs274`.

use super::{filter, help::usage_of, language, printer::Printer};
use crate::{
    Stdio, Terminal,
    programs::options::{Opt, mixed, plain, usage},
    terminal::print_error,
};
use hal_gcode::{
    Call, Error, Interpreter, Settings, Text,
    axis::AxisMask,
    canon::Unit,
    error::Problem,
    program::{has_percent_signs, numbered_line},
};
use hal_job::{
    machine::{Files, Machine},
    run::{Answers, Stop, run, start, step},
    world::World,
};
use std::{
    collections::BTreeMap,
    path::{Path, PathBuf},
    process::ExitCode,
};

/// Arguments of the command.
pub(super) const ARGUMENTS: &str = "[options] FILE [OUTPUT]";
/// Purpose of the command.
pub(super) const HELP: &str = "the canonical calls, with the options of rs274";

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Id {
    Go,
    Table,
    Parameters,
    Ini,
    OnError,
    BlockDelete,
    Dialect,
    Stack,
    LogLevel,
    Machine,
    Lines,
    Help,
}

const OPTIONS: &[Opt<Id>] = &[
    Opt { help: "accepted; every run is a batch", ..Opt::flag(Id::Go, 'g') },
    Opt { help: "the tool table", ..Opt::short_with(Id::Table, 't', "TABLE") },
    Opt {
        help: "the parameter file; it is written again at the end",
        ..Opt::short_with(Id::Parameters, 'v', "FILE")
    },
    Opt {
        help: "the INI file: subroutines, remapped codes, values",
        ..Opt::short_with(Id::Ini, 'i', "INI")
    },
    Opt {
        help: "after an error: 0 goes on with the next line, 1 takes lines of MDI and asks, 2 stops (the default)",
        ..Opt::short_with(Id::OnError, 'n', "0|1|2")
    },
    Opt { help: "lines that begin with / are not run", ..Opt::flag(Id::BlockDelete, 'b') },
    language::option(Id::Dialect),
    Opt { help: "after an error, the calls that led there", ..Opt::flag(Id::Stack, 's') },
    Opt { help: "accepted, without effect", ..Opt::short_with(Id::LogLevel, 'l', "LEVEL") },
    Opt {
        long: Some("machine"),
        help: "units, axes, startup code, tool table and parameters of the INI file too",
        ..Opt::flag(Id::Machine, 'm')
    },
    Opt {
        long: Some("lines"),
        help: "before each call its file, line, column of calls and pass",
        ..Opt::flag(Id::Lines, 'L')
    },
    Opt { long: Some("help"), help: "print this", ..Opt::flag(Id::Help, 'h') },
];

/// Returns the options for completion.
pub(super) fn completable() -> Vec<Opt<()>> {
    plain(OPTIONS)
}

/// Runs `canon` with these words.
pub(super) fn main(words: &[String]) -> Result<ExitCode, String> {
    let (given, rest) = mixed("halgcode", OPTIONS, words).map_err(|e| e.to_string())?;
    let path = |wanted| {
        let found = given.iter().rev().find(|(id, _)| *id == wanted)?;
        found.1.as_deref().map(PathBuf::from)
    };
    let is_given = |wanted| given.iter().any(|(id, _)| *id == wanted);
    if is_given(Id::Help) {
        Stdio.out(&usage_of("canon", ARGUMENTS, HELP, &usage(OPTIONS)))?;
        return Ok(ExitCode::SUCCESS);
    }
    let on_error = match path(Id::OnError).as_deref().and_then(Path::to_str) {
        None | Some("2") => OnError::Stop,
        Some("0") => OnError::GoOn,
        Some("1") => OnError::Ask,
        Some(other) => return Err(format!("-n '{other}': 0, 1 or 2")),
    };
    let (file, output) = match rest.as_slice() {
        [file] => (file, None),
        [file, output] => (file, Some(PathBuf::from(output))),
        _ => return Err("which file? halgcode canon [options] FILE [OUTPUT]".into()),
    };
    let (ini, table, parameters) = (path(Id::Ini), path(Id::Table), path(Id::Parameters));
    let whole = is_given(Id::Machine);
    let mut machine = Machine::read(&Files {
        ini: ini.as_deref(),
        table: table.as_deref(),
        parameters: parameters.as_deref(),
        ..Files::default()
    })?;
    if !whole {
        stand_in(&mut machine, parameters.is_some());
    }
    machine.settings.block_delete = is_given(Id::BlockDelete);
    language::set(&mut machine, path(Id::Dialect).as_deref().and_then(Path::to_str))?;
    let world = World::with_functions(machine, BTreeMap::new());
    for remark in &world.machine.remarks {
        print_error(&format!("{remark}\n"));
    }
    let mut printer = Printer::new(output.as_deref(), is_given(Id::Lines))?;
    let job = Job {
        file,
        on_error,
        stack: is_given(Id::Stack),
        // The reference resets once more when it had no INI file.
        resets: if ini.is_some() { 1 } else { 2 },
        whole,
    };
    job.run(&world, &mut printer)
}

/// Gives the machine the facts of the one that `rs274` stands in for.
fn stand_in(machine: &mut Machine, keeps_parameters: bool) {
    let remaps = core::mem::take(&mut machine.settings.remaps);
    machine.settings = Settings {
        axes: AxisMask::XYZABC,
        unit: Unit::Inch,
        program_unit: Unit::Millimetre,
        remaps,
        random_changer: machine.settings.random_changer,
        no_fanuc_subs: machine.settings.no_fanuc_subs,
        counts_arguments: machine.settings.counts_arguments,
        orient_offset: machine.settings.orient_offset,
        dialect: machine.settings.dialect,
        default_feed: machine.settings.default_feed,
        ..Settings::default()
    };
    machine.startup = None;
    if !keeps_parameters {
        machine.parameters = None;
        machine.numbered = hal_gcode::Numbered::default();
    }
}

/// The reaction to an error.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum OnError {
    /// The next line.
    GoOn,
    /// Lines of MDI from standard input, and then the answer of a person.
    Ask,
    /// The end.
    Stop,
}

/// A run with its options.
struct Job<'a> {
    file: &'a str,
    on_error: OnError,
    stack: bool,
    resets: u32,
    whole: bool,
}

impl Job<'_> {
    fn run(&self, world: &World, printer: &mut Printer) -> Result<ExitCode, String> {
        print_error("executing\n");
        let machine = &world.machine;
        let mut it = Interpreter::new(machine.settings.clone(), machine.numbered.clone());
        if self.whole {
            start(&mut it, world)?;
        }
        for call in it.preamble() {
            if !matches!(call, Call::UseToolLengthOffset(_)) {
                printer.call(&call, None)?;
            }
        }
        printer.text("SET_FEED_REFERENCE(CANON_XYZ)", None)?;
        let text = match filter::load(Path::new(self.file), machine) {
            Ok(text) => text,
            Err(reason) => {
                printer.finish()?;
                print_error(&format!("Unable to open file <{}>\n{reason}\n", self.file));
                return Ok(ExitCode::FAILURE);
            }
        };
        printer.text("ON_RESET()", None)?;
        it.load(self.file, text);
        let failed = self.lines(&mut it, world, printer)?;
        for _ in 0..self.resets {
            printer.text("ON_RESET()", None)?;
        }
        printer.finish()?;
        if let Some((path, file)) = &machine.parameters {
            let text = file.save(&it.state.numbered);
            let written = hal_output::write(path, text.as_bytes());
            written.map_err(|e| format!("{}: {}", path.display(), hal_output::reason(&e)))?;
        }
        Ok(if failed { ExitCode::FAILURE } else { ExitCode::SUCCESS })
    }

    /// Runs the program; returns whether it ended by an error.
    fn lines(
        &self,
        it: &mut Interpreter,
        world: &World,
        printer: &mut Printer,
    ) -> Result<bool, String> {
        let answers = Answers { probe_trips: false, functions: world.functions.as_ref() };
        let mut result = run(it, world, answers, |it, issued| printer.issued(it, issued));
        loop {
            let error = match result {
                Ok(()) => return Ok(false),
                Err(Stop::Output(reason)) => return Err(reason),
                Err(Stop::Program(error)) => error,
            };
            if reads_to_percent(&error, world) {
                printer.text("FINISH()", None)?;
            }
            printer.flush().map_err(|e| e.to_string())?;
            self.report(&error, world);
            let goes_on = match self.on_error {
                OnError::GoOn => true,
                OnError::Ask => ask(it, world, printer)?,
                OnError::Stop => false,
            };
            if !goes_on || it.state.levels.is_empty() {
                return Ok(true);
            }
            // Goes on with the line after the one that failed, or after the call that led there.
            it.leave_calls();
            it.state.ended = false;
            it.state.pending = None;
            let mut out = Vec::new();
            let end_of_file = matches!(error.problem, Problem::NoProgramEnd);
            if end_of_file {
                return Ok(true);
            }
            result = match step(it, world, answers, &mut out) {
                Ok(going) => {
                    for issued in &out {
                        printer.issued(it, issued).map_err(|_| "output".to_owned())?;
                    }
                    if going {
                        run(it, world, answers, |it, i| printer.issued(it, i))
                    } else {
                        Ok(())
                    }
                }
                Err(error) => Err(error.into()),
            };
        }
    }

    /// Tells an error as `rs274` does: the message, and the line.
    fn report(&self, error: &Error, world: &World) {
        let text = text_of(error, world);
        let longest = world.machine.settings.limits.line_length;
        let line = text.and_then(|t| numbered_line(&t, error.place.line.into(), longest));
        let line = line.map(|l| String::from_utf8_lossy(&l).trim_end_matches('\r').to_owned());
        print_error(&format!("{}\n{}\n", error.problem, line.unwrap_or_default()));
        if self.stack {
            print_error(&format!("{error}\n"));
        }
    }
}

/// Tells whether `rs274`, which looks for a label down to the end of its file, has read the percent sign there.
fn reads_to_percent(error: &Error, world: &World) -> bool {
    let seeks = matches!(error.problem, Problem::LabelMissing { .. } | Problem::EndMissing { .. });
    let longest = world.machine.settings.limits.line_length;
    seeks && text_of(error, world).is_some_and(|text| has_percent_signs(&text, longest))
}

/// Returns the text of the file in which an error is.
fn text_of(error: &Error, world: &World) -> Option<Text> {
    use hal_gcode::Environment;
    let file = &*error.place.file;
    world.open(file).or_else(|| filter::load(Path::new(file), &world.machine).ok())
}

/// Runs lines of MDI from standard input to its end, then asks whether the program goes on.
fn ask(it: &mut Interpreter, world: &World, printer: &mut Printer) -> Result<bool, String> {
    print_error("starting MDI\n");
    let levels = core::mem::take(&mut it.state.levels);
    let answers = Answers { probe_trips: false, functions: world.functions.as_ref() };
    while let Some(line) = person()? {
        it.mdi(&line);
        match run(it, world, answers, |it, issued| printer.issued(it, issued)) {
            Ok(()) => {}
            Err(Stop::Program(error)) => print_error(&format!("{}\n{line}\n", error.problem)),
            Err(Stop::Output(reason)) => return Err(reason),
        }
    }
    it.state.levels = levels;
    it.state.mdi = None;
    printer.flush().map_err(|stop| stop.to_string())?;
    print_error("continue program? y/n =>");
    Ok(person()?.is_some_and(|answer| answer.trim_start().starts_with(['y', 'Y'])))
}

/// Reads a line of standard input; `None` at its end.
fn person() -> Result<Option<String>, String> {
    let mut line = String::new();
    let read = std::io::stdin().read_line(&mut line);
    let read = read.map_err(|e| format!("standard input: {}", hal_output::reason(&e)))?;
    Ok((read > 0).then(|| line.trim_end_matches(['\r', '\n']).to_owned()))
}
