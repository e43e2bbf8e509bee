//! Work for viewers: files that never end, requests that go away, and the memory that they leave.

use super::printer::Printer;
use hal_tests::{
    scratch::until,
    web::{self, Answer},
};
use std::{
    fs,
    io::{Read as _, Write as _},
    net::TcpStream,
};

/// Programs that a viewer finds, or that an operator has stored: none of them ends.
const ENDLESS: &[(&str, &str)] = &[
    ("quiet.ngc", "o1 repeat [2000000000]\no1 endrepeat\nM2\n"),
    ("moves.ngc", "G21 G91\no1 repeat [2000000000]\nG0 X1\nG0 X-1\no1 endrepeat\nM2\n"),
    ("calls.ngc", "o<a> sub\no2 while [1]\nG4 P0\no2 endwhile\no<a> endsub\no<a> call\nM2\n"),
    ("arcs.ngc", "G21 G91\no1 while [1]\nG2 X0 Y0 I1 J0 P9\no1 endwhile\nM2\n"),
];
const SHORT: &str = "G21\nG0 X10\nG1 F100 Y10\nM2\n";
/// Requests that are aborted in a run of all tests, and in the long one.
const ABORTED: usize = 60;
const LONG: usize = 1000;

fn machine() -> Printer {
    let printer = Printer::start("viewer");
    for (name, text) in ENDLESS {
        printer.scratch.write(&format!("programs/{name}"), text);
    }
    printer.scratch.write("programs/short.ngc", SHORT);
    printer
}

/// Sends a request whose answer nobody has read yet.
fn asks(printer: &Printer, headers: &str, path: &str) -> TcpStream {
    let mut stream = TcpStream::connect(("127.0.0.1", printer.port)).unwrap();
    let request = format!("GET /api/v1{path} HTTP/1.1\r\n{headers}\r\n");
    stream.write_all(request.as_bytes()).unwrap();
    stream
}

/// Returns the path of the short program, as soon as the person has a seat.
fn short(printer: &Printer, headers: &str) -> Answer {
    printer.request("GET", "/api/v1/programs/short.ngc/path", headers, b"")
}

fn resident(pid: u32) -> u64 {
    let status = fs::read_to_string(format!("/proc/{pid}/status")).unwrap();
    let line = status.lines().find_map(|line| line.strip_prefix("VmRSS:")).unwrap();
    line.trim().trim_end_matches(" kB").parse().unwrap()
}

#[test]
fn files_that_never_end_block_nobody_else() {
    let printer = machine();
    let (mallory, ana) = (printer.sign_in(), printer.sign_in());
    let mut requests = Vec::new();
    // All seats of the one session are taken, also for pictures and texts, and the other goes on.
    for path in ["programs/short.ngc", "programs/short.ngc/path", "graph"] {
        until("the seats are taken", || {
            // Those that move: the interpreter ends the others by itself before long. A look for a seat may have that of one.
            for name in ["moves", "arcs"] {
                let path = format!("/programs/{name}.ngc/path");
                requests.push(asks(&printer, &mallory.headers(), &path));
            }
            let path = format!("/api/v1/{path}");
            printer.request("GET", &path, &mallory.headers(), b"").code() == "too-many"
        });
    }
    let answer = short(&printer, &ana.headers());
    assert_eq!((answer.status, &answer.body[..8]), (200, &b"FERPATH1"[..]));
    // Stops need no seat.
    assert_eq!(mallory.socket().command("estop", &serde_json::json!({})), "");
    // The work of requests that have gone ends.
    drop(requests);
    until("the seats are free again", || short(&printer, &mallory.headers()).status == 200);
}

/// Aborts requests, and returns the memory of the panel before and after.
fn abort(count: usize) -> (u64, u64) {
    let printer = machine();
    let (mallory, ana) = (printer.sign_in(), printer.sign_in());
    let round = |count: usize| {
        for n in 0..count {
            let (name, _) = ENDLESS[n % ENDLESS.len()];
            let path = format!("/programs/{name}/path");
            let stream = asks(&printer, &mallory.headers(), &path);
            // Some are aborted at once, and some in the middle.
            if n % 3 == 0 {
                assert_eq!(short(&printer, &ana.headers()).status, 200);
            }
            drop(stream);
        }
        until("all work has ended", || short(&printer, &mallory.headers()).status == 200);
    };
    // Memory for what every process keeps.
    round(ABORTED);
    let before = resident(printer.panel_pid());
    round(count);
    (before, resident(printer.panel_pid()))
}

#[test]
fn aborted_requests_leave_no_memory() {
    let (before, after) = abort(ABORTED);
    // So few requests do not bring the number of the panel's threads, each with some 100 kB, to its end yet.
    let most = before * 11 / 10 + (4 << 10);
    assert!(after <= most, "{before} kB before, {after} kB after");
}

#[test]
#[ignore = "a measurement: cargo test -p hal-tests --test system panel::viewers::a_thousand -- --ignored --nocapture"]
#[expect(clippy::print_stdout, reason = "figures")]
fn a_thousand_aborted_requests_leave_no_memory() {
    let (before, after) = abort(LONG);
    println!("memory of the panel: {before} kB before, {after} kB after {LONG} requests");
    assert!(after * 10 <= before * 11, "{before} kB before, {after} kB after");
}

#[test]
fn a_client_that_reads_nothing_keeps_its_own_seats_alone() {
    let printer = machine();
    let (mallory, ana) = (printer.sign_in(), printer.sign_in());
    // An answer that is larger than what the system keeps for a connection.
    printer.scratch.write("programs/large.ngc", "G0 X1\n".repeat(2_000_000));
    let path = "/programs/large.ngc";
    let mut streams: Vec<_> = (0..4).map(|_| asks(&printer, &mallory.headers(), path)).collect();
    for stream in &mut streams {
        stream.read_exact(&mut [0; 12]).unwrap();
    }
    let answer = printer.request("GET", "/api/v1/programs/short.ngc", &mallory.headers(), b"");
    assert_eq!(answer.code(), "too-many");
    assert_eq!(short(&printer, &ana.headers()).status, 200);
    let whole =
        web::request(printer.port, "GET", "/api/v1/programs/large.ngc", &ana.headers(), b"");
    assert_eq!(whole.body.len(), 12_000_000);
    drop(streams);
    until("the seats are free again", || short(&printer, &mallory.headers()).status == 200);
}
