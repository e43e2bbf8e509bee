//! The letters of the axes, which kinematics, `[TRAJ]COORDINATES` and the joints' types must agree on.

use super::{entries::about, joints::place};
use crate::{ini::Ini, session::dry_run::DryRun};
use hal_protocol::{At, Code, Finding};

/// The letters that trivkins gives its joints without an argument.
const USUAL: &str = "XYZABCUVW";

/// The letters of trivkins, with the line that states them.
struct Letters {
    text: String,
    at: Option<At>,
    stated: bool,
}

/// Returns whether a letter is that of a rotary axis.
pub(super) const fn is_rotary(letter: char) -> bool {
    matches!(letter, 'A' | 'B' | 'C')
}

fn letters(text: &str) -> String {
    text.chars().filter(char::is_ascii_alphabetic).map(|c| c.to_ascii_uppercase()).collect()
}

fn count(text: &str, letter: char) -> usize {
    text.chars().filter(|c| *c == letter).count()
}

/// Returns the first letter that is repeated.
fn repeated(text: &str) -> Option<char> {
    text.chars().find(|c| count(text, *c) > 1)
}

/// Returns the letters of trivkins. Other kinematics have joints of their own.
fn trivial(ini: Option<&Ini>, dry_run: &DryRun) -> Option<Letters> {
    let mut lines = dry_run.result().statements.iter().map(|(at, w)| (at.clone(), w.join(" ")));
    let line = lines.find(|(_, line)| {
        let mut words = line.split_whitespace();
        words.next() == Some("loadrt") && words.next() == Some("trivkins")
    });
    let entry = ini.and_then(|ini| ini.all("KINS", "KINEMATICS").next());
    let of_entry = || {
        let entry = entry.filter(|e| e.value.trim().starts_with("trivkins"))?;
        Some((At::new(&entry.file, entry.line), entry.value.clone()))
    };
    let (at, text) = line.or_else(of_entry)?;
    let argument = text.split_whitespace().find_map(|w| w.strip_prefix("coordinates="));
    let text = argument.map_or_else(|| USUAL.to_owned(), letters);
    Some(Letters { text, at: Some(at), stated: argument.is_some() })
}

/// Returns the letter of each joint of trivkins, as far as it is known.
pub(super) fn of_joints(dry_run: &DryRun) -> Vec<char> {
    let ini = dry_run.ini();
    let Some(letters) = trivial(ini, dry_run) else { return Vec::new() };
    let traj = ini.and_then(|i| i.get("TRAJ", "COORDINATES")).map(self::letters);
    // Without an argument, files that leave letters out count their joints in several ways.
    if !letters.stated && traj.is_some_and(|t| !USUAL.starts_with(&t)) {
        return Vec::new();
    }
    letters.text.chars().collect()
}

/// Reports letters that are repeated in one place and not in the other, or more letters than joints.
pub(super) fn findings(dry_run: &DryRun, joints: Option<u32>) -> Option<Finding> {
    let ini = dry_run.ini();
    let kins = trivial(ini, dry_run).filter(|k| k.stated);
    let entry = ini.and_then(|ini| ini.all("TRAJ", "COORDINATES").next());
    let traj = entry.map(|e| letters(&e.value)).unwrap_or_default();
    let joints = joints.and_then(|n| usize::try_from(n).ok());
    if let Some(entry) = entry
        && let Some(letter) = repeated(&traj)
    {
        let own = kins.as_ref().map_or(0, |k| count(&k.text, letter));
        let short = joints.filter(|n| *n < traj.len());
        let unlike = kins.is_some() && own != count(&traj, letter);
        if unlike || short.is_some() {
            let other = match (&kins, short) {
                (Some(k), _) if unlike => format!("the kinematics' coordinates are {}", k.text),
                (_, n) => format!("the machine has {} joints", n.unwrap_or_default()),
            };
            let text = format!("[TRAJ]COORDINATES has {letter} {} times, and {other}", {
                count(&traj, letter)
            });
            let there = kins.and_then(|k| k.at).filter(|at| Some(at) != place(entry).as_ref());
            let finding = about(Code::CoordinatesOdd, entry, text)
                .remedy("write each letter as often as joints move that axis");
            return Some(if unlike { finding.related(there, "they are here") } else { finding });
        }
    }
    let kins = kins?;
    let short = joints.filter(|n| *n < kins.text.len());
    let letter = repeated(&kins.text)?;
    let missing = !traj.is_empty() && count(&traj, letter) == 0;
    if short.is_none() && !missing {
        return None;
    }
    let other = short.map_or_else(
        || "[TRAJ]COORDINATES has none".to_owned(),
        |n| format!("coordinates={} needs {} joints, not {n}", kins.text, kins.text.len()),
    );
    let text = format!("the kinematics have {letter} {} times, and {other}", {
        count(&kins.text, letter)
    });
    let subject = format!("coordinates={}", kins.text);
    Some(
        Finding::new(Code::CoordinatesOdd, &subject, text)
            .at(kins.at)
            .remedy("write each letter as often as joints move that axis: coordinates=XYZ"),
    )
}
