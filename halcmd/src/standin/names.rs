//! Types and directions that names and values tell, where nothing else does.

use hal_protocol::Type;

/// Ends of the names of an output and of the input that it follows.
pub(super) const PAIRS: &[(&str, &str, bool)] = &[
    ("position-fb", "position-cmd", false),
    ("position-fb", "velocity-cmd", true),
    ("pos-fb", "pos-cmd", false),
    ("pos-fb", "vel-cmd", true),
    ("position", "position-cmd", false),
    ("position", "velocity-cmd", true),
    ("velocity-fb", "velocity-cmd", false),
    ("vel-fb", "vel-cmd", false),
    ("torque-fb", "torque-cmd", false),
    ("speed-fb", "speed-cmd", false),
    ("speed-fb", "speed-command", false),
    ("spindle-speed-fb", "speed-command", false),
    ("spindle-rpm", "speed-command", false),
    ("actual-position", "target-position", false),
    ("position-actual", "position-target", false),
    ("actual-velocity", "target-velocity", false),
    ("enabled", "enable", false),
    ("is-on", "enable", false),
    ("drive-on", "drive-enable", false),
    ("stat-op-enabled", "enable", false),
    ("spindle-on-fb", "spindle-on", false),
];

/// Returns the type of this name, as `newsig` has it.
pub(super) fn type_named(word: &str) -> Option<Type> {
    Some(match word {
        "bit" | "bool" => Type::Bit,
        "float" | "real" => Type::Float,
        "s32" | "si32" | "sint" => Type::S32,
        "u32" | "ui32" | "uint" => Type::U32,
        "s64" | "si64" => Type::S64,
        "u64" | "ui64" => Type::U64,
        _ => return None,
    })
}

/// Returns the type of a value as a script has it. Every number is one that a float takes.
pub(super) fn type_of(value: &str) -> Option<Type> {
    match value.to_ascii_lowercase().as_str() {
        "true" | "false" | "yes" | "no" | "on" | "off" => Some(Type::Bit),
        other if other.starts_with("0x") => Some(Type::U32),
        other => other.parse::<f64>().is_ok().then_some(Type::Float),
    }
}

/// Words in names of bits.
const BITS: &[&str] = &[
    "enable",
    "enabled",
    "fault",
    "reset",
    "ready",
    "on",
    "off",
    "run",
    "in",
    "in-not",
    "out",
    "input",
    "output",
    "at-speed",
    "ok",
    "alarm",
    "button",
    "led",
    "is-connected",
    "error",
    "forward",
    "reverse",
    "switch",
    "limit",
    "home",
];

/// Words in names of numbers.
const FLOATS: &[&str] = &[
    "position",
    "velocity",
    "speed",
    "pos",
    "vel",
    "fb",
    "cmd",
    "scale",
    "value",
    "current",
    "voltage",
    "volts",
    "temperature",
    "temp",
    "frequency",
    "freq",
    "rpm",
    "load",
    "power",
    "feed",
    "percent",
    "angle",
    "accel",
    "meter",
    "bar",
    "jog-scale",
];

/// Returns the type of a signal, from the names of all its pins.
pub(super) fn type_by_names(names: &[&str]) -> Type {
    let is_line = |name: &&str| {
        let last = name.rsplit('.').next().unwrap_or(name);
        let end = last.trim_end_matches(|c: char| c.is_ascii_digit());
        ["in", "in-", "in-not", "out", "out-", "input-", "output-", "din", "dout"].contains(&end)
    };
    if names.iter().any(is_line) {
        return Type::Bit;
    }
    let types: Vec<Type> = names.iter().map(|name| type_by_name(name)).collect();
    [Type::Float, Type::S32].into_iter().find(|ty| types.contains(ty)).unwrap_or(Type::Bit)
}

fn type_by_name(name: &str) -> Type {
    let last = name.rsplit('.').next().unwrap_or(name).to_ascii_lowercase();
    let has = |words: &[&str]| {
        words.iter().any(|word| last == *word || last.split(['-', '_']).any(|part| part == *word))
    };
    if last.contains("count") {
        Type::S32
    } else if has(FLOATS) && !last.contains("enable") && !last.ends_with("-on") {
        Type::Float
    } else if has(BITS) || !last.contains("slider") {
        Type::Bit
    } else {
        Type::Float
    }
}

/// Returns how much the end of a name looks like that of an output.
pub(super) fn outwards(name: &str) -> i32 {
    let last = name.rsplit('.').next().unwrap_or(name).to_ascii_lowercase();
    let ends = |words: &[&str]| words.iter().any(|word| last.ends_with(word));
    if ends(&[
        "-fb", "in-not", "fault", "at-speed", "counts", "ready", "alarm", "error", "status",
        "online",
    ]) || ["in", "position", "velocity", "x-in"].contains(&last.as_str())
        || last.starts_with("input")
        || last.contains("button")
    {
        1
    } else if ends(&[
        "-cmd", "enable", "-out", "reset", "-led", "-on", "scale", "command", "-disable",
    ]) || ["out", "value", "enable"].contains(&last.as_str())
        || last.starts_with("output")
        || last.contains("led")
    {
        -1
    } else {
        0
    }
}
