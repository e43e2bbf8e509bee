//! The picture of a program has the path that motion plans, and a simulation plays it.

use super::{fixture::Fixture, operator::open, stock::simulate};
use hal_tests::browser::DESKTOP;

/// A square whose corners are rounded by up to 2 mm, and a thread of short lines.
const SQUARE: &str = "\
G21 G90 G94 G54
T1 M6
G0 X20 Y20 Z5
G64 P2
G1 Z-1 F5000
X60
Y60
X20
Y20
G0 Z5
M2
";

#[test]
fn the_picture_has_the_planned_path_and_the_programmed_one() {
    let Some(fixture) = Fixture::start(DESKTOP) else { return };
    let b = &fixture.browser;
    fixture.ready();
    open(&fixture, "square.ngc", SQUARE);
    b.until("Number(document.querySelector('.view').dataset.planned) > 20");
    b.run("[...document.querySelectorAll('#view button')].find((n) => n.textContent === 'Top').click()");
    b.run("window.drawn = 0; document.querySelector('.view').addEventListener('complete', () => { window.drawn += 1; })");
    let picture = "document.querySelector('.view canvas').toDataURL()";
    let shown = |text: &str, name: &str| {
        b.run("window.drawn = 0; document.querySelector('#view-way').click()");
        b.until("window.drawn > 0");
        assert_eq!(b.text("#view-way"), text);
        fixture.picture(name);
        b.run(&format!("return {picture}")).as_str().unwrap().to_owned()
    };
    let programmed = shown("Path: programmed", "path-programmed");
    let planned = shown("Path: planned", "path-planned");
    assert!(programmed != planned, "both look the same");
    assert!(shown("Path: programmed", "path-programmed") == programmed);

    // The corners that are rounded leave stock, and the times differ by less than a tenth.
    let removed = || {
        simulate(&fixture, "max");
        b.run("return Number(document.querySelector('.view').dataset.removed)").as_f64().unwrap()
    };
    let sharp = removed();
    b.run("document.querySelector('#view-way').click()");
    let round = removed();
    assert!(sharp > 0.0 && (round / sharp - 1.0).abs() < 0.05, "{sharp} and {round} mm³");
    assert_ne!(round.to_bits(), sharp.to_bits(), "the planned path is not played");
    assert_eq!(b.errors(), Vec::<String>::new());
}
