//! Entries of an INI file that are missing, misplaced, or contradict each other or the wiring.

use super::{
    coordinates,
    joints::{place, value},
    plausible, repeated, sections, tools,
};
use crate::{
    ini::{Entry, Ini},
    language::hint::nearest,
    session::dry_run::DryRun,
};
use hal_protocol::{At, Code, Finding, ItemInfo, Kind, Level, Value};
use std::collections::BTreeMap;

/// Entries that a joint needs: velocity and acceleration always, the others if another joint has them.
const NEEDED: &[&str] = &["MAX_VELOCITY", "MAX_ACCELERATION", "MIN_LIMIT", "MAX_LIMIT", "FERROR"];

/// Sections and the entries that LinuxCNC and Ferrule read from them.
const KNOWN: &[(&str, &[&str])] = &[
    ("KINS", &["JOINTS", "KINEMATICS"]),
    (
        "TRAJ",
        &[
            "AXES",
            "JOINTS",
            "COORDINATES",
            "LINEAR_UNITS",
            "ANGULAR_UNITS",
            "UNITS",
            "CYCLE_TIME",
            "SPINDLES",
            "HOME",
            "POSITION_FILE",
            "NO_FORCE_HOMING",
            "NO_PROBE_JOG_ERROR",
            "NO_PROBE_HOME_ERROR",
            "TPMOD",
            "MAX_VELOCITY",
            "MAX_ACCELERATION",
            "DEFAULT_VELOCITY",
            "DEFAULT_ACCELERATION",
            "MAX_LINEAR_VELOCITY",
            "MAX_LINEAR_ACCELERATION",
            "DEFAULT_LINEAR_VELOCITY",
            "DEFAULT_LINEAR_ACCELERATION",
            "MAX_ANGULAR_VELOCITY",
            "MAX_ANGULAR_ACCELERATION",
            "DEFAULT_ANGULAR_VELOCITY",
            "MAX_JERK",
            "MAX_LINEAR_JERK",
            "PLANNER_TYPE",
            "ARC_BLEND_ENABLE",
            "ARC_BLEND_FALLBACK_ENABLE",
            "ARC_BLEND_OPTIMIZATION_DEPTH",
            "ARC_BLEND_GAP_CYCLES",
            "ARC_BLEND_RAMP_FREQ",
            "ARC_BLEND_KINK_RATIO",
            "MIN_LINEAR_VELOCITY",
            "MIN_ANGULAR_VELOCITY",
            "DEFAULT_ANGULAR_ACCELERATION",
            "MIN_VELOCITY",
        ],
    ),
    (
        "EMCMOT",
        &[
            "EMCMOT",
            "BASE_PERIOD",
            "SERVO_PERIOD",
            "TRAJ_PERIOD",
            "COMM_TIMEOUT",
            "COMM_WAIT",
            "HOMEMOD",
            "TPMOD",
            "SHMEM_KEY",
        ],
    ),
    ("HAL", &["HALFILE", "POSTGUI_HALFILE", "HALCMD", "HALUI", "SHUTDOWN", "TWOPASS", "COMPAT"]),
];

/// Returns a finding about an entry.
pub(super) fn about(code: Code, entry: &Entry, text: String) -> Finding {
    let subject = format!("[{}]{}", entry.section, entry.name);
    Finding::new(code, &subject, text).at(place(entry))
}

/// Returns the findings. Without all HAL files, nothing is known of the wiring.
pub(super) fn findings(dry_run: &mut DryRun, unread: bool) -> Vec<Finding> {
    let is_machine = dry_run.is_machine();
    let Some(ini) = dry_run.ini().cloned().filter(|_| is_machine) else { return Vec::new() };
    let mut items: BTreeMap<String, ItemInfo> = BTreeMap::new();
    for kind in [Kind::Pins, Kind::Params] {
        let all = dry_run.items(kind).into_iter();
        items.extend(all.map(|i| (i.original.clone().unwrap_or_else(|| i.name.clone()), i)));
    }
    let mut found = names(&ini, dry_run);
    found.extend(sections::findings(&ini, &dry_run.result().entries, &found));
    found.extend(repeated::findings(&ini));
    found.extend(tools::table(&ini));
    found.extend(tools::programs(&ini));
    if !unread {
        found.extend(tools::answers(&ini, &items));
    }
    found.extend(no_numbers(&ini));
    let motion = items.contains_key("motion.in-position");
    if motion || ini.has_section("KINS") || ini.has_section("TRAJ") && ini.has_section("EMCMOT") {
        found.extend(machine(&ini));
    }
    let kind = if ini.is_old() { "axis" } else { "joint" };
    let section = kind.to_ascii_uppercase();
    let Some((count, stated)) = joints(&ini) else { return found };
    let mut letters = coordinates::of_joints(dry_run).into_iter();
    let of = |n| {
        let section = format!("{section}_{n}");
        Joint { ini: &ini, section, items: &items, kind, n, letter: letters.next() }
    };
    let all: Vec<Joint<'_>> = (0..count.min(100)).map(of).collect();
    for joint in &all {
        found.extend(joint.entries(stated));
        found.extend(plausible::joint(joint));
        if !unread {
            found.extend(joint.wiring());
        }
    }
    found.extend(plausible::sequence(&all));
    found.extend(plausible::units(&ini, &all));
    found.extend(coordinates::findings(dry_run, Some(count)));
    found.extend(surplus(&ini, &section, count, stated));
    found
}

/// Returns the number of joints, with the entry that states it.
fn joints(ini: &Ini) -> Option<(u32, &Entry)> {
    let mut said = [("KINS", "JOINTS"), ("TRAJ", "JOINTS"), ("TRAJ", "AXES")]
        .into_iter()
        .filter_map(|(s, k)| ini.all(s, k).next());
    let entry = said.next()?;
    Some((entry.value.split_whitespace().next()?.parse().ok()?, entry))
}

/// Entries that a whole machine needs.
fn machine(ini: &Ini) -> Vec<Finding> {
    let mut found = Vec::new();
    let mut need = |section: &str, names: &[&str], why: &str, value: &str| {
        let has = |n: &&str| ini.get(section, n).is_some_and(|v| !v.trim().is_empty());
        let Some(name) = names.first() else { return };
        if names.iter().any(has) {
            return;
        }
        let empty = ini.all(section, name).next();
        let at = empty.or_else(|| ini.section(section).next()).or_else(|| ini.entries().next());
        let subject = format!("[{section}]{name}");
        let text = if empty.is_some() {
            format!("{subject} has no value: {why}")
        } else {
            format!("{subject} is missing: {why}")
        };
        let found_at = at.map(|e| At::new(&e.file, if e.section == section { e.line } else { 0 }));
        found.push(
            Finding::new(Code::EntryMissing, &subject, text)
                .at(found_at)
                .remedy(format!("write {name} = {value} in [{section}]")),
        );
    };
    need("HAL", &["HALFILE", "HALCMD"], "nothing wires the machine", "FILE.hal");
    need("TRAJ", &["LINEAR_UNITS", "UNITS"], "lengths have no unit", "mm");
    if joints(ini).is_none() {
        need("KINS", &["JOINTS"], "the number of joints is not known", "NUMBER");
    }
    found
}

/// Entries of joints and of motion that are no finite numbers.
fn no_numbers(ini: &Ini) -> Vec<Finding> {
    let is_joint = |e: &&Entry| {
        ["JOINT_", "AXIS_"].iter().any(|p| e.section.starts_with(p)) || e.section == "EMCMOT"
    };
    let bad = |e: &&Entry| value(e).is_some_and(|x| !x.is_finite());
    ini.entries()
        .filter(is_joint)
        .filter(bad)
        .map(|e| {
            let text = format!("[{}]{} is {}, not a finite number", e.section, e.name, e.value);
            about(Code::EntriesDisagree, e, text)
                .remedy(format!("write a number: {} = 1.5", e.name))
        })
        .collect()
}

/// Entries of known sections whose names are misspelt, or that belong in another section.
fn names(ini: &Ini, dry_run: &DryRun) -> Vec<Finding> {
    let read = &dry_run.result().entries;
    let mut found = Vec::new();
    for entry in ini.entries() {
        let (section, name) = (entry.section.as_str(), entry.name.as_str());
        let is_joint = ["JOINT_", "AXIS_"].iter().any(|p| section.starts_with(p));
        let own = KNOWN.iter().find(|(s, _)| *s == section).map(|(_, names)| *names);
        let own = if is_joint { Some(super::unused::KNOWN) } else { own };
        let Some(own) = own else { continue };
        if own.contains(&name) || read.contains(&(section.to_owned(), name.to_owned())) {
            continue;
        }
        let joint = super::unused::KNOWN.contains(&name).then_some("JOINT_n");
        let other = KNOWN.iter().find(|(_, names)| names.contains(&name)).map(|(s, _)| *s);
        // Scripts read an entry of this name from another section.
        let elsewhere = read.iter().any(|(s, n)| n == name && s != section);
        let whole = format!("[{section}]{name}");
        let near = nearest(name, own.iter().copied()).filter(|_| name.len() > 4);
        if let Some(near) = near {
            let text = format!("nothing reads {whole}");
            let finding = about(Code::EntryMisplaced, entry, text);
            found.push(finding.remedy(format!("did you mean '{near}'?")));
        } else if let Some(right) = other.or(joint.filter(|_| !is_joint)) {
            let text = format!("nothing reads {whole}: {name} belongs in [{right}]");
            let finding = about(Code::EntryMisplaced, entry, text);
            found.push(finding.remedy(format!("move {name} to [{right}]")));
        } else if elsewhere && !is_joint {
            let text = format!("nothing reads {whole}, and scripts read {name} of other sections");
            let finding = about(Code::EntryMisplaced, entry, text);
            found.push(finding.remedy(format!("move {name} to the section that scripts name")));
        }
    }
    found
}

/// Sections of joints that the machine does not have.
fn surplus(ini: &Ini, kind: &str, count: u32, entry: &Entry) -> Vec<Finding> {
    let mut found = Vec::new();
    for n in count..count.saturating_add(16) {
        let section = format!("{kind}_{n}");
        let Some(first) = ini.section(&section).next() else { continue };
        let text = format!(
            "[{section}] is there, and [{}]{} is {count}: the machine has joints 0 to {}",
            entry.section,
            entry.name,
            count.saturating_sub(1)
        );
        let mut surplus = about(Code::EntriesDisagree, entry, text)
            .remedy(format!("{} = {}, or take [{section}] out", entry.name, n + 1))
            .related(place(first), format!("[{section}] is here"));
        // Many files keep the sections of joints that the machine has lost.
        surplus.level = Level::Note;
        found.push(surplus);
    }
    found
}

/// A joint of the INI file and its pins.
pub(super) struct Joint<'a> {
    pub(super) ini: &'a Ini,
    pub(super) section: String,
    items: &'a BTreeMap<String, ItemInfo>,
    kind: &'a str,
    n: u32,
    /// Letter of the axis that it moves, if that is known.
    pub(super) letter: Option<char>,
}

impl Joint<'_> {
    pub(super) fn entry(&self, name: &str) -> Option<&Entry> {
        self.ini.all(&self.section, name).next()
    }

    pub(super) fn number(&self, name: &str) -> Option<f64> {
        value(self.entry(name)?)
    }

    pub(super) fn pin(&self, name: &str) -> Option<&ItemInfo> {
        self.items.get(&format!("{}.{}.{name}", self.kind, self.n))
    }

    /// Reports a missing section and missing or contradicting entries.
    fn entries(&self, count: &Entry) -> Vec<Finding> {
        let mut found = Vec::new();
        if self.ini.section(&self.section).next().is_none() {
            let section = &self.section;
            let subject = format!("[{section}]");
            let text =
                format!("section [{section}] is missing: the joint has no limits of its own");
            let finding = Finding::new(Code::EntryMissing, &subject, text).at(place(count));
            found.push(finding.remedy(format!(
                "write [{section}] with {}; or let {} be {}",
                NEEDED.join(", "),
                count.name,
                self.n
            )));
            return found;
        }
        // A rotary joint may turn without end.
        let is_limited = |name: &&str| {
            let limits = ["MIN_LIMIT", "MAX_LIMIT"];
            let rotary = self.entry("TYPE").is_some_and(|e| e.value.trim() == "ANGULAR");
            !limits.contains(name) || !rotary || limits.iter().any(|l| self.entry(l).is_some())
        };
        for name in NEEDED.iter().filter(|name| is_limited(name)) {
            let entry = self.entry(name);
            if entry.is_some_and(|e| !e.value.trim().is_empty()) {
                continue;
            }
            // A machine may do without limits and following errors, if all its joints do.
            let prefix = self.section.trim_end_matches(|c: char| c.is_ascii_digit());
            let mut others = self.ini.entries().filter(|e| e.section.starts_with(prefix));
            let needed = name.starts_with("MAX_") && !name.ends_with("_LIMIT");
            if entry.is_none() && !needed && !others.any(|e| e.name == *name) {
                continue;
            }
            let near = entry.or_else(|| self.ini.section(&self.section).next());
            let subject = format!("[{}]{name}", self.section);
            let why = if entry.is_some() { "has no value" } else { "is missing" };
            let text = format!("{subject} {why}: motion uses its default");
            let at = near.and_then(place);
            found.push(
                Finding::new(Code::EntryMissing, &subject, text)
                    .at(at)
                    .remedy(format!("write {name} = VALUE in [{}]", self.section)),
            );
        }
        let (low, high) = (self.number("MIN_LIMIT"), self.number("MAX_LIMIT"));
        if let (Some(entry), Some(home)) = (self.entry("HOME"), self.number("HOME"))
            && (low.is_some_and(|low| home < low) || high.is_some_and(|high| home > high))
        {
            let shown = |x: Option<f64>| x.map_or("no limit".to_owned(), |x| x.to_string());
            let text = format!(
                "[{}]HOME is {home}, outside the travel limits {} to {}",
                self.section,
                shown(low),
                shown(high)
            );
            found.push(
                about(Code::EntriesDisagree, entry, text)
                    .remedy("let HOME be between MIN_LIMIT and MAX_LIMIT"),
            );
        }
        found
    }

    /// Reports entries that the wiring contradicts.
    fn wiring(&self) -> Vec<Finding> {
        let mut found = Vec::new();
        let is_linked = |name| self.pin(name).is_some_and(|p| p.signal.is_some());
        if let (Some(entry), Some(speed)) =
            (self.entry("HOME_SEARCH_VEL"), self.number("HOME_SEARCH_VEL"))
            && speed != 0.0
            && let Some(switch) = self.pin("home-sw-in").filter(|p| p.signal.is_none())
            && !is_linked("index-enable")
        {
            let text = format!(
                "[{}]HOME_SEARCH_VEL is {speed}, and '{}' is not linked: homing finds no switch",
                self.section, switch.name
            );
            found.push(
                about(Code::EntriesDisagree, entry, text)
                    .remedy(format!("net SIGNAL PIN => {}; or HOME_SEARCH_VEL = 0", switch.name)),
            );
        }
        found.extend(self.step());
        found
    }

    /// Reports a permitted following error that is shorter than a step.
    fn step(&self) -> Option<Finding> {
        let signal = self.pin("motor-pos-cmd")?.signal.as_ref()?;
        let fed = |(name, item): (&String, &ItemInfo)| {
            (item.signal.as_ref() == Some(signal))
                .then(|| name.strip_suffix(".position-cmd"))?
                .map(str::to_owned)
        };
        let channel = self.items.iter().find_map(fed)?;
        let Value::Float(scale) = self.items.get(&format!("{channel}.position-scale"))?.value
        else {
            return None;
        };
        let step = 1.0 / scale.abs();
        let error = self.number("FERROR")?;
        if !step.is_finite() || error >= step {
            return None;
        }
        let entry = self.entry("FERROR")?;
        let text = format!(
            "[{}]FERROR is {error}, less than a step of {channel}, which is {step} units \
             (position-scale {scale}): the joint fails as soon as it moves",
            self.section
        );
        Some(
            about(Code::EntriesDisagree, entry, text)
                .remedy("let FERROR be several steps, or correct the scale, in steps per unit"),
        )
    }
}

#[cfg(test)]
mod tests {
    use super::{Ini, joints, surplus};

    #[test]
    fn sections_beyond_the_number_of_joints() {
        let of = |count: &str| {
            let text = format!("[KINS]\nJOINTS = {count}\n[JOINT_0]\nA = 1\n[JOINT_1]\nA = 1\n");
            let ini = Ini::parse("m.ini", text.as_bytes()).unwrap();
            let (count, stated) = joints(&ini).unwrap();
            let found = surplus(&ini, "JOINT", count, stated);
            found.into_iter().map(|f| f.remedy).collect::<Vec<_>>()
        };
        assert_eq!(of("1"), ["JOINTS = 2, or take [JOINT_1] out"]);
        assert_eq!(of("2"), [""; 0]);
        // The largest number ends the search, not the program.
        assert_eq!(of("4294967295"), [""; 0]);
    }
}
