//! The HAL file of a machine, and the script of one axis for the search of what it bears.

use super::{
    answers::{Answers, Driver, Joint, Motors},
    lines::{Line, line},
    timing::{Timing, rate},
    write::{number, purpose},
};
use std::{collections::BTreeSet, fmt::Write as _};

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
        wiring(&mut to, answers, timing, n, joint);
    }
    if timing.resets {
        put!(to, "\n# The port ends each step in the period in which it began.");
        let steps = answers.joint.iter().filter_map(|j| line(j.step.as_ref()?));
        let steps: Vec<Line> = steps.collect();
        let ports: BTreeSet<usize> = steps.iter().map(|step| step.port).collect();
        for port in ports {
            put!(to, "setp parport.{port}.reset-time {}", answers.pulse.length);
        }
        for step in steps {
            put!(to, "setp {}-reset TRUE", output(answers, step));
        }
    }
    spindle(&mut to, answers);
    touch(&mut to, answers);
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
    } else {
        put!(to, "loadrt stepgen step_type={}", vec!["0"; joints].join(","));
    }
    // A channel for each servo, and one for the spindle.
    let mut channels = if answers.kind == Motors::Servos { vec!["1"; joints] } else { Vec::new() };
    channels.extend(answers.pins.spindle_pwm.as_ref().map(|_| "0"));
    if !channels.is_empty() {
        put!(to, "loadrt pwmgen output_type={}", channels.join(","));
    }
    if answers.pins.estop.is_some() {
        put!(to, "loadrt estop_latch names=estop\nloadrt and2 names=estop-chain");
    }
    if answers.pins.charge_pump.is_some() {
        put!(to, "loadrt charge_pump");
    }
    if answers.pins.probe.is_some() && answers.pins.setter.is_some() {
        put!(to, "loadrt or2 names=touch");
    }
}

fn driver(to: &mut String, answers: &Answers) {
    match answers.driver {
        Driver::Parport => {
            put!(to, "loadrt hal_parport cfg=\"{}\"", answers.ports.join(" "));
        }
        Driver::Viagpio => put!(to, "loadrt hal_viagpio"),
    }
}

/// Returns the parts of the driver that have functions of their own.
fn boards(answers: &Answers) -> Vec<String> {
    match answers.driver {
        Driver::Parport => (0..answers.ports.len()).map(|p| format!("parport.{p}")).collect(),
        Driver::Viagpio => vec!["viagpio".to_owned()],
    }
}

/// Appends the reset of the port that ends each step in its period.
fn reset(to: &mut String, answers: &Answers, step: Line) {
    put!(to, "setp parport.{}.reset-time {}", step.port, answers.pulse.length);
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
        put!(to, "addf encoder.update-counters base-thread");
    } else {
        put!(to, "addf stepgen.make-pulses base-thread");
    }
    let has_widths = is_servo || answers.pins.spindle_pwm.is_some();
    if has_widths {
        put!(to, "addf pwmgen.make-pulses base-thread");
    }
    if answers.pins.charge_pump.is_some() {
        put!(to, "addf charge-pump base-thread");
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
    if answers.pins.probe.is_some() && answers.pins.setter.is_some() {
        put!(to, "addf touch servo-thread");
    }
    put!(to, "addf motion-command-handler servo-thread\naddf motion-controller servo-thread");
    if is_servo {
        for n in joints {
            put!(to, "addf pid.{n}.do-pid-calcs servo-thread");
        }
    } else {
        put!(to, "addf stepgen.update-freq servo-thread");
    }
    if has_widths {
        put!(to, "addf pwmgen.update servo-thread");
    }
}

/// Appends the wiring of a joint.
fn wiring(to: &mut String, answers: &Answers, timing: &Timing, n: usize, joint: &Joint) {
    let name = name(answers, n);
    let second = if joint.is_second { ", the second motor" } else { "" };
    put!(to, "\n# {}{second}.", joint.axis.clone().unwrap_or_else(|| format!("Joint {n}")));
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
        put!(to, "net {name}enable joint.{n}.amp-enable-out => stepgen.{n}.enable");
    }
    let from = if answers.kind == Motors::Servos { ["pwmgen", "pwm"] } else { ["stepgen", "step"] };
    let [component, pulses] = from;
    let signal = format!("{name}step {component}.{n}.{pulses}");
    give(to, answers, &signal, joint.step.as_ref());
    give(to, answers, &format!("{name}dir {component}.{n}.dir"), joint.direction.as_ref());
    give(to, answers, &format!("{name}enable"), joint.enable.as_ref());
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
        give(to, answers, "estop-allowed", answers.pins.estop_out.as_ref());
    } else {
        put!(
            to,
            "\n# The e-stop: what the user allows is what the machine has. No button is wired."
        );
        put!(to, "net estop-out iocontrol.0.user-enable-out => iocontrol.0.emc-enable-in");
        give(to, answers, "estop-out", answers.pins.estop_out.as_ref());
    }
    if answers.pins.charge_pump.is_some() {
        let ok = if answers.pins.estop.is_some() { "estop-ok" } else { "estop-out" };
        put!(to, "net {ok} => charge-pump.enable");
        give(to, answers, "pump charge-pump.out", answers.pins.charge_pump.as_ref());
    }
}

/// Returns the name of a joint in signals: the letter of its axis, with a 2 for the second motor of a gantry.
pub(super) fn name(answers: &Answers, n: usize) -> String {
    let joint = answers.joint.get(n);
    let second = if joint.is_some_and(|j| j.is_second) { "2" } else { "" };
    let letter = joint.and_then(|j| j.axis.as_ref());
    letter.map_or_else(|| format!("j{n}"), |l| format!("{}{second}", l.to_lowercase()))
}

/// Appends the spindle: what of it is wired.
fn spindle(to: &mut String, answers: &Answers) {
    let pins = &answers.pins;
    if pins.spindle.is_none() && pins.spindle_pwm.is_none() {
        return;
    }
    put!(to, "\n# The spindle.");
    give(to, answers, "spindle-on spindle.0.on", pins.spindle.as_ref());
    give(to, answers, "spindle-reverse spindle.0.reverse", pins.spindle_reverse.as_ref());
    if pins.spindle_pwm.is_some() {
        let channel = if answers.kind == Motors::Servos { answers.joint.len() } else { 0 };
        let spindle = answers.spindle;
        put!(to, "setp pwmgen.{channel}.scale {}", number(spindle.speed));
        put!(to, "setp pwmgen.{channel}.pwm-freq {}", number(spindle.frequency));
        put!(to, "setp pwmgen.{channel}.dither-pwm TRUE");
        put!(to, "net spindle-speed spindle.0.speed-out-abs => pwmgen.{channel}.value");
        let from = if pins.spindle.is_none() { "spindle.0.on " } else { "" };
        put!(to, "net spindle-on {from}=> pwmgen.{channel}.enable");
        let pulses = format!("spindle-pwm pwmgen.{channel}.pwm");
        give(to, answers, &pulses, pins.spindle_pwm.as_ref());
    }
}

/// Appends the touch probe and the tool setter, which a program cannot tell apart.
fn touch(to: &mut String, answers: &Answers) {
    let pins = &answers.pins;
    let both = pins.probe.is_some() && pins.setter.is_some();
    let each = [("probe-in", &pins.probe, "touch.in0"), ("setter-in", &pins.setter, "touch.in1")];
    if pins.probe.is_some() || pins.setter.is_some() {
        put!(to, "\n# What touches.");
    }
    for (signal, text, into) in each {
        if let Some(line) = text.as_ref().and_then(|text| line(text)) {
            let into = if both { into } else { "motion.probe-input" };
            put!(to, "net {signal} {} => {into}", input(answers, line));
        }
    }
    if both {
        put!(to, "net touching touch.out => motion.probe-input");
    }
}
