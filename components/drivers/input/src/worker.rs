//! The worker: it reads the devices, and finds lost ones again.

use crate::{
    bus::{Abilities, Bus, FoundDevice, Identity, InputDevice},
    event::InputEvent,
    reader::{DeviceReader, DeviceRecord},
    refused::Unusable,
    simulated::SimPins,
};
use hal_component::{Clock, Gives, Messages, SeqWriter, Takes, Texts, Touch, Work};
use port::Lost;
use std::sync::atomic::{AtomicU32, Ordering::Relaxed};

/// Period of the worker, in nanoseconds.
pub(crate) const PERIOD_NS: i64 = 2_000_000;
/// Time between two looks for lost devices, in nanoseconds.
const LOOK_NS: i64 = 500_000_000;
/// Number of events that are taken at once.
const AT_ONCE: usize = 64;
/// Largest number of times that a step takes events of a device.
const MOST_READS: usize = 16;
/// Number of refusals of a device that is back after which a warning is written: the system gives the right to open its node
/// a moment after the node.
const TOLD_AFTER: u8 = 2;

/// The worker.
#[derive(Touch)]
pub(crate) struct Worker {
    pub(crate) devices: Vec<ReadDevice>,
    /// Pins of the simulated devices.
    pub(crate) simulated: Vec<SimPins>,
    pub(crate) steps: Gives<AtomicU32>,
    pub(crate) clock: Clock,
    pub(crate) messages: Messages,
    #[state]
    pub(crate) bus: Box<dyn Bus>,
    /// Machine time of the last look for lost devices.
    #[state]
    pub(crate) looked: Option<i64>,
}

/// Device that is read.
#[derive(Touch)]
pub(crate) struct ReadDevice {
    pub(crate) record: SeqWriter<DeviceRecord>,
    pub(crate) lights: Takes<AtomicU32>,
    #[state]
    pub(crate) reader: DeviceReader,
    /// Open device; none while it is lost.
    #[state]
    pub(crate) device: Option<Box<dyn InputDevice>>,
    #[state]
    pub(crate) wanted: WantedDevice,
    #[state]
    pub(crate) texts: DeviceTexts,
    #[state]
    pub(crate) lit: Lit,
    /// Number of times that the device was refused since its loss.
    #[state]
    pub(crate) refusals: u8,
}

/// Lights of an open device, by their bits.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Lit {
    /// Lights that were asked for last.
    asked: Option<u32>,
    /// Lights that were switched.
    known: u32,
    /// Lights that are on, of those.
    on: u32,
}

/// Device that belongs to the pins.
#[derive(Clone, Debug)]
pub(crate) struct WantedDevice {
    /// Number of its node.
    pub(crate) number: u32,
    /// Number of the first specification that meant the same device at the load.
    pub(crate) group: usize,
    pub(crate) identity: Identity,
    /// Abilities that have pins.
    pub(crate) abilities: Abilities,
    pub(crate) is_exclusive: bool,
}

/// Messages about a device.
#[derive(Debug)]
pub(crate) struct DeviceTexts {
    pub(crate) lost: &'static str,
    pub(crate) back: &'static str,
    pub(crate) dark: &'static str,
    /// Pins and name of the device.
    pub(crate) who: String,
    /// Texts about refusals.
    pub(crate) refused: Texts,
}

impl Work for Worker {
    fn work(&mut self, _: u32) -> u32 {
        for device in &mut self.devices {
            if device.step(self.messages) {
                // The loss is seen for a while, whatever comes back.
                self.looked = Some(self.clock.now_ns());
            }
        }
        if self.devices.iter().any(|device| device.device.is_none()) {
            let now = self.clock.now_ns();
            if self.looked.is_none_or(|looked| LOOK_NS <= now.wrapping_sub(looked)) {
                self.looked = Some(now);
                self.look();
            }
        }
        self.steps.store(self.steps.load(Relaxed).wrapping_add(1), Relaxed);
        0
    }
}

impl Worker {
    /// Looks for lost devices.
    fn look(&mut self) {
        let found = self.bus.devices();
        for at in 0..self.devices.len() {
            let Some(place) = self.place_of(at, &found) else { continue };
            let Some(device) = self.devices.get_mut(at) else { continue };
            match device.open(&*self.bus, place) {
                Ok(()) => self.messages.notice(device.texts.back, &[]),
                Err(why) => device.note_refusal(why, self.messages),
            }
        }
    }

    /// Returns a lost device that is there again: where it was, or, if it is the only one of its make, in another place.
    fn place_of<'f>(&self, at: usize, found: &'f [FoundDevice]) -> Option<&'f FoundDevice> {
        let lost = self.devices.get(at).filter(|device| device.device.is_none())?;
        let WantedDevice { group, identity, .. } = &lost.wanted;
        let open = || self.devices.iter().filter(|other| other.device.is_some());
        // Several specifications may mean one device, which moves with all of them.
        if let Some(own) = open().find(|other| other.wanted.group == *group) {
            return found.iter().find(|device| {
                device.number == own.wanted.number && device.identity.is_same_make(identity)
            });
        }
        let is_free =
            |device: &&FoundDevice| open().all(|other| other.wanted.number != device.number);
        let same = || found.iter().filter(|d| d.identity.is_same_make(identity)).filter(is_free);
        let mut in_place = same().filter(|device| device.identity.is_in_place(identity));
        if let Some(first) = in_place.next() {
            // Lost devices without a difference come back together, in the order of their nodes.
            let is_twin = |other: &&ReadDevice| {
                other.device.is_none() && other.wanted.identity.is_in_place(identity)
            };
            let mut groups: Vec<usize> =
                self.devices.iter().filter(is_twin).map(|other| other.wanted.group).collect();
            groups.sort_unstable();
            groups.dedup();
            return (groups.len() <= 1 + in_place.count()).then_some(first);
        }
        let is_other = |other: &ReadDevice| {
            other.wanted.group != *group && other.wanted.identity.is_same_make(identity)
        };
        let mut same = same();
        let only = same.next()?;
        let is_alone = same.next().is_none() && !self.devices.iter().any(is_other);
        is_alone.then_some(only)
    }
}

impl ReadDevice {
    /// Reads the device. Returns true if it was lost just now.
    fn step(&mut self, messages: Messages) -> bool {
        let Some(device) = &mut self.device else { return false };
        let before = *self.reader.record();
        let is_lost = read(&mut **device, &mut self.reader).is_err();
        if is_lost {
            self.device = None;
            self.refusals = 0;
            self.reader.lose();
            messages.error(self.texts.lost, &[]);
        } else {
            self.switch(messages);
        }
        if *self.reader.record() != before {
            self.record.set(self.reader.record());
        }
        is_lost
    }

    /// Switches the lights that are to change. Lights that cannot be switched off at the beginning are no problem.
    fn switch(&mut self, messages: Messages) {
        let Some(device) = &mut self.device else { return };
        let asked = self.lights.load(Relaxed);
        if self.lit.asked.replace(asked) == Some(asked) {
            return;
        }
        let mut is_dark = false;
        for led in self.wanted.abilities.leds.iter().copied() {
            let bit = 1 << (led % 32);
            let (is_on, is_known) = (asked & bit != 0, self.lit.known & bit != 0);
            if is_known && is_on == (self.lit.on & bit != 0) {
                continue;
            }
            // If the device is lost, the next step finds it out.
            if device.light(led, is_on).is_ok() {
                self.lit.known |= bit;
                self.lit.on = self.lit.on & !bit | asked & bit;
            } else {
                is_dark |= is_on || is_known;
            }
        }
        if is_dark {
            messages.warn(self.texts.dark, &[]);
        }
    }

    /// Opens the device that is there again.
    fn open(&mut self, bus: &dyn Bus, found: &FoundDevice) -> Result<(), Unusable> {
        let is_exclusive = self.wanted.is_exclusive;
        let unusable = |lost| Unusable::new(lost, is_exclusive);
        let mut device = bus.open(found, is_exclusive).map_err(unusable)?;
        if !device.abilities().map_err(unusable)?.cover(&self.wanted.abilities) {
            return Err(Unusable::Lacking);
        }
        self.reader.open(&device.state().map_err(unusable)?);
        self.wanted.number = found.number;
        self.device = Some(device);
        self.lit = Lit::default();
        self.record.set(self.reader.record());
        Ok(())
    }

    /// Tells the user once for each loss that the device is there again and is refused.
    fn note_refusal(&mut self, why: Unusable, messages: Messages) {
        self.refusals = self.refusals.saturating_add(1);
        if self.refusals == TOLD_AFTER {
            let text = format!("{} is there again, but cannot be used: {why}", self.texts.who);
            messages.warn(self.texts.refused.keep(&text), &[]);
        }
    }
}

/// Takes the events that wait, up to a limit.
fn read(device: &mut dyn InputDevice, reader: &mut DeviceReader) -> Result<(), Lost> {
    let mut room = [InputEvent::default(); AT_ONCE];
    for _ in 0..MOST_READS {
        let count = device.read(&mut room)?;
        for event in room.iter().take(count) {
            if reader.event(*event) {
                // The state is newer than the events that still wait.
                let held = device.state()?;
                reader.take(&held);
                return Ok(());
            }
        }
        if count < room.len() {
            break;
        }
    }
    Ok(())
}
