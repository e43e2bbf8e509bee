//! Smart-serial remotes: what they say about themselves, and the process data that they exchange.
//!
//! A remote is a text file in `remotes/`:
//!
//! | line | meaning |
//! |---|---|
//! | `name 7I76` | four letters |
//! | `unit HEX` | number on the card's label |
//! | `element NAME TYPE BITS DIRECTION MIN MAX UNIT` | process data |
//! | `parameter NAME TYPE BITS MIN MAX UNIT VALUE` | parameter that is no process data |
//! | `mode NAME: ELEMENT …` | elements of a software mode, in order; modes are numbered from 0 |
//!
//! Source: section "SSLBP" of Mesa's manuals (7I76E, pages 30 to 59).

use std::collections::BTreeMap;

/// Remotes by name, in the order of their names.
const FILES: &[(&str, &str)] = &[
    ("7i70", include_str!("../remotes/7i70.txt")),
    ("7i71", include_str!("../remotes/7i71.txt")),
    ("7i73", include_str!("../remotes/7i73.txt")),
    ("7i76", include_str!("../remotes/7i76.txt")),
    ("7i77", include_str!("../remotes/7i77.txt")),
    ("7i77-analog", include_str!("../remotes/7i77-analog.txt")),
    ("7i84", include_str!("../remotes/7i84.txt")),
];

/// Names of the remotes.
pub fn remotes() -> impl Iterator<Item = &'static str> {
    FILES.iter().map(|file| file.0)
}

/// Bytes of the memory that the controller can read and write.
const MEMORY: usize = 0x2000;
/// Addresses of the process data, the lists, and the records.
const DATA_AT: usize = 0x0100;
const LISTS_AT: usize = 0x0400;
const RECORDS_AT: usize = 0x0800;
/// Bits of process data in one direction.
const PROCESS_BITS: u8 = 96;
const RECORD: u8 = 0xA0;
const MODE_RECORD: u8 = 0xB0;
/// Command that switches between the memory and the parameters that outlast power, with a flag as data.
const SELECT: u8 = 0xEC;

/// Kind of a datum.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
enum DataKind {
    Padding = 0,
    Bits = 1,
    Unsigned = 2,
    Signed = 3,
    LastingUnsigned = 4,
    LastingSigned = 5,
    Stream = 6,
    Boolean = 7,
    Encoder = 8,
}

/// Direction of a datum, as the controller sees it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
enum Flow {
    In = 0,
    Both = 0x40,
    Out = 0x80,
}

#[derive(Clone, Debug)]
struct Datum {
    name: Box<str>,
    kind: DataKind,
    bits: u8,
    way: Flow,
    min: f32,
    max: f32,
    unit: Box<str>,
    value: u64,
    at: usize,
    is_parameter: bool,
}

#[derive(Clone, Debug)]
struct SoftwareMode {
    elements: Vec<usize>,
    list: u16,
}

/// Remote at a channel of a smart-serial port.
#[derive(Clone, Debug)]
pub struct Remote {
    name: [u8; 4],
    unit: u32,
    data: Vec<Datum>,
    modes: Vec<SoftwareMode>,
    globals: u16,
    mode: usize,
    memory: Box<[u8]>,
    is_lasting: bool,
}

/// Error of a remote's text.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct BadRemote {
    /// Line, from 1; 0 for what the text lacks or has too much of.
    pub line: usize,
}

impl core::fmt::Display for BadRemote {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        match self.line {
            0 => f.write_str("a name, a mode, or room for the records is missing"),
            line => write!(f, "line {line}: a word is missing or unknown, or a number is none"),
        }
    }
}

impl core::error::Error for BadRemote {}

impl Remote {
    /// Returns the remote with this name.
    #[must_use]
    pub fn named(name: &str) -> Option<Self> {
        let text = FILES.iter().find(|file| file.0 == name)?.1;
        Self::parse(text).ok()
    }

    /// Reads a remote's text.
    ///
    /// # Errors
    /// A line is none that a remote has, or the records do not fit into its memory.
    pub fn parse(text: &str) -> Result<Self, BadRemote> {
        let mut remote = Self {
            name: [0; 4],
            unit: 0,
            data: Vec::new(),
            modes: Vec::new(),
            globals: 0,
            mode: 0,
            memory: vec![0; MEMORY].into(),
            is_lasting: false,
        };
        let mut mode_names = Vec::new();
        for (at, line) in text.lines().enumerate() {
            let line = line.split('#').next().unwrap_or_default();
            let words: Vec<&str> = line.split_whitespace().collect();
            remote.line(&words, &mut mode_names).ok_or(BadRemote { line: at + 1 })?;
        }
        let good = remote.name != [0; 4] && !remote.modes.is_empty();
        good.then_some(())
            .and_then(|()| remote.write_records(&mode_names))
            .ok_or(BadRemote { line: 0 })?;
        Ok(remote)
    }

    fn line<'t>(&mut self, words: &[&'t str], mode_names: &mut Vec<&'t str>) -> Option<()> {
        match words {
            [] => Some(()),
            ["name", name] => {
                self.name = name.as_bytes().try_into().ok()?;
                Some(())
            }
            ["unit", unit] => {
                self.unit = u32::from_str_radix(unit, 16).ok()?;
                Some(())
            }
            ["element", name, kind, bits, way, min, max, unit] => {
                let way = match *way {
                    "in" => Flow::In,
                    "out" => Flow::Out,
                    "both" => Flow::Both,
                    _ => return None,
                };
                self.datum(&[name, kind, bits, min, max, unit], way, 0, false)
            }
            ["parameter", name, kind, bits, min, max, unit, value] => {
                let value = value.parse().ok()?;
                self.datum(&[name, kind, bits, min, max, unit], Flow::Both, value, true)
            }
            ["mode", name, elements @ ..] => {
                mode_names.push(name.strip_suffix(':')?);
                let of = |name: &&str| {
                    self.data.iter().position(|d| !d.is_parameter && *d.name == **name)
                };
                let elements: Vec<usize> = elements.iter().map(of).collect::<Option<_>>()?;
                self.modes.push(SoftwareMode { elements, list: 0 });
                Some(())
            }
            _ => None,
        }
    }

    fn datum(
        &mut self,
        words: &[&str; 6],
        way: Flow,
        value: u64,
        is_parameter: bool,
    ) -> Option<()> {
        let [name, kind, bits, min, max, unit] = words;
        let kind = match *kind {
            "padding" => DataKind::Padding,
            "bits" => DataKind::Bits,
            "unsigned" => DataKind::Unsigned,
            "signed" => DataKind::Signed,
            "lasting-unsigned" => DataKind::LastingUnsigned,
            "lasting-signed" => DataKind::LastingSigned,
            "stream" => DataKind::Stream,
            "boolean" => DataKind::Boolean,
            "encoder" => DataKind::Encoder,
            _ => return None,
        };
        let bits = bits.parse().ok().filter(|bits| (1..=64).contains(bits))?;
        let at = DATA_AT + self.data.len() * 8;
        self.data.push(Datum {
            name: (*name).into(),
            kind,
            bits,
            way,
            min: min.parse().ok()?,
            max: max.parse().ok()?,
            unit: (*unit).into(),
            value,
            at,
            is_parameter,
        });
        (at + 8 <= LISTS_AT).then_some(())
    }

    /// Writes the lists and the records of all data into the memory.
    fn write_records(&mut self, mode_names: &[&str]) -> Option<()> {
        let mut at = RECORDS_AT;
        let mut records = BTreeMap::new();
        for (nth, datum) in self.data.iter().enumerate() {
            records.insert(nth, u16::try_from(at).ok()?);
            let [low, high] = u16::try_from(datum.at).ok()?.to_le_bytes();
            let head = [RECORD, datum.bits, datum.kind as u8, datum.way as u8];
            let parts: [&[u8]; 8] = [
                &head,
                &datum.min.to_le_bytes(),
                &datum.max.to_le_bytes(),
                &[low, high],
                datum.unit.as_bytes(),
                &[0],
                datum.name.as_bytes(),
                &[0],
            ];
            at = put(&mut self.memory, at, &parts)?;
            self.memory
                .get_mut(datum.at..)?
                .get_mut(..8)?
                .copy_from_slice(&datum.value.to_le_bytes());
        }
        let mut list = LISTS_AT;
        for (nth, mode) in self.modes.iter_mut().enumerate() {
            let record = u16::try_from(at).ok()?;
            let head = [MODE_RECORD, u8::try_from(nth).ok()?, 1, 0];
            at = put(&mut self.memory, at, &[&head, mode_names.get(nth)?.as_bytes(), &[0]])?;
            mode.list = u16::try_from(list).ok()?;
            for element in &mode.elements {
                list = put(&mut self.memory, list, &[&records.get(element)?.to_le_bytes()])?;
            }
            list = put(&mut self.memory, list, &[&record.to_le_bytes(), &[0, 0]])?;
        }
        self.globals = u16::try_from(list).ok()?;
        for (nth, datum) in self.data.iter().enumerate() {
            if datum.is_parameter {
                list = put(&mut self.memory, list, &[&records.get(&nth)?.to_le_bytes()])?;
            }
        }
        list = put(&mut self.memory, list, &[&[0, 0]])?;
        (list <= RECORDS_AT).then_some(())
    }

    /// Returns unit number, name, and pointers to the lists, as the port has them after a start.
    pub(crate) fn account(&self) -> [u32; 3] {
        let list = self.modes.get(self.mode).map_or(0, |mode| mode.list);
        [self.unit, u32::from_le_bytes(self.name), u32::from(self.globals) << 16 | u32::from(list)]
    }

    /// Starts the remote in a mode; false if it has no such mode.
    pub(crate) fn start(&mut self, mode: u8) -> bool {
        self.is_lasting = false;
        let mode = usize::from(mode);
        let known = mode < self.modes.len();
        if known {
            self.mode = mode;
        }
        known
    }

    /// Runs a command of the setup mode: its byte, an address, and the data of a write. Returns the data of a read.
    pub(crate) fn command(&mut self, command: u8, address: u16, data: u64) -> Option<u64> {
        if command == SELECT {
            self.is_lasting = data != 0;
            return Some(0);
        }
        if command >> 6 != 1 {
            return None;
        }
        let size = 1_usize << (command & 3);
        let place = self.memory.get_mut(usize::from(address)..)?.get_mut(..size)?;
        if command & 0x20 == 0 {
            let mut bytes = [0; 8];
            bytes.get_mut(..size)?.copy_from_slice(place);
            return Some(u64::from_le_bytes(bytes));
        }
        // Only data are writable: lists and records are not.
        let end = usize::from(address) + size;
        if usize::from(address) < DATA_AT || LISTS_AT < end {
            return None;
        }
        place.copy_from_slice(data.to_le_bytes().get(..size)?);
        Some(0)
    }

    /// Takes the process data of the controller, and returns those of the remote.
    pub(crate) fn exchange(&mut self, from: [u32; 3]) -> [u32; 3] {
        let [a, b, c] = from.map(u128::from);
        let (mut from, mut to, mut at) = (a | b << 32 | c << 64, 0_u128, 0_u32);
        let Some(mode) = self.modes.get(self.mode) else { return [0; 3] };
        for nth in &mode.elements {
            let Some(datum) = self.data.get_mut(*nth) else { continue };
            let mask = u64::MAX >> (64 - u32::from(datum.bits.max(1)));
            if datum.way != Flow::In {
                let [low, high] = split(from);
                datum.value = (low | high << 32) & mask;
                from >>= datum.bits;
            }
            if datum.way != Flow::Out && at < u32::from(PROCESS_BITS) {
                to |= u128::from(datum.value & mask) << at;
                at += u32::from(datum.bits);
            }
        }
        let [low, high] = split(to);
        let [third, _] = split(to >> 64);
        [low, high, third].map(|word| u32::try_from(word).unwrap_or(0))
    }

    /// Switches all outputs off.
    pub(crate) fn release(&mut self) {
        for datum in self.data.iter_mut().filter(|d| !d.is_parameter && d.way != Flow::In) {
            datum.value = 0;
        }
    }

    /// Returns the process data with this name, as bits.
    #[must_use]
    pub fn value(&self, name: &str) -> Option<u64> {
        self.data.iter().find(|d| !d.is_parameter && &*d.name == name).map(|d| d.value)
    }

    /// Sets the process data with this name, as bits. Returns whether the remote has it as an input.
    pub fn set(&mut self, name: &str, value: u64) -> bool {
        let mut all = self.data.iter_mut();
        let found = all.find(|d| !d.is_parameter && d.way != Flow::Out && &*d.name == name);
        found.map(|datum| datum.value = value).is_some()
    }
}

/// Returns the low 64 bits as two words.
const fn split(bits: u128) -> [u64; 2] {
    let [a, b, c, d, e, f, g, h, ..] = bits.to_le_bytes();
    [u32::from_le_bytes([a, b, c, d]) as u64, u32::from_le_bytes([e, f, g, h]) as u64]
}

/// Puts bytes into the memory, and returns where they end.
fn put(memory: &mut [u8], mut at: usize, parts: &[&[u8]]) -> Option<usize> {
    for part in parts {
        memory.get_mut(at..)?.get_mut(..part.len())?.copy_from_slice(part);
        at += part.len();
    }
    Some(at)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_remote_has_its_records() {
        let folder = std::fs::read_dir(concat!(env!("CARGO_MANIFEST_DIR"), "/remotes")).unwrap();
        assert_eq!(folder.count(), remotes().count(), "a file that no row names");
        for (name, text) in FILES {
            let remote = Remote::parse(text).unwrap_or_else(|fault| panic!("{name}: {fault}"));
            for mode in &remote.modes {
                let bits = |out: Flow| -> u32 {
                    let data = mode.elements.iter().map(|nth| &remote.data[*nth]);
                    data.filter(|d| d.way == out).map(|d| u32::from(d.bits)).sum()
                };
                assert!(bits(Flow::In) <= 96 && bits(Flow::Out) <= 96, "{name}");
            }
            let unit = remote.data.iter().find(|d| &*d.name == "NVUnitNumber").unwrap();
            assert_eq!(unit.value, u64::from(remote.unit), "{name}");
        }
    }

    #[test]
    fn a_bad_line_is_named() {
        let rows = [
            ("nonsense", 1),
            ("name 7I7", 1),
            ("unit xyz", 1),
            ("name 7I76\nelement A bits 65 in 0 0 None", 2),
            ("element A bits 0 in 0 0 None", 1),
            ("element A word 8 in 0 0 None", 1),
            ("element A bits 8 up 0 0 None", 1),
            ("parameter A bits 8 0 0 None x", 1),
            ("mode A: B", 1),
            ("mode A", 1),
            ("name 7I76", 0),
        ];
        for (text, line) in rows {
            assert_eq!(Remote::parse(text).err(), Some(BadRemote { line }), "{text}");
        }
        let many = "element A bits 8 in 0 0 None\n".repeat(200);
        assert!(Remote::parse(&many).is_err());
    }
}
