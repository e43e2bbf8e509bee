//! Output above the line that a person is typing.

use rustyline::ExternalPrinter;
use std::{
    collections::VecDeque,
    io::{self, Write},
    sync::{
        Mutex, PoisonError,
        atomic::{AtomicBool, Ordering},
        mpsc::{self, Sender},
    },
    thread,
};

/// True while a person is typing.
static HELD: AtomicBool = AtomicBool::new(false);
/// Channel for texts during editing. A thread of its own prints them, because printing may have to
/// wait for the editor.
static PRINT: Mutex<Option<Sender<String>>> = Mutex::new(None);

/// Redirects texts to the editor, or stops redirecting them.
pub(super) fn hold(yes: bool) {
    // Unpaired: a text that comes at the same moment may go either way.
    HELD.store(yes, Ordering::Relaxed);
}

/// Prints redirected texts with this printer of the editor.
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

/// Collects texts while it exists, and prints them at its end. For views that use the whole screen.
#[derive(Debug)]
pub(crate) struct Kept(());

/// Collected texts; `None` while no view has the screen.
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

/// Number of texts that are remembered.
const REMEMBERED: usize = 64;
/// The last texts.
static SAID: Mutex<VecDeque<String>> = Mutex::new(VecDeque::new());

/// Returns whether one of the last messages of components had this text.
pub(crate) fn was_said(text: &str) -> bool {
    let said = SAID.lock().unwrap_or_else(PoisonError::into_inner);
    said.iter()
        .any(|line| line.trim_end().strip_suffix(text).is_some_and(|name| name.ends_with(": ")))
}

fn remember(bytes: &[u8]) {
    let mut said = SAID.lock().unwrap_or_else(PoisonError::into_inner);
    said.push_back(String::from_utf8_lossy(bytes).into_owned());
    if said.len() > REMEMBERED {
        said.pop_front();
    }
}

/// Standard error, or the space above the prompt.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Aside;

impl Write for Aside {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        remember(bytes);
        if let Some(kept) = &mut *KEPT.lock().unwrap_or_else(PoisonError::into_inner) {
            kept.extend_from_slice(bytes);
            return Ok(bytes.len());
        }
        // Unpaired, as above.
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
