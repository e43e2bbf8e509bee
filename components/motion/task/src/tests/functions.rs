//! Functions in Python in a job: the same orders twice, an abort in the middle, and what is not known without them.

use super::*;
use hal_golden::tools::Tool;
use hal_job::dry_run::Target;

/// A machine with the functions of the tests of `hal-job`, and this program; `None` without Python.
fn rig(program: &str) -> Option<Rig> {
    rig_with(program, |_| {})
}

fn rig_with(program: &str, change: impl FnOnce(&mut Rules)) -> Option<Rig> {
    if !Tool::of("python3").is_installed() {
        return None;
    }
    let ini = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../job/tests/functions/machine.ini");
    let read = Machine::read(&Files { ini: Some(&ini), ..Files::default() }).unwrap();
    let mut functions = None;
    let mut rig = Rig::on_machine(program, |machine, rules| {
        change(rules);
        machine.settings.remaps = read.settings.remaps;
        machine.settings.task = true;
        machine.python = read.python;
        machine.folders.extend(read.folders);
        functions = machine.start_functions(true);
        assert_eq!(machine.remarks, Vec::<String>::new());
    });
    rig.fake.functions = functions;
    Some(rig)
}

const PROGRAM: &str =
    "G21 G64 F600\nG1 X1\nG88.6 X2 Y2\nG1 X20\no<yields> call\nG1 X[#<_value>]\nM402 P2\nM2\n";

#[test]
fn lines_of_functions_are_moves_like_others_and_the_same_twice() {
    let Some(mut first) = rig(PROGRAM) else { return };
    let sent = first.run();
    let moves: Vec<&String> = sent.iter().filter(|l| l.contains(": line")).collect();
    let wanted = [
        "2: line 1 0 0",
        "3: line 2 2 0",
        "3: line 3 1 0",
        "3: line 4 0 0",
        "4: line 20 0 0",
        "5: line 5 0 0",
        "6: line 7.5 0 0",
    ];
    assert_eq!(moves[..7], wanted, "{sent:#?}");
    assert!(first.fake.messages.iter().any(|m| m == "behind: value 12 of True, given 6"));
    assert_eq!(rig(PROGRAM).unwrap().run(), sent);
}

#[test]
fn reading_goes_on_in_a_function_while_the_moves_before_run() {
    let Some(mut rig) = rig("G21 F600\nG1 X1\nG88.6 X2 Y2\nM2\n") else { return };
    rig.fake.move_time = 50.0;
    rig.send(Command::Run);
    rig.pass(1.0);
    let sent = rig.sent();
    assert!(sent.iter().any(|l| l == "3: line 4 0 0"), "the first move has not ended: {sent:#?}");
}

#[test]
fn an_abort_ends_a_function_and_the_next_call_begins_anew() {
    let Some(mut rig) = rig("G21\nG0 X1\nM406\nM2\n") else { return };
    rig.fake.is_patient = false;
    let ticket = rig.send(Command::Run);
    rig.pass(0.3);
    assert_eq!(rig.result(ticket), None);
    assert!(rig.fake.functions.as_ref().unwrap().is_busy());
    rig.good(Command::Abort);
    rig.pass(0.3);
    assert_eq!(rig.result(ticket), Some(Err("aborted".to_owned())));
    assert!(!rig.fake.functions.as_ref().unwrap().is_busy());
    rig.fake.is_patient = true;
    let ticket = rig.send(Command::Run);
    rig.pass(0.3);
    let why = rig.result(ticket).unwrap().unwrap_err();
    assert!(why.contains("job.ngc:3: endless: it made no step within 2 s"), "{why}");
}

#[test]
fn what_only_a_function_knows_ends_the_check_and_refuses_a_start_behind_it() {
    let Some(mut rig) = rig("G21\nG0 X1\nM400 P1\nG0 Z900\nM2\n") else { return };
    // Without the function, the place beyond the limit would refuse the start.
    let ticket = rig.send(Command::Run);
    rig.pass(0.3);
    assert_ne!(rig.result(ticket), None);
    assert!(rig.sent().iter().any(|l| l == "2: line 1 0 0"));
    let ticket = rig.send(Command::RunFrom(Target::Line { file: None, line: 4, pass: 1 }));
    rig.pass(0.3);
    let why = rig.result(ticket).unwrap().unwrap_err();
    let wanted = "job.ngc:3: the effect of a function in Python is not known without the machine";
    assert!(why.contains(wanted), "{why}");
}

#[test]
fn lines_behind_a_tool_change_of_a_function_begin_at_its_place() {
    for code in ["M414", "M416"] {
        let program = format!("G21\nG0 X100 Y100 Z-20\nT1\n{code}\nM2\n");
        let at = |rules: &mut Rules| {
            let mut place = [None; 9];
            place[..3].copy_from_slice(&[Some(0.0), Some(0.0), Some(15.0)]);
            rules.change_position = Some(place);
        };
        let Some(mut rig) = rig_with(&program, at) else { return };
        let sent = rig.run();
        let moves: Vec<&String> = sent.iter().filter(|l| l.contains(": line")).collect();
        assert_eq!(moves, ["2: line 100 100 -20", "4: line 0 0 15", "4: line 50 0 15"], "{code}");
    }
}

#[test]
fn a_function_at_work_delays_no_move_before_it() {
    let moves: String = (1..200).map(|n| format!("G0 X{n}\n")).collect();
    let Some(mut rig) = rig(&format!("G21\n{moves}M406\nM2\n")) else { return };
    rig.fake.is_patient = false;
    rig.send(Command::Run);
    let mut steps = 0;
    while rig.fake.log.iter().filter(|l| l.contains(": line")).count() < 199 {
        rig.pass(0.01);
        steps += 1;
        assert!(steps < 1000, "the moves are not sent");
    }
    assert!(rig.fake.looks <= steps, "{} waits in {steps} steps", rig.fake.looks);
    rig.good(Command::Abort);
}
