//! Runs of one axis for the search: an engine with a step generator, and a person or a simulated motor that tells
//! whether steps were lost.

use super::{
    answers::{Answers, Joint, Motors, Units},
    search::{Settings, Trial, search, told},
    timing::{Timing, rate, timing},
    wiring,
};
use crate::{programs::alone::Alone, terminal::termination::ending_flag};
use hal_engine::ClockKind;
use std::sync::atomic::{AtomicBool, Ordering};

/// Time between two looks at a run, in nanoseconds.
const LOOK_NS: u64 = 10_000_000;
/// Time after a run in which a motor comes to rest, in nanoseconds.
const REST_NS: u64 = 200_000_000;
/// Looks until a run is aborted: an hour.
const MAX_LOOKS: u32 = 360_000;
/// Ends of the way that a run reaches before it returns.
const ENDS: u32 = 2;
/// Share of its limits up to which the simulated motor is sure to hold: it measures speeds from steps.
const SURE: f64 = 0.98;
/// Share of the travel that a run uses on each side of the middle, unless it is given.
const TRAVEL: f64 = 0.45;

/// Options of a search, as the command line states them.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Search {
    /// Letter of the axis, or number of the joint.
    pub(super) axis: String,
    pub(super) amplitude: Option<f64>,
    pub(super) velocity_step: Option<f64>,
    pub(super) acceleration_step: Option<f64>,
    /// Velocity and acceleration from which a simulated motor loses steps.
    pub(super) stall: Option<(f64, f64)>,
    /// True for the virtual clock with simulated hardware, where a person still judges.
    pub(super) is_virtual: bool,
}

/// A person who is asked, and who answers with a line.
pub(super) type AskUser<'a> = dyn FnMut(&str) -> Result<Option<String>, String> + 'a;

/// Searches what an axis bears; returns the report.
pub(super) fn test(
    answers: &Answers,
    asked: &Search,
    ask: &mut AskUser<'_>,
) -> Result<String, String> {
    let simulated = asked.stall.is_some() || asked.is_virtual;
    let Tested { number, joint, name, timing } =
        tested(answers, &asked.axis, simulated).map_err(|why| why.to_string())?;
    let settings = settings(joint, &timing, asked);
    let clock = if simulated { ClockKind::Virtual } else { ClockKind::Real };
    let mut engine = Alone::new(clock, None)?;
    engine.script("axis test", &wiring::axis(answers, &timing, joint, asked.stall.is_some()))?;
    if let Some((velocity, acceleration)) = asked.stall {
        engine.set("stepper.0.max-vel", &(velocity * SURE).to_string())?;
        engine.set("stepper.0.max-accel", &(acceleration * SURE).to_string())?;
    }
    engine.set("steptest.0.amplitude", &settings.amplitude.to_string())?;
    // Drives are switched off before the program ends.
    let ending = ending_flag();
    engine.script("axis test", "start")?;
    let unit = if answers.units == Units::Mm { "mm" } else { "inch" };
    let mut returns = |trial: Trial| {
        let shown =
            format!("axis {name}: {} {unit}/s, {} {unit}/s^2", trial.velocity, trial.acceleration);
        if asked.stall.is_some() {
            let from = engine.number("stepper.0.position")?;
            run(&mut engine, trial, &ending)?;
            let off = engine.number("stepper.0.position")? - from;
            // A person puts the axis back on its mark; the next trial begins where this one ended.
            return Ok(off.abs() * joint.scale().abs() < 1.0);
        }
        let question = format!(
            "{shown}, {} {unit} to each side: mark where it stands, then Enter (q ends) ",
            settings.amplitude
        );
        answer(ask, &question, &["", "q"])?;
        run(&mut engine, trial, &ending)?;
        let said = answer(ask, "does it stand on its mark again? [y/n/q] ", &["y", "n", "q"])?;
        Ok(said == "y")
    };
    let borne = search(&settings, &mut returns)?;
    Ok(told(name, unit, number, &borne))
}

/// Joint that is tested, with its number, its axis, and the timing of the steps.
struct Tested<'a> {
    number: usize,
    joint: &'a Joint,
    name: &'a str,
    timing: Timing,
}

/// Reason why an axis cannot be tested.
enum Untestable<'a> {
    /// The motors are servos.
    Servos,
    /// No joint has this letter or number.
    Unknown { axis: &'a str, answers: &'a Answers },
    /// Steps of a joint come faster than the computer can make them.
    TooFast { joint: usize, possible: f64 },
    /// The answers have no lines for the steps of this axis.
    NoStep { axis: &'a str },
}

impl core::fmt::Display for Untestable<'_> {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        match self {
            Self::Servos => {
                f.write_str("servos have encoders: they lose no steps that a search could find")
            }
            Self::Unknown { axis, answers } => {
                let joints = answers.joint.iter().enumerate();
                let names = joints.map(|(n, j)| j.axis.clone().unwrap_or(n.to_string()));
                let names = names.collect::<Vec<_>>().join(", ");
                write!(f, "--test '{axis}': the answers have {names}")
            }
            Self::TooFast { joint, possible } => write!(
                f,
                "joint {joint}: too fast for this computer's jitter; a velocity of {possible:.3} is possible"
            ),
            Self::NoStep { axis } => {
                write!(f, "axis {axis}: the answers have no step and direction for it")
            }
        }
    }
}

/// Finds what is tested: the joint of an axis, by its letter or number. A simulated one needs no lines.
fn tested<'a>(
    answers: &'a Answers,
    axis: &'a str,
    simulated: bool,
) -> Result<Tested<'a>, Untestable<'a>> {
    if answers.kind == Motors::Servos {
        return Err(Untestable::Servos);
    }
    let is_axis = |j: &Joint| j.axis.as_deref().is_some_and(|name| name.eq_ignore_ascii_case(axis));
    let by_letter = answers.joint.iter().position(is_axis);
    let found = by_letter.or_else(|| axis.parse().ok());
    let found = found.and_then(|n| Some((n, answers.joint.get(n)?)));
    let (number, joint) = found.ok_or(Untestable::Unknown { axis, answers })?;
    let name = joint.axis.as_deref().unwrap_or(axis);
    let timing =
        timing(answers).map_err(|(joint, possible)| Untestable::TooFast { joint, possible })?;
    if !simulated && joint.step.is_none() {
        return Err(Untestable::NoStep { axis: name });
    }
    Ok(Tested { number, joint, name, timing })
}

/// Returns the settings of a search; what is not given follows from the answers.
fn settings(joint: &Joint, timing: &Timing, asked: &Search) -> Settings {
    let periods = if timing.resets { 1.0 } else { 2.0 };
    let highest = 1e9 / (periods * timing.base);
    Settings {
        amplitude: asked.amplitude.unwrap_or((joint.max - joint.min) * TRAVEL),
        velocity_step: asked.velocity_step.unwrap_or(joint.velocity / 10.0),
        acceleration_step: asked.acceleration_step.unwrap_or(joint.acceleration / 10.0),
        gentle: joint.acceleration / 2.0,
        fastest: joint.velocity * highest / rate(joint),
    }
}

/// Runs back and forth once, and home.
fn run(engine: &mut Alone, trial: Trial, ending: &AtomicBool) -> Result<(), String> {
    engine.set("stepgen.0.maxvel", &trial.velocity.to_string())?;
    engine.set("stepgen.0.maxaccel", &trial.acceleration.to_string())?;
    // The latch opens at the edge, if the e-stop and the switch permit it.
    engine.set("latch.reset", "TRUE")?;
    engine.pass(LOOK_NS)?;
    engine.set("latch.reset", "FALSE")?;
    go_on(engine, ending)?;
    engine.set("steptest.0.run", "TRUE")?;
    let (mut target, mut ends) = (None, 0);
    for _ in 0..MAX_LOOKS {
        engine.pass(LOOK_NS)?;
        go_on(engine, ending)?;
        let now = engine.number("steptest.0.position-cmd")?.to_bits();
        if target.replace(now).is_some_and(|before| before != now) {
            ends += 1;
            if ends == ENDS {
                engine.set("steptest.0.run", "FALSE")?;
            }
        }
        if engine.number("steptest.0.running")? == 0.0 && ENDS <= ends {
            return engine.pass(REST_NS);
        }
    }
    Err("the axis has not come back to its start within an hour".to_owned())
}

/// Ends the run if a signal ends the program, or if the e-stop or a switch has stopped the axis.
fn go_on(engine: &mut Alone, ending: &AtomicBool) -> Result<(), String> {
    if ending.load(Ordering::Relaxed) {
        return Err("the search was ended: nothing is told of the axis".to_owned());
    }
    if engine.number("stepgen.0.enable")? == 0.0 {
        engine.set("steptest.0.run", "FALSE")?;
        return Err("the e-stop or a switch has ended the run: nothing moves any more".to_owned());
    }
    Ok(())
}

/// Asks until one of the answers comes; `q` and the end of the input end the search.
fn answer(ask: &mut AskUser<'_>, question: &str, answers: &[&str]) -> Result<String, String> {
    loop {
        let line =
            ask(question)?.ok_or("the search was not finished: nothing is told of the axis")?;
        let said = line.trim().to_lowercase();
        if said == "q" {
            return Err("the search was ended: nothing is told of the axis".to_owned());
        }
        if answers.contains(&said.as_str()) {
            return Ok(said);
        }
    }
}

/// Reads `V,A`, two numbers above 0.
pub(super) fn pair(text: &str) -> Option<(f64, f64)> {
    let (velocity, acceleration) = text.split_once(',')?;
    Some((positive(velocity)?, positive(acceleration)?))
}

/// Reads a number above 0.
pub(super) fn positive(text: &str) -> Option<f64> {
    text.trim().parse().ok().filter(|x: &f64| x.is_finite() && *x > 0.0)
}

#[cfg(test)]
mod tests {
    use super::{answer, pair, positive, timing, wiring};
    use crate::programs::halsetup::given;

    #[test]
    fn only_a_latch_switches_the_drive_on() {
        let text = include_str!("../../../../configs/printer/printer.setup");
        let answers = given::read(text).unwrap();
        let timing = timing(&answers).unwrap();
        for is_simulated in [false, true] {
            let joint = &answers.joint[0];
            let script = wiring::axis(&answers, &timing, joint, is_simulated);
            let of = |word: &str| script.lines().filter(|l| l.contains(word)).collect::<Vec<_>>();
            assert_eq!(of("stepgen.0.enable"), ["net enable latch.ok-out => stepgen.0.enable"]);
            assert_eq!(of("latch.ok-in"), ["net may-move may-move.out => latch.ok-in"]);
            // The chain is judged before the latch, and both before the steps.
            let order = of("addf").into_iter().filter(|l| l.ends_with("servo-thread"));
            let order: Vec<_> = order.map(|l| l.split(' ').nth(1).unwrap()).collect();
            assert_eq!(order[..2], ["may-move", "latch"], "{order:?}");
        }
    }

    #[test]
    fn numbers_are_above_0() {
        assert_eq!(pair("100,1600"), Some((100.0, 1600.0)));
        for wrong in ["100", "100,", "-1,2", "0,1", "nan,1", "1,inf", "a,b", ""] {
            assert_eq!(pair(wrong), None, "{wrong}");
        }
        assert_eq!((positive("2.5"), positive("0")), (Some(2.5), None));
    }

    #[test]
    fn a_person_is_asked_until_the_answer_is_one() {
        let mut lines = ["what", "Y"].into_iter();
        let mut ask = |_: &str| Ok(lines.next().map(str::to_owned));
        assert_eq!(answer(&mut ask, "?", &["y", "n"]), Ok("y".to_owned()));
        assert!(answer(&mut ask, "?", &["y", "n"]).unwrap_err().contains("not finished"));
        let mut quits = |_: &str| Ok(Some("q\n".to_owned()));
        assert!(answer(&mut quits, "?", &["", "q"]).unwrap_err().contains("was ended"));
    }
}
