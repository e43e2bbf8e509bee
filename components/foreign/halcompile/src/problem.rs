//! Faults of a .comp file, in the user's words.

use core::fmt;

/// Kind of a fault. Where LinuxCNC has a message for it, the wording is the same.
#[derive(Clone, Debug, PartialEq)]
#[expect(missing_docs, reason = "the sentence of each variant is its documentation")]
pub enum Problem {
    Expected { wanted: Vec<&'static str>, found: Box<str> },
    UnclosedComment,
    UnclosedText,
    UnclosedLongText,
    Escape { escape: Box<str> },
    TooDeep,
    NumberTooLarge { number: Box<str> },
    NoSeparator,
    NotText,
    FileName { name: Box<str>, file: Box<str> },
    Duplicate { name: Box<str>, line: usize },
    SameHalName { name: Box<str>, line: usize },
    Reserved { name: Box<str> },
    ArrayWithoutHash { name: Box<str> },
    HashWithoutArray { name: Box<str> },
    TwoHashes { name: Box<str> },
    EmptyArray,
    NamelessItem { name: Box<str> },
    Keyword { name: Box<str> },
    OutOfRange { value: Box<str>, kind: &'static str, least: i128, most: i128 },
    WrongValue { kind: &'static str },
    NoDefault { kind: &'static str },
    PortParam,
    UnknownOption { name: Box<str>, near: Option<&'static str> },
    OptionSwitch { name: &'static str },
    OptionWhole { name: &'static str, least: i128, most: i128 },
    OptionType { name: &'static str },
    OptionText { name: &'static str },
    OptionTwice { name: Box<str>, line: usize },
    NoPeriod,
    Apart { one: &'static str, other: &'static str },
    NeedsUserspace { name: &'static str },
    NoLicense,
    NoPin,
    UserspaceFunction,
    BodyWithoutFunction { functions: usize },
}

impl fmt::Display for Problem {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Expected { wanted, found } => {
                let (last, first) = wanted.split_last().unwrap_or((&"nothing", &[]));
                let list = first.join(", ");
                let or = if first.is_empty() { "" } else { " or " };
                write!(f, "expected {list}{or}{last}, found {found}")
            }
            Self::UnclosedComment => f.write_str("this comment is not closed by */"),
            Self::UnclosedText => f.write_str(
                "this text is not closed by \" on its line; use \"\"\" for one of several lines",
            ),
            Self::UnclosedLongText => f.write_str("this text is not closed by \"\"\""),
            Self::Escape { escape } => {
                write!(f, "{escape} is no escape; a backslash itself is written \\\\")
            }
            Self::TooDeep => f.write_str("this expression is nested too deeply"),
            Self::NumberTooLarge { number } => write!(f, "{number} is too large"),
            Self::NoSeparator => f.write_str(
                "the line ;; is missing: it stands alone between the declarations and the C text",
            ),
            Self::NotText => f.write_str("this byte is no UTF-8 text"),
            Self::FileName { name, file } => {
                write!(f, "Component name ({name}) does not match filename ({file})")
            }
            Self::Duplicate { name, line } => {
                write!(f, "Duplicate item name {name}; it is declared on line {line}")
            }
            Self::SameHalName { name, line } => {
                write!(f, "Duplicate item name {name}; line {line} makes the same HAL name")
            }
            Self::Reserved { name } => write!(f, "Variable name {name} is reserved"),
            Self::ArrayWithoutHash { name } => {
                write!(
                    f,
                    "Array name contains no #: '{name}'; its index is to stand in it: '{name}-#'"
                )
            }
            Self::HashWithoutArray { name } => {
                write!(f, "Non-array name contains #: '{name}'; an array has a size, as [4]")
            }
            Self::TwoHashes { name } => {
                write!(f, "Array name contains more than one block of #: '{name}'")
            }
            Self::EmptyArray => f.write_str("an array has at least one element"),
            Self::NamelessItem { name } => write!(f, "nothing is left of '{name}' as a HAL name"),
            Self::Keyword { name } => write!(f, "'{name}' is a word of C, and can name nothing"),
            Self::OutOfRange { value, kind, least, most } => {
                write!(f, "{value} does not fit {kind}, which holds {least} to {most}")
            }
            Self::WrongValue { kind } => write!(f, "this is not a value of {kind}"),
            Self::NoDefault { kind } => write!(f, "{kind} takes no value to start with"),
            Self::PortParam => f.write_str("a parameter cannot be a port"),
            Self::UnknownOption { name, near } => {
                write!(f, "option {name} is not known and does nothing")?;
                near.map_or(Ok(()), |near| write!(f, "; is {near} meant?"))
            }
            Self::OptionSwitch { name } => write!(f, "option {name} is yes or no"),
            Self::OptionWhole { name, least, most } => {
                write!(f, "option {name} is a whole number from {least} to {most}")
            }
            Self::OptionType { name } => write!(f, "option {name} names a C type"),
            Self::OptionText { name } => write!(f, "option {name} is a text in \"…\""),
            Self::OptionTwice { name, line } => {
                write!(f, "option {name} has been given on line {line}")
            }
            Self::NoPeriod => f.write_str(
                "functions have no period with option period no, and the C text uses fperiod; LinuxCNC 2.9 ignores \
                 this option: give --compat 2.9, or take the line out",
            ),
            Self::Apart { one, other } => {
                write!(f, "option {one} and option {other} exclude each other")
            }
            Self::NeedsUserspace { name } => {
                write!(f, "option {name} is for option userspace yes alone")
            }
            Self::NoLicense => {
                f.write_str("License not specified; it is declared as license \"GPL\";")
            }
            Self::NoPin => f.write_str("Component must have at least one pin"),
            Self::UserspaceFunction => f.write_str("Userspace components may not have functions"),
            Self::BodyWithoutFunction { functions } => write!(
                f,
                "the C text has no FUNCTION(…), and is the body of a single function alone; there are {functions}"
            ),
        }
    }
}
