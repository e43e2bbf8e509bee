//! The plugin over a socket of this machine, and a controller in another program.
#![expect(clippy::unwrap_used, reason = "tests")]

use hal_bench::Bench;
use robot::Robot;
use std::{
    io::{BufRead as _, BufReader, Read as _},
    net::{TcpListener, TcpStream},
    process::{Child, ChildStdout, Command, Stdio},
};

const MS: i64 = 1_000_000;
/// Largest number of steps of the worker: each waits for bytes.
const STEPS: u32 = 200_000;

/// Simulated robot, and its address.
struct Sim {
    child: Child,
    out: BufReader<ChildStdout>,
    address: String,
}

impl Sim {
    fn new(fast: &str, more: &[&str]) -> Self {
        let mut child = Command::new(env!("CARGO_BIN_EXE_halrobotsim"))
            .args(["--listen", "127.0.0.1:0", "--fast", fast, "--once"])
            .args(more)
            .stdout(Stdio::piped())
            .spawn()
            .unwrap();
        let mut out = BufReader::new(child.stdout.take().unwrap());
        let mut line = String::new();
        out.read_line(&mut line).unwrap();
        let address = line.trim().strip_prefix("listening at ").unwrap().to_owned();
        Self { child, out, address }
    }

    fn end(&mut self) -> String {
        let mut line = String::new();
        self.out.read_line(&mut line).unwrap();
        line.trim().split_once(": ").unwrap().1.to_owned()
    }
}

impl Drop for Sim {
    fn drop(&mut self) {
        drop(self.child.kill());
        drop(self.child.wait());
    }
}

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
    for _ in 0..STEPS {
        step(bench);
        if bench.get::<bool>(pin) {
            return;
        }
        std::thread::yield_now();
    }
    assert!(bench.get::<bool>(pin), "{pin} stays FALSE: {:?}", bench.said());
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
    let mut sim = Sim::new("50", &["--doubled", "0.2", "--zero", "-390,1.5,-31"]);
    let bench = bench(&sim.address);
    let file = program("tcp", "G0 Z10\nG0 X5 Y5\nG1 Z0 F300\nG2 X15 Y5 R5\nG0 Z10\n");
    connect(&bench, &file);
    until(&bench, "robot.ended");
    assert_eq!(sim.end(), "ended, 183 moves");
    assert_eq!(bench.get::<f64>("robot.zero-y").to_bits(), 1.5_f64.to_bits());
    assert_eq!(bench.get::<i32>("robot.line"), bench.get::<i32>("robot.lines"));
    assert_eq!(bench.get::<i32>("robot.error"), 0);
    std::fs::remove_file(file.trim_start_matches("file=")).unwrap();
}

#[test]
fn the_e_stop_chain_and_the_stop_action_end_a_run_over_tcp() {
    for (how, error) in [("enable", 2), ("stop", 10), ("lost", 3)] {
        let mut sim = Sim::new("1", &[]);
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
            assert_eq!(sim.end(), "ended, 0 moves", "{how}");
        }
        assert_eq!(bench.get::<i32>("robot.error"), error, "{how}");
        assert!(!bench.get::<bool>("robot.connected"));
    }
}

/// Returns what a client has sent up to its end.
fn sent(client: &mut TcpStream) -> String {
    let mut text = String::new();
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
        until(&bench, if error == 0 { "robot.enable" } else { "robot.stopped" });
        assert_eq!(sent(&mut client), "EXIT\r\n", "{how}");
        assert_eq!(bench.get::<i32>("robot.error"), error, "{how}");
        assert!(!bench.get::<bool>("robot.busy"), "{how}");
    }
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
