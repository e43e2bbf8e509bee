//! Sessions with a machine that notes its commands.

mod rights;

use crate::{
    Facts, Jog, JogTarget, Lines, MAX_LINE, Machine, Next, Passwords, Record, Session, Snapshots,
    is_stop, rows::ROWS,
};
use hal_ini::Ini;
use hal_protocol::{Stop, Value};
use std::{collections::BTreeSet, time::Duration};

const INI: &[u8] = b"[EMC]\nMACHINE = test\n[TRAJ]\nLINEAR_UNITS = inch\n[KINS]\nJOINTS = 2\n\
KINEMATICS = trivkins coordinates=XA\n[JOINT_1]\nTYPE = ANGULAR\n";

/// The machine: its state, and what it was told.
struct Noted {
    state: Snapshots,
    said: Vec<String>,
    control: bool,
    /// Refusal of all commands.
    refuses: Option<String>,
}

impl Noted {
    fn new() -> Self {
        let (mut motion, mut task) = (Record::default(), Record::default());
        let floats = |values: &[f64]| values.iter().map(|v| Value::Float(*v)).collect::<Vec<_>>();
        motion.set("pose", &floats(&[1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0, 9.0]));
        motion.set("mode", &[Value::U32(0)]);
        motion.set("joints", &[Value::U32(2)]);
        motion.set("joints_above", &[Value::U32(2)]);
        motion.set("joint_at_min", &[Value::Bit(true), Value::Bit(false)]);
        motion.set("spindles", &[Value::U32(1)]);
        motion.set("spindle_speed", &floats(&[-300.0]));
        task.set("state", &[Value::U32(2)]);
        task.set("g5x_offset", &floats(&[0.5; 9]));
        task.set("tool_offset", &floats(&[0.0, 0.0, 0.25, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0]));
        let g_codes = [800, 170, 200, 400, 490, 540, 640, 80, 900, 911, 940, 970, 990];
        task.set("g_codes", &g_codes.map(Value::U32));
        task.set("feed", &floats(&[12.5]));
        let ini = Ini::parse("test.ini", INI).unwrap();
        let facts = Facts::new("/m/test.ini".to_owned(), ini);
        let state = Snapshots { motion, task, facts };
        Self { state, said: Vec::new(), control: false, refuses: None }
    }
}

impl Machine for Noted {
    fn poll(&mut self) {}

    fn state(&self) -> &Snapshots {
        &self.state
    }

    fn command(&mut self, name: &str, args: Vec<String>) -> Result<Option<u64>, String> {
        self.said.push([&[name.to_owned()][..], &args].concat().join(" "));
        self.refuses.clone().map_or(Ok(Some(1)), Err)
    }

    fn stop(&mut self, stop: Stop) -> Result<Option<u64>, String> {
        self.said.push(format!("stop {}", stop.name()));
        self.refuses.clone().map_or(Ok(Some(1)), Err)
    }

    fn jog(&mut self, jog: Jog) -> Result<(), String> {
        let Jog { target, velocity, distance } = jog;
        self.said.push(format!("jog {} {velocity} {distance:?}", target.arg()));
        assert!(
            matches!(target, JogTarget::Joint(_) | JogTarget::Axis('X'..='Z' | 'A'..='C' | 'U'..='W'))
        );
        Ok(())
    }

    fn wait(&mut self, _: u64, most: Option<Duration>) -> Result<(), String> {
        self.said.push(format!("wait {most:?}"));
        Err("it failed".to_owned())
    }

    fn take(&mut self) -> Result<(), String> {
        self.refuses.clone().map_or(Ok(()), Err)?;
        self.control = true;
        Ok(())
    }

    fn give(&mut self) {
        self.control = false;
    }

    fn has_control(&self) -> bool {
        self.control
    }

    fn shut_down(&mut self) -> Result<(), String> {
        Ok(())
    }

    fn time(&self) -> f64 {
        1.5
    }
}

fn passwords() -> Passwords {
    let text = str::to_owned;
    Passwords { connect: text("EMC"), enable: text("EMCTOO"), name: text("EMCNETSVR") }
}

/// Executes lines; returns the reply to the last one.
fn say(session: &mut Session, machine: &mut Noted, lines: &str) -> String {
    let mut reply = String::new();
    for line in lines.lines() {
        reply = session.line(line.trim(), &passwords(), machine).0;
    }
    reply
}

/// Returns a session that is greeted and has control, without echo, and its machine.
fn ready() -> (Session, Noted) {
    let (mut session, mut machine) = (Session::default(), Noted::new());
    say(
        &mut session,
        &mut machine,
        "hello EMC me 1.0\nset echo off\nset verbose on\nset enable EMCTOO",
    );
    (session, machine)
}

#[test]
fn what_needs_hello_or_control_is_refused_without_it() {
    let (mut session, mut machine) = (Session::default(), Noted::new());
    for line in ["set echo off", "set enable EMCTOO", "set abort", "set estop on", "set mdi g0x1"] {
        assert_eq!(say(&mut session, &mut machine, line), "SET NAK\r\n");
    }
    assert_eq!(say(&mut session, &mut machine, "hello emc me 1.0"), "HELLO NAK\r\n");
    assert_eq!(say(&mut session, &mut machine, "hello EMC me"), "HELLO NAK\r\n");
    let reply = say(&mut session, &mut machine, "hello EMC me 1.0");
    assert_eq!(reply, "HELLO ACK EMCNETSVR 1.1\r\n");
    say(&mut session, &mut machine, "set echo off");
    // Every row that commands the machine.
    for row in
        ROWS.iter().filter(|row| row.set.is_some_and(|(n, _)| n == crate::rows::Needs::Control))
    {
        let line = format!("set {} 0 1 2", row.name);
        let stops = is_stop(&line);
        let reply = say(&mut session, &mut machine, &line);
        assert_eq!(reply.is_empty(), stops, "{line}: {reply}");
    }
    let stops = ["stop abort", "motion.jog-stop joint=0", "stop pause"];
    assert_eq!(machine.said, stops, "a stop needs no control");
    say(&mut session, &mut machine, "set machine off\nset estop on\nset estop off\nset machine on");
    assert_eq!(machine.said[3..], ["stop off", "stop estop"]);
    assert_eq!(say(&mut session, &mut machine, "shutdown"), "SHUTDOWN NAK\r\n");
    assert_eq!(say(&mut session, &mut machine, "set enable emctoo"), "SET ENABLE NAK\n\r");
    machine.refuses = Some("ana has the control lease".to_owned());
    assert_eq!(say(&mut session, &mut machine, "set enable EMCTOO"), "SET ENABLE NAK\n\r");
    // The refusals of lines without control come first.
    let last = say(&mut session, &mut machine, &"get error\n".repeat(16));
    assert_eq!(last, "ERROR ana has the control lease\r\n");
    assert_eq!(say(&mut session, &mut machine, "get error"), "ERROR OK\r\n");
}

#[test]
fn wrong_passwords_end_a_connection() {
    let (mut session, mut machine) = (Session::default(), Noted::new());
    let mut ends = |line: &str| session.line(line, &passwords(), &mut machine).1;
    for _ in 0..9 {
        assert_eq!(ends("hello x y z"), Next::Line);
    }
    assert_eq!(ends("hello x y z"), Next::Close);
}

#[test]
fn an_axis_that_does_not_jog_is_told_why() {
    let (mut session, mut machine) = ready();
    assert!(say(&mut session, &mut machine, "set jog X 60").ends_with(" NAK\n\r"));
    let why = say(&mut session, &mut machine, "get error");
    assert!(
        why.contains("jogs move joints now, which have numbers: set teleop_enable on"),
        "{why}"
    );
    assert_eq!(machine.said, [""; 0]);
}

#[test]
fn lines_become_commands() {
    for (lines, commands) in [
        ("set estop off", "task.estop-reset"),
        ("SET Machine ON", "task.on"),
        ("set mode MDI", "task.mode mode=mdi"),
        ("set mdi  G0  X1 ; x", "task.mdi text=G0  X1 ; x"),
        ("set home -1", "task.home joint=all"),
        ("set home 1", "task.home joint=1"),
        ("set jog 1 -30", "jog joint=1 -0.5 None"),
        ("set jog_incr 1 60 2", "jog joint=1 1 Some(2.0)"),
        ("set jog_incr 1 -60 2", "jog joint=1 1 Some(-2.0)"),
        ("set jog_stop 1", "motion.jog-stop joint=1"),
        // Joints jog in this mode, and a stop is no less one for that.
        ("set jog_stop X", "motion.jog-stop"),
        ("set feed_override 50", "task.feed-override scale=0.5"),
        ("set feed_override -5", "task.feed-override scale=0"),
        ("set spindle_override 80", "task.spindle-override spindle=0 scale=0.8"),
        ("set spindle_override 1 80", "task.spindle-override spindle=1 scale=0.8"),
        ("set spindle increase", "motion.spindle spindle=0 speed=-400 brake=FALSE"),
        ("set spindle decrease 0", "motion.spindle spindle=0 speed=-200 brake=FALSE"),
        ("set spindle forward", "motion.spindle spindle=0 speed=1 brake=FALSE"),
        ("set spindle off", "motion.spindle spindle=0 speed=0 brake=TRUE"),
        ("set brake on", "motion.spindle spindle=0 brake=TRUE"),
        ("set flood on", "iocontrol.coolant flood=TRUE"),
        ("set open /a b.ngc", "task.open file=/a b.ngc"),
        ("set run", "task.run"),
        ("set step", "task.step"),
        ("set optional_stop 0", "task.optional-stop on=FALSE"),
        ("set teleop_enable on", "motion.mode mode=teleop"),
        ("set probe 1 2 -3", "task.mdi text=G38.2 X1 Y2 Z-3"),
    ] {
        let (mut session, mut machine) = ready();
        let reply = say(&mut session, &mut machine, lines);
        assert!(reply.ends_with(" ACK\n\r"), "{lines}: {reply}");
        assert_eq!(machine.said, [commands], "{lines}");
    }
    let mut machine = Noted::new();
    machine.state.motion.set("mode", &[Value::U32(1)]);
    let mut session = Session::default();
    say(
        &mut session,
        &mut machine,
        "hello EMC me 1.0\nset enable EMCTOO\nset jog Z 60\nset jog 1 60",
    );
    assert_eq!(machine.said, ["jog axis=z 1 None", "jog axis=y 1 None"]);
}

#[test]
fn malformed_lines_command_nothing() {
    let (mut session, mut machine) = ready();
    for row in ROWS.iter().filter(|row| row.set.is_some()) {
        for args in [
            "",
            "?",
            "NaN",
            "inf inf inf",
            "-2",
            "99999999999999999999 1 1",
            "\u{1}",
            "on on on",
            "1e400 1e400",
        ] {
            say(&mut session, &mut machine, &format!("set {} {args}", row.name));
            say(&mut session, &mut machine, &format!("get {} {args}", row.name));
        }
        say(
            &mut session,
            &mut machine,
            "set echo off\nset verbose on\nset enable EMCTOO\nset update auto",
        );
    }
    let said: BTreeSet<_> = machine
        .said
        .iter()
        .filter(|said| !said.starts_with("task.mdi ") && !said.starts_with("task.open"))
        .collect();
    assert!(said.iter().all(|said| !said.contains("NaN") && !said.contains("inf")), "{said:?}");
    for line in [
        "set jog X 5",
        "set jog 0 NaN",
        "set jog_incr 0 5",
        "set run -1",
        "set run 3",
        "set home all",
        "set mode x",
    ] {
        let before = machine.said.len();
        assert!(say(&mut session, &mut machine, line).ends_with(" NAK\n\r"), "{line}");
        assert_eq!(machine.said.len(), before, "{line}");
    }
    for line in ["", " ", "foo", "get", "set", "hello", "help \u{7f}", "\0\0"] {
        session.line(line, &passwords(), &mut machine);
    }
}

#[test]
fn replies_show_the_state() {
    let (mut session, mut machine) = ready();
    for (line, reply) in [
        ("get abs_cmd_pos", "ABS_CMD_POS 1.000000 2.000000 3.000000 4.000000 5.000000 6.000000"),
        ("get abs_cmd_pos W", "ABS_CMD_POS 8 9.000000"),
        ("get rel_cmd_pos 2", "REL_CMD_POS 2 2.250000"),
        ("get pos_offset y", "POS_OFFSET Y  0.500000"),
        ("get joint_limit", "JOINT_LIMIT MINHARD MAXSOFT OK OK OK OK"),
        ("get joint_type 1", "JOINT_TYPE 1  ANGULAR"),
        ("get joint_units", "JOINT_UNITS INCH DEG INCH INCH INCH INCH"),
        ("get spindle", "SPINDLE 0 REVERSE"),
        ("get lube_level", "LUBE_LEVEL LOW"),
        ("get ini MACHINE EMC", "INI test"),
        (
            "get program_codes",
            "PROGRAM_CODES G80 G17 G40 G20 G90 G94 G54 G49 G99 G64 G97 G91.1 G8 G92.2 F12.5 S0",
        ),
        ("get time", "TIME 1.500000"),
        ("get timeout", "SET_TIMEOUT 0.000000"),
    ] {
        assert_eq!(say(&mut session, &mut machine, line), format!("{reply}\r\n"));
    }
    for line in ["get abs_cmd_pos 9", "get joint_pos -1", "get spindle 1", "get ini X", "get jog"] {
        assert!(say(&mut session, &mut machine, line).ends_with(" NAK\r\n\r\n"), "{line}");
    }
    let task = &mut machine.state.task;
    let words = [u64::from_le_bytes(*b"no such ")].map(Value::U64);
    task.set("message", &words);
    task.set("messages", &[Value::U32(1)]);
    task.set("message_level", &[Value::U32(1)]);
    assert_eq!(say(&mut session, &mut machine, "get error"), "ERROR no such \r\n");
    assert_eq!(say(&mut session, &mut machine, "get error"), "ERROR OK\r\n");
}

#[test]
fn a_machine_without_a_task_shows_the_state_of_motion() {
    for (estop, enabled, paused, queue, expected) in [
        (true, false, false, 0, "ESTOP ON MACHINE OFF PROGRAM_STATUS IDLE"),
        (false, false, false, 0, "ESTOP OFF MACHINE OFF PROGRAM_STATUS IDLE"),
        (false, true, false, 2, "ESTOP OFF MACHINE ON PROGRAM_STATUS RUNNING"),
        (false, true, true, 2, "ESTOP OFF MACHINE ON PROGRAM_STATUS PAUSED"),
    ] {
        let (mut session, mut machine) = ready();
        let motion = &mut machine.state.motion;
        for (name, on) in [("estop", estop), ("enabled", enabled), ("paused", paused)] {
            motion.set(name, &[Value::Bit(on)]);
        }
        motion.set("queue", &[Value::U32(queue)]);
        motion.set("feed_override", &[Value::Float(0.5)]);
        machine.state.fill_task();
        let asked = ["estop", "machine", "program_status"]
            .map(|name| say(&mut session, &mut machine, &format!("get {name}")).trim().to_owned());
        assert_eq!(asked.join(" "), expected);
        let shown = say(&mut session, &mut machine, "get feed_override");
        assert_eq!(shown, "FEED_OVERRIDE 50\r\n");
    }
}

#[test]
fn a_session_that_waits_learns_of_failures() {
    let (mut session, mut machine) = ready();
    say(&mut session, &mut machine, "set set_wait done\nset timeout 2");
    assert_eq!(say(&mut session, &mut machine, "set mode mdi"), "SET MODE NAK\n\r");
    assert_eq!(machine.said, ["task.mode mode=mdi", "wait Some(2s)"]);
    assert_eq!(say(&mut session, &mut machine, "get error"), "ERROR it failed\r\n");
    say(&mut session, &mut machine, "set set_wait received");
    machine.refuses = Some("no".to_owned());
    assert_eq!(say(&mut session, &mut machine, "set mode mdi"), "SET MODE ACK\n\r");
    assert_eq!(say(&mut session, &mut machine, "get error"), "ERROR no\r\n");
}

#[test]
fn lines_are_the_same_however_they_are_cut() {
    let long = "x".repeat(MAX_LINE);
    for (bytes, expected) in [
        ("a\nb\r\n\r\n\nc d\r".to_owned(), vec!["a", "b", "c d"]),
        ("a\rb\r\r\n".to_owned(), vec!["a", "b"]),
        (format!("{long}\n{long}y\nb\nunfinished"), vec![long.as_str(), "b"]),
    ] {
        for size in [1, 2, 3, 1000, 100_000] {
            let mut lines = Lines::default();
            bytes.as_bytes().chunks(size).for_each(|piece| lines.push(piece));
            assert!(lines.waiting().eq(expected.iter().copied()), "in pieces of {size}");
        }
    }
    let mut lines = Lines::default();
    lines.push(b"\xff\xfe\n");
    assert_eq!(lines.next_line().as_deref(), Some("\u{fffd}\u{fffd}"));
}

#[test]
fn the_tool_table_is_read_before_the_next_line() {
    let (mut session, mut machine) = ready();
    let reply = say(&mut session, &mut machine, "set load_tool_table tool.tbl");
    assert_eq!(reply, "SET LOAD_TOOL_TABLE ACK\n\r");
    assert_eq!(machine.said, ["task.mdi-brief text=G10 L0", "wait None"]);
}
