//! Starts at the place where a job broke off.

use super::*;
use hal_gcode::{Interpreter, State, parameters::file::ParameterFile};
use hal_job::journal::{Begin, Journal};

/// A job with two tools, calls, loops, an input, cutter compensation and a series of cycles.
const JOB: &str = "\
G21 G90 G64 P0.1
T1 M6
G43 H1
M3 S1000
o<hole> sub
  G0 X#1 Y#2
  G1 Z-1 F60
  G0 Z5
o<hole> endsub
G0 Z5
o1 repeat [4]
#5=[#5+1]
o<hole> call [#5] [2]
o1 endrepeat
M66 P1 L3 Q5
#7=#5399
M8
G91
o2 while [#7 LT 4]
#7=[#7+1]
G1 X#7
G1 Y-1
o2 endwhile
G90
G10 L2 P2 X[10*#7] Y1
G0 Z9
G42.1 D2
G1 X20 Y20
G1 X30
G1 Y30
G40 G1 X0 Y0
G81 X1 Y1 Z-1 R2
X2
X3
G80
M64 P3
T2 M6
G43 H2
S500 M4
G55
G92 Y1
G1 X3 F120
X4 Y5
G92.1
M9
G0 X0
M2
";

/// Random numbers from a seed.
struct Random(u64);

impl Random {
    fn below(&mut self, bound: u64) -> u64 {
        self.0 =
            self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 33) % bound
    }
}

fn machine(program: &str) -> Rig {
    Rig::on_machine(program, |machine, _| {
        machine.settings.axes = hal_gcode::axis::AxisMask(7);
        machine.limits[2] = (Some(-50.0), Some(80.0));
    })
}

/// A machine after a loss of power: another task, with the files of this one.
fn after_loss(rig: &Rig, journal: String) -> Rig {
    let mut new = machine("M2\n");
    new.fake.journal = journal;
    let path = rig.folder.join("job.ngc");
    assert!(path.exists());
    // The program stays where it is, as long as the first machine lives.
    new.good(Command::Mode(Mode::Auto));
    new
}

impl Rig {
    /// Recovers, and returns the lines of the proposal or the refusal.
    fn recovered(&mut self) -> Result<Vec<String>, String> {
        let ticket = self.send(Command::Recover);
        for _ in 0..1000 {
            if let Some(result) = self.result(ticket) {
                return result.map(|()| self.core.shown_start().unwrap().lines.clone());
            }
            self.step();
        }
        panic!("the search does not end");
    }

    /// Runs for this time with a person at the changer, and the input that the job waits for.
    fn run_for(&mut self, seconds: f64) {
        let end = self.fake.now + seconds;
        while self.fake.now < end {
            self.pass(0.01);
            if self.fake.now % 0.5 < 0.01 {
                self.fake.answer_changer();
            }
            self.fake.motion.digital_in = 2;
        }
    }
}

/// The states before each line of an unbroken run, by the number of lines before it.
fn unbroken(begin: &Begin, rig: &Rig, answers: &[hal_gcode::Answer]) -> BTreeMap<u64, State> {
    let mut it = Interpreter::from_state(begin.state.clone());
    it.supply(&begin.name, hal_job::world::program(&begin.path).unwrap());
    let (mut calls, mut answers) = (Vec::new(), answers.iter());
    let mut out = BTreeMap::new();
    loop {
        out.insert(it.state.lines_run, it.state.clone());
        let mut step = it.next(&rig.core.world, &mut calls).unwrap();
        while let hal_gcode::Step::Ask(_) = step {
            step = it.answer(answers.next().unwrap(), &rig.core.world, &mut calls).unwrap();
        }
        if step == hal_gcode::Step::Ended {
            return out;
        }
    }
}

#[test]
fn killed_at_100_random_moments_a_job_goes_on_in_the_state_of_the_unbroken_run() {
    // The unbroken run: its orders, its answers and its states.
    let mut whole = machine(JOB);
    let ticket = whole.send(Command::Run);
    while whole.result(ticket).is_none() {
        whole.run_for(0.1);
    }
    assert_eq!(whole.result(ticket), Some(Ok(())));
    let duration = whole.fake.now;
    let orders: Vec<String> = whole.sent();
    let moves = |orders: &[String]| -> Vec<String> {
        orders.iter().filter(|o| o.contains(": ")).filter(|o| o.contains("line")).cloned().collect()
    };
    let (mut stepped, mut lines) = (0, std::collections::BTreeSet::new());
    let mut random = Random(2026);
    for seed in 0..100 {
        let mut broken = machine(JOB);
        broken.send(Command::Run);
        let moment = 0.02 + random.below(10_000) as f64 / 10_000.0 * (duration - 0.1);
        broken.run_for(moment);
        // The power goes while a record is written: its end is lost, or not.
        let mut text = broken.fake.journal.clone();
        let first = text.find('\n').unwrap() + 1;
        if seed % 3 == 0 && text.len() > first {
            let lost = 1 + usize::try_from(random.below(40)).unwrap();
            text.truncate(first.max(text.len() - lost));
        }
        let known = Journal::parse(text.as_bytes()).unwrap();
        let states = unbroken(
            &known.begin,
            &broken,
            &Journal::parse(whole.fake.journal.as_bytes()).unwrap().answers,
        );
        let at = known.at.as_ref().map_or(0, |at| at.number);
        let mut new = after_loss(&broken, text);
        new.fake.io.tool = broken.fake.io.tool;
        let shown = new.recovered().unwrap_or_else(|e| panic!("{seed} at {moment}: {e}"));
        assert!(new.sent().is_empty(), "nothing moves by itself");
        let (found, interpreter) = new.core.proposed().unwrap();
        let number = found.begin.number;
        assert!(number <= at, "{seed}: {number} is behind the last finished line {at}");
        stepped += u32::from(number < at);
        lines.insert(number);
        assert_eq!(found.state, states[&number], "{seed} at {moment}: {shown:#?}");
        assert_eq!(interpreter.state.levels, states[&number].levels);
        // After the entry, the job is the rest of the unbroken run.
        let token = new.core.shown_start().unwrap().lines[0].clone();
        let token = token.split("token=").nth(1).unwrap().split(' ').next().unwrap().to_owned();
        let ticket = new.send(Command::Confirm(token.parse().unwrap()));
        let mut waits = 0;
        while new.result(ticket).is_none() {
            new.run_for(0.1);
            waits += 1;
            assert!(waits < 600, "{seed} at {moment} does not end");
        }
        assert_eq!(new.result(ticket), Some(Ok(())), "{seed} at {moment}");
        let all = moves(&orders);
        let rest = moves(&new.sent());
        let entry = shown.iter().filter(|row| row.starts_with("entry") && row.contains(": X"));
        let entry = entry.filter(|row| !row.contains("offset")).count();
        let rest = &rest[entry..];
        assert_eq!(all[all.len() - rest.len()..], *rest, "{seed} at {moment}: {shown:#?}");
    }
    assert!(stepped >= 5, "{stepped} moments were in a series");
    assert!(lines.len() >= 15, "{} places", lines.len());
}

#[test]
fn a_job_that_was_aborted_goes_on_from_its_journal() {
    let mut rig = machine("G21 F100\nG1 X1\nG1 X2\nG1 X3\nM2\n");
    rig.send(Command::Run);
    rig.pass(0.15);
    rig.good(Command::Abort);
    rig.pass(0.2);
    rig.sent();
    let shown = rig.recovered().unwrap();
    assert!(shown[0].contains("line=3 "), "{shown:#?}");
    assert!(shown.iter().any(|row| row.contains("position X1.0000")), "{shown:#?}");
    assert!(shown.iter().any(|row| row.contains("broke off at line 3")), "{shown:#?}");
    // A job that ends has nothing to resume.
    rig.send(Command::Run);
    rig.pass(1.0);
    let why = rig.recovered().unwrap_err();
    assert_eq!(why, "the last job has ended: there is nothing to resume");
}

#[test]
fn parameters_that_a_series_has_changed_are_those_of_the_place_and_not_of_the_line_before_it() {
    let job =
        "G21 F100\n#100=[#100+5]\nG0 Z5\nG81 X1 Y1 Z-1 R2\n#100=[#100+1]\nX#100\nX9\nG80\nM2\n";
    let mut rig = machine(job);
    let file = ParameterFile::parse("100 0\n");
    rig.core.world.machine.parameters = Some((PathBuf::new(), file));
    rig.send(Command::Run);
    for _ in 0..1000 {
        rig.pass(0.01);
        if rig.core.line() >= 6 {
            break;
        }
    }
    rig.pass(0.15);
    rig.good(Command::Abort);
    rig.pass(0.2);
    assert_eq!(rig.core.interpreter.state.numbered.get(100), 6.0);
    let shown = rig.recovered().unwrap();
    assert!(shown.iter().any(|row| row.contains("in the middle of a series")), "{shown:#?}");
    let (found, _) = rig.core.proposed().unwrap();
    assert_eq!(found.state.numbered.get(100), 5.0, "the start is before the series");
}

#[test]
fn a_machine_that_is_not_as_the_job_left_it_is_refused_by_name() {
    type Change = fn(&mut Rig, &Path);
    let changes: [(Change, &str); 8] = [
        (
            |_, path| std::fs::write(path, "G21 F100\nG1 X1\nG1 X2\nG1 X4\nM2\n").unwrap(),
            "job.ngc: the program has changed",
        ),
        (|_, path| std::fs::write(path, "M2\n").unwrap(), "job.ngc: the program has changed"),
        (|_, path| std::fs::remove_file(path).unwrap(), "job.ngc: No such file"),
        (
            |rig, _| rig.core.interpreter.state.numbered.put(5221, 7.0),
            "parameter #5221 is 7 and was 0",
        ),
        (
            |rig, _| {
                let file = ParameterFile::parse("100 4\n");
                file.apply(&mut rig.core.interpreter.state.numbered);
                rig.core.world.machine.parameters = Some((PathBuf::new(), file));
            },
            "parameter #100 is 4 and was 0",
        ),
        (
            |rig, _| rig.core.world.machine.tools.tools[0].offset.z = 11.0,
            "tool 1 of the tool table",
        ),
        (
            |rig, _| rig.core.world.machine.settings.arc_tolerance = 5.0,
            "the machine's INI file has changed",
        ),
        (|rig, _| rig.fake.journal.clear(), "the journal has no job"),
    ];
    for (change, wanted) in changes {
        let mut rig = machine("G21 F100\nG1 X1\nG1 X2\nG1 X3\nM2\n");
        rig.send(Command::Run);
        rig.pass(0.25);
        let mut new = after_loss(&rig, rig.fake.journal.clone());
        change(&mut new, &rig.folder.join("job.ngc"));
        let open = new.core.program.take();
        let why = new.recovered().unwrap_err();
        assert!(why.contains(wanted), "{wanted}: {why}");
        assert_eq!(new.core.program, None, "{wanted}: the open program stays");
        new.core.program = open;
        assert!(new.sent().is_empty() && new.core.shown_start().is_none());
    }
}

#[test]
fn offsets_with_more_decimals_than_the_parameter_file_has_are_those_of_the_job() {
    let mut rig = machine("G21 F100\nG1 X1\nG1 X2\nG1 X3\nM2\n");
    rig.core.interpreter.state.numbered.put(5221, 1.0 / 3.0);
    rig.send(Command::Run);
    rig.pass(0.25);
    let mut new = after_loss(&rig, rig.fake.journal.clone());
    new.core.interpreter.state.numbered.put(5221, 0.333_333);
    new.recovered().unwrap();
    let (found, _) = new.core.proposed().unwrap();
    assert_eq!(found.state.numbered.get(5221), 1.0 / 3.0, "the job's own value");
}

#[test]
fn the_journal_has_the_subroutines_of_calls_that_end_within_a_step() {
    let mut rig = machine("G21 F100\no<outer> call\nG1 X1\nG1 X2\nM2\n");
    let sub = |name: &str, body: &str| {
        let text = format!("o<{name}> sub\n{body}\no<{name}> endsub\nM2\n");
        std::fs::write(rig.folder.join(format!("{name}.ngc")), text).unwrap();
    };
    sub("outer", "o<inner> call");
    sub("inner", "G1 X9");
    rig.send(Command::Run);
    rig.pass(0.25);
    let journal = Journal::parse(rig.fake.journal.as_bytes()).unwrap();
    let mut names: Vec<&str> = journal.files.iter().map(|(name, _)| &**name).collect();
    names.sort_unstable();
    assert!(names.len() == 3 && names[1..] == ["inner", "outer"], "{names:?}");
}

#[test]
fn a_machine_that_is_not_homed_is_shown_the_place_and_no_entry() {
    let mut rig = machine("G21 F100\nG1 X1\nG1 X2\nG1 X3\nM2\n");
    rig.send(Command::Run);
    rig.pass(0.25);
    let mut new = after_loss(&rig, rig.fake.journal.clone());
    new.fake.motion.all_homed = false;
    let shown = new.recovered().unwrap();
    let last = &shown[shown.len() - 1];
    assert_eq!(last, "not-ready a program needs homed joints: task.home joint=all");
    assert!(!new.fake.motion.all_homed, "the journal never homes");
}

#[test]
fn a_job_that_broke_off_goes_on_with_the_values_of_hal_that_it_read() {
    let mut rig = machine("G21 F100\n#1=#<_hal[a.b]>\nG1 X1\nG1 X#1\nG1 X3\nM2\n");
    rig.fake.hal.insert("a.b".to_owned(), 2.5);
    rig.send(Command::Run);
    rig.pass(0.25);
    let mut new = after_loss(&rig, rig.fake.journal.clone());
    new.fake.hal.insert("a.b".to_owned(), 8.0);
    new.recovered().unwrap();
    let (found, _) = new.core.proposed().unwrap();
    assert_eq!(found.state.numbered.get(1), 2.5, "the job's own value");
}

#[test]
fn a_disk_that_is_full_ends_the_journal_and_not_the_job() {
    let mut rig = machine("G21 F100\nG1 X1\nG1 X2\nG1 X3\nM2\n");
    let ticket = rig.send(Command::Run);
    rig.pass(0.15);
    rig.fake.disk_is_full = true;
    rig.pass(1.0);
    assert_eq!(rig.result(ticket), Some(Ok(())));
    let wanted = "job.journal: No space left on device: the job goes on without a journal";
    assert_eq!(rig.fake.messages, [wanted]);
}

#[test]
fn a_program_that_changes_while_it_runs_ends_the_job() {
    let mut text = "G21\n".to_owned();
    for n in 0..20_000 {
        text.push_str(&format!("G0 X{}\n", n % 7));
    }
    text.push_str("M2\n");
    let mut rig = machine(&text);
    let ticket = rig.send(Command::Run);
    rig.pass(1.0);
    assert_eq!(rig.result(ticket), None);
    std::fs::write(rig.folder.join("job.ngc"), text.replace("X3", "X999")).unwrap();
    for _ in 0..3000 {
        rig.pass(0.5);
        if rig.result(ticket).is_some() {
            break;
        }
    }
    let why = rig.result(ticket).unwrap().unwrap_err();
    assert!(why.contains("it has changed since it was opened"), "{why}");
    assert!(rig.sent().iter().all(|order| !order.contains("line 999")));
    // Its journal does not lead into the other program.
    let why = rig.recovered().unwrap_err();
    assert!(why.contains("job.ngc: the program has changed since the job began"), "{why}");
}

#[test]
fn the_place_of_a_break_is_that_on_the_move_and_names_pass_and_call() {
    let program = "G21 G90 G64 F1000\no<foo> sub\nG1 X20\nG1 X0\no<foo> endsub\no100 repeat [3]\no<foo> call\no100 \
                   endrepeat\nM2\n";
    let mut rig = Rig::new(program);
    rig.fake.move_time = 1.0;
    rig.send(Command::Run);
    // In the first move of the second call.
    rig.pass(2.5);
    rig.fake.motion.pose[0] = 12.0;
    (rig.fake.motion.travelled, rig.fake.motion.to_go) = (12.0, 8.0);
    rig.pass(0.2);
    // The machine brakes for half a millimetre.
    rig.good(Command::Abort);
    rig.fake.motion.pose[0] = 12.5;
    (rig.fake.motion.travelled, rig.fake.motion.to_go) = (0.0, 0.0);
    rig.pass(0.2);
    let ticket = rig.send(Command::Recover);
    rig.pass(0.2);
    assert_eq!(rig.result(ticket), Some(Ok(())));
    let lines = rig.core.shown_start().unwrap().lines.clone();
    let has = |part: &str| lines.iter().any(|line| line.contains(part));
    assert!(has("broke off at line 3, near X12.5000"), "{lines:#?}");
    assert!(has(", 12.500 mm along its move and 7.500 mm before its end, homed"), "{lines:#?}");
    assert!(has(":3, pass 2 of 3, in sub foo called from "), "{lines:#?}");
}
