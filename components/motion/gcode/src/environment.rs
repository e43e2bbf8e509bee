//! The environment: the facts that the interpreter reads while it runs.

use std::sync::Arc;

use crate::tool::Tool;

/// The text of a file.
pub type Text = Arc<dyn Source + Send + Sync>;

/// Bytes that are read in parts, such as those of a file.
pub trait Source {
    /// Reads bytes from `offset` on into the buffer, and returns their number; 0 at the end.
    ///
    /// # Errors
    /// The bytes cannot be read, or are no longer those that were there; the reason.
    fn read_at(&self, offset: u64, buffer: &mut [u8]) -> Result<usize, Box<str>>;
}

impl Source for Vec<u8> {
    fn read_at(&self, offset: u64, buffer: &mut [u8]) -> Result<usize, Box<str>> {
        let from = usize::try_from(offset).unwrap_or(usize::MAX);
        let rest = self.get(from..).unwrap_or_default();
        let count = rest.len().min(buffer.len());
        if let (Some(to), Some(from)) = (buffer.get_mut(..count), rest.get(..count)) {
            to.copy_from_slice(from);
        }
        Ok(count)
    }
}

/// The facts that the interpreter reads while it runs. The library itself reads no file and no device.
pub trait Environment {
    /// Returns the text of a file that a program calls: a name without ending, or a program's name as it was loaded.
    fn open(&self, name: &str) -> Option<Text>;

    /// Returns why a file of this name, which is there, is not read.
    fn refusal(&self, _name: &str) -> Option<Box<str>> {
        None
    }

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

    /// Tells whether `o<name> call` calls a function of another language.
    fn function(&self, _name: &str) -> bool {
        false
    }

    /// Returns the place of a tool in the tool table, as functions of another language number it.
    fn tool_slot(&self, number: i32) -> Option<i32> {
        self.tool(number).map(|t| t.pocket)
    }

    /// Tells whether the user's program `M100` to `M199` exists.
    ///
    /// # Errors
    /// The program exists and is not run; the reason.
    fn user_code(&self, _code: u16) -> Result<bool, Box<str>> {
        Ok(false)
    }
}
