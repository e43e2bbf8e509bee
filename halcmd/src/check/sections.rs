//! Entries in a section from which nothing reads them, although their name belongs to another section.

use super::{entries::about, unused};
use crate::ini::Ini;
use hal_protocol::{Code, Finding};
use std::collections::BTreeSet;

/// Names that only one section has.
const HOMES: &[(&str, &[&str])] = &[
    (
        "EMCIO",
        &[
            "TOOL_TABLE",
            "TOOL_CHANGE_POSITION",
            "TOOL_CHANGE_QUILL_UP",
            "TOOL_CHANGE_WITH_SPINDLE_ON",
            "TOOL_CHANGE_AT_G30",
            "RANDOM_TOOLCHANGER",
            "DB_PROGRAM",
        ],
    ),
    ("RS274NGC", &["PARAMETER_FILE", "SUBROUTINE_PATH", "USER_M_PATH", "REMAP"]),
    ("FILTER", &["PROGRAM_EXTENSION"]),
    ("DISPLAY", &["INCREMENTS", "MAX_FEED_OVERRIDE", "PROGRAM_PREFIX", "POSITION_OFFSET"]),
    ("KINS", &["KINEMATICS", "JOINTS"]),
    ("TRAJ", &["COORDINATES", "LINEAR_UNITS", "ANGULAR_UNITS", "NO_FORCE_HOMING"]),
    ("EMCMOT", &["BASE_PERIOD", "SERVO_PERIOD"]),
    ("HAL", &["HALFILE", "POSTGUI_HALFILE", "SHUTDOWN"]),
];
/// Sections that LinuxCNC's programs read, besides those of joints, axes and spindles.
const SECTIONS: &[&str] = &[
    "EMC", "DISPLAY", "TASK", "EMCIO", "RS274NGC", "FILTER", "KINS", "TRAJ", "EMCMOT", "HAL",
    "HALUI",
];
/// Names that a joint's section shares with others.
const SHARED: &[&str] =
    &["TYPE", "UNITS", "HOME", "MAX_VELOCITY", "MAX_ACCELERATION", "MAX_JERK", "INCREMENT"];
/// Names that the section of an axis letter has too.
const OF_AXIS: &[&str] =
    &["MIN_LIMIT", "MAX_LIMIT", "WRAPPED_ROTARY", "OFFSET_AV_RATIO", "DISABLE_JOG"];

/// Returns findings about entries of which `read` has none and `known` has no finding yet.
pub(super) fn findings(
    ini: &Ini,
    read: &BTreeSet<(String, String)>,
    known: &[Finding],
) -> Vec<Finding> {
    let mut found = Vec::new();
    for entry in ini.entries() {
        let (section, name) = (entry.section.as_str(), entry.name.as_str());
        let subject = format!("[{section}]{name}");
        let letter = section
            .strip_prefix("AXIS_")
            .is_some_and(|rest| rest.len() == 1 && rest.bytes().all(|b| b.is_ascii_alphabetic()));
        let of_joint = unused::KNOWN.contains(&name)
            && !SHARED.contains(&name)
            && (!letter || !OF_AXIS.contains(&name))
            && !name.contains("_VELOCITY");
        let home = HOMES.iter().find(|(_, names)| names.contains(&name)).map(|(home, _)| *home);
        let numbered = section.starts_with("JOINT_") || section.starts_with("AXIS_");
        let right = match home {
            Some(home) if home != section && (numbered || SECTIONS.contains(&section)) => home,
            None if of_joint && (letter || SECTIONS.contains(&section)) => "JOINT_n",
            _ => continue,
        };
        // Older files have the number of joints in [TRAJ].
        if read.contains(&(section.to_owned(), name.to_owned()))
            || known.iter().any(|f| f.subject == subject)
            || (section, name) == ("TRAJ", "JOINTS")
        {
            continue;
        }
        let text = format!("nothing reads {subject}: {name} belongs in [{right}]");
        let finding = about(Code::EntryMisplaced, entry, text);
        found.push(finding.remedy(format!("move {name} to [{right}]")));
    }
    found
}
