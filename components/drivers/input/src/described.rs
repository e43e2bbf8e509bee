//! Devices as text: the lines of `/proc/bus/input/devices`, with ranges of axes and differences.

use crate::{
    bus::{
        ABS_COUNT, Abilities, AxisRange, FoundDevice, Identity, KEY_COUNT, KEY_WORDS, LED_COUNT,
        REL_COUNT,
    },
    codes,
    event::kind,
};
use core::fmt;

/// Devices that come with the driver.
const KNOWN: &str = include_str!("devices.txt");

/// Meaning of the values of a relative axis.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) enum WheelKind {
    /// Each value is a movement.
    #[default]
    Movement,
    /// Each value is the place of a wheel, a number of so many bits that leaves out 0.
    Counter(u32),
    /// Each value is the place of a ring with a spring; a packet without one means 0.
    Ring,
}

/// Meaning of the relative axes of a device, by their codes.
pub(crate) type Wheels = [WheelKind; REL_COUNT];

/// Described device.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(crate) struct Described {
    pub(crate) identity: Identity,
    pub(crate) abilities: Abilities,
    pub(crate) wheels: Wheels,
}

/// Problem of a description: the number of its line, and what was expected there.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct BadLine(pub(crate) usize, pub(crate) &'static str);

impl fmt::Display for BadLine {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "line {}: expected {}", self.0, self.1)
    }
}

/// Returns the devices that come with the driver.
pub(crate) fn known() -> Vec<Described> {
    parse(KNOWN).unwrap_or_default()
}

/// Returns the device that has all keys and all axes with a name, which stands for one that nobody has described.
pub(crate) fn everything() -> Described {
    let range = |code: u16| {
        let name = codes::name(kind::ABS, code);
        let most = if name.contains("hat") { 1 } else { 32_767 };
        AxisRange { min: -most, max: most, ..AxisRange::default() }
    };
    let axes = codes::all(kind::ABS).into_iter();
    Described {
        identity: Identity { name: "everything".to_owned(), ..Identity::default() },
        abilities: Abilities {
            keys: (0..KEY_COUNT).collect(),
            // Fingers on a pad are no axes of a machine.
            abs: axes.filter(|code| *code < 0x2f).map(|code| (code, range(code))).collect(),
            rel: codes::all(kind::REL),
            leds: codes::all(kind::LED),
        },
        wheels: Wheels::default(),
    }
}

/// Reads descriptions.
///
/// # Errors
/// The first line that is none.
pub(crate) fn parse(text: &str) -> Result<Vec<Described>, BadLine> {
    let mut all = Vec::new();
    let mut device: Option<Described> = None;
    for (number, line) in (1..).zip(text.lines()) {
        let line = line.trim();
        if line.is_empty() {
            all.extend(device.take());
        } else if !line.starts_with('#') {
            let device = device.get_or_insert_default();
            read(device, line).map_err(|expected| BadLine(number, expected))?;
        }
    }
    all.extend(device);
    Ok(all)
}

/// Returns the devices with a node that `/proc/bus/input/devices` lists, in the order of their numbers. Devices choose their
/// names: a line that cannot be read is left out.
pub(crate) fn listed(text: &str) -> Vec<FoundDevice> {
    let device = |block: &str| {
        let (mut found, mut number) = (Identity::default(), None);
        for line in block.lines() {
            match line.split_once(':') {
                Some(("H", handlers)) => number = number.or_else(|| node(handlers)),
                Some((letter @ ("I" | "N" | "P" | "U"), rest)) => {
                    identity(&mut found, letter, rest.trim()).unwrap_or_default();
                }
                _ => {}
            }
        }
        Some(FoundDevice { number: number?, identity: found })
    };
    let mut all: Vec<_> = text.split("\n\n").filter_map(device).collect();
    all.sort_by_key(|device| device.number);
    all
}

/// Returns the number of the node among handlers: 3 for ` Handlers=kbd event3`.
fn node(handlers: &str) -> Option<u32> {
    let mut names = handlers.trim().strip_prefix("Handlers=")?.split_whitespace();
    names.find_map(|name| name.strip_prefix("event")?.parse().ok())
}

/// Returns a text of a device as it is compared: its first line, without spaces around it.
pub(crate) fn first_line(text: &str) -> String {
    text.lines().next().unwrap_or_default().trim().to_owned()
}

fn read(device: &mut Described, line: &str) -> Result<(), &'static str> {
    const LINE: &str = "a line of /proc/bus/input/devices, such as N: Name=\"Gamepad\", or one that begins with A: or D:";
    let (letter, rest) = line.split_once(':').ok_or(LINE)?;
    let rest = rest.trim();
    match letter {
        "I" | "N" | "P" | "U" => identity(&mut device.identity, letter, rest),
        "S" | "H" => Ok(()),
        "B" => bits(&mut device.abilities, rest),
        "A" => axis(&mut device.abilities, rest),
        "D" => difference(&mut device.wheels, rest),
        _ => Err(LINE),
    }
}

/// Reads a line `I`, `N`, `P` or `U`.
fn identity(identity: &mut Identity, letter: &str, text: &str) -> Result<(), &'static str> {
    match letter {
        "N" => {
            let name = text.strip_prefix("Name=").ok_or("Name=\"…\"")?;
            let name = name.strip_prefix('"').unwrap_or(name);
            identity.name = first_line(name.strip_suffix('"').unwrap_or(name));
        }
        "P" => identity.phys = text.strip_prefix("Phys=").ok_or("Phys=…")?.to_owned(),
        "U" => identity.uniq = text.strip_prefix("Uniq=").ok_or("Uniq=…")?.to_owned(),
        _ => numbers(identity, text)?,
    }
    Ok(())
}

fn numbers(identity: &mut Identity, text: &str) -> Result<(), &'static str> {
    const EXPECTED: &str =
        "Bus=0003 Vendor=046d Product=c216 Version=0110, with numbers of 16 bits";
    for word in text.split_whitespace() {
        let (name, value) = word.split_once('=').ok_or(EXPECTED)?;
        let value = u16::from_str_radix(value, 16).map_err(|_| EXPECTED)?;
        match name {
            "Bus" => identity.bus = value,
            "Vendor" => identity.vendor = value,
            "Product" => identity.product = value,
            "Version" => identity.version = value,
            _ => return Err(EXPECTED),
        }
    }
    Ok(())
}

/// Reads a mask of codes: words of 64 bits, the highest first.
fn bits(abilities: &mut Abilities, text: &str) -> Result<(), &'static str> {
    const EXPECTED: &str =
        "a mask of codes, such as KEY=fff00000000 0 0 0 0: words of 64 bits, at most 12";
    let (name, mask) = text.split_once('=').ok_or(EXPECTED)?;
    let words: Vec<&str> = mask.split_whitespace().collect();
    if words.is_empty() || words.len() > KEY_WORDS {
        return Err(EXPECTED);
    }
    let mut codes = Vec::new();
    for (at, word) in (0u16..).zip(words.iter().rev()) {
        let word = u64::from_str_radix(word, 16).map_err(|_| EXPECTED)?;
        codes.extend((0..64).filter(|bit| word >> bit & 1 != 0).map(|bit| at * 64 + bit));
    }
    let below = |most: usize| codes.iter().all(|code| usize::from(*code) < most);
    match name {
        "KEY" => abilities.keys = codes,
        "REL" if below(REL_COUNT) => abilities.rel = codes,
        "LED" if below(LED_COUNT) => abilities.leds = codes,
        "ABS" if below(ABS_COUNT) => {
            let usual = AxisRange { max: 255, flat: 15, value: 127, ..AxisRange::default() };
            abilities.abs = codes.into_iter().map(|code| (code, usual)).collect();
        }
        "REL" | "LED" | "ABS" => return Err("a mask of codes that the kernel has"),
        _ => {}
    }
    Ok(())
}

fn axis(abilities: &mut Abilities, text: &str) -> Result<(), &'static str> {
    const EXPECTED: &str =
        "an axis of the line ABS with its range: abs-x MIN MAX FUZZ FLAT, and its value at rest";
    let mut words = text.split_whitespace();
    let code = words.next().and_then(|name| codes::code(kind::ABS, name)).ok_or(EXPECTED)?;
    let numbers = words.map(str::parse).collect::<Result<Vec<i32>, _>>().map_err(|_| EXPECTED)?;
    let (min, max, fuzz, flat, value) = match *numbers {
        [min, max, fuzz, flat] => (min, max, fuzz, flat, min.midpoint(max)),
        [min, max, fuzz, flat, value] => (min, max, fuzz, flat, value),
        _ => return Err(EXPECTED),
    };
    let axis = abilities.abs.iter_mut().find(|axis| axis.0 == code).ok_or(EXPECTED)?;
    axis.1 = AxisRange { min, max, fuzz, flat, value };
    Ok(())
}

fn difference(wheels: &mut Wheels, text: &str) -> Result<(), &'static str> {
    const EXPECTED: &str = "rel-wheel ring, or rel-dial counter 8, with 2 to 31 bits";
    let words: Vec<&str> = text.split_whitespace().collect();
    let (name, meaning) = match *words {
        [name, "ring"] => (name, WheelKind::Ring),
        [name, "counter", bits] => {
            let bits = bits.parse().ok().filter(|bits| (2..32).contains(bits)).ok_or(EXPECTED)?;
            (name, WheelKind::Counter(bits))
        }
        _ => return Err(EXPECTED),
    };
    let code = codes::code(kind::REL, name).ok_or(EXPECTED)?;
    *wheels.get_mut(usize::from(code)).ok_or(EXPECTED)? = meaning;
    Ok(())
}
