//! The text protocol of linuxcncrsh: its replies beside LinuxCNC's, its control, and malformed lines.
#![expect(clippy::unwrap_used, reason = "tests")]

use crate::panel::attacks::list::Tries;
use hal_tests::{
    foreign, golden,
    programs::{own_test, root},
    scratch::{Running, Scratch, until},
    tools,
    user::{as_user, is_root},
};
use rustix::process::{Pid, Signal};
use std::{
    collections::BTreeMap,
    fmt::Write as _,
    fs,
    io::{Read as _, Write as _},
    net::{Shutdown, TcpStream},
    path::PathBuf,
    process::{Command, Stdio},
};

/// Reply to the line that marks the end of the reply before it.
const MARK: &str = "PLAT Linux\r\n";
/// Number of attempts until a reply is the expected one.
const MAX_ASKED: u32 = 20_000;

fn folder() -> PathBuf {
    root().join("tests/peer/rsh")
}

/// A connection.
struct Line {
    stream: TcpStream,
}

impl Line {
    fn new(port: u16) -> Self {
        let stream = TcpStream::connect(("127.0.0.1", port)).unwrap();
        Self { stream }
    }

    fn send(&mut self, text: &str) {
        self.stream.write_all(text.as_bytes()).unwrap();
    }

    /// Sends a line and returns the reply; `<end>` stands for the end of the connection.
    fn ask(&mut self, line: &str) -> String {
        if line.eq_ignore_ascii_case("quit") {
            self.send(&format!("{line}\r\n"));
            let mut rest = Vec::new();
            // A server that has bytes left unread resets the connection.
            drop(self.stream.read_to_end(&mut rest));
            return format!("{}<end>", String::from_utf8_lossy(&rest));
        }
        self.send(&format!("{line}\r\n"));
        self.send("get plat\r\n");
        let (mut seen, mut byte) = (Vec::new(), [0]);
        let marks = 1 + usize::from(line.to_lowercase().starts_with("get plat"));
        while String::from_utf8_lossy(&seen).matches(MARK).count() < marks {
            match self.stream.read(&mut byte) {
                Ok(1) => seen.extend_from_slice(&byte),
                _ => return format!("{}<end>", String::from_utf8_lossy(&seen)),
            }
        }
        let text = String::from_utf8(seen).unwrap();
        let own = text.strip_suffix(MARK).unwrap();
        own.strip_suffix("get plat\r\n").unwrap_or(own).to_owned()
    }
}

/// Executes the session. Returns each line with its reply.
fn talk(port: u16, session: &str) -> String {
    let mut lines: BTreeMap<&str, Line> = BTreeMap::new();
    let mut out = String::new();
    for text in session.lines().filter(|text| !text.starts_with('#')) {
        let at = text.find(['>', '?']).unwrap();
        let (name, rest) = text.split_at(at);
        let line = lines.entry(name).or_insert_with(|| Line::new(port));
        if let Some(rest) = rest.strip_prefix("? ") {
            let (asked, reply) = rest.split_once(" = ").unwrap();
            let mut last = String::new();
            let found = (0..MAX_ASKED).any(|_| {
                last = line.ask(asked);
                last.trim_end() == reply
            });
            writeln!(out, "{text}").unwrap();
            assert!(found, "{text}: {last:?}\n{out}");
            continue;
        }
        let reply = line.ask(rest.strip_prefix("> ").unwrap());
        writeln!(out, "{text}\n  {}", reply.escape_debug()).unwrap();
    }
    out
}

/// Starts the machine with linuxcncrsh as its user interface; returns its port.
fn start(scratch: &Scratch, options: &str) -> (Running, u16) {
    let ini = scratch.read("machine.ini");
    scratch.write(
        "machine.ini",
        ini.replace("= linuxcncrsh", &format!("= linuxcncrsh -p 0{options}")),
    );
    let running = scratch.start(scratch.command(&[], "halrun").arg("machine.ini"));
    let mut port = None;
    until("linuxcncrsh listens", || {
        let (out, errors) = running.said();
        port = out
            .lines()
            .find_map(|l| l.strip_prefix("linuxcncrsh listens at 127.0.0.1:")?.parse().ok());
        assert!(!errors.contains("error:") && !errors.contains("linuxcncrsh:"), "{out}{errors}");
        port.is_some()
    });
    (running, port.unwrap())
}

#[test]
fn replies_are_those_of_linuxcnc() {
    let session = fs::read_to_string(folder().join("session.txt")).unwrap();
    let theirs = fs::read_to_string(folder().join("linuxcnc.txt")).unwrap();
    let scratch = Scratch::copy_of(&folder());
    let (running, port) = start(&scratch, "");
    let ours = talk(port, &session);
    let mut wrong = String::new();
    for (ours, theirs) in ours.lines().zip(theirs.lines()).filter(|(a, b)| a != b) {
        writeln!(wrong, "expected {theirs}\n     got {ours}").unwrap();
    }
    assert!(wrong.is_empty() && ours.lines().count() == theirs.lines().count(), "{wrong}");
    // Shutdown ends the machine.
    let mut line = Line::new(port);
    line.send("hello EMC me 1.0\nset enable EMCTOO\nshutdown\n");
    let output = running.wait();
    assert_eq!(output.status, Some(0), "{output:?}");
}

/// Measures LinuxCNC again.
#[test]
#[ignore = "starts LinuxCNC, which must run alone: cargo test -p hal-tests --test system peer::rsh -- --ignored"]
fn linuxcnc_replies_as_recorded() {
    let here = foreign::installed().filter(|_| PathBuf::from("/usr/bin/linuxcncrsh").is_file());
    if tools::LINUXCNC.or_skip(here).is_none() {
        return;
    }
    let session = fs::read_to_string(folder().join("session.txt")).unwrap();
    let scratch = Scratch::copy_of(&folder());
    let mut allow = Command::new("chmod");
    assert!(allow.args(["-R", "a+rwX"]).arg(scratch.path()).status().unwrap().success());
    let mut command = foreign::peer("/usr/bin/linuxcnc", scratch.path());
    command.arg("machine.ini").env("PATH", "/usr/bin:/bin:/usr/sbin:/sbin");
    let mut child = command.stdout(Stdio::null()).stderr(Stdio::null()).spawn().unwrap();
    until("LinuxCNC listens", || TcpStream::connect(("127.0.0.1", 5007)).is_ok());
    let theirs = talk(5007, &session);
    let mut line = Line::new(5007);
    line.ask("hello EMC me 1.0");
    line.ask("set enable EMCTOO");
    line.ask("shutdown");
    child.wait().unwrap();
    golden::check(&folder().join("linuxcnc.txt"), &theirs);
}

/// Returns a line with hello, without echo, that acknowledges.
fn greeted(port: u16) -> Line {
    let mut line = Line::new(port);
    assert_eq!(line.ask("hello EMC me 1.0"), "HELLO ACK EMCNETSVR 1.1\r\n");
    line.ask("set echo off");
    line.ask("set verbose on");
    line
}

fn wait(line: &mut Line, asked: &str, reply: &str) {
    until(reply, || line.ask(asked).trim_end() == reply);
}

/// Returns a line with control of a machine that is on, whose joints are homed.
fn homed(port: u16) -> Line {
    let mut line = greeted(port);
    for text in
        ["set enable EMCTOO", "set set_wait done", "set estop off", "set machine on", "set home -1"]
    {
        let reply = line.ask(text);
        assert!(reply.ends_with(" ACK\n\r"), "{text}: {reply} {}", line.ask("get error"));
    }
    line.ask("set set_wait received");
    wait(&mut line, "get joint_homed 2", "JOINT_HOMED 2 YES");
    line.ask("set teleop_enable on");
    wait(&mut line, "get teleop_enable", "TELEOP_ENABLE YES");
    line
}

/// Returns the process of a program that another process has started.
fn child_of(parent: u32, program: &str) -> Pid {
    let begin = format!("({program}) ");
    let is_it = |stat: &str| {
        let rest = stat.split_once(&begin).map(|(_, rest)| rest);
        rest.and_then(|rest| rest.split(' ').nth(1)) == Some(&*parent.to_string())
    };
    let entries = fs::read_dir("/proc").unwrap().flatten();
    let found =
        entries.filter_map(|e| fs::read_to_string(e.path().join("stat")).ok()).find(|s| is_it(s));
    Pid::from_raw(found.unwrap().split(' ').next().unwrap().parse().unwrap()).unwrap()
}

#[test]
fn a_jog_ends_with_its_connection_and_a_stop_needs_no_control() {
    let scratch = Scratch::copy_of(&folder());
    let (running, port) = start(&scratch, "");
    let mut watch = greeted(port);
    let moves = |watch: &mut Line| {
        let first = watch.ask("get abs_cmd_pos 0");
        let cycle = || {
            let shown = scratch.halcmd(&["snapshot", "motion.status"]).stdout;
            let (_, rest) = shown.split_once("\"cycle\":").unwrap();
            let digits = rest.trim_start_matches([' ', '"']).split(|c: char| !c.is_ascii_digit());
            digits.into_iter().next().unwrap().parse::<u64>().unwrap()
        };
        let from = cycle();
        until("another cycle", || from < cycle());
        first != watch.ask("get abs_cmd_pos 0")
    };
    for end in ["close", "reset", "take", "disable", "abort", "jog_stop"] {
        let mut line = homed(port);
        until("it jogs", || {
            line.ask("set jog X 60");
            moves(&mut watch)
        });
        match end {
            "close" => line.stream.shutdown(Shutdown::Both).unwrap(),
            // Without reading what has come.
            "reset" => line.send("get time\r\n".repeat(20).as_str()),
            "take" => drop(watch.ask("set enable EMCTOO")),
            "disable" => drop(line.ask("set enable off")),
            "abort" => assert_eq!(watch.ask("set abort"), "SET ABORT ACK\n\r"),
            _ => assert_eq!(watch.ask("set jog_stop X"), "SET JOG_STOP ACK\n\r"),
        }
        if end == "reset" {
            drop(line);
        } else if end == "take" {
            assert_eq!(line.ask("get enable"), "ENABLE OFF\r\n");
            assert_eq!(line.ask("set jog X 60"), "SET JOG NAK\n\r");
            assert_eq!(watch.ask("set enable off"), "SET ENABLE ACK\n\r");
        }
        until(&format!("the jog stops: {end}"), || !moves(&mut watch));
        // Nothing resumes.
        assert!(!moves(&mut watch), "{end}");
        assert_eq!(watch.ask("set estop on"), "SET ESTOP ACK\n\r");
        wait(&mut watch, "get estop", "ESTOP ON");
    }
    let mut line = homed(port);
    until("it jogs", || {
        line.ask("set jog X 60");
        moves(&mut watch)
    });
    // The death of the program ends it, too.
    let pid = child_of(running.pid(), "linuxcncrsh");
    rustix::process::kill_process(pid, Signal::STOP).unwrap();
    let speed =
        || scratch.halcmd(&["getp", "joint.0.vel-cmd"]).stdout.trim().parse::<f64>().unwrap();
    until("the jog stops", || speed() == 0.0);
    rustix::process::kill_process(pid, Signal::KILL).unwrap();
    // The machine ends with its user interface.
    running.wait();
}

#[test]
fn a_machine_without_a_task_is_stopped_by_lines() {
    let scratch = Scratch::copy_of(&root().join("configs/rs03n"));
    let machine = scratch.start(scratch.command(&[], "halrun").args(["--simulate", "rs03n.hal"]));
    until("the machine runs", || scratch.halcmd(&["motion.status"]).status == Some(0));
    let server = scratch.start(scratch.command(&[], "linuxcncrsh").args(["-p", "0"]));
    let mut port = None;
    until("linuxcncrsh listens", || {
        let (out, errors) = server.said();
        assert!(errors.is_empty(), "{errors}");
        let said = |l: &str| l.strip_prefix("linuxcncrsh listens at 127.0.0.1:")?.parse().ok();
        port = out.lines().find_map(said);
        port.is_some()
    });
    let port = port.unwrap();
    let (mut line, mut watch) = (greeted(port), greeted(port));
    assert_eq!(line.ask("set enable EMCTOO"), "SET ENABLE ACK\n\r");
    line.ask("set set_wait done");
    let velocity = || scratch.told("getp motion.current-vel").trim().parse::<f64>().unwrap();
    for (stop, on, estop) in [
        ("set estop on", "OFF", "ON"),
        ("set machine off", "OFF", "OFF"),
        ("set abort", "ON", "OFF"),
        ("set pause", "ON", "OFF"),
    ] {
        if watch.ask("get estop") == "ESTOP ON\r\n" {
            assert_eq!(line.ask("set estop off"), "SET ESTOP ACK\n\r", "{stop}");
        }
        for text in ["set machine on", "set home -1"] {
            let reply = line.ask(text);
            assert!(reply.ends_with(" ACK\n\r"), "{text}: {reply} {}", line.ask("get error"));
        }
        let x = scratch.told("getp axis.x.pos-cmd").trim().parse::<f64>().unwrap();
        let to = if x > -400.0 { -500 } else { -300 };
        scratch.told(&format!("motion.move x={to} velocity=3"));
        until("it moves", || velocity() > 2.9);
        wait(&mut watch, "get program_status", "PROGRAM_STATUS RUNNING");
        // Without control.
        let reply = watch.ask(stop);
        assert!(reply.ends_with(" ACK\n\r"), "{stop}: {reply} {}", watch.ask("get error"));
        until(stop, || velocity() == 0.0);
        wait(&mut watch, "get machine", &format!("MACHINE {on}"));
        wait(&mut watch, "get estop", &format!("ESTOP {estop}"));
    }
    wait(&mut watch, "get program_status", "PROGRAM_STATUS PAUSED");
    assert_eq!(line.ask("set resume"), "SET RESUME ACK\n\r");
    until("it goes on", || velocity() > 2.9);
    assert_eq!(line.ask("set mdi g0 x1"), "SET MDI NAK\n\r");
    let why = line.ask("get error");
    assert!(why.contains("need a task, and this machine has none"), "{why}");
    assert_eq!(watch.ask("set abort"), "SET ABORT ACK\n\r");
    for program in [server, machine] {
        program.signal(Signal::TERM);
        program.wait();
    }
}

#[test]
fn one_operator_has_control_here_and_in_the_panel() {
    let scratch = Scratch::copy_of(&folder());
    let (_running, port) = start(&scratch, "");
    let mut line = greeted(port);
    assert_eq!(line.ask("set enable EMCTOO"), "SET ENABLE ACK\n\r");
    let refused = scratch.halcmd(&["remote.take", "holder=ana"]);
    assert!(refused.stderr.contains("linuxcncrsh has the control lease"), "{refused:?}");
    assert_eq!(line.ask("set enable off"), "SET ENABLE ACK\n\r");
    // The lease of the panel's operator lasts a second without beats.
    let taken = scratch.halcmd(&["remote.take", "holder=ana"]);
    assert_eq!(taken.status, Some(0), "{taken:?}");
    if line.ask("set enable EMCTOO") == "SET ENABLE NAK\n\r" {
        let why = line.ask("get error");
        assert_eq!(why, "ERROR ana has the control lease\r\n");
    }
    until("the lease of ana ends", || line.ask("set enable EMCTOO") == "SET ENABLE ACK\n\r");
}

#[test]
fn control_needs_the_permission_of_the_machine() {
    let scratch = Scratch::copy_of(&folder());
    let (_running, port) = start(&scratch, "");
    let mut line = greeted(port);
    scratch.told("setp remote.allow-motion FALSE");
    assert_eq!(line.ask("set enable EMCTOO"), "SET ENABLE NAK\n\r");
    let why = line.ask("get error");
    assert!(why.starts_with("ERROR the machine permits no motion from afar"), "{why}");
    scratch.told("setp remote.allow-motion TRUE");
    assert_eq!(line.ask("set enable EMCTOO"), "SET ENABLE ACK\n\r");
}

#[test]
fn a_stop_ends_a_wait_and_what_was_sent_before_it_is_left_out() {
    let scratch = Scratch::copy_of(&folder());
    let (_running, port) = start(&scratch, "");
    let mut line = homed(port);
    line.ask("set set_wait done");
    assert_eq!(line.ask("set mode mdi"), "SET MODE ACK\n\r");
    let mut watch = greeted(port);
    line.send("set mdi g1 x50 f1\r\n");
    // Hundredths of a millimetre take half a second.
    until("it moves", || {
        let reply = watch.ask("get abs_cmd_pos 0");
        reply.trim_end().rsplit(' ').next().unwrap().parse::<f64>().unwrap() >= 0.01
    });
    line.send("set mdi g0 y9\r\nset abort\r\n");
    let reply = line.ask("get plat");
    assert!(reply.starts_with("SET MDI NAK\n\rSET MDI NAK\n\rSET ABORT ACK\n\r"), "{reply:?}");
    wait(&mut line, "get program_status", "PROGRAM_STATUS IDLE");
    assert_eq!(line.ask("get abs_cmd_pos 1"), "ABS_CMD_POS 1 0.000000\r\n");
    // What is sent at once is executed in its order.
    line.send("set mdi g0 y1\r\nset abort\r\n");
    let reply = line.ask("get plat");
    assert!(reply.starts_with("SET MDI ACK\n\rSET ABORT ACK\n\r"), "{reply:?}");
    assert_eq!(line.ask("get abs_cmd_pos 1"), "ABS_CMD_POS 1 1.000000\r\n");
    // A failure is known at once.
    assert_eq!(line.ask("set mdi bogus"), "SET MDI NAK\n\r");
    assert!(line.ask("get error").starts_with("ERROR "), "the reason");
}

#[test]
fn malformed_input_moves_nothing_and_ends_nothing() {
    let scratch = Scratch::copy_of(&folder());
    let (_running, port) = start(&scratch, "");
    let long = "x".repeat(100_000);
    let mut seed = 7_u64;
    let mut random = || {
        seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        usize::try_from(seed >> 33).unwrap()
    };
    let words = [
        "set",
        "get",
        "hello",
        "EMC",
        "enable",
        "mdi",
        "jog",
        "0",
        "-1",
        "1e9",
        "\0",
        "\u{7f}",
        "\r",
        "\n",
        "nan",
        "EMCTO",
        "help",
        "set set set",
        "%s%n",
        &long,
    ];
    for round in 0..60 {
        let mut line = Line::new(port);
        let mut text = String::new();
        for _ in 0..random() % 40 {
            text.push_str(words[random() % words.len()]);
            text.push_str([" ", "\r\n", "\n", ""][random() % 4]);
        }
        let bytes = text.as_bytes();
        let cut = if bytes.is_empty() { 0 } else { random() % bytes.len() };
        // The server may have left a connection with wrong passwords.
        drop(line.stream.write_all(if round % 3 == 0 { &bytes[..cut] } else { bytes }));
        drop(line.stream.write_all(&[0xff, 0xfe, 0x80]));
        if round % 2 == 0 {
            drop(line.stream.shutdown(Shutdown::Write));
            drop(line.stream.read_to_end(&mut Vec::new()));
        }
    }
    // Wrong passwords end a connection.
    let mut line = Line::new(port);
    let wrong = "hello wrong me 1.0\r\n".repeat(9);
    line.send(&wrong);
    assert!(line.ask("hello wrong me 1.0").ends_with("HELLO NAK\r\n<end>"));
    let mut line = greeted(port);
    assert_eq!(line.ask("get estop"), "ESTOP ON\r\n");
    assert_eq!(line.ask("get enable"), "ENABLE OFF\r\n");
    assert_eq!(line.ask("get error"), "ERROR OK\r\n");
    // A line that is too long is left out, and the next one is not.
    assert_eq!(line.ask(&format!("set mdi {long}\r\nget machine")), "MACHINE OFF\r\n");
}

/// Connections that are opened at once, and sessions that say hello: a program has fewer of the engine's 256 clients.
const SILENT: usize = 250;
const GREETED: usize = 128;

#[test]
fn connections_take_a_client_of_the_engine_with_their_hello_and_never_all_of_them() {
    let scratch = Scratch::copy_of(&folder());
    let (_running, port) = start(&scratch, "");
    let connect = || TcpStream::connect(("127.0.0.1", port)).unwrap();
    let mut silent: Vec<_> = (0..SILENT).map(|_| Line { stream: connect() }).collect();
    // All of them are served, and show the machine, before anybody has said hello.
    for line in &mut silent {
        assert_eq!(line.ask("get estop"), "ESTOP ON\r\n");
        assert_eq!(line.ask("set mode mdi"), "SET NAK\r\n");
    }
    let serves = || scratch.told("getp motion.motion-enabled");
    assert_eq!(serves().trim(), "FALSE");
    let said = silent.iter_mut().map(|line| line.ask("hello EMC me 1.0"));
    let greeted = said.filter(|said| said.starts_with("HELLO ACK"));
    assert_eq!(greeted.count(), GREETED);
    assert_eq!(serves().trim(), "FALSE");
    drop(silent);
    until("a client is free again", || {
        Line { stream: connect() }.ask("hello EMC me 1.0").starts_with("HELLO ACK")
    });
}

/// A user without rights: `nobody`.
const NOBODY: u32 = 65_534;

#[test]
fn people_open_programs_of_the_machine_alone_and_have_a_part_of_the_connections() {
    if !is_root() {
        return;
    }
    let scratch = Scratch::copy_of(&folder());
    let secret = scratch.path().with_extension("secret.ngc");
    fs::write(&secret, "M2\n").unwrap();
    std::os::unix::fs::symlink(&secret, scratch.path().join("link.ngc")).unwrap();
    let (_running, port) = start(&scratch, " -w one -e two");
    let begin = || {
        let mut line = Line::new(port);
        assert!(line.ask("hello one me 1.0").starts_with("HELLO ACK"));
        line.ask("set echo off");
        line.ask("set verbose on");
        for text in ["set enable two", "set set_wait done"] {
            let reply = line.ask(text);
            assert!(reply.ends_with(" ACK\n\r"), "{text}: {reply} {}", line.ask("get error"));
        }
        line
    };
    let refusal = |line: &mut Line, file: &str| {
        let reply = line.ask(&format!("set open {file}"));
        if reply == "SET OPEN ACK\n\r" { String::new() } else { line.ask("get error") }
    };
    let (inside, outside) = (scratch.path().join("square.ngc"), secret.display().to_string());
    let inside = inside.display().to_string();
    let attacks = [
        (&*outside, "a file elsewhere", "programs are opened from afar in "),
        ("/etc/passwd", "/etc/passwd", "([DISPLAY]PROGRAM_PREFIX)"),
        ("link.ngc", "a link", "a symbolic link is here or on the way"),
        ("../machine.ini", "a file of the folder above", "the name has '..'"),
    ];
    let mut tries = Tries::default();
    let attacked = |tries: &mut Tries, line: &mut Line, who: &str| {
        for (file, what, why) in attacks {
            let said = refusal(line, file);
            let attack = format!("{who}: set open of {what} in linuxcncrsh");
            tries.note(&attack, !said.contains(why), &said);
        }
    };
    as_user(NOBODY, || {
        let mut line = begin();
        assert_eq!(refusal(&mut line, &inside), "");
        attacked(&mut tries, &mut line, "another user");
        // A part of the connections; one more ends without a word.
        let others: Vec<_> = (1..32).map(|_| begin()).collect();
        until("one more is closed", || {
            let mut more = TcpStream::connect(("127.0.0.1", port)).unwrap();
            more.write_all(b"get plat\r\n").unwrap_or_default();
            more.read(&mut [0; 1]).unwrap_or(0) == 0
        });
        drop(others);
    });
    // A client is elsewhere, also one of the user who runs linuxcncrsh.
    let mut own = begin();
    assert_eq!(refusal(&mut own, &inside), "");
    attacked(&mut tries, &mut own, "operator");
    // The refusal is reported to a client that waits for nothing, too.
    own.ask("set set_wait received");
    assert_eq!(own.ask(&format!("set open {outside}")), "SET OPEN ACK\n\r");
    assert!(own.ask("get error").contains("programs are opened from afar in "));
    fs::remove_file(secret).unwrap();
    tries.finish(&own_test(
        module_path!(),
        "people_open_programs_of_the_machine_alone_and_have_a_part_of_the_connections",
    ));
}

#[test]
fn without_an_ini_file_no_program_is_opened() {
    let scratch = Scratch::copy_of(&folder());
    let machine = scratch.start(scratch.command(&[], "halrun").args([
        "--simulate",
        "--headless",
        "machine.ini",
    ]));
    until("the machine runs", || scratch.halcmd(&["task.status"]).status == Some(0));
    let server = scratch.start(scratch.command(&[], "linuxcncrsh").args(["-p", "0"]));
    let mut port = None;
    until("linuxcncrsh listens", || {
        let said = |l: &str| l.strip_prefix("linuxcncrsh listens at 127.0.0.1:")?.parse().ok();
        port = server.said().0.lines().find_map(said);
        port.is_some()
    });
    let mut line = greeted(port.unwrap());
    assert_eq!(line.ask("set enable EMCTOO"), "SET ENABLE ACK\n\r");
    assert_eq!(line.ask("set set_wait done"), "SET SET_WAIT ACK\n\r");
    assert_eq!(line.ask("set open square.ngc"), "SET OPEN NAK\n\r");
    let why = line.ask("get error");
    assert!(why.contains("linuxcncrsh was started without an INI file"), "{why}");
    for program in [server, machine] {
        program.signal(Signal::TERM);
        program.wait();
    }
}
