//! Starts in the middle of a program.

use super::*;
use hal_job::dry_run::Target;

fn line(line: u32, pass: u32) -> Target {
    Target::Line { file: None, line, pass }
}

impl Rig {
    /// Proposes a start and returns the lines that show it, or the refusal.
    fn proposed(&mut self, target: Target) -> Result<Vec<String>, String> {
        let ticket = self.send(Command::RunFrom(target));
        for _ in 0..1000 {
            if let Some(result) = self.result(ticket) {
                return result.map(|()| self.core.shown_start().unwrap().lines.clone());
            }
            self.step();
        }
        panic!("the dry run does not end");
    }

    fn token(&self) -> u32 {
        let shown = self.core.shown_start().unwrap();
        let (_, rest) = shown.lines[0].split_once("token=").unwrap();
        rest.split(' ').next().unwrap().parse().unwrap()
    }

    /// Confirms the start that is proposed, and runs to the end of the program.
    fn confirmed(&mut self) -> Vec<String> {
        let token = self.token();
        let ticket = self.send(Command::Confirm(token));
        self.ended(ticket)
    }
}

const JOB: &str = "\
G21 G90 G64 P0.1
G10 L2 P2 X100
T1 M6
G43 H1
M3 S1000
G0 X1 Y1 Z5
G1 Z-1 F60
M8
o1 repeat [3]
G91
G1 X2
G1 Y1
G90
o1 endrepeat
M64 P3
T2 M6
G43 H2
S500 M4
G55
G0 X3 Z7
G1 Z2 F120
X4
M2
";

#[test]
fn a_start_in_the_middle_is_shown_entered_and_goes_on_as_the_unbroken_run() {
    let mut rig = Rig::on_machine(JOB, |machine, _| machine.limits[2] = (Some(-50.0), Some(80.0)));
    let all = rig.run();
    for (target, first) in [(line(11, 2), "11: line 5"), (line(22, 1), "22: line 104")] {
        let mut rig =
            Rig::on_machine(JOB, |machine, _| machine.limits[2] = (Some(-50.0), Some(80.0)));
        let shown = rig.proposed(target).unwrap();
        assert!(rig.sent().is_empty(), "a proposal moves nothing");
        rig.pass(5.0);
        assert!(rig.sent().is_empty(), "nothing begins by itself");
        let sent = rig.confirmed();
        // The entry is what was shown; behind it, the job is the rest of the unbroken run.
        let begins: Vec<usize> = (0..all.len()).filter(|n| all[*n].starts_with(first)).collect();
        let rest = &all[begins[begins.len() - 1]..];
        assert_eq!(sent[sent.len() - rest.len()..], *rest, "{shown:#?}");
        let entry = &sent[..sent.len() - rest.len()];
        let ends = shown.iter().filter(|row| row.starts_with("entry"));
        let moves = ends.filter(|row| row.contains("to Z") || row.contains("over")).count();
        let sent_moves = entry.iter().filter(|order| order.contains(": line ")).count();
        assert_eq!(moves, sent_moves, "{shown:#?} {entry:#?}");
    }
}

#[test]
fn the_proposal_shows_the_state_and_every_step() {
    let mut rig = Rig::on_machine(JOB, |machine, _| {
        machine.limits[2] = (Some(-50.0), Some(80.0));
        machine.settings.axes = hal_gcode::axis::AxisMask(7);
    });
    let shown = rig.proposed(line(11, 2)).unwrap();
    let file = rig.folder.join("job.ngc");
    let wanted = format!(
        "start token=1 file={0} line=11 pass=2 of=3\n\
         place {0}:11, pass 2 of 3\n\
         modal G1 G17 G21 G40 G43 G54 G64 G8 G91 G91.1 G94 G97 G99 F60\n\
         tool number=1 selected=1\n\
         spindle number=0 speed=1000\n\
         coolant mist=FALSE flood=TRUE\n\
         position X3.0000 Y2.0000 Z9.0000\n\
         system number=1 rotation=0 X0.0000 Y0.0000 Z0.0000\n\
         g92 X0.0000 Y0.0000 Z0.0000\n\
         tool-offset X0.0000 Y0.0000 Z10.0000\n\
         entry 1 up: up to Z80.0000: X0.0000 Y0.0000 Z80.0000\n\
         entry 2 spindle: spindle 0 stops\n\
         entry 3 prepare: tool 1 is prepared\n\
         entry 4 tool: tool 1 into the spindle\n\
         entry 5 offset: tool offset X0.0000 Y0.0000 Z10.0000\n\
         entry 6 spindle: spindle 0 clockwise, 1000 rpm\n\
         entry 7 coolant: flood on\n\
         entry 8 over: over the place at Z80.0000: X3.0000 Y2.0000 Z80.0000\n\
         entry 9 down: down to Z9.0000 at feed 60: X3.0000 Y2.0000 Z9.0000",
        file.display()
    );
    assert_eq!(shown.join("\n"), wanted);
    let json = rig.core.shown_start().unwrap().json.clone();
    for part in ["\"line\":11", "\"pass\":2", "\"passes\":3", "\"tool\":1", "\"kind\":\"down\""] {
        assert!(json.contains(part), "{part} in {json}");
    }
    let shown = rig.proposed(line(22, 1)).unwrap();
    let outputs = shown.iter().filter(|row| row.contains("output 3 on")).count();
    assert_eq!(outputs, 1, "{shown:#?}");
}

#[test]
fn a_confirmation_is_refused_when_machine_tool_or_program_have_changed() {
    type Change = fn(&mut Rig);
    let change: [(Change, &str); 7] = [
        (|rig| rig.fake.motion.pose[0] = 3.0, "the machine has moved"),
        (|rig| rig.fake.io.tool = 2, "the tool has changed"),
        (|rig| rig.good(Command::Mode(Mode::Manual)), "needs mode auto"),
        (|rig| rig.fake.motion.all_homed = false, "needs homed joints"),
        (|rig| std::fs::write(rig.folder.join("job.ngc"), "M2\n").unwrap(), "has changed since"),
        (|rig| rig.good(Command::Abort), "is not that of a proposal"),
        (
            |rig| {
                let other = rig.folder.join("other.ngc");
                std::fs::write(&other, "M2\n").unwrap();
                rig.good(Command::Open(other));
            },
            "has changed since",
        ),
    ];
    for (change, wanted) in change {
        let mut rig = Rig::new(JOB);
        rig.proposed(line(11, 1)).unwrap();
        let token = rig.token();
        change(&mut rig);
        rig.pass(0.1);
        rig.sent();
        let why = rig.refused(Command::Confirm(token));
        assert!(why.contains(wanted), "{wanted}: {why}");
        rig.pass(1.0);
        assert!(rig.sent().is_empty(), "{wanted}: nothing moves");
    }
    let mut rig = Rig::new(JOB);
    rig.proposed(line(11, 1)).unwrap();
    assert!(rig.refused(Command::Confirm(77)).contains("token 77 is not that"));
    // A machine that is not ready is shown the state, and why there is no entry.
    rig.fake.motion.all_homed = false;
    let shown = rig.proposed(line(11, 1)).unwrap();
    assert_eq!(
        shown[shown.len() - 1],
        "not-ready a program needs homed joints: task.home joint=all"
    );
    let token = rig.token();
    assert!(rig.refused(Command::Confirm(token)).contains("needs homed joints"));
}

#[test]
fn an_entry_beyond_a_limit_is_refused_with_every_reason() {
    let mut rig = Rig::on_machine("G21 G0 X500 Y-900 Z5\nG1 Z1 F10\nM2\n", |machine, _| {
        machine.limits[0] = (Some(-100.0), Some(100.0));
        machine.limits[1] = (Some(-100.0), Some(100.0));
        machine.limits[2] = (Some(-100.0), Some(100.0));
    });
    rig.proposed(line(2, 1)).unwrap();
    let token = rig.token();
    let why = rig.refused(Command::Confirm(token));
    assert!(why.contains("X500.0000 is 400.0000 mm beyond [AXIS_X]MAX_LIMIT = 100"), "{why}");
    assert!(why.contains("Y-900.0000 is 800.0000 mm beyond [AXIS_Y]MIN_LIMIT = -100"), "{why}");
}

#[test]
fn a_long_dry_run_goes_on_in_slices_and_ends_with_an_abort() {
    let program = "G21\no1 repeat [50000]\nG0 X1\nG0 X2\no1 endrepeat\nG0 X7\nM2\n";
    let mut rig = Rig::new(program);
    let ticket = rig.send(Command::RunFrom(line(6, 1)));
    rig.step();
    assert_eq!(rig.result(ticket), None, "a slice is shorter");
    assert!(rig.refused(Command::RunFrom(line(6, 1))).contains("in progress"));
    rig.good(Command::Abort);
    assert_eq!(rig.result(ticket), Some(Err("aborted".to_owned())));
    rig.pass(0.1);
    let shown = rig.proposed(line(6, 1)).unwrap();
    assert!(shown.iter().any(|row| row.starts_with("position X2.0000")), "{shown:#?}");
    // Another job makes a dry run void.
    let ticket = rig.send(Command::RunFrom(line(6, 1)));
    rig.send(Command::Run);
    rig.pass(0.1);
    assert_eq!(rig.result(ticket), Some(Err("another job has begun".to_owned())));
}

#[test]
fn a_refused_place_has_its_reason() {
    let mut rig = Rig::new("G21\nM66 P1 L3 Q5\nG0 X1\nM2\n");
    let why = rig.proposed(line(3, 1)).unwrap_err();
    assert!(why.contains("job.ngc:2: the result of M66 is not known"), "{why}");
    assert!(rig.core.shown_start().is_none());
    let why = rig.proposed(line(9, 1)).unwrap_err();
    assert!(why.contains("job.ngc:9: the result of M66") || why.contains(":2:"), "{why}");
}
