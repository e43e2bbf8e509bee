//! `motion.configure`: checks the arguments and keeps the configuration.

use crate::{
    commands::arguments::{AXIS, JOINT, SPINDLE, TRAJ},
    commands::call::Call,
    commands::command::Command,
    commands::comp_file,
    commands::config::{AxisConfig, Encoder, HomeConfig, JointConfig, SpindleConfig, TrajConfig},
    commands::interface::letter,
    compensation::{MAX_TABLES, Tables},
};
use hal_component::Error;
use hal_safety::Reaction;
use std::collections::BTreeMap;

/// Configuration so far.
#[derive(Debug)]
pub(crate) struct ConfigCache {
    joints: BTreeMap<usize, JointConfig>,
    axes: BTreeMap<usize, AxisConfig>,
    spindles: BTreeMap<usize, SpindleConfig>,
    traj: TrajConfig,
    tables: Tables,
}

impl ConfigCache {
    /// Creates a cache that adds screw errors to these tables.
    pub(crate) fn new(tables: Tables) -> Self {
        Self {
            joints: BTreeMap::new(),
            axes: BTreeMap::new(),
            spindles: BTreeMap::new(),
            traj: TrajConfig::default(),
            tables,
        }
    }

    /// Returns the command to send. The cache itself is unchanged, also on an error; [`Self::keep`] stores the
    /// settings.
    pub(crate) fn read(
        &self,
        call: &Call<'_>,
        joints: usize,
        spindles: usize,
    ) -> Result<Command, Error> {
        match Target::of(call, joints, spindles)? {
            Target::Spindle(n) => {
                only(call, SPINDLE, "spindle=")?;
                self.spindle(n, call)
            }
            Target::Joint(n) => {
                only(call, JOINT, "joint=")?;
                self.joint(n, call)
            }
            Target::Axis(n) => {
                only(call, AXIS, "axis=")?;
                self.axis(n, call)
            }
            Target::Traj => {
                only(call, TRAJ, "a configuration without joint=, axis= and spindle=")?;
                self.traj(call)
            }
        }
    }

    pub(crate) fn keep(&mut self, command: &Command) {
        match *command {
            Command::Joint(n, config) => {
                self.joints.insert(n, config);
            }
            Command::Axis(n, config) => {
                self.axes.insert(n, config);
            }
            Command::Spindle(n, config) => {
                self.spindles.insert(n, config);
            }
            Command::Traj(config) => self.traj = config,
            Command::Request(..) => {}
        }
    }

    /// Returns a setting by the name of its argument.
    pub(crate) fn setting(&self, target: Target, name: &str) -> Option<f64> {
        match target {
            Target::Joint(n) => self.joints.get(&n).copied().unwrap_or_default().setting(name),
            Target::Axis(n) => self.axes.get(&n).copied().unwrap_or_default().setting(name),
            Target::Spindle(n) => self.spindles.get(&n).copied().unwrap_or_default().setting(name),
            Target::Traj => self.traj.setting(name),
        }
    }

    fn joint(&self, n: usize, call: &Call<'_>) -> Result<Command, Error> {
        let mut c = self.joints.get(&n).copied().unwrap_or_default();
        limit(call, "min-limit", &mut c.min_limit)?;
        limit(call, "max-limit", &mut c.max_limit)?;
        ordered(c.min_limit, c.max_limit)?;
        above(call, "max-velocity", &mut c.max_velocity)?;
        above(call, "max-acceleration", &mut c.max_acceleration)?;
        jerk(call, &mut c.max_jerk)?;
        not_negative(call, "ferror", &mut c.ferror)?;
        not_negative(call, "min-ferror", &mut c.min_ferror)?;
        home(call, &mut c.home)?;
        finite(call, "backlash", &mut c.backlash)?;
        let legal = |v: f64| 0.0 < v && v <= 0.9;
        let range = "above 0, and at most 0.9";
        take(call, "comp-av-ratio", &mut c.correction_share, legal, range)?;
        self.screw(call, &mut c)?;
        if let Some(text) = call.text("fault-stop") {
            c.fault_stop = match text.to_ascii_lowercase().as_str() {
                "drop" => Reaction::Drop,
                "ramp" => Reaction::Ramp,
                _ => {
                    return Err(Error::new(format!(
                        "fault-stop is '{text}', must be drop or ramp"
                    )));
                }
            };
        }
        Ok(Command::Joint(n, c))
    }

    /// Reads the file of screw errors, if one is given; an empty name removes the table.
    fn screw(&self, call: &Call<'_>, c: &mut JointConfig) -> Result<(), Error> {
        let holds_corrections = match call.int("comp-file-type") {
            None | Some(0) => false,
            Some(1) => true,
            Some(n) => return Err(Error::new(format!("comp-file-type is {n}, must be 0 or 1"))),
        };
        match call.text("comp-file").as_deref() {
            None => {}
            Some("") => c.table = None,
            Some(path) => {
                let table = comp_file::read(path, holds_corrections)?;
                let place = self.tables.place(&table);
                c.table = Some(place.ok_or_else(|| {
                    Error::new(format!("more than {MAX_TABLES} different files of screw errors"))
                })?);
            }
        }
        Ok(())
    }

    fn axis(&self, n: usize, call: &Call<'_>) -> Result<Command, Error> {
        let mut c = self.axes.get(&n).copied().unwrap_or_default();
        limit(call, "min-limit", &mut c.min_limit)?;
        limit(call, "max-limit", &mut c.max_limit)?;
        ordered(c.min_limit, c.max_limit)?;
        above(call, "max-velocity", &mut c.max_velocity)?;
        above(call, "max-acceleration", &mut c.max_acceleration)?;
        jerk(call, &mut c.max_jerk)?;
        let legal = |v: f64| (0.0..=0.9).contains(&v);
        take(call, "offset-av-ratio", &mut c.offset_fraction, legal, "0 to 0.9")?;
        Ok(Command::Axis(n, c))
    }

    fn spindle(&self, n: usize, call: &Call<'_>) -> Result<Command, Error> {
        let mut c = self.spindles.get(&n).copied().unwrap_or_default();
        not_negative(call, "min-forward-velocity", &mut c.min_forward)?;
        not_negative(call, "max-forward-velocity", &mut c.max_forward)?;
        not_negative(call, "min-reverse-velocity", &mut c.min_reverse)?;
        not_negative(call, "max-reverse-velocity", &mut c.max_reverse)?;
        above(call, "sync-error", &mut c.sync_error)?;
        for (forward, way) in [(true, "forward"), (false, "reverse")] {
            let (min, max) = c.limits(forward);
            if min > max {
                return Err(Error::new(format!(
                    "min-{way}-velocity {min} is above max-{way}-velocity {max}"
                )));
            }
        }
        Ok(Command::Spindle(n, c))
    }

    fn traj(&self, call: &Call<'_>) -> Result<Command, Error> {
        let mut c = self.traj;
        above(call, "max-velocity", &mut c.max_velocity)?;
        above(call, "max-acceleration", &mut c.max_acceleration)?;
        jerk(call, &mut c.max_jerk)?;
        above(call, "default-velocity", &mut c.default_velocity)?;
        not_negative(call, "max-feed-override", &mut c.max_feed_override)?;
        if let Some(text) = call.text("linear-units") {
            c.units_per_mm = units(&text)?;
        }
        Ok(Command::Traj(c))
    }
}

/// The object that a configuration changes.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Target {
    Joint(usize),
    Axis(usize),
    Spindle(usize),
    /// Coordinated moves.
    Traj,
}

impl Target {
    pub(crate) fn of(call: &Call<'_>, joints: usize, spindles: usize) -> Result<Self, Error> {
        match (call.int("joint"), call.text("axis"), call.int("spindle")) {
            (Some(_), Some(_), _) => Err(Error::new("joint= and axis= exclude each other")),
            (Some(_), _, Some(_)) => Err(Error::new("joint= and spindle= exclude each other")),
            (_, Some(_), Some(_)) => Err(Error::new("axis= and spindle= exclude each other")),
            (None, None, Some(n)) => {
                usize::try_from(n).ok().filter(|n| *n < spindles).map(Self::Spindle).ok_or_else(
                    || Error::new(format!("there is no spindle {n}, the machine has {spindles}")),
                )
            }
            (Some(n), None, None) => crate::commands::interface::joint(n, joints).map(Self::Joint),
            (None, Some(text), None) => letter(&text).map(Self::Axis),
            (None, None, None) => Ok(Self::Traj),
        }
    }
}

fn home(call: &Call<'_>, c: &mut HomeConfig) -> Result<(), Error> {
    finite(call, "home", &mut c.place)?;
    finite(call, "home-offset", &mut c.offset)?;
    finite(call, "home-search-vel", &mut c.search_vel)?;
    finite(call, "home-latch-vel", &mut c.latch_vel)?;
    finite(call, "home-final-vel", &mut c.final_vel)?;
    if let Some(n) = call.int("home-sequence") {
        c.sequence = i32::try_from(n)
            .ok()
            .filter(|n| (-1000..=1000).contains(n))
            .ok_or_else(|| Error::new(format!("home-sequence is {n}, must be -1000 to 1000")))?;
    }
    let no_reset = call.bit("home-index-no-encoder-reset");
    c.encoder = match (call.int("home-absolute-encoder"), no_reset) {
        (None, None) => c.encoder,
        (None | Some(0), Some(true)) => Encoder::Goes,
        (None, Some(false)) | (Some(0), _) => Encoder::Resets,
        (Some(1), _) => Encoder::Absolute,
        (Some(2), _) => Encoder::AbsoluteStill,
        (Some(n), _) => {
            return Err(Error::new(format!("home-absolute-encoder is {n}, must be 0, 1 or 2")));
        }
    };
    for (name, to) in [
        ("home-use-index", &mut c.use_index),
        ("home-ignore-limits", &mut c.ignore_limits),
        ("home-is-shared", &mut c.is_shared),
        ("volatile-home", &mut c.is_volatile),
        ("locking-indexer", &mut c.is_locking),
    ] {
        *to = call.bit(name).unwrap_or(*to);
    }
    Ok(())
}

/// Refuses arguments that belong to another kind of object.
fn only(call: &Call<'_>, names: &[&str], what: &str) -> Result<(), Error> {
    let all = JOINT.iter().chain(AXIS).chain(TRAJ).chain(SPINDLE).filter(|n| !names.contains(n));
    for name in all {
        // A number or a text, depending on its declaration.
        if call.float(name).is_some() {
            return Err(Error::new(format!("{name}= does not belong to {what}")));
        }
    }
    Ok(())
}

fn units(text: &str) -> Result<f64, Error> {
    match text.to_ascii_lowercase().as_str() {
        "mm" | "metric" => Ok(1.0),
        "in" | "inch" | "imperial" => Ok(1.0 / 25.4),
        number => match number.parse() {
            Ok(n) if n > 0.0 && f64::is_finite(n) => Ok(n),
            _ => Err(Error::new(format!(
                "linear-units '{text}' is none of mm, inch, and a number of units per millimetre"
            ))),
        },
    }
}

/// Reads an argument, if it is given, into a setting: a number, or one that is unset at first.
fn take(
    call: &Call<'_>,
    name: &str,
    to: &mut impl From<f64>,
    legal: fn(f64) -> bool,
    range: &str,
) -> Result<(), Error> {
    match call.float(name) {
        None => Ok(()),
        Some(value) if legal(value) => {
            *to = value.into();
            Ok(())
        }
        Some(value) => Err(Error::new(format!("{name} is {value}, must be {range}"))),
    }
}

fn limit(call: &Call<'_>, name: &str, to: &mut f64) -> Result<(), Error> {
    take(call, name, to, |v| !v.is_nan(), "a number")
}

fn finite(call: &Call<'_>, name: &str, to: &mut f64) -> Result<(), Error> {
    take(call, name, to, f64::is_finite, "a finite number")
}

/// Reads a jerk limit; 0 is no limit.
fn jerk(call: &Call<'_>, to: &mut f64) -> Result<(), Error> {
    not_negative(call, "max-jerk", to)?;
    *to = if *to > 0.0 { *to } else { f64::INFINITY };
    Ok(())
}

fn above(call: &Call<'_>, name: &str, to: &mut f64) -> Result<(), Error> {
    take(call, name, to, |v| v > 0.0 && v.is_finite(), "above 0")
}

fn not_negative(call: &Call<'_>, name: &str, to: &mut impl From<f64>) -> Result<(), Error> {
    take(call, name, to, |v| v >= 0.0 && v.is_finite(), "0 or more")
}

fn ordered(min: f64, max: f64) -> Result<(), Error> {
    if min <= max {
        return Ok(());
    }
    Err(Error::new(format!("min-limit {min} is above max-limit {max}")))
}
