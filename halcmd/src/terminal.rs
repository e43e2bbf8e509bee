//! Where text for people goes.

use hal_output::{Unwritten, print, reader_is_gone};
use std::{io::Write, process::ExitCode};

/// Standard output and standard error, or what stands for them.
pub trait Terminal {
    /// Writes to standard output, as it is.
    ///
    /// # Errors
    /// The text could not be written.
    fn out(&mut self, text: &str) -> Result<(), Unwritten>;
    /// Writes to standard error, as it is.
    fn err(&mut self, text: &str);
    /// Whether a person reads standard error: then errors show the line and point into it.
    fn is_person(&self) -> bool {
        false
    }
    /// Whether that person sees colours.
    fn is_coloured(&self) -> bool {
        false
    }

    /// Whether a person looks at a screen and has a keyboard.
    fn is_screen(&self) -> bool {
        false
    }
}

/// This process's own. Standard error that cannot be written to is no error: there is nowhere to say so.
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
        crate::colour::wanted(std::io::stderr())
    }

    fn is_screen(&self) -> bool {
        crate::colour::is_person()
    }
}

/// How a small program ends: well, or with a complaint.
pub(crate) fn ended(result: Result<(), String>) -> ExitCode {
    match result {
        Ok(()) => ExitCode::SUCCESS,
        Err(text) => {
            complain(&format!("{text}\n"));
            ExitCode::FAILURE
        }
    }
}

/// Says why a program ends. That nobody reads its output any more is no news to the user.
pub(crate) fn complain(text: &str) {
    if !reader_is_gone() {
        Stdio.err(text);
    }
}

/// Keeps both, in the order of writing, and each by itself.
#[derive(Clone, Debug, Default)]
pub struct Captured {
    /// Both.
    pub all: String,
    /// Standard output.
    pub out: String,
    /// Standard error.
    pub err: String,
    /// Whether it stands for a terminal.
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
