//! Findings for entries of joints, axes and spindles that nothing reads, often because they are misspelt.

use crate::{language::hint::nearest, session::dry_run::DryRun};
use hal_protocol::{At, Code, Finding, Kind, Link, Reply, Request};

/// Entries that LinuxCNC's programs read from the section of a joint, an axis or a spindle.
pub(super) const KNOWN: &[&str] = &[
    "TYPE",
    "UNITS",
    "HOME",
    "MAX_VELOCITY",
    "MAX_ACCELERATION",
    "MAX_JERK",
    "BACKLASH",
    "COMP_FILE",
    "COMP_FILE_TYPE",
    "COMP_AV_RATIO",
    "MIN_LIMIT",
    "MAX_LIMIT",
    "FERROR",
    "MIN_FERROR",
    "LOCKING_INDEXER",
    "HOME_SEARCH_VEL",
    "HOME_LATCH_VEL",
    "HOME_FINAL_VEL",
    "HOME_OFFSET",
    "HOME_USE_INDEX",
    "HOME_INDEX_NO_ENCODER_RESET",
    "HOME_IGNORE_LIMITS",
    "HOME_IS_SHARED",
    "HOME_ABSOLUTE_ENCODER",
    "HOME_SEQUENCE",
    "VOLATILE_HOME",
    "OFFSET_AV_RATIO",
    "WRAPPED_ROTARY",
    "DISABLE_JOG",
    "MAX_FORWARD_VELOCITY",
    "MIN_FORWARD_VELOCITY",
    "MAX_REVERSE_VELOCITY",
    "MIN_REVERSE_VELOCITY",
    "INCREMENT",
    "HOME_SEARCH_VELOCITY",
];

pub(super) fn findings(dry_run: &mut DryRun) -> Vec<Finding> {
    let Some(ini) = dry_run.ini().cloned() else { return Vec::new() };
    let read = dry_run.result().entries.clone();
    let list = Request::List {
        kind: Kind::Commands,
        patterns: vec!["motion.configure".to_owned()],
        ty: None,
    };
    let told: Vec<String> = match dry_run.engine().call(list) {
        Ok(Reply::Commands(list)) => {
            list.into_iter().flat_map(|c| c.args).map(|a| a.name).collect()
        }
        _ => Vec::new(),
    };
    let mut found = Vec::new();
    for entry in ini.entries() {
        let of_joint = ["AXIS_", "JOINT_", "SPINDLE_"].iter().any(|p| entry.section.starts_with(p));
        let name = (entry.section.clone(), entry.name.clone());
        let arg = entry.name.to_ascii_lowercase().replace('_', "-");
        if !of_joint
            || read.contains(&name)
            || KNOWN.contains(&entry.name.as_str())
            || told.contains(&arg)
        {
            continue;
        }
        let near = nearest(&entry.name, KNOWN.iter().copied());
        let remedy = near.map_or_else(
            || "use it in a script, or take it out".to_owned(),
            |near| format!("did you mean '{near}'?"),
        );
        let subject = format!("[{}]{}", entry.section, entry.name);
        let text = format!("nothing reads {subject}");
        let at = At::new(&entry.file, entry.line);
        found.push(Finding::new(Code::IniUnused, &subject, text).at(Some(at)).remedy(remedy));
    }
    found
}
