//! Functions of another language that a program calls: those of remaps, and of O-words.
//!
//! The library runs none of them. A call is a level of the program ([`crate::state::LevelKind::Function`]). While it is
//! the innermost one, the interpreter asks its host for the function's next step ([`crate::Request::Function`]), and the
//! host answers with a [`Reply`]: what the function has changed, and what it waits for.

use serde::{Deserialize, Serialize};

use crate::tool::Tool;

/// The part of a function in a program.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Hook {
    /// `prolog=`: runs before the subroutine of a remap.
    Prolog,
    /// `epilog=`: runs after it.
    Epilog,
    /// `py=` or `python=`: runs instead of one.
    Body,
    /// `o<name> call`.
    Word,
}

impl Hook {
    /// Returns the option of a remap that names the function.
    pub fn option(self) -> &'static str {
        match self {
            Self::Prolog => "prolog",
            Self::Epilog => "epilog",
            Self::Body => "py",
            Self::Word => "o",
        }
    }
}

/// A call in progress.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Function {
    /// The part in the program.
    pub hook: Hook,
    /// The name.
    pub name: Box<str>,
    /// The arguments without a name.
    pub arguments: Vec<f64>,
    /// The arguments with a name: words of the line.
    pub words: Vec<(Box<str>, f64)>,
    /// The number of the call, counted over the run.
    pub serial: u64,
    /// The number of turns so far.
    pub turns: u64,
    /// The next thing that happens.
    pub turn: Turn,
    /// A tool change that the function has ordered, and whose end is not known.
    pub changing: Option<i32>,
    /// The tool before the function set `current_tool`, until a canonical call tells the machine of the new one.
    pub stated: Option<Tool>,
}

/// State of a call between two steps.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum Turn {
    /// The function begins.
    Begin,
    /// The function waits for the end of this line.
    Executing(Box<str>),
    /// The line has ended.
    Executed(Option<Failure>),
    /// The function waits until the machine has done everything.
    Finishing,
    /// The machine has done everything.
    Finished,
    /// The function waits for a value.
    Asking(Wanted),
    /// The value; `None` if there is none.
    Value(Option<f64>),
    /// The function has ended with this value.
    Leaving(Option<f64>),
}

/// A value that a function reads.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum Wanted {
    /// A named parameter, in lower case.
    Name(Box<str>),
    /// The place of a tool in the tool table.
    Slot(i32),
}

/// An error of lines that a function has executed.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Failure {
    /// The line that failed, from 1.
    pub line: u32,
    /// The text that was executed.
    pub text: Box<str>,
    /// The message.
    pub message: Box<str>,
}

/// The answer of a function's host: a step of the function.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Reply {
    /// The effects of the function, in this order.
    pub effects: Vec<Effect>,
    /// The request of the function, or its end.
    pub next: Next,
}

/// Something that a function does to the interpreter.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum Effect {
    /// Sets a numbered parameter.
    Number(i32, f64),
    /// Sets a named parameter.
    Name(Box<str>, f64),
    /// Sets a field of the interpreter.
    Field(Box<str>, f64),
    /// Makes a canonical call.
    Call(Box<str>, Vec<CallWord>),
}

/// An argument of a canonical call.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(untagged)]
pub enum CallWord {
    /// A number.
    Number(f64),
    /// A text.
    Text(Box<str>),
}

/// The request of a function, or its end.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum Next {
    /// Executes a line.
    Execute(Box<str>),
    /// Waits until the machine has done everything.
    Finish,
    /// Reads a value.
    Ask(Wanted),
    /// Ends, with the value of an O-word.
    Done(Option<f64>),
    /// Fails, with the reason.
    Fail(Box<str>),
}
