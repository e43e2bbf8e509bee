//! The tests of a machine, for `haltest`: what each of its lines does, in virtual time, as its answers say.

use super::{
    answers::{Answers, Joint, Motors},
    wiring::name,
};
use std::fmt::Write as _;

/// Name of the common beginning.
const BEGIN: &str = "on.begin";
/// Longest jog, in seconds. A joint that makes no step in it is only shown to follow.
const LONGEST_JOG: f64 = 20.0;

/// Returns the files of the folder `tests`, with their texts.
pub(super) fn tests(answers: &Answers) -> Vec<(String, String)> {
    let mut to = vec![
        (BEGIN.to_owned(), begin(answers)),
        ("estop.toml".to_owned(), estop(answers)),
        ("jog.toml".to_owned(), jog(answers)),
    ];
    if answers.pins.estop.is_some() {
        to.push(("estop-outside.toml".to_owned(), estop_outside()));
    }
    if answers.joint.iter().any(|j| j.switch.is_some()) {
        to.push(("limits.toml".to_owned(), limits(answers)));
    }
    let has_switch = answers.joint.iter().any(|j| j.switch.is_some());
    // A servo does not move without its motor, which the simulated board does not have.
    if has_switch && answers.kind != Motors::Servos {
        to.push(("home.toml".to_owned(), home(answers)));
    }
    if answers.pins.spindle.is_some() || answers.pins.spindle_pwm.is_some() {
        to.push(("spindle.toml".to_owned(), spindle(answers)));
    }
    if answers.pins.probe.is_some() || answers.pins.setter.is_some() {
        to.push(("probe.toml".to_owned(), probe(answers)));
    }
    if answers.pins.charge_pump.is_some() || answers.pins.estop_out.is_some() {
        to.push(("outputs.toml".to_owned(), outputs(answers)));
    }
    to
}

/// Returns the switches: the number of the joint and its signal.
fn switches(answers: &Answers) -> Vec<(usize, String)> {
    let each = answers.joint.iter().enumerate().filter(|(_, j)| j.switch.is_some());
    each.map(|(n, _)| (n, format!("{}switch", name(answers, n)))).collect()
}

/// Returns the common beginning: the inputs of a machine at rest, and the machine on.
fn begin(answers: &Answers) -> String {
    let mut inputs: Vec<String> =
        switches(answers).into_iter().map(|(_, signal)| format!("{signal} = false")).collect();
    let pins = &answers.pins;
    let more = [
        (&pins.estop, "estop-button = true"),
        (&pins.probe, "probe-in = false"),
        (&pins.setter, "setter-in = false"),
    ];
    inputs.extend(more.iter().filter(|(pin, _)| pin.is_some()).map(|(_, text)| (*text).to_owned()));
    let mut to = String::from("# The machine at rest, switched on.\n");
    put!(to, "machine = \"../{}.ini\"", answers.name);
    if !inputs.is_empty() {
        put!(to, "\n[[step]]\nforce = {{ {} }}", inputs.join(", "));
    }
    put!(to, "\n[[step]]\nrun = \"10ms\"\n");
    put!(
        to,
        "[[step]]\ndo = \"\"\"\niocontrol.estop-reset --wait\nmotion.enable --wait\n\"\"\"\nmark = \"on\""
    );
    to
}

fn head(about: &str) -> String {
    format!("about = \"{about}\"\nbegin = \"{BEGIN}\"\n")
}

fn run(to: &mut String, time: &str) {
    put!(to, "\n[[step]]\nrun = \"{time}\"");
}

fn execute(to: &mut String, line: &str) {
    put!(to, "\n[[step]]\ndo = \"{line}\"");
}

fn expect(to: &mut String, what: &str) {
    put!(to, "\n[[step]]\nexpect = {{ {what} }}");
}

/// Returns the values of all enables.
fn enables(answers: &Answers, is_on: bool) -> String {
    let each = (0..answers.joint.len()).map(|n| format!("{}enable = {is_on}", name(answers, n)));
    let all: Vec<String> = each.collect();
    format!("{}, \"motion.motion-enabled\" = {is_on}", all.join(", "))
}

fn estop(answers: &Answers) -> String {
    let mut to = head("The e-stop switches everything off at once, and its end starts nothing.");
    expect(&mut to, &enables(answers, true));
    execute(&mut to, "iocontrol.estop");
    run(&mut to, "10ms");
    expect(&mut to, &enables(answers, false));
    put!(to, "\n[[step]]\ndo = \"motion.enable --wait\"\nfails = \"the machine is in e-stop\"");
    execute(&mut to, "iocontrol.estop-reset --wait");
    run(&mut to, "100ms");
    expect(&mut to, &enables(answers, false));
    to
}

fn estop_outside() -> String {
    let mut to = head(
        "The button opens the e-stop chain: everything is off, and stays off when it is pulled out.",
    );
    put!(to, "\n[[step]]\nforce = {{ estop-button = false }}");
    run(&mut to, "10ms");
    expect(&mut to, "\"motion.motion-enabled\" = false, estop-ok = false");
    put!(to, "\n[[step]]\nforce = {{ estop-button = true }}");
    run(&mut to, "100ms");
    expect(&mut to, "\"motion.motion-enabled\" = false, estop-ok = false");
    to
}

/// Returns a gentle velocity of a joint.
fn gentle(joint: &Joint) -> f64 {
    joint.velocity / 2.0
}

/// Returns the time in which a jog makes some steps, in seconds.
fn of_steps(joint: &Joint) -> f64 {
    let way = 4.0 / joint.scale();
    let time = 0.2 + (2.0 * way / joint.acceleration).sqrt() + way / gentle(joint);
    time.min(LONGEST_JOG)
}

/// Returns whether a joint is one of the two motors of a gantry, which are homed before they are jogged.
fn is_pair(answers: &Answers, n: usize) -> bool {
    let is_second = |n: usize| answers.joint.get(n).is_some_and(|j| j.is_second);
    is_second(n) || is_second(n + 1)
}

/// Jogs each joint; a gantry with switches is moved by its homing. A servo's encoder stands still, as the simulated board has no motor: its following error must
/// switch the machine off.
fn jog(answers: &Answers) -> String {
    if answers.kind == Motors::Servos {
        let mut to = head(
            "A servo whose encoder stands still has a following error, and the machine is switched off.",
        );
        let joint = answers.joint.first();
        let velocity = joint.map_or(1.0, gentle);
        let has_switch = joint.is_some_and(|j| j.switch.is_some());
        let jog = format!("motion.jog joint=0 velocity={velocity}");
        match (is_pair(answers, 0), has_switch) {
            (true, true) => execute(&mut to, "motion.home joint=0"),
            (true, false) => {
                execute(&mut to, "motion.home joint=0 --wait");
                execute(&mut to, &jog);
            }
            (false, _) => execute(&mut to, &jog),
        }
        put!(to, "\n[[step]]\nwait = \"not motion.motion-enabled\"\nwithin = \"60s\"");
        expect(&mut to, "\"joint.0.f-errored\" = true");
        return to;
    }
    let mut to =
        head("Each motor is jogged: its steps are made, and it stands where motion wants it.");
    let jogged = |n: usize, joint: &Joint| !(is_pair(answers, n) && joint.switch.is_some());
    for (n, joint) in answers.joint.iter().enumerate().filter(|(n, j)| jogged(*n, j)) {
        let name = name(answers, n);
        if is_pair(answers, n) && !joint.is_second {
            execute(&mut to, &format!("motion.home joint={n} --wait"));
            put!(to, "\n[[step]]\nwait = \"joint.{}.homed\"\nwithin = \"10s\"", n + 1);
        }
        execute(&mut to, &format!("motion.jog joint={n} velocity={}", gentle(joint)));
        put!(to, "mark = \"{name}-begins\"");
        let time = of_steps(joint);
        run(&mut to, &format!("{}ms", (time * 1000.0).ceil()));
        execute(&mut to, &format!("motion.jog-stop joint={n}"));
        put!(to, "\n[[step]]\nwait = \"joint.{n}.in-position\"\nwithin = \"60s\"");
        run(&mut to, "200ms");
        put!(to, "mark = \"{name}-ends\"");
    }
    expect(&mut to, &enables(answers, true));
    for (n, joint) in answers.joint.iter().enumerate().filter(|(n, j)| jogged(*n, j)) {
        let name = name(answers, n);
        if joint.step.is_some() && of_steps(joint) < LONGEST_JOG {
            put!(
                to,
                "\n[[expect]]\nabout = \"it moves\"\nhappens = \"{name}step rises\"\nfrom = \"{name}-begins\"\nto = \"{name}-ends\""
            );
            put!(
                to,
                "\n[[expect]]\nabout = \"and no further than a step from there\"\nalways = \"joint.{n}.f-error in -1..1\""
            );
        }
    }
    to
}

fn limits(answers: &Answers) -> String {
    let mut to = head("A closed switch ends a jog, and the machine is switched off.");
    for (n, signal) in switches(answers) {
        let Some(joint) = answers.joint.get(n) else { continue };
        if answers.kind != Motors::Servos {
            execute(&mut to, &format!("motion.jog joint={n} velocity={}", gentle(joint)));
            run(&mut to, "50ms");
        }
        put!(to, "\n[[step]]\nforce = {{ {signal} = true }}");
        run(&mut to, "100ms");
        expect(
            &mut to,
            &format!("\"motion.motion-enabled\" = false, \"joint.{n}.pos-hard-limit\" = true"),
        );
        put!(to, "\n[[step]]\nforce = {{ {signal} = false }}");
        run(&mut to, "50ms");
        execute(&mut to, "motion.enable --wait");
    }
    to
}

/// Homes each joint that has a switch.
fn home(answers: &Answers) -> String {
    let mut to = head("Homing looks for the switch, and leaves it.");
    let switches = switches(answers);
    for (n, signal) in &switches {
        let Some(joint) = answers.joint.get(*n) else { continue };
        if joint.is_second {
            continue;
        }
        let second = format!("{}switch", name(answers, n + 1));
        let pair = answers.joint.get(n + 1).is_some_and(|j| j.is_second && j.switch.is_some());
        let force = |is_on: bool| match pair {
            true => format!("{signal} = {is_on}, {second} = {is_on}"),
            false => format!("{signal} = {is_on}"),
        };
        execute(&mut to, &format!("motion.home joint={n}"));
        // Homing waits a moment before it moves.
        run(&mut to, "500ms");
        expect(&mut to, &format!("\"joint.{n}.homing\" = true"));
        let search = joint.search.unwrap_or(1.0).abs();
        put!(to, "\n[[step]]\nforce = {{ {} }}", force(true));
        // It brakes, and goes back at a tenth of the velocity until the switch is free.
        let stop = 1.0 + search / joint.acceleration;
        run(&mut to, &format!("{}ms", (stop * 1000.0).ceil()));
        put!(to, "\n[[step]]\nforce = {{ {} }}", force(false));
        let way = (joint.max - joint.min) / joint.velocity + joint.velocity / joint.acceleration;
        put!(
            to,
            "\n[[step]]\nwait = \"joint.{n}.homed\"\nwithin = \"{}s\"",
            (10.0 + 4.0 * way).ceil()
        );
        if pair {
            put!(to, "\n[[step]]\nwait = \"joint.{}.homed\"\nwithin = \"10s\"", n + 1);
        }
    }
    to
}

fn spindle(answers: &Answers) -> String {
    let mut to = head("The spindle turns, turns round, and stops.");
    let speed = answers.spindle.speed / 2.0;
    let reverse = answers.pins.spindle_reverse.is_some();
    execute(&mut to, &format!("motion.spindle speed={speed}"));
    run(&mut to, "100ms");
    let forward = if reverse { ", spindle-reverse = false" } else { "" };
    expect(&mut to, &format!("spindle-on = true{forward}"));
    if answers.pins.spindle_pwm.is_some() {
        let channel = if answers.kind == Motors::Servos { answers.joint.len() } else { 0 };
        expect(&mut to, &format!("\"pwmgen.{channel}.curr-dc\" = 0.5"));
        put!(to, "tolerance = 0.2");
        put!(to, "\n[[expect]]\nhappens = \"spindle-pwm rises\"");
    }
    if reverse {
        execute(&mut to, &format!("motion.spindle speed=-{speed}"));
        run(&mut to, "100ms");
        expect(&mut to, "spindle-on = true, spindle-reverse = true");
    }
    execute(&mut to, "motion.spindle speed=0");
    run(&mut to, "100ms");
    expect(&mut to, "spindle-on = false");
    to
}

fn probe(answers: &Answers) -> String {
    let mut to = head("What touches is seen.");
    expect(&mut to, "\"motion.probe-input\" = false");
    let pins = &answers.pins;
    for (signal, pin) in [("probe-in", &pins.probe), ("setter-in", &pins.setter)] {
        if pin.is_none() {
            continue;
        }
        put!(to, "\n[[step]]\nforce = {{ {signal} = true }}");
        run(&mut to, "10ms");
        expect(&mut to, "\"motion.probe-input\" = true");
        put!(to, "\n[[step]]\nforce = {{ {signal} = false }}");
        run(&mut to, "10ms");
        expect(&mut to, "\"motion.probe-input\" = false");
    }
    to
}

fn outputs(answers: &Answers) -> String {
    let mut to = head("Relay and charge pump say that all is well, until it is not.");
    let relay = if answers.pins.estop.is_some() { "estop-allowed" } else { "estop-out" };
    run(&mut to, "20ms");
    if answers.pins.estop_out.is_some() {
        expect(&mut to, &format!("{relay} = true"));
    }
    put!(to, "\n[[step]]\ndo = \"iocontrol.estop\"\nmark = \"estop\"");
    run(&mut to, "20ms");
    if answers.pins.estop_out.is_some() {
        expect(&mut to, &format!("{relay} = false"));
    }
    if answers.pins.charge_pump.is_some() {
        put!(
            to,
            "\n[[expect]]\nhappens = \"pump rises\"\nfrom = \"on\"\nto = \"estop\"\nleast = 10"
        );
        put!(
            to,
            "\n[[expect]]\npulses = \"pump\"\nfrom = \"estop + 3ms\"\nto = \"end\"\ncount = 0"
        );
    }
    to
}
