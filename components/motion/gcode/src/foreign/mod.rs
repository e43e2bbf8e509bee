//! Programs of other controls: which control a file was written for, and what of it means nothing here.
//!
//! | module | subject |
//! |---|---|
//! | [`table`] | the codes and words of other controls: what each means there, and what to write instead |
//! | [`row`] | what a row of the table is |
//! | `scan` | the codes and words of one line |
//! | `survey` | the lines of a file, within bounds |
//! | `report` | the texts |
//!
//! A file is recognised by at least two signs of one control, of which this language understands one not at all. One word that
//! only LinuxCNC has makes a file LinuxCNC's own. Nothing is translated.

mod report;
pub mod row;
mod scan;
mod survey;
pub mod table;

pub use report::{advice, line_advice};
pub use survey::{CodeName, Findings, MAX_BYTES, MAX_LINES, Seen, Unread, survey};

/// A control that programs are written for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
#[expect(missing_docs, reason = "the names are those of the makers")]
pub enum Control {
    Fanuc,
    Haas,
    Mach3,
    Grbl,
    Marlin,
    Siemens,
    Heidenhain,
}

impl Control {
    /// All controls.
    pub const ALL: [Self; 7] = [
        Self::Fanuc,
        Self::Haas,
        Self::Mach3,
        Self::Grbl,
        Self::Marlin,
        Self::Siemens,
        Self::Heidenhain,
    ];

    /// Returns the name, as people write it.
    pub fn name(self) -> &'static str {
        match self {
            Self::Fanuc => "Fanuc",
            Self::Haas => "Haas",
            Self::Mach3 => "Mach3",
            Self::Grbl => "GRBL",
            Self::Marlin => "Marlin or a slicer",
            Self::Siemens => "Siemens",
            Self::Heidenhain => "Heidenhain",
        }
    }

    /// Returns the name as an owner, such as "Haas's".
    pub fn owner(self) -> &'static str {
        match self {
            Self::Fanuc => "Fanuc's",
            Self::Haas => "Haas's",
            Self::Mach3 => "Mach3's",
            Self::Grbl => "GRBL's",
            Self::Marlin => "Marlin's",
            Self::Siemens => "Siemens'",
            Self::Heidenhain => "Heidenhain's",
        }
    }
}
