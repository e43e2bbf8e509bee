//! The environment: the interpreter's questions to the world and the world's answers.

use std::sync::Arc;

use serde::{Deserialize, Serialize};

use crate::{axis::Position, remap::Hook, state::State, tool::Tool};

/// The text of a file; a mapped file stays outside of the heap.
pub type Text = Arc<dyn AsRef<[u8]> + Send + Sync>;

/// The facts that the interpreter reads while it runs. The library itself reads no file and no device.
pub trait Environment {
    /// Returns the text of a file that a program calls: a name without ending, or a program's name as it was loaded.
    fn open(&self, name: &str) -> Option<Text>;

    /// Returns a tool of the tool table, in the machine's unit.
    fn tool(&self, number: i32) -> Option<Tool>;

    /// Returns a number of the INI file. Section and key are in lower case.
    fn ini(&self, _section: &str, _key: &str) -> Option<f64> {
        None
    }

    /// Returns the value of a HAL pin, signal or parameter.
    fn hal(&self, _name: &str) -> Option<f64> {
        None
    }

    /// Runs a function that a remap names, `None` if there is none of this name. A prolog may set parameters of the
    /// innermost level, which is that of the subroutine.
    fn hook(&self, _hook: Hook, _name: &str, _state: &mut State) -> Option<Result<(), Box<str>>> {
        None
    }

    /// Tells whether the user's program `M100` to `M199` exists.
    fn user_code(&self, _code: u16) -> bool {
        false
    }
}

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
    /// The request failed; the program ends with this reason.
    Failed(Box<str>),
}
