//! Questions of the interpreter to the machine, and the machine's answers.

use serde::{Deserialize, Serialize};

use crate::{axis::Position, function::Reply};

/// A question whose answer depends on motion that must be finished first.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum Request {
    /// A probing move; its calls were handed out.
    Probe,
    /// A tool change; its calls were handed out.
    ToolChange {
        /// The tool that was selected; 0 for none.
        tool: i32,
    },
    /// An input (M66).
    Input {
        /// The input's number.
        index: u32,
        /// An analog input.
        analog: bool,
        /// The L word: 0 at once, 1 rise, 2 fall, 3 high, 4 low.
        mode: u8,
        /// The time-out in seconds.
        timeout: f64,
    },
    /// Values of HAL that the next line reads. The line is run with the answer.
    Hal {
        /// The names of pins, parameters or signals, in lower case.
        names: Vec<Box<str>>,
    },
    /// The next step of the function of another language that is the innermost level of the state. Its calls so far
    /// need not have been run.
    Function {
        /// The function's name.
        name: Box<str>,
    },
    /// Nothing but the end of everything that was handed out.
    Finish,
    /// A user's program (M100 to M199). Lines behind it may depend on what it does, so they are read after its end.
    UserCode {
        /// The M number.
        code: u16,
        /// The P word, -1 without one.
        p: f64,
        /// The Q word, -1 without one.
        q: f64,
    },
}

/// The answer to a [`Request`]. Positions are machine coordinates in millimetres and degrees.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum Answer {
    /// The probing move ended.
    Probe {
        /// The place of the trip, or the end of the move.
        tripped_at: Position,
        /// The place where motion stopped.
        stopped_at: Position,
        /// The probe tripped.
        tripped: bool,
    },
    /// The tool changed.
    ToolChange {
        /// The place after the change, if the changer moved the machine.
        position: Option<Position>,
    },
    /// The input's value; -1 after a time-out.
    Input(f64),
    /// The values of HAL by their names, `None` for a name that nothing has.
    Hal(Vec<(Box<str>, Option<f64>)>),
    /// The step of a function.
    Function(Reply),
    /// The user's program ended well, or everything that was handed out has ended.
    Done,
    /// The request failed; the program ends with this reason.
    Failed(Box<str>),
}
