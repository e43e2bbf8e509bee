//! `halgcode check`: the errors of a program, the places that the machine cannot reach, its tools and extents.

use super::{filter, foreign, help::usage_of, language};
use crate::{
    Stdio, Terminal,
    programs::options::{Opt, mixed, plain, usage},
};
use hal_gcode::{
    Call, Dialect, Interpreter, Issued, axis::Position, error::Problem, state::FeedMode,
};
use hal_job::{
    clock::Clock,
    machine::{Files, Machine},
    run::{Answers, Stop, run, start},
    threads::{Finding, Threads},
    way::{Extents, Kind, Way, distance},
    world::World,
};
use std::{
    collections::BTreeMap,
    path::{Path, PathBuf},
    process::ExitCode,
};

mod report;

/// Arguments of the command.
pub(super) const ARGUMENTS: &str = "[options] FILE...";
/// Purpose of the command.
pub(super) const HELP: &str = "errors, limits, tools and extents, before anything moves";

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Id {
    Ini,
    Table,
    Parameters,
    Hal,
    BlockDelete,
    Dialect,
    Errors,
    Lines,
    Quiet,
    Help,
}

const OPTIONS: &[Opt<Id>] = &[
    Opt { help: "the machine's INI file", ..Opt::short_with(Id::Ini, 'i', "INI") },
    Opt { help: "the tool table", ..Opt::short_with(Id::Table, 't', "TABLE") },
    Opt {
        help: "the parameter file; it is only read",
        ..Opt::short_with(Id::Parameters, 'v', "FILE")
    },
    Opt {
        long: Some("hal"),
        help: "the value of #<_hal[NAME]>; may be repeated",
        ..Opt::short_with(Id::Hal, 'H', "NAME=VALUE")
    },
    Opt { help: "lines that begin with / are not run", ..Opt::flag(Id::BlockDelete, 'b') },
    language::option(Id::Dialect),
    Opt {
        long: Some("errors"),
        help: "ends a file after so many errors (20)",
        ..Opt::short_with(Id::Errors, 'e', "N")
    },
    Opt {
        long: Some("max-lines"),
        help: "ends a file after so many lines were run (100000000)",
        ..Opt::short_with(Id::Lines, 'l', "N")
    },
    Opt { long: Some("quiet"), help: "findings only", ..Opt::flag(Id::Quiet, 'q') },
    Opt { long: Some("help"), help: "print this", ..Opt::flag(Id::Help, 'h') },
];

/// Returns the options for completion.
pub(super) fn completable() -> Vec<Opt<()>> {
    plain(OPTIONS)
}

/// Runs `check` with these words. The status is 1 if there is an error, and 2 if a file cannot be read.
pub(super) fn main(words: &[String]) -> Result<ExitCode, String> {
    let (given, files) = mixed("halgcode", OPTIONS, words).map_err(|e| e.to_string())?;
    let value = |wanted| given.iter().rev().find(|(id, _)| *id == wanted)?.1.as_deref();
    let path = |wanted| value(wanted).map(PathBuf::from);
    let is_given = |wanted| given.iter().any(|(id, _)| *id == wanted);
    if is_given(Id::Help) {
        Stdio.out(&usage_of("check", ARGUMENTS, HELP, &usage(OPTIONS)))?;
        return Ok(ExitCode::SUCCESS);
    }
    if files.is_empty() {
        return Err("which file? halgcode check [options] FILE...".into());
    }
    let number = |wanted, default: u64| match value(wanted) {
        None => Ok(default),
        Some(text) => text.parse().map_err(|_| format!("'{text}' is not a number")),
    };
    let most = number(Id::Errors, 20)?;
    let lines = number(Id::Lines, 100_000_000)?;
    let mut hal = BTreeMap::new();
    for (_, text) in given.iter().filter(|(id, _)| *id == Id::Hal) {
        let text = text.as_deref().unwrap_or_default();
        let pair = text.split_once('=').and_then(|(n, v)| Some((n, v.parse::<f64>().ok()?)));
        let (name, value) = pair.ok_or_else(|| format!("'{text}': NAME=VALUE"))?;
        hal.insert(name.to_ascii_lowercase(), value);
    }
    let (ini, table, parameters) = (path(Id::Ini), path(Id::Table), path(Id::Parameters));
    let mut machine = Machine::read(&Files {
        ini: ini.as_deref(),
        table: table.as_deref(),
        parameters: parameters.as_deref(),
        ..Files::default()
    })?;
    machine.settings.block_delete = is_given(Id::BlockDelete);
    language::set(&mut machine, value(Id::Dialect))?;
    machine.settings.limits.lines = lines;
    let world = World::with_functions(machine, hal);
    let mut text = String::new();
    for remark in &world.machine.remarks {
        text.push_str(&format!("{}\n", remark.replacen(": ", ": warning: ", 1)));
    }
    if let Some(name) = &world.machine.kinematics {
        text.push_str(&format!(
            "{}: note: the limits of joints are not checked: [KINS]KINEMATICS is {name}\n",
            ini.as_deref().unwrap_or(Path::new("")).display()
        ));
    }
    Stdio.out(&text)?;
    let mut wrong = false;
    for file in &files {
        wrong |= one(file, &world, most, is_given(Id::Quiet))?;
    }
    Ok(if wrong { ExitCode::FAILURE } else { ExitCode::SUCCESS })
}

/// Checks one file; returns whether it has an error.
fn one(file: &str, world: &World, most: u64, quiet: bool) -> Result<bool, String> {
    let machine = &world.machine;
    let text = filter::load(Path::new(file), machine)?;
    let mut it = Interpreter::new(machine.settings.clone(), machine.numbered.clone());
    start(&mut it, world)?;
    let other_control = foreign::told(file, &text, world)?;
    it.load(file, text);
    let mut check = Check::new(&it, world);
    check.text.push_str(&other_control);
    let mut result = run(
        &mut it,
        world,
        Answers { probe_trips: true, functions: world.functions.as_ref() },
        |it, i| check.call(it, i),
    );
    while let Err(Stop::Program(error)) = result {
        check.error(&error, world);
        check.errors += 1;
        let last = matches!(
            error.problem,
            Problem::NoProgramEnd
                | Problem::LinesSpent { .. }
                | Problem::RunAway { .. }
                | Problem::NoFile { .. }
        );
        // The next lines show their own errors.
        if last || check.errors >= most || it.state.levels.is_empty() {
            result = Ok(());
            break;
        }
        it.state.ended = false;
        it.state.pending = None;
        it.state.nurbs = None;
        result = run(
            &mut it,
            world,
            Answers { probe_trips: true, functions: world.functions.as_ref() },
            |it, i| check.call(it, i),
        );
    }
    if let Err(Stop::Output(reason)) = result {
        return Err(reason);
    }
    let found = check.threads.finish(&world.machine);
    check.found(file, found);
    check.limits(file);
    let wrong = check.errors > 0;
    if !quiet {
        check.summary(file);
    }
    Stdio.out(&check.text)?;
    Ok(wrong)
}

/// The part of a program that one tool cuts.
#[derive(Clone, Debug, Default)]
struct Use {
    line: u32,
    way: f64,
}

/// A limit that moves go beyond: the first line, the number of moves, and the farthest place.
#[derive(Clone, Debug)]
struct Beyond {
    file: Box<str>,
    line: u32,
    moves: u64,
    farthest: f64,
    limit: f64,
}

/// The findings of a file.
struct Check<'a> {
    world: &'a World,
    way: Way,
    threads: Threads,
    text: String,
    errors: u64,
    all: Extents,
    cut: Extents,
    rapid: f64,
    /// The feed rate that the last call set, and whether it counts by revolution.
    feed: (f64, bool),
    speed: f64,
    minutes: f64,
    /// The planner's time, if the INI file states what it needs.
    clock: Option<Clock>,
    /// Moves that the planner refused, and those that the axes cannot follow.
    refused: u64,
    unfollowed: u64,
    tools: BTreeMap<i32, Use>,
    /// Lowest height of Z at which a rapid move crosses the part, in machine coordinates.
    crossing: Option<f64>,
    /// The limits of an axis that moves go beyond: lower, upper.
    beyond: BTreeMap<(usize, bool), Beyond>,
}

impl<'a> Check<'a> {
    fn new(it: &Interpreter, world: &'a World) -> Self {
        Self {
            world,
            way: Way::new(it.state.frame, it.state.position),
            threads: Threads::new(&it.state),
            text: String::new(),
            errors: 0,
            all: Extents::new(),
            cut: Extents::new(),
            rapid: 0.0,
            feed: (it.state.modal.feed, it.state.modal.feed_mode == FeedMode::PerRevolution),
            speed: it.state.modal.spindles.first().map_or(0.0, |s| s.speed),
            minutes: 0.0,
            clock: Clock::new(it, &world.machine),
            refused: 0,
            unfollowed: 0,
            tools: BTreeMap::new(),
            crossing: None,
            beyond: BTreeMap::new(),
        }
    }

    /// Takes a call into account.
    fn call(&mut self, it: &Interpreter, issued: &Issued) -> Result<(), Stop> {
        let state = &it.state;
        // This dialect has no messages of its own, so that each is a warning of the interpreter.
        let is_rs274d = state.settings.dialect == Dialect::Rs274d;
        let tool = state.tool.number;
        // The line of the main program, also while a subroutine changes the tool.
        let main = state.levels.first().map_or(issued.line, |l| l.cursor.line);
        if let Call::ChangeTool(number) | Call::ChangeToolNumber(number) = issued.call {
            self.tools.entry(number).or_insert(Use { line: main, way: 0.0 });
        }
        if matches!(issued.call, Call::StraightTraverse(_)) && !self.all.any {
            self.all.add(self.way.at);
        }
        match issued.call {
            // In inverse time, each move has its own.
            Call::SetFeedRate(feed) => self.feed.0 = feed,
            Call::SetFeedMode { per_revolution, .. } => self.feed.1 = per_revolution,
            Call::SetSpindleSpeed { spindle: 0, speed } => self.speed = speed,
            Call::Message(ref text) if is_rs274d => self.text.push_str(&format!("{text}\n")),
            _ => {}
        }
        if let Some(Err(error)) = self.clock.as_mut().map(|clock| clock.call(issued)) {
            self.refusal(it, &error);
        }
        let mut from = self.way.at;
        let mut moved = Vec::new();
        self.way.follow(&issued.call, &mut |kind, point| moved.push((kind, point)));
        let found = self.threads.call(&self.world.machine, issued, state, from, &moved);
        let file = state.levels.last().map(|l| l.file.clone()).unwrap_or_default();
        self.found(&file, found);
        for (kind, point) in moved {
            let length = distance(from, point);
            if self.cut.any || kind == Kind::Rapid {
                self.all.add(point);
            }
            match kind {
                Kind::Rapid => {
                    self.rapid += length;
                    if (from.x, from.y) != (point.x, point.y) {
                        let lowest = self.crossing.unwrap_or(f64::INFINITY);
                        self.crossing = Some(lowest.min(from.z).min(point.z));
                    }
                }
                Kind::Feed => {
                    self.all.add(from);
                    self.all.add(point);
                    self.cut.add(from);
                    self.cut.add(point);
                    self.tools.entry(tool).or_insert(Use { line: main, way: 0.0 }).way += length;
                    let (feed, per_revolution) = self.feed;
                    let turns = if per_revolution { self.speed } else { 1.0 };
                    let rate = feed * turns * state.frame.unit.millimetres();
                    self.minutes += if rate > 0.0 { length / rate } else { 0.0 };
                }
            }
            self.limit(it, issued.line, point);
            from = point;
        }
        Ok(())
    }

    /// Notes the axes that are beyond their travel.
    fn limit(&mut self, it: &Interpreter, line: u32, point: Position) {
        for (axis, side, limit) in self.world.machine.beyond(point) {
            let value = point[axis];
            let entry = self.beyond.entry((usize::from(axis.index()), side)).or_insert_with(|| {
                let file = it.state.levels.last().map(|l| l.file.clone()).unwrap_or_default();
                Beyond { file, line, moves: 0, farthest: value, limit }
            });
            entry.moves += 1;
            if (value > entry.farthest) == side {
                entry.farthest = value;
            }
        }
    }
}
