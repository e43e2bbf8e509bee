//! Pins of the panel: pulses from the servo thread, the beats that answer them, and the pins of teleoperation.

use crate::lease::Beating;
use hal_protocol::{Client, Direction, Kind, Link as _, PinPage, Place, Reply, Request, Type};
use std::{
    sync::{
        Arc,
        atomic::{
            AtomicBool, AtomicU32,
            Ordering::{Acquire, Relaxed, Release},
        },
    },
    thread,
};

/// Interval of the exchange, in nanoseconds of machine time.
const INTERVAL_NS: u64 = 4_000_000;
/// Pins, in the order of their creation, with the signal and the pin of `remote` that each is linked with, if any.
const PINS: &[(&str, Type, Direction, &str, &str)] = &[
    ("halpanel.pulse", Type::U32, Direction::In, "remote-pulse", "remote.pulse"),
    ("halpanel.beat", Type::U32, Direction::Out, "remote-beat", "remote.beat"),
    ("halpanel.clients", Type::U32, Direction::Out, "remote-clients", "remote.clients"),
    ("halpanel.lease", Type::U32, Direction::In, "remote-lease", "remote.lease"),
    ("halpanel.permit", Type::Bit, Direction::In, "remote-permit", "remote.permit"),
    ("halpanel.hold", Type::Bit, Direction::In, "remote-hold", "remote.hold"),
    ("halpanel.allowed", Type::Bit, Direction::In, "remote-allowed", "remote.allowed"),
    ("teleop.serve", Type::Bit, Direction::Io, "", ""),
    ("teleop.port", Type::U32, Direction::Io, "", ""),
    ("teleop.listening", Type::U32, Direction::Out, "", ""),
    ("teleop.sessions", Type::U32, Direction::Out, "", ""),
    ("teleop.running", Type::Bit, Direction::Out, "", ""),
    ("teleop.link-ok", Type::Bit, Direction::Out, "", ""),
    ("teleop.progress", Type::U32, Direction::Out, "", ""),
];
const PULSE: usize = 0;
const BEAT: usize = 1;
const CLIENTS: usize = 2;
const LEASE: usize = 3;
const PERMIT: usize = 4;
const HOLD: usize = 5;
const ALLOWED: usize = 6;
const SERVE: usize = 7;
const PORT: usize = 8;
const LISTENING: usize = 9;
const SESSIONS: usize = 10;
const RUNNING: usize = 11;
const LINK_OK: usize = 12;
const PROGRESS: usize = 13;

/// Values of the pins. Each stands alone: none is read as proof of another.
#[derive(Debug, Default)]
pub(crate) struct Heart {
    /// Number that the servo thread made last.
    pub(crate) pulse: AtomicU32,
    /// Number that the holder of the lease sent back last.
    pub(crate) beat: AtomicU32,
    /// Number of clients.
    pub(crate) clients: AtomicU32,
    /// Number of the lease in the engine; 0 without one.
    pub(crate) lease: AtomicU32,
    /// True while a held jog is permitted.
    pub(crate) permit: AtomicBool,
    /// True while a program is held since the lease was lost.
    pub(crate) hold: AtomicBool,
    /// True while the machine's wiring allows motion from afar.
    pub(crate) allowed: AtomicBool,
    /// Number of the lease of a teleoperated job, under which this program sends pulses back; 0 without one.
    keeps: AtomicU32,
    /// Machine time in milliseconds up to which it does: the silence of that job's client ends the beats.
    pub(crate) answers_until: AtomicU32,
    /// Pins of teleoperation.
    pub(crate) teleop: Teleop,
}

/// Values of the pins of teleoperation.
#[derive(Debug, Default)]
pub(crate) struct Teleop {
    /// True while the server shall listen.
    pub(crate) serve: AtomicBool,
    /// Port at which it shall.
    pub(crate) port: AtomicU32,
    /// True once it cannot: ends the wish at the pin.
    pub(crate) refused: AtomicBool,
    /// Port at which it listens; 0 while it does not.
    pub(crate) listening: AtomicU32,
    /// Number of users that are logged in.
    pub(crate) sessions: AtomicU32,
    /// True while a job of a client runs.
    pub(crate) running: AtomicBool,
    /// True unless the client of that job has vanished or is silent.
    pub(crate) link_ok: AtomicBool,
    /// Progress in percent.
    pub(crate) progress: AtomicU32,
}

impl Heart {
    /// Begins to send pulses back under the lease of a teleoperated job; 0 ends it.
    pub(crate) fn keep(&self, lease: u64) {
        self.keeps.store(u32::try_from(lease).unwrap_or(0), Relaxed);
    }

    /// Returns what the servo thread says of the lease.
    pub(crate) fn beating(&self) -> Beating {
        let pulse = self.pulse.load(Acquire); // Pairs with Release in the thread of the pins.
        Beating { lease: self.lease.load(Relaxed), pulse }
    }

    /// Sends a pulse back that was made under this lease, if it is that of a teleoperated job whose client is there.
    fn echo(&self, pulse: u32, lease: u32) {
        let is_own = lease != 0 && lease == self.keeps.load(Relaxed);
        let until = self.answers_until.load(Relaxed);
        if is_own && until.wrapping_sub(pulse).cast_signed() >= 0 {
            self.beat.store(pulse, Relaxed);
        }
    }

    /// Returns the command that sends a pulse back, for a program that may not write to the plugin's pin.
    fn beat_command(&self, pulse: u64) -> Request {
        let lease = format!("lease={}", self.keeps.load(Relaxed));
        Request::Command {
            name: "remote.beat".to_owned(),
            args: vec![lease, format!("pulse={pulse}")],
        }
    }

    /// Returns the values of the pins that this program writes whenever they change.
    fn written(&self) -> [(usize, u64); 7] {
        let teleop = &self.teleop;
        let count = |n: &AtomicU32| u64::from(n.load(Relaxed));
        let bit = |on: &AtomicBool| u64::from(on.load(Relaxed));
        [
            (BEAT, count(&self.beat)),
            (CLIENTS, count(&self.clients)),
            (LISTENING, count(&teleop.listening)),
            (SESSIONS, count(&teleop.sessions)),
            (RUNNING, bit(&teleop.running)),
            (LINK_OK, bit(&teleop.link_ok)),
            (PROGRESS, count(&teleop.progress)),
        ]
    }
}

/// Starts the thread that exchanges the pins. Teleoperation begins at `teleop`, with the port where it is wanted at once.
pub(crate) fn start(place: &Place, teleop: (bool, u16)) -> Result<Arc<Heart>, String> {
    let mut client = Client::connect(place, "").map_err(|e| e.to_string())?;
    let is_guest = hal_lease::is_guest(place);
    let mut page = join(&mut client, is_guest).map_err(|e| e.to_string())?;
    page.set(SERVE, teleop.0.into());
    page.set(PORT, teleop.1.into());
    let heart = Arc::new(Heart::default());
    let shared = heart.clone();
    let beat = move || {
        let count = |n: u64| u32::try_from(n).unwrap_or(u32::MAX);
        while client.call(Request::Sleep { ns: INTERVAL_NS }).is_ok() {
            // In this order: a lease that still lasts is the one under which the pulse was made.
            let pulse = count(page.get(PULSE));
            let lease = count(page.get(LEASE));
            // The lease first: what is read behind a pulse is then no older than the pulse.
            shared.lease.store(lease, Relaxed);
            shared.pulse.store(pulse, Release); // Pairs with Acquire in `beating`.
            shared.permit.store(page.get(PERMIT) & 1 != 0, Relaxed);
            shared.hold.store(page.get(HOLD) & 1 != 0, Relaxed);
            shared.allowed.store(page.get(ALLOWED) & 1 != 0, Relaxed);
            shared.echo(pulse, lease);
            for (pin, value) in shared.written() {
                if page.own(pin) != Some(value) {
                    page.set(pin, value);
                    if pin == BEAT && is_guest {
                        // A lease that has ended meanwhile is noticed at its pin.
                        drop(client.call(shared.beat_command(value)));
                    }
                }
            }
            if shared.teleop.refused.swap(false, Relaxed) {
                page.set(SERVE, 0);
            }
            shared.teleop.serve.store(page.get(SERVE) & 1 != 0, Relaxed);
            shared.teleop.port.store(count(page.get(PORT)), Relaxed);
        }
    };
    let begun = thread::Builder::new().name("heart".to_owned()).spawn(beat);
    begun.map_err(|e| hal_output::reason(&e))?;
    Ok(heart)
}

/// Makes the pins and links them. A guest links only those that read: its beats are commands.
fn join(client: &mut Client, is_guest: bool) -> Result<PinPage, hal_protocol::Failure> {
    client.call(Request::Join { name: "halpanel".to_owned(), poll_ns: INTERVAL_NS })?;
    for (name, ty, direction, _, _) in PINS {
        let name = (*name).to_owned();
        client.call(Request::NewPin { name, ty: *ty, direction: *direction })?;
    }
    let pins = u32::try_from(PINS.len()).unwrap_or(u32::MAX);
    let page = client.share_pins(pins, None)?;
    client.call(Request::Ready)?;
    let is_linked = |direction: Direction, pin: &str| {
        !pin.is_empty() && (!is_guest || direction == Direction::In)
    };
    for (name, _, _, signal, pin) in PINS.iter().filter(|row| is_linked(row.2, row.4)) {
        // The machine's files may have linked the pin: then its signal is used.
        let patterns = vec![(*pin).to_owned()];
        let own = client.call(Request::List { kind: Kind::Pins, patterns, ty: None })?;
        let linked = match own {
            Reply::Items(pins) => pins.into_iter().find_map(|pin| pin.signal),
            _ => None,
        };
        let (signal, pins) = match linked {
            Some(signal) => (signal, vec![(*name).to_owned()]),
            None => ((*signal).to_owned(), vec![(*pin).to_owned(), (*name).to_owned()]),
        };
        client.call(Request::Net { signal, pins })?;
    }
    Ok(page)
}

#[cfg(test)]
mod tests {
    //! Pulses that are sent back for a job, and those that are not.

    use super::{Heart, Relaxed};

    #[test]
    fn pulses_are_sent_back_under_the_lease_of_the_job_alone() {
        let heart = Heart::default();
        let beat = |pulse, lease| {
            heart.echo(pulse, lease);
            heart.beat.load(Relaxed)
        };
        heart.answers_until.store(10_000, Relaxed);
        assert_eq!(beat(20, 3), 0, "without a job");
        heart.keep(3);
        assert_eq!(beat(40, 3), 40);
        // A page takes the lease: its own beats keep it.
        assert_eq!(beat(60, 4), 40, "the lease of a page");
        assert_eq!(beat(80, 0), 40, "no lease");
        assert_eq!(beat(10_000, 3), 10_000);
        assert_eq!(beat(10_001, 3), 10_000, "the client is silent");
        // The number begins again at 0.
        heart.answers_until.store(5, Relaxed);
        assert_eq!(beat(u32::MAX, 3), u32::MAX);
        heart.keep(0);
        assert_eq!(beat(1, 3), u32::MAX, "after the job");
        assert_eq!(beat(2, 0), u32::MAX, "after the job, and without a lease");
    }
}
