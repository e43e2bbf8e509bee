//! Comparison of the joints in an INI file with the step generators that move them.

use crate::{ini::Entry, session::dry_run::DryRun};
use hal_protocol::{At, Code, Direction, Finding, Kind, Link, Reply, Request, SignalInfo, Value};

/// The function that makes step pulses.
const MAKER: &str = "stepgen.make-pulses";

pub(super) fn findings(dry_run: &mut DryRun) -> Vec<Finding> {
    let Some(ini) = dry_run.ini().cloned() else { return Vec::new() };
    let kind = if ini.is_old() { "axis" } else { "joint" };
    let mut machine = JointQueries { link: dry_run.engine() };
    let Some(period) = machine.period() else { return Vec::new() };
    let signals = machine.signals();
    let mut found = Vec::new();
    for n in 0..16 {
        let section = format!("{}_{n}", kind.to_ascii_uppercase());
        let command = format!("{kind}.{n}.motor-pos-cmd");
        let Some(channel) = channel(&signals, &command) else { continue };
        let entry = |name: &str| ini.all(&section, name).next();
        if let Some(speed) = entry("MAX_VELOCITY") {
            found.extend(machine.speed(&channel, period, speed));
            found.extend(machine.top(&channel, speed));
        }
        if let Some(accel) = entry("MAX_ACCELERATION") {
            found.extend(machine.accel(&channel, accel));
        }
    }
    found
}

/// Returns the step generator that receives a joint's position command, such as `stepgen.0`.
fn channel(signals: &[SignalInfo], command: &str) -> Option<String> {
    let signal = signals.iter().find(|s| s.pins.iter().any(|(_, pin)| pin == command))?;
    signal.pins.iter().find_map(|(direction, pin)| {
        let channel = pin.strip_suffix(".position-cmd")?;
        (*direction == Direction::In && channel.starts_with("stepgen.")).then(|| channel.to_owned())
    })
}

struct JointQueries<'a> {
    link: &'a mut dyn Link,
}

impl JointQueries<'_> {
    /// Returns the period of the thread that makes the pulses, in nanoseconds.
    fn period(&mut self) -> Option<f64> {
        let list = Request::List { kind: Kind::Threads, patterns: Vec::new(), ty: None };
        let Ok(Reply::Threads(threads)) = self.link.call(list) else { return None };
        let thread = threads.iter().find(|t| t.functs.iter().any(|f| f == MAKER))?;
        Some(thread.period as f64)
    }

    fn signals(&mut self) -> Vec<SignalInfo> {
        let list = Request::List { kind: Kind::Signals, patterns: Vec::new(), ty: None };
        match self.link.call(list) {
            Ok(Reply::Signals(list)) => list,
            _ => Vec::new(),
        }
    }

    fn number(&mut self, name: &str) -> Option<f64> {
        match self.link.call(Request::Get { name: name.to_owned() }) {
            Ok(Reply::Value(Value::Float(x))) => Some(x),
            Ok(Reply::Value(Value::U32(n))) => Some(f64::from(n)),
            _ => None,
        }
    }

    fn speed(&mut self, channel: &str, period: f64, entry: &Entry) -> Option<Finding> {
        let speed: f64 = value(entry)?;
        let scale = self.number(&format!("{channel}.position-scale"))?.abs();
        let len = self.number(&format!("{channel}.steplen"))?.max(1.0);
        let space = self.number(&format!("{channel}.stepspace")).unwrap_or(0.0);
        let periods = (len / period).ceil() + (space / period).ceil();
        let (wish, most) = (speed * scale, 1e9 / (periods * period));
        if wish.is_nan() || wish <= most {
            return None;
        }
        let subject = format!("[{}]{}", entry.section, entry.name);
        let text = format!(
            "{subject} asks {channel} for {wish:.0} steps/s; in periods of {period:.0} ns it makes \
             {most:.0} at most"
        );
        Some(Finding::new(Code::JointTooFast, &subject, text).at(place(entry)).remedy(format!(
            "at most {:.3} units/s, or a base period of at most {:.0} ns",
            most / scale,
            (1e9 / wish / periods).floor()
        )))
    }

    /// Compares the velocity with the step generator's own limit.
    fn top(&mut self, channel: &str, entry: &Entry) -> Option<Finding> {
        let speed: f64 = value(entry)?;
        let most = self.number(&format!("{channel}.maxvel"))?;
        if most <= 0.0 || speed.is_nan() || speed <= most {
            return None;
        }
        let subject = format!("[{}]{}", entry.section, entry.name);
        let text = format!(
            "{subject} is {speed}, and '{channel}.maxvel' is {most}: the motor stays behind"
        );
        Some(
            Finding::new(Code::JointTooFast, &subject, text)
                .at(place(entry))
                .remedy(format!("let maxvel be more than {speed}, or 0 for no limit")),
        )
    }

    fn accel(&mut self, channel: &str, entry: &Entry) -> Option<Finding> {
        let accel: f64 = value(entry)?;
        let most = self.number(&format!("{channel}.maxaccel"))?;
        if most <= 0.0 || accel.is_nan() || accel <= most {
            return None;
        }
        let subject = format!("[{}]{}", entry.section, entry.name);
        let text = format!(
            "{subject} is {accel}, and '{channel}.maxaccel' is {most}: the motor stays behind"
        );
        Some(
            Finding::new(Code::StepgenSlower, &subject, text)
                .at(place(entry))
                .remedy(format!("let maxaccel be more than {accel}, by a quarter or so")),
        )
    }
}

/// Returns the number that an entry states.
pub(super) fn value(entry: &Entry) -> Option<f64> {
    entry.value.split_whitespace().next()?.parse().ok()
}

/// Returns the position of an entry.
pub(super) fn place(entry: &Entry) -> Option<At> {
    Some(At::new(&entry.file, entry.line))
}
