//! Arguments of a command: those of a text command, or the fields of a record of the service `motion`.

use crate::{
    commands::arguments::{AXIS, JOINT, SPINDLE, TRAJ},
    pins::LETTERS,
};
use hal_component::{
    Error, MotionCommand, StopEpoch, motion_flags as flags, motion_kind, motion_setting,
};

/// Arguments of a command, by name.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Call<'c> {
    /// A text command.
    Text(&'c hal_component::Call<'c>),
    /// A record, of a kind that exists, whose codes are those of the ABI.
    Record(&'c MotionCommand),
}

impl<'c> Call<'c> {
    /// Checks the codes of a record. Its numbers are checked as those of a text command.
    pub(crate) fn of(c: &'c MotionCommand) -> Result<Self, Error> {
        let unknown = |what: &str, n: u32| Err(Error::new(format!("there is no {what} {n}")));
        let kind = usize::try_from(c.kind).unwrap_or(usize::MAX);
        if kind == 0 || motion_kind::NAMES.len() <= kind {
            return unknown("command of kind", c.kind);
        }
        if c.flags & !flags::ALL_BITS != 0 {
            return unknown("flag in", c.flags);
        }
        if c.letters >> LETTERS.len() != 0 {
            return unknown("letter in", c.letters);
        }
        if c.speed_kind > 3 {
            return unknown("kind of speed", c.speed_kind);
        }
        if c.extent > 2 {
            return unknown("extent of a jog", c.extent);
        }
        let is_known = |name: &&str| [JOINT, AXIS, SPINDLE, TRAJ].iter().any(|l| l.contains(name));
        if c.kind == motion_kind::CONFIGURE && setting(c).filter(is_known).is_none() {
            return unknown("setting", c.setting);
        }
        Ok(Self::Record(c))
    }

    /// Returns the stop epoch in which the order was given; none means now.
    pub(crate) fn epoch(&self) -> Option<StopEpoch> {
        match self {
            Self::Text(call) => StopEpoch::of(u64::try_from(call.int("epoch")?).ok()?),
            Self::Record(c) => StopEpoch::of(c.epoch),
        }
    }

    /// Returns an integer or boolean argument that is given or has a default.
    pub(crate) fn int(&self, name: &str) -> Option<i64> {
        match self {
            Self::Text(call) => call.int(name),
            Self::Record(c) => int(c, name),
        }
    }

    /// Returns a number that is given or has a default.
    pub(crate) fn float(&self, name: &str) -> Option<f64> {
        match self {
            Self::Text(call) => call.float(name),
            Self::Record(c) => float(c, name),
        }
    }

    /// Returns a boolean argument that is given or has a default.
    pub(crate) fn bit(&self, name: &str) -> Option<bool> {
        match self {
            Self::Text(call) => call.bit(name),
            Self::Record(c) => bit(c, name),
        }
    }

    /// Returns a string argument that is given or has a default.
    pub(crate) fn text(&self, name: &str) -> Option<String> {
        match self {
            Self::Text(call) => call.text(name),
            Self::Record(c) => text(c, name),
        }
    }
}

/// Returns the name of the setting that a record changes.
pub(crate) fn setting(c: &MotionCommand) -> Option<&'static str> {
    let names = motion_setting::NAMES.get(usize::try_from(c.setting).ok()?);
    names.copied().filter(|_| c.kind == motion_kind::CONFIGURE)
}

/// Returns whether a move follows a spindle, and has no speed of its own.
fn is_bound(c: &MotionCommand) -> bool {
    let may = [motion_kind::MOVE, motion_kind::ARC, motion_kind::TAP];
    may.contains(&c.kind) && c.pitch != 0.0
}

const fn has(c: &MotionCommand, flag: u32) -> bool {
    c.flags & flag != 0
}

fn int(c: &MotionCommand, name: &str) -> Option<i64> {
    let number = |n: u32, given: bool| given.then_some(i64::from(n));
    let configures = c.kind == motion_kind::CONFIGURE;
    match name {
        "joint" => number(c.index, has(c, flags::JOINT)),
        "spindle" => number(c.index, !configures || has(c, flags::SPINDLE)),
        "index" => number(c.index, true),
        "mode" => number(c.mode, true),
        "line" => number(c.line, true),
        "turns" => number(c.count, true),
        #[expect(clippy::cast_possible_truncation, reason = "only whole numbers in range pass")]
        name if setting(c) == Some(name) => Some(match c.value as i64 {
            n if n as f64 == c.value => n,
            _ => i64::MAX,
        }),
        _ => None,
    }
}

fn float(c: &MotionCommand, name: &str) -> Option<f64> {
    let vector = |[x, y, z]: [f64; 3], name: &str| match name {
        "x" => (x, 0),
        "y" => (y, 1),
        _ => (z, 2),
    };
    let given = |value: f64, given: bool| given.then_some(value);
    match name {
        "velocity" => {
            given(c.speed, c.kind == motion_kind::JOG || c.speed_kind == 2 && !is_bound(c))
        }
        "time" => given(c.speed, c.speed_kind == 3 && !is_bound(c)),
        // The target is the direction: the sign of K says nothing.
        "pitch" => given(c.pitch.abs(), is_bound(c) && !has(c, flags::VELOCITY_MODE)),
        "per-turn" => given(c.pitch, is_bound(c) && has(c, flags::VELOCITY_MODE)),
        "cam-tolerance" => given(c.cam_tolerance, c.mode == 2 && c.cam_tolerance != 0.0),
        "return" => given(c.scale, has(c, flags::HAS_SCALE) || c.scale != 0.0),
        "acceleration" => given(c.acceleration, c.acceleration != 0.0),
        "tolerance" => {
            let has_none = c.tolerance < 0.0 || c.tolerance == f64::INFINITY;
            given(c.tolerance, c.mode == 2 && !has_none)
        }
        "center-x" | "center-y" | "center-z" => {
            let (value, n) = vector(c.center, name.trim_start_matches("center-"));
            given(value, has(c, flags::CENTER_X << n))
        }
        "normal-x" | "normal-y" | "normal-z" => {
            Some(vector(c.normal, name.trim_start_matches("normal-")).0)
        }
        "speed" => given(c.speed, has(c, flags::HAS_SPEED)),
        "override" => given(c.scale, has(c, flags::HAS_SCALE)),
        "rapid-override" => given(c.value, has(c, flags::HAS_RAPID)),
        "angle" | "value" => Some(c.value),
        "distance" => given(c.value, c.extent == 1),
        "position" => given(c.value, c.extent == 2),
        name if c.kind == motion_kind::CONFIGURE => given(c.value, setting(c) == Some(name)),
        name => {
            let n = LETTERS.iter().position(|l| *l.encode_utf8(&mut [0; 4]) == *name)?;
            c.pose.get(n).copied().filter(|_| c.letters >> n & 1 == 1)
        }
    }
}

fn bit(c: &MotionCommand, name: &str) -> Option<bool> {
    let pair = |given, value| has(c, given).then_some(has(c, value));
    match name {
        "clockwise" => Some(has(c, flags::CLOCKWISE)),
        "surface" => Some(has(c, flags::SURFACE)),
        "away" => Some(has(c, flags::AWAY)),
        "optional" => Some(has(c, flags::OPTIONAL)),
        "sync" => Some(has(c, flags::SYNC)),
        "value" => Some(has(c, flags::ON)),
        "rapid" => Some(c.speed_kind == 1 && !is_bound(c)),
        "brake" => pair(flags::HAS_BRAKE, flags::BRAKE),
        "adaptive" => pair(flags::HAS_ADAPTIVE, flags::ADAPTIVE),
        "hold" => pair(flags::HAS_HOLD, flags::HOLD),
        _ => None,
    }
}

fn text(c: &MotionCommand, name: &str) -> Option<String> {
    let one_of = |names: &[&str]| {
        let name = usize::try_from(c.mode).ok().and_then(|n| names.get(n));
        Some(name.map_or_else(|| c.mode.to_string(), |n| (*n).to_owned()))
    };
    match name {
        "joint" if has(c, flags::ALL) => Some("all".to_owned()),
        "joint" => Some(c.index.to_string()),
        "axis" if has(c, flags::AXIS) => {
            let letter = usize::try_from(c.index).ok().and_then(|n| LETTERS.get(n));
            Some(letter.map_or_else(|| c.index.to_string(), ToString::to_string))
        }
        "mode" if c.kind == motion_kind::MODE => one_of(&["free", "teleop", "coord"]),
        "mode" => one_of(&["stop", "exact", "blend"]),
        _ => None,
    }
}
