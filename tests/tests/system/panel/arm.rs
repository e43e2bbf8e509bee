//! A robot arm in the panel: a cutter-location file that is shown, played and carved, and stock that the arm itself carves.

use super::{
    fixture::Fixture,
    operator::choose,
    printer::Printer,
    stock::{LOADED, number, state_box},
};
use hal_tests::{browser::DESKTOP, programs::root, scratch::until};

/// The part, and the options that tell its cell.
const PART: &[&str] = &["plate.apt"];
const CELL: &[&str] = &["--cell", "cell.conf"];

/// Switches the arm on and homes it; then its axes are its joints.
const READY: &str = "\
iocontrol.estop-reset --wait
motion.enable --wait
motion.home joint=all --wait
setp motion.switchkins-type 1
";

/// Runs a script of halcmd while machine time passes in these steps.
fn run(fixture: &Fixture, script: &str, step: &str) {
    let scratch = &fixture.printer.scratch;
    scratch.write("run.hal", script);
    let mut running = scratch.start(scratch.command(&[], "halcmd").args(["-f", "run.hal"]));
    while running.is_running() {
        fixture.printer.halcmd(&format!("run {step}"));
    }
    assert!(running.ended().is_some_and(|status| status.success()), "{:?}", running.said());
    fixture.printer.halcmd("run 1s");
}

#[test]
fn an_arm_cuts_a_plate_as_its_simulation_does() {
    let start = || Printer::of_script("rx90", PART, CELL);
    let Some(fixture) = Fixture::with(DESKTOP, start) else { return };
    let b = &fixture.browser;
    choose(&fixture, "plate.apt");
    b.until(LOADED);
    b.until("document.querySelector('#programs').textContent.includes('TLAXIS')");
    // The stock is 3 mm higher than the touched corners.
    state_box(&fixture, [[0, 0, -10], [216, 102, 3]]);

    // While it plays, the arm is where the tool is.
    // The page itself pauses: a busy computer would be late.
    b.run("document.querySelector('#sim-speed').value = '10'");
    b.run(
        "const view = document.querySelector('.view'); \
         const seen = new MutationObserver(() => { \
             if (!(Number(view.dataset.removed) > 4000)) return; \
             seen.disconnect(); document.querySelector('#sim-pause').click() }); \
         seen.observe(view, { attributes: true, attributeFilter: ['data-removed'] }); \
         document.querySelector('#sim-start').click()",
    );
    b.until("document.querySelector('.view').dataset.simulation === 'paused'");
    let joints = b.run("return document.querySelector('.view').dataset.joints");
    let joints: Vec<f64> =
        joints.as_str().unwrap().split(' ').map(|word| word.parse().unwrap()).collect();
    for button in ["Machine", "+", "+", "+", "+"] {
        b.run(&format!("[...document.querySelectorAll('#view button')].find((n) => n.textContent === '{button}').click()"));
    }
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
    run(&fixture, READY, "1s");
    b.run("document.querySelector('#stock-live').click()");
    b.until("document.querySelector('.view').dataset.removed === '0'");
    // Between two reports lies no more than 1 mm, however busy the computer is: each step waits for the report of its end.
    let reported = || {
        let time = b.run("return Number(document.querySelector('.view').dataset.reported ?? 0)");
        time.as_f64().unwrap() * 1e-6
    };
    let all_reported = || {
        let pulse = fixture.printer.number("getp remote.pulse");
        until("the report of the end of the step", || reported() >= pulse - 2.0);
    };
    // A move that waits would itself let the time pass, and no step would bound it.
    let moves = std::fs::read_to_string(root().join("configs/rx90/plate.moves")).unwrap();
    fixture.printer.scratch.write("cut.moves", moves.replace(" --wait", ""));
    fixture.printer.halcmd("source cut.moves");
    let mut is_moving = true;
    while is_moving {
        fixture.printer.halcmd("run 50ms");
        all_reported();
        is_moving = fixture.printer.halcmd("getp motion.in-position").trim() != "TRUE";
    }
    let removed = number(&fixture, "removed");
    fixture.picture("arm-cut");
    println!("{removed} mm³ by reports, {simulated} mm³ by the simulation");
    assert!((removed - simulated).abs() < 0.02 * simulated, "{removed} and {simulated} mm³");
    assert_eq!(b.errors(), Vec::<String>::new());
}

#[test]
fn a_cell_that_is_not_the_machine_is_named() {
    let start = || Printer::of_script("rx90", PART, CELL);
    let Some(fixture) = Fixture::with(DESKTOP, start) else { return };
    let b = &fixture.browser;
    fixture.printer.halcmd("setp armkins.tool.z 200");
    b.run("location.reload()");
    choose(&fixture, "plate.apt");
    b.until(LOADED);
    b.run("document.querySelector('#sim-start').click()");
    b.until("document.querySelector('.view').dataset.simulation === 'playing'");
    let text = b.text("#sim-figures");
    assert!(text.contains("is not that of the machine, 75.0"), "{text}");
    assert_eq!(b.errors(), Vec::<String>::new());
}
