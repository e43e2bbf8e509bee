//! Pins that nobody changes from afar: values that lead to motion, or to what drives the machine.

use super::printer::{Printer, Session};
use hal_tests::web::Socket;
use serde_json::{Value, json};

/// Components of the machine's person beside the printer's: an e-stop chain of two gates, a lamp, and a gate of which nothing leads on.
const MORE: &[&str] = &[
    "loadrt and2 count=3",
    "addf and2.0 servo-thread",
    "addf and2.1 servo-thread",
    "addf and2.2 servo-thread",
    "setp and2.0.in1 1",
    "loadrt debounce cfg=1,1",
    "addf debounce.0 servo-thread",
    "addf debounce.1 servo-thread",
    "setp debounce.0.0.in 1",
    "net gate debounce.0.0.out => and2.1.in1",
    "net loop and2.0.out => and2.1.in0",
    "net chain and2.1.out => motion.enable",
    "net xenable => and2.2.in0",
];

/// Starts the printer with more components and a person of this role who has the lease.
fn machine(role: &str) -> (Printer, Session, Socket) {
    let printer = Printer::start(role);
    MORE.iter().for_each(|line| drop(printer.halcmd(line)));
    let session = printer.sign_in();
    let mut socket = session.socket();
    assert_eq!(socket.ask(json!({ "type": "lease", "do": "take" }))["ok"], json!({}));
    (printer, session, socket)
}

/// Gives a command, and returns the code and the text of its refusal.
fn refusal(socket: &mut Socket, name: &str, args: &Value) -> (String, String) {
    let reply = socket.ask(json!({ "type": "command", "name": name, "args": args }));
    let text = |key: &str| reply["error"][key].as_str().unwrap_or_default().to_owned();
    (text("code"), text("text"))
}

/// Returns every change of the wiring of a pin.
fn changes(pin: &str) -> [(&'static str, Value); 4] {
    [
        ("setp", json!({ "name": pin, "value": "1" })),
        ("unlink", json!({ "pin": pin })),
        ("net", json!({ "signal": "own", "pins": pin })),
        ("linkp", json!({ "pin": pin, "signal": "own" })),
    ]
}

#[test]
fn an_integrator_from_afar_changes_nothing_that_leads_to_motion_or_a_line() {
    let (printer, _, mut socket) = machine("integrator");
    printer.halcmd("newsig own bit");
    for (pin, to) in [
        // Drives and lines, with the enables before them.
        ("stepgen.0.position-cmd", "stepgen', which drives the machine"),
        ("stepgen.0.enable", "stepgen', which drives the machine"),
        ("viagpio.pin-05-out", "hal_viagpio', which drives the machine"),
        ("viagpio.pin-07-out", "hal_viagpio', which drives the machine"),
        // Interlock, limits, feedback, dead man, and the beginnings of motion.
        ("motion.enable", "motmod', which takes commands"),
        ("axis.0.neg-lim-sw-in", "motmod', which takes commands"),
        ("axis.0.motor-pos-fb", "motmod', which takes commands"),
        ("axis.0.jog-enable", "motmod', which takes commands"),
        ("motion.jog-stop", "motmod', which takes commands"),
        ("iocontrol.0.emc-enable-in", "iocontrol', which takes commands"),
        ("remote.allow-motion", "remote', which takes commands"),
        ("remote.beat", "remote', which takes commands"),
        ("halpanel.beat", "remote', which takes commands"),
        // Gates before them, and outputs whose signals lead there.
        ("and2.0.in0", "motmod', which takes commands"),
        ("and2.0.in1", "motmod', which takes commands"),
        ("and2.1.in0", "motmod', which takes commands"),
        ("and2.1.out", "motmod', which takes commands"),
        ("axis.0.motor-pos-cmd", "stepgen', which drives the machine"),
        ("stepgen.0.step", "hal_viagpio', which drives the machine"),
    ] {
        let before = printer.halcmd(&format!("getp {pin}"));
        for (name, args) in changes(pin) {
            let (code, text) = refusal(&mut socket, name, &args);
            let wanted = format!("pin '{pin}' leads to '{to}: it is not changed from afar");
            assert_eq!((&*code, &*text), ("remote", &*wanted), "{name} {pin}");
        }
        if !pin.ends_with("beat") {
            assert_eq!(printer.halcmd(&format!("getp {pin}")), before, "{pin}");
        }
    }
    for signal in ["chain", "loop", "xenable", "xpos-cmd", "xpos-fb", "xstep"] {
        for (name, args) in [
            ("sets", json!({ "name": signal, "value": "1" })),
            ("net", json!({ "signal": signal, "pins": "and2.2.in1" })),
            ("linkp", json!({ "pin": "and2.2.in1", "signal": signal })),
        ] {
            assert_eq!(refusal(&mut socket, name, &args).0, "remote", "{name} {signal}");
        }
    }
    for (parameter, code) in [
        // They invert lines.
        ("viagpio.pin-05-out-invert", "remote"),
        // A filter before an enable: with another delay it would never change again.
        ("debounce.0.delay", "remote"),
        ("debounce.1.delay", ""),
        // Settings are an integrator's.
        ("stepgen.0.maxaccel", ""),
        ("stepgen.update-freq.tmax", ""),
    ] {
        let set = json!({ "name": parameter, "value": "0" });
        assert_eq!(refusal(&mut socket, "setp", &set).0, code, "{parameter}");
    }
    // What leads nowhere is free, and a display may leave the signal that it shows.
    for (name, args) in [
        ("setp", json!({ "name": "and2.2.in1", "value": "TRUE" })),
        ("unlink", json!({ "pin": "and2.2.in0" })),
        ("net", json!({ "signal": "own", "pins": "and2.2.out" })),
        ("sets", json!({ "name": "own", "value": "TRUE" })),
    ] {
        let (code, text) = refusal(&mut socket, name, &args);
        assert_ne!(code, "remote", "{name} {args}: {text}");
    }
    assert_eq!(printer.halcmd("getp and2.2.in1").trim(), "TRUE");
    // A person at the machine may.
    printer.halcmd("setp and2.0.in0 TRUE");
    printer.halcmd("unlinkp stepgen.0.position-cmd");
    printer.halcmd("setp stepgen.0.position-cmd 0");
    // The pin that has left its signal still drives.
    let (code, _) =
        refusal(&mut socket, "setp", &json!({ "name": "stepgen.0.position-cmd", "value": "5" }));
    assert_eq!(code, "remote");
}

#[test]
fn a_program_that_is_started_from_elsewhere_is_held_to_the_same() {
    let printer = Printer::start("viewer");
    let from_afar = |line: &str| {
        let mut command = printer.scratch.command(&[], "halcmd");
        let words = line.split(' ');
        printer.scratch.run(command.env("HAL_FROM_AFAR", "1").args(words))
    };
    for line in ["setp stepgen.0.position-cmd 5", "sets xpos-cmd 5", "unlinkp motion.enable"] {
        let output = from_afar(line);
        assert_ne!(output.status, Some(0), "{line}: {output:?}");
        assert!(output.stderr.contains("it is not changed from afar"), "{line}: {output:?}");
    }
    for line in [
        "loadrt and2",
        "unloadrt stepgen",
        "delf stepgen.update-freq servo-thread",
        "addf viagpio.read servo-thread",
        "delsig xpos-cmd",
        "stop",
        "lock all",
        "alias pin motion.enable mine",
        "record all.vcd",
        "unloadusr halpanel",
    ] {
        let output = from_afar(line);
        assert_ne!(output.status, Some(0), "{line}: {output:?}");
        let wanted = "this is done at the machine, and not from afar";
        assert!(output.stderr.contains(wanted), "{line}: {output:?}");
    }
    // They look, and stop.
    for line in
        ["show pin stepgen", "getp motion.enable", "check", "iocontrol.estop", "motion.abort"]
    {
        let output = from_afar(line);
        assert_eq!(output.status, Some(0), "{line}: {output:?}");
    }
}

#[test]
fn an_operator_changes_no_pin_and_learns_how_to_sign_in_as_integrator() {
    // A panel that is started without a role gives the token that of an operator.
    let mut printer = Printer::start("operator");
    printer.begin_plain();
    let mut socket = printer.sign_in().socket();
    assert_eq!(socket.ask(json!({ "type": "lease", "do": "take" }))["ok"], json!({}));
    for (name, args) in changes("stepgen.0.maxaccel") {
        assert_eq!(refusal(&mut socket, name, &args).0, "role", "{name}");
    }
    let page = printer.request("GET", "/src/texts.js", &printer.host(), b"");
    assert!(String::from_utf8_lossy(&page.body).contains("--role integrator"), "the page says how");
}
