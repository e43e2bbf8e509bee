//! Stock of machines whose rotary axes tilt the tool or the table: carved where the kinematics tell the direction, named where not.

use super::{
    fixture::Fixture,
    operator::open,
    printer::Printer,
    stock::{LOADED, number, simulate, state_box},
};
use core::f64::consts::PI;
use hal_tests::browser::DESKTOP;

const HAL: &str = "\
loadrt KINEMATICS
loadrt motmod servo_period_nsec=1000000 num_joints=[KINS]JOINTS
addf motion-command-handler servo-thread
addf motion-controller servo-thread
net x joint.0.motor-pos-cmd => joint.0.motor-pos-fb
net y joint.1.motor-pos-cmd => joint.1.motor-pos-fb
net z joint.2.motor-pos-cmd => joint.2.motor-pos-fb
net a joint.3.motor-pos-cmd => joint.3.motor-pos-fb
net c joint.4.motor-pos-cmd => joint.4.motor-pos-fb
net estop-loop iocontrol.0.user-enable-out => iocontrol.0.emc-enable-in
";

/// Returns a machine of five axes, A and C beside X Y Z, with these lines after its script.
fn machine(kinematics: &str, lines: &str) -> Printer {
    let mut ini = format!(
        "[EMCMOT]\nSERVO_PERIOD = 1000000\n[TASK]\nCYCLE_TIME = 0.010\n[HAL]\nHALFILE = machine.hal\n[KINS]\nJOINTS = 5\n\
         KINEMATICS = {kinematics}\n[TRAJ]\nCOORDINATES = X Y Z A C\nLINEAR_UNITS = mm\n\
         MAX_LINEAR_VELOCITY = 100\n[REMOTE]\nLEASE_TIMEOUT = 60\n"
    );
    for (joint, letter) in ["X", "Y", "Z", "A", "C"].into_iter().enumerate() {
        let kind = if joint < 3 { "LINEAR" } else { "ANGULAR" };
        let limits =
            "MIN_LIMIT = -400\nMAX_LIMIT = 400\nMAX_VELOCITY = 100\nMAX_ACCELERATION = 800\n";
        ini += &format!(
            "[AXIS_{letter}]\n{limits}[JOINT_{joint}]\nTYPE = {kind}\n{limits}FERROR = 1000\n\
             MIN_FERROR = 1000\nHOME = 0\n"
        );
    }
    let hal = HAL.replace("KINEMATICS", kinematics) + lines;
    Printer::made(&[("machine.ini", &ini), ("machine.hal", &hal)])
}

/// A tool of 6 mm, which is assumed, plunges along itself to two points 10 mm below the surface, leaning by 30 degrees to Y and by
/// 20 to X: on a table that tilts by A and turns by C the tip is where X Y Z say.
const LEANS: &str = "\
G21 G90 G94 G54 F600
G0 X0 Y0 Z60
A30
G1 Y17.320508 Z20
Y0 Z-10
Y17.320508 Z20
G0 Z60
X44.558809 Y-20
A20 C90
G1 Z30
X30 Z-10
X44.558809 Z30
G0 Z60
M2
";

/// Size of the stock around both.
const BOX: [[i32; 3]; 2] = [[-40, -40, -20], [60, 40, 0]];

#[test]
fn a_table_that_tilts_lets_the_tool_lean_in_the_part() {
    let Some(fixture) = Fixture::with(DESKTOP, || machine("xyzac-trt-kins", "")) else { return };
    let b = &fixture.browser;
    fixture.ready();
    open(&fixture, "leans.ngc", LEANS);
    b.until(LOADED);
    // The program's own box begins at the tip of the tool.
    state_box(&fixture, BOX);
    simulate(&fixture, "max");
    let removed = number(&fixture, "removed");
    fixture.picture("five-axis");
    // A cylinder each, as long as from the tip to the surface.
    let long = |angle: f64| 10.0 / angle.to_radians().cos();
    let closed = PI * 9.0 * (long(30.0) + long(20.0));
    assert!((removed - closed).abs() < 0.05 * closed, "{removed} instead of {closed} mm³");
    assert_eq!(number(&fixture, "rapids").to_bits(), 0.0_f64.to_bits());
    assert_eq!(b.errors(), Vec::<String>::new());
}

/// The first of both points, with a tool of another length; it dwells at the ends, so that reports have them.
const LONGER: &str = "\
G21 G90 G94 G54 F1800
G0 X0 Y0 Z60
G43.1 Z20
G0 Z60
A30
G1 Y17.320508 Z20
G4 P1
Y0 Z-10
G4 P1
Y17.320508 Z20
G0 Z60
M2
";

#[test]
fn the_kinematics_are_read_anew_for_another_tool() {
    let length = "net length motion.tooloffset.z => xyzac-trt-kins.tool-offset\n";
    let Some(fixture) = Fixture::with(DESKTOP, || machine("xyzac-trt-kins", length)) else {
        return;
    };
    let b = &fixture.browser;
    fixture.ready();
    open(&fixture, "longer.ngc", LONGER);
    b.until(LOADED);
    state_box(&fixture, BOX);
    b.run("document.querySelector('#stock-live').click()");
    b.until("document.querySelector('.view').dataset.removed === '0'");
    fixture.hold("#run-start", "!document.querySelector('#run-stop').disabled");
    fixture.printer.job_ends();
    b.until("!document.querySelector('#sim-start').disabled");
    // With the offset as it was when the stock was made, the tip would be 10 mm aside and 2.7 mm deeper or higher.
    let closed = PI * 9.0 * 10.0 / 30_f64.to_radians().cos();
    let removed = number(&fixture, "removed");
    assert!((removed - closed).abs() < 0.08 * closed, "{removed} instead of {closed} mm³");
    assert_eq!(b.errors(), Vec::<String>::new());
}

#[test]
fn what_axes_without_known_kinematics_do_is_named() {
    let Some(fixture) = Fixture::with(DESKTOP, || machine("trivkins coordinates=xyzac", "")) else {
        return;
    };
    let b = &fixture.browser;
    fixture.ready();
    open(&fixture, "leans.ngc", LEANS);
    b.until(LOADED);
    simulate(&fixture, "max");
    let text = b.text("#sim-figures");
    assert!(text.contains("The program moves A C: its stock is not simulated"), "{text}");
    assert_eq!(b.run("return document.querySelector('.view').dataset.removed"), "");
    assert_eq!(b.errors(), Vec::<String>::new());
}
