//! Effects of `set`: commands of the machine, and settings of the session.

use crate::{
    Jog, JogTarget, Machine,
    get::{AXES, axis},
    session::Settings,
};
use hal_protocol::Stop;
use std::time::Duration;

/// Seconds in a minute: speeds of jogs are in units per minute.
const MINUTE: f64 = 60.0;
/// Change of the speed of a spindle by `increase` and `decrease`, in turns per minute.
const STEP: f64 = 100.0;
/// Speed at which a spindle begins to turn where no program has set one, in turns per minute.
const FIRST_SPEED: f64 = 1.0;

/// A subcommand on its way.
pub(crate) struct SetLine<'a> {
    pub(crate) settings: &'a mut Settings,
    pub(crate) machine: &'a mut dyn Machine,
    /// Text after the name of the subcommand.
    pub(crate) rest: &'a str,
    /// Password of `set enable`.
    pub(crate) password: &'a str,
}

/// Executes it; returns false for arguments that it does not have, and for a refusal of which the client learns.
pub(crate) type Set = fn(&mut SetLine<'_>, &[&str]) -> bool;

impl SetLine<'_> {
    /// Gives a command. As with LinuxCNC it counts as received although the machine refuses it; `get error` has the
    /// reason. A session that waits for its commands learns of the refusal at once.
    fn command(&mut self, name: &str, args: &[String]) -> bool {
        self.settings.ticket = None;
        let given = self.machine.command(name, args.to_vec());
        self.given(given)
    }

    /// Stops the machine, as a command.
    fn stop(&mut self, stop: Stop) -> bool {
        self.settings.ticket = None;
        let given = self.machine.stop(stop);
        self.given(given)
    }

    fn given(&mut self, given: Result<Option<u64>, String>) -> bool {
        match given {
            Ok(ticket) => {
                self.settings.ticket = ticket;
                !self.settings.waits || self.wait()
            }
            Err(why) => {
                self.settings.fail(&why);
                !self.settings.waits
            }
        }
    }

    fn wait(&mut self) -> bool {
        let Some(ticket) = self.settings.ticket.take() else { return true };
        let most = Duration::try_from_secs_f64(self.settings.timeout).ok();
        let done = self.machine.wait(ticket, most.filter(|time| !time.is_zero()));
        if let Err(why) = &done {
            self.settings.fail(why);
        }
        done.is_ok()
    }

    /// Refuses something that this machine does not have.
    fn refuse(&mut self, why: &str) -> bool {
        self.settings.fail(why);
        false
    }
}

fn on(args: &[&str]) -> Option<bool> {
    let word = args.first()?;
    if word.eq_ignore_ascii_case("on") {
        Some(true)
    } else {
        word.eq_ignore_ascii_case("off").then_some(false)
    }
}

fn bit(name: &str, on: bool) -> String {
    format!("{name}={}", if on { "TRUE" } else { "FALSE" })
}

fn number(word: Option<&&str>) -> Option<f64> {
    word?.parse::<f64>().ok().filter(|number| number.is_finite())
}

fn one_of(args: &[&str], words: &[&'static str]) -> Option<&'static str> {
    let word = args.first()?;
    words.iter().copied().find(|other| word.eq_ignore_ascii_case(other))
}

macro_rules! plain {
    ($($name:ident: $command:expr;)*) => {$(
        pub(crate) fn $name(order: &mut SetLine<'_>, _: &[&str]) -> bool {
            order.command($command, &[])
        }
    )*};
}

plain! {
    resume: "task.resume";
    step: "task.step";
}

macro_rules! coolant {
    ($($name:ident)*) => {$(
        pub(crate) fn $name(order: &mut SetLine<'_>, args: &[&str]) -> bool {
            on(args).is_some_and(|on| order.command("iocontrol.coolant", &[bit(stringify!($name), on)]))
        }
    )*};
}

coolant! { flood mist lube }

/// Accepts what has no effect.
pub(crate) fn nothing(_: &mut SetLine<'_>, _: &[&str]) -> bool {
    true
}

/// Refuses what cannot be set.
pub(crate) fn never(_: &mut SetLine<'_>, _: &[&str]) -> bool {
    false
}

pub(crate) fn abort(order: &mut SetLine<'_>, _: &[&str]) -> bool {
    order.stop(Stop::Abort)
}

pub(crate) fn pause(order: &mut SetLine<'_>, _: &[&str]) -> bool {
    order.stop(Stop::Pause)
}

pub(crate) fn estop(order: &mut SetLine<'_>, args: &[&str]) -> bool {
    on(args).is_some_and(|on| match on {
        true => order.stop(Stop::Estop),
        false => order.command("task.estop-reset", &[]),
    })
}

pub(crate) fn machine(order: &mut SetLine<'_>, args: &[&str]) -> bool {
    on(args).is_some_and(|on| match on {
        true => order.command("task.on", &[]),
        false => order.stop(Stop::Off),
    })
}

pub(crate) fn mode(order: &mut SetLine<'_>, args: &[&str]) -> bool {
    let mode = one_of(args, &["manual", "auto", "mdi"]);
    mode.is_some_and(|mode| order.command("task.mode", &[format!("mode={mode}")]))
}

pub(crate) fn teleop_enable(order: &mut SetLine<'_>, args: &[&str]) -> bool {
    let mode = on(args).map(|on| if on { "teleop" } else { "free" });
    mode.is_some_and(|mode| order.command("motion.mode", &[format!("mode={mode}")]))
}

pub(crate) fn home(order: &mut SetLine<'_>, args: &[&str]) -> bool {
    let joint = match args.first().and_then(|word| word.parse::<i32>().ok()) {
        None => return false,
        Some(-1) => "joint=all".to_owned(),
        Some(n) => format!("joint={n}"),
    };
    order.command("task.home", &[joint])
}

/// Returns the joint or axis of a jog: a number is that of a joint, or of an axis where jogs move axes.
fn target(order: &SetLine<'_>, word: &str) -> Option<JogTarget> {
    if order.machine.state().is_teleop() {
        AXES.chars().nth(axis(word)?).map(JogTarget::Axis)
    } else {
        word.parse().ok().map(JogTarget::Joint)
    }
}

fn jogs(order: &mut SetLine<'_>, args: &[&str], distance: Option<f64>) -> bool {
    let target = args.first().and_then(|word| target(order, word));
    if target.is_none() && args.first().is_some_and(|word| axis(word).is_some()) {
        return order
            .refuse("jogs move joints now, which have numbers: set teleop_enable on, for axes");
    }
    let (Some(target), Some(speed)) = (target, number(args.get(1))) else { return false };
    let jog = Jog { target, velocity: speed / MINUTE, distance };
    if let Err(why) = order.machine.jog(jog) {
        order.settings.fail(&why);
        return !order.settings.waits;
    }
    true
}

pub(crate) fn jog(order: &mut SetLine<'_>, args: &[&str]) -> bool {
    jogs(order, args, None)
}

/// Jogs by a distance, whose sign is that of the speed.
pub(crate) fn jog_incr(order: &mut SetLine<'_>, args: &[&str]) -> bool {
    let (speed, distance) = (number(args.get(1)), number(args.get(2)));
    let Some((speed, distance)) = speed.zip(distance) else { return false };
    let distance = if speed < 0.0 { -distance } else { distance };
    let speed = speed.abs().to_string();
    let target = args.first().copied().unwrap_or_default();
    jogs(order, &[target, &speed], Some(distance))
}

pub(crate) fn jog_stop(order: &mut SetLine<'_>, args: &[&str]) -> bool {
    let Some(word) = args.first().filter(|word| axis(word).is_some()) else { return false };
    // A stop of what does not jog in this mode stops all that does.
    let target = target(order, word).map(JogTarget::arg);
    order.command("motion.jog-stop", target.as_slice())
}

pub(crate) fn feed_override(order: &mut SetLine<'_>, args: &[&str]) -> bool {
    number(args.first()).is_some_and(|percent| {
        let scale = percent.max(0.0) / 100.0;
        order.command("task.feed-override", &[format!("scale={scale}")])
    })
}

pub(crate) fn spindle_override(order: &mut SetLine<'_>, args: &[&str]) -> bool {
    let (spindle, percent) = match args {
        [percent] => ("0", *percent),
        [spindle, percent, ..] => (*spindle, *percent),
        [] => return false,
    };
    let (Ok(spindle), Some(percent)) = (spindle.parse::<u32>(), number(Some(&percent))) else {
        return false;
    };
    let scale = percent.max(0.0) / 100.0;
    let args = [format!("spindle={spindle}"), format!("scale={scale}")];
    order.command("task.spindle-override", &args)
}

/// Returns the number of the spindle of an argument, or 0.
fn spindle_of(word: Option<&&str>) -> Option<u32> {
    word.map_or(Some(0), |word| word.parse().ok())
}

pub(crate) fn brake(order: &mut SetLine<'_>, args: &[&str]) -> bool {
    let (Some(on), Some(spindle)) = (on(args), spindle_of(args.get(1))) else { return false };
    order.command("motion.spindle", &[format!("spindle={spindle}"), bit("brake", on)])
}

pub(crate) fn spindle(order: &mut SetLine<'_>, args: &[&str]) -> bool {
    let words = ["forward", "reverse", "increase", "decrease", "constant", "off"];
    let (Some(word), Some(spindle)) = (one_of(args, &words), spindle_of(args.get(1))) else {
        return false;
    };
    let n = spindle as usize;
    let state = order.machine.state();
    let (turning, programmed) =
        (state.motion.number("spindle_speed", n), state.task.number("speed", n).abs());
    let begin = if programmed == 0.0 { FIRST_SPEED } else { programmed };
    let step = |by: f64| turning.signum() * (turning.abs() + by).max(0.0);
    let speed = match word {
        "forward" => begin,
        "reverse" => -begin,
        "off" => 0.0,
        // A spindle at rest has no speed that could change.
        "increase" if turning != 0.0 => step(STEP),
        "decrease" if turning != 0.0 => step(-STEP),
        _ => return true,
    };
    let args = [format!("spindle={spindle}"), format!("speed={speed}"), bit("brake", speed == 0.0)];
    order.command("motion.spindle", &args)
}

pub(crate) fn mdi(order: &mut SetLine<'_>, _: &[&str]) -> bool {
    let text = format!("text={}", order.rest);
    order.command("task.mdi", &[text])
}

pub(crate) fn open(order: &mut SetLine<'_>, args: &[&str]) -> bool {
    !args.is_empty() && {
        let file = format!("file={}", order.rest);
        order.command("task.open", &[file])
    }
}

pub(crate) fn run(order: &mut SetLine<'_>, args: &[&str]) -> bool {
    match args.first().map_or(Ok(0), |word| word.parse::<i64>()) {
        Ok(0 | 1) => order.command("task.run", &[]),
        Ok(n) if n < 0 => order.refuse("halgcode check verifies a program"),
        Ok(_) => order.refuse("a start at another line is shown and confirmed: task.run-from"),
        Err(_) => false,
    }
}

pub(crate) fn load_tool_table(order: &mut SetLine<'_>, args: &[&str]) -> bool {
    if args.is_empty() {
        return false;
    }
    // The table is that of the INI file, which is read again.
    let accepted = order.command("task.mdi-brief", &["text=G10 L0".to_owned()]);
    // The line of MDI occupies the machine: the next command must find it free.
    let done = order.wait();
    accepted && (done || !order.settings.waits)
}

pub(crate) fn optional_stop(order: &mut SetLine<'_>, args: &[&str]) -> bool {
    let on = one_of(args, &["0", "1"]).map(|word| word == "1");
    on.is_some_and(|on| order.command("task.optional-stop", &[bit("on", on)]))
}

pub(crate) fn override_limits(order: &mut SetLine<'_>, args: &[&str]) -> bool {
    match on(args) {
        Some(true) => order.command("motion.override-limits", &[]),
        // It ends with the next jog.
        Some(false) => true,
        None => false,
    }
}

pub(crate) fn probe(order: &mut SetLine<'_>, args: &[&str]) -> bool {
    let numbers: Vec<f64> = args.iter().filter_map(|word| number(Some(word))).collect();
    let [x, y, z] = numbers.as_slice() else { return false };
    order.command("task.mdi", &[format!("text=G38.2 X{x} Y{y} Z{z}")])
}

pub(crate) fn probe_clear(order: &mut SetLine<'_>, _: &[&str]) -> bool {
    order.refuse("the mark of a probe move is that of the last one: it cannot be cleared")
}

pub(crate) fn echo(order: &mut SetLine<'_>, args: &[&str]) -> bool {
    on(args).map(|on| order.settings.echo = on).is_some()
}

pub(crate) fn verbose(order: &mut SetLine<'_>, args: &[&str]) -> bool {
    on(args).map(|on| order.settings.verbose = on).is_some()
}

pub(crate) fn enable(order: &mut SetLine<'_>, args: &[&str]) -> bool {
    let Some(word) = args.first() else { return false };
    if word.eq_ignore_ascii_case("off") {
        order.machine.give();
        return true;
    }
    if *word != order.password {
        order.settings.wrong += 1;
        return false;
    }
    match order.machine.take() {
        Ok(()) => true,
        Err(why) => order.refuse(&why),
    }
}

pub(crate) fn comm_mode(order: &mut SetLine<'_>, args: &[&str]) -> bool {
    let mode = one_of(args, &["ascii", "binary"]);
    mode.map(|mode| order.settings.binary = mode == "binary").is_some()
}

pub(crate) fn set_wait(order: &mut SetLine<'_>, args: &[&str]) -> bool {
    let wait = one_of(args, &["received", "done"]);
    wait.map(|wait| order.settings.waits = wait == "done").is_some()
}

pub(crate) fn wait(order: &mut SetLine<'_>, args: &[&str]) -> bool {
    match one_of(args, &["received", "done"]) {
        Some("done") => order.wait(),
        wait => wait.is_some(),
    }
}

pub(crate) fn timeout(order: &mut SetLine<'_>, args: &[&str]) -> bool {
    number(args.first()).map(|seconds| order.settings.timeout = seconds).is_some()
}

pub(crate) fn update(order: &mut SetLine<'_>, args: &[&str]) -> bool {
    let update = one_of(args, &["none", "auto"]);
    update.map(|update| order.settings.fresh = update == "auto").is_some()
}

pub(crate) fn linear_conversion(order: &mut SetLine<'_>, args: &[&str]) -> bool {
    let unit = one_of(args, &["INCH", "MM", "CM", "AUTO", "CUSTOM"]);
    unit.map(|unit| order.settings.linear = unit).is_some()
}

pub(crate) fn angular_conversion(order: &mut SetLine<'_>, args: &[&str]) -> bool {
    let unit = one_of(args, &["DEG", "RAD", "GRAD", "AUTO", "CUSTOM"]);
    unit.map(|unit| order.settings.angular = unit).is_some()
}
