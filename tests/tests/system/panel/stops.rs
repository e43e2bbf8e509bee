//! Stops of a machine without a task, by every role, in bursts, and beside orders of others.

use super::printer::Printer;
use hal_bench::Random;
use hal_tests::{scratch::until, web::Socket};
use serde_json::{Value, json};

/// The machine: it has no INI file and no task.
const ARM: &str = "rs03n";
/// Stops, each with what it says, and whether the machine stays on.
const STOPS: [(&str, &str, bool); 4] = [
    ("estop", "the machine is in e-stop", false),
    ("off", "motion was switched off", false),
    ("abort", "motion brakes, and the rest of its path is gone", true),
    ("pause", "motion brakes, and its path rests until it is resumed", true),
];

/// Starts the arm on a virtual clock that stands until it is run; the panel has exchanged its pins.
fn arm() -> Printer {
    let printer = Printer::of_script(ARM, &[], &[]);
    printer.halcmd("run 1s");
    printer
}

fn x(printer: &Printer) -> f64 {
    printer.number("getp axis.x.pos-cmd")
}

fn is_on(printer: &Printer) -> bool {
    printer.halcmd("getp motion.motion-enabled").trim() == "TRUE"
}

/// Switches the arm on and homes it, from a shell.
fn ready(printer: &Printer) {
    printer.halcmd("iocontrol.estop-reset --wait");
    printer.halcmd("motion.enable --wait");
    printer.halcmd("motion.home joint=all --wait");
    printer.halcmd("run 500ms");
}

/// Gives a command that must not be refused; returns what it says.
fn said(socket: &mut Socket, name: &str, args: &Value) -> String {
    let reply = socket.ask(json!({ "type": "command", "name": name, "args": args }));
    let lines = reply["ok"]["lines"].as_array().unwrap_or_else(|| panic!("{name}: {reply}"));
    lines.iter().map(|line| line.as_str().unwrap()).collect::<Vec<_>>().join("; ")
}

fn take(socket: &mut Socket) {
    assert_eq!(socket.ask(json!({ "type": "lease", "do": "take" }))["ok"], json!({}));
}

/// Lets milliseconds of machine time pass, and answers the panel's pulses meanwhile: the lease lasts for a second without.
fn pass(printer: &Printer, socket: &mut Socket, ms: u32) {
    for _ in 0..ms / 100 {
        printer.halcmd("run 100ms");
        // Its refusal is an answer too.
        socket.command("optional-stop", &json!({ "on": true }));
    }
}

#[test]
fn every_stop_stops_a_machine_without_a_task() {
    let printer = arm();
    for (name, words, stays_on) in STOPS {
        ready(&printer);
        let from = x(&printer);
        let to = if from < -450.0 { -300 } else { -500 };
        printer.halcmd(&format!("motion.move x={to} velocity=3"));
        printer.halcmd("run 2s");
        let before = x(&printer);
        assert!((before - from).abs() > 3.0, "{name}: it moves from {from} to {before}");
        // Who only looks and has no lease stops it too, but switches nothing off.
        let mut socket = printer.sign_in().socket();
        assert!(said(&mut socket, name, &json!({})).starts_with(words), "{name}");
        printer.halcmd("run 1s");
        let rest = x(&printer);
        assert!((rest - before).abs() < 0.1, "{name}: {before}, then {rest}");
        assert_eq!(is_on(&printer), stays_on, "{name}");
        // Nothing comes back by itself, nor with reset and on.
        if name != "pause" {
            printer.halcmd("iocontrol.estop-reset --wait");
            printer.halcmd("motion.enable --wait");
            printer.halcmd("run 3s");
            assert!((x(&printer) - rest).abs() < 1e-9, "{name}");
        } else {
            printer.halcmd("run 3s");
            assert!((x(&printer) - rest).abs() < 1e-9, "{name}");
            printer.halcmd("motion.resume");
            printer.halcmd("run 1s");
            assert!((x(&printer) - rest).abs() > 1.0, "the path rests, and goes on");
            printer.halcmd("motion.abort --wait");
        }
    }
}

#[test]
fn a_machine_without_a_task_is_worked_with_and_says_what_needs_one() {
    let printer = arm();
    let mut socket = printer.sign_in().socket();
    take(&mut socket);
    for (name, args) in [
        ("estop-reset", json!({})),
        ("on", json!({})),
        ("mode", json!({ "mode": "manual" })),
        ("home", json!({ "joint": "all" })),
        ("feed-override", json!({ "scale": 0.5 })),
        ("rapid-override", json!({ "scale": 0.25 })),
    ] {
        assert_eq!(socket.command(name, &args), "", "{name}");
        pass(&printer, &mut socket, 1000);
    }
    assert!(is_on(&printer));
    let z = || printer.number("getp axis.z.pos-cmd");
    let before = z();
    let jog = json!({ "axis": "z", "velocity": 20, "distance": 5 });
    assert_eq!(socket.command("jog", &jog), "");
    pass(&printer, &mut socket, 1000);
    assert!((z() - before - 5.0).abs() < 1e-6, "the jog has ended at {}", z());
    for (name, args) in [
        ("run", json!({})),
        ("mdi", json!({ "text": "G0 X1" })),
        ("mode", json!({ "mode": "auto" })),
        ("touch-off", json!({ "axis": "x", "value": 0 })),
    ] {
        let reply = socket.ask(json!({ "type": "command", "name": name, "args": args }));
        assert_eq!(reply["error"]["code"], "no-task", "{name}: {reply}");
        let text = reply["error"]["text"].as_str().unwrap();
        assert!(text.contains("need a task, and this machine has none"), "{name}: {text}");
    }
}

#[test]
fn a_path_that_is_resumed_under_the_lease_does_what_was_said_when_its_page_is_lost() {
    for on_loss in ["hold", "continue", "abort"] {
        let printer = arm();
        ready(&printer);
        printer.halcmd("motion.move x=-500 velocity=3");
        let mut socket = printer.sign_in().socket();
        take(&mut socket);
        said(&mut socket, "pause", &json!({}));
        pass(&printer, &mut socket, 1000);
        said(&mut socket, "resume", &json!({ "on_loss": on_loss }));
        pass(&printer, &mut socket, 1000);
        let before = x(&printer);
        drop(socket);
        until("the lease is lost", || {
            printer.halcmd("run 10ms");
            printer.halcmd("getp remote.lease").trim() == "0"
        });
        printer.halcmd("run 3s");
        let far = x(&printer) - before;
        assert_eq!(far < -6.0, on_loss == "continue", "{on_loss}: {far}");
        let queue = printer.halcmd("snapshot motion.status");
        assert_eq!(queue.contains("\"queue\":0"), on_loss == "abort", "{on_loss}: {queue}");
        if on_loss != "hold" {
            continue;
        }
        // The hold lasts until somebody with the lease resumes.
        let rest = x(&printer);
        printer.halcmd("motion.resume");
        let mut socket = printer.sign_in().socket();
        take(&mut socket);
        pass(&printer, &mut socket, 3000);
        assert_eq!(x(&printer).to_bits(), rest.to_bits());
        said(&mut socket, "resume", &json!({}));
        pass(&printer, &mut socket, 2000);
        assert!(x(&printer) < rest - 3.0);
    }
}

#[test]
fn stops_in_a_burst_end_no_connection_and_the_last_one_counts() {
    let printer = arm();
    ready(&printer);
    let mut socket = printer.sign_in().socket();
    for n in 0..3000 {
        let name = ["abort", "estop", "off", "pause"][n % 4];
        socket.send(&json!({ "type": "command", "id": 1_000_000 + n, "name": name, "args": {} }));
    }
    // Another message comes behind all of them.
    assert_eq!(socket.command("jog-stop", &json!({})), "");
    printer.halcmd("run 100ms");
    assert!(!is_on(&printer));
    // Other messages that come too fast end a connection, as ever.
    for n in 0..1000 {
        socket.send(&json!({ "type": "command", "id": n, "name": "mode", "args": {} }));
    }
    assert_eq!(socket.last_error(), "too-many");
}

#[test]
fn an_order_from_before_a_stop_begins_nothing() {
    let printer = arm();
    ready(&printer);
    let mut socket = printer.sign_in().socket();
    take(&mut socket);
    // Both are sent at once: the stop goes before the jog, whichever arrives first.
    for order in [["jog", "abort"], ["abort", "jog"]] {
        let at = x(&printer);
        for name in order {
            let args = match name {
                "jog" => json!({ "axis": "x", "velocity": 20, "distance": -5 }),
                _ => json!({}),
            };
            socket.send(&json!({ "type": "command", "id": 77, "name": name, "args": args }));
        }
        pass(&printer, &mut socket, 1000);
        let far = (x(&printer) - at).abs();
        // What is given after the stop is another order.
        assert!(if order[0] == "jog" { far < 5.0 } else { far < 5.1 }, "{order:?}: {far}");
    }
}

/// Stops at random moments by one of several clients, while all of them ask and command; after each the machine rests.
fn random_stops(count: u64) {
    let printer = arm();
    let mut random = Random::new(35);
    let mut viewers: Vec<Socket> = (0..4).map(|_| printer.sign_in().socket()).collect();
    let mut socket = printer.sign_in().socket();
    take(&mut socket);
    let mut pick = |n: u64| usize::try_from(random.below(n)).unwrap();
    for n in 0..count {
        ready(&printer);
        let to = if x(&printer) < -400.0 { -300 } else { -500 };
        printer.halcmd(&format!("motion.move x={to} velocity=20"));
        printer.halcmd(&format!("run {}ms", 20 + pick(200)));
        for (id, viewer) in viewers.iter_mut().enumerate() {
            for _ in 0..pick(20) {
                let id = 1_000_000 + id;
                let load = json!({ "type": "command", "id": id, "name": "jog-stop", "args": {} });
                viewer.send(&load);
            }
            viewer.send(&json!({ "type": "watch", "names": ["axis.x.pos-cmd", "remote.pulse"] }));
        }
        let (name, words, stays_on) = STOPS[pick(4)];
        let stopper = pick(5);
        let of = viewers.get_mut(stopper).unwrap_or(&mut socket);
        assert!(said(of, name, &json!({})).starts_with(words), "stop {n}: {name}");
        pass(&printer, &mut socket, 300);
        let rest = x(&printer);
        pass(&printer, &mut socket, 200);
        assert_eq!(x(&printer).to_bits(), rest.to_bits(), "stop {n}: {name} is lost");
        assert_eq!(is_on(&printer), stays_on, "stop {n}: {name} is lost");
        printer.halcmd("motion.abort --wait");
    }
    println!("{count} stops, none lost");
}

#[test]
fn random_stops_are_never_lost() {
    random_stops(25);
}

/// The same a thousand times.
#[test]
#[ignore = "takes minutes: cargo test -p hal-tests --test system panel::stops -- --ignored --nocapture"]
fn a_thousand_random_stops_are_never_lost() {
    random_stops(1000);
}
