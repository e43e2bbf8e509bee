//! Pins of the panel: pulses from the servo thread, and the beats that answer them.

use hal_protocol::{Client, Direction, Kind, Link as _, PinPage, Place, Reply, Request, Type};
use std::{
    sync::{
        Arc,
        atomic::{AtomicBool, AtomicU32, Ordering::Relaxed},
    },
    thread,
};

/// Interval of the exchange, in nanoseconds of machine time.
const INTERVAL_NS: u64 = 4_000_000;
/// Pins, in the order of their creation, with the signal and the pin of `remote` that each is linked with.
const PINS: &[(&str, Type, Direction, &str, &str)] = &[
    ("halpanel.pulse", Type::U32, Direction::In, "remote-pulse", "remote.pulse"),
    ("halpanel.beat", Type::U32, Direction::Out, "remote-beat", "remote.beat"),
    ("halpanel.clients", Type::U32, Direction::Out, "remote-clients", "remote.clients"),
    ("halpanel.lease", Type::U32, Direction::In, "remote-lease", "remote.lease"),
    ("halpanel.permit", Type::Bit, Direction::In, "remote-permit", "remote.permit"),
    ("halpanel.hold", Type::Bit, Direction::In, "remote-hold", "remote.hold"),
    ("halpanel.allowed", Type::Bit, Direction::In, "remote-allowed", "remote.allowed"),
];
const PULSE: usize = 0;
const BEAT: usize = 1;
const CLIENTS: usize = 2;
const LEASE: usize = 3;
const PERMIT: usize = 4;
const HOLD: usize = 5;
const ALLOWED: usize = 6;

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
}

/// Starts the thread that exchanges the pins.
pub(crate) fn start(place: &Place) -> Result<Arc<Heart>, String> {
    let mut client = Client::connect(place, "").map_err(|e| e.to_string())?;
    let mut page = join(&mut client).map_err(|e| e.to_string())?;
    let heart = Arc::new(Heart::default());
    let shared = heart.clone();
    let beat = move || {
        let count = |n: u64| u32::try_from(n).unwrap_or(u32::MAX);
        while client.call(Request::Sleep { ns: INTERVAL_NS }).is_ok() {
            shared.pulse.store(count(page.get(PULSE)), Relaxed);
            shared.lease.store(count(page.get(LEASE)), Relaxed);
            shared.permit.store(page.get(PERMIT) & 1 != 0, Relaxed);
            shared.hold.store(page.get(HOLD) & 1 != 0, Relaxed);
            shared.allowed.store(page.get(ALLOWED) & 1 != 0, Relaxed);
            for (pin, value) in [(BEAT, &shared.beat), (CLIENTS, &shared.clients)] {
                let value = u64::from(value.load(Relaxed));
                if page.own(pin) != Some(value) {
                    page.set(pin, value);
                }
            }
        }
    };
    let begun = thread::Builder::new().name("heart".to_owned()).spawn(beat);
    begun.map_err(|e| hal_output::reason(&e))?;
    Ok(heart)
}

fn join(client: &mut Client) -> Result<PinPage, hal_protocol::Failure> {
    client.call(Request::Join { name: "halpanel".to_owned(), poll_ns: INTERVAL_NS })?;
    for (name, ty, direction, _, _) in PINS {
        let name = (*name).to_owned();
        client.call(Request::NewPin { name, ty: *ty, direction: *direction })?;
    }
    let pins = u32::try_from(PINS.len()).unwrap_or(u32::MAX);
    let page = client.share_pins(pins, None)?;
    client.call(Request::Ready)?;
    for (name, _, _, signal, pin) in PINS {
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
