//! Control of the machine: at most one session has it, under the control lease of remote operators.

use hal_protocol::{Client, Link as _, Place, Reply, Request};
use std::{
    sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError},
    thread,
    time::Duration,
};

/// Interval of the beats that keep the lease.
const INTERVAL: Duration = Duration::from_millis(20);
/// Number of beats until which a lease must permit motion.
const MAX_FIRST: u32 = 50;

#[derive(Clone, Copy, Debug)]
struct Held {
    session: u64,
    lease: u64,
    /// Pulse to send back.
    pulse: u64,
}

#[derive(Debug)]
struct Holders {
    client: Client,
    held: Option<Held>,
}

/// Control.
#[derive(Debug)]
pub(crate) struct Control {
    table: Mutex<Holders>,
    taken: Condvar,
}

impl Control {
    /// Starts the thread that keeps the lease while a session has control.
    pub(crate) fn start(place: &Place) -> Result<Arc<Self>, String> {
        let client = Client::connect(place, "").map_err(|e| e.to_string())?;
        let table = Mutex::new(Holders { client, held: None });
        let control = Arc::new(Self { table, taken: Condvar::new() });
        let shared = control.clone();
        let begun = thread::Builder::new().name("lease".to_owned()).spawn(move || shared.keep());
        begun.map_err(|e| hal_output::reason(&e))?;
        Ok(control)
    }

    fn lock(&self) -> MutexGuard<'_, Holders> {
        self.table.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Sends pulses back, as long as a session has control.
    fn keep(&self) {
        loop {
            let mut table = self.lock();
            while table.held.is_none() {
                table = self.taken.wait(table).unwrap_or_else(PoisonError::into_inner);
            }
            if table.beat().is_err() {
                // The plugin has ended the lease.
                table.held = None;
            }
            drop(table);
            crate::pause(INTERVAL);
        }
    }

    /// Gives control to a session, also from another one of this program.
    pub(crate) fn take(&self, session: u64) -> Result<(), String> {
        let mut table = self.lock();
        let mut args = vec!["holder=linuxcncrsh".to_owned()];
        if let Some(held) = table.held {
            if held.session == session {
                return Ok(());
            }
            args.push(format!("from={}", held.lease));
        }
        let lines = table.ask("remote.take", args)?;
        let lease = number(&lines, "lease=").ok_or("the machine gave no lease")?;
        table.held = Some(Held { session, lease, pulse: 0 });
        for _ in 0..MAX_FIRST {
            if table.beat()? {
                self.taken.notify_one();
                return Ok(());
            }
            crate::pause(INTERVAL);
        }
        table.give();
        Err("the machine permits no motion from afar: remote.allow-motion is FALSE, or its thread does not run".to_owned())
    }

    /// Takes control from a session, if it has it: its jogs stop.
    pub(crate) fn give(&self, session: u64) {
        let mut table = self.lock();
        if table.held.is_some_and(|held| held.session == session) {
            table.give();
        }
    }

    /// Returns whether a session has control.
    pub(crate) fn has(&self, session: u64) -> bool {
        self.lock().held.is_some_and(|held| held.session == session)
    }

    /// Jogs under the lease of a session.
    pub(crate) fn jog(&self, session: u64, mut args: Vec<String>) -> Result<(), String> {
        let mut table = self.lock();
        let held = table.held.filter(|held| held.session == session);
        let held = held.ok_or("this connection has no control: set enable PASSWORD")?;
        args.push(format!("lease={}", held.lease));
        table.ask("remote.jog", args).map(drop)
    }
}

impl Holders {
    fn ask(&mut self, name: &str, args: Vec<String>) -> Result<Vec<String>, String> {
        match self.client.call(Request::Command { name: name.to_owned(), args }) {
            Ok(Reply::Answer(answer)) => Ok(answer.lines),
            Ok(_) => Ok(Vec::new()),
            Err(why) => Err(why.text),
        }
    }

    /// Sends the last pulse back. Returns whether a held jog is permitted.
    fn beat(&mut self) -> Result<bool, String> {
        let Some(held) = self.held else { return Ok(false) };
        let args = vec![format!("lease={}", held.lease), format!("pulse={}", held.pulse)];
        let lines = self.ask("remote.beat", args)?;
        let pulse = number(&lines, "pulse=").unwrap_or(0);
        self.held = Some(Held { pulse, ..held });
        Ok(lines.iter().any(|line| line.contains("permit=TRUE")))
    }

    fn give(&mut self) {
        if let Some(held) = self.held.take() {
            // A lease that has ended already needs no end.
            drop(self.ask("remote.give", vec![format!("lease={}", held.lease)]));
        }
    }
}

/// Returns the number after a word.
fn number(lines: &[String], word: &str) -> Option<u64> {
    let rest = lines.iter().find_map(|line| line.strip_prefix(word))?;
    rest.split(' ').next()?.parse().ok()
}
