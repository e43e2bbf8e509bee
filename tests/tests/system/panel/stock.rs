//! Stock in the picture: a program that is simulated while the machine stands, and stock that the machine carves.

use super::{fixture::Fixture, operator::open};
use core::f64::consts::PI;
use hal_tests::{
    browser::{DESKTOP, PHONE},
    programs::root,
};
use std::fs;

/// Two slots of T1, whose diameter is 5 mm, and a rapid move down into the stock between them.
const SLOTS: &str = "\
G21 G90 G94 G54
T1 M6
G0 X10 Y10 Z5
G1 Z-2 F300
X60
G0 Z5
G0 Y40
G1 Z-2
X10
G0 Z5
G0 X35 Y25
G0 Z-1
G0 Z5
G0 X0 Y0
M2
";
/// Volume of a slot whose middle line is 50 mm long.
const SLOT: f64 = 2.0 * (50.0 * 5.0 + PI * 2.5 * 2.5);

/// True when the picture has the path of the program, and can simulate it.
pub(super) const LOADED: &str = "Number(document.querySelector('.view').dataset.points) > 0 && !document.querySelector('#sim-start').disabled";

/// Returns a number that the picture has.
pub(super) fn number(fixture: &Fixture, name: &str) -> f64 {
    let value =
        fixture.browser.run(&format!("return document.querySelector('.view').dataset.{name}"));
    value.as_str().unwrap_or_else(|| panic!("{name} is {value}")).parse().unwrap()
}

/// States the size of the stock: its two ends.
pub(super) fn state_box(fixture: &Fixture, ends: [[i32; 3]; 2]) {
    for (side, end) in ends.iter().enumerate() {
        for (axis, value) in ["x", "y", "z"].into_iter().zip(end) {
            fixture.browser.run(&format!(
                "const input = document.querySelector('#stock-{axis}-{side}'); \
                 input.value = '{value}'; input.dispatchEvent(new Event('change'))"
            ));
        }
    }
}

/// Begins to remember the commands that the page sends.
fn listen(fixture: &Fixture) {
    fixture.browser.run(
        "const send = WebSocket.prototype.send; window.commands = []; \
         WebSocket.prototype.send = function (text) { \
             const m = JSON.parse(text); if (m.type === 'command') window.commands.push(m.name); send.call(this, text) }",
    );
}

/// Presses Simulate, and waits for the end.
pub(super) fn simulate(fixture: &Fixture, speed: &str) {
    let b = &fixture.browser;
    b.run(&format!("document.querySelector('#sim-speed').value = '{speed}'"));
    b.run("document.querySelector('#sim-start').click()");
    b.until("document.querySelector('.view').dataset.simulation === 'done'");
}

#[test]
fn a_program_is_simulated_while_the_machine_stands() {
    let Some(fixture) = Fixture::start(DESKTOP) else { return };
    let b = &fixture.browser;
    fixture.ready();
    open(&fixture, "slots.ngc", SLOTS);
    b.until(LOADED);
    let joints = || [0, 1, 2].map(|n| fixture.printer.number(&format!("getp joint.{n}.pos-cmd")));
    let before = joints();
    listen(&fixture);

    // While it plays, the picture says what it is; a pause keeps it.
    b.run("document.querySelector('#sim-speed').value = '1'");
    b.run("document.querySelector('#sim-start').click()");
    b.until("Number(document.querySelector('.view').dataset.removed) > 100");
    assert_eq!(b.run("return document.querySelector('.view').dataset.simulation"), "playing");
    b.run("document.querySelector('#sim-pause').click()");
    b.until("document.querySelector('.view').dataset.simulation === 'paused'");
    let banner = "document.querySelector('.view .simulated')";
    assert_eq!(b.run(&format!("return {banner}.checkVisibility()")), true);
    assert!(b.text(".view .simulated").contains("does not move"), "{}", b.text(".view .simulated"));
    let at = number(&fixture, "removed");
    fixture.picture("stock-playing");
    for view in ["Top", "Front"] {
        b.run(&format!("[...document.querySelectorAll('#view button')].find((n) => n.textContent === '{view}').click()"));
    }
    assert_eq!(number(&fixture, "removed").to_bits(), at.to_bits(), "a look removes nothing");
    b.run("document.querySelector('#sim-speed').value = '100'");
    b.run("document.querySelector('#sim-pause').click()");
    b.until("document.querySelector('.view').dataset.simulation === 'done'");

    // The slots have their volume within half a cell along their edges, and the rapid move is reported.
    let cell = (69.0_f64 * 39.0 / 40_000.0).sqrt() * 1.05;
    let plunge = PI * 2.5 * 2.5;
    let edges = 2.0 * 2.0 * (100.0 + PI * 5.0) + PI * 5.0;
    let removed = number(&fixture, "removed");
    let wanted = 2.0 * SLOT + plunge;
    assert!((removed - wanted).abs() < edges * cell, "{removed} instead of {wanted} mm³");
    assert_eq!(number(&fixture, "rapids").to_bits(), 1.0_f64.to_bits());
    assert!(b.text("#sim-warning").contains("1 rapid move"), "{}", b.text("#sim-warning"));
    assert_eq!(b.run(&format!("return {banner}.checkVisibility()")), true, "the stock is not real");

    // As often as wanted, with the same result.
    for speed in ["max", "100"] {
        simulate(&fixture, speed);
        assert!((number(&fixture, "removed") - removed).abs() < 0.01 * removed, "{speed}");
        assert_eq!(number(&fixture, "rapids").to_bits(), 1.0_f64.to_bits());
    }
    fixture.picture("stock-done");
    b.run("document.querySelector('#sim-end').click()");
    assert_eq!(
        b.run("return document.querySelector('.view').dataset.simulation ?? null"),
        serde_json::Value::Null
    );
    assert_eq!(b.run(&format!("return {banner}.checkVisibility()")), false);

    assert_eq!(b.run("return window.commands"), serde_json::json!([]), "commands");
    assert_eq!(joints().map(f64::to_bits), before.map(f64::to_bits), "the machine has moved");

    // The machine moves: the simulation ends by itself, and the picture is that of the machine.
    b.run("document.querySelector('#sim-speed').value = '1'");
    b.run("document.querySelector('#sim-start').click()");
    b.until("document.querySelector('.view').dataset.simulation === 'playing'");
    fixture.jog(".jog-X-plus", 0, 1.0);
    b.until("document.querySelector('.view').dataset.simulation === undefined");
    fixture.end_jog(".jog-X-plus");
    fixture.rests();
    assert_eq!(b.errors(), Vec::<String>::new());
}

#[test]
fn the_pedal_is_simulated_on_each_screen() {
    let pedal = fs::read_to_string(root().join("configs/printer/pedal.ngc")).unwrap();
    for (screen, width) in [(DESKTOP, "desktop"), (PHONE, "phone")] {
        let Some(fixture) = Fixture::start(screen) else { return };
        let b = &fixture.browser;
        fixture.ready();
        b.run("document.querySelector('nav [data-group=job]').click()");
        open(&fixture, "pedal.ngc", &pedal);
        b.run("document.querySelector('nav [data-group=view]').click()");
        b.until(LOADED);
        simulate(&fixture, "max");
        // T1 is flat, T2 is a ball: what the table remarks. Rows 5 mm apart over 30 mm, in two slices of 3 mm, and more.
        let removed = number(&fixture, "removed");
        assert!((6.0 * 35.0 * 25.0..40.0 * 35.0 * 8.0).contains(&removed), "{removed} mm³");
        assert_eq!(number(&fixture, "rapids").to_bits(), 0.0_f64.to_bits());
        let too_wide =
            "return document.documentElement.scrollWidth - document.documentElement.clientWidth";
        b.run("document.querySelector('#stock-more').open = true");
        assert_eq!(b.run(too_wide), 0, "{width}: the page is wider than the screen");
        b.run("document.querySelector('#view').scrollIntoView()");
        fixture.picture(&format!("stock-pedal-{width}"));
        assert_eq!(b.errors(), Vec::<String>::new());
    }
}

#[test]
fn the_machine_carves_while_it_cuts() {
    let Some(fixture) = Fixture::start(DESKTOP) else { return };
    let b = &fixture.browser;
    fixture.ready();
    // It dwells at the ends, so that reports have them. No tool is in the spindle: the stated diameter of 6 mm counts.
    open(
        &fixture,
        "slot.ngc",
        "G21 G90\nG0 X10 Y10 Z5\nG1 Z-2 F300\nG4 P1\nX40 F600\nG4 P1\nG0 Z5\nM2\n",
    );
    b.until(LOADED);
    b.run("document.querySelector('#stock-live').click()");
    b.until("document.querySelector('.view').dataset.removed === '0'");
    fixture.hold("#run-start", "!document.querySelector('#run-stop').disabled");
    fixture.printer.job_ends();
    let wanted = 2.0 * (30.0 * 6.0 + PI * 9.0);
    b.until("!document.querySelector('#sim-start').disabled");
    let removed = number(&fixture, "removed");
    // Between two reports the way is taken to be straight; along the edges cells count whole.
    assert!((removed - wanted).abs() < 0.08 * wanted, "{removed} instead of {wanted} mm³");
    // A simulation has stock of its own, and leaves that of the machine.
    simulate(&fixture, "max");
    b.run("document.querySelector('#sim-end').click()");
    assert_eq!(number(&fixture, "removed").to_bits(), removed.to_bits());
    fixture.picture("stock-live");
    assert_eq!(b.errors(), Vec::<String>::new());
}
