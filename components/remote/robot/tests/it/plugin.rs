//! The plugin over a socket of this machine, and a controller in another program.
#![expect(clippy::unwrap_used, reason = "tests")]

use crate::sim;

use hal_bench::Bench;
use robot::{Robot, TcpOpening};
use sim::Sim;
use std::{
    io::Read as _,
    net::{TcpListener, TcpStream},
    time::Duration,
};

const MS: i64 = 1_000_000;
/// Largest number of steps of the worker that wait for bytes, each for 2 ms at most.
const STEPS: u32 = 200_000;
/// Longest wait for the end of a connection that is not ended, so that the test fails.
const LONGEST: Duration = Duration::from_secs(300);

fn bench(address: &str) -> Bench {
    let mut bench = Bench::new().with_hardware();
    bench.load::<Robot>(&[&format!("to={address}")]).unwrap();
    assert!(bench.names().iter().all(|name| !name.contains(".sim.")));
    bench.set("robot.enable", true);
    bench.run("robot", MS);
    bench
}

fn step(bench: &Bench) {
    bench.pass(MS / 10);
    bench.run("robot", MS);
    bench.work("robot", 1).unwrap();
    bench.run("robot", MS);
}

fn until(bench: &Bench, pin: &str) {
    let mut steps = 0;
    while !bench.get::<bool>(pin) {
        step(bench);
        // A thread that connects ends by itself, and no step waits for it.
        let is_opening = bench.get::<bool>("robot.busy") && !bench.get::<bool>("robot.connected");
        steps += u32::from(!is_opening);
        assert!(steps < STEPS, "{pin} stays FALSE: {:?}", bench.said());
        std::thread::yield_now();
    }
}

fn program(name: &str, text: &str) -> String {
    let path = std::env::temp_dir().join(format!("ferrule-{name}-{}.nc", std::process::id()));
    std::fs::write(&path, text).unwrap();
    format!("file={}", path.display())
}

fn connect(bench: &Bench, file: &str) {
    bench.command("robot.connect", &[]).unwrap();
    until(bench, "robot.ready");
    bench.command("robot.load", &[file]).unwrap();
    bench.work("robot", 1).unwrap();
    assert_eq!(bench.failure(), None);
    bench.command("robot.run", &[]).unwrap();
}

#[test]
fn a_program_runs_over_tcp_with_doubled_answers() {
    let mut sim =
        Sim::new(&["--once", "--fast", "10", "--doubled", "0.2", "--zero", "-390,1.5,-31"]);
    let bench = bench(&sim.address);
    let file = program("tcp", "G0 Z10\nG0 X5 Y5\nG1 Z0 F300\nG2 X15 Y5 R5\nG0 Z10\n");
    connect(&bench, &file);
    until(&bench, "robot.ended");
    let end = sim.line();
    assert!(end.ends_with(": ended, 183 moves"), "{end}");
    assert_eq!(bench.get::<f64>("robot.zero-y").to_bits(), 1.5_f64.to_bits());
    assert_eq!(bench.get::<i32>("robot.line"), bench.get::<i32>("robot.lines"));
    assert_eq!(bench.get::<i32>("robot.error"), 0);
    std::fs::remove_file(file.trim_start_matches("file=")).unwrap();
}

#[test]
fn the_e_stop_chain_and_the_stop_action_end_a_run_over_tcp() {
    for (how, error) in [("enable", 2), ("stop", 10), ("lost", 3)] {
        let mut sim = Sim::new(&["--once"]);
        // The retract of 50 mm takes 5 s of the simulated robot.
        let bench = bench(&sim.address);
        bench.command("robot.connect", &[]).unwrap();
        until(&bench, "robot.connected");
        match how {
            "enable" => bench.set("robot.enable", false),
            "stop" => bench.stop(),
            _ => {
                sim.child.kill().unwrap();
                sim.child.wait().unwrap();
            }
        }
        until(&bench, "robot.stopped");
        if how != "lost" {
            let end = sim.line();
            assert!(end.ends_with(": ended, 0 moves"), "{how}: {end}");
        }
        assert_eq!(bench.get::<i32>("robot.error"), error, "{how}");
        assert!(!bench.get::<bool>("robot.connected"));
    }
}

/// Returns what a client has sent up to its end.
fn sent(client: &mut TcpStream) -> String {
    let mut text = String::new();
    client.set_read_timeout(Some(LONGEST)).unwrap();
    client.read_to_string(&mut text).unwrap();
    text
}

#[test]
fn a_connection_that_was_given_up_ends_with_exit() {
    // The thread connects, and before the worker looks the connection is aborted: by the e-stop chain, a command, a hold, and
    // the end of the instance.
    for (how, error) in
        [("enable", 2), ("robot.stop", 1), ("hold", 7), ("halt", 10), ("robot.disconnect", 0)]
    {
        let listener = TcpListener::bind("127.0.0.1:0").unwrap();
        let bench = bench(&listener.local_addr().unwrap().to_string());
        bench.command("robot.connect", &[]).unwrap();
        bench.work("robot", 1).unwrap();
        bench.run("robot", MS);
        assert!(bench.get::<bool>("robot.busy") && !bench.get::<bool>("robot.connected"));
        match how {
            "enable" | "hold" => {
                bench.set(&format!("robot.{how}"), how == "hold");
                bench.run("robot", MS);
            }
            "halt" => bench.stop(),
            command => drop(bench.command(command, &[]).unwrap()),
        }
        let (mut client, _) = listener.accept().unwrap();
        if error == 0 {
            step(&bench);
        } else {
            until(&bench, "robot.stopped");
        }
        assert_eq!(sent(&mut client), "EXIT\r\n", "{how}");
        assert_eq!(bench.get::<i32>("robot.error"), error, "{how}");
        assert!(!bench.get::<bool>("robot.busy"), "{how}");
    }
}

#[test]
fn a_connection_that_was_given_up_early_is_no_failure() {
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let to = listener.local_addr().unwrap().to_string();
    let opening = TcpOpening::begin(&to, LONGEST, LONGEST).unwrap();
    // The thread looks at the flag behind the connection, and waits for it here.
    let mut is_given_up = opening.flag().lock().unwrap();
    let (mut client, _) = listener.accept().unwrap();
    *is_given_up = true;
    drop(is_given_up);
    // A thread that was faster has made the connection.
    if let Some(made) = opening.poll() {
        made.unwrap().exit();
    }
    assert_eq!(sent(&mut client), "EXIT\r\n");
    let is_quiet = |_| {
        std::thread::yield_now();
        opening.poll().is_none()
    };
    assert!((0..10_000).all(is_quiet), "the end of the thread is taken for a failure");
}

#[test]
fn a_controller_that_is_not_there_is_named() {
    let address = TcpListener::bind("127.0.0.1:0").unwrap().local_addr().unwrap().to_string();
    let bench = bench(&address);
    bench.command("robot.connect", &[]).unwrap();
    until(&bench, "robot.stopped");
    assert_eq!(bench.get::<i32>("robot.error"), 7);
    // The pins show it first.
    step(&bench);
    step(&bench);
    assert_eq!(bench.failure().unwrap(), format!("{address}: Connection refused"));
    let status = bench.command("robot.status", &[]).unwrap();
    assert_eq!(status.last().unwrap(), &format!("problem: {address}: Connection refused"));
}
