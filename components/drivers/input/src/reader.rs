//! State of a device, from its events.

use crate::{
    bus::{ABS_COUNT, HeldState, KEY_WORDS, REL_COUNT},
    described::{WheelKind, Wheels},
    event::{DROPPED, InputEvent, REPORT, kind},
};
use hal_component::Plain;

/// Place of a ring before the first report.
pub(crate) const UNKNOWN: i32 = i32::MIN;

/// State of a device, as the worker passes it to the function.
#[derive(Clone, Copy, Debug, PartialEq, Plain)]
pub(crate) struct DeviceRecord {
    /// True while the node of the device can be read.
    pub(crate) connected: bool,
    /// Number of times that the device was opened: 1 for the first.
    pub(crate) opened: u32,
    /// Bits of the keys that are down.
    pub(crate) keys: [u64; KEY_WORDS],
    /// Values of the absolute axes.
    pub(crate) abs: [i32; ABS_COUNT],
    /// Sums of the movements of wheels, which wrap, and places of rings.
    pub(crate) rel: [i32; REL_COUNT],
}

impl DeviceRecord {
    /// No device was opened yet.
    pub(crate) const NONE: Self = Self {
        connected: false,
        opened: 0,
        keys: [0; KEY_WORDS],
        abs: [0; ABS_COUNT],
        rel: [0; REL_COUNT],
    };
}

/// Turns events into the state of a device.
#[derive(Clone, Debug)]
pub(crate) struct DeviceReader {
    wheels: Wheels,
    record: DeviceRecord,
    /// Last places of the wheels that report one.
    places: [Option<i32>; REL_COUNT],
    /// Bits of the axes that the packet under way has moved.
    moved: u16,
    /// True from an event that says that events were lost to the end of that packet.
    is_dropping: bool,
}

impl DeviceReader {
    pub(crate) const fn new(wheels: Wheels) -> Self {
        Self {
            wheels,
            record: DeviceRecord::NONE,
            places: [None; REL_COUNT],
            moved: 0,
            is_dropping: false,
        }
    }

    pub(crate) const fn record(&self) -> &DeviceRecord {
        &self.record
    }

    /// Begins with the state of a device that was opened.
    pub(crate) fn open(&mut self, held: &HeldState) {
        self.record.connected = true;
        self.record.opened = self.record.opened.wrapping_add(1);
        self.take(held);
    }

    /// Takes the state that the kernel was asked for.
    pub(crate) fn take(&mut self, held: &HeldState) {
        self.record.keys = held.keys;
        self.record.abs = held.abs;
        self.places = [None; REL_COUNT];
        self.moved = 0;
        self.is_dropping = false;
        // The kernel keeps no places of rings.
        self.set_rings(0, UNKNOWN);
    }

    /// Notes that the device is gone: nothing is held.
    pub(crate) fn lose(&mut self) {
        self.record.connected = false;
        self.record.keys = [0; KEY_WORDS];
        self.set_rings(0, UNKNOWN);
    }

    /// Takes an event. Returns true if the kernel must be asked for the state, because events were lost.
    pub(crate) fn event(&mut self, event: InputEvent) -> bool {
        let InputEvent { kind: of, code, value } = event;
        let at = usize::from(code);
        match of {
            kind::SYN if code == DROPPED => self.is_dropping = true,
            kind::SYN if code == REPORT => {
                if self.is_dropping {
                    return true;
                }
                let moved = core::mem::take(&mut self.moved);
                self.set_rings(moved, 0);
            }
            _ if self.is_dropping => {}
            kind::KEY => {
                if let Some(word) = self.record.keys.get_mut(at / 64) {
                    let bit = 1 << (at % 64);
                    // The value 2 is a repetition of a key that is down.
                    *word = if value == 0 { *word & !bit } else { *word | bit };
                }
            }
            kind::ABS => {
                if let Some(axis) = self.record.abs.get_mut(at) {
                    *axis = value;
                }
            }
            kind::REL => self.wheel(at, value),
            _ => {}
        }
        false
    }

    fn wheel(&mut self, at: usize, value: i32) {
        let (Some(kind), Some(sum), Some(place)) =
            (self.wheels.get(at), self.record.rel.get_mut(at), self.places.get_mut(at))
        else {
            return;
        };
        self.moved |= 1 << at;
        match *kind {
            WheelKind::Movement => *sum = sum.wrapping_add(value),
            WheelKind::Ring => *sum = value,
            WheelKind::Counter(bits) => {
                if let Some(last) = place.replace(value) {
                    *sum = sum.wrapping_add(moved_by(last, value, bits));
                }
            }
        }
    }

    /// Sets the places of rings whose bits are not set.
    fn set_rings(&mut self, moved: u16, to: i32) {
        for (at, (kind, place)) in self.wheels.iter().zip(&mut self.record.rel).enumerate() {
            if *kind == WheelKind::Ring && moved >> at & 1 == 0 {
                *place = to;
            }
        }
    }
}

/// Returns the movement of a wheel between two places. The place 0 is left out: 1 follows the largest one.
fn moved_by(from: i32, to: i32, bits: u32) -> i32 {
    let places = (1_i64 << bits.min(31)) - 1;
    let by = (i64::from(to) - i64::from(from)).rem_euclid(places);
    let by = if by > places / 2 { by - places } else { by };
    i32::try_from(by).unwrap_or(0)
}
