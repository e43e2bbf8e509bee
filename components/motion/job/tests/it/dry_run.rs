//! Dry runs to random lines of the programs of hal-gcode: the state is that of the unbroken run, or the refusal is true.
#![expect(clippy::unwrap_used, reason = "tests")]
#![expect(clippy::print_stderr, reason = "the table of lines by kind")]

use hal_gcode::{
    Answer, Environment, Interpreter, Numbered, Request, State, Step, axis::AxisMask, canon::Unit,
    parameters::number, remap::Remap, tool::ToolTable,
};
use hal_job::{
    Files, Machine, World,
    dry_run::{DryRun, Found, Target},
    refusal::{Refusal, Series, Unknown},
    simulation::KnownAnswers,
};
use std::{
    collections::{BTreeMap, VecDeque},
    path::PathBuf,
    sync::Arc,
};

const TABLE: &str = "T1 P1 Z1.5 D6\nT2 P2 Z2.5 X0.5 D10\nT3 P3 Z0.3 X-1 D0.8 I85 J115 Q2\nT4 P4 Z1 D0.1\n\
                     T99999 P50 Z1 D1\n";
const REMAPS: [&str; 4] = [
    "M400 modalgroup=10 argspec=Pq ngc=lib-remap-named",
    "M401 modalgroup=10 argspec=@PQr ngc=lib-remap-positional",
    "M402 modalgroup=5 ngc=lib-remap-plain",
    "G88.6 modalgroup=1 argspec=XYzp ngc=lib-remap-move",
];

/// A sequence of numbers from a seed.
struct Random(u32);

impl Random {
    fn below(&mut self, bound: usize) -> usize {
        self.0 = self.0.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (self.0 >> 8) as usize % bound
    }
}

fn world(folder: PathBuf) -> World {
    let mut machine = Machine::read(&Files::default()).unwrap();
    machine.settings.axes = AxisMask::XYZABC;
    machine.settings.unit = Unit::Inch;
    machine.settings.block_delete = false;
    machine.settings.remaps = REMAPS.iter().map(|r| Remap::parse(r).unwrap()).collect();
    machine.tools = ToolTable::parse(TABLE).0;
    machine.folders = vec![folder];
    World { machine, hal: BTreeMap::new(), functions: None }
}

fn load(world: &World, name: &str) -> Interpreter {
    let settings = world.machine.settings.clone();
    let mut interpreter = Interpreter::new(settings, Numbered::default());
    interpreter.load(name, world.open(name.trim_end_matches(".ngc")).unwrap());
    interpreter
}

/// A line of an unbroken run: the state before it, and what the run had asked until then.
struct Line {
    state: State,
    pass: u32,
    answers: usize,
    asked: Option<Unknown>,
}

/// The answer of a machine whose probe trips, and whose inputs are on.
fn answer(request: &Request, state: &State) -> Answer {
    let here = state.frame.machine_mm(state.position);
    match request {
        Request::Probe => Answer::Probe { tripped_at: here, stopped_at: here, tripped: true },
        Request::ToolChange { .. } => Answer::ToolChange { position: None },
        Request::Input { .. } => Answer::Input(1.0),
        Request::Hal { names } => {
            Answer::Hal(names.iter().map(|name| (name.clone(), Some(1.0))).collect())
        }
        Request::Function { .. } | Request::Finish | Request::UserCode { .. } => Answer::Done,
    }
}

/// Runs a program unbroken, as far as its end, its error or the line with this number.
fn unbroken(world: &World, name: &str, at: u64) -> (Option<Line>, Vec<Answer>, u64) {
    let mut it = load(world, name);
    let (mut answers, mut asked, mut calls) = (Vec::new(), None, Vec::new());
    let mut times: BTreeMap<(Box<str>, u32), u32> = BTreeMap::new();
    loop {
        let level = it.state.levels.last().unwrap();
        let pass = times.entry((level.file.clone(), level.cursor.line + 1)).or_default();
        *pass += 1;
        if it.state.lines_run == at {
            let line = Line { pass: *pass, answers: answers.len(), asked, state: it.state.clone() };
            return (Some(line), answers, at);
        }
        let mut result = it.next(world, &mut calls);
        while let Ok(Step::Ask(request)) = &result {
            let unknown = match request {
                Request::Probe => Some(Unknown::Probe),
                Request::Input { .. } => Some(Unknown::Input),
                Request::Hal { .. } => Some(Unknown::Hal),
                Request::Function { .. } => Some(Unknown::Function),
                Request::ToolChange { .. } | Request::Finish | Request::UserCode { .. } => None,
            };
            asked = asked.or(unknown);
            let given = answer(request, &it.state);
            answers.push(given.clone());
            result = it.answer(&given, world, &mut calls);
        }
        calls.clear();
        if !matches!(result, Ok(Step::Line)) {
            return (None, answers, it.state.lines_run);
        }
    }
}

/// Runs dry to the end, in slices.
fn seek(world: &World, name: &str, target: Target, given: KnownAnswers) -> Result<Found, Refusal> {
    let mut run = DryRun::new(load(world, name), target, given);
    loop {
        if let Some(found) = run.advance(world, 7)? {
            let state = found.state.clone();
            assert_eq!(run.into_interpreter(&found).state, state);
            return Ok(found);
        }
    }
}

fn series(state: &State) -> Option<Series> {
    let chain = state.cycle.active == Some(state.modal.motion);
    match state {
        s if s.compensation.is_on() => Some(Series::Compensation),
        s if s.nurbs.is_some() => Some(Series::Nurbs),
        _ => chain.then_some(Series::Cycle),
    }
}

#[test]
fn a_dry_run_to_500_random_lines_gives_the_state_of_the_unbroken_run() {
    let folder =
        PathBuf::from(env!("CARGO_MANIFEST_DIR")).parent().unwrap().join("gcode/tests/programs");
    let world = world(folder.clone());
    let mut names: Vec<String> = std::fs::read_dir(folder)
        .unwrap()
        .map(|e| e.unwrap().file_name().into_string().unwrap())
        .filter(|n| n.ends_with(".ngc") && !n.starts_with("lib-"))
        .collect();
    names.sort();
    // Every second program is one with calls, remapped codes, questions or series.
    let begins = ["comp-", "cycle-", "flow-", "remap-", "m66-", "g38", "g5.2"];
    let hard: Vec<&String> =
        names.iter().filter(|n| begins.iter().any(|b| n.starts_with(b))).collect();
    let mut random = Random(17);
    let mut table: BTreeMap<&str, u32> = BTreeMap::new();
    let mut count = |kind| *table.entry(kind).or_default() += 1;
    for draw in 0..500 {
        let name = match draw % 2 {
            0 => &names[random.below(names.len())],
            _ => hard[random.below(hard.len())],
        };
        let (_, _, lines) = unbroken(&world, name, u64::MAX);
        let at = random.below(usize::try_from(lines.min(5000)).unwrap()) as u64;
        let (line, answers, _) = unbroken(&world, name, at);
        let Line { state, pass, answers: known, asked } = line.unwrap();
        let level = state.levels.last().unwrap();
        let (file, number) = (level.file.clone(), level.cursor.line + 1);
        let target = Target::Line { file: Some(file), line: number, pass };
        let recorded: VecDeque<Answer> = answers[..known].iter().cloned().collect();
        let without = seek(&world, name, target.clone(), KnownAnswers::default());
        let replay = KnownAnswers { answers: recorded, ..KnownAnswers::default() };
        let with = seek(&world, name, target, replay.clone());
        let by_number = seek(&world, name, Target::Number(at), replay);
        if let Some(of) = series(&state) {
            let from = [with, by_number].map(|result| match result {
                Err(Refusal::Middle { of: refused, from: Some(from), .. }) if refused == of => from,
                other => panic!("{name}: a start in {of} at {at}: {other:?}"),
            });
            // From the line that it names, a start is possible.
            assert!(from[0].number < at && from[0] == from[1], "{name} at {at}: {from:?}");
            let replay = KnownAnswers { answers: answers.into(), ..KnownAnswers::default() };
            seek(&world, name, Target::Number(from[0].number), replay).unwrap();
            count(match of {
                Series::Compensation => "refused: compensation",
                Series::Cycle => "refused: cycle",
                Series::Nurbs => "refused: NURBS",
                Series::Function => "refused: in a function",
            });
            continue;
        }
        let with = with.unwrap_or_else(|e| panic!("{name} at {at}: {e}"));
        assert_eq!(with.state, state, "{name} at {at}");
        assert_eq!(by_number.unwrap().state, state, "{name} at {at}");
        assert_eq!((with.pass.0, with.begin.number), (pass, at), "{name}");
        assert!(with.pass.1 >= pass && with.calls.len() + 1 == state.levels.len(), "{name}");
        match asked {
            Some(what) => {
                let Err(Refusal::Unknown { what: refused, .. }) = without else {
                    panic!("{name} at {at}: {what} is not known: {without:?}");
                };
                assert_eq!(refused, what, "{name} at {at}");
                count(if what == Unknown::Probe { "refused: probe" } else { "refused: M66" });
            }
            None => assert_eq!(without.unwrap().state, state, "{name} at {at}"),
        }
        count(match &state {
            s if s.levels.iter().any(|l| l.remapped.is_some()) => "equal: in a remapped code",
            s if s.levels.len() > 1 => "equal: in a subroutine",
            s if s.levels.iter().any(|l| !l.open.is_empty()) => "equal: in a loop or condition",
            s if s.tool.number != 0 || s.frame.tool != Default::default() => "equal: with a tool",
            s if s.frame.g5x != Default::default() || s.numbered.get(number::SYSTEM) != 1.0 => {
                "equal: in a coordinate system"
            }
            s if s.modal.spindles[0].speed != 0.0 => "equal: with a spindle speed",
            _ => "equal: elsewhere",
        });
    }
    for (kind, lines) in &table {
        eprintln!("{lines:4} {kind}");
    }
    let kinds = ["refused: compensation", "refused: cycle", "equal: in a subroutine"];
    assert!(kinds.iter().all(|k| table.get(k).is_some_and(|n| *n >= 5)), "{table:?}");
    assert!(table.values().sum::<u32>() >= 500 && table.len() >= 10, "{table:?}");
}

/// Returns the result for a program of these lines.
fn in_program(program: &str, target: Target, answers: &[Answer]) -> Result<Found, String> {
    let world = world(PathBuf::from("/nonexistent"));
    let settings = world.machine.settings.clone();
    let mut it = Interpreter::new(settings, Numbered::default());
    it.load("job.ngc", Arc::new(program.as_bytes().to_vec()));
    let given = KnownAnswers { answers: answers.to_vec().into(), ..KnownAnswers::default() };
    let mut run = DryRun::new(it, target, given);
    loop {
        match run.advance(&world, 1000) {
            Ok(None) => {}
            Ok(Some(found)) => return Ok(found),
            Err(refusal) => return Err(refusal.to_string()),
        }
    }
}

fn line(line: u32, pass: u32) -> Target {
    Target::Line { file: None, line, pass }
}

#[test]
fn what_only_the_machine_knows_is_refused_with_its_line() {
    for (program, wanted) in [
        ("G21\nM66 P0 L0\nG0 X1\nM2\n", "job.ngc:2: the result of M66 is not known"),
        ("G21 F10\nG38.3 Z-5\nG0 X1\nM2\n", "job.ngc:2: the result of a probe is not known"),
        ("G21\nG0 X#<_hal[a.b]>\nG0 X1\nM2\n", "job.ngc:2: a value of HAL is not known"),
        ("G21\n#1=EXISTS[#<_HAL[a.b]>]\nG0 X1\nM2\n", "job.ngc:2: a value of HAL is not known"),
        ("G21\nG0 X[1/0]\nG0 X1\nM2\n", "job.ngc:2:"),
        ("G21\nM2\nG0 X1\n", "job.ngc:3: the program does not reach this line"),
    ] {
        let why = in_program(program, line(3, 1), &[]).unwrap_err();
        assert!(why.starts_with(wanted), "{why}");
    }
    let probed = Answer::Input(7.0);
    let found = in_program("G21\nM66 P0 L0\nG0 X1\nM2\n", line(3, 1), &[probed]).unwrap();
    assert_eq!(found.state.numbered.get(number::INPUT), 7.0);
}

#[test]
fn a_line_is_found_as_often_as_it_is_reached() {
    let program = "G21 G91\no1 repeat [4]\nG0 X1\no1 endrepeat\nM62 P3\nM65 P1\nM68 E0 Q2.5\nM2\n";
    let found = in_program(program, line(3, 3), &[]).unwrap();
    assert_eq!((found.state.position.x, found.pass, found.more), (2.0, (3, 4), false));
    let why = in_program(program, line(3, 5), &[]).unwrap_err();
    assert_eq!(why, "job.ngc:3: the program reaches this line 4 times only");
    let outputs = in_program(program, line(8, 1), &[]).unwrap().effects.outputs;
    assert_eq!(outputs.digital, BTreeMap::from([(1, false), (3, true)]));
    assert_eq!(outputs.analog, BTreeMap::from([(0, 2.5)]));
    // Behind a found place, an error is no reason against a start there.
    let found = in_program("G21\nG0 X1\nG1 Y\nM2\n", line(2, 1), &[]).unwrap();
    assert_eq!(found.pass, (1, 1));
    // Endless programs end in the count.
    let found = in_program("o1 while [1]\nG0 X1\no1 endwhile\n", line(2, 2), &[]).unwrap();
    assert!(found.more && found.pass.1 > 1000, "{:?}", found.pass);
}

#[test]
fn a_start_in_a_series_names_the_lines_around_it() {
    let comp = "G21 F100\nG0 X-10\nG41.1 D2\nG1 X0\nG1 X10\nG40\nG0 X20\nM2\n";
    let why = in_program(comp, line(5, 1), &[]).unwrap_err();
    assert_eq!(
        why,
        "job.ngc:5: a start in the middle of cutter compensation is not possible; start at job.ngc:3 or job.ngc:7 instead"
    );
    let cycle = "G21 F100\nG0 Z5\nG81 X1 Z-1 R2\nX2\nX3\nG80\nM2\n";
    let why = in_program(cycle, line(4, 1), &[]).unwrap_err();
    assert_eq!(
        why,
        "job.ngc:4: a start in the middle of a series of canned cycles is not possible; start at job.ngc:3 or job.ngc:7 instead"
    );
    assert_eq!(in_program(cycle, line(3, 1), &[]).unwrap().state.position.z, 5.0);
}
