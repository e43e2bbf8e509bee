//! The lease of a job that runs is lost: the job is aborted, held, or goes on.

use super::printer::Printer;
use hal_tests::{scratch::until, web::Socket};
use serde_json::json;

/// A program that takes 40 s, and turns the spindle.
const PART: &str = "G21 G90 G94 G54\nM3 S1000\nG1 X20 F60\nG1 X40\nM2\n";

/// Lets machine time pass, and answers the panel's pulses.
fn pass(printer: &Printer, socket: &mut Socket, time: &str) {
    printer.halcmd(&format!("run {time}"));
    assert_eq!(socket.command("optional-stop", &json!({ "on": true })), "");
}

/// Executes a command to its end.
fn finish(printer: &Printer, socket: &mut Socket, name: &str, args: &serde_json::Value) {
    let reply = socket.ask(json!({ "type": "command", "name": name, "args": args }));
    assert!(reply["error"].is_null(), "{name}: {reply}");
    if reply["pending"] == true {
        printer.halcmd("run 5s");
        let done = socket.wait(|m| m["type"] == "done" && m["id"] == reply["id"]).unwrap();
        assert!(done["error"].is_null(), "{name}: {done}");
    }
}

/// Starts the job, takes its lease away while it moves, and returns the printer with the place of X then.
fn lose(on_loss: &str) -> (Printer, f64) {
    let clock = ["--virtual", "--hold"];
    let printer = Printer::with("operator", &clock, &format!("ON_LOSS = {on_loss}\n"));
    printer.scratch.write("programs/part.ngc", PART);
    // The panel exchanges its pins.
    printer.halcmd("run 1s");
    let mut socket = printer.sign_in().socket();
    assert_eq!(socket.ask(json!({ "type": "lease", "do": "take" }))["ok"], json!({}));
    for (name, args) in [
        ("estop-reset", json!({})),
        ("on", json!({})),
        ("home", json!({ "joint": "all" })),
        ("open", json!({ "program": "part.ngc" })),
        ("mode", json!({ "mode": "auto" })),
    ] {
        finish(&printer, &mut socket, name, &args);
    }
    // What ends with the job has its reply at once.
    let reply = socket.ask(json!({ "type": "command", "name": "run", "args": {} }));
    assert_eq!(reply["pending"], true, "{reply}");
    pass(&printer, &mut socket, "5s");
    let x = printer.number("getp joint.0.pos-cmd");
    assert!(1.0 < x && x < 10.0, "the job moves: {x}");
    assert_eq!(printer.halcmd("getp motion.feed-inhibit").trim(), "FALSE");

    drop(socket);
    until("the lease is lost", || {
        printer.halcmd("run 10ms");
        printer.halcmd("getp remote.lease").trim() == "0"
    });
    printer.halcmd("run 2s");
    (printer, x)
}

#[test]
fn a_lost_lease_aborts_a_job() {
    let (printer, x) = lose("abort");
    let status = printer.halcmd("task.status");
    assert!(status.contains("jobs=1 failed=1"), "{status}");
    let rest = printer.number("getp joint.0.pos-cmd");
    assert!(rest < x + 2.0, "{x}, then {rest}");
    assert_eq!(printer.halcmd("getp spindle.0.on").trim(), "FALSE");
    // Neither time nor the next client begins it again.
    drop(printer.sign_in().socket());
    printer.halcmd("run 5s");
    assert_eq!(printer.number("getp joint.0.pos-cmd").to_bits(), rest.to_bits());
}

#[test]
fn a_lost_lease_holds_a_job() {
    let (printer, x) = lose("hold");
    let rest = printer.number("getp joint.0.pos-cmd");
    let rests = |what: &str| {
        printer.halcmd("run 5s");
        assert_eq!(printer.number("getp joint.0.pos-cmd").to_bits(), rest.to_bits(), "{what}");
        assert_eq!(printer.halcmd("getp motion.feed-inhibit").trim(), "TRUE", "{what}");
    };
    assert!(rest < x + 2.0, "{x}, then {rest}");
    rests("time alone");
    let mut socket = printer.sign_in().socket();
    rests("a new client");
    assert_eq!(socket.ask(json!({ "type": "lease", "do": "take" }))["ok"], json!({}));
    rests("a new lease");

    // A person lets it go on, to its end.
    let reply = socket.command("resume", &json!({}));
    assert_eq!(reply, "");
    for _ in 0..6 {
        pass(&printer, &mut socket, "10s");
    }
    let status = printer.halcmd("task.status");
    assert!(status.contains("jobs=1 failed=0"), "{status}");
    assert_eq!(printer.number("getp joint.0.pos-cmd"), 40.0);
}

#[test]
fn a_lost_lease_lets_a_job_go_on() {
    let (printer, x) = lose("continue");
    let later = printer.number("getp joint.0.pos-cmd");
    assert!(x + 1.5 < later, "{x}, then {later}");
    printer.halcmd("run 60s");
    let status = printer.halcmd("task.status");
    assert!(status.contains("jobs=1 failed=0"), "{status}");
    assert_eq!(printer.number("getp joint.0.pos-cmd"), 40.0);
}
