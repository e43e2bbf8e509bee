//! `halgcode ticks`: a program in single steps, as figures, as a table of ticks, or as a picture of the simulation.

mod drawing;

use super::{filter, help::usage_of, language};
use crate::{
    Stdio, Terminal,
    programs::{
        options::{Opt, mixed, plain, usage},
        picture,
    },
    terminal::print_error,
};
use drawing::{Drawing, View};
use hal_gcode::{
    Interpreter,
    ticks::{Figures, Resolution, Step, Ticks},
};
use hal_job::{
    machine::{Files, Machine},
    number,
    run::{Answers, Stop, run, start},
    world::World,
};
use std::{
    collections::BTreeMap,
    path::{Path, PathBuf},
    process::ExitCode,
};

/// Arguments of the command.
pub(super) const ARGUMENTS: &str = "[options] FILE";
/// Purpose of the command.
pub(super) const HELP: &str =
    "the program in single steps: figures, a table, or a picture of the simulation";

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum TicksOption {
    Output,
    View,
    Turn,
    Title,
    Size,
    Resolution,
    Ini,
    Dialect,
    Help,
}

const OPTIONS: &[Opt<TicksOption>] = &[
    Opt {
        long: Some("output"),
        help: "the ticks as FILE.csv, or a picture of the simulation as FILE.svg or FILE.png; the figures if none is given",
        ..Opt::short_with(TicksOption::Output, 'o', "FILE")
    },
    Opt {
        long: Some("view"),
        help: "perspective (the default), front, side or top",
        ..Opt::short_with(TicksOption::View, 'w', "NAME")
    },
    Opt {
        long: Some("turn"),
        help: "where the perspective is seen from, in degrees: to the right of the front, and above it; 30,35 if none is given",
        ..Opt::short_with(TicksOption::Turn, 'a', "RIGHT,UP")
    },
    Opt {
        long: Some("title"),
        help: "the title",
        ..Opt::short_with(TicksOption::Title, 'T', "TEXT")
    },
    Opt {
        long: Some("size"),
        help: "in pixels; 1000x1000 if none is given",
        ..Opt::short_with(TicksOption::Size, 'S', "WIDTHxHEIGHT")
    },
    Opt {
        long: Some("resolution"),
        help: "points per inch, above 0 to 1000000; those of [JOINT_0]SCALE, or 100",
        ..Opt::short_with(TicksOption::Resolution, 'r', "N")
    },
    Opt { help: "the machine's INI file", ..Opt::short_with(TicksOption::Ini, 'i', "INI") },
    language::option(TicksOption::Dialect),
    Opt { long: Some("help"), help: "print this", ..Opt::flag(TicksOption::Help, 'h') },
];

/// Points per inch where nothing states them.
const COARSE: f64 = 100.0;
/// Most points per inch.
const FINEST: f64 = 1e6;
/// Most ticks of a program.
const MAX_TICKS: u64 = 100_000_000;
/// Most ticks that are kept for a table or a picture.
const MAX_KEPT: u64 = 5_000_000;

/// Returns the options for completion.
pub(super) fn completable() -> Vec<Opt<()>> {
    plain(OPTIONS)
}

/// Target of the ticks.
enum Target {
    Figures,
    Table(PathBuf),
    Picture(PathBuf, picture::Kind),
}

/// Runs `ticks` with these words. The status is 1 if the program has an error; nothing is written then.
pub(super) fn main(words: &[String]) -> Result<ExitCode, String> {
    let (given, rest) = mixed("halgcode", OPTIONS, words).map_err(|e| e.to_string())?;
    let value = |wanted| given.iter().rev().find(|(id, _)| *id == wanted)?.1.as_deref();
    if given.iter().any(|(id, _)| *id == TicksOption::Help) {
        Stdio.out(&usage_of("ticks", ARGUMENTS, HELP, &usage(OPTIONS)))?;
        return Ok(ExitCode::SUCCESS);
    }
    let [file] = rest.as_slice() else {
        return Err("which file? halgcode ticks [options] FILE".into());
    };
    let target = target(value(TicksOption::Output).map(PathBuf::from))?;
    let view = View::of(value(TicksOption::View), value(TicksOption::Turn))?;
    let size = value(TicksOption::Size).map(picture::size).transpose()?.unwrap_or((1000, 1000));
    let ini = value(TicksOption::Ini).map(PathBuf::from);
    let mut machine = Machine::read(&Files { ini: ini.as_deref(), ..Files::default() })?;
    language::set(&mut machine, value(TicksOption::Dialect))?;
    let scale = match value(TicksOption::Resolution) {
        None => resolution(&machine)?,
        Some(text) => {
            let number = text.parse::<f64>().ok().filter(|n| *n > 0.0 && *n <= FINEST);
            number.ok_or_else(|| {
                format!("'{text}' is no resolution: points per inch, above 0 to {FINEST}")
            })?
        }
    };
    let rapid = machine.top_speed.0 * 60.0 / 25.4;
    let default = Resolution::default();
    let limit = if matches!(target, Target::Figures) { MAX_TICKS } else { MAX_KEPT };
    let rapid = if rapid.is_finite() { rapid } else { default.rapid };
    let world = World::with_functions(machine, BTreeMap::new());
    let mut made = Made { figures: Figures::default(), ticks: Vec::new(), moves: Vec::new() };
    let keeps = !matches!(target, Target::Figures);
    if let Err(why) = follow(file, &world, Resolution { scale, rapid, limit }, keeps, &mut made)? {
        print_error(&format!("{why}\n"));
        return Ok(ExitCode::FAILURE);
    }
    let write = |path: &Path, bytes: &[u8]| {
        let written = hal_output::write(path, bytes);
        written.map_err(|e| format!("{}: {}", path.display(), hal_output::reason(&e)))
    };
    match target {
        Target::Figures => Stdio.out(&made.report(file, scale))?,
        Target::Table(path) => write(&path, made.table().as_bytes())?,
        Target::Picture(path, kind) => {
            let name = Path::new(file).file_name().map(|n| n.to_string_lossy().into_owned());
            let title = value(TicksOption::Title).map(str::to_owned).or(name).unwrap_or_default();
            let drawing = Drawing::new(&made.ticks, &made.moves, scale, view, title, size);
            let drawing = drawing.ok_or_else(|| format!("{file}: there is no move to draw"))?;
            write(&path, &kind.bytes(&drawing)?)?;
        }
    }
    Ok(ExitCode::SUCCESS)
}

fn target(output: Option<PathBuf>) -> Result<Target, String> {
    let Some(path) = output else { return Ok(Target::Figures) };
    if path.extension().is_some_and(|e| e.eq_ignore_ascii_case("csv")) {
        return Ok(Target::Table(path));
    }
    match picture::Kind::of(&path) {
        Ok(kind) => Ok(Target::Picture(path, kind)),
        Err(_) => {
            Err(format!("{}: a table ends in .csv, a picture in .svg or .png", path.display()))
        }
    }
}

/// Returns the points per inch of the machine's first joint.
fn resolution(machine: &Machine) -> Result<f64, String> {
    let Some(ini) = &machine.ini else { return Ok(COARSE) };
    let scale = number::number(ini, "JOINT_0", "SCALE")?.map(f64::abs);
    let scale = scale.map(|s| s * 25.4 / machine.settings.unit.millimetres());
    Ok(scale.filter(|s| *s > 0.0 && *s <= FINEST).unwrap_or(COARSE))
}

/// Ticks and moves of a program.
struct Made {
    figures: Figures,
    /// The ticks, if they are kept.
    ticks: Vec<Step>,
    moves: Vec<hal_gcode::ticks::Move>,
}

/// Follows a program. The inner error is one of the program, at its place.
fn follow(
    file: &str,
    world: &World,
    resolution: Resolution,
    keeps: bool,
    made: &mut Made,
) -> Result<Result<(), String>, String> {
    let machine = &world.machine;
    let text = filter::load(Path::new(file), machine)?;
    let mut it = Interpreter::new(machine.settings.clone(), machine.numbered.clone());
    start(&mut it, world)?;
    it.load(file, text);
    let ticks = Ticks::new(it.state.frame, it.state.position, resolution);
    let mut ticks = ticks.map_err(|problem| format!("{file}: {problem}"))?;
    let result = run(
        &mut it,
        world,
        Answers { probe_trips: true, functions: world.functions.as_ref() },
        |it, issued| {
            let moved = ticks.follow(issued, &mut |step| {
                made.figures.step(step);
                if keeps {
                    made.ticks.push(step);
                }
            });
            let moved = moved.map_err(|problem| {
                let file = it.state.levels.last().map_or(file, |l| &*l.file);
                let remedy = problem.remedy();
                Stop::Output(format!("{file}:{}: {problem} ({remedy})", issued.line))
            })?;
            if let Some(moved) = moved {
                made.figures.moved(&moved);
                made.moves.push(moved);
            }
            Ok(())
        },
    );
    Ok(match result {
        Ok(()) => Ok(()),
        Err(Stop::Output(why)) => Err(why),
        Err(Stop::Program(error)) => Err(error.to_string()),
    })
}

impl Made {
    fn report(&self, file: &str, scale: f64) -> String {
        let f = &self.figures;
        let list = |values: [u64; 3]| values.map(|v| v.to_string()).join(" ");
        let ranges = f.low.iter().zip(&f.high).map(|(low, high)| format!("{low} to {high}"));
        let ranges = ranges.collect::<Vec<_>>().join(", ");
        let end = f.place.map(|v| v.to_string()).join(" ");
        let moves = f.moves.map(|v| v.to_string()).join(" ");
        format!(
            "{file}: {} ticks, {scale} to the inch\n  ticks of 1, 2 and 3 axes  {}\n  steps of X, Y, Z          {}\n  \
             places of X, Y, Z         {ranges}\n  end                       {end}\n  \
             moves G00 G01 G02 G03     {moves}\n  length                    {:.4} in\n  \
             time                      {:.2} s\n",
            f.ticks,
            list(f.by_axes),
            list(f.steps),
            f.length,
            f.seconds
        )
    }

    /// Returns the ticks as a table: seconds at the end of each, the line of the program, the steps of X, Y and Z.
    fn table(&self) -> String {
        let mut out = String::from("seconds,line,x,y,z\n");
        let mut ticks = self.ticks.iter();
        let mut before = 0.0;
        for by in &self.moves {
            let count = usize::try_from(by.ticks).unwrap_or(usize::MAX);
            for (n, [x, y, z]) in (1_u64..).zip(ticks.by_ref().take(count)) {
                let seconds = before + by.seconds * n as f64;
                out.push_str(&format!("{seconds:.6},{},{x},{y},{z}\n", by.line));
            }
            before += by.seconds * by.ticks as f64;
        }
        out
    }
}
