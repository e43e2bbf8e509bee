//! Start and end of a program, as far as its output is concerned.

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

/// Runs a program with its command-line arguments.
///
/// A file that exceeds the file size limit causes a failed write and does not end the process. If
/// the reader of standard output has closed its end when `main` returns, the process ends with
/// SIGPIPE, like other programs in a pipeline.
#[must_use]
pub fn program(main: fn(&[String]) -> ExitCode) -> ExitCode {
    // If the handler cannot be installed, the signal keeps its default action.
    drop(flag::register(SIGXFSZ, Arc::new(AtomicBool::new(false))));
    let words: Vec<String> =
        std::env::args_os().skip(1).map(|w| w.to_string_lossy().into_owned()).collect();
    let mut code = main(&words);
    if !reader_is_gone()
        && let Err(unwritten) = close()
    {
        // If standard error fails too, the failure cannot be reported anywhere.
        writeln!(std::io::stderr(), "{unwritten}").unwrap_or_default();
        if code == ExitCode::SUCCESS {
            code = ExitCode::FAILURE;
        }
    }
    if reader_is_gone() {
        // Returns only if the system refuses.
        drop(low_level::emulate_default_handler(SIGPIPE));
        return ExitCode::FAILURE;
    }
    code
}
