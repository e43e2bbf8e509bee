//! Output of text for people.

pub(crate) mod colour;
pub(crate) mod screen;
pub mod termination;

use hal_output::{Unwritten, print, reader_is_gone};
use std::{io::Write, process::ExitCode};

/// Standard output and standard error, or a replacement.
pub trait Terminal {
    /// Writes to standard output, as it is.
    ///
    /// # Errors
    /// The text could not be written.
    fn out(&mut self, text: &str) -> Result<(), Unwritten>;
    /// Writes to standard error, as it is.
    fn err(&mut self, text: &str);
    /// Returns whether a person reads standard error. Errors then show the line with a mark.
    fn is_person(&self) -> bool {
        false
    }
    /// Returns whether that person sees colours.
    fn is_coloured(&self) -> bool {
        false
    }

    /// Returns whether a person has a screen and a keyboard.
    fn is_screen(&self) -> bool {
        false
    }
}

/// This process's own output. Errors of standard error are ignored, because there is no place to
/// report them.
#[derive(Clone, Copy, Debug, Default)]
pub struct Stdio;

impl Terminal for Stdio {
    fn out(&mut self, text: &str) -> Result<(), Unwritten> {
        print(text)
    }

    fn err(&mut self, text: &str) {
        std::io::stderr().lock().write_all(text.as_bytes()).unwrap_or_default();
    }

    fn is_person(&self) -> bool {
        rustix::termios::isatty(std::io::stderr())
    }

    fn is_coloured(&self) -> bool {
        hal_output::is_coloured(std::io::stderr())
    }

    fn is_screen(&self) -> bool {
        hal_output::is_person()
    }
}

/// Returns the exit status of a small program, and prints its error.
pub(crate) fn ended(result: Result<(), String>) -> ExitCode {
    match result {
        Ok(()) => ExitCode::SUCCESS,
        Err(text) => {
            print_error(&format!("{text}\n"));
            ExitCode::FAILURE
        }
    }
}

/// Prints the error of a program, unless the error is only that the reader of its output is gone. It may quote a file:
/// control characters in it do not reach the terminal.
pub(crate) fn print_error(text: &str) {
    if !reader_is_gone() {
        Stdio.err(&colour::visible(text));
    }
}

/// Keeps both outputs, in the order of writing, and each separately.
#[derive(Clone, Debug, Default)]
pub struct Captured {
    /// Both outputs.
    pub all: String,
    /// Standard output.
    pub out: String,
    /// Standard error.
    pub err: String,
    /// True if it stands for a terminal.
    pub person: bool,
}

impl Terminal for Captured {
    fn out(&mut self, text: &str) -> Result<(), Unwritten> {
        self.all.push_str(text);
        self.out.push_str(text);
        Ok(())
    }

    fn err(&mut self, text: &str) {
        self.all.push_str(text);
        self.err.push_str(text);
    }

    fn is_person(&self) -> bool {
        self.person
    }
}
