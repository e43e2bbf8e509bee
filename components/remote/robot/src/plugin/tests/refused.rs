//! Refusals, and reports of an end.

use super::{
    super::{cause::Cause, report::Report, session::Session},
    MS, Rig,
};
use crate::{Command, Volume};
use hal_component::abi::TicketState;

#[test]
fn a_refusal_after_a_failed_connection_is_logged() {
    let rig = Rig::new(&[]);
    rig.0.set("robot.sim.cut", true);
    rig.pass(4);
    let why = "the simulated link is down";
    assert_eq!(rig.refused("robot.connect", &[]), why);
    assert_eq!(rig.error(), 7);
    let said = rig.0.said();
    assert_eq!(said.iter().filter(|text| text.contains(why)).count(), 1, "{said:?}");
    for (name, why) in [
        ("robot.run", "there is no program: robot.load first"),
        ("robot.pause", "no run is in progress"),
    ] {
        assert_eq!(rig.refused(name, &[]), why);
        let said = rig.0.said();
        assert!(said.iter().any(|text| text.contains(why)), "{said:?}");
    }
}

#[test]
fn a_command_that_does_not_fit_a_run_is_refused() {
    let rig = Rig::running();
    for (name, args, why) in [
        ("robot.connect", &[][..], "the controller is connected already"),
        ("robot.disconnect", &[], "a run is in progress: robot.stop ends it"),
        ("robot.load", &["file=nowhere.nc"], "a run is in progress"),
        ("robot.run", &[], "a run is in progress"),
    ] {
        assert_eq!(rig.refused(name, args), why);
    }
    rig.0.command("robot.pause", &[]).unwrap();
    rig.0.command("robot.pause", &[]).unwrap();
    rig.pass(10);
    let before = rig.0.tickets().into_iter().rev().nth(1);
    let why = "another command of this kind has followed";
    assert_eq!(
        (before, rig.0.ticket()),
        (Some(TicketState::Failed(why)), Some(TicketState::Pending))
    );
    rig.pass(6000);
    assert_eq!(
        (rig.0.ticket(), rig.shown().as_str()),
        (Some(TicketState::Done), "busy connected paused")
    );
}

#[test]
fn many_commands_at_once_are_refused_but_for_the_stop() {
    let rig = Rig::connected();
    let mut refused = 0;
    for _ in 0..40 {
        if let Err(why) = rig.0.command("robot.pause", &[]) {
            assert_eq!(why, "too many commands wait for the worker of robot");
            refused += 1;
        }
    }
    assert_eq!(refused, 24);
    rig.0.command("robot.stop", &[]).unwrap();
    rig.pass(4);
    assert_eq!((rig.error(), rig.0.get::<bool>("robot.connected")), (1, false));
}

#[test]
fn an_order_that_has_waited_long_moves_nothing() {
    for (order, is_stale) in [("robot.run", true), ("robot.pause", false)] {
        let rig = Rig::connected();
        rig.load("G0 Z10\nG0 X50\n");
        rig.0.command(order, &[]).unwrap();
        // Without the function's cycles this is no dead worker.
        rig.0.pass(1001 * MS);
        rig.pass(10);
        let why = rig.0.failure().unwrap();
        assert_eq!(why.starts_with("the order has waited too long"), is_stale, "{order}: {why}");
        assert!(!rig.0.get::<bool>("robot.busy"));
    }
}

#[test]
fn a_connection_that_a_command_ends_is_named() {
    let rig = Rig::new(&[]);
    rig.0.command("robot.connect", &[]).unwrap();
    rig.pass(10);
    rig.0.command("robot.disconnect", &[]).unwrap();
    rig.pass(10);
    let why = "robot.disconnect has ended the connection";
    assert_eq!(rig.0.tickets(), [TicketState::Failed(why), TicketState::Done]);
    assert_eq!((rig.error(), rig.shown().as_str()), (0, ""));
}

/// Returns a session without a link, whose driver has begun a run, and has sent its first line.
fn driven() -> Session {
    let mut session = Session::new(&Volume::default(), 20.0, None);
    session.driver.connected(0.0);
    session.driver.receive(b"-400 0 -30\r\nEsperando inicio\r\n", 0.0);
    assert!(session.driver.run(vec![Command::Rapid([5.0, 0.0, 10.0])], 0, 0.0));
    assert_eq!(session.driver.output(), b"inicio\r\n");
    session
}

/// Returns the last line of `robot.status`.
fn told(session: &Session) -> String {
    let mut report = Report::default();
    session.report(&mut report);
    report.lines().pop().unwrap()
}

#[test]
fn an_end_by_the_controller_has_its_number_and_its_text() {
    for (answer, number, text) in [
        ("error unknown\r\n", 5, "the controller does not know line 0"),
        ("error format\r\nerror unknown\r\n", 5, "the controller finds wrong numbers in line 0"),
        ("error range\r\n", 5, "the controller finds line 0 outside its range"),
        ("error busy\r\n", 6, "another client is connected to the controller"),
    ] {
        let mut session = driven();
        session.driver.receive(answer.as_bytes(), 0.0);
        assert_eq!(told(&session), format!("problem: {text}"));
        assert_eq!(session.results().error, number, "{text}");
    }
}

#[test]
fn the_reason_of_an_end_precedes_text_that_is_no_answer() {
    let mut session = driven();
    session.driver.receive(b"booting\r\n", 0.0);
    session.flush(false, 0.0);
    let noise = "the controller has sent text that is no answer";
    assert_eq!(told(&session), format!("problem: {noise}"));
    session.stop(Cause::Command, 0.0);
    assert_eq!(told(&session), format!("problem: stopped at line 0; {noise}"));
}

#[test]
fn the_end_of_the_instance_is_no_lost_connection() {
    let mut session = driven();
    session.driver.disconnected();
    assert_eq!(session.cause(), Some(Cause::Lost));
    session.end_with_instance(0.0);
    assert_eq!(session.cause(), Some(Cause::Instance));
    let mut session = Session::new(&Volume::default(), 20.0, None);
    session.end_with_instance(0.0);
    assert_eq!(session.cause(), None, "nothing has ended");
}
