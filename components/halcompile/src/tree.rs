//! What a .comp file says, declaration by declaration, each with its place.

use crate::{expr::Expr, place::Span};

/// Something with its place.
#[derive(Clone, Debug, PartialEq)]
pub struct At<T> {
    /// What it is.
    pub value: T,
    /// Where it stands.
    pub span: Span,
}

/// A file as it is written.
#[derive(Clone, Debug, PartialEq)]
pub struct Tree {
    /// The name after `component`.
    pub name: At<String>,
    /// Its text.
    pub doc: Option<String>,
    /// Everything after it, in order.
    pub declarations: Vec<Declaration>,
    /// The C text after `;;`.
    pub body: Body,
}

/// The C text of a file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Body {
    /// As it is written.
    pub text: String,
    /// The line of the file on which it begins, from 1.
    pub line: usize,
}

/// One declaration.
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
    /// `include`: what stands behind it, with its brackets or quotes.
    Include(At<String>),
    /// `description`, `license` and their kind.
    Text(TextKind, At<String>),
}

/// A pin or a parameter.
#[derive(Clone, Debug, PartialEq)]
pub struct Item {
    /// Direction, which also tells a pin from a parameter.
    pub direction: Direction,
    /// Type.
    pub kind: Kind,
    /// The name as written.
    pub name: At<String>,
    /// How many of them.
    pub array: Option<Array>,
    /// What it starts with.
    pub default: Option<At<Value>>,
    /// Which instances have it.
    pub condition: Option<Expr>,
    /// Its text.
    pub doc: Option<String>,
}

impl Item {
    /// Whether it is a pin.
    #[must_use]
    pub const fn is_pin(&self) -> bool {
        matches!(self.direction, Direction::In | Direction::Out | Direction::Io)
    }
}

/// The size of an array.
#[derive(Clone, Debug, PartialEq)]
pub struct Array {
    /// The most there can be.
    pub max: At<u32>,
    /// How many an instance has, where that depends on its personality.
    pub size: Option<Expr>,
}

/// Who writes an item.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Direction {
    /// A pin that the component reads.
    In,
    /// A pin that it writes.
    Out,
    /// A pin that it does both with.
    Io,
    /// A parameter that it reports.
    R,
    /// A parameter that the user sets.
    Rw,
}

impl Direction {
    /// Its constant in C.
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

    /// As a user reads it.
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

/// The type of an item: which storage C code sees, and which HAL type it is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Kind {
    /// As written.
    pub word: &'static str,
    /// Its HAL type.
    pub hal: Hal,
    /// Whether C code reaches it by `hal_get_…` and `hal_set_…` alone.
    pub handle: bool,
}

/// The types of HAL.
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
    /// Its name, as `show` prints it and as it stands in the names of C functions.
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

    /// The whole numbers it can hold.
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

/// Every type a pin or parameter can be declared with.
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

/// A value in a declaration.
#[derive(Clone, Debug, PartialEq)]
pub enum Value {
    /// `yes`, `no`, `true`, `false`, `TRUE`, `FALSE`.
    Truth(bool),
    /// A name that means something in C.
    Name(String),
    /// A whole number.
    Whole(i128),
    /// Any other number.
    Real(f64),
    /// A text, which only options take.
    Text(String),
}

/// A function.
#[derive(Clone, Debug, PartialEq)]
pub struct Function {
    /// The name as written.
    pub name: At<String>,
    /// Whether it says that it uses floating point.
    pub fp: Option<bool>,
    /// Its text.
    pub doc: Option<String>,
}

/// A variable of each instance.
#[derive(Clone, Debug, PartialEq)]
pub struct Variable {
    /// Its C type, without stars.
    pub c_type: String,
    /// How many stars stand before its name.
    pub stars: usize,
    /// Its name.
    pub name: At<String>,
    /// How many of them.
    pub array: Option<At<String>>,
    /// What it starts with.
    pub default: Option<Value>,
}

/// A parameter of the module.
#[derive(Clone, Debug, PartialEq)]
pub struct ModParam {
    /// `int`; without it the C text declares the variable itself, or nobody does.
    pub is_int: bool,
    /// Its name.
    pub name: At<String>,
    /// What it is when not given.
    pub default: Option<Value>,
    /// Its text.
    pub doc: Option<String>,
}

/// A line `option NAME VALUE;`.
#[derive(Clone, Debug, PartialEq)]
pub struct OptionLine {
    /// Which one.
    pub name: At<String>,
    /// What it is to be; nothing means yes.
    pub value: Option<At<Value>>,
}

/// The texts that a file can hold.
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

/// The declarations that are texts.
pub const TEXTS: &[(&str, TextKind)] = &[
    ("see_also", TextKind::SeeAlso),
    ("notes", TextKind::Notes),
    ("description", TextKind::Description),
    ("examples", TextKind::Examples),
    ("license", TextKind::License),
    ("author", TextKind::Author),
];
