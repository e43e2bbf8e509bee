//! Realtime. The watchdog: without a packet in time, the card makes all I/O pins inputs.

use crate::{
    link::{Kept, Outgoing, Renewals},
    making::Making,
    module::{Cycle, Reads, Writes},
    numbers::whole,
    plan::{Place, ReadAnswer},
};
use core::sync::atomic::{
    AtomicBool, AtomicU32,
    Ordering::{Acquire, Relaxed, Release},
};
use hal_component::{Clock, Error, Gives, Hardware, Io, Messages, ParamRw, Takes, Touch};
use hal_firmware::{Tag, registers};

/// Value that lets the time begin again.
pub(crate) const RESET: u32 = 0x5A00_0000;

/// Longest time that the register holds: bit 31 switches the watchdog off.
const MOST: u32 = 0x7FFF_FFFF;

/// State that the writing half leaves for the reading one.
#[derive(Debug)]
struct Keeper {
    /// True from the first write on.
    runs: AtomicBool,
    /// True from a release until an answer shows that the card has received it, or until it is aborted.
    releases: AtomicBool,
    /// Number of releases, the one at the beginning included.
    count: AtomicU32,
    /// Number of the release after which a bite was said; 0 before the first bite.
    said: AtomicU32,
}

/// Function half that reads.
#[derive(Touch)]
struct Status {
    #[state]
    status: Place,
    has_bit: Io<bool>,
    messages: Messages,
    /// The card's I/O pins: failed while they are inputs.
    hardware: Hardware,
    keeper: Takes<Keeper>,
    /// Message about a bite.
    #[state]
    says: &'static str,
}

impl Reads for Status {
    fn read(&mut self, answer: ReadAnswer<'_>, _: Cycle, fresh: bool) {
        // Before the first write, what the status says is of an earlier program. Pairs with `write`.
        let runs = self.keeper.runs.load(Acquire);
        let bitten = runs && answer.get(self.status) & 1 != 0;
        if fresh && runs {
            self.keeper.releases.store(false, Release); // Pairs with `write`.
        }
        // A card that may have missed its release says what it said before. Pairs with `write`.
        let is_new = bitten && !self.keeper.releases.load(Acquire);
        let count = self.keeper.count.load(Acquire); // Pairs with `write`.
        if is_new && self.keeper.said.load(Relaxed) != count {
            self.has_bit.set(true);
            self.keeper.said.store(count, Release); // Pairs with `write`, which then sees the pin.
            self.messages.error(self.says, &[]);
        }
        self.hardware.note(bitten || self.has_bit.get());
    }
}

const BITTEN: &str = "the card's watchdog has bitten, because no packet of the write function came \
    in watchdog.timeout_ns: all its I/O pins are inputs; when the cause is known, set watchdog.has_bit \
    to 0 to go on";

/// Function half that writes.
#[derive(Touch)]
struct Keep {
    has_bit: Io<bool>,
    timeout: ParamRw<u32>,
    keeper: Gives<Keeper>,
    #[state]
    renewals: Renewals,
    clock: Clock,
    /// Frequency of the card's clock in hertz.
    #[state]
    hz: f64,
    #[state]
    period: Kept,
    #[state]
    status: u16,
    #[state]
    reset: u16,
    /// Machine time at which the release under way began; none before its first packet.
    #[state]
    begun: Option<i64>,
}

impl Writes for Keep {
    fn write(&mut self, to: &mut Outgoing<'_>, _: Cycle) {
        let said = self.keeper.said.load(Acquire); // Pairs with `read`.
        if self.has_bit.get() {
            // Nothing keeps the watchdog quiet until a person has looked.
            return;
        }
        let count = self.keeper.count.load(Relaxed); // Only this function writes it.
        if said == count {
            self.begun = None;
            self.keeper.count.store(count.wrapping_add(1).max(1), Release); // Pairs with `read`.
            self.keeper.releases.store(true, Release); // Pairs with `read`.
            self.renewals.renew();
        }
        let timeout_ns = self.timeout.get();
        let ticks = libm::floor(f64::from(timeout_ns) * 1e-9 * self.hz) - 1.0;
        self.period.put(to, whole(ticks, MOST).max(1));
        // Not renewed like other registers: a bite that no answer has shown yet would end unseen. A release that no answer
        // confirms is repeated only until the card may have bitten again. Pairs with `read`.
        if self.keeper.releases.load(Acquire) {
            let now = self.clock.now_ns();
            let begun = *self.begun.get_or_insert(now);
            if now.wrapping_sub(begun) < i64::from(timeout_ns).max(1) {
                to.put(self.status, 0);
            } else {
                self.keeper.releases.store(false, Release); // Pairs with `read`.
            }
        }
        to.put(self.reset, RESET);
        self.keeper.runs.store(true, Release); // Pairs with `read`.
    }
}

/// Creates the pins of the watchdog.
pub(crate) fn make(m: &mut Making<'_, '_>) -> Result<(), Error> {
    let Some((module, _)) = m.module(Tag::Watchdog) else { return Ok(()) };
    let (has_bit, timeout) = (m.at("watchdog.has_bit"), m.at("watchdog.timeout_ns"));
    let about = "TRUE once the watchdog has bitten: all I/O pins are inputs. Setting it FALSE lets the \
        card work again. The driver sets it TRUE";
    let has_bit: Io<bool> = m.b.item(&has_bit, about, false)?;
    let about =
        "Longest time between two runs of the write function, in nanoseconds; 0 to 2^32 - 1";
    let timeout: ParamRw<u32> = m.b.item(&timeout, about, 5_000_000)?;
    let (gives, takes) = m.b.shared(Keeper {
        runs: AtomicBool::new(false),
        releases: AtomicBool::new(true),
        count: AtomicU32::new(1),
        said: AtomicU32::new(0),
    });
    let status = Status {
        status: m.read(&module, registers::WATCHDOG_STATUS, 0)?,
        has_bit,
        messages: m.b.messages(),
        hardware: m.b.hardware(),
        keeper: takes,
        says: m.says(BITTEN),
    };
    let keep = Keep {
        has_bit,
        timeout,
        keeper: gives,
        renewals: m.renewals.clone(),
        clock: m.b.clock(),
        hz: m.clock(&module)?,
        period: Kept::new(m.address(&module, registers::WATCHDOG_TIMEOUT, 0)?),
        status: m.address(&module, registers::WATCHDOG_STATUS, 0)?,
        reset: m.address(&module, registers::WATCHDOG_RESET, 0)?,
        begun: None,
    };
    m.reads.push(Box::new(status));
    m.writes.push(Box::new(keep));
    Ok(())
}
