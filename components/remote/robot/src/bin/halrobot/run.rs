//! A run from the terminal.

use crate::{RunOptions, print};
use robot::{Driver, Event, Program, Record, State, Stopped, TcpLink, Volume, Zero};
use std::{
    io::BufRead as _,
    sync::mpsc::{Receiver, channel},
    time::{Duration, Instant},
};

/// Longest wait for bytes.
const TICK: Duration = Duration::from_millis(5);
/// Longest time for a connection.
const CONNECT: Duration = Duration::from_secs(60);

/// Converts and checks alone.
pub(crate) fn only_convert(options: &RunOptions, zero: Zero) -> Result<(), String> {
    let program = program(options, zero)?;
    print(&format!("{} lines, all in the work volume\n", program.records.len()))
}

/// Converts the program, and writes the lines if they are wanted.
fn program(options: &RunOptions, zero: Zero) -> Result<Program, String> {
    let volume = Volume { tool: options.tool, ..Volume::default() };
    let path = options.file.as_deref().ok_or("a program is needed")?;
    let program = Program::read(path, &volume, &zero, options.speed)?;
    let file = path.display();
    for warning in &program.warnings {
        print(&format!("{file}: warning: {warning}\n"))?;
    }
    let count = program.records.len();
    if options.from > count {
        return Err(format!("--from {}: there are {count} lines", options.from));
    }
    program.check_approach(&volume, options.from)?;
    if let Some(path) = &options.lines {
        let written = hal_output::write(path, program.table().as_bytes());
        written.map_err(|e| format!("{}: {}", path.display(), hal_output::reason(&e)))?;
    }
    Ok(program)
}

/// Reads words from standard input in a thread of its own.
fn words() -> Receiver<String> {
    let (send, receive) = channel();
    std::thread::spawn(move || {
        for line in std::io::stdin().lock().lines().map_while(Result::ok) {
            if send.send(line.trim().to_owned()).is_err() {
                return;
            }
        }
    });
    receive
}

/// Runs the program on a robot.
#[expect(
    clippy::disallowed_methods,
    reason = "a program at the edge: the robot lives in real time"
)]
pub(crate) fn run(options: &RunOptions) -> Result<(), String> {
    // NaN is refused too.
    if !(0.0 < options.timeout && options.timeout < f64::INFINITY) {
        return Err(format!("--timeout {}: must be a number above 0", options.timeout));
    }
    let mut link = TcpLink::connect(&options.to, CONNECT, TICK)?;
    let begin = Instant::now();
    let now = || begin.elapsed().as_secs_f64();
    let mut driver = Driver::new(options.timeout);
    driver.connected(now());
    let words = words();
    let mut records: Vec<Record> = Vec::new();
    // A pause that is asked for before the run begins.
    let mut is_held = false;
    loop {
        link.exchange(&mut driver, now);
        if !is_held && let (State::Ready, Some(zero)) = (driver.state(), driver.zero()) {
            match program(options, zero) {
                Ok(program) => {
                    driver.run(program.commands(), options.from, now());
                    records = program.records;
                }
                Err(text) => {
                    driver.stop();
                    // The robot stands still: nothing but the end was sent.
                    link.send(&mut driver);
                    return Err(text);
                }
            }
        }
        for word in words.try_iter() {
            match word.as_str() {
                "pause" => {
                    is_held = true;
                    driver.pause();
                }
                "resume" => {
                    is_held = false;
                    driver.resume(now());
                }
                "stop" => driver.stop(),
                other => print(&format!("'{other}' is none of pause, resume and stop\n"))?,
            }
        }
        for event in driver.events() {
            show(&event, &records)?;
        }
        link.send(&mut driver);
        match driver.state() {
            State::Ended => {
                let count = records.len().saturating_sub(options.from);
                return print(&format!("{count} lines executed\n"));
            }
            State::Stopped(Stopped::User(_)) if records.is_empty() => {
                return Err("stopped before the first line was sent".to_owned());
            }
            State::Stopped(why) => return Err(ended(&why)),
            State::Closed => {
                return Err(format!("{}: the robot closed the connection", options.to));
            }
            State::Connected | State::Ready | State::Running | State::Paused => {}
        }
    }
}

fn ended(why: &Stopped) -> String {
    why.line().map_or_else(|| why.to_string(), |n| format!("{why}; --from {n} resumes there"))
}

/// Prints the lists of a run: the program's line, the robot's line, and whether it was executed.
fn show(event: &Event, records: &[Record]) -> Result<(), String> {
    match event {
        Event::Zero([x, y, z]) => print(&format!("part zero {x:.3} {y:.3} {z:.3}\n")),
        Event::Sent(n) => {
            records.get(*n).map_or(Ok(()), |r| print(&format!("{n}\t{}\t{}\n", r.text, r.command)))
        }
        Event::Executed(n, true) => print(&format!("{n}\tdone\n")),
        Event::Executed(n, false) => print(&format!("{n}\tdone, its answer was lost\n")),
        Event::Noise => print("the robot sent text that is no answer\n"),
    }
}
