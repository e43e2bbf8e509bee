//! The INI file of a machine.

use super::{
    answers::{Answers, Axis, Driver, Joint, Motors, Units},
    timing::Timing,
};
use std::fmt::Write as _;

/// Returns a number without more than nine decimals, as INI files have them.
pub(super) fn number(value: f64) -> String {
    let text = format!("{value:.9}");
    let text = text.trim_end_matches('0');
    let text = if text.ends_with('.') { format!("{text}0") } else { text.to_owned() };
    if text == "-0.0" { "0.0".to_owned() } else { text }
}

/// Returns what the machine is, in a sentence.
pub(super) fn purpose(answers: &Answers) -> String {
    let joints = answers.joint.len();
    let board = match answers.driver {
        Driver::Parport => "a parallel port",
        Driver::Viagpio => "the GPIO of a VIA board",
    };
    match answers.kind {
        Motors::Steppers => format!("{joints} axes of stepper motors on {board}."),
        Motors::Servos => format!("{joints} axes of servo motors with encoders on {board}."),
        Motors::Arm => {
            let model = &answers.model;
            format!("A six-joint arm ({model}) with stepper motors on {board}.")
        }
    }
}

/// Returns the INI file.
pub(super) fn ini(answers: &Answers, timing: &Timing) -> String {
    let name = &answers.name;
    let is_arm = answers.kind == Motors::Arm;
    let mut to = String::new();
    put!(to, "# {}\n\n[EMC]\nMACHINE = {name}\nVERSION = 1.1\n", purpose(answers));
    put!(to, "[TASK]\nTASK = milltask\n\n[RS274NGC]\nPARAMETER_FILE = {name}.var\n");
    put!(to, "[EMCMOT]\nEMCMOT = motmod\nBASE_PERIOD = {}\nSERVO_PERIOD = 1000000\n", timing.base);
    put!(to, "[EMCIO]\nTOOL_TABLE = tool.tbl\n");
    put!(to, "[HAL]\nHALFILE = {name}.hal\nHALFILE = custom.hal\n");
    let letters: String = match answers.kind {
        Motors::Arm => "XYZABC".to_owned(),
        _ => answers.joint.iter().filter_map(|j| j.axis.as_deref()).collect(),
    };
    // Joints of a gantry share an axis: they are jogged one by one until they are homed.
    let both = if answers.joint.iter().any(|j| j.is_second) { " kinstype=BOTH" } else { "" };
    let kinematics = if is_arm {
        format!("armkins model={}", answers.model)
    } else {
        format!("trivkins coordinates={letters}{both}")
    };
    put!(to, "[KINS]\nJOINTS = {}\nKINEMATICS = {kinematics}\n", answers.joint.len());
    let units = if answers.units == Units::Mm { "mm" } else { "inch" };
    let speeds: Vec<f64> = if is_arm {
        answers.axis.iter().map(|a| a.velocity).collect()
    } else {
        answers.joint.iter().map(|j| j.velocity).collect()
    };
    let fastest = speeds.iter().copied().fold(0.0, f64::max);
    put!(to, "[TRAJ]\nCOORDINATES = {letters}\nLINEAR_UNITS = {units}\nANGULAR_UNITS = degree");
    put!(to, "DEFAULT_LINEAR_VELOCITY = {}", number(fastest / 10.0));
    put!(to, "MAX_LINEAR_VELOCITY = {}", number(fastest));
    for axis in &answers.axis {
        section_of_an_axis(&mut to, axis);
    }
    for (n, j) in answers.joint.iter().enumerate() {
        if let Some(letter) = j.axis.as_ref().filter(|_| !j.is_second) {
            let (min, max) = (j.min, j.max);
            let (velocity, acceleration) = (j.velocity, j.acceleration);
            let axis = Axis { letter: letter.clone(), min, max, velocity, acceleration };
            section_of_an_axis(&mut to, &axis);
        }
        section_of_a_joint(&mut to, answers, n, j);
    }
    to
}

fn section_of_an_axis(to: &mut String, axis: &Axis) {
    put!(to, "\n[AXIS_{}]\nMAX_VELOCITY = {}", axis.letter, number(axis.velocity));
    put!(to, "MAX_ACCELERATION = {}", number(axis.acceleration));
    put!(to, "MIN_LIMIT = {}\nMAX_LIMIT = {}", number(axis.min), number(axis.max));
}

fn section_of_a_joint(to: &mut String, answers: &Answers, n: usize, joint: &Joint) {
    let is_turning = answers.kind == Motors::Arm
        || joint.axis.as_deref().is_some_and(|letter| "ABC".contains(letter));
    let kind = if is_turning { "ANGULAR" } else { "LINEAR" };
    let (ferror, min_ferror) = match (answers.units, is_turning) {
        (Units::Inch, false) => (0.05, 0.01),
        _ => (1.0, 0.25),
    };
    // More than the way of one servo period, at which every fast move would fail, and than some steps.
    let ferror = f64::max(ferror, f64::max(5.0 * joint.velocity * 1e-3, 5.0 / joint.scale()));
    let min_ferror = f64::max(min_ferror, 2.0 / joint.scale());
    put!(to, "\n[JOINT_{n}]\nTYPE = {kind}\nMAX_VELOCITY = {}", number(joint.velocity));
    put!(to, "MAX_ACCELERATION = {}", number(joint.acceleration));
    if answers.kind != Motors::Servos {
        let most = joint.drive_acceleration.unwrap_or(1.25 * joint.acceleration);
        put!(to, "STEPGEN_MAXACCEL = {}", number(most));
    }
    put!(to, "SCALE = {}", number(joint.scale()));
    put!(to, "FERROR = {}\nMIN_FERROR = {}", number(ferror), number(min_ferror));
    put!(to, "MIN_LIMIT = {}\nMAX_LIMIT = {}", number(joint.min), number(joint.max));
    put!(to, "HOME = {}", number(joint.home));
    if let Some(search) = joint.search {
        // The switch is at the end to which the search goes; the latch comes back from it at a tenth of the speed.
        let end = if search < 0.0 { joint.min } else { joint.max };
        put!(to, "HOME_OFFSET = {}\nHOME_SEARCH_VEL = {}", number(end), number(search));
        put!(to, "HOME_LATCH_VEL = {}\nHOME_IGNORE_LIMITS = YES", number(-search / 10.0));
    } else {
        put!(to, "HOME_OFFSET = {}", number(joint.home));
    }
    put!(to, "HOME_SEQUENCE = {}", sequence(answers, n));
}

/// Returns the place of a joint in homing: each by itself, but both motors of a gantry in one final move.
fn sequence(answers: &Answers, n: usize) -> String {
    let is_second = |n: usize| answers.joint.get(n).is_some_and(|j| j.is_second);
    let before = (0..n).filter(|n| !is_second(n + 1)).count();
    // A negative 0 is none, so that a gantry on the first axis is the first of 1.
    let place = before + usize::from(is_second(1));
    if is_second(n) || is_second(n + 1) { format!("-{place}") } else { place.to_string() }
}
