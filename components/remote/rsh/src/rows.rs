//! The table of subcommands: what `get` and `set` know, and what `help` lists.

use crate::{get, get::Get, set, set::Set};

/// Condition under which a subcommand of `set` is executed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Needs {
    /// A successful hello.
    Hello,
    /// Control.
    Control,
}

/// Arguments with which a subcommand of `set` ends motion: it needs no control then.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Stops {
    /// None.
    Never,
    /// All.
    Always,
    /// This one, in lower case.
    With(&'static str),
}

/// A subcommand.
pub(crate) struct Subcommand {
    /// Name, in upper case.
    pub(crate) name: &'static str,
    /// Reply to `get`.
    pub(crate) get: Option<Get>,
    /// Effect of `set`.
    pub(crate) set: Option<(Needs, Set)>,
    /// Arguments of `set`, for its help.
    pub(crate) args: &'static str,
    /// Arguments with which it ends motion.
    pub(crate) stops: Stops,
}

impl Subcommand {
    const fn stops(self, stops: Stops) -> Self {
        Self { stops, ..self }
    }
}

const fn get(name: &'static str, get: Get) -> Subcommand {
    Subcommand { name, get: Some(get), set: None, args: "", stops: Stops::Never }
}

const fn set(name: &'static str, args: &'static str, set: Set) -> Subcommand {
    Subcommand { name, get: None, set: Some((Needs::Control, set)), args, stops: Stops::Never }
}

const fn both(name: &'static str, args: &'static str, get: Get, set: Set) -> Subcommand {
    Subcommand { name, get: Some(get), set: Some((Needs::Control, set)), args, stops: Stops::Never }
}

const fn free(name: &'static str, args: &'static str, get: Get, set: Set) -> Subcommand {
    Subcommand { name, get: Some(get), set: Some((Needs::Hello, set)), args, stops: Stops::Never }
}

/// All subcommands.
pub(crate) const ROWS: &[Subcommand] = &[
    set("ABORT", "", set::abort).stops(Stops::Always),
    get("ABS_ACT_POS", get::abs_act_pos),
    get("ABS_CMD_POS", get::abs_cmd_pos),
    both(
        "ANGULAR_UNIT_CONVERSION",
        "<deg | rad | grad | auto | custom>",
        get::angular_conversion,
        set::angular_conversion,
    ),
    both("BRAKE", "<on | off> [spindle]", get::brake, set::brake),
    free("COMM_MODE", "<ascii | binary>", get::comm_mode, set::comm_mode),
    free("COMM_PROT", "<version>", get::comm_prot, set::never),
    both("CONFIG", "", get::config, set::nothing),
    both("DEBUG", "<level>", get::debug, set::never),
    get("DISPLAY_ANGULAR_UNITS", get::display_angular),
    get("DISPLAY_LINEAR_UNITS", get::display_linear),
    free("ECHO", "<on | off>", get::echo, set::echo),
    free("ENABLE", "<password | off>", get::enable, set::enable),
    get("ERROR", get::error),
    both("ESTOP", "<on | off>", get::estop, set::estop).stops(Stops::With("on")),
    both("FEED_OVERRIDE", "<percent>", get::feed_override, set::feed_override),
    both("FLOOD", "<on | off>", get::flood, set::flood),
    set("HOME", "<joint | -1>", set::home),
    both("INI", "<name> <section>", get::ini, set::nothing),
    both("INIFILE", "", get::inifile, set::nothing),
    set("JOG", "<joint | axis> <speed>", set::jog),
    set("JOG_INCR", "<joint | axis> <speed> <distance>", set::jog_incr),
    set("JOG_STOP", "<joint | axis>", set::jog_stop).stops(Stops::Always),
    get("JOINT_FAULT", get::joint_fault),
    get("JOINT_HOMED", get::joint_homed),
    get("JOINT_LIMIT", get::joint_limit),
    get("JOINT_POS", get::joint_pos),
    get("JOINT_TYPE", get::joint_type),
    get("JOINT_UNITS", get::joint_units),
    get("KINEMATICS_TYPE", get::kinematics_type),
    both(
        "LINEAR_UNIT_CONVERSION",
        "<inch | mm | cm | auto | custom>",
        get::linear_conversion,
        set::linear_conversion,
    ),
    set("LOAD_TOOL_TABLE", "<file>", set::load_tool_table),
    both("LUBE", "<on | off>", get::lube, set::lube),
    get("LUBE_LEVEL", get::lube_level),
    both("MACHINE", "<on | off>", get::machine, set::machine).stops(Stops::With("off")),
    set("MDI", "<text>", set::mdi),
    both("MIST", "<on | off>", get::mist, set::mist),
    both("MODE", "<manual | auto | mdi>", get::mode, set::mode),
    set("OPEN", "<file>", set::open),
    get("OPERATOR_DISPLAY", get::operator_display),
    get("OPERATOR_TEXT", get::operator_text),
    both("OPTIONAL_STOP", "<0 | 1>", get::optional_stop, set::optional_stop),
    both("OVERRIDE_LIMITS", "<on | off>", get::override_limits, set::override_limits),
    set("PAUSE", "", set::pause).stops(Stops::Always),
    both("PLAT", "", get::plat, set::nothing),
    get("POS_OFFSET", get::pos_offset),
    set("PROBE", "<x> <y> <z>", set::probe),
    set("PROBE_CLEAR", "", set::probe_clear),
    get("PROBE_TRIPPED", get::probe_tripped),
    get("PROBE_VALUE", get::probe_value),
    get("PROGRAM", get::program),
    get("PROGRAM_ANGULAR_UNITS", get::program_angular),
    get("PROGRAM_CODES", get::program_codes),
    get("PROGRAM_LINE", get::program_line),
    get("PROGRAM_LINEAR_UNITS", get::program_units),
    get("PROGRAM_STATUS", get::program_status),
    get("PROGRAM_UNITS", get::program_units),
    get("REL_ACT_POS", get::rel_act_pos),
    get("REL_CMD_POS", get::rel_cmd_pos),
    set("RESUME", "", set::resume),
    set("RUN", "[line]", set::run),
    both("SET_TIMEOUT", "<seconds>", get::timeout, set::timeout),
    both("SET_WAIT", "<received | done>", get::set_wait, set::set_wait),
    both(
        "SPINDLE",
        "<forward | reverse | increase | decrease | constant | off> [spindle]",
        get::spindle,
        set::spindle,
    ),
    both("SPINDLE_OVERRIDE", "[spindle] <percent>", get::spindle_override, set::spindle_override),
    set("STEP", "", set::step),
    // The interpreter starts each job from the place where the machine is.
    set("TASK_PLAN_INIT", "", set::nothing),
    both("TELEOP_ENABLE", "<on | off>", get::teleop_enable, set::teleop_enable),
    get("TIME", get::time),
    both("TIMEOUT", "<seconds>", get::timeout, set::timeout),
    get("TOOL", get::tool),
    get("TOOL_OFFSET", get::tool_offset),
    both("UPDATE", "<none | auto>", get::update, set::update),
    get("USER_ANGULAR_UNITS", get::user_angular),
    get("USER_LINEAR_UNITS", get::user_linear),
    free("VERBOSE", "<on | off>", get::verbose, set::verbose),
    set("WAIT", "<received | done>", set::wait),
];

/// Returns the subcommand of this name, in any case.
pub(crate) fn find(name: &str) -> Option<&'static Subcommand> {
    ROWS.iter().find(|row| row.name.eq_ignore_ascii_case(name))
}

/// Returns whether a subcommand of `set` with this argument ends motion.
pub(crate) fn stops(name: &str, word: &str) -> bool {
    find(name).is_some_and(|row| match row.stops {
        Stops::Never => false,
        Stops::Always => true,
        Stops::With(other) => word.eq_ignore_ascii_case(other),
    })
}
