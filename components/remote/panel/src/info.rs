//! Description of the machine for the page, from its INI file.

use hal_ini::Ini;
use serde_json::{Map, Value as Json, json};

/// Sections that the page gets as they are.
const SECTIONS: &[&str] = &["DISPLAY", "EMC", "TRAJ", "KINS"];
/// Largest number of joints.
const MAX_JOINTS: usize = 16;

/// Returns the description of the machine.
pub(crate) fn info(instance: &str, ini: Option<&Ini>, is_inch: bool) -> Map<String, Json> {
    let get = |section: &str, name: &str| ini.and_then(|ini| ini.get(section, name));
    let number = |section: &str, name: &str| get(section, name).and_then(|t| t.parse::<f64>().ok());
    let letters = get("TRAJ", "COORDINATES").unwrap_or_default().to_uppercase();
    let letters: String = letters.chars().filter(|c| "XYZABCUVW".contains(*c)).collect();
    let limits = |section: &str, kind: &str, name: Json| {
        json!({
            kind: name,
            "type": get(section, "TYPE"),
            "min": number(section, "MIN_LIMIT"),
            "max": number(section, "MAX_LIMIT"),
            "velocity": number(section, "MAX_VELOCITY"),
            "acceleration": number(section, "MAX_ACCELERATION"),
        })
    };
    let old = ini.is_some_and(Ini::is_old);
    let axes = letters.chars().map(|letter| {
        let n = "XYZABCUVW".find(letter).unwrap_or_default();
        let section = if old { format!("AXIS_{n}") } else { format!("AXIS_{letter}") };
        limits(&section, "axis", letter.to_string().into())
    });
    let axes: Vec<Json> = axes.collect();
    let count = number("KINS", "JOINTS").or_else(|| number("TRAJ", "AXES")).unwrap_or(0.0);
    let joints = (0..MAX_JOINTS).take_while(|n| (*n as f64) < count).map(|n| {
        let section = if old { format!("AXIS_{n}") } else { format!("JOINT_{n}") };
        limits(&section, "joint", n.into())
    });
    let joints: Vec<Json> = joints.collect();
    let increments = get("DISPLAY", "INCREMENTS").unwrap_or_default();
    let increments: Vec<&str> =
        increments.split([',', ' ', '\t']).filter(|w| !w.is_empty()).collect();
    let sections = SECTIONS.iter().map(|section| {
        let entries = ini.into_iter().flat_map(|ini| ini.section(section));
        let entries = entries.map(|e| (e.name.clone(), Json::from(e.value.clone())));
        ((*section).to_owned(), Json::Object(entries.collect()))
    });
    let info = json!({
        "api": 1,
        "instance": instance,
        "version": env!("CARGO_PKG_VERSION"),
        "machine": get("EMC", "MACHINE"),
        "linear_units": ini.map(|_| if is_inch { "inch" } else { "mm" }),
        "angular_units": get("TRAJ", "ANGULAR_UNITS"),
        "kinematics": get("KINS", "KINEMATICS"),
        "spindles": number("TRAJ", "SPINDLES").unwrap_or(1.0),
        "axes": letters,
        "joints": joints.len(),
        "limits": { "axes": axes, "joints": joints },
        "increments": increments,
        "max_feed_override": number("DISPLAY", "MAX_FEED_OVERRIDE"),
        "max_spindle_override": number("DISPLAY", "MAX_SPINDLE_OVERRIDE"),
        "default_linear_velocity": number("DISPLAY", "DEFAULT_LINEAR_VELOCITY")
            .or_else(|| number("TRAJ", "DEFAULT_LINEAR_VELOCITY"))
            .or_else(|| number("TRAJ", "DEFAULT_VELOCITY")),
        "max_linear_velocity": number("DISPLAY", "MAX_LINEAR_VELOCITY")
            .or_else(|| number("TRAJ", "MAX_LINEAR_VELOCITY"))
            .or_else(|| number("TRAJ", "MAX_VELOCITY")),
        "default_angular_velocity": number("DISPLAY", "DEFAULT_ANGULAR_VELOCITY"),
        "max_angular_velocity": number("DISPLAY", "MAX_ANGULAR_VELOCITY"),
        "mdi_commands": commands(ini),
        "languages": ["en", "es"],
        "ini": Json::Object(sections.collect()),
    });
    if let Json::Object(info) = info { info } else { Map::new() }
}

/// Returns the user's buttons: `[MDI_COMMAND_LIST]MDI_COMMAND = LINES,LABEL`, also with a name behind `MDI_COMMAND_`.
fn commands(ini: Option<&Ini>) -> Vec<Json> {
    let entries = ini.into_iter().flat_map(|ini| ini.section("MDI_COMMAND_LIST"));
    let entries = entries.filter(|e| e.name.starts_with("MDI_COMMAND"));
    let command = |(n, entry): (usize, &hal_ini::Entry)| {
        let name = entry.name.trim_start_matches("MDI_COMMAND").trim_start_matches('_');
        let name = if name.is_empty() { n.to_string() } else { name.to_owned() };
        let (lines, label) = entry.value.split_once(',').unwrap_or((&entry.value, &entry.value));
        json!({ "name": name, "label": label.trim(), "lines": lines.trim() })
    };
    entries.enumerate().map(command).collect()
}
