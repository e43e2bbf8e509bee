//! The worker: it reads the devices, and finds lost ones again.

use crate::{
    bus::{Abilities, Bus, FoundDevice, Identity, InputDevice, LED_COUNT},
    event::InputEvent,
    reader::{DeviceReader, DeviceRecord},
    simulated::SimPins,
};
use hal_component::{Clock, Gives, Messages, SeqWriter, Takes, Touch, Work};
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
    /// Lights as they were switched last.
    #[state]
    pub(crate) lit: Option<u32>,
}

/// Device that belongs to the pins.
#[derive(Clone, Debug)]
pub(crate) struct WantedDevice {
    /// Number of its node.
    pub(crate) number: u32,
    pub(crate) identity: Identity,
    /// Abilities that have pins.
    pub(crate) abilities: Abilities,
    pub(crate) is_exclusive: bool,
}

/// Messages about a device.
#[derive(Clone, Copy, Debug)]
pub(crate) struct DeviceTexts {
    pub(crate) lost: &'static str,
    pub(crate) back: &'static str,
    pub(crate) dark: &'static str,
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
        let found = self.bus.devices().all;
        for at in 0..self.devices.len() {
            let Some(number) = self.place_of(at, &found) else { continue };
            let Some(device) = self.devices.get_mut(at) else { continue };
            if device.open(&*self.bus, number).is_ok() {
                self.messages.notice(device.texts.back, &[]);
            }
        }
    }

    /// Returns the node of a lost device that is there again: where it was, or, if it is the only one of its make, in
    /// another place.
    fn place_of(&self, at: usize, found: &[FoundDevice]) -> Option<u32> {
        let lost = self.devices.get(at).filter(|device| device.device.is_none())?;
        let wanted = &lost.wanted;
        let is_same = |device: &&FoundDevice| device.identity.is_same_make(&wanted.identity);
        let in_place = |device: &&FoundDevice| device.identity.phys == wanted.identity.phys;
        let mut same = found.iter().filter(is_same);
        if let Some(device) = same.clone().find(in_place) {
            return Some(device.number);
        }
        // Several specifications may mean one device, which moves with all of them.
        let is_other = |other: &ReadDevice| {
            other.wanted.identity.is_same_make(&wanted.identity)
                && other.wanted.identity.phys != wanted.identity.phys
        };
        let only = same.next()?;
        let is_alone = same.next().is_none() && !self.devices.iter().any(is_other);
        is_alone.then_some(only.number)
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

    /// Switches the lights that are to change.
    fn switch(&mut self, messages: Messages) {
        let Some(device) = &mut self.device else { return };
        let asked = self.lights.load(Relaxed);
        let changed = self.lit.map_or(u32::MAX, |lit| lit ^ asked);
        self.lit = Some(asked);
        for led in self.wanted.abilities.leds.iter().copied() {
            let is_of = usize::from(led) < LED_COUNT && changed >> led & 1 != 0;
            if is_of && device.light(led, asked >> led & 1 != 0).is_err() {
                // If the device is lost, the next step finds it out.
                messages.warn(self.texts.dark, &[]);
                return;
            }
        }
    }

    /// Opens the device that is there again.
    fn open(&mut self, bus: &dyn Bus, number: u32) -> Result<(), Lost> {
        let mut device = bus.open(number, self.wanted.is_exclusive)?;
        if !device.abilities()?.cover(&self.wanted.abilities) {
            return Err(Lost::NONE);
        }
        self.reader.open(&device.state()?);
        self.wanted.number = number;
        self.device = Some(device);
        self.lit = None;
        self.record.set(self.reader.record());
        Ok(())
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
