//! Mistakes in entries of an INI file that belong together.

use super::{Mutant, hal::misspelt, ini::Entry};

/// The lines of the INI file, with its name.
type Lines<'a> = (&'a str, &'a [String]);

/// Sections that programs read which know nothing of joints.
const OTHERS: &[&str] = &["EMC", "DISPLAY", "TASK", "EMCIO", "RS274NGC"];

/// Returns the mutants of one entry.
pub(super) fn mutants(
    all: &mut Vec<Mutant>,
    source: Lines<'_>,
    e: &Entry<'_>,
    entries: &[Entry<'_>],
) {
    let of = |key: &str| entries.iter().find(|o| o.section == e.section && o.key == key);
    let number = |key: &str| of(key).and_then(|o| o.value.parse::<f64>().ok());
    let with = |kind, value: &str| {
        let line = format!("{} = {value}", e.key);
        Mutant::replace(kind, source, e.index, &line).cured([e.key])
    };
    let more = |kind, lines: &str| {
        let text = format!("{} = {}\n{lines}", e.key, e.value);
        let made = Mutant::replace(kind, source, e.index, &text);
        made.also(e.index + 1).also(e.index + 2)
    };
    let is_joint = e.section.starts_with("JOINT_") || e.section.starts_with("AXIS_");
    if let Ok(value) = e.value.parse::<f64>()
        && (is_joint || e.section == "EMCMOT" || e.section == "TRAJ")
    {
        let twice = format!("{} = {}", e.key, value * 2.0 + 1.0);
        all.push(more("entry twice", &twice).cured(["keep the one"]));
    }
    match e.key {
        "FERROR" if is_joint => {
            if let Some(speed) = number("MAX_VELOCITY") {
                let half = (speed * 0.0005).to_string();
                all.push(with("following error below a servo period", &half));
            }
            all.push(more("backlash in hundredths", "BACKLASH = 20").cured(["BACKLASH"]));
            let homing = "HOME_SEARCH_VEL = 5\nHOME_LATCH_VEL = 0";
            all.push(more("latch velocity of zero", homing).cured(["HOME_LATCH_VEL"]));
            if of("TYPE").is_none() {
                let made = more("LINEAR and ANGULAR exchanged", "TYPE = ANGULAR");
                let rotary = number("MAX_LIMIT").is_some_and(|limit| limit > 9000.0);
                all.extend((!rotary).then(|| made.cured(["LINEAR"])));
            }
            let next = entries.iter().find(|o| {
                o.index > e.index && o.key == "FERROR" && o.section.starts_with("JOINT_")
            });
            if let Some(next) = next
                && e.section == "JOINT_0"
                && entries.iter().all(|o| o.key != "HOME_SEQUENCE")
            {
                let mut made = more("a gap in HOME_SEQUENCE", "HOME_SEQUENCE = 0");
                made.lines[next.index].push_str("\nHOME_SEQUENCE = 2");
                all.push(made.also(next.index + 2).cured(["HOME_SEQUENCE = 1"]));
            }
            let other = entries.iter().find(|o| OTHERS.contains(&o.section));
            if let Some(other) = other {
                let mut made =
                    Mutant::replace("a joint's entry in a program's section", source, e.index, "");
                made.lines[other.index].push_str(&format!("\n{} = {}", e.key, e.value));
                let whole = format!("[{}]{}", e.section, e.key);
                all.push(made.also(other.index + 1).named([whole.as_str()]).cured([e.key]));
            }
        }
        "MIN_FERROR" if is_joint => {
            if let Some(most) = number("FERROR") {
                let made = with("MIN_FERROR above FERROR", &(most * 10.0).to_string());
                let also = of("FERROR").map_or(e.index, |o| o.index);
                all.push(made.also(also).cured(["FERROR"]));
            }
        }
        "TYPE" if is_joint => {
            let other = if e.value == "LINEAR" { "ANGULAR" } else { "LINEAR" };
            all.push(with("LINEAR and ANGULAR exchanged", other).cured([e.value]));
        }
        "HOME_SEQUENCE" => {
            if let Ok(n @ 1..) = e.value.parse::<i32>() {
                let made = with("a gap in HOME_SEQUENCE", &(n + 5).to_string());
                all.push(made.cured(["HOME_SEQUENCE"]));
            }
        }
        "MIN_LIMIT" => {
            if let Some(max) = of("MAX_LIMIT") {
                let made = with("travel limits equal", max.value);
                all.push(made.also(max.index).cured(["MIN_LIMIT", "less"]));
            }
        }
        "LINEAR_UNITS" => {
            let other = if e.value == "mm" { "inch" } else { "mm" };
            all.push(with("mm and inch exchanged", other).cured([e.value]));
        }
        "COORDINATES" => {
            let twice = format!("{} {}", e.value, &e.value[e.value.len() - 1..]);
            all.push(with("a letter twice in COORDINATES", &twice).cured(["letter"]));
        }
        "TOOL_TABLE" => {
            all.push(with("no tool table", &misspelt(e.value)).cured(["make the file"]));
            let mut made = Mutant::replace("TOOL_TABLE in another section", source, e.index, "");
            if let Some(other) = entries.iter().find(|o| o.section == "TRAJ") {
                made.lines[other.index].push_str(&format!("\nTOOL_TABLE = {}", e.value));
                all.push(made.also(other.index + 1).cured(["EMCIO"]));
            }
        }
        _ => {}
    }
}
