//! Figures of the page: its first picture, and the path of a program of a million lines and its simulation while somebody works.

use super::fixture::Fixture;
use hal_tests::browser::DESKTOP;
use std::fmt::Write as _;

/// Lines of the long program.
const LINES: u32 = 1_000_000;

/// Returns a program of so many lines: waves over a square.
fn waves(lines: u32) -> String {
    let mut text = "G21 G90 G94 F3000\nG1 X0 Y0 Z0\n".to_owned();
    for n in 0..lines - 3 {
        let (row, column) = (f64::from(n / 1000), f64::from(n % 1000));
        let x = if (n / 1000).is_multiple_of(2) { column } else { 999.0 - column } * 0.1;
        let y = row * 0.1;
        writeln!(text, "X{x:.3} Y{y:.3} Z{:.3}", (x * 0.3).sin() + (y * 0.2).cos()).unwrap();
    }
    text.push_str("M2\n");
    text
}

#[test]
#[ignore = "a measurement, of 5 s on an idle computer: cargo test -p hal-tests --test system panel::figures -- --ignored --nocapture"]
fn a_path_of_a_million_lines() {
    let Some(fixture) = Fixture::start(DESKTOP) else { return };
    let b = &fixture.browser;
    let paint = b
        .run("return performance.getEntriesByName('first-contentful-paint')[0]?.startTime ?? null");
    println!("first picture after {paint} ms");
    fixture.ready();
    fixture.printer.scratch.write("programs/waves.ngc", waves(LINES));
    b.run("[...document.querySelectorAll('#programs button')].at(-1).click()");
    let file = "[...document.querySelectorAll('.files .plain')].find((f) => f.textContent === 'waves.ngc')";
    b.until(file);
    // An event waits for what the page does at that moment: it looks 50 times a second how long.
    b.run(
        "window.waits = [0]; let due = performance.now(); \
         const tick = () => { const now = performance.now(); window.waits.push(now - due); due = now + 20; setTimeout(tick, 20); }; \
         tick()",
    );
    b.run(&format!("{file}.click()"));
    b.until("Number(document.querySelector('.view').dataset.points) > 0");
    let complete = b.run("return document.querySelector('.view').dataset.complete");
    let points = b.run("return document.querySelector('.view').dataset.points");
    let longest = b.run("return Math.round(Math.max(...window.waits))");
    fixture.picture("million");
    println!(
        "{points} points are complete after {complete} ms; the longest wait of an input was {longest} ms"
    );
    b.run(
        "window.waits = [0]; window.begun = performance.now(); \
         document.querySelector('#sim-speed').value = 'max'; document.querySelector('#sim-start').click()",
    );
    b.until("document.querySelector('.view').dataset.simulation === 'done'");
    let took = b.run("return Math.round(performance.now() - window.begun)");
    let longest = b.run("return Math.round(Math.max(...window.waits))");
    fixture.picture("million-simulated");
    println!(
        "simulated as fast as possible in {took} ms; the longest wait of an input was {longest} ms: {}",
        b.text("#sim-figures")
    );
    let number = |value: &serde_json::Value| value.as_str().unwrap().parse::<u32>().unwrap();
    assert!(LINES - 10 < number(&points), "{points} points");
    assert_eq!(b.errors(), Vec::<String>::new());
}
