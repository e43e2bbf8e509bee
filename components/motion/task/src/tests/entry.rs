//! The entry of a start in the middle: what it does before the program goes on, and what ends it.

use super::*;
use hal_job::dry_run::Target;

/// Proposes a start at a line and returns the lines that show it.
fn proposed(rig: &mut Rig, line: u32) -> Vec<String> {
    let ticket = rig.send(Command::RunFrom(Target::Line { file: None, line, pass: 1 }));
    for _ in 0..100 {
        rig.step();
        if let Some(result) = rig.result(ticket) {
            assert_eq!(result, Ok(()));
            return rig.core.shown_start().unwrap().lines.clone();
        }
    }
    panic!("the dry run does not end");
}

/// Confirms the first proposal of a rig, and lets this many seconds pass.
fn confirmed(rig: &mut Rig, seconds: f64) -> Ticket {
    let ticket = rig.send(Command::Confirm(1));
    rig.pass(seconds);
    ticket
}

/// Executes a line of MDI and returns to mode auto.
fn mdi(rig: &mut Rig, text: &str) {
    rig.good(Command::Mode(Mode::Mdi));
    let ticket = rig.send(Command::Mdi(text.into()));
    rig.pass(0.5);
    assert_eq!(rig.result(ticket), Some(Ok(())));
    rig.good(Command::Mode(Mode::Auto));
}

const TWO_TOOLS: &str = "G21\nT1 M6\nG43 H1\n#500=9\nG0 X1\nG0 X2\n#500=7 T2 M6\nG0 X3\nM2\n";

#[test]
fn the_operator_is_asked_for_the_tool_of_the_entry_and_not_of_a_line_that_was_read_ahead() {
    let mut rig = Rig::new(TWO_TOOLS);
    proposed(&mut rig, 6);
    confirmed(&mut rig, 0.5);
    assert_eq!(rig.fake.changer.len(), 1, "the changer is asked to prepare");
    assert_eq!((rig.core.awaited_tool(), rig.core.line()), (Some(1), 6));
    rig.fake.answer_changer();
    rig.pass(0.1);
    assert_eq!(rig.fake.changer[0].1, IoRequest::Change);
    assert_eq!((rig.core.awaited_tool(), rig.core.line()), (Some(1), 6));
    rig.fake.answer_changer();
    rig.pass(2.0);
    assert_eq!((rig.core.awaited_tool(), rig.core.line()), (Some(2), 7));
}

#[test]
fn every_spindle_stops_before_the_entry_changes_the_tool() {
    let mut rig = Rig::new("G21\nT1 M6\nM3 S1000\nG0 X1\nG0 X2\nM2\n");
    mdi(&mut rig, "M3 S500");
    rig.sent();
    proposed(&mut rig, 5);
    confirmed(&mut rig, 0.5);
    let sent = rig.sent();
    let at = |what: &str| sent.iter().position(|s| s.starts_with(what)).unwrap();
    assert!(at("Spindle { spindle: 0, speed: 0.0 }") < at("Prepare"), "{sent:#?}");
}

#[test]
fn mdi_during_a_dry_run_ends_it_and_its_effect_stays() {
    let program = "G21\no1 repeat [5000]\nG0 X1\nG0 X2\no1 endrepeat\nG0 X7\nM2\n";
    let mut rig = Rig::new(program);
    let target = Target::Line { file: None, line: 6, pass: 1 };
    let ticket = rig.send(Command::RunFrom(target));
    rig.step();
    assert_eq!(rig.result(ticket), None);
    mdi(&mut rig, "#500=3");
    assert_eq!(rig.result(ticket), Some(Err("another job has begun".to_owned())));
    assert!(rig.refused(Command::Confirm(1)).contains("token 1 is not that"));
    assert_eq!(rig.core.interpreter.state.numbered.get(500), 3.0);
}

#[test]
fn without_a_safe_height_nothing_begins() {
    let mut rig = Rig::on_machine(TWO_TOOLS, |machine, _| {
        machine.limits[2] = (None, None);
        machine.settings.axes = hal_gcode::axis::AxisMask(7);
    });
    proposed(&mut rig, 6);
    let why = rig.refused(Command::Confirm(1));
    assert!(why.contains("[TASK]SAFE_HEIGHT"), "{why}");
    assert!(rig.sent().is_empty());
    // A height of the INI file suffices.
    let mut rig = Rig::on_machine(TWO_TOOLS, |machine, rules| {
        (machine.limits[2], rules.safe_height) = ((None, None), Some(30.0));
    });
    let shown = proposed(&mut rig, 6);
    assert!(shown.iter().any(|row| row.contains("up to Z30.0000")), "{shown:#?}");
}

#[test]
fn the_entry_sets_coolant_and_keeps_the_switch_of_block_delete() {
    let mut rig = Rig::new("G21\nG0 X1\nG0 X2\n/G0 X3\nM2\n");
    proposed(&mut rig, 3);
    // Somebody turns coolant and the switch on after the proposal.
    rig.fake.io.flood = true;
    rig.good(Command::BlockDelete(true));
    let ticket = confirmed(&mut rig, 3.0);
    assert_eq!(rig.result(ticket), Some(Ok(())));
    let sent = rig.sent();
    assert!(sent.iter().any(|s| s.starts_with("Coolant { mist: Some(false), flood: Some(false)")));
    assert!(!sent.iter().any(|s| s.starts_with("4: ")), "{sent:#?}");
}

#[test]
fn an_abort_in_the_entry_leaves_the_machine_as_it_was_before() {
    let mut rig = Rig::new(TWO_TOOLS);
    mdi(&mut rig, "G20 #500=4");
    let before = rig.core.interpreter.state.clone();
    proposed(&mut rig, 6);
    let ticket = confirmed(&mut rig, 0.5);
    rig.good(Command::Abort);
    rig.pass(0.5);
    assert_eq!(rig.result(ticket), Some(Err("aborted".to_owned())));
    let after = &rig.core.interpreter.state;
    assert_eq!(after.numbered.get(500), 4.0);
    assert_eq!((&after.modal, after.frame), (&before.modal, before.frame));
    // The steps that were executed stay: the tool and its offset.
    let mut rig = Rig::new(TWO_TOOLS);
    mdi(&mut rig, "G20 #500=4");
    proposed(&mut rig, 6);
    confirmed(&mut rig, 0.5);
    for _ in 0..2 {
        rig.fake.answer_changer();
        rig.pass(0.03);
    }
    rig.good(Command::Abort);
    rig.pass(0.5);
    let after = &rig.core.interpreter.state;
    assert_eq!((after.numbered.get(500), after.tool.number), (4.0, 1));
    assert!((after.frame.tool.z - 10.0 / 25.4).abs() < 1e-9, "{}", after.frame.tool.z);
    assert!(after.modal.tool_offset);
}

#[test]
fn a_quill_is_drawn_all_the_way_back_before_the_machine_goes_over_the_place() {
    let quill = |high: Option<f64>| {
        Rig::on_machine("G21\nG0 X1 W-50\nG0 X2\nG0 X3\nM2\n", |machine, rules| {
            machine.settings.axes = hal_gcode::axis::AxisMask(0b1_0000_0111);
            machine.limits[8] = (Some(-60.0), high);
            rules.safe_height = Some(5.0);
        })
    };
    // The quill is where it is at the line, farther out, and back.
    for out in [-50.0, -59.0, 0.0] {
        let mut rig = quill(Some(2.0));
        rig.fake.motion.pose[8] = out;
        rig.pass(0.1);
        let lines = proposed(&mut rig, 4);
        let named = "up: up to Z5.0000, quill back to W2.0000";
        assert!(lines.iter().any(|line| line.contains(named)), "{lines:#?}");
        let shown = rig.core.shown_start().unwrap();
        let json: serde_json::Value = serde_json::from_str(&shown.json).unwrap();
        let steps = json["entry"].as_array().unwrap().iter().filter(|step| !step["to"].is_null());
        let moves: Vec<_> =
            steps.map(|s| (s["kind"].as_str().unwrap(), s["to"][8].as_f64().unwrap())).collect();
        assert_eq!(moves, [("up", 2.0), ("over", 2.0), ("down", -50.0)]);
    }
    // Without a limit nobody knows how far back it goes.
    let mut rig = quill(None);
    proposed(&mut rig, 4);
    let why = rig.refused(Command::Confirm(1));
    assert!(why.contains("the quill W has no upper limit"), "{why}");
}

#[test]
fn the_proposal_names_files_that_the_start_does_not_open() {
    let mut rig =
        Rig::new("G21\n(LOGOPEN,a.txt)\n(PROBEOPEN b.txt)\n(PROBECLOSE)\nG0 X1\nG0 X2\nM2\n");
    let shown = proposed(&mut rig, 6);
    let notes: Vec<_> = shown.iter().filter(|line| line.starts_with("note ")).collect();
    assert_eq!(notes, ["note the log file a.txt is not open: nothing is written to it"]);
}
