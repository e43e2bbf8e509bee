//! Realtime. The watchdog: without a packet in time, the card makes all I/O pins inputs.

use crate::{
    link::{Kept, Outgoing, Renewals},
    making::Making,
    module::{Cycle, Reads, Writes},
    numbers::whole,
    plan::{Place, ReadAnswer},
};
use core::sync::atomic::{
    AtomicBool,
    Ordering::{AcqRel, Acquire, Release},
};
use hal_component::{Error, Gives, Hardware, Io, Messages, ParamRw, Takes, Touch};
use hal_firmware::{Tag, registers};

/// Value that lets the time begin again.
pub(crate) const RESET: u32 = 0x5A00_0000;

/// Longest time that the register holds: bit 31 switches the watchdog off.
const MOST: u32 = 0x7FFF_FFFF;

/// State that the writing half leaves for the reading one.
#[derive(Debug, Default)]
struct Keeper {
    /// True from the first write on.
    runs: AtomicBool,
    /// True when the status has been written to 0.
    released: AtomicBool,
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
    #[state]
    was_said: bool,
    #[state]
    number: f64,
}

impl Reads for Status {
    fn read(&mut self, answer: ReadAnswer<'_>, _: Cycle, fresh: bool) {
        // Before the first write, what the status says is of an earlier program. Pairs with `write`.
        let bitten = self.keeper.runs.load(Acquire) && answer.get(self.status) & 1 != 0;
        // Once it was said, a person may clear the pin; the card's status follows with the write of that cycle.
        if fresh && self.keeper.released.swap(false, AcqRel) {
            self.was_said = false;
        }
        if bitten && !core::mem::replace(&mut self.was_said, bitten) {
            self.has_bit.set(true);
            self.messages.error(BITTEN, &[self.number]);
        }
        self.hardware.note(bitten || self.has_bit.get());
    }
}

const BITTEN: &str = "card {}: its watchdog has bitten, because no packet of the write function came \
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
    #[state]
    clock: f64,
    #[state]
    period: Kept,
    #[state]
    status: Kept,
    #[state]
    reset: u16,
    #[state]
    was_bitten: bool,
}

impl Writes for Keep {
    fn write(&mut self, to: &mut Outgoing<'_>, _: Cycle) {
        let is_bitten = self.has_bit.get();
        if is_bitten {
            // Nothing keeps the watchdog quiet until a person has looked.
            self.was_bitten = true;
            return;
        }
        if self.was_bitten {
            self.was_bitten = false;
            self.status.forget();
            self.renewals.renew();
        }
        let ticks = libm::floor(f64::from(self.timeout.get()) * 1e-9 * self.clock) - 1.0;
        self.period.put(to, whole(ticks, MOST).max(1));
        if self.status.put(to, 0) {
            self.keeper.released.store(true, Release); // Pairs with `read`.
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
    let (gives, takes) = m.b.shared(Keeper::default());
    let status = Status {
        status: m.read(&module, registers::WATCHDOG_STATUS, 0)?,
        has_bit,
        messages: m.b.messages(),
        hardware: m.b.hardware(),
        keeper: takes,
        was_said: false,
        number: m.number,
    };
    let keep = Keep {
        has_bit,
        timeout,
        keeper: gives,
        renewals: m.renewals.clone(),
        clock: m.clock(&module)?,
        period: Kept::new(m.address(&module, registers::WATCHDOG_TIMEOUT, 0)?),
        status: Kept::new(m.address(&module, registers::WATCHDOG_STATUS, 0)?),
        reset: m.address(&module, registers::WATCHDOG_RESET, 0)?,
        was_bitten: false,
    };
    m.reads.push(Box::new(status));
    m.writes.push(Box::new(keep));
    Ok(())
}
