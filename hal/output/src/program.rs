//! The begin and the end of a program, as far as its output is concerned.

use crate::stdout::{close, reader_is_gone};
use signal_hook::{
    consts::{SIGPIPE, SIGXFSZ},
    flag, low_level,
};
use std::{
    io::Write,
    process::ExitCode,
    sync::{Arc, atomic::AtomicBool},
};

/// Runs a program with the words of its command line.
///
/// A file that would grow beyond the limit for files is then a write that fails, not the end of the
/// process. When `main` has returned and the reader of standard output has gone, the process ends by
/// SIGPIPE, as other programs of a pipeline do.
#[must_use]
pub fn program(main: fn(&[String]) -> ExitCode) -> ExitCode {
    // A signal that cannot be caught keeps its effect.
    drop(flag::register(SIGXFSZ, Arc::new(AtomicBool::new(false))));
    let words: Vec<String> =
        std::env::args_os().skip(1).map(|w| w.to_string_lossy().into_owned()).collect();
    let mut code = main(&words);
    if !reader_is_gone()
        && let Err(unwritten) = close()
    {
        // There is nowhere left to say that this could not be said.
        writeln!(std::io::stderr(), "{unwritten}").unwrap_or_default();
        if code == ExitCode::SUCCESS {
            code = ExitCode::FAILURE;
        }
    }
    if reader_is_gone() {
        // Does not return, unless the system refuses.
        drop(low_level::emulate_default_handler(SIGPIPE));
        return ExitCode::FAILURE;
    }
    code
}
