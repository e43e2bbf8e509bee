//! The program halrobotsim: a robot's controller with simulated motion, delays and faults, over TCP.
#![forbid(unsafe_code)]

use clap::Parser;
use robot::{Controller, Faults, Output, Volume, Zero, parse_zero};
use std::{
    io::{ErrorKind, Read as _, Write as _},
    net::{SocketAddr, TcpListener, TcpStream},
    process::ExitCode,
    time::{Duration, Instant},
};

/// Simulated controller of a robot arm that serves lines over TCP. It stands at its part zero, and serves one client.
#[derive(Parser)]
#[command(name = "halrobotsim", version)]
struct Options {
    /// Address and port to listen at; port 0 takes a free one.
    #[arg(long, default_value = "127.0.0.1:55000")]
    listen: SocketAddr,
    /// Part zero in robot coordinates.
    #[arg(long, value_parser = parse_zero, default_value = "-400,0,-30", allow_hyphen_values = true)]
    zero: Zero,
    /// Longest delay of an answer, in seconds: 0 to 3600.
    #[arg(long, value_parser = delay, default_value = "0")]
    delay: f64,
    /// Share of answers that are lost, 0 to 1.
    #[arg(long, value_parser = share, default_value = "0")]
    lost: f64,
    /// Share of answers that come twice, 0 to 1.
    #[arg(long, value_parser = share, default_value = "0")]
    doubled: f64,
    /// Seed of chance.
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Simulated seconds in a second: 0.001 to 1000000.
    #[arg(long, value_parser = fast, default_value = "1")]
    fast: f64,
    /// End after the first connection.
    #[arg(long)]
    once: bool,
}

/// Longest wait for bytes; the simulated motion advances at least so often.
const TICK: Duration = Duration::from_millis(2);

fn delay(text: &str) -> Result<f64, String> {
    within(text, 0.0, 3600.0)
}

fn share(text: &str) -> Result<f64, String> {
    within(text, 0.0, 1.0)
}

fn fast(text: &str) -> Result<f64, String> {
    within(text, 0.001, 1e6)
}

fn within(text: &str, low: f64, high: f64) -> Result<f64, String> {
    let value = text.parse().ok().filter(|x| (low..=high).contains(x));
    value.ok_or_else(|| format!("a number between {low} and {high}"))
}

fn main() -> ExitCode {
    hal_output::program(|_| match serve(&Options::parse()) {
        Ok(()) => ExitCode::SUCCESS,
        Err(text) => say(&text),
    })
}

/// Prints a message; whether anybody reads it makes no difference.
fn say(text: &str) -> ExitCode {
    drop(writeln!(std::io::stderr(), "halrobotsim: {text}"));
    ExitCode::FAILURE
}

#[expect(
    clippy::disallowed_methods,
    reason = "a program at the edge: its clients live in real time"
)]
fn serve(options: &Options) -> Result<(), String> {
    let listener = TcpListener::bind(options.listen);
    let listener =
        listener.map_err(|e| format!("{}: {}", options.listen, hal_output::reason(&e)))?;
    let fail = |e: std::io::Error| hal_output::reason(&e);
    let address = listener.local_addr().map_err(fail)?;
    hal_output::print(&format!("listening at {address}\n")).map_err(|e| e.to_string())?;
    let faults = Faults {
        seed: options.seed,
        delay: options.delay,
        lost: options.lost,
        doubled: options.doubled,
    };
    let begin = Instant::now();
    let now = || begin.elapsed().as_secs_f64() * options.fast;
    let mut robot = Controller::new(Volume::default(), options.zero, faults);
    loop {
        listener.set_nonblocking(false).map_err(fail)?;
        let (client, peer) = listener.accept().map_err(fail)?;
        listener.set_nonblocking(true).map_err(fail)?;
        robot.connect(now());
        let served = one(&mut robot, client, &listener, &now);
        robot.disconnect(now());
        let end = served.map_or_else(|e| hal_output::reason(&e), |()| "ended".to_owned());
        let count = robot.moves().len();
        hal_output::print(&format!("{peer}: {end}, {count} moves\n")).map_err(|e| e.to_string())?;
        if options.once {
            return Ok(());
        }
    }
}

/// Serves one client to its end; others are told that the robot is busy.
fn one(
    robot: &mut Controller,
    mut client: TcpStream,
    listener: &TcpListener,
    now: &impl Fn() -> f64,
) -> std::io::Result<()> {
    client.set_nonblocking(false)?;
    client.set_nodelay(true)?;
    client.set_read_timeout(Some(TICK))?;
    client.set_write_timeout(Some(Duration::from_secs(1)))?;
    let mut buffer = [0; 256];
    loop {
        if let Ok((mut other, _)) = listener.accept() {
            let busy = robot.connect(now()).unwrap_or_default();
            // Whether the other client still listens makes no difference.
            drop(other.write_all(&busy));
        }
        match client.read(&mut buffer) {
            Ok(0) => return Ok(()),
            Ok(count) => robot.receive(buffer.get(..count).unwrap_or_default(), now()),
            Err(e) if matches!(e.kind(), ErrorKind::WouldBlock | ErrorKind::TimedOut) => {}
            Err(e) if e.kind() == ErrorKind::Interrupted => {}
            Err(e) => return Err(e),
        }
        // What is due goes out as a whole: an answer and its copy come together.
        let (mut bytes, mut is_over) = (Vec::new(), false);
        for output in robot.poll(now()) {
            match output {
                Output::Bytes(more) => bytes.extend(more),
                Output::Close => is_over = true,
            }
        }
        client.write_all(&bytes)?;
        if is_over {
            return Ok(());
        }
    }
}
