//! A robot arm in the panel: a cutter-location file that is shown, played and carved, and stock that the arm itself carves.

use super::{
    fixture::Fixture,
    printer::Printer,
    stock::{LOADED, number},
};
use hal_tests::{browser::DESKTOP, scratch::until};

/// Speed of the machine's clock: the plate is cut in seconds, and reports are close together.
const PACE: &str = "4";

#[test]
fn an_arm_cuts_a_plate_as_its_simulation_does() {
    let start = || Printer::of_script("rx90", PACE, &["--programs", ".", "--cell", "cell.conf"]);
    let Some(fixture) = Fixture::with(DESKTOP, start) else { return };
    let (b, halcmd) = (&fixture.browser, |line: &str| fixture.printer.halcmd(line));
    b.until("[...document.querySelectorAll('.files .plain')].some((f) => f.textContent === 'plate.apt')");
    b.run("[...document.querySelectorAll('.files .plain')].find((f) => f.textContent === 'plate.apt').click()");
    b.until(LOADED);
    assert!(b.text("#programs").contains("GODLTA"), "the text of the file");
    // The stock is 3 mm higher than the touched corners.
    for (name, value) in [("x-0", 0), ("y-0", 0), ("z-0", -10), ("x-1", 216), ("y-1", 102), ("z-1", 3)] {
        b.run(&format!(
            "const input = document.querySelector('#stock-{name}'); input.value = '{value}'; \
             input.dispatchEvent(new Event('change'))"
        ));
    }

    // While it plays, the arm is where the tool is.
    b.run("document.querySelector('#sim-speed').value = '10'");
    b.run("document.querySelector('#sim-start').click()");
    b.until("Number(document.querySelector('.view').dataset.removed) > 4000");
    b.run("document.querySelector('#sim-pause').click()");
    b.until("document.querySelector('.view').dataset.simulation === 'paused'");
    let joints = b.run("return document.querySelector('.view').dataset.joints");
    let joints: Vec<f64> =
        joints.as_str().unwrap().split(' ').map(|word| word.parse().unwrap()).collect();
    fixture.picture("arm-playing");
    // It points down still: joints 1, 2 and 4 add up, and joint 3 stays.
    assert!((joints[1] + joints[2] + joints[4] - 180.0).abs() < 0.5, "{joints:?}");
    assert!(joints[3].abs() < 0.1 && joints[0].abs() < 20.0, "{joints:?}");
    b.run("document.querySelector('#sim-speed').value = 'max'");
    b.run("document.querySelector('#sim-pause').click()");
    b.until("document.querySelector('.view').dataset.simulation === 'done'");
    let simulated = number(&fixture, "removed");
    println!("{simulated} mm³ in {}", b.text("#sim-figures"));
    assert!(b.text("#sim-figures").contains("⌀ 8"), "{}", b.text("#sim-figures"));
    fixture.picture("arm-simulated");
    b.run("document.querySelector('#sim-end').click()");

    // The machine itself: its joints tell where the tool is and points, whatever X Y Z are.
    halcmd("iocontrol.estop-reset --wait");
    halcmd("motion.enable --wait");
    halcmd("motion.home joint=all --wait");
    b.run("document.querySelector('#stock-live').click()");
    b.until("document.querySelector('.view').dataset.removed === '0'");
    halcmd("setp motion.switchkins-type 1");
    until("joints are axes", || halcmd("getp kinstype.is-1").trim() == "TRUE");
    halcmd("source plate.moves");
    fixture.rests();
    b.until("Number(document.querySelector('.view').dataset.removed) > 4000");
    let at_end = || number(&fixture, "removed");
    let mut removed = at_end();
    until("the last report is drawn", || {
        let before = core::mem::replace(&mut removed, at_end());
        before.to_bits() == removed.to_bits()
    });
    fixture.picture("arm-cut");
    println!("{removed} mm³ by reports, {simulated} mm³ by the simulation");
    assert!((removed - simulated).abs() < 0.1 * simulated, "{removed} and {simulated} mm³");
    assert_eq!(b.errors(), Vec::<String>::new());
}

#[test]
fn a_cell_that_is_not_the_machine_is_named() {
    let start = || Printer::of_script("rx90", "1", &["--programs", ".", "--cell", "cell.conf"]);
    let Some(fixture) = Fixture::with(DESKTOP, start) else { return };
    let b = &fixture.browser;
    fixture.printer.halcmd("setp armkins.tool.z 200");
    b.run("location.reload()");
    b.until("[...document.querySelectorAll('.files .plain')].some((f) => f.textContent === 'plate.apt')");
    b.run("[...document.querySelectorAll('.files .plain')].find((f) => f.textContent === 'plate.apt').click()");
    b.until(LOADED);
    b.run("document.querySelector('#sim-start').click()");
    b.until("document.querySelector('.view').dataset.simulation === 'playing'");
    let text = b.text("#sim-figures");
    assert!(text.contains("is not that of the machine, 75.0"), "{text}");
    assert_eq!(b.errors(), Vec::<String>::new());
}
