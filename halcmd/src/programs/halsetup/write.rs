//! The INI file and the HAL file of a machine.

use super::{
    answers::{Answers, ArmModel, Axis, Driver, Joint, Motors, Units},
    lines::{Line, line},
    timing::{Timing, rate},
};
use std::fmt::Write as _;

/// Appends a line. Writing to a string cannot fail.
macro_rules! put {
    ($to:expr, $($words:tt)*) => {{
        let _: std::fmt::Result = writeln!($to, $($words)*);
    }};
}

/// Returns a number without more than nine decimals, as INI files have them.
fn number(value: f64) -> String {
    let text = format!("{value:.9}");
    let text = text.trim_end_matches('0');
    let text = if text.ends_with('.') { format!("{text}0") } else { text.to_owned() };
    if text == "-0.0" { "0.0".to_owned() } else { text }
}

/// Returns what the machine is, in a sentence.
fn purpose(answers: &Answers) -> String {
    let joints = answers.joint.len();
    let board = match answers.driver {
        Driver::Parport => "a parallel port",
        Driver::Viagpio => "the GPIO of a VIA board",
    };
    match answers.kind {
        Motors::Steppers => format!("{joints} axes of stepper motors on {board}."),
        Motors::Servos => format!("{joints} axes of servo motors with encoders on {board}."),
        Motors::Arm => {
            let model = answers.model.map_or("", ArmModel::name);
            format!("A six-joint arm ({model}) with stepper motors on {board}.")
        }
    }
}

/// Returns the INI file.
pub(super) fn ini(answers: &Answers, timing: &Timing) -> String {
    let name = answers.name.get_ref();
    let is_arm = answers.kind == Motors::Arm;
    let mut to = String::new();
    put!(to, "# {}\n\n[EMC]\nMACHINE = {name}\nVERSION = 1.1\n", purpose(answers));
    put!(to, "[TASK]\nTASK = milltask\n\n[RS274NGC]\nPARAMETER_FILE = {name}.var\n");
    put!(to, "[EMCMOT]\nEMCMOT = motmod\nBASE_PERIOD = {}\nSERVO_PERIOD = 1000000\n", timing.base);
    put!(to, "[EMCIO]\nTOOL_TABLE = tool.tbl\n");
    put!(to, "[HAL]\nHALFILE = {name}.hal\nHALFILE = custom.hal\n");
    let letters: String = match answers.kind {
        Motors::Arm => "XYZABC".to_owned(),
        _ => answers.joint.iter().filter_map(|j| j.get_ref().axis.as_deref()).collect(),
    };
    let kinematics = match (is_arm, answers.model) {
        (true, Some(model)) => format!("armkins model={}", model.name()),
        _ => format!("trivkins coordinates={letters}"),
    };
    put!(to, "[KINS]\nJOINTS = {}\nKINEMATICS = {kinematics}\n", answers.joint.len());
    let units = if answers.units == Units::Mm { "mm" } else { "inch" };
    let speeds: Vec<f64> = if is_arm {
        answers.axis.iter().map(|a| a.get_ref().velocity).collect()
    } else {
        answers.joint.iter().map(|j| j.get_ref().velocity).collect()
    };
    let fastest = speeds.iter().copied().fold(0.0, f64::max);
    put!(to, "[TRAJ]\nCOORDINATES = {letters}\nLINEAR_UNITS = {units}\nANGULAR_UNITS = degree");
    put!(to, "DEFAULT_LINEAR_VELOCITY = {}", number(fastest / 10.0));
    put!(to, "MAX_LINEAR_VELOCITY = {}", number(fastest));
    for axis in &answers.axis {
        let a = axis.get_ref();
        section_of_an_axis(&mut to, a);
    }
    for (n, joint) in answers.joint.iter().enumerate() {
        let j = joint.get_ref();
        if let Some(letter) = &j.axis {
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
        put!(to, "HOME_SEQUENCE = {n}");
    } else {
        put!(to, "HOME_OFFSET = {}\nHOME_SEQUENCE = {n}", number(joint.home));
    }
}

/// Returns the name of a pin for an output.
fn output(answers: &Answers, line: Line) -> String {
    match answers.driver {
        Driver::Parport => format!("parport.{}.pin-{:02}-out", line.port, line.number),
        Driver::Viagpio => format!("viagpio.pin-{:02}-out", line.number),
    }
}

/// Returns the name of a pin for an input.
fn input(answers: &Answers, line: Line) -> String {
    let not = if line.is_inverted { "-not" } else { "" };
    match answers.driver {
        Driver::Parport => format!("parport.{}.pin-{:02}-in{not}", line.port, line.number),
        Driver::Viagpio => format!("viagpio.pin-{:02}-in{not}", line.number),
    }
}

/// Appends the line that gives a signal to an output, if the answers have one.
fn give(to: &mut String, answers: &Answers, signal: &str, text: Option<&String>) {
    let Some(line) = text.and_then(|t| line(t)) else { return };
    let pin = output(answers, line);
    put!(to, "net {signal} => {pin}");
    if line.is_inverted {
        put!(to, "setp {pin}-invert TRUE");
    }
}

/// Returns the HAL file.
pub(super) fn hal(answers: &Answers, timing: &Timing) -> String {
    let mut to = String::new();
    put!(to, "# {} Made by halsetup.\n", purpose(answers));
    load(&mut to, answers);
    functions(&mut to, answers, timing);
    for (n, joint) in answers.joint.iter().enumerate() {
        wiring(&mut to, answers, timing, n, joint.get_ref());
    }
    if timing.resets {
        put!(to, "\n# The port ends each step in the period in which it began.");
        let steps = answers.joint.iter().filter_map(|j| line(j.get_ref().step.as_ref()?));
        for step in steps {
            reset(&mut to, answers, step);
        }
    }
    put!(to, "\n# The spindle.\nnet spindle-cmd <= spindle.0.speed-out");
    put!(to, "net spindle-cw <= spindle.0.forward\nnet spindle-ccw <= spindle.0.reverse");
    give(&mut to, answers, "spindle-on spindle.0.on", answers.pins.spindle.as_ref());
    estop(&mut to, answers);
    put!(to, "\n# The tool change: a person answers.\nloadusr -W hal_manualtoolchange");
    put!(to, "net tool-change iocontrol.0.tool-change => hal_manualtoolchange.change");
    put!(to, "net tool-changed iocontrol.0.tool-changed <= hal_manualtoolchange.changed");
    put!(to, "net tool-number iocontrol.0.tool-prep-number => hal_manualtoolchange.number");
    put!(to, "net tool-prepare-loopback iocontrol.0.tool-prepare => iocontrol.0.tool-prepared");
    to
}

fn load(to: &mut String, answers: &Answers) {
    let joints = answers.joint.len();
    put!(to, "loadrt [KINS]KINEMATICS");
    put!(
        to,
        "loadrt [EMCMOT]EMCMOT base_period_nsec=[EMCMOT]BASE_PERIOD \
         servo_period_nsec=[EMCMOT]SERVO_PERIOD num_joints=[KINS]JOINTS"
    );
    driver(to, answers);
    if answers.kind == Motors::Servos {
        put!(to, "loadrt encoder num_chan={joints}\nloadrt pid num_chan={joints}");
        put!(to, "loadrt pwmgen output_type={}", vec!["1"; joints].join(","));
    } else {
        put!(to, "loadrt stepgen step_type={}", vec!["0"; joints].join(","));
    }
    if answers.pins.estop.is_some() {
        put!(to, "loadrt estop_latch names=estop\nloadrt and2 names=estop-chain");
    }
}

fn driver(to: &mut String, answers: &Answers) {
    match answers.driver {
        Driver::Parport => {
            put!(to, "loadrt hal_parport cfg=\"{}\"", answers.ports.get_ref().join(" "));
        }
        Driver::Viagpio => put!(to, "loadrt hal_viagpio"),
    }
}

/// Returns the parts of the driver that have functions of their own.
fn boards(answers: &Answers) -> Vec<String> {
    match answers.driver {
        Driver::Parport => {
            (0..answers.ports.get_ref().len()).map(|p| format!("parport.{p}")).collect()
        }
        Driver::Viagpio => vec!["viagpio".to_owned()],
    }
}

/// Appends the reset of the port that ends each step in its period.
fn reset(to: &mut String, answers: &Answers, step: Line) {
    put!(to, "setp parport.{}.reset-time {}", step.port, answers.pulse.get_ref().length);
    put!(to, "setp {}-reset TRUE", output(answers, step));
}

/// Returns the script of a single axis for the search of what it bears. `is_simulated` adds a motor that stalls.
pub(super) fn axis(
    answers: &Answers,
    timing: &Timing,
    joint: &Joint,
    is_simulated: bool,
) -> String {
    let mut to = String::new();
    let base = timing.base;
    put!(to, "loadrt threads name1=base-thread period1={base} name2=servo-thread period2=1000000");
    driver(&mut to, answers);
    put!(to, "loadrt stepgen step_type=0\nloadrt steptest\nloadrt and2 names=may-move");
    put!(to, "loadrt estop_latch names=latch");
    let boards = boards(answers);
    for board in &boards {
        put!(to, "addf {board}.read base-thread");
    }
    put!(to, "addf stepgen.make-pulses base-thread");
    put!(to, "net step stepgen.0.step\nnet dir stepgen.0.dir");
    if is_simulated {
        put!(to, "loadrt stepper\naddf stepper.0 base-thread\nnet step => stepper.0.step");
        put!(to, "net dir => stepper.0.dir\nsetp stepper.0.scale {}", number(joint.scale()));
    }
    for board in &boards {
        put!(to, "addf {board}.write base-thread");
    }
    if timing.resets {
        for board in &boards {
            put!(to, "addf {board}.reset base-thread");
        }
        if let Some(step) = joint.step.as_ref().and_then(|text| line(text)) {
            reset(&mut to, answers, step);
        }
    }
    put!(to, "addf may-move servo-thread\naddf latch servo-thread");
    put!(to, "addf stepgen.capture-position servo-thread");
    put!(to, "addf steptest.0 servo-thread\naddf stepgen.update-freq servo-thread");
    put!(to, "setp stepgen.0.position-scale {}", number(joint.scale()));
    put!(to, "setp stepgen.0.steplen 1\nsetp stepgen.0.stepspace {}", timing.space);
    put!(to, "setp stepgen.0.dirhold {}\nsetp stepgen.0.dirsetup {}", timing.hold, timing.setup);
    put!(to, "net cmd steptest.0.position-cmd => stepgen.0.position-cmd");
    put!(to, "net fb stepgen.0.position-fb => steptest.0.position-fb");
    give(&mut to, answers, "step", joint.step.as_ref());
    give(&mut to, answers, "dir", joint.direction.as_ref());
    // What the e-stop chain or the switch at the ends has stopped, however shortly, only a new run switches on again.
    put!(to, "net may-move may-move.out => latch.ok-in");
    put!(to, "net enable latch.ok-out => stepgen.0.enable");
    give(&mut to, answers, "enable", answers.pins.enable.as_ref());
    let chain = answers.pins.estop.as_ref().and_then(|text| line(text));
    let free = joint.switch.as_ref().and_then(|text| line(text));
    let free = free.map(|switch| Line { is_inverted: !switch.is_inverted, ..switch });
    for (pin, source) in [("may-move.in0", chain), ("may-move.in1", free)] {
        match source.filter(|_| !is_simulated) {
            Some(source) => put!(to, "net {pin}-wire {} => {pin}", input(answers, source)),
            None => put!(to, "setp {pin} TRUE"),
        }
    }
    to
}

fn functions(to: &mut String, answers: &Answers, timing: &Timing) {
    let ports = boards(answers);
    let joints = 0..answers.joint.len();
    let is_servo = answers.kind == Motors::Servos;
    put!(to, "\n# The fast thread: inputs, pulses, outputs.");
    for port in &ports {
        put!(to, "addf {port}.read base-thread");
    }
    if is_servo {
        put!(to, "addf encoder.update-counters base-thread\naddf pwmgen.make-pulses base-thread");
    } else {
        put!(to, "addf stepgen.make-pulses base-thread");
    }
    for port in &ports {
        put!(to, "addf {port}.write base-thread");
    }
    if timing.resets {
        for port in &ports {
            put!(to, "addf {port}.reset base-thread");
        }
    }
    put!(to, "\n# The slow thread: where the motors are, where they shall be, how fast that is.");
    let capture = if is_servo { "encoder" } else { "stepgen" };
    put!(to, "addf {capture}.capture-position servo-thread");
    if answers.pins.estop.is_some() {
        put!(to, "addf estop-chain servo-thread\naddf estop servo-thread");
    }
    put!(to, "addf motion-command-handler servo-thread\naddf motion-controller servo-thread");
    if is_servo {
        for n in joints {
            put!(to, "addf pid.{n}.do-pid-calcs servo-thread");
        }
        put!(to, "addf pwmgen.update servo-thread");
    } else {
        put!(to, "addf stepgen.update-freq servo-thread");
    }
}

/// Appends the wiring of a joint.
fn wiring(to: &mut String, answers: &Answers, timing: &Timing, n: usize, joint: &Joint) {
    let name = joint.axis.as_ref().map_or_else(|| format!("j{n}"), |l| l.to_lowercase());
    put!(to, "\n# {}.", joint.axis.clone().unwrap_or_else(|| format!("Joint {n}")));
    if answers.kind == Motors::Servos {
        servo(to, answers, n, joint, &name);
    } else {
        put!(to, "# {:.0} steps a second at its velocity.", rate(joint));
        put!(to, "setp stepgen.{n}.position-scale [JOINT_{n}]SCALE");
        put!(to, "setp stepgen.{n}.steplen 1\nsetp stepgen.{n}.stepspace {}", timing.space);
        put!(to, "setp stepgen.{n}.dirhold {}", timing.hold);
        put!(to, "setp stepgen.{n}.dirsetup {}", timing.setup);
        put!(to, "setp stepgen.{n}.maxaccel [JOINT_{n}]STEPGEN_MAXACCEL");
        put!(to, "net {name}pos-cmd joint.{n}.motor-pos-cmd => stepgen.{n}.position-cmd");
        put!(to, "net {name}pos-fb stepgen.{n}.position-fb => joint.{n}.motor-pos-fb");
        put!(to, "net {name}step <= stepgen.{n}.step\nnet {name}dir <= stepgen.{n}.dir");
        put!(to, "net {name}enable joint.{n}.amp-enable-out => stepgen.{n}.enable");
    }
    give(to, answers, &format!("{name}step"), joint.step.as_ref());
    give(to, answers, &format!("{name}dir"), joint.direction.as_ref());
    if n == 0 {
        give(to, answers, &format!("{name}enable"), answers.pins.enable.as_ref());
    }
    if let Some(switch) = joint.switch.as_ref().and_then(|t| line(t)) {
        let pin = input(answers, switch);
        put!(
            to,
            "net {name}switch {pin} => joint.{n}.home-sw-in joint.{n}.neg-lim-sw-in joint.{n}.pos-lim-sw-in"
        );
    }
}

/// Appends the loop of a servo: the error of its position gives a speed, and the speed a power.
fn servo(to: &mut String, answers: &Answers, n: usize, joint: &Joint, name: &str) {
    let full = joint.full_speed.unwrap_or(joint.velocity);
    put!(to, "# {:.0} edges a second at its velocity. Tune Pgain first.", rate(joint));
    put!(to, "setp encoder.{n}.position-scale [JOINT_{n}]SCALE");
    put!(to, "setp pid.{n}.Pgain 10\nsetp pid.{n}.FF1 1\nsetp pid.{n}.maxoutput {}", number(full));
    put!(to, "setp pwmgen.{n}.scale {}\nsetp pwmgen.{n}.pwm-freq 1000", number(full));
    put!(to, "setp pwmgen.{n}.dither-pwm TRUE");
    put!(to, "net {name}pos-cmd joint.{n}.motor-pos-cmd => pid.{n}.command");
    put!(to, "net {name}pos-fb encoder.{n}.position => pid.{n}.feedback joint.{n}.motor-pos-fb");
    put!(to, "net {name}effort pid.{n}.output => pwmgen.{n}.value");
    put!(to, "net {name}enable joint.{n}.amp-enable-out => pid.{n}.enable pwmgen.{n}.enable");
    put!(to, "net {name}step <= pwmgen.{n}.pwm\nnet {name}dir <= pwmgen.{n}.dir");
    for (phase, text) in [("A", &joint.a), ("B", &joint.b)] {
        if let Some(line) = text.as_ref().and_then(|t| line(t)) {
            let signal = format!("{name}{}", phase.to_lowercase());
            put!(to, "net {signal} {} => encoder.{n}.phase-{phase}", input(answers, line));
        }
    }
}

fn estop(to: &mut String, answers: &Answers) {
    if let Some(chain) = answers.pins.estop.as_ref().and_then(|t| line(t)) {
        put!(
            to,
            "\n# The e-stop: the chain and iocontrol close it, and a latch waits for its reset."
        );
        put!(to, "net estop-button {} => estop-chain.in0", input(answers, chain));
        put!(to, "net estop-allowed iocontrol.0.user-enable-out => estop-chain.in1");
        put!(to, "net estop-closed estop-chain.out => estop.ok-in");
        put!(to, "net estop-reset iocontrol.0.user-request-enable => estop.reset");
        put!(to, "net estop-ok estop.ok-out => iocontrol.0.emc-enable-in motion.enable");
    } else {
        put!(
            to,
            "\n# The e-stop: what the user allows is what the machine has. No button is wired."
        );
        put!(to, "net estop-out iocontrol.0.user-enable-out => iocontrol.0.emc-enable-in");
    }
}
