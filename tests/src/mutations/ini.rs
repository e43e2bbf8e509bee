//! Mistakes in INI files.

use super::{Mutant, hal::misspelt, joints};

/// An entry.
pub(super) struct Entry<'a> {
    pub(super) index: usize,
    pub(super) section: &'a str,
    pub(super) key: &'a str,
    pub(super) value: &'a str,
}

/// Entries whose absence changes the machine.
const MATTER: &[&str] = &[
    "MAX_VELOCITY",
    "MAX_ACCELERATION",
    "MIN_LIMIT",
    "MAX_LIMIT",
    "FERROR",
    "SCALE",
    "STEPGEN_MAXACCEL",
    "JOINTS",
    "BASE_PERIOD",
    "SERVO_PERIOD",
    "HALFILE",
    "LINEAR_UNITS",
    "AXES",
    "MAX_LINEAR_VELOCITY",
];

/// Sections of the machine itself.
fn is_machine(section: &str) -> bool {
    ["JOINT_", "AXIS_"].iter().any(|p| section.starts_with(p))
        || ["EMCMOT", "KINS", "TRAJ", "HAL"].contains(&section)
}

/// Returns the mutants of an INI file.
pub(super) fn mutants(name: &str, lines: &[String]) -> Vec<Mutant> {
    let (mut section, mut entries, mut sections) = ("", Vec::new(), Vec::new());
    for (index, line) in lines.iter().enumerate() {
        if let Some(title) = line.strip_prefix('[').and_then(|l| l.strip_suffix(']')) {
            section = title;
            sections.push((index, title));
        } else if !line.starts_with('#')
            && let Some((key, value)) = line.split_once('=')
        {
            entries.push(Entry { index, section, key: key.trim(), value: value.trim() });
        }
    }
    let source = (name, lines);
    let mut all = Vec::new();
    for e in &entries {
        joints::mutants(&mut all, source, e, &entries);
    }
    for e in entries.iter().filter(|e| is_machine(e.section)) {
        entry(&mut all, source, e, &entries);
        joint(&mut all, source, e, &entries);
    }
    for (index, title) in sections.iter().filter(|(_, s)| is_machine(s)) {
        let wrong = format!("[{}]", misspelt(title));
        let made = Mutant::replace("section misspelt", source, *index, &wrong);
        all.push(made.named([*title]).cured([*title]));
        let end = sections.iter().find(|(n, _)| n > index).map_or(lines.len(), |(n, _)| *n);
        let mut made = Mutant::replace("section removed", source, *index, "");
        for line in &mut made.lines[*index..end] {
            line.clear();
        }
        all.push(made.named([*title]).cured([*title]));
    }
    all
}

fn entry(all: &mut Vec<Mutant>, source: (&str, &[String]), e: &Entry<'_>, entries: &[Entry<'_>]) {
    if !MATTER.contains(&e.key) {
        return;
    }
    let with =
        |kind, value: &str| Mutant::replace(kind, source, e.index, &format!("{} = {value}", e.key));
    let section = format!("[{}]", e.section);
    let whole = format!("[{}]{}", e.section, e.key);
    let gone = Mutant::replace("entry removed", source, e.index, "");
    all.push(gone.named([&whole, e.key]).cured([e.key]));
    let wrong = format!("{} = {}", misspelt(e.key), e.value);
    let made = Mutant::replace("entry misspelt", source, e.index, &wrong);
    all.push(made.named([&whole, e.key]).cured([e.key]));
    all.push(with("entry without a value", "").cured([e.key]));
    if e.value.parse::<f64>().is_ok() {
        all.push(
            with("a word for a number in the INI file", "fast").cured(["number", e.key, e.value]),
        );
        all.push(with("NaN in the INI file", "nan").cured(["number", e.key, "finite"]));
        if e.value.contains('.') {
            all.push(
                with("a decimal comma in the INI file", &e.value.replace('.', ","))
                    .cured([e.value, "point", "number"]),
            );
        }
    }
    // The entry slips into the next section.
    let next = entries
        .iter()
        .find(|n| n.index > e.index && n.section != e.section && is_machine(n.section));
    if let Some(next) = next
        && !entries.iter().any(|o| o.section == next.section && o.key == e.key)
    {
        let mut made = Mutant::replace("entry in the wrong section", source, e.index, "");
        made.lines[next.index].push_str(&format!("\n{} = {}", e.key, e.value));
        all.push(
            made.also(next.index)
                .also(next.index + 1)
                .named([&whole, &section, e.key])
                .cured([e.key]),
        );
    }
    match e.key {
        "HALFILE" => all.push(with("HALFILE misspelt", &misspelt(e.value)).cured([e.value])),
        "LINEAR_UNITS" => all.push(with("units that are none", "milimetre").cured(["mm", "inch"])),
        "JOINTS" | "AXES" => {
            let n: u32 = e.value.parse().unwrap();
            let cures = [e.key, "num_joints", "JOINT_", "coordinates", "AXIS_"];
            all.push(with("one joint too few", &(n - 1).to_string()).cured(cures).named(cures));
            all.push(with("one joint too many", &(n + 1).to_string()).cured(cures).named(cures));
        }
        "SERVO_PERIOD" | "BASE_PERIOD" => {
            let n: i64 = e.value.parse().unwrap();
            all.push(with("period in microseconds", &(n / 1000).to_string()).cured(["ns", e.key]));
        }
        _ => {}
    }
}

fn joint(all: &mut Vec<Mutant>, source: (&str, &[String]), e: &Entry<'_>, entries: &[Entry<'_>]) {
    let Ok(value) = e.value.parse::<f64>() else { return };
    let with = |kind, value: f64| {
        Mutant::replace(kind, source, e.index, &format!("{} = {value}", e.key)).cured([e.key])
    };
    let of = |key: &str| entries.iter().find(|o| o.section == e.section && o.key == key);
    let is_joint = e.section.starts_with("JOINT_") || e.section.starts_with("AXIS_");
    if !is_joint {
        return;
    }
    let number = |key: &str| of(key).and_then(|o| o.value.parse::<f64>().ok());
    match e.key {
        "MIN_LIMIT" => {
            let Some(max) = of("MAX_LIMIT") else { return };
            let mut made = with("travel limits exchanged", max.value.parse().unwrap());
            made.lines[max.index] = format!("MAX_LIMIT = {value}");
            all.push(made.also(max.index).cured(["MAX_LIMIT", "max-limit", "min-limit", "swap"]));
        }
        "HOME" => {
            let Some(max) = number("MAX_LIMIT") else { return };
            let cures = ["MIN_LIMIT", "MAX_LIMIT", "limit"];
            all.push(with("HOME outside the limits", max + 10.0).cured(cures));
        }
        "MAX_VELOCITY" => {
            all.push(with("velocity 1000 times too high", value * 1000.0).cured(["at most"]));
            all.push(with("velocity of zero", 0.0));
            all.push(with("negative velocity", -value));
        }
        "MAX_ACCELERATION" => {
            all.push(with("acceleration 1000 times too high", value * 1000.0).cured(["maxaccel"]));
            all.push(with("acceleration of zero", 0.0));
            all.push(with("negative acceleration", -value));
        }
        "SCALE" => {
            all.push(with("scale 1000 times too high", value * 1000.0).cured(["at most", "scale"]));
            all.push(
                with("scale 1000 times too low", value / 1000.0).cured(["step", "FERROR", "scale"]),
            );
            all.push(with("scale of zero in the INI file", 0.0).cured(["unit", "zero"]));
        }
        "FERROR" => all.push(with("following error below a step", 1e-6).cured(["step"])),
        "STEPGEN_MAXACCEL" => {
            all.push(with("stepgen accelerates less than its joint", 1.0).cured(["maxaccel"]));
        }
        _ => {}
    }
}
