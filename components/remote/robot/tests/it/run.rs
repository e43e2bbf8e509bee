//! The driver against the simulated controller, in virtual time and without a network.
#![expect(clippy::unwrap_used, clippy::indexing_slicing, reason = "tests")]

use robot::{Command, Controller, Driver, Event, Faults, Output, State, Stopped, Volume, convert};

const ZERO: [f64; 3] = [-400.0, 0.0, -30.0];

/// Driver and controller with the connection between them.
struct Link {
    driver: Driver,
    robot: Controller,
    now: f64,
    is_up: bool,
    to_robot: Vec<u8>,
    transcript: String,
    events: Vec<Event>,
    chance: u64,
}

impl Link {
    fn new(faults: Faults, timeout: f64) -> Self {
        let mut link = Self {
            driver: Driver::new(timeout),
            robot: Controller::new(Volume::default(), ZERO, faults),
            now: 0.0,
            is_up: false,
            to_robot: Vec::new(),
            transcript: String::new(),
            events: Vec::new(),
            chance: faults.seed | 1,
        };
        link.connect();
        link
    }

    fn connect(&mut self) {
        assert_eq!(self.robot.connect(self.now), None);
        self.driver.connected(self.now);
        self.is_up = true;
        self.until(|l| l.driver.state() == State::Ready);
    }

    fn cut(&mut self) {
        self.is_up = false;
        self.to_robot.clear();
        self.robot.disconnect(self.now);
        self.driver.disconnected();
    }

    /// Returns a number below `n` by chance.
    fn draw(&mut self, n: u64) -> u64 {
        self.chance ^= self.chance << 13;
        self.chance ^= self.chance >> 7;
        self.chance ^= self.chance << 17;
        self.chance % n
    }

    /// Runs one step: bytes go over in pieces of any size, and time advances to the next event.
    fn step(&mut self) {
        let sent = self.driver.output();
        self.transcript.push_str(&String::from_utf8_lossy(&sent).replace("\r\n", "|"));
        if self.is_up {
            self.to_robot.extend(sent);
        }
        while !self.to_robot.is_empty() {
            let size = 1 + usize::try_from(self.draw(20)).unwrap();
            let piece: Vec<u8> = self.to_robot.drain(..size.min(self.to_robot.len())).collect();
            self.robot.receive(&piece, self.now);
        }
        let due = [self.robot.next(), self.driver.next()].into_iter().flatten().reduce(f64::min);
        self.now = due.map_or(self.now, |due| due.max(self.now));
        for output in self.robot.poll(self.now) {
            match output {
                Output::Bytes(bytes) if self.is_up => {
                    self.transcript.push_str(&String::from_utf8_lossy(&bytes).replace("\r\n", "<"));
                    let middle = usize::try_from(self.draw(bytes.len() as u64)).unwrap();
                    self.driver.receive(&bytes[..middle], self.now);
                    self.driver.receive(&bytes[middle..], self.now);
                }
                Output::Bytes(_) => {}
                Output::Close => {
                    self.is_up = false;
                    self.driver.disconnected();
                }
            }
        }
        self.driver.poll(self.now);
        self.events.extend(self.driver.events());
    }

    fn until(&mut self, done: impl Fn(&Self) -> bool) {
        for _ in 0..2_000_000 {
            if done(self) {
                return;
            }
            self.step();
        }
        assert!(done(self), "{:?} at {}", self.driver.state(), self.now);
    }

    fn run(&mut self, lines: &[Command], from: usize) {
        assert!(self.driver.run(lines.to_vec(), from, self.now));
    }

    fn is_over(&self) -> bool {
        matches!(self.driver.state(), State::Ended | State::Stopped(_))
    }
}

/// Moves in the work volume, no two of which go to the same point.
fn moves(count: u32) -> Vec<Command> {
    let at = |n: u32| {
        let n = f64::from(n);
        [(n * 0.618).fract() * 20.0, (n * 0.755).fract() * 20.0, n / 1000.0]
    };
    let mut out = Vec::new();
    for n in 0..count {
        if n % 1000 == 0 {
            out.push(Command::Speed(f64::from(5 + n % 7)));
        }
        out.push(if n % 10 == 0 { Command::Rapid(at(n)) } else { Command::Cut(at(n)) });
    }
    out
}

/// Returns the targets of lines.
fn targets(lines: &[Command]) -> Vec<[f64; 3]> {
    let sent = |to: [f64; 3]| to.map(|x| format!("{x:.3}").parse().unwrap());
    lines.iter().filter_map(Command::target).map(sent).collect()
}

#[test]
fn a_short_run_and_its_transcript() {
    let mut link = Link::new(Faults::default(), 60.0);
    assert_eq!(link.driver.zero(), Some(ZERO));
    let lines = [Command::Speed(5.0), Command::Rapid([0., 0., 10.]), Command::Cut([10., 0., 0.])];
    link.run(&lines, 0);
    link.until(Link::is_over);
    link.step();
    assert_eq!(link.driver.state(), State::Ended);
    assert_eq!(
        link.transcript,
        "-400.000 0.000 -30.000<Esperando inicio<inicio|done<?|error unknown<\
         SPEED,5.000|done<SPEED|error format<JMOVE,0.000,0.000,10.000|done<?|error unknown<\
         LMOVE,10.000,0.000,0.000|done<SPEED|error format<EXIT|"
    );
    assert_eq!(link.robot.moves(), targets(&lines));
    // 50 mm back, 40 mm down, both at 10 mm/s, and 14.142 mm at 5 mm/s.
    assert!((link.now - (5.0 + 4.0 + 2.828)).abs() < 0.05, "{}", link.now);
}

#[test]
fn ten_thousand_lines_with_faults_are_each_executed_once() {
    for (seed, delay, lost, doubled) in [
        (1, 2.0, 0.0, 0.2),
        (2, 2.0, 0.1, 0.0),
        // Answers may come later than the driver waits.
        (3, 12.0, 0.0, 0.2),
        (4, 12.0, 0.1, 0.1),
    ] {
        let faults = Faults { seed, delay, lost, doubled };
        let mut link = Link::new(faults, 9.0);
        let lines = moves(10_000);
        link.run(&lines, 0);
        link.until(Link::is_over);
        assert_eq!(link.driver.state(), State::Ended, "{seed}");
        assert_eq!(link.robot.moves(), targets(&lines), "{seed}");
        let executed = link.events.iter().filter_map(|e| match e {
            Event::Executed(n, _) => Some(*n),
            _ => None,
        });
        assert_eq!(executed.collect::<Vec<_>>(), (0..lines.len()).collect::<Vec<_>>());
        let unanswered = link.events.iter().filter(|e| matches!(e, Event::Executed(_, false)));
        let is_late = lost > 0.0 || delay > 9.0;
        assert_eq!(unanswered.count() > 100, is_late, "{seed}");
    }
}

#[test]
fn two_runs_are_equal_byte_for_byte() {
    let run = || {
        let mut link = Link::new(Faults { seed: 9, delay: 2.0, lost: 0.05, doubled: 0.05 }, 30.0);
        link.run(&moves(2_000), 0);
        link.until(Link::is_over);
        (link.transcript, link.now.to_bits())
    };
    assert_eq!(run(), run());
}

#[test]
fn a_lost_connection_stops_the_robot_and_resumes_with_the_unanswered_line() {
    for seed in 0..100 {
        let lines = moves(60);
        let mut link = Link::new(Faults { seed, delay: 0.5, lost: 0.05, doubled: 0.05 }, 30.0);
        link.run(&lines, 0);
        let cut = 1 + link.draw(200);
        for _ in 0..cut {
            link.step();
        }
        if link.is_over() {
            continue;
        }
        // In the middle of a move.
        link.now += 0.2;
        link.cut();
        let State::Stopped(Stopped::Lost(line)) = link.driver.state() else {
            std::panic::panic_any("the driver goes on")
        };
        assert!(!link.robot.is_moving());
        let place = link.robot.place(link.now);
        link.now += 1000.0;
        assert_eq!(link.robot.place(link.now), place, "the robot stays");
        let all = targets(&lines);
        let done = targets(&lines[..line]).len();
        let made = link.robot.moves().len();
        // The line without an answer may have been executed before the cut.
        assert!(made == done || made == done + 1, "{seed}: cut at line {line}");
        assert_eq!(link.robot.moves(), &all[..made], "{seed}: cut at line {line}");
        link.connect();
        link.run(&lines, line);
        link.until(Link::is_over);
        assert_eq!(link.driver.state(), State::Ended);
        let back = done.checked_sub(1).map(|n| [[all[n][0], all[n][1], all[59][2]], all[n]]);
        let more = [&back.unwrap_or_default()[..2 * done.min(1)], &all[done..]].concat();
        assert_eq!(link.robot.moves()[made..], more, "{seed}: cut at line {line}");
    }
}

#[test]
fn pause_ends_the_move_and_stop_does_not() {
    let lines =
        [Command::Cut([0., 0., 0.]), Command::Cut([50., 0., 0.]), Command::Cut([0., 0., 0.])];
    let mut link = Link::new(Faults::default(), 60.0);
    link.run(&lines, 0);
    link.until(|l| l.events.contains(&Event::Sent(1)));
    link.step();
    link.driver.pause();
    let begin = link.now;
    link.until(|l| !l.robot.is_moving());
    assert!(link.now - begin <= 10.0 + 0.1, "50 mm at 5 mm/s");
    for _ in 0..100 {
        link.step();
    }
    assert!(link.now - begin > 600.0, "the robot keeps a connection that pauses");
    assert_eq!(link.driver.state(), State::Paused);
    assert_eq!(link.robot.place(link.now), [50., 0., 0.]);
    assert!(!link.events.contains(&Event::Sent(2)));
    link.driver.resume(link.now);
    link.until(Link::is_over);
    assert_eq!(link.robot.moves(), targets(&lines));

    let mut link = Link::new(Faults::default(), 60.0);
    link.run(&lines, 0);
    link.until(|l| l.events.contains(&Event::Sent(1)));
    let sent = link.driver.output();
    link.robot.receive(&sent, link.now);
    let begin = link.now;
    link.driver.pause();
    link.driver.resume(link.now);
    link.driver.stop();
    let out = link.driver.output();
    assert_eq!(out, b"EXIT\r\n");
    link.now = begin + 0.5;
    link.robot.receive(&out, link.now);
    assert!(!link.robot.is_moving());
    let place = link.robot.place(link.now);
    assert!(0.0 < place[0] && place[0] < 5.0, "{place:?}");
    assert_eq!(link.driver.state(), State::Stopped(Stopped::User(1)));
    assert_eq!(link.robot.poll(link.now), [Output::Close]);
}

#[test]
fn refusals_stop_the_run_and_name_the_line() {
    let lines =
        [Command::Cut([0., 0., 0.]), Command::Cut([400., 0., 0.]), Command::Cut([1., 0., 0.])];
    let mut link = Link::new(Faults::default(), 60.0);
    link.run(&lines, 0);
    link.until(Link::is_over);
    assert_eq!(link.driver.state(), State::Stopped(Stopped::Refused(1, robot::Refusal::Range)));
    assert_eq!(link.robot.moves(), [[0., 0., 0.]]);
    // A refusal with the word that answers the probe before: the probe before is SPEED, then ?.
    for (line, text, why) in
        [(1, "LMOVE,1,2\r\n", robot::Refusal::Format), (2, "X\r\n", robot::Refusal::Unknown)]
    {
        let mut link = Link::new(Faults::default(), 60.0);
        let lines = moves(5);
        link.run(&lines, 0);
        link.until(|l| l.events.contains(&Event::Sent(line)));
        drop(link.driver.output());
        link.to_robot.extend_from_slice(text.as_bytes());
        link.until(Link::is_over);
        assert_eq!(link.driver.state(), State::Stopped(Stopped::Refused(line, why)));
        assert_eq!(link.robot.moves(), targets(&lines[..line]));
    }
    // A robot that says nothing any more.
    let mut link = Link::new(Faults { lost: 1.0, ..Faults::default() }, 5.0);
    link.run(&lines, 0);
    link.until(Link::is_over);
    assert_eq!(link.driver.state(), State::Stopped(Stopped::Silent(0)));
    // A second client.
    let mut robot = Controller::new(Volume::default(), ZERO, Faults::default());
    assert_eq!(robot.connect(0.0), None);
    let busy = robot.connect(0.0).unwrap();
    let mut second = Driver::new(1.0);
    second.connected(0.0);
    second.receive(&busy, 0.0);
    assert_eq!(second.state(), State::Stopped(Stopped::Busy));
}

/// The tool was lifted since the last point: it goes above that, and down to it, before it cuts on.
#[test]
fn a_run_from_the_middle_goes_to_the_last_point_from_above() {
    let lines = [
        Command::Rapid([0., 0., 10.]),
        Command::Speed(5.0),
        Command::Cut([0., 0., -1.]),
        Command::Cut([20., 0., -1.]),
        Command::Cut([20., 9., -1.]),
    ];
    let mut link = Link::new(Faults::default(), 60.0);
    link.run(&lines, 4);
    link.until(Link::is_over);
    let sent: Vec<&str> = link.transcript.split('|').filter(|l| l.contains("MOVE")).collect();
    let moves =
        ["JMOVE,20.000,0.000,10.000", "LMOVE,20.000,0.000,-1.000", "LMOVE,20.000,9.000,-1.000"];
    assert!(sent.iter().zip(moves).all(|(s, m)| s.ends_with(m)) && sent.len() == 3, "{sent:?}");
    assert_eq!(link.events.iter().filter(|e| matches!(e, Event::Executed(4, true))).count(), 1);
}

#[test]
fn stop_before_the_run_ends_the_connection() {
    let mut driver = Driver::new(1.0);
    driver.connected(0.0);
    driver.stop();
    assert_eq!(driver.output(), b"EXIT\r\n");
    assert_eq!(driver.state(), State::Stopped(Stopped::User(0)));
    driver.receive(b"-400 0 -30\r\nEsperando inicio\r\n", 1.0);
    assert!(!driver.run(moves(5), 0, 1.0));
}

#[test]
fn the_driver_survives_any_answer() {
    let mut chance = 7_u64;
    for _ in 0..2000 {
        let mut driver = Driver::new(1.0);
        driver.connected(0.0);
        driver.receive(b"-400 0 -30\r\nEsperando inicio\r\n", 0.0);
        assert!(driver.run(moves(5), 0, 0.0));
        for n in 0..20 {
            chance = chance.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
            let words: [&[u8]; 6] = [
                b"done\r\n",
                b"error unknown\r\n",
                b"error format\r\n",
                b"1 2 3\r\n",
                b"\xff\0\r",
                b"x",
            ];
            driver.receive(words[usize::try_from(chance >> 61).unwrap() % 6], f64::from(n));
            driver.poll(f64::from(n));
        }
        let sent = driver.output();
        assert!(!sent.is_empty() && sent.is_ascii());
    }
}

#[test]
fn a_program_of_any_dialect_runs_to_its_end() {
    let text = b"G0 Z10\nX5 Y5\nG1 Z-0.25 F300\nG2 X15 Y5 R5\nG1 X5\nG0 Z10\n";
    let (records, _) = convert(text, &Volume::default(), &ZERO, 5.0).unwrap();
    let lines: Vec<Command> = records.iter().map(|r| r.command).collect();
    let mut link = Link::new(Faults::default(), 60.0);
    link.run(&lines, 0);
    link.until(Link::is_over);
    assert_eq!(link.robot.moves(), targets(&lines));
    assert_eq!(link.robot.moves().len(), 2 + 180 + 2);
}

/// A copy that comes after the next line has left is no refusal of it, as its `done` tells.
#[test]
fn a_late_copy_stops_nothing() {
    let mut driver = Driver::new(60.0);
    driver.connected(0.0);
    driver.receive(b"-400 0 -30\r\nEsperando inicio\r\n", 0.0);
    assert!(driver.run(moves(2), 0, 0.0));
    assert_eq!(driver.output(), b"inicio\r\n");
    driver.receive(b"done\r\nerror unknown\r\n", 1.0);
    assert_eq!(driver.output(), b"?\r\nSPEED,5.000\r\n");
    driver.receive(b"error unknown\r\n", 2.0);
    assert_eq!(driver.output(), b"SPEED\r\n", "asked at once");
    driver.receive(b"done\r\nerror format\r\n", 3.0);
    assert_eq!(driver.state(), State::Running);
    assert_eq!(driver.events()[1..3], [Event::Sent(0), Event::Executed(0, true)]);
}

/// Answers have no numbers: behind the time-out of a line, the word of the probe is taken for the probe's answer. Any other
/// refusal stops the run.
#[test]
fn a_refusal_behind_the_time_out_counts_unless_it_has_the_word_of_the_probe() {
    for (word, wanted) in [
        ("error format", State::Running),
        ("error range", State::Stopped(Stopped::Refused(0, robot::Refusal::Range))),
    ] {
        let mut driver = Driver::new(1.0);
        driver.connected(0.0);
        driver.receive(b"-400 0 -30\r\nEsperando inicio\r\n", 0.0);
        assert!(driver.run(moves(2), 0, 0.0));
        driver.receive(b"done\r\nerror unknown\r\n", 0.1);
        assert_eq!(driver.output(), b"inicio\r\n?\r\nSPEED,5.000\r\n");
        driver.poll(2.0);
        assert_eq!(driver.output(), b"SPEED\r\n", "the probe behind the time-out");
        driver.receive(format!("{word}\r\n").as_bytes(), 2.1);
        assert_eq!(driver.state(), wanted, "{word}");
        let executed = driver.events().contains(&Event::Executed(0, false));
        assert_eq!(executed, wanted == State::Running, "{word}");
    }
}

/// Above the last point, at the greatest height of the program, is a point of its own: a long tool does not reach it.
#[test]
fn the_way_to_a_line_is_checked_like_the_program() {
    let path = std::env::temp_dir().join(format!("ferrule-approach-{}.nc", std::process::id()));
    std::fs::write(&path, "G0 X0 Y0 Z60\nX100\nZ0\nG1 X110 F300\nX120\n").unwrap();
    let mut volume = Volume::default();
    let program = robot::Program::read(&path, &volume, &ZERO, 5.0).unwrap();
    std::fs::remove_file(path).unwrap();
    assert_eq!(program.check_approach(&volume, 4), Ok(()));
    assert_eq!(robot::approach(&program.commands(), 0), [Command::Start]);
    volume.max[2] = 29.0;
    let why = program.check_approach(&volume, 4).unwrap_err();
    assert!(why.ends_with(
        "the way to line 4: X100.000 Y0.000 Z60.000 is outside the work volume: robot Z 30.000 > 29"
    ), "{why}");
}
