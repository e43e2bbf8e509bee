//! Specifications of devices, as in LinuxCNC: which device, and which of its features have pins.

use crate::bus::{FoundDevice, Identity};
use std::path::PathBuf;

/// Largest number of devices.
pub(crate) const MOST_DEVICES: u32 = 16;

/// Features of a device that have pins.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Features {
    pub(crate) keys: bool,
    pub(crate) rel: bool,
    pub(crate) abs: bool,
    pub(crate) leds: bool,
}

/// Way to choose a device.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum Choice {
    /// The device with the node of this number: 3 is /dev/input/event3; if there is none, one with these digits in its name.
    Number(u32, String),
    /// The device to whose node this path leads.
    Path(PathBuf),
    /// Vendor and product, and the bus if it is given.
    Numbers { bus: Option<u16>, vendor: u16, product: u16 },
    /// A part of its name, of `Phys=`, or of its line `Bus=… Vendor=… Product=… Version=…`, or a pattern with `*` and `?`.
    Text(String),
}

/// Device that a user asks for.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct DeviceSpec {
    pub(crate) features: Features,
    pub(crate) is_exclusive: bool,
    pub(crate) choice: Choice,
    /// Number of the device among those that match, from 0.
    pub(crate) nth: usize,
}

/// Problem of a specification.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum BadSpec {
    /// There is no device behind the letters.
    NoDevice,
    /// The letters are others than K, R, A and L.
    Letters,
}

impl DeviceSpec {
    /// Reads a specification such as `-KRAL +Gamepad:1`.
    ///
    /// # Errors
    /// The word has other letters, or names no device.
    pub(crate) fn parse(word: &str) -> Result<Self, BadSpec> {
        let word = word.trim();
        let (letters, rest) = match word.strip_prefix('-') {
            Some(rest) => rest.split_once(char::is_whitespace).unwrap_or((rest, "")),
            None => ("KRAL", word),
        };
        if letters.is_empty() || !letters.chars().all(|c| "KRAL".contains(c)) {
            return Err(BadSpec::Letters);
        }
        let has = |letter| letters.contains(letter);
        let features = Features { keys: has('K'), rel: has('R'), abs: has('A'), leds: has('L') };
        let rest = rest.trim();
        let (is_exclusive, text) = match rest.strip_prefix('+') {
            Some(text) => (true, text),
            None => (false, rest),
        };
        let (choice, nth) = choice(text);
        if choice == Choice::Text(String::new()) {
            return Err(BadSpec::NoDevice);
        }
        Ok(Self { features, is_exclusive, choice, nth })
    }

    /// Returns the device that is meant. A pattern matches the whole of a text, or, if it matches none, a part.
    pub(crate) fn find<'d>(&self, devices: &'d [FoundDevice]) -> Option<&'d FoundDevice> {
        if let Choice::Number(number, _) = &self.choice
            && self.nth == 0
            && let Some(device) = devices.iter().find(|device| device.number == *number)
        {
            return Some(device);
        }
        let of = |anywhere: bool| devices.iter().filter(move |d| self.matches(d, anywhere));
        let anywhere = of(false).next().is_none();
        of(anywhere).nth(self.nth)
    }

    fn matches(&self, device: &FoundDevice, anywhere: bool) -> bool {
        let Identity { name, phys, .. } = &device.identity;
        match &self.choice {
            Choice::Number(_, digits) => name.contains(digits.as_str()),
            Choice::Path(_) => false,
            Choice::Numbers { bus, vendor, product } => {
                let id = &device.identity;
                bus.is_none_or(|bus| bus == id.bus)
                    && (*vendor, *product) == (id.vendor, id.product)
            }
            Choice::Text(text) => {
                let numbers = device.identity.to_string();
                let pattern = if anywhere { format!("*{text}*") } else { text.clone() };
                [name, phys, &numbers].iter().any(|is| {
                    is.contains(text.as_str()) || is_like(is.as_bytes(), pattern.as_bytes())
                })
            }
        }
    }
}

fn choice(text: &str) -> (Choice, usize) {
    // Names that udev gives have colons.
    if text.starts_with('/') {
        return (Choice::Path(text.into()), 0);
    }
    if let Some(numbers) = numbers(text) {
        return (numbers, 0);
    }
    let (text, nth) = match text.rsplit_once(':') {
        Some((text, nth)) if nth.bytes().all(|b| b.is_ascii_digit()) && !nth.is_empty() => {
            (text, nth.parse().unwrap_or(usize::MAX))
        }
        _ => (text, 0),
    };
    let choice = numbers(text)
        .or_else(|| text.parse().ok().map(|number| Choice::Number(number, text.to_owned())))
        .unwrap_or_else(|| Choice::Text(text.to_owned()));
    (choice, nth)
}

/// Reads `VENDOR:PRODUCT` or `BUS:VENDOR:PRODUCT`, of four hexadecimal digits each.
fn numbers(text: &str) -> Option<Choice> {
    let number = |word: &str| {
        let is_number = word.len() == 4 && word.bytes().all(|b| b.is_ascii_hexdigit());
        is_number.then(|| u16::from_str_radix(word, 16).ok()).flatten()
    };
    let words = text.split(':').map(number).collect::<Option<Vec<u16>>>()?;
    match *words {
        [vendor, product] => Some(Choice::Numbers { bus: None, vendor, product }),
        [bus, vendor, product] => Some(Choice::Numbers { bus: Some(bus), vendor, product }),
        _ => None,
    }
}

/// Returns whether the whole text matches a pattern, in which `*` is any text and `?` any byte.
fn is_like(text: &[u8], pattern: &[u8]) -> bool {
    let (mut t, mut p) = (0, 0);
    // Place behind the last star, and the text from which it goes on.
    let mut star = None;
    while let Some(byte) = text.get(t) {
        match pattern.get(p) {
            Some(b'*') => {
                p += 1;
                star = Some((p, t));
            }
            Some(b'?') => (t, p) = (t + 1, p + 1),
            Some(other) if other == byte => (t, p) = (t + 1, p + 1),
            _ => {
                let Some((behind, from)) = star else { return false };
                star = Some((behind, from + 1));
                (t, p) = (from + 1, behind);
            }
        }
    }
    pattern.get(p..).is_some_and(|rest| rest.iter().all(|b| *b == b'*'))
}
