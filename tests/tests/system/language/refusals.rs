//! Refusals that no script produces.

use hal_engine::{ClockKind, Engine};
use hal_protocol::{Direction, Link, Request, Type};
use hal_tests::{
    machine::{Machine, Served, options, says},
    scratch::Scratch,
};

#[test]
fn an_instance_runs_once() {
    let scratch = Scratch::new("twice");
    let served = Served::on(ClockKind::Virtual, &scratch, "twice", "loadrt threads");
    let again = Engine::new(options(served.place.clone(), ClockKind::Virtual)).unwrap_err();
    assert_eq!(again.to_string(), "instance 'twice' is already running");
    served.end();
}

#[test]
fn a_program_needs_a_machine_with_a_task() {
    let scratch = Scratch::new("no-task");
    scratch.write("m.hal", "loadrt threads\n");
    scratch.write("m.ini", "[HAL]\nHALFILE = m.hal\n");
    scratch.write("p.ngc", "M2\n");
    let run = scratch.halrun(&["--virtual", "--run", "p.ngc", "m.ini"]);
    let says = "this machine has no task, which runs programs";
    assert!(run.stderr.contains(says), "{run:?}");
    assert_eq!(run.status, Some(1));
}

#[test]
fn a_ticket_that_was_never_given_is_unknown() {
    let mut m = Machine::new(ClockKind::Virtual);
    let none = m.call(Request::Ticket { id: 7, wait: true }).unwrap_err();
    assert_eq!(none.to_string(), "no command with ticket 7 is known");
}

#[test]
fn a_queue_has_one_reader_and_no_pin_of_both_ways() {
    let scratch = Scratch::new("ports");
    let served = Served::on(ClockKind::Virtual, &scratch, "ports", "loadrt threads");
    let mut client = served.client();
    client.call(Request::Join { name: "me".to_owned(), poll_ns: 0 }).unwrap();
    for (name, direction) in [
        ("me.out", Direction::Out),
        ("me.in-0", Direction::In),
        ("me.in-1", Direction::In),
        ("me.io", Direction::Io),
    ] {
        client.call(Request::NewPin { name: name.to_owned(), ty: Type::Port, direction }).unwrap();
    }
    client.call(Request::Ready).unwrap();
    for (line, want) in [
        ("net q me.out me.in-0", "ok"),
        ("net q me.in-1", "signal 'q' is a port and can only have one input pin"),
        ("linkps me.in-1 q", "signal 'q' is a port and can only have one input pin"),
        ("linkps me.io q", "signal 'q' already has output pin"),
        ("newsig p port", "ok"),
        ("linkps me.io p", "signal 'p' is a port and cannot have I/O pin(s)"),
        ("net p me.io", "signal 'p' is a port and cannot have I/O pin(s)"),
    ] {
        assert_eq!(says(&mut client, line), want, "{line}");
    }
    drop(client);
    served.end();
}
