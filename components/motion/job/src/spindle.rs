//! The record of the tool in the spindle, which survives a power cut.
//!
//! The file has two lines: the record before and the current one.
//!
//! ```text
//! tool 1 #51c15fcca7506bdc
//! change 1 2 #fb590115df78b75c
//! ```
//!
//! `tool N`: tool N is in the spindle, 0 for none, -1 if it is unknown. `change A B`: A is being changed for B. The number
//! behind `#` is the [`checksum`] of the text before it. Each record is stored before it is acted upon: `change` before the
//! changer is asked, `tool` before the machine goes on. A line that was cut off was therefore never acted upon, and the
//! line before it counts.

use hal_output::checksum;
use std::path::{Path, PathBuf};

/// Number of the tool in the spindle if it is unknown.
pub const UNKNOWN: i32 = -1;

/// Knowledge about the tool in the spindle.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Spindle {
    /// This tool is in the spindle; 0 for none, [`UNKNOWN`].
    Holds(i32),
    /// A change is in progress.
    Changing {
        /// Tool before the change.
        from: i32,
        /// Tool after the change.
        to: i32,
    },
}

impl Spindle {
    /// Returns the tool that is certainly in the spindle, or [`UNKNOWN`].
    pub const fn tool(self) -> i32 {
        match self {
            Self::Holds(tool) => tool,
            Self::Changing { .. } => UNKNOWN,
        }
    }

    /// Returns the record that is stored before the changer is asked for a tool.
    pub const fn asked(self, tool: i32) -> Self {
        let from = self.tool();
        // Without a change, the changer does nothing either.
        if from == tool && tool != UNKNOWN { self } else { Self::Changing { from, to: tool } }
    }

    /// Returns the record after the changer, which was asked for the tool `to`, states the tool `is`; `None` if it is
    /// another one. The change then stays open: a person must say which tool is there.
    pub fn changed(to: i32, is: i32) -> Option<Self> {
        (is == to).then_some(Self::Holds(is))
    }

    fn text(self) -> String {
        match self {
            Self::Holds(tool) => format!("tool {tool}"),
            Self::Changing { from, to } => format!("change {from} {to}"),
        }
    }

    fn line(self) -> String {
        let text = self.text();
        let sum = checksum::of(text.as_bytes());
        format!("{text} #{sum:016x}\n")
    }

    fn parse(line: &str) -> Option<Self> {
        // A line without its end may have been cut off.
        let (text, sum) = line.strip_suffix('\n')?.split_once(" #")?;
        if u64::from_str_radix(sum, 16).ok()? != checksum::of(text.as_bytes()) {
            return None;
        }
        let words: Vec<&str> = text.split(' ').collect();
        let number = |word: &str| word.parse::<i32>().ok();
        match *words.as_slice() {
            ["tool", tool] => Some(Self::Holds(number(tool)?)),
            ["change", from, to] => Some(Self::Changing { from: number(from)?, to: number(to)? }),
            _ => None,
        }
    }
}

/// Returns the text of the file.
pub fn print(before: Spindle, now: Spindle) -> String {
    before.line() + &now.line()
}

/// Returns the file of the record where the INI file names none: beside the tool table if it is there already, else a file
/// whose name begins with `state`.
pub(crate) fn file(table: &Path, state: Option<&Path>) -> Option<PathBuf> {
    let mut name = table.as_os_str().to_owned();
    name.push(".spindle");
    let beside = Some(PathBuf::from(name)).filter(|path| path.exists());
    beside.or_else(|| Some(state?.with_extension("spindle")))
}

/// Returns the record of a file; `None` if no line is whole.
pub fn parse(text: &str) -> Option<Spindle> {
    text.split_inclusive('\n').rev().find_map(Spindle::parse)
}

#[cfg(test)]
mod tests {
    use super::*;

    const RECORDS: [Spindle; 4] = [
        Spindle::Holds(UNKNOWN),
        Spindle::Holds(0),
        Spindle::Holds(i32::MAX),
        Spindle::Changing { from: 12, to: 7 },
    ];

    #[test]
    fn a_record_is_beside_the_table_only_if_it_was_there() {
        let folder = std::env::temp_dir().join(format!("hal-spindle-{}", std::process::id()));
        std::fs::create_dir_all(&folder).unwrap();
        let (table, state) = (folder.join("tool.tbl"), Path::new("/state/mill-1"));
        assert_eq!(file(&table, None), None);
        assert_eq!(file(&table, Some(state)), Some("/state/mill-1.spindle".into()));
        let beside = folder.join("tool.tbl.spindle");
        std::fs::write(&beside, "").unwrap();
        assert_eq!(file(&table, None).as_ref(), Some(&beside));
        assert_eq!(file(&table, Some(state)), Some(beside));
        std::fs::remove_dir_all(folder).unwrap();
    }

    /// A file that is cut off anywhere has one of its two records; without the first line nothing is known.
    #[test]
    fn a_file_that_was_cut_off_has_the_record_before() {
        for before in RECORDS {
            for now in RECORDS {
                let text = print(before, now);
                assert_eq!(parse(&text), Some(now));
                let first = before.line().len();
                for cut in 0..text.len() {
                    let wanted = (cut >= first).then_some(before);
                    assert_eq!(parse(&text[..cut]), wanted, "{text:?} cut at {cut}");
                }
            }
        }
    }

    /// A changed byte never makes another record.
    #[test]
    fn a_damaged_line_does_not_count() {
        for now in RECORDS {
            let line = now.line();
            for at in 0..line.len() {
                for byte in (b' '..=b'~').chain([b'\n']) {
                    let mut bytes = line.clone().into_bytes();
                    bytes[at] = byte;
                    let text = String::from_utf8(bytes).unwrap();
                    assert!(parse(&text).is_none_or(|r| r == now), "{text:?}");
                }
            }
        }
        assert_eq!(parse("tool 1\ntool x #0\n"), None);
    }
}
