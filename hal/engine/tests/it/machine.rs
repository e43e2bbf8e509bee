//! Small machines in virtual time, from components that are linked in.
#![expect(clippy::unwrap_used, clippy::panic, clippy::indexing_slicing, reason = "tests")]

use hal_engine::{ClockKind, Engine, Options};
use hal_protocol::{Failure, Kind, Link, Place, Reply, Request, Value};

fn engine() -> Engine {
    let options = Options::simulated(Place::find(Some("test")).unwrap(), ClockKind::Virtual);
    let mut e = Engine::without_socket(options).unwrap();
    e.add_static(&logic::HAL_LIBRARY);
    e
}

fn words(line: &str) -> Vec<String> {
    line.split_whitespace().map(str::to_owned).collect()
}

/// A line of a script, without its language.
fn run(e: &mut Engine, line: &str) -> Result<Reply, Failure> {
    let w = words(line);
    let at = |i: usize| w[i].clone();
    e.call(match w[0].as_str() {
        "loadrt" => Request::Load { module: at(1), args: w[2..].to_vec() },
        "unloadrt" => Request::Unload { name: at(1) },
        "net" => Request::Net { signal: at(1), pins: w[2..].to_vec() },
        "unlinkp" => Request::Unlink { pin: at(1) },
        "setp" => Request::Set { name: at(1), value: at(2) },
        "getp" => Request::Get { name: at(1) },
        "gets" => Request::GetSignal { name: at(1) },
        "sets" => Request::SetSignal { name: at(1), value: at(2) },
        other => panic!("{other}"),
    })
}

fn bit(e: &mut Engine, name: &str) -> bool {
    run(e, &format!("getp {name}")).unwrap() == Reply::Value(Value::Bit(true))
}

#[test]
fn a_component_loads_links_and_goes() {
    let mut e = engine();
    run(&mut e, "loadrt and2 count=2").unwrap();
    run(&mut e, "setp and2.0.in0 1").unwrap();
    run(&mut e, "net x and2.0.out and2.1.in0").unwrap();
    assert!(!bit(&mut e, "and2.1.in0"));
    let Reply::Items(pins) =
        e.call(Request::List { kind: Kind::Pins, patterns: Vec::new(), ty: None }).unwrap()
    else {
        panic!()
    };
    assert_eq!(pins.len(), 8, "{pins:?}");
    for round in 0..100 {
        run(&mut e, "unloadrt and2").unwrap();
        assert!(run(&mut e, "getp and2.0.out").is_err(), "{round}");
        run(&mut e, "loadrt and2 names=a,b").unwrap();
        run(&mut e, "net x a.in0 b.in0").unwrap();
    }
    run(&mut e, "loadrt nand").unwrap_err();
    let Reply::Status(s) = e.call(Request::Status).unwrap() else { panic!() };
    assert_eq!((s.components.active, s.pins.active, s.signals.active), (1, 8, 1));
}

#[test]
fn refusals_say_what_is_wrong_and_what_would_be_right() {
    let mut e = engine();
    run(&mut e, "loadrt and2 count=3").unwrap();
    run(&mut e, "net x and2.0.out").unwrap();
    for (line, want) in [
        (
            "loadrt and2",
            "and2: already exists; for more instances, give them names: loadrt and2 names=a,b",
        ),
        (
            "net x and2.1.out",
            "Signal 'x' can not add OUT pin 'and2.1.out', it already has OUT pin 'and2.0.out'; a signal has one writer: \
             'unlinkp and2.0.out' before this line lets and2.1.out be it",
        ),
        (
            "net y and2.0.out",
            "Pin 'and2.0.out' was already linked to signal 'x'; 'unlinkp and2.0.out' frees it",
        ),
        (
            "net and2.0.in0 and2.1.in0",
            "Signal name 'and2.0.in0' must not be the same as a pin.  Did you omit the signal name?",
        ),
        ("net z and2.0.in9", "Pin 'and2.0.in9' does not exist; did you mean and2.0.in0?"),
        ("setp and2.0.out 1", "pin 'and2.0.out': not writable; it is an output of its component"),
        (
            "setp and2.0.in0 maybe",
            "pin 'and2.0.in0': invalid argument; expected TRUE or FALSE (or 1, 0, ON, OFF, YES, NO)",
        ),
        ("getp and2.0.inn", "parameter or pin 'and2.0.inn': not found; did you mean and2.0.in0?"),
        ("sets x 1", "signal 'x': not writable; an output writes it"),
        ("unloadrt or2", "component 'or2' is not loaded"),
    ] {
        let e = run(&mut e, line).unwrap_err();
        assert_eq!(e.to_string(), want, "{line}");
    }
}
