//! What has to be said while a person types: above the line, not into it.

use rustyline::ExternalPrinter;
use std::{
    io::{self, Write},
    sync::{
        Mutex, PoisonError,
        atomic::{AtomicBool, Ordering},
        mpsc::{self, Sender},
    },
    thread,
};

/// Whether a person types right now.
static HELD: AtomicBool = AtomicBool::new(false);
/// Where texts go meanwhile. Whoever prints them may have to wait for the editor, so that is a
/// thread of its own.
static PRINT: Mutex<Option<Sender<String>>> = Mutex::new(None);

/// From here on, texts are held back for the editor, or no longer.
pub(super) fn hold(yes: bool) {
    // Lone: a text that comes in between goes one way or the other.
    HELD.store(yes, Ordering::Relaxed);
}

/// Prints texts with this printer of the editor's.
pub(super) fn print_with(mut printer: impl ExternalPrinter + Send + 'static) {
    let (sender, texts) = mpsc::channel::<String>();
    let run = move || {
        for text in texts {
            drop(printer.print(text));
        }
    };
    if thread::Builder::new().name("messages".to_owned()).spawn(run).is_ok() {
        *PRINT.lock().unwrap_or_else(PoisonError::into_inner) = Some(sender);
    }
}

/// While it lives, texts are kept; then they are printed. For those who have the whole screen.
#[derive(Debug)]
pub(crate) struct Kept(());

/// What is kept; none: nobody has the screen.
static KEPT: Mutex<Option<Vec<u8>>> = Mutex::new(None);

impl Kept {
    pub(crate) fn new() -> Self {
        *KEPT.lock().unwrap_or_else(PoisonError::into_inner) = Some(Vec::new());
        Self(())
    }
}

impl Drop for Kept {
    fn drop(&mut self) {
        let kept = KEPT.lock().unwrap_or_else(PoisonError::into_inner).take();
        io::stderr().write_all(&kept.unwrap_or_default()).unwrap_or_default();
    }
}

/// Standard error, or the space above the prompt.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Aside;

impl Write for Aside {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        if let Some(kept) = &mut *KEPT.lock().unwrap_or_else(PoisonError::into_inner) {
            kept.extend_from_slice(bytes);
            return Ok(bytes.len());
        }
        // Lone, as above.
        if HELD.load(Ordering::Relaxed)
            && rustix::termios::isatty(io::stderr())
            && let Some(print) = &*PRINT.lock().unwrap_or_else(PoisonError::into_inner)
            && print.send(String::from_utf8_lossy(bytes).into_owned()).is_ok()
        {
            return Ok(bytes.len());
        }
        io::stderr().write(bytes)
    }

    fn flush(&mut self) -> io::Result<()> {
        io::stderr().flush()
    }
}
