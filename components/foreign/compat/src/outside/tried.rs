//! Record of what a module has tried, and the messages about it.

use crate::{loading::loading, message::write_error, running};
use core::fmt::Write;
use hal_component::abi::level;
use std::sync::atomic::{AtomicBool, Ordering::Relaxed};

/// Remedy of a refusal.
pub(super) const REMEDY: &str = "`--stub NAME` replaces the component NAME by pins";

/// Text of limited length, made without memory.
struct ShortText {
    text: [u8; 400],
    used: usize,
}

impl ShortText {
    const fn new() -> Self {
        Self { text: [0; 400], used: 0 }
    }

    fn get(&self) -> &str {
        let text = self.text.get(..self.used).unwrap_or_default();
        core::str::from_utf8(text).unwrap_or_else(|e| {
            let whole = text.get(..e.valid_up_to()).unwrap_or_default();
            core::str::from_utf8(whole).unwrap_or_default()
        })
    }
}

impl Write for ShortText {
    fn write_str(&mut self, text: &str) -> core::fmt::Result {
        for byte in text.bytes() {
            let place = self.text.get_mut(self.used).ok_or(core::fmt::Error)?;
            *place = byte;
            self.used += 1;
        }
        Ok(())
    }
}

/// Realtime. Records that the running module has tried `what`, and says so once for each module. `about` is a path or
/// another detail, or empty.
pub(crate) fn note(what: &str, about: &str) {
    static TOLD: AtomicBool = AtomicBool::new(false);
    if let Some(l) = loading() {
        let tried = if about.is_empty() { what.to_owned() } else { format!("{what} '{about}'") };
        let mut all = l.tried.borrow_mut();
        if !all.contains(&tried) {
            all.push(tried);
        }
    }
    let module = running::module();
    if module.map_or(&TOLD, |m| &m.told_refusal).swap(true, Relaxed) {
        return;
    }
    let mut line = ShortText::new();
    let whose = if module.is_some() { "" } else { "a thread of a component in C: " };
    let quote = if about.is_empty() { "" } else { "'" };
    let gap = if about.is_empty() { "" } else { " " };
    // What does not fit is left out.
    let _fits = write!(
        line,
        "{whose}{what}{gap}{quote}{about}{quote} is refused: under --virtual and --simulate a component \
         in C reaches nothing outside"
    );
    match module {
        Some(m) => m.say(level::ERR, line.get()),
        None => write_error(&[line.get(), "\n"]),
    }
}

/// Returns the end of the reason of a failed setup that tried these, which begins with a semicolon, or nothing.
pub(crate) fn suffix(name: &str, tried: &[String]) -> String {
    if tried.is_empty() {
        return String::new();
    }
    format!(
        "; it tried {}, and under --virtual and --simulate a component in C reaches nothing outside: \
         `--stub {name}` replaces it by pins",
        tried.join(", ")
    )
}
