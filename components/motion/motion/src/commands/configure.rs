//! `motion.configure`: checks the arguments and keeps the configuration.

use crate::{
    commands::command::Command,
    commands::comp_file,
    commands::config::{AxisConfig, Encoder, HomeConfig, JointConfig, TrajConfig},
    commands::interface::letter,
    compensation::{MAX_TABLES, Tables},
};
use hal_component::{Arg, Call, Error, abi::ArgSpec};
use std::collections::BTreeMap;

pub(crate) const DOC: &str = "\
Sets the limits of a joint (joint=), of an axis (axis=), or of coordinated moves (neither).

A joint takes part once it was configured. What is not given stays as it is. All values are in
machine units and seconds.";

pub(crate) const ARGS: &[&ArgSpec] = &[
    &Arg::int("joint", "Number of the joint, from 0."),
    &Arg::text("axis", "Letter of the axis: x y z a b c u v w."),
    &Arg::float("min-limit", "Lowest position of a joint or axis, in units."),
    &Arg::float("max-limit", "Highest position of a joint or axis, in units."),
    &Arg::float(
        "max-velocity",
        "Highest velocity, in units/s, above 0: of a joint (at first 1), of an axis or along a \
         path (at first whatever the joints allow).",
    ),
    &Arg::float(
        "max-acceleration",
        "Highest acceleration, in units/s², above 0: of a joint (at first 1), of an axis or along \
         a path (at first whatever the joints allow).",
    ),
    &Arg::float("ferror", "Following error of a joint allowed at max-velocity, in units."),
    &Arg::float(
        "min-ferror",
        "Following error of a joint allowed at any velocity, in units; ferror if never given.",
    ),
    &Arg::float("home", "Where a joint goes at the end of homing, in units."),
    &Arg::float(
        "home-offset",
        "What homing calls the place of the switch or index, or where a joint stands, in units; \
         with an absolute encoder what is added to its position.",
    ),
    &Arg::float(
        "home-search-vel",
        "Velocity to look for the home switch, in units/s; its sign is the direction; 0: no switch.",
    ),
    &Arg::float(
        "home-latch-vel",
        "Velocity to find the switch's edge and the index, in units/s: onto the switch when its \
         sign is that of home-search-vel, off it otherwise.",
    ),
    &Arg::float(
        "home-final-vel",
        "Velocity of the move to home, in units/s; 0 or less: max-velocity.",
    ),
    &Arg::int(
        "home-sequence",
        "When a joint is homed with all, -1000 to 1000, lowest first, at first 0; those of one \
         number below 0 are homed together, with a common final move, in the order of the number \
         without its sign.",
    ),
    &Arg::bit("home-use-index", "Home is at the encoder's index behind the switch's edge."),
    &Arg::bit(
        "home-index-no-encoder-reset",
        "The encoder goes on at its index and does not become 0.",
    ),
    &Arg::int(
        "home-absolute-encoder",
        "1: the encoder knows where it is, and homing only goes to home; 2: nor that; 0: it does \
         not.",
    ),
    &Arg::bit("home-ignore-limits", "Limit switches do not end homing, such as one that is home."),
    &Arg::bit(
        "home-is-shared",
        "Several joints have this home switch: none begins while it is closed.",
    ),
    &Arg::bit("volatile-home", "The joint is no longer homed when the machine goes off."),
    &Arg::bit(
        "locking-indexer",
        "The joint is an indexer with a lock, which homing opens and closes; it has the pins unlock \
         and is-unlocked, and does not jog.",
    ),
    &Arg::float("backlash", "Backlash of a joint, in units."),
    &Arg::text(
        "comp-file",
        "File of the screw's measured errors, which replace the backlash once the joint is homed: \
         lines of nominal position, forward, reverse; at most 256.",
    ),
    &Arg::int(
        "comp-file-type",
        "What comp-file holds after the nominal position: 0, as at first, the measured positions; \
         1 the corrections to add.",
    ),
    &Arg::float(
        "comp-av-ratio",
        "What part of a joint's velocity and acceleration the correction of backlash or screw \
         errors has, above 0, to 0.9; moves have the rest; at first 0.1 where either is given.",
    ),
    &Arg::float(
        "offset-av-ratio",
        "What part of an axis's velocity and acceleration its external offset has, 0 to 0.9; moves \
         have the rest; 0, as at first: no external offset.",
    ),
    &Arg::float(
        "default-velocity",
        "Velocity of a path when none is given, in units/s, above 0; at first 1.",
    ),
    &Arg::text("linear-units", "Machine unit: mm, inch, or how many of them a millimetre is."),
    &Arg::float("max-feed-override", "Highest factor of feed override, 0 or more; at first 1."),
];

/// Configuration so far.
#[derive(Debug)]
pub(crate) struct ConfigCache {
    joints: BTreeMap<usize, JointConfig>,
    axes: BTreeMap<usize, AxisConfig>,
    traj: TrajConfig,
    tables: Tables,
}

/// Arguments that apply to each kind of object.
const JOINT: &[&str] = &[
    "min-limit",
    "max-limit",
    "max-velocity",
    "max-acceleration",
    "ferror",
    "min-ferror",
    "home",
    "home-offset",
    "home-search-vel",
    "home-latch-vel",
    "home-final-vel",
    "home-sequence",
    "home-use-index",
    "home-index-no-encoder-reset",
    "home-absolute-encoder",
    "home-ignore-limits",
    "home-is-shared",
    "volatile-home",
    "locking-indexer",
    "backlash",
    "comp-file",
    "comp-file-type",
    "comp-av-ratio",
];
const AXIS: &[&str] =
    &["min-limit", "max-limit", "max-velocity", "max-acceleration", "offset-av-ratio"];
const TRAJ: &[&str] =
    &["max-velocity", "max-acceleration", "default-velocity", "linear-units", "max-feed-override"];

impl ConfigCache {
    /// Creates a cache that adds screw errors to these tables.
    pub(crate) fn new(tables: Tables) -> Self {
        Self { joints: BTreeMap::new(), axes: BTreeMap::new(), traj: TrajConfig::default(), tables }
    }

    /// Returns the command to send. The cache itself is unchanged, also on an error; [`Self::keep`] stores the
    /// settings.
    pub(crate) fn read(&self, call: &Call<'_>, joints: usize) -> Result<Command, Error> {
        let (joint, axis) = (call.int("joint"), call.text("axis"));
        match (joint, axis) {
            (Some(_), Some(_)) => Err(Error::new("joint= and axis= exclude each other")),
            (Some(n), None) => {
                let n = crate::commands::interface::joint(n, joints)?;
                only(call, JOINT, "joint=")?;
                self.joint(n, call)
            }
            (None, Some(text)) => {
                let n = letter(&text)?;
                only(call, AXIS, "axis=")?;
                self.axis(n, call)
            }
            (None, None) => {
                only(call, TRAJ, "a configuration without joint= and axis=")?;
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
            Command::Traj(config) => self.traj = config,
            Command::Request(..) => {}
        }
    }

    fn joint(&self, n: usize, call: &Call<'_>) -> Result<Command, Error> {
        let mut c = self.joints.get(&n).copied().unwrap_or_default();
        limit(call, "min-limit", &mut c.min_limit)?;
        limit(call, "max-limit", &mut c.max_limit)?;
        ordered(c.min_limit, c.max_limit)?;
        above(call, "max-velocity", &mut c.max_velocity)?;
        above(call, "max-acceleration", &mut c.max_acceleration)?;
        not_negative(call, "ferror", &mut c.ferror)?;
        if call.float("min-ferror").is_some() {
            let mut least = 0.0;
            not_negative(call, "min-ferror", &mut least)?;
            c.min_ferror = Some(least);
        }
        home(call, &mut c.home)?;
        finite(call, "backlash", &mut c.backlash)?;
        if call.float("comp-av-ratio").is_some() {
            let mut share = 0.0;
            let legal = |v: f64| 0.0 < v && v <= 0.9;
            take(call, "comp-av-ratio", &mut share, legal, "above 0, and at most 0.9")?;
            c.correction_share = Some(share);
        }
        self.screw(call, &mut c)?;
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
        let legal = |v: f64| (0.0..=0.9).contains(&v);
        take(call, "offset-av-ratio", &mut c.offset_fraction, legal, "0 to 0.9")?;
        Ok(Command::Axis(n, c))
    }

    fn traj(&self, call: &Call<'_>) -> Result<Command, Error> {
        let mut c = self.traj;
        above(call, "max-velocity", &mut c.max_velocity)?;
        above(call, "max-acceleration", &mut c.max_acceleration)?;
        above(call, "default-velocity", &mut c.default_velocity)?;
        not_negative(call, "max-feed-override", &mut c.max_feed_override)?;
        if let Some(text) = call.text("linear-units") {
            c.units_per_mm = units(&text)?;
        }
        Ok(Command::Traj(c))
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
    let all = JOINT.iter().chain(AXIS).chain(TRAJ).filter(|n| !names.contains(n));
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

fn take(
    call: &Call<'_>,
    name: &str,
    to: &mut f64,
    legal: fn(f64) -> bool,
    range: &str,
) -> Result<(), Error> {
    match call.float(name) {
        None => Ok(()),
        Some(value) if legal(value) => {
            *to = value;
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

fn above(call: &Call<'_>, name: &str, to: &mut f64) -> Result<(), Error> {
    take(call, name, to, |v| v > 0.0 && v.is_finite(), "above 0")
}

fn not_negative(call: &Call<'_>, name: &str, to: &mut f64) -> Result<(), Error> {
    take(call, name, to, |v| v >= 0.0 && v.is_finite(), "0 or more")
}

fn ordered(min: f64, max: f64) -> Result<(), Error> {
    if min <= max {
        return Ok(());
    }
    Err(Error::new(format!("min-limit {min} is above max-limit {max}")))
}
