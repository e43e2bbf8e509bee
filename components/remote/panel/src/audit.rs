//! The audit log: who did what, a line of JSON for each, only ever appended.

use crate::error::{Code, Error};
use serde_json::{Value as Json, json};
use std::{
    fs::{File, OpenOptions},
    io::Write as _,
    os::unix::fs::OpenOptionsExt as _,
    path::Path,
    sync::{Mutex, PoisonError},
    time::{Duration, SystemTime, UNIX_EPOCH},
};
use tokio::time::Instant;

/// Number of refused logins that are noted in each span of time: strangers must not fill the disk.
const MAX_REFUSALS: u32 = 10;
const SPAN: Duration = Duration::from_secs(10);

/// The log.
#[derive(Debug)]
pub(crate) struct Audit {
    file: Mutex<File>,
    refusals: Mutex<Refusals>,
}

/// Refused logins since a moment.
#[derive(Debug, Default)]
struct Refusals {
    since: Option<Instant>,
    noted: u32,
    left_out: u64,
}

impl Refusals {
    /// Counts a refused login, and returns whether it is noted.
    fn note(&mut self) -> bool {
        let notes = self.noted < MAX_REFUSALS;
        self.noted += u32::from(notes);
        self.left_out += u64::from(!notes);
        notes
    }

    /// Begins another span if one is over; returns the number of logins that were left out in it.
    fn begin(&mut self, now: Instant) -> u64 {
        if self.since.is_some_and(|since| now - since <= SPAN) {
            return 0;
        }
        core::mem::replace(self, Self { since: Some(now), ..Self::default() }).left_out
    }
}

impl Audit {
    /// Opens the log of this name.
    pub(crate) fn open(path: &Path) -> Result<Self, String> {
        let file = OpenOptions::new().append(true).create(true).mode(0o600).open(path);
        let file = file.map_err(|e| format!("{}: {}", path.display(), hal_output::reason(&e)))?;
        Ok(Self { file: Mutex::new(file), refusals: Mutex::default() })
    }

    /// Adds a login. Of those that are refused in haste, only the number is noted, with the next login after a while.
    pub(crate) fn note_login(&self, user: &str, what: &str, end: Result<(), &Error>) {
        let (left_out, notes) = {
            let mut refusals = self.refusals.lock().unwrap_or_else(PoisonError::into_inner);
            (refusals.begin(Instant::now()), end.is_ok() || refusals.note())
        };
        if left_out > 0 {
            let haste = Error::new(Code::TooMany, "refused logins");
            self.note("", 0, &json!({ "refused sign-ins": left_out }), Err(&haste));
        }
        if notes {
            self.note(user, 0, &json!(what), end);
        }
    }

    /// Adds what somebody did, and how it ended.
    pub(crate) fn note(&self, user: &str, client: u64, what: &Json, end: Result<(), &Error>) {
        let time = SystemTime::now().duration_since(UNIX_EPOCH).unwrap_or_default();
        let end = end.map_or_else(|e| json!(e.code), |()| json!("ok"));
        let line = json!({
            "time": time.as_secs_f64(), "user": user, "client": client, "what": what, "end": end,
        });
        if let Ok(mut file) = self.file.lock() {
            // A full disk must not keep anybody from an abort.
            drop(file.write_all(format!("{line}\n").as_bytes()));
        }
    }
}

#[cfg(test)]
mod tests {
    //! Refused logins that come in haste.

    use super::{Audit, Code, Error, Instant, MAX_REFUSALS, Refusals, SPAN};

    #[test]
    fn logins_that_are_refused_in_haste_are_counted() {
        let (mut refusals, now) = (Refusals::default(), Instant::now());
        for at in [now, now + SPAN + SPAN] {
            assert_eq!(refusals.begin(at), if at == now { 0 } else { 990 });
            let noted = (0..1000).filter(|_| refusals.begin(at + SPAN) == 0 && refusals.note());
            assert_eq!(noted.count(), 10);
        }
        let file = std::env::temp_dir().join(format!("halpanel-audit-{}", std::process::id()));
        let (audit, why) = (Audit::open(&file).unwrap(), Error::new(Code::WrongLogin, "wrong"));
        for _ in 0..1000 {
            audit.note_login("x", "sign-in", Err(&why));
        }
        audit.note_login("ana", "sign-in", Ok(()));
        let text = std::fs::read_to_string(&file).unwrap();
        std::fs::remove_file(file).unwrap();
        // A slow computer may begin another span.
        let lines = text.lines().count();
        assert!(lines <= 5 * MAX_REFUSALS as usize, "{lines} lines");
        assert!(text.lines().last().is_some_and(|line| line.contains("ana")), "{text}");
    }
}
