//! `halgcode plot`: the way of the tool as a picture.

use super::{
    filter,
    help::usage_of,
    language,
    views::{Move, Views},
};
use crate::{
    Stdio, Terminal,
    programs::{
        options::{Opt, mixed, plain, usage},
        picture,
    },
    terminal::print_error,
};
use hal_gcode::{Interpreter, axis::Axis};
use hal_job::{
    clock::Clock,
    machine::{Files, Machine},
    run::{Answers, Stop, run, start},
    way::{Extents, Kind, Way},
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
pub(super) const HELP: &str = "a picture of the way, SVG or PNG";

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Id {
    Output,
    Title,
    Size,
    Ini,
    Table,
    Parameters,
    BlockDelete,
    Dialect,
    Help,
}

const OPTIONS: &[Opt<Id>] = &[
    Opt {
        long: Some("output"),
        help: "the picture, FILE.svg or FILE.png; the program's name with .svg if none is given",
        ..Opt::short_with(Id::Output, 'o', "FILE")
    },
    Opt { long: Some("title"), help: "the title", ..Opt::short_with(Id::Title, 'T', "TEXT") },
    Opt {
        long: Some("size"),
        help: "in pixels; 1400x1050 if none is given",
        ..Opt::short_with(Id::Size, 'S', "WIDTHxHEIGHT")
    },
    Opt {
        help: "the machine's INI file: its limits are drawn, and the path that motion plans",
        ..Opt::short_with(Id::Ini, 'i', "INI")
    },
    Opt { help: "the tool table", ..Opt::short_with(Id::Table, 't', "TABLE") },
    Opt {
        help: "the parameter file; it is only read",
        ..Opt::short_with(Id::Parameters, 'v', "FILE")
    },
    Opt { help: "lines that begin with / are not run", ..Opt::flag(Id::BlockDelete, 'b') },
    language::option(Id::Dialect),
    Opt { long: Some("help"), help: "print this", ..Opt::flag(Id::Help, 'h') },
];

/// The most points that are kept for a picture.
const MAX_POINTS: usize = 20_000_000;

/// Returns the options for completion.
pub(super) fn completable() -> Vec<Opt<()>> {
    plain(OPTIONS)
}

/// Runs `plot` with these words. The status is 1 if the program has an error; what came before it is drawn.
pub(super) fn main(words: &[String]) -> Result<ExitCode, String> {
    let (given, rest) = mixed("halgcode", OPTIONS, words).map_err(|e| e.to_string())?;
    let value = |wanted| given.iter().rev().find(|(id, _)| *id == wanted)?.1.as_deref();
    let path = |wanted| value(wanted).map(PathBuf::from);
    let is_given = |wanted| given.iter().any(|(id, _)| *id == wanted);
    if is_given(Id::Help) {
        Stdio.out(&usage_of("plot", ARGUMENTS, HELP, &usage(OPTIONS)))?;
        return Ok(ExitCode::SUCCESS);
    }
    let [file] = rest.as_slice() else {
        return Err("which file? halgcode plot [options] FILE".into());
    };
    let output = path(Id::Output).unwrap_or_else(|| Path::new(file).with_extension("svg"));
    let kind = picture::Kind::of(&output)?;
    let size = value(Id::Size).map(picture::size).transpose()?.unwrap_or((1400, 1050));
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
    let Followed { moves, planned, failed } = follow(file, &world)?;
    let title = value(Id::Title).map_or_else(
        || {
            Path::new(file)
                .file_name()
                .map(|n| n.to_string_lossy().into_owned())
                .unwrap_or_default()
        },
        str::to_owned,
    );
    let limit = |axis: Axis| {
        let limit =
            world.machine.limits.get(usize::from(axis.index())).copied().unwrap_or_default();
        limit.0.zip(limit.1)
    };
    let limits = match (limit(Axis::X), limit(Axis::Y), limit(Axis::Z)) {
        (None, None, None) => None,
        (x, y, z) => Some([x, y, z].map(|l| l.unwrap_or((0.0, 0.0)))),
    };
    let views = Views::new(moves, planned, limits, title, size)
        .ok_or_else(|| format!("{file}: there is no move to draw"))?;
    let bytes = kind.bytes(&views)?;
    let written = hal_output::write(&output, &bytes);
    written.map_err(|e| format!("{}: {}", output.display(), hal_output::reason(&e)))?;
    Ok(if failed { ExitCode::FAILURE } else { ExitCode::SUCCESS })
}

/// A program that was followed.
struct Followed {
    moves: Vec<Move>,
    /// The planned path, if the INI file states what the planner needs.
    planned: Vec<[f64; 3]>,
    /// True if the program has an error; the moves are those before it.
    failed: bool,
}

/// Follows a program.
fn follow(file: &str, world: &World) -> Result<Followed, String> {
    let machine = &world.machine;
    let text = filter::load(Path::new(file), machine)?;
    let mut it = Interpreter::new(machine.settings.clone(), machine.numbered.clone());
    start(&mut it, world)?;
    it.load(file, text);
    let mut way = Way::new(it.state.frame, it.state.position);
    let mut moves: Vec<Move> = Vec::new();
    let mut extents = Extents::new();
    let mut points = 0usize;
    let mut clock = Clock::new(&it, machine);
    clock.iter_mut().for_each(Clock::draw);
    let mut planned: Vec<[f64; 3]> = Vec::new();
    let result = run(
        &mut it,
        world,
        Answers { probe_trips: true, functions: world.functions.as_ref() },
        |_, issued| {
            let from = way.at;
            way.follow(&issued.call, &mut |kind, point| {
                extents.add(point);
                points += 1;
                let point = [point.x, point.y, point.z];
                match moves.last_mut() {
                    Some(last) if last.rapid == (kind == Kind::Rapid) => last.points.push(point),
                    _ => {
                        let from = [from.x, from.y, from.z];
                        moves.push(Move { rapid: kind == Kind::Rapid, points: vec![from, point] });
                    }
                }
            });
            if let Some(clock) = &mut clock {
                // What the planner refuses, `check` reports.
                clock.call(issued).unwrap_or_default();
                planned.extend(clock.places().map(|place| [place.at.x, place.at.y, place.at.z]));
            }
            if points + planned.len() > MAX_POINTS {
                return Err(Stop::Output(format!("{file}: more than {MAX_POINTS} points to draw")));
            }
            Ok(())
        },
    );
    let failed = match result {
        Ok(()) => false,
        Err(Stop::Output(reason)) => return Err(reason),
        Err(Stop::Program(error)) => {
            print_error(&format!("{error}\n"));
            true
        }
    };
    if let Some(clock) = &mut clock {
        clock.finish();
        planned.extend(clock.places().map(|place| [place.at.x, place.at.y, place.at.z]));
    }
    Ok(Followed { moves, planned, failed })
}

#[cfg(test)]
mod tests {
    use super::*;

    const AXES: &str = "[TRAJ]\nCOORDINATES = XYZ\nLINEAR_UNITS = mm\n";

    /// Follows a program on a machine of these lines.
    fn followed(name: &str, ini: &str, program: &str) -> Followed {
        let folder =
            std::env::temp_dir().join(format!("ferrule-plot-{name}-{}", std::process::id()));
        std::fs::create_dir_all(&folder).unwrap();
        let [machine, part] = ["m.ini", "p.ngc"].map(|file| folder.join(file));
        std::fs::write(&machine, ini).unwrap();
        std::fs::write(&part, program).unwrap();
        let machine = Machine::read(&Files { ini: Some(&machine), ..Files::default() }).unwrap();
        let world = World::with_functions(machine, BTreeMap::new());
        let followed = follow(part.to_str().unwrap(), &world).unwrap();
        std::fs::remove_dir_all(&folder).unwrap();
        followed
    }

    #[test]
    fn the_planned_path_rounds_corners_as_motion_does() {
        let rates = "MAX_VELOCITY = 150\nMAX_ACCELERATION = 1500\n";
        let ini = format!("{AXES}[AXIS_X]\n{rates}[AXIS_Y]\n{rates}[AXIS_Z]\n{rates}");
        // LinuxCNC misses the corner of the second program by 0.0355 mm (`components/motion/motion/CORNERS.md`).
        for (name, mode, [least, most]) in
            [("exact", "G61", [0.0, 1e-3]), ("free", "G64", [0.015, 0.0355])]
        {
            let program = format!("G21 G90 {mode} F600\nG1 X40\nY40\nM2\n");
            let Followed { moves, planned, failed } = followed(name, &ini, &program);
            assert!(!failed && moves.len() == 1, "{moves:?}");
            let missed = planned.iter().map(|[x, y, _]| (x - 40.0).hypot(*y));
            let missed = missed.fold(f64::INFINITY, f64::min);
            // Places are 5 micrometres apart at least.
            assert!((least..=most + NEAR).contains(&missed), "{mode}: {missed}");
            let end = planned.last().unwrap();
            assert!((end[0] - 40.0).hypot(end[1] - 40.0) < 0.02, "{end:?}");
        }
    }

    #[test]
    fn without_the_limits_of_axes_nothing_is_planned() {
        let Followed { moves, planned, .. } =
            followed("none", AXES, "G21 G90 F600\nG1 X40\nY40\nM2\n");
        assert_eq!((moves.len(), planned.len()), (1, 0));
    }

    #[test]
    fn a_feed_per_turn_is_that_of_its_spindle() {
        let rates = "MAX_VELOCITY = 150\nMAX_ACCELERATION = 1500\n";
        let ini =
            format!("{AXES}SPINDLES = 2\n[AXIS_X]\n{rates}[AXIS_Y]\n{rates}[AXIS_Z]\n{rates}");
        let program = "G21 G90\nM3 S1000 $1\nG95 $1 F0.2\nG1 X10\nM2\n";
        let Followed { planned, failed, .. } = followed("spindle", &ini, program);
        assert!(!failed);
        assert!((planned.last().unwrap()[0] - 10.0).abs() < 0.01, "{:?}", planned.last());
    }

    /// Distance between places of the planned path, in millimetres.
    const NEAR: f64 = 0.005;
}
