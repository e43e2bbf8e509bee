//! The audit log: who did what, a line of JSON for each, only ever appended.

use crate::error::Error;
use serde_json::{Value as Json, json};
use std::{
    fs::{File, OpenOptions},
    io::Write as _,
    os::unix::fs::OpenOptionsExt as _,
    path::Path,
    sync::Mutex,
    time::{SystemTime, UNIX_EPOCH},
};

/// The log.
#[derive(Debug)]
pub(crate) struct Audit(Mutex<File>);

impl Audit {
    /// Opens the log of this name.
    pub(crate) fn open(path: &Path) -> Result<Self, String> {
        let file = OpenOptions::new().append(true).create(true).mode(0o600).open(path);
        let file = file.map_err(|e| format!("{}: {}", path.display(), hal_output::reason(&e)))?;
        Ok(Self(Mutex::new(file)))
    }

    /// Adds what somebody did, and how it ended.
    pub(crate) fn note(&self, user: &str, client: u64, what: &Json, end: Result<(), &Error>) {
        let time = SystemTime::now().duration_since(UNIX_EPOCH).unwrap_or_default();
        let end = end.map_or_else(|e| json!(e.code), |()| json!("ok"));
        let line = json!({
            "time": time.as_secs_f64(), "user": user, "client": client, "what": what, "end": end,
        });
        if let Ok(mut file) = self.0.lock() {
            // A full disk must not keep anybody from an abort.
            drop(file.write_all(format!("{line}\n").as_bytes()));
        }
    }
}
