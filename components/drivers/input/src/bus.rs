//! Input devices as the driver sees them.

use crate::event::InputEvent;
use core::fmt;
use port::Lost;
use std::path::Path;

/// Number of 64-bit words for the keys of a device: the kernel has 768 codes.
pub(crate) const KEY_WORDS: usize = 12;
/// Number of codes of keys and buttons.
pub(crate) const KEY_COUNT: u16 = 768;
/// Number of codes of absolute axes.
pub(crate) const ABS_COUNT: usize = 64;
/// Number of codes of relative axes.
pub(crate) const REL_COUNT: usize = 16;
/// Number of codes of lights.
pub(crate) const LED_COUNT: usize = 16;

/// Numbers and names by which a device is chosen.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(crate) struct Identity {
    pub(crate) bus: u16,
    pub(crate) vendor: u16,
    pub(crate) product: u16,
    pub(crate) version: u16,
    pub(crate) name: String,
    /// Place of its connection; over Bluetooth, the address of the computer's adapter.
    pub(crate) phys: String,
    /// Address or serial number of the device itself; empty for most devices on USB.
    pub(crate) uniq: String,
}

impl Identity {
    /// Returns whether two devices are of the same make.
    pub(crate) fn is_same_make(&self, other: &Self) -> bool {
        (self.vendor, self.product, &self.name) == (other.vendor, other.product, &other.name)
    }

    /// Returns whether two devices of a make have the same place and the same address.
    pub(crate) fn is_in_place(&self, other: &Self) -> bool {
        self.is_same_make(other) && (&self.phys, &self.uniq) == (&other.phys, &other.uniq)
    }
}

/// The line that `/proc/bus/input/devices` has for it.
impl fmt::Display for Identity {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { bus, vendor, product, version, .. } = self;
        write!(f, "Bus={bus:04x} Vendor={vendor:04x} Product={product:04x} Version={version:04x}")
    }
}

/// Range of an absolute axis.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct AxisRange {
    pub(crate) min: i32,
    pub(crate) max: i32,
    /// Change that is noise.
    pub(crate) fuzz: i32,
    /// Distance from the centre that is the centre.
    pub(crate) flat: i32,
    /// Value now.
    pub(crate) value: i32,
}

/// Codes of what a device has, in ascending order.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(crate) struct Abilities {
    pub(crate) keys: Vec<u16>,
    pub(crate) abs: Vec<(u16, AxisRange)>,
    pub(crate) rel: Vec<u16>,
    pub(crate) leds: Vec<u16>,
}

impl Abilities {
    /// Returns whether a device with these abilities can take the place of another one.
    pub(crate) fn cover(&self, other: &Self) -> bool {
        let has = |all: &[u16], some: &[u16]| some.iter().all(|code| all.contains(code));
        let has_axis = |code: &u16| self.abs.iter().any(|(c, _)| c == code);
        has(&self.keys, &other.keys)
            && has(&self.rel, &other.rel)
            && other.abs.iter().all(|(code, _)| has_axis(code))
    }
}

/// State of a device, as the kernel has it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct HeldState {
    /// Bits of the keys that are down.
    pub(crate) keys: [u64; KEY_WORDS],
    pub(crate) abs: [i32; ABS_COUNT],
}

impl HeldState {
    /// Nothing is down.
    pub(crate) const REST: Self = Self { keys: [0; KEY_WORDS], abs: [0; ABS_COUNT] };
}

/// Device that was found.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct FoundDevice {
    /// Number of its node: 3 for event3.
    pub(crate) number: u32,
    pub(crate) identity: Identity,
}

/// All devices of a computer.
pub(crate) trait Bus: Send {
    /// Returns the devices that are there, in the order of their numbers. Opens none of them.
    fn devices(&self) -> Vec<FoundDevice>;

    /// Opens a device; `is_exclusive` keeps its events from all other programs.
    ///
    /// # Errors
    /// The device is gone, another one has its number now, or its node cannot be opened.
    fn open(&self, device: &FoundDevice, is_exclusive: bool) -> Result<Box<dyn InputDevice>, Lost>;

    /// Returns the number of the node that a path leads to.
    fn number_of(&self, _path: &Path) -> Option<u32> {
        None
    }
}

/// Open device. None of its operations waits.
pub(crate) trait InputDevice: Send {
    /// Returns what the device has.
    ///
    /// # Errors
    /// The node cannot be read.
    fn abilities(&self) -> Result<Abilities, Lost>;

    /// Takes the events that wait, as many as there is room for.
    ///
    /// # Errors
    /// The node cannot be read.
    fn read(&mut self, room: &mut [InputEvent]) -> Result<usize, Lost>;

    /// Asks for the state; events that wait are part of it.
    ///
    /// # Errors
    /// The node cannot be read.
    fn state(&mut self) -> Result<HeldState, Lost>;

    /// Switches a light.
    ///
    /// # Errors
    /// The device is gone, or the user may not write to it.
    fn light(&mut self, led: u16, is_on: bool) -> Result<(), Lost>;
}
