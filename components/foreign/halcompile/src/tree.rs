//! Syntax tree of a .comp file: its declarations, each with its place.

use crate::{expr::Expr, place::Span};

/// Value with its place in the file.
#[derive(Clone, Debug, PartialEq)]
pub struct At<T> {
    /// Parsed value.
    pub value: T,
    /// Place of the value.
    pub span: Span,
}

/// Syntax tree of a file.
#[derive(Clone, Debug, PartialEq)]
pub struct Tree {
    /// Name after `component`.
    pub name: At<String>,
    /// Text after the name.
    pub doc: Option<String>,
    /// Declarations after it, in order.
    pub declarations: Vec<Declaration>,
    /// C text after `;;`.
    pub body: Body,
}

/// C text of a file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Body {
    /// Text as written.
    pub text: String,
    /// Line of the file on which the text begins, from 1.
    pub line: usize,
}

/// Declaration of a file.
#[derive(Clone, Debug, PartialEq)]
pub enum Declaration {
    /// `pin` or `param`.
    Item(Item),
    /// `function`.
    Function(Function),
    /// `variable`.
    Variable(Variable),
    /// `modparam`.
    ModParam(ModParam),
    /// `option`.
    Option(OptionLine),
    /// `include`: the header with its brackets or quotes.
    Include(At<String>),
    /// `description`, `license` and other texts.
    Text(TextKind, At<String>),
}

/// Pin or parameter.
#[derive(Clone, Debug, PartialEq)]
pub struct Item {
    /// Direction, which also distinguishes pins from parameters.
    pub direction: Direction,
    /// Type of the item.
    pub kind: Kind,
    /// Name as written.
    pub name: At<String>,
    /// Array size, if the item is an array.
    pub array: Option<Array>,
    /// Initial value.
    pub default: Option<At<Value>>,
    /// Condition on the personality for instances to have the item.
    pub condition: Option<Expr>,
    /// Description of the item.
    pub doc: Option<String>,
}

impl Item {
    /// Returns whether the item is a pin.
    #[must_use]
    pub const fn is_pin(&self) -> bool {
        matches!(self.direction, Direction::In | Direction::Out | Direction::Io)
    }
}

/// Size of an array.
#[derive(Clone, Debug, PartialEq)]
pub struct Array {
    /// Maximum number of elements.
    pub max: At<u32>,
    /// Number of elements of an instance, if it depends on the personality.
    pub size: Option<Expr>,
}

/// Direction of an item.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Direction {
    /// Pin that the component reads.
    In,
    /// Pin that the component writes.
    Out,
    /// Pin that the component reads and writes.
    Io,
    /// Parameter that the component reports.
    R,
    /// Parameter that the user sets.
    Rw,
}

impl Direction {
    /// Returns the constant in C.
    #[must_use]
    pub const fn c(self) -> &'static str {
        match self {
            Self::In => "HAL_IN",
            Self::Out => "HAL_OUT",
            Self::Io => "HAL_IO",
            Self::R => "HAL_RO",
            Self::Rw => "HAL_RW",
        }
    }

    /// Returns the word that users read.
    #[must_use]
    pub const fn word(self) -> &'static str {
        match self {
            Self::In => "in",
            Self::Out => "out",
            Self::Io => "io",
            Self::R => "r",
            Self::Rw => "rw",
        }
    }
}

/// Type of an item: the storage that C code sees, and the HAL type.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Kind {
    /// Keyword as written.
    pub word: &'static str,
    /// HAL type of the item.
    pub hal: Hal,
    /// True if C code accesses it only by `hal_get_…` and `hal_set_…`.
    pub handle: bool,
}

/// HAL types.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[expect(missing_docs, reason = "their names are HAL's")]
pub enum Hal {
    Bit,
    Float,
    S32,
    U32,
    S64,
    U64,
    Port,
}

impl Hal {
    /// Returns the name, as `show` prints it and as it occurs in the names of C functions.
    #[must_use]
    pub const fn word(self) -> &'static str {
        match self {
            Self::Bit => "bit",
            Self::Float => "float",
            Self::S32 => "s32",
            Self::U32 => "u32",
            Self::S64 => "s64",
            Self::U64 => "u64",
            Self::Port => "port",
        }
    }

    /// Returns the range of integers the type can hold.
    #[must_use]
    pub const fn range(self) -> Option<(i128, i128)> {
        match self {
            Self::Bit => Some((0, 1)),
            Self::S32 => Some((i32::MIN as i128, i32::MAX as i128)),
            Self::U32 => Some((0, u32::MAX as i128)),
            Self::S64 => Some((i64::MIN as i128, i64::MAX as i128)),
            Self::U64 => Some((0, u64::MAX as i128)),
            Self::Float | Self::Port => None,
        }
    }
}

/// All types that a pin or parameter can be declared with.
pub const KINDS: &[Kind] = &[
    Kind { word: "bit", hal: Hal::Bit, handle: false },
    Kind { word: "float", hal: Hal::Float, handle: false },
    Kind { word: "signed", hal: Hal::S32, handle: false },
    Kind { word: "unsigned", hal: Hal::U32, handle: false },
    Kind { word: "s32", hal: Hal::S32, handle: false },
    Kind { word: "u32", hal: Hal::U32, handle: false },
    Kind { word: "s64", hal: Hal::S64, handle: false },
    Kind { word: "u64", hal: Hal::U64, handle: false },
    Kind { word: "port", hal: Hal::Port, handle: false },
    Kind { word: "bool", hal: Hal::Bit, handle: true },
    Kind { word: "real", hal: Hal::Float, handle: true },
    Kind { word: "sint", hal: Hal::S64, handle: true },
    Kind { word: "uint", hal: Hal::U64, handle: true },
    Kind { word: "si32", hal: Hal::S32, handle: true },
    Kind { word: "ui32", hal: Hal::U32, handle: true },
];

/// Value in a declaration.
#[derive(Clone, Debug, PartialEq)]
pub enum Value {
    /// `yes`, `no`, `true`, `false`, `TRUE`, `FALSE`.
    Truth(bool),
    /// Name with a meaning in C.
    Name(String),
    /// Integer.
    Whole(i128),
    /// Other number.
    Real(f64),
    /// Text, which only options take.
    Text(String),
}

/// Function of the component.
#[derive(Clone, Debug, PartialEq)]
pub struct Function {
    /// Name as written.
    pub name: At<String>,
    /// Declared use of floating point, if any.
    pub fp: Option<bool>,
    /// Description of the function.
    pub doc: Option<String>,
}

/// Variable of each instance.
#[derive(Clone, Debug, PartialEq)]
pub struct Variable {
    /// C type, without stars.
    pub c_type: String,
    /// Number of stars before the name.
    pub stars: usize,
    /// Name of the variable.
    pub name: At<String>,
    /// Array size, if the variable is an array.
    pub array: Option<At<String>>,
    /// Initial value.
    pub default: Option<Value>,
}

/// Parameter of the module.
#[derive(Clone, Debug, PartialEq)]
pub struct ModParam {
    /// True if declared `int`; otherwise the C text declares the variable itself, or nothing does.
    pub is_int: bool,
    /// Name of the parameter.
    pub name: At<String>,
    /// Default value.
    pub default: Option<Value>,
    /// Description of the parameter.
    pub doc: Option<String>,
}

/// Line `option NAME VALUE;`.
#[derive(Clone, Debug, PartialEq)]
pub struct OptionLine {
    /// Name of the option.
    pub name: At<String>,
    /// Value of the option; `None` means yes.
    pub value: Option<At<Value>>,
}

/// Kinds of text in a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[expect(missing_docs, reason = "they are what their declarations say")]
pub enum TextKind {
    SeeAlso,
    Notes,
    Description,
    Examples,
    License,
    Author,
}

/// Keywords of the text declarations.
pub const TEXTS: &[(&str, TextKind)] = &[
    ("see_also", TextKind::SeeAlso),
    ("notes", TextKind::Notes),
    ("description", TextKind::Description),
    ("examples", TextKind::Examples),
    ("license", TextKind::License),
    ("author", TextKind::Author),
];
