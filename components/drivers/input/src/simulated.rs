//! Simulated devices, whose buttons, axes and wheels are pins.

use crate::{
    bus::{ABS_COUNT, Abilities, Bus, FoundDevice, HeldState, InputDevice, REL_COUNT},
    codes,
    described::{Described, WheelKind, Wheels},
    event::{InputEvent, kind},
};
use hal_component::{Builder, Error, In, Out, Touch};
use port::Lost;

/// Simulated device, by its pins.
#[derive(Clone, Debug, Touch)]
pub(crate) struct SimPins {
    unplugged: In<bool>,
    keys: Vec<SimPin<In<bool>>>,
    axes: Vec<SimPin<In<i32>>>,
    wheels: Vec<SimPin<In<i32>>>,
    lights: Vec<SimPin<Out<bool>>>,
}

/// Pin with its code.
#[derive(Clone, Debug, Touch)]
struct SimPin<P: Touch> {
    #[state]
    code: u16,
    pin: P,
}

impl SimPins {
    /// Makes the pins `PREFIX.sim.*` of what a device has.
    ///
    /// # Errors
    /// A name is taken.
    pub(crate) fn make(b: &mut Builder<'_>, prefix: &str, has: &Abilities) -> Result<Self, Error> {
        let mut pins = Self {
            unplugged: b.simulated(&format!("{prefix}.sim.unplugged"), UNPLUGGED, false)?,
            keys: Vec::new(),
            axes: Vec::new(),
            wheels: Vec::new(),
            lights: Vec::new(),
        };
        let name = |kind, code| format!("{prefix}.sim.{}", codes::name(kind, code));
        for code in has.keys.iter().copied() {
            let pin = b.simulated(&name(kind::KEY, code), "TRUE holds it down", false)?;
            pins.keys.push(SimPin { code, pin });
        }
        for (code, range) in has.abs.iter().copied() {
            let pin = b.simulated(&name(kind::ABS, code), "Value of the axis", range.value)?;
            pins.axes.push(SimPin { code, pin });
        }
        for code in has.rel.iter().copied() {
            let about = "Place of the wheel or ring; its changes are movements";
            let pin = b.simulated(&name(kind::REL, code), about, 0)?;
            pins.wheels.push(SimPin { code, pin });
        }
        for code in has.leds.iter().copied() {
            let pin = b.simulated(&name(kind::LED, code), "TRUE while the light is on", false)?;
            pins.lights.push(SimPin { code, pin });
        }
        Ok(pins)
    }
}

const UNPLUGGED: &str = "TRUE makes every access fail as if the device had been unplugged";

/// Simulated devices, numbered from 0.
#[derive(Clone, Debug, Default)]
pub(crate) struct SimulatedBus {
    pub(crate) devices: Vec<(Described, SimPins)>,
}

impl Bus for SimulatedBus {
    fn devices(&self) -> Vec<FoundDevice> {
        let there = (0..).zip(&self.devices).filter(|(_, (_, pins))| !pins.unplugged.get());
        let found = there.map(|(number, (described, _))| FoundDevice {
            number,
            identity: described.identity.clone(),
        });
        found.collect()
    }

    fn open(&self, found: &FoundDevice, _: bool) -> Result<Box<dyn InputDevice>, Lost> {
        let at = usize::try_from(found.number).map_err(|_| Lost::GONE)?;
        let (described, pins) = self.devices.get(at).ok_or(Lost::GONE)?;
        let mut device = SimulatedDevice {
            abilities: described.abilities.clone(),
            pins: pins.clone(),
            wheels: described.wheels,
            was: HeldState::REST,
            turned: [0; REL_COUNT],
        };
        device.state()?;
        Ok(Box::new(device))
    }
}

/// Open simulated device.
#[derive(Debug)]
struct SimulatedDevice {
    abilities: Abilities,
    pins: SimPins,
    wheels: Wheels,
    /// State of which events were taken.
    was: HeldState,
    /// Places of the wheels of which events were taken.
    turned: [i32; REL_COUNT],
}

impl SimulatedDevice {
    fn answer(&self) -> Result<(), Lost> {
        if self.pins.unplugged.get() { Err(Lost::GONE) } else { Ok(()) }
    }

    fn now(&self) -> HeldState {
        let mut now = HeldState { keys: [0; _], abs: [0; ABS_COUNT] };
        for SimPin { code, pin } in self.pins.keys.iter().filter(|key| key.pin.get()) {
            if let Some(word) = now.keys.get_mut(usize::from(code / 64)) {
                *word |= u64::from(pin.get()) << (code % 64);
            }
        }
        for SimPin { code, pin } in &self.pins.axes {
            if let Some(value) = now.abs.get_mut(usize::from(*code)) {
                *value = pin.get();
            }
        }
        now
    }

    /// Returns the next difference between the pins, as they are now, and the events that were taken.
    fn next(&mut self, now: &HeldState) -> Option<InputEvent> {
        for SimPin { code, .. } in &self.pins.keys {
            let (word, bit) = (usize::from(code / 64), 1 << (code % 64));
            let (is, was) = (now.keys.get(word)? & bit, self.was.keys.get_mut(word)?);
            if is != *was & bit {
                *was ^= bit;
                return Some(InputEvent { kind: kind::KEY, code: *code, value: (is != 0).into() });
            }
        }
        for SimPin { code, .. } in &self.pins.axes {
            let at = usize::from(*code);
            let (is, was) = (*now.abs.get(at)?, self.was.abs.get_mut(at)?);
            if is != *was {
                *was = is;
                return Some(InputEvent { kind: kind::ABS, code: *code, value: is });
            }
        }
        None
    }

    /// Adds the events of wheels to those of a packet, as the device says them.
    fn turn(&mut self, events: &mut Vec<InputEvent>) {
        let (mut has_rested, before) = (false, events.len());
        let mut rings = Vec::new();
        for SimPin { code, pin } in &self.pins.wheels {
            let at = usize::from(*code);
            let (Some(was), Some(kind)) = (self.turned.get_mut(at), self.wheels.get(at)) else {
                continue;
            };
            let is = pin.get();
            let by = is.wrapping_sub(*was);
            *was = is;
            let event = |value| InputEvent { kind: kind::REL, code: *code, value };
            match *kind {
                WheelKind::Movement if by != 0 => events.push(event(by)),
                WheelKind::Counter(bits) if by != 0 => {
                    events.push(event(1 + is.rem_euclid((1 << bits.min(30)) - 1)));
                }
                WheelKind::Ring if is != 0 => rings.push((event(is), by != 0)),
                WheelKind::Ring => has_rested |= by != 0,
                WheelKind::Movement | WheelKind::Counter(_) => {}
            }
        }
        // A ring that is not at rest is a part of each report; its rest is a report without it.
        let is_report = events.len() > before || before != 0 || rings.iter().any(|ring| ring.1);
        if is_report || has_rested {
            events.extend(rings.iter().map(|ring| ring.0));
            events.push(InputEvent::REPORT);
        }
    }
}

impl InputDevice for SimulatedDevice {
    fn abilities(&self) -> Result<Abilities, Lost> {
        self.answer().map(|()| self.abilities.clone())
    }

    fn read(&mut self, room: &mut [InputEvent]) -> Result<usize, Lost> {
        self.answer()?;
        // The last place is for the end of the packet, and some for the wheels.
        let most = room.len().saturating_sub(REL_COUNT + 1);
        let now = self.now();
        let mut events: Vec<_> = core::iter::from_fn(|| self.next(&now)).take(most).collect();
        self.turn(&mut events);
        for (to, from) in room.iter_mut().zip(&events) {
            *to = *from;
        }
        Ok(events.len().min(room.len()))
    }

    fn state(&mut self) -> Result<HeldState, Lost> {
        self.answer()?;
        self.was = self.now();
        for SimPin { code, pin } in &self.pins.wheels {
            if let Some(place) = self.turned.get_mut(usize::from(*code)) {
                *place = pin.get();
            }
        }
        Ok(self.was)
    }

    fn light(&mut self, led: u16, is_on: bool) -> Result<(), Lost> {
        self.answer()?;
        self.pins.lights.iter().filter(|l| l.code == led).for_each(|l| l.pin.set(is_on));
        Ok(())
    }
}
