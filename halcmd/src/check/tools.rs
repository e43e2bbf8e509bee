//! The tool table, and the answers to a tool change.

use super::entries::about;
use crate::ini::{Entry, Ini};
use hal_job::places::NoPrograms;
use hal_protocol::{Code, Finding, ItemInfo};
use std::{
    collections::BTreeMap,
    path::{Path, PathBuf},
};

/// Pairs of a request of iocontrol and the pin that answers it.
const ANSWERS: [(&str, &str); 2] =
    [("tool-prepare", "tool-prepared"), ("tool-change", "tool-changed")];

/// Reports a tool table that is not there. A database of tools needs none.
pub(super) fn table(ini: &Ini) -> Option<Finding> {
    let entry = ini.all("EMCIO", "TOOL_TABLE").next()?;
    let name = entry.value.trim();
    let database = ini.get("EMCIO", "DB_PROGRAM").is_some_and(|v| !v.trim().is_empty());
    if name.is_empty() || database || files(ini, entry, name).iter().any(|file| file.exists()) {
        return None;
    }
    let text = format!("the tool table '{name}' is not there: no tool has a length or a diameter");
    let remedy = format!("make the file '{name}' beside the INI file, or correct TOOL_TABLE");
    Some(about(Code::NoToolTable, entry, text).remedy(remedy))
}

/// Reports a folder of programs that is not there.
pub(super) fn programs(ini: &Ini) -> Option<Finding> {
    let entry = ini.all("DISPLAY", "PROGRAM_PREFIX").next()?;
    let absent: Option<Vec<_>> =
        folders(ini, entry).map(|folder| NoPrograms::of(ini, folder)).collect();
    let absent = absent?.pop()?;
    let value = absent.entry.value.trim();
    let text = format!(
        "the folder of programs '{value}' is not there, perhaps one of another computer: no program is found"
    );
    Some(about(Code::NoProgramFolder, absent.entry, text).remedy(absent.remedy()))
}

/// Returns the places where a file of the machine may be: beside the INI file, and beside the file that names it.
fn files(ini: &Ini, entry: &Entry, name: &str) -> Vec<PathBuf> {
    folders(ini, entry).map(|folder| hal_ini::beside(folder, name)).collect()
}

fn folders<'a>(ini: &'a Ini, entry: &'a Entry) -> impl Iterator<Item = &'a Path> {
    let main = ini.entries().next().map(|e| e.file.as_str());
    [Some(entry.file.as_str()), main].into_iter().flatten().filter_map(|f| Path::new(f).parent())
}

/// Reports requests of a tool change that nothing answers, in a machine with a tool table.
pub(super) fn answers(ini: &Ini, items: &BTreeMap<String, ItemInfo>) -> Vec<Finding> {
    let Some(entry) = ini.all("EMCIO", "TOOL_TABLE").next() else { return Vec::new() };
    // A machine whose scripts link nothing of iocontrol has another program for inputs and outputs.
    let is_used =
        |(name, i): (&String, &ItemInfo)| name.starts_with("iocontrol.0.") && i.signal.is_some();
    if !items.iter().any(is_used) {
        return Vec::new();
    }
    let is_linked = |pin: &str| items.get(pin).is_none_or(|item| item.signal.is_some());
    let open = ANSWERS.iter().filter_map(|(asks, answers)| {
        let (asks, answers) = (format!("iocontrol.0.{asks}"), format!("iocontrol.0.{answers}"));
        // One of the two alone is a connection of which half is missing.
        if is_linked(&asks) || is_linked(&answers) {
            return None;
        }
        let text = format!(
            "the machine has a tool table, and neither '{asks}' nor '{answers}' is linked: a tool \
             change waits for ever"
        );
        Some(
            Finding::new(Code::ToolChangeOpen, &answers, text)
                .at(super::joints::place(entry))
                .remedy(format!("net tool-loop {asks} => {answers}; or link what changes tools")),
        )
    });
    open.collect()
}
