//! The program halrobot: runs a G-code program on a robot arm behind its controller's line protocol.
#![forbid(unsafe_code)]

use clap::Parser;
use robot::{
    Command, Driver, Event, FASTEST, Record, State, Stopped, Volume, Zero, convert, parse_zero,
};
use std::{
    io::{BufRead as _, ErrorKind, Read as _, Write as _},
    net::{TcpStream, ToSocketAddrs as _},
    path::PathBuf,
    process::ExitCode,
    sync::mpsc::{Receiver, channel},
    time::{Duration, Instant},
};

/// Runs a G-code program on a robot arm. While it runs, the words pause, resume and stop on standard input are obeyed.
#[derive(Parser)]
#[command(name = "halrobot", version)]
struct Options {
    /// G-code program.
    file: PathBuf,
    /// Address and port of the robot.
    #[arg(long, default_value = "127.0.0.1:55000")]
    to: String,
    /// Highest cutting speed, in mm/s.
    #[arg(long, default_value_t = 5.0)]
    speed: f64,
    /// Length of the tool beyond the flange, in mm.
    #[arg(long, default_value_t = 0.0)]
    tool: f64,
    /// Line to begin with, as the message of a stopped run names it.
    #[arg(long, default_value_t = 0)]
    from: usize,
    /// File for the lines to the robot, with the program's lines beside them.
    #[arg(long)]
    lines: Option<PathBuf>,
    /// Convert for this part zero, and run nothing.
    #[arg(long, value_name = "X,Y,Z", value_parser = parse_zero, allow_hyphen_values = true)]
    zero: Option<Zero>,
    /// Time for the answer to a line, in seconds; longer than any move.
    #[arg(long, default_value_t = 60.0)]
    timeout: f64,
}

/// Longest wait for bytes.
const TICK: Duration = Duration::from_millis(5);
/// Longest time for a connection.
const CONNECT: Duration = Duration::from_secs(60);

fn main() -> ExitCode {
    hal_output::program(|_| {
        let options = Options::parse();
        let done = match options.zero {
            Some(zero) => only_convert(&options, zero),
            None => run(&options),
        };
        done.map_or_else(|text| say(&text), |()| ExitCode::SUCCESS)
    })
}

/// Prints a message; whether anybody reads it makes no difference.
fn say(text: &str) -> ExitCode {
    drop(writeln!(std::io::stderr(), "halrobot: {text}"));
    ExitCode::FAILURE
}

fn print(text: &str) -> Result<(), String> {
    hal_output::print(text).map_err(|e| e.to_string())
}

fn only_convert(options: &Options, zero: Zero) -> Result<(), String> {
    let records = records(options, zero)?;
    print(&format!("{} lines, all in the work volume\n", records.len()))
}

/// Converts the program, and writes the lines if they are wanted.
fn records(options: &Options, zero: Zero) -> Result<Vec<Record>, String> {
    if !(0.0 < options.speed && options.speed <= FASTEST) {
        return Err(format!("--speed {}: above 0 and at most {FASTEST}", options.speed));
    }
    let file = options.file.display();
    let text =
        std::fs::read(&options.file).map_err(|e| format!("{file}: {}", hal_output::reason(&e)))?;
    let volume = Volume { tool: options.tool, ..Volume::default() };
    let (records, warnings) =
        convert(&text, &volume, &zero, options.speed).map_err(|e| format!("{file}: {e}"))?;
    for warning in warnings {
        print(&format!("{file}: warning: {warning}\n"))?;
    }
    if options.from > records.len() {
        return Err(format!("--from {}: there are {} lines", options.from, records.len()));
    }
    if let Some(path) = &options.lines {
        let lines: String =
            records.iter().map(|r| format!("{}\t{}\n", r.text, r.command)).collect();
        let written = hal_output::write(path, lines.as_bytes());
        written.map_err(|e| format!("{}: {}", path.display(), hal_output::reason(&e)))?;
    }
    Ok(records)
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

#[expect(
    clippy::disallowed_methods,
    reason = "a program at the edge: the robot lives in real time"
)]
fn run(options: &Options) -> Result<(), String> {
    // NaN is refused too.
    if !(0.0 < options.timeout && options.timeout < f64::INFINITY) {
        return Err(format!("--timeout {}: must be a number above 0", options.timeout));
    }
    let refused = |e: std::io::Error| format!("{}: {}", options.to, hal_output::reason(&e));
    let address = options.to.to_socket_addrs().map_err(refused)?.next();
    let address = address.ok_or_else(|| format!("{}: no such address", options.to))?;
    let mut stream = TcpStream::connect_timeout(&address, CONNECT).map_err(refused)?;
    stream.set_nodelay(true).map_err(refused)?;
    stream.set_read_timeout(Some(TICK)).map_err(refused)?;
    let begin = Instant::now();
    let now = || begin.elapsed().as_secs_f64();
    let mut driver = Driver::new(options.timeout);
    driver.connected(now());
    let words = words();
    let mut records: Vec<Record> = Vec::new();
    let mut buffer = [0; 256];
    // A pause that is asked for before the run begins.
    let mut is_held = false;
    loop {
        match stream.read(&mut buffer) {
            Ok(0) => driver.disconnected(),
            Ok(count) => driver.receive(buffer.get(..count).unwrap_or_default(), now()),
            Err(e) if matches!(e.kind(), ErrorKind::WouldBlock | ErrorKind::TimedOut) => {}
            Err(e) if e.kind() == ErrorKind::Interrupted => {}
            Err(_) => driver.disconnected(),
        }
        driver.poll(now());
        if !is_held && let (State::Ready, Some(zero)) = (driver.state(), driver.zero()) {
            records = match self::records(options, zero) {
                Ok(records) => records,
                Err(text) => {
                    driver.stop();
                    // The robot stands still: nothing but the end was sent.
                    drop(stream.write_all(&driver.output()));
                    return Err(text);
                }
            };
            let lines: Vec<Command> = records.iter().map(|r| r.command).collect();
            driver.run(lines, options.from, now());
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
        let bytes = driver.output();
        if stream.write_all(&bytes).is_err() {
            driver.disconnected();
        }
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
