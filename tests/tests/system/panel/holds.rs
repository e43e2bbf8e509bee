//! Holds in a browser: the banner, the log and Resume, of machines with and without a task.

use super::{fixture::Fixture, operator::open, printer::Printer};
use hal_tests::{browser::DESKTOP, scratch::until};

/// Returns a condition on the text of the banner.
fn banner(text: &str) -> String {
    format!(
        "!document.querySelector('#hold-banner').hidden && \
         document.querySelector('#hold-text').textContent.includes('{text}')"
    )
}

const NONE: &str = "document.querySelector('#hold-banner').hidden";

/// Returns a condition on the log.
fn logged(text: &str) -> String {
    format!("document.querySelector('#messages').textContent.includes('{text}')")
}

#[test]
fn a_path_without_a_task_is_held_and_resumed_in_the_page() {
    let Some(fixture) = Fixture::with(DESKTOP, || Printer::without_task("rs03n")) else { return };
    let b = &fixture.browser;
    b.until("!document.querySelector('#no-task').hidden");
    fixture.ready();
    fixture.printer.halcmd("motion.move x=-500 velocity=3");
    b.until("!document.querySelector('#run-pause').disabled");
    b.click("#run-pause");
    b.until(&banner("Paused. Resume goes on."));
    b.until(&logged("Held: Paused."));
    let x = || fixture.printer.number("getp axis.x.pos-cmd");
    until("motion rests", || fixture.printer.number("getp motion.current-vel") == 0.0);
    fixture.picture("held-without-task");
    let rest = x();
    fixture.hold("#hold-resume", NONE);
    until("the path goes on", || x() < rest - 0.5);
    b.until(&logged("Nothing is held any more."));

    // An override of 0 holds it too, and the banner says how it goes on.
    b.run("const f = document.querySelector('#feed-override'); f.value = 0; f.dispatchEvent(new Event('input'))");
    b.until(&banner("The feed override is 0 %: raise it."));
    assert_eq!(b.run("return document.querySelector('#hold-resume').hidden"), true);
    b.run("const f = document.querySelector('#feed-override'); f.value = 100; f.dispatchEvent(new Event('input'))");
    b.until(NONE);

    // The stop that once was void here.
    b.click("#estop");
    b.until("document.querySelector('#machine-state').dataset.state === 'estop'");
    b.until(&logged("the machine is in e-stop"));
    assert_eq!(fixture.printer.halcmd("getp motion.motion-enabled").trim(), "FALSE");
    fixture.picture("estop-without-task");
    assert_eq!(b.errors(), Vec::<String>::new());
}

#[test]
fn a_job_is_held_by_a_program_a_door_and_a_lost_lease_and_says_so() {
    let Some(fixture) = Fixture::start(DESKTOP) else { return };
    let b = &fixture.browser;
    fixture.ready();
    open(&fixture, "held.ngc", "G21 G90\nG1 X2 F600\nM0\nG1 X60 F120\nM2\n");
    // The start says what becomes of the job, and shows it.
    b.until("document.querySelector('#on-loss').value === 'hold'");
    fixture.hold("#run-start", &banner("Resume goes on."));
    b.until("document.querySelector('#on-loss-state').textContent.endsWith('hold')");
    b.until(&logged("Held: "));
    fixture.picture("held-program");
    fixture.hold("#hold-resume", NONE);

    // The lease goes back: the job does what its start said.
    until("it moves", || fixture.printer.number("getp joint.0.pos-cmd") > 3.0);
    b.click("#lease");
    b.until(&banner("Control was lost. Resume goes on."));
    assert_eq!(b.run("return document.querySelector('#hold-resume').disabled"), true);
    until("motion rests", || fixture.printer.number("getp motion.current-vel") == 0.0);
    fixture.picture("held-lease");
    b.click("#lease");
    fixture.hold("#hold-resume", NONE);
    until("it goes on", || fixture.printer.number("getp motion.current-vel") > 0.0);
    b.click("#run-stop");
    until("the job is aborted", || {
        fixture.printer.halcmd("task.status").contains("jobs=1 failed=1")
    });
    assert_eq!(b.errors(), Vec::<String>::new());
}

#[test]
fn a_page_that_nobody_sees_keeps_its_job() {
    let Some(fixture) = Fixture::start(DESKTOP) else { return };
    let b = &fixture.browser;
    fixture.ready();
    open(&fixture, "long.ngc", "G21 G90\nG1 X60 F300\nM2\n");
    fixture.hold("#run-start", "!document.querySelector('#run-stop').disabled");
    // As behind a screen that is off: hidden, with its link.
    b.run(
        "Object.defineProperty(document, 'hidden', { value: true, configurable: true }); \
         document.dispatchEvent(new Event('visibilitychange'))",
    );
    let x = || fixture.printer.number("getp joint.0.pos-cmd");
    let beats = || fixture.printer.number("getp remote.beat");
    let first = beats();
    until("beats arrive for longer than the lease lasts without them", || beats() > first + 3000.0);
    assert_eq!(fixture.printer.halcmd("getp remote.hold").trim(), "FALSE");
    let before = x();
    until("the job goes on", || x() > before + 1.0);
    b.run("delete document.hidden");
    b.click("#run-stop");
}
