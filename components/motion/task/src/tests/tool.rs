//! The tool in the spindle: its record, interrupted changes, random changers.

use super::*;
use hal_job::spindle::UNKNOWN;

const CHANGE: &str = "G21 T2 M6\nG0 X1\nM2\n";

fn records(rig: &Rig) -> &[Spindle] {
    rig.fake.spindles.as_deref().unwrap_or_default()
}

/// Runs the program until the changer is asked to change.
fn changing() -> (Rig, Ticket) {
    let mut rig = Rig::new(CHANGE);
    let ticket = rig.send(Command::Run);
    rig.pass(0.1);
    rig.fake.answer_changer();
    rig.pass(0.1);
    assert_eq!(rig.fake.changer.front().map(|(_, r)| *r), Some(IoRequest::Change));
    (rig, ticket)
}

/// States in MDI which tool is in the spindle, and returns to mode auto.
fn state_tool(rig: &mut Rig, text: &str) {
    rig.good(Command::Mode(Mode::Mdi));
    let ticket = rig.send(Command::Mdi(text.into()));
    rig.pass(0.3);
    assert_eq!(rig.result(ticket), Some(Ok(())));
    rig.good(Command::Mode(Mode::Auto));
}

#[test]
fn a_change_is_written_before_it_begins_and_after_it_ends() {
    let (mut rig, ticket) = changing();
    assert_eq!(records(&rig), [Spindle::Changing { from: 0, to: 2 }]);
    rig.fake.answer_changer();
    rig.pass(0.5);
    assert_eq!(rig.result(ticket), Some(Ok(())));
    assert_eq!(records(&rig)[1..], [Spindle::Holds(2)]);
    // The tool that is there already is not changed.
    rig.run();
    assert_eq!(records(&rig).len(), 2);
}

#[test]
fn an_interrupted_change_must_be_settled_before_a_program_runs() {
    let interrupts: [fn(&mut Rig); 3] = [
        |rig| rig.good(Command::Abort),
        |rig| (rig.fake.io.estop.commanded, rig.fake.motion.enabled) = (true, false),
        |rig| {
            rig.fake.ends.values_mut().for_each(|end| {
                if *end == Progress::Pending {
                    *end = Progress::Failed("jammed".to_owned());
                }
            });
        },
    ];
    for interrupt in interrupts {
        let (mut rig, ticket) = changing();
        interrupt(&mut rig);
        rig.pass(0.2);
        rig.result(ticket).unwrap().unwrap_err();
        (rig.fake.io.estop.commanded, rig.fake.motion.enabled) = (false, true);
        rig.pass(0.2);
        rig.good(Command::Mode(Mode::Auto));
        assert_eq!(rig.core.interpreter.state.tool.number, 0);
        assert_eq!(
            rig.refused(Command::Run),
            "the change from tool 0 to tool 2 was interrupted: in mode mdi, task.mdi text='M61 Q…' says \
             which one is in the spindle, Q0 none"
        );
        state_tool(&mut rig, "M61 Q1");
        assert_eq!((rig.fake.io.tool, records(&rig).last()), (1, Some(&Spindle::Holds(1))));
        rig.run();
        assert_eq!(records(&rig).last(), Some(&Spindle::Holds(2)));
    }
}

#[test]
fn a_full_disk_ends_the_job_before_the_changer_is_asked() {
    let mut rig = Rig::new(CHANGE);
    rig.fake.spindles = None;
    let ticket = rig.send(Command::Run);
    rig.pass(0.1);
    rig.fake.answer_changer();
    rig.pass(0.5);
    let why = rig.result(ticket).unwrap().unwrap_err();
    assert!(why.ends_with("job.ngc:1: no space left on device"), "{why}");
    assert!(!rig.sent().contains(&"Change".to_owned()));
    // Nothing has changed, so nothing is unknown.
    rig.fake.spindles = Some(Vec::new());
    rig.run();
}

#[test]
fn a_disk_that_is_full_after_the_change_leaves_it_open() {
    let (mut rig, ticket) = changing();
    rig.fake.spindles = None;
    rig.fake.answer_changer();
    rig.pass(0.5);
    let why = rig.result(ticket).unwrap().unwrap_err();
    assert!(why.contains("no space left on device"), "{why}");
    assert!(!rig.sent().iter().any(|s| s.contains("line")), "nothing moves");
    assert!(rig.refused(Command::Run).contains("was interrupted"));
}

/// As after a power cut.
#[test]
fn the_record_counts_at_the_start() {
    for (record, tool, refused) in [
        (Spindle::Holds(2), 2, false),
        (Spindle::Holds(UNKNOWN), 0, true),
        (Spindle::Changing { from: 1, to: 2 }, 0, true),
    ] {
        let mut rig =
            Rig::on_machine("#<_tool>=#5400\nM2\n", |machine, _| machine.spindle = record);
        assert_eq!(rig.core.interpreter.state.tool.number, tool);
        rig.fake.io.tool = record.tool();
        rig.pass(0.1);
        assert_eq!(records(&rig), [], "it is on disk");
        if refused {
            assert!(rig.refused(Command::Run).contains("task.mdi text='M61 Q…'"), "{record:?}");
            state_tool(&mut rig, "M61 Q0");
        }
        rig.run();
    }
}

#[test]
fn a_tool_that_a_command_changes_is_written_too() {
    let mut rig = Rig::new(CHANGE);
    rig.fake.io.tool = 1;
    rig.pass(0.1);
    assert_eq!(
        (records(&rig), rig.core.interpreter.state.tool.number),
        (&[Spindle::Holds(1)][..], 1)
    );
    // A changer that was interrupted.
    rig.fake.io.tool = UNKNOWN;
    rig.pass(0.1);
    assert!(rig.refused(Command::Run).starts_with("the tool in the spindle is unknown: "));
}

#[test]
fn a_random_changer_exchanges_pockets() {
    let mut rig = Rig::on_machine("T2 M6\nT1 M6\nM2\n", |machine, _| {
        machine.settings.random_changer = true;
        machine.tools = ToolTable::parse("T1 P0\nT2 P5\nT3 P3\n").0;
        machine.spindle = Spindle::Holds(1);
    });
    rig.fake.io.tool = 1;
    rig.run();
    let pockets = |text: &str| -> Vec<(i32, i32)> {
        ToolTable::parse(text).0.tools.iter().map(|t| (t.number, t.pocket)).collect()
    };
    let tables: Vec<_> = rig.fake.tables.iter().map(|t| pockets(t)).collect();
    assert_eq!(tables, [[(1, 5), (2, 0), (3, 3)], [(1, 0), (2, 5), (3, 3)]]);
}

/// A tool setter 10 mm above the table measures the tool: its length is the height at which the probe trips, less the setter's.
#[test]
fn a_tool_is_measured_on_a_setter() {
    let mut rig = Rig::new(
        "G21 G90 G49\nT2 M6\nG38.2 Z-50 F100\nG10 L1 P#5400 Z[#5063 - 10]\nG43 H2\nG0 Z0\nM2\n",
    );
    rig.fake.motion.probe_found = true;
    rig.fake.motion.probe_measured[2] = 42.5;
    let sent = rig.run();
    let table = ToolTable::parse(rig.fake.tables.last().unwrap()).0;
    assert_eq!(table.find(2).unwrap().offset.z, 32.5);
    // Its tip is at 0 when the machine is at the tool's length.
    assert_eq!(sent.iter().rfind(|s| s.contains("line")).unwrap(), "6: line 0 0 32.5");
}

/// The tool touches the part: G10 L10 makes the place where it is the given one in the current system, L11 in G59.3.
#[test]
fn a_tool_is_touched_off() {
    for (code, length) in [("G10 L10 P1 Z2", 18.0), ("G10 L11 P1 Z2", 13.0)] {
        let mut rig =
            Rig::new(&format!("G21 G90 T1 M6\nG10 L2 P9 Z5\nG0 Z20\n{code}\nG43 H1\nG0 Z0\nM2\n"));
        let sent = rig.run();
        let table = ToolTable::parse(rig.fake.tables.last().unwrap()).0;
        assert_eq!(table.find(1).unwrap().offset.z, length, "{code}");
        let last = sent.iter().rfind(|s| s.contains("line")).unwrap();
        assert_eq!(*last, format!("6: line 0 0 {length}"), "{code}");
    }
}

/// G10 L0 reads the table again while a tool is in the spindle.
#[test]
fn a_table_that_is_reloaded_keeps_the_tool_in_the_spindle() {
    let mut rig = Rig::new("T2 M6\nG10 L0\nM2\n");
    rig.run();
    assert_eq!(rig.core.interpreter.state.tool.number, 2);
    assert_eq!(records(&rig).last(), Some(&Spindle::Holds(2)));
}

#[test]
fn a_changer_that_brings_another_tool_leaves_the_change_open() {
    let (mut rig, ticket) = changing();
    rig.fake.io.prepared = 1;
    rig.fake.answer_changer();
    rig.pass(0.5);
    let why = rig.result(ticket).unwrap().unwrap_err();
    assert!(why.ends_with("the changer was asked for tool 2 and states tool 1"), "{why}");
    assert_eq!(records(&rig), [Spindle::Changing { from: 0, to: 2 }]);
    assert!(rig.refused(Command::Run).contains("was interrupted"));
    assert!(!rig.sent().iter().any(|s| s.contains("line")), "nothing moves");
}
