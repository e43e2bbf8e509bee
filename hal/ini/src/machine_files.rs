//! Files that an INI file names, by what they are for the machine.

use crate::{Entry, Ini};

/// Purpose of a file that an INI file names.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Purpose {
    /// A script: the user writes it.
    Script,
    /// The tool table: the user and the machine write it.
    Tools,
    /// Memory of the machine between two runs: the machine writes it.
    Memory,
}

/// Entries that name a file of the machine.
const ENTRIES: [(&str, &str, Purpose); 8] = [
    ("HAL", "HALFILE", Purpose::Script),
    ("HAL", "POSTGUI_HALFILE", Purpose::Script),
    ("HAL", "SHUTDOWN", Purpose::Script),
    ("EMCIO", "TOOL_TABLE", Purpose::Tools),
    ("EMCIO", "SPINDLE_FILE", Purpose::Memory),
    ("RS274NGC", "PARAMETER_FILE", Purpose::Memory),
    ("TASK", "JOURNAL", Purpose::Memory),
    ("TRAJ", "POSITION_FILE", Purpose::Memory),
];

impl Ini {
    /// Returns the names of the machine's files, relative to the folder of the INI file, with their purpose.
    pub fn machine_files(&self) -> impl Iterator<Item = (Purpose, &str)> {
        ENTRIES.into_iter().flat_map(|(section, name, purpose)| {
            self.all(section, name).filter_map(move |entry| Some((purpose, file(entry, purpose)?)))
        })
    }
}

/// Returns the file of an entry. The line of a script may have arguments behind the file.
fn file(entry: &Entry, purpose: Purpose) -> Option<&str> {
    let value = entry.value.trim();
    let name = if purpose == Purpose::Script { value.split_whitespace().next()? } else { value };
    (!name.is_empty()).then_some(name)
}

#[cfg(test)]
mod tests {
    use super::{ENTRIES, Purpose};
    use crate::Ini;

    #[test]
    fn every_entry_names_its_file() {
        for (section, name, purpose) in ENTRIES {
            let text = format!("[{section}]\n{name} = a b.x \n{name} =\n");
            let ini = Ini::parse("m.ini", text.as_bytes()).unwrap();
            let file = if purpose == Purpose::Script { "a" } else { "a b.x" };
            assert_eq!(ini.machine_files().collect::<Vec<_>>(), [(purpose, file)], "{name}");
        }
    }
}
