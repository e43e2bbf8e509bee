//! Arguments of `motion.configure`, with their documentation.

use hal_component::{Arg, abi::ArgSpec};

pub(crate) const DOC: &str = "\
Sets the limits of a joint (joint=), an axis (axis=), a spindle (spindle=), or of coordinated moves (none of them).

A joint takes part once it was configured. What is not given stays as it is. All values are in
machine units and seconds.";

pub(crate) const ARGS: &[&ArgSpec] = &[
    &Arg::int("joint", "Number of the joint, from 0."),
    &Arg::text("axis", "Letter of the axis: x y z a b c u v w."),
    &Arg::int("spindle", "Number of the spindle, from 0."),
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
    &Arg::float(
        "max-jerk",
        "Highest jerk, in units/s³, 0 for no limit, as at first: of a joint, of an axis, or along a path in \
         x y z or u v w.",
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
    &Arg::text(
        "fault-stop",
        "How a joint ends motion when its limit switch closes, or its following error exceeds the limit: drop, as at first, \
         cuts the power at once; ramp brakes everything within the limits and then switches off, unless the error reaches \
         twice its limit.",
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
    &Arg::float(
        "min-forward-velocity",
        "Lowest speed of a spindle forward, in turns/min; at first 0.",
    ),
    &Arg::float("max-forward-velocity", "Highest speed of a spindle forward, in turns/min."),
    &Arg::float(
        "min-reverse-velocity",
        "Lowest speed in reverse, without sign; min-forward-velocity if never given.",
    ),
    &Arg::float(
        "max-reverse-velocity",
        "Highest speed in reverse, without sign; max-forward-velocity if never given.",
    ),
    &Arg::float(
        "sync-error",
        "How far the axes of a thread or tap may be from their place at a spindle, in units, above 0: \
         beyond it the path ends; at first any distance.",
    ),
    &Arg::float("max-feed-override", "Highest factor of feed override, 0 or more; at first 1."),
];

/// Arguments that apply to each kind of object.
pub(crate) const JOINT: &[&str] = &[
    "min-limit",
    "max-limit",
    "max-velocity",
    "max-acceleration",
    "max-jerk",
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
    "fault-stop",
];
pub(crate) const AXIS: &[&str] =
    &["min-limit", "max-limit", "max-velocity", "max-acceleration", "max-jerk", "offset-av-ratio"];
pub(crate) const TRAJ: &[&str] = &[
    "max-velocity",
    "max-acceleration",
    "max-jerk",
    "default-velocity",
    "linear-units",
    "max-feed-override",
];

pub(crate) const SPINDLE: &[&str] = &[
    "min-forward-velocity",
    "max-forward-velocity",
    "min-reverse-velocity",
    "max-reverse-velocity",
    "sync-error",
];
