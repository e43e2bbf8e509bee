//! Replies to `get`: the machine's state as text.

use crate::{Machine, Record, session::Settings, state::Snapshots};

/// Data of a reply.
pub(crate) struct Look<'a> {
    pub(crate) settings: &'a mut Settings,
    pub(crate) machine: &'a mut dyn Machine,
}

impl Look<'_> {
    fn state(&self) -> &Snapshots {
        self.machine.state()
    }

    fn motion(&self) -> &Record {
        &self.machine.state().motion
    }

    fn task(&self) -> &Record {
        &self.machine.state().task
    }
}

/// Returns the reply without its end, or `None` for arguments that it does not have.
pub(crate) type Get = fn(&mut Look<'_>, &[&str]) -> Option<String>;

/// Number of joints and axes that replies list, at least.
const LISTED: usize = 6;
/// Letters of the axes, in the order of poses.
pub(crate) const AXES: &str = "XYZABCUVW";
/// Number of the unit that G20 and G21 stand for in the codes in force, times ten.
const INCH: u32 = 200;

fn on_off(name: &str, on: bool) -> Option<String> {
    Some(format!("{name} {}", if on { "ON" } else { "OFF" }))
}

macro_rules! simple {
    ($($name:ident: |$look:ident| $value:expr;)*) => {$(
        pub(crate) fn $name($look: &mut Look<'_>, _: &[&str]) -> Option<String> {
            $value
        }
    )*};
}

simple! {
    angular_conversion: |look| Some(format!("ANGULAR_UNIT_CONVERSION {}", look.settings.angular));
    linear_conversion: |look| Some(format!("LINEAR_UNIT_CONVERSION {}", look.settings.linear));
    comm_mode: |look| Some(format!("COMM_MODE {}", if look.settings.binary { "BINARY" } else { "ASCII" }));
    comm_prot: |_look| Some("COMM_PROT 1.0".to_owned());
    config: |_look| Some("CONFIG".to_owned());
    debug: |look| Some(format!("DEBUG {}", look.state().facts.ini.get("EMC", "DEBUG").map_or("0", str::trim)));
    display_angular: |look| {
        let unit = look.settings.angular;
        let unit = if unit == "AUTO" { "DEG" } else { unit };
        Some(format!("DISPLAY_ANGULAR_UNITS {unit}"))
    };
    display_linear: |look| {
        let unit = look.settings.linear;
        let unit = if unit == "AUTO" { program_unit(look.task()) } else { unit };
        Some(format!("DISPLAY_LINEAR_UNITS {unit}"))
    };
    echo: |look| on_off("ECHO", look.settings.echo);
    verbose: |look| on_off("VERBOSE", look.settings.verbose);
    enable: |look| on_off("ENABLE", look.machine.has_control());
    error: |look| Some(format!("ERROR {}", look.settings.errors.pop_front().unwrap_or_else(|| "OK".to_owned())));
    operator_display: |look| {
        let text = look.settings.messages.pop_front().unwrap_or_else(|| "OK".to_owned());
        Some(format!("OPERATOR_DISPLAY {text}"))
    };
    operator_text: |_look| Some("OPERATOR_TEXT OK".to_owned());
    estop: |look| on_off("ESTOP", look.state().is_estop());
    machine: |look| on_off("MACHINE", look.task().count("state", 0) == 2);
    feed_override: |look| Some(format!("FEED_OVERRIDE {:.0}", look.task().number("feed_override", 0) * 100.0));
    flood: |look| on_off("FLOOD", look.task().bit("flood", 0));
    mist: |look| on_off("MIST", look.task().bit("mist", 0));
    lube: |look| on_off("LUBE", look.task().bit("lube", 0));
    lube_level: |look| {
        let is_full = look.task().bit("lube_level", 0);
        Some(format!("LUBE_LEVEL {}", if is_full { "OK" } else { "LOW" }))
    };
    inifile: |look| Some(format!("INIFILE {}", look.state().facts.path));
    kinematics_type: |look| Some(format!("KINEMATICS_TYPE {}", look.state().facts.kinematics));
    mode: |look| {
        let mode = match look.task().count("mode", 0) { 0 => "MANUAL", 1 => "AUTO", _ => "MDI" };
        Some(format!("MODE {mode}"))
    };
    optional_stop: |look| Some(format!("OPTIONAL_STOP {}", u8::from(look.task().bit("optional_stop", 0))));
    override_limits: |look| Some(format!("OVERRIDE_LIMITS {}", u8::from(look.motion().bit("overriding_limits", 0))));
    plat: |_look| Some("PLAT Linux".to_owned());
    probe_tripped: |look| Some(format!("PROBE_TRIPPED {}", u8::from(look.motion().bit("probe_found", 0))));
    probe_value: |look| Some(format!("PROBE_VALUE {}", u8::from(look.motion().bit("probe_input", 0))));
    program: |look| {
        let file = look.task().text("file");
        let name = file.rsplit('/').next().unwrap_or_default();
        Some(format!("PROGRAM {}", if name.is_empty() { "NONE" } else { name }))
    };
    program_angular: |_look| Some("PROGRAM_ANGULAR_UNITS DEG".to_owned());
    program_units: |look| Some(format!("PROGRAM_UNITS {}", program_unit(look.task())));
    program_line: |look| Some(format!("PROGRAM_LINE {}", look.motion().count("line", 0)));
    program_status: |look| {
        let status = match look.task().count("interpreter", 0) { 0 => "IDLE", 2 => "PAUSED", _ => "RUNNING" };
        Some(format!("PROGRAM_STATUS {status}"))
    };
    program_codes: |look| Some(codes(look.task()));
    set_wait: |look| Some(format!("SET_WAIT {}", if look.settings.waits { "DONE" } else { "RECEIVED" }));
    teleop_enable: |look| {
        let on = look.state().is_teleop();
        Some(format!("TELEOP_ENABLE {}", if on { "YES" } else { "NO" }))
    };
    time: |look| Some(format!("TIME {:.6}", look.machine.time()));
    timeout: |look| Some(format!("SET_TIMEOUT {:.6}", look.settings.timeout));
    tool: |look| Some(format!("TOOL {}", look.task().number("tool", 0)));
    tool_offset: |look| Some(format!("TOOL_OFFSET {:.6}", look.task().number("tool_offset", 2)));
    update: |look| Some(format!("UPDATE {}", if look.settings.fresh { "AUTO" } else { "NONE" }));
    user_angular: |look| Some(format!("USER_ANGULAR_UNITS {}", angular_unit(look.state().facts.angular)));
    user_linear: |look| Some(format!("USER_LINEAR_UNITS {}", linear_unit(look.state())));
}

macro_rules! poses {
    ($($name:ident $text:literal $field:literal $relative:literal;)*) => {$(
        pub(crate) fn $name(look: &mut Look<'_>, args: &[&str]) -> Option<String> {
            pose(look, args, $text, $field, $relative)
        }
    )*};
}

poses! {
    abs_act_pos "ABS_ACT_POS" "pose_feedback" false;
    abs_cmd_pos "ABS_CMD_POS" "pose" false;
    rel_act_pos "REL_ACT_POS" "pose_feedback" true;
    rel_cmd_pos "REL_CMD_POS" "pose" true;
}

fn program_unit(task: &Record) -> &'static str {
    if task.count("g_codes", 2) == INCH { "INCH" } else { "MM" }
}

/// Returns the name of the machine's unit of length.
fn linear_unit(state: &Snapshots) -> &'static str {
    if state.facts.is_inch { "INCH" } else { "MM" }
}

/// Returns the name of a unit of angles: `value` of it make a degree.
fn angular_unit(value: f64) -> &'static str {
    let is = |other: f64| (value - other).abs() < 1e-3 * other;
    if is(1.0) {
        "DEG"
    } else if is(core::f64::consts::PI / 180.0) {
        "RAD"
    } else if is(10.0 / 9.0) {
        "GRAD"
    } else {
        "CUSTOM"
    }
}

/// Returns the offset of an axis: coordinate system, G92 and tool.
fn offset(task: &Record, n: usize) -> f64 {
    ["g5x_offset", "g92_offset", "tool_offset"].iter().map(|name| task.number(name, n)).sum()
}

/// Returns the codes in force, in the order of LinuxCNC's reply.
fn codes(task: &Record) -> String {
    let mut text = String::from("PROGRAM_CODES");
    // Motion, plane, side, unit, distance, feed, origin, tool, retract, path, css, arcs, diameter.
    for n in [0, 1, 3, 2, 8, 10, 5, 4, 12, 6, 11, 9, 7] {
        let code = task.count("g_codes", n);
        let (whole, tenth) = (code / 10, code % 10);
        text.push_str(&format!(" G{whole}"));
        if tenth != 0 {
            text.push_str(&format!(".{tenth}"));
        }
    }
    let (feed, speed) = (task.number("feed", 0), task.number("speed", 0).abs());
    text.push_str(&format!(" G92.2 F{feed} S{speed}"));
    text
}

/// Returns a list of values for all, or the value for the one that the argument names.
fn listed<T: core::fmt::Display>(
    args: &[&str],
    name: &str,
    count: usize,
    index: impl Fn(&str) -> Option<usize>,
    value: impl Fn(usize) -> T,
) -> Option<String> {
    let mut text = name.to_owned();
    match args.first() {
        None => (0..count).for_each(|n| text.push_str(&format!(" {}", value(n)))),
        Some(word) => {
            let n = index(word).filter(|n| *n < count)?;
            text.push_str(&format!(" {n} {}", value(n)));
        }
    }
    Some(text)
}

/// Returns the index of an axis, by its letter or number.
pub(crate) fn axis(word: &str) -> Option<usize> {
    let letter = AXES.chars().position(|letter| word.eq_ignore_ascii_case(&letter.to_string()));
    letter.or_else(|| word.parse().ok())
}

/// Returns the position of the axes, or of one of them; a relative one is that in the program's coordinates.
fn pose(look: &Look<'_>, args: &[&str], name: &str, field: &str, relative: bool) -> Option<String> {
    let (motion, task) = (look.motion(), look.task());
    let count = if args.is_empty() { LISTED } else { AXES.len() };
    let origin = |n| if relative { offset(task, n) } else { 0.0 };
    listed(args, name, count, axis, |n| format!("{:.6}", motion.number(field, n) - origin(n)))
}

pub(crate) fn pos_offset(look: &mut Look<'_>, args: &[&str]) -> Option<String> {
    let task = look.task();
    let value = |n: usize| task.number("g5x_offset", n) + task.number("g92_offset", n);
    let mut text = "POS_OFFSET".to_owned();
    match args.first() {
        None => (0..LISTED).for_each(|n| text.push_str(&format!(" {:.6}", value(n)))),
        Some(word) => {
            let n = axis(word).filter(|n| *n < AXES.len())?;
            text.push_str(&format!(" {}  {:.6}", word.to_uppercase(), value(n)));
        }
    }
    Some(text)
}

/// Returns values of joints: at least six, as LinuxCNC.
fn joints<T: core::fmt::Display>(
    look: &Look<'_>,
    args: &[&str],
    name: &str,
    value: impl Fn(&Snapshots, usize) -> T,
) -> Option<String> {
    let count = (look.motion().count("joints", 0) as usize).max(LISTED);
    let state = look.state();
    listed(args, name, count, |word| word.parse().ok(), |n| value(state, n))
}

pub(crate) fn joint_pos(look: &mut Look<'_>, args: &[&str]) -> Option<String> {
    let position = |s: &Snapshots, n| format!("{:.6}", s.motion.number("joint_feedback", n));
    joints(look, args, "JOINT_POS", position)
}

pub(crate) fn joint_homed(look: &mut Look<'_>, args: &[&str]) -> Option<String> {
    joints(
        look,
        args,
        "JOINT_HOMED",
        |s, n| {
            if s.motion.bit("joint_homed", n) { "YES" } else { "NO" }
        },
    )
}

pub(crate) fn joint_fault(look: &mut Look<'_>, args: &[&str]) -> Option<String> {
    joints(look, args, "JOINT_FAULT", |s, n| {
        let fault = s.motion.bit("joint_fault", n) || s.motion.bit("joint_error", n);
        if fault { "FAULT" } else { "OK" }
    })
}

pub(crate) fn joint_limit(look: &mut Look<'_>, args: &[&str]) -> Option<String> {
    joints(look, args, "JOINT_LIMIT", |s, n| {
        let motion = &s.motion;
        if motion.bit("joint_at_min", n) {
            "MINHARD"
        } else if motion.bit("joint_at_max", n) {
            "MAXHARD"
        } else if motion.has("joints_below", n) {
            "MINSOFT"
        } else if motion.has("joints_above", n) {
            "MAXSOFT"
        } else {
            "OK"
        }
    })
}

fn turns(state: &Snapshots, n: usize) -> bool {
    state.facts.turns.get(n).copied().unwrap_or(false)
}

pub(crate) fn joint_type(look: &mut Look<'_>, args: &[&str]) -> Option<String> {
    // LinuxCNC puts two spaces before the kind of one joint.
    let space = if args.is_empty() { "" } else { " " };
    joints(look, args, "JOINT_TYPE", |s, n| {
        format!("{space}{}", if turns(s, n) { "ANGULAR" } else { "LINEAR" })
    })
}

pub(crate) fn joint_units(look: &mut Look<'_>, args: &[&str]) -> Option<String> {
    joints(look, args, "JOINT_UNITS", |s, n| {
        if turns(s, n) { angular_unit(s.facts.angular) } else { linear_unit(s) }
    })
}

/// Returns the number of the spindle that the arguments name, or 0.
pub(crate) fn spindle_of(look: &Look<'_>, word: Option<&&str>) -> Option<usize> {
    let n = word.map_or(Some(0), |word| word.parse().ok())?;
    (n < look.motion().count("spindles", 0) as usize).then_some(n)
}

pub(crate) fn spindle(look: &mut Look<'_>, args: &[&str]) -> Option<String> {
    let n = spindle_of(look, args.first())?;
    let speed = look.motion().number("spindle_speed", n);
    let turning = if speed > 0.0 {
        "FORWARD"
    } else if speed < 0.0 {
        "REVERSE"
    } else {
        "OFF"
    };
    Some(format!("SPINDLE {n} {turning}"))
}

pub(crate) fn brake(look: &mut Look<'_>, args: &[&str]) -> Option<String> {
    let n = spindle_of(look, args.first())?;
    on_off("BRAKE", look.motion().bit("spindle_brake", n))
}

pub(crate) fn spindle_override(look: &mut Look<'_>, args: &[&str]) -> Option<String> {
    let n = spindle_of(look, args.first())?;
    let percent = look.task().number("spindle_override", n) * 100.0;
    Some(format!("SPINDLE_OVERRIDE {n} {percent:.0}"))
}

pub(crate) fn ini(look: &mut Look<'_>, args: &[&str]) -> Option<String> {
    let [name, section] = args else { return None };
    let value = look.state().facts.ini.get(section, name)?;
    Some(format!("INI {value}"))
}
