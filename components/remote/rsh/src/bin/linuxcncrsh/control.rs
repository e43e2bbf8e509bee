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
    /// Number of beats.
    beats: u32,
    /// True once a beat has permitted motion.
    permitted: bool,
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
    /// Notified when control is taken, and after each beat.
    changed: Condvar,
}

impl Control {
    /// Starts the thread that keeps the lease while a session has control.
    pub(crate) fn start(place: &Place) -> Result<Arc<Self>, String> {
        let client = Client::connect(place, "").map_err(|e| e.to_string())?;
        let table = Mutex::new(Holders { client, held: None });
        let control = Arc::new(Self { table, changed: Condvar::new() });
        let shared = control.clone();
        let begun = thread::Builder::new().name("lease".to_owned()).spawn(move || shared.keep());
        begun.map_err(|e| hal_output::reason(&e))?;
        Ok(control)
    }

    fn lock(&self) -> MutexGuard<'_, Holders> {
        self.table.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn wait_while<'a>(
        &self,
        table: MutexGuard<'a, Holders>,
        is_so: impl Fn(&Holders) -> bool,
    ) -> MutexGuard<'a, Holders> {
        let waited = self.changed.wait_while(table, |table| is_so(table));
        waited.unwrap_or_else(PoisonError::into_inner)
    }

    /// Sends pulses back, as long as a session has control.
    fn keep(&self) {
        loop {
            self.wait_while(self.lock(), |table| table.held.is_none()).beat();
            self.changed.notify_all();
            crate::pause(INTERVAL);
        }
    }

    /// Gives control to a session, also from another one of this program.
    pub(crate) fn take(&self, session: u64) -> Result<(), String> {
        let mut table = self.lock();
        let Some(lease) = table.take(session)? else { return Ok(()) };
        // The thread keeps the lease from here on.
        self.changed.notify_all();
        let own = |table: &Holders| table.held.filter(|held| held.lease == lease);
        table = self.wait_while(table, |table| {
            own(table).is_some_and(|held| !held.permitted && held.beats < MAX_FIRST)
        });
        match own(&table) {
            Some(held) if held.permitted => Ok(()),
            Some(_) => {
                table.give();
                Err("the machine permits no motion from afar: remote.allow-motion is FALSE, or its thread does not run".to_owned())
            }
            None => Err("control has ended again, or another connection has it".to_owned()),
        }
    }

    /// Takes control from a session, if it has it: its jogs stop.
    pub(crate) fn give(&self, session: u64) {
        let mut table = self.lock();
        if table.held.is_some_and(|held| held.session == session) {
            table.give();
        }
    }

    /// Returns whether a session has control, which the plugin confirms: this program may have stood still meanwhile, and
    /// somebody else may have taken the lease by another program.
    pub(crate) fn has(&self, session: u64) -> bool {
        let mut table = self.lock();
        let is_held = |table: &Holders| table.held.is_some_and(|held| held.session == session);
        is_held(&table) && {
            table.beat();
            is_held(&table)
        }
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
    /// Takes the lease for a session. Returns its number, or nothing if the session has it already.
    fn take(&mut self, session: u64) -> Result<Option<u64>, String> {
        let mut args = vec!["holder=linuxcncrsh".to_owned()];
        if let Some(held) = self.held {
            if held.session == session {
                return Ok(None);
            }
            args.push(format!("from={}", held.lease));
        }
        let lines = self.ask("remote.take", args)?;
        let lease = number(&lines, "lease=").ok_or("the machine gave no lease")?;
        self.held = Some(Held { session, lease, pulse: 0, beats: 0, permitted: false });
        Ok(Some(lease))
    }

    fn ask(&mut self, name: &str, args: Vec<String>) -> Result<Vec<String>, String> {
        match self.client.call(Request::Command { name: name.to_owned(), args }) {
            Ok(Reply::Answer(answer)) => Ok(answer.lines),
            Ok(_) => Ok(Vec::new()),
            Err(why) => Err(why.text),
        }
    }

    /// Sends the last pulse back. An error ends control: the plugin has ended the lease.
    fn beat(&mut self) {
        let Some(held) = self.held else { return };
        let args = vec![format!("lease={}", held.lease), format!("pulse={}", held.pulse)];
        self.held = self.ask("remote.beat", args).ok().map(|lines| Held {
            pulse: number(&lines, "pulse=").unwrap_or(0),
            beats: held.beats.saturating_add(1),
            permitted: held.permitted || lines.iter().any(|line| line.contains("permit=TRUE")),
            ..held
        });
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
