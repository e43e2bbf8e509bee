//! The page of a robot behind its own controller: the arm, the run and its stops, the lease.

use super::{
    fixture::Fixture,
    printer::{LASTING, Printer},
};
use hal_tests::{
    browser::{DESKTOP, PHONE},
    scratch::until,
    web::Socket,
};
use serde_json::{Value, json};

/// Returns a condition on the state that the page shows.
fn is(state: &str) -> String {
    format!("document.querySelector('#robot-state').dataset.state === '{state}'")
}

/// Waits until the page shows a state.
///
/// # Panics
/// The robot stops, and the page shows why.
fn becomes(fixture: &Fixture, state: &str) {
    fixture.browser.until(&format!(
        "{} || (() => {{ if ({}) throw Error(document.querySelector('#robot-why').textContent) }})()",
        is(state),
        is("stopped"),
    ));
}

/// Chooses a program and loads it.
fn load(fixture: &Fixture, name: &str) {
    let b = &fixture.browser;
    b.until("document.querySelectorAll('#robot-file option').length > 2");
    b.run(&format!("document.querySelector('#robot-file').value = '{name}'"));
    b.until("!document.querySelector('#robot-load').disabled");
    b.click("#robot-load");
}

fn stands(fixture: &Fixture) {
    until("the robot stands", || fixture.printer.halcmd("getp robot.sim.moving").trim() == "FALSE");
}

/// Checks that all numbers lie within their card.
fn fits(fixture: &Fixture) {
    let right = |of: &str| format!("document.querySelector('{of}').getBoundingClientRect().right");
    let look = format!("return {} <= {}", right("#robot table"), right("#robot"));
    assert_eq!(fixture.browser.run(&look), true, "numbers lie beside their card");
}

#[test]
fn the_lease_reaches_a_robot_without_motion() {
    let printer = Printer::robot("integrator", "");
    for (pins, signal) in [
        (["remote.hold", "robot.hold"], "remote-hold"),
        (["remote.abort", "robot.stop"], "remote-abort"),
        (["robot.busy", "remote.job"], "remote-job"),
    ] {
        for pin in pins {
            let shown = printer.halcmd(&format!("show pin {pin}"));
            let is_linked = shown.lines().any(|line| line.contains(pin) && line.contains(signal));
            assert!(is_linked, "{shown}");
        }
    }
    let functs = printer.halcmd("show thread");
    let at = |name: &str| functs.lines().position(|line| line.trim_end().ends_with(name)).unwrap();
    assert!(at(" remote") < at(" robot"), "{functs}");
}

/// Sends a message that must not be refused; returns its reply.
fn sent(socket: &mut Socket, message: Value) -> Value {
    let text = message.to_string();
    let reply = socket.ask(message);
    assert!(reply["ok"].is_object(), "{text}: {reply}");
    reply
}

fn lease(socket: &mut Socket, what: &str) {
    sent(socket, json!({ "type": "lease", "do": what }));
}

/// Executes a command of the robot; to its end, unless that is the end of a connection, a run or a move.
fn robot(socket: &mut Socket, what: &str) {
    let args = if what == "load" { json!({ "program": "part.nc" }) } else { json!({}) };
    let name = format!("robot-{what}");
    let reply = sent(socket, json!({ "type": "command", "name": name, "args": args }));
    if !["connect", "run", "pause"].contains(&what) {
        assert_eq!(reply["pending"], true, "{name}: {reply}");
        let done = socket.wait(|m| m["type"] == "done" && m["id"] == reply["id"]).unwrap();
        assert!(done["ok"].is_object(), "{name}: {done}");
    }
}

/// Waits until a pin has a value, and answers the panel's pulses meanwhile.
fn shows(socket: &mut Socket, pin: &str, value: bool) {
    socket.send(&json!({ "type": "watch", "names": [pin] }));
    let has = |m: &Value| m["values"][pin]["bit"] == value;
    assert!(socket.wait(has).is_some(), "{pin} does not become {value}");
}

/// Gives the lease up while the robot is busy, which holds it.
fn lose_lease(socket: &mut Socket) {
    lease(socket, "give");
    shows(socket, "robot.hold", true);
}

#[test]
fn a_lost_lease_holds_a_connection_and_one_resume_ends_a_hold_and_a_pause() {
    let printer = Printer::robot("operator", LASTING);
    printer.halcmd("iocontrol.estop-reset --wait");
    let mut socket = printer.sign_in().socket();
    let socket = &mut socket;
    // The greeting is late, so that the connection is not ready before the lease is lost.
    printer.halcmd("setp robot.sim.delay 3600");
    lease(socket, "take");
    robot(socket, "connect");
    shows(socket, "robot.connecting", true);
    lose_lease(socket);
    robot(socket, "stop");
    shows(socket, "robot.hold", false);

    printer.halcmd("setp robot.sim.delay 0");
    lease(socket, "take");
    robot(socket, "connect");
    shows(socket, "robot.ready", true);
    robot(socket, "load");
    robot(socket, "run");
    robot(socket, "pause");
    shows(socket, "robot.paused", true);
    lose_lease(socket);
    lease(socket, "take");
    robot(socket, "resume");
    shows(socket, "robot.running", true);
    assert_eq!(printer.halcmd("getp robot.hold").trim(), "FALSE");
    robot(socket, "stop");
    shows(socket, "robot.stopped", true);
}

#[test]
fn a_program_is_checked_run_paused_and_stopped() {
    let Some(fixture) = Fixture::robot(DESKTOP) else { return };
    let b = &fixture.browser;
    becomes(&fixture, "closed");
    assert_eq!(b.text("#robot-why"), "The e-stop chain is open");
    b.click("#lease");
    b.until("document.querySelector('#lease').getAttribute('aria-pressed') === 'true'");
    b.until("document.querySelector('#robot-connect').disabled");
    fixture.printer.halcmd("iocontrol.estop-reset --wait");
    fixture.hold("#robot-connect", &format!("!({})", is("closed")));
    becomes(&fixture, "ready");
    assert_eq!(b.text("#robot-zero"), "-400.000  0.000  -30.000");

    // A point outside is named, and nothing can be run.
    load(&fixture, "outside.nc");
    b.until("document.querySelector('#messages').textContent.includes('outside.nc: line 3: X')");
    assert!(b.text("#messages").contains("is outside the work volume: robot X -55"));
    assert_eq!(b.run("return document.querySelector('#robot-run').disabled"), true);
    load(&fixture, "line.nc");
    b.until("document.querySelector('#robot-line').textContent === '0 / 6'");

    fixture.hold("#robot-run", &is("running"));
    b.until("document.querySelector('#robot-point').textContent.startsWith('20.000')");
    // The view has the point in the part's coordinates, and the arm of the joints.
    b.until("document.querySelector('.view').title.startsWith('X 20.000  Y 0.000')");
    b.click("#robot-pause");
    becomes(&fixture, "paused");
    stands(&fixture);
    let line = b.text("#robot-line");
    fits(&fixture);
    // For the picture: nearer, and without messages that name a folder of this test.
    b.run(
        "document.querySelectorAll('#view .tabs button')[4].click(); \
         document.querySelectorAll('#view .tabs button')[4].click(); \
         document.querySelectorAll('.toasts > *, #messages li').forEach((node) => node.remove())",
    );
    fixture.picture("robot");
    fixture.hold("#robot-resume", &is("running"));
    b.until(&format!("document.querySelector('#robot-line').textContent !== '{line}'"));

    // The control is given back: the run is held behind the move under way, and goes on by a person alone.
    b.click("#lease");
    b.until("document.querySelector('#robot-why').textContent.startsWith('Held')");
    becomes(&fixture, "paused");
    stands(&fixture);
    assert_eq!(b.run("return document.querySelector('#robot-resume').disabled"), true);
    b.click("#lease");
    fixture.hold("#robot-resume", &is("running"));

    // The button of the e-stop opens the chain, and ends the move and the connection.
    b.click("#estop");
    becomes(&fixture, "stopped");
    stands(&fixture);
    assert_eq!(fixture.printer.halcmd("getp robot.connected").trim(), "FALSE");
    assert_eq!(fixture.printer.halcmd("getp robot.enable").trim(), "FALSE");
    b.until("document.querySelector('#messages').textContent.includes('the machine is in e-stop; the robot stops')");
    assert_eq!(b.run("return document.querySelector('#robot-connect').disabled"), true);
    fixture.hold("#estop-reset", "document.querySelector('#robot-connect').disabled === false");

    // And the rest of the program, to its end.
    fixture.hold("#robot-connect", &format!("!({})", is("stopped")));
    becomes(&fixture, "ready");
    fixture.hold("#robot-again", &is("running"));
    becomes(&fixture, "ended");
    assert_eq!(b.text("#robot-line"), "6 / 6");
    assert_eq!(b.text("#robot-point"), "0.000  20.000  10.000");
    b.run("localStorage.setItem('ferrule-panel', JSON.stringify({ language: 'es', theme: 'light', page: 'operate' })); location.reload()");
    b.until("document.querySelector('#robot-state')?.textContent === 'Terminado'");
    fixture.picture("robot-es-light");
    assert_eq!(b.errors(), Vec::<String>::new());
}

#[test]
fn the_chain_of_the_e_stop_stops_a_robot_and_a_phone_shows_it() {
    let Some(fixture) = Fixture::robot(PHONE) else { return };
    let b = &fixture.browser;
    fixture.printer.halcmd("iocontrol.estop-reset --wait");
    b.click("#lease");
    fixture.hold("#robot-connect", &format!("!({})", is("closed")));
    becomes(&fixture, "connected");
    fixture.printer.halcmd("iocontrol.estop");
    becomes(&fixture, "stopped");
    stands(&fixture);
    assert_eq!(b.text("#robot-why"), "The e-stop chain is open");
    assert_eq!(b.run("return document.querySelector('#robot-connect').disabled"), true);
    let width = b.run("return document.documentElement.scrollWidth <= innerWidth");
    assert_eq!(width, true, "nothing lies beside the screen");
    fits(&fixture);
    fixture.picture("robot-phone");
    assert_eq!(b.errors(), Vec::<String>::new());
}
