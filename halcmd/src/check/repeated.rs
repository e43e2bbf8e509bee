//! Entries that a file has in one section twice, with different values.

use crate::ini::{Entry, Ini};
use hal_protocol::{At, Code, Finding};
use std::collections::BTreeMap;

/// Sections in which each name stands for one value. In others, such as `[DISPLAY]` and `[HAL]`, lists are usual.
const SINGLE: &[&str] = &["TRAJ", "KINS", "EMCMOT", "EMCIO", "TASK"];
const NUMBERED: &[&str] = &["JOINT_", "AXIS_", "SPINDLE_"];

pub(super) fn findings(ini: &Ini) -> Vec<Finding> {
    let mut first: BTreeMap<(&str, &str, &str), &Entry> = BTreeMap::new();
    let mut found = Vec::new();
    for entry in ini.entries() {
        let section = entry.section.as_str();
        if !SINGLE.contains(&section) && !NUMBERED.iter().any(|p| section.starts_with(p)) {
            continue;
        }
        // A file may change what a file that it includes says.
        let name = (entry.file.as_str(), section, entry.name.as_str());
        let before = *first.entry(name).or_insert(entry);
        let (is, was) = (entry.value.trim(), before.value.trim());
        let number = |text: &str| text.parse::<f64>().ok();
        if is == was || number(is).is_some() && number(is) == number(was) {
            continue;
        }
        let subject = format!("[{section}]{}", entry.name);
        let text = format!("{subject} is {is} here, and {was} before: the first counts");
        found.push(
            Finding::new(Code::EntryTwice, &subject, text)
                .at(Some(At::new(&entry.file, entry.line)))
                .remedy("keep the one that is meant, and take the other out")
                .related(Some(At::new(&before.file, before.line)), format!("{was} is here")),
        );
    }
    found
}

#[cfg(test)]
mod tests {
    use super::{Ini, findings};

    #[test]
    fn the_same_value_twice_is_no_mistake_and_lists_are_none() {
        let text =
            "[JOINT_0]\nHOME = 1\nHOME = 1.0\nSCALE = 4\nSCALE = 5\n[DISPLAY]\nA = 1\nA = 2\n";
        let ini = Ini::parse("m.ini", text.as_bytes()).unwrap();
        let found: Vec<String> = findings(&ini).into_iter().map(|f| f.text).collect();
        assert_eq!(found, ["[JOINT_0]SCALE is 5 here, and 4 before: the first counts"]);
    }
}
