//! Boards: which modules a card has, and which of them may use each I/O pin.
//!
//! A board is a text file in `boards/`:
//!
//! | line | meaning |
//! |---|---|
//! | `name 7I92` | name of the card, as space 7 has it |
//! | `board MESA7I92` | name of the board in the identification |
//! | `chip 9 144` | size and legs of the chip |
//! | `ports 2 17` | ports of I/O pins, and pins of each |
//! | `clocks LOW HIGH` | clocks of the modules in hertz |
//! | `scanned 24` | number of scanned inputs, if there are any |
//! | `module NAME VERSION CLOCK INSTANCES BASE REGISTERS STRIDES MULTIPLE` | a descriptor; base, strides and multiple are hexadecimal |
//! | `pin N TERMINAL [MODULE INSTANCE NAME]` | an I/O pin; without a module it is an I/O pin only |
//!
//! A terminal is `unknown` where no document gives it, and `internal` where no terminal has the pin.

use hal_firmware::{Clock, Identification, MAX_MODULES, MAX_PINS, Module, Pin, Tag};

/// Boards by name, in the order of their names.
const FILES: &[(&str, &str)] = &[
    ("7i76e", include_str!("../boards/7i76e.txt")),
    ("7i76eu", include_str!("../boards/7i76eu.txt")),
    ("7i80db", include_str!("../boards/7i80db.txt")),
    ("7i80hd", include_str!("../boards/7i80hd.txt")),
    ("7i92", include_str!("../boards/7i92.txt")),
    ("7i92-5abobx2", include_str!("../boards/7i92-5abobx2.txt")),
    ("7i92t", include_str!("../boards/7i92t.txt")),
    ("7i93", include_str!("../boards/7i93.txt")),
    ("7i95", include_str!("../boards/7i95.txt")),
    ("7i95t", include_str!("../boards/7i95t.txt")),
    ("7i96", include_str!("../boards/7i96.txt")),
    ("7i96s", include_str!("../boards/7i96s.txt")),
    ("7i97", include_str!("../boards/7i97.txt")),
    ("7i97t", include_str!("../boards/7i97t.txt")),
    ("7i98", include_str!("../boards/7i98.txt")),
];

/// Names of the boards.
pub fn boards() -> impl Iterator<Item = &'static str> {
    FILES.iter().map(|file| file.0)
}

/// Card with its firmware.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Board {
    /// Name of the card, as space 7 has it.
    pub name: [u8; 16],
    /// Identification of the firmware.
    pub identification: Identification,
    /// Descriptors of the modules.
    pub modules: Vec<Module>,
    /// Descriptors of the I/O pins.
    pub pins: Vec<Pin>,
    /// Terminal of each I/O pin, as the document of the board has it.
    pub terminals: Vec<Terminal>,
    /// Number of scanned inputs.
    pub scanned: u8,
}

/// Place at which an I/O pin can be reached.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Terminal {
    /// Nowhere: a part of the card uses it.
    Internal,
    /// No document gives it.
    Unknown,
    /// Connector and pin, as a document gives them.
    Named(Box<[u8]>),
}

/// Error of a board's text.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct BadBoard {
    /// Line, from 1; 0 for what the text lacks.
    pub line: usize,
    /// Fault of the line.
    pub fault: BoardFault,
}

/// Faults of a line of a board's text.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BoardFault {
    /// A word is missing, or is none that is known.
    Word,
    /// A number is none, or is too large.
    Number,
    /// An unknown module, or one that the card does not have.
    Module,
    /// The module has no pin with that name.
    Name,
    /// The pin is not the next one.
    Order,
    /// The pins are not those of the ports, or there are too many modules.
    Count,
}

impl core::fmt::Display for BadBoard {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        let fault = match self.fault {
            BoardFault::Word => "a word is missing or unknown",
            BoardFault::Number => "a number is none, or is too large",
            BoardFault::Module => "the card has no such module",
            BoardFault::Name => "the module has no such pin",
            BoardFault::Order => "pins must be in order, from 0",
            BoardFault::Count => "the pins must be those of the ports, of at most 32 modules",
        };
        write!(f, "line {}: {fault}", self.line)
    }
}

impl core::error::Error for BadBoard {}

impl Board {
    /// Returns the board with this name.
    #[must_use]
    pub fn named(name: &str) -> Option<Self> {
        let text = FILES.iter().find(|file| file.0 == name)?.1;
        Self::parse(text).ok()
    }

    /// Reads a board's text.
    ///
    /// # Errors
    /// A line is none that a board has.
    pub fn parse(text: &str) -> Result<Self, BadBoard> {
        let mut board = Self {
            name: [0; 16],
            identification: Identification {
                layout: 3,
                modules: 0x40,
                pins: 0x200,
                board: [0; 8],
                chip_size: 0,
                chip_pins: 0,
                ports: 0,
                width: 0,
                port_width: 0,
                clock_low: 0,
                clock_high: 0,
                instance_strides: [4, 64],
                register_strides: [256, 256],
            },
            modules: Vec::new(),
            pins: Vec::new(),
            terminals: Vec::new(),
            scanned: 0,
        };
        for (at, line) in text.lines().enumerate() {
            let line = line.split('#').next().unwrap_or_default();
            let mut words = line.split_whitespace();
            let Some(first) = words.next() else { continue };
            board.line(first, &mut words).map_err(|fault| BadBoard { line: at + 1, fault })?;
            if words.next().is_some() {
                return Err(BadBoard { line: at + 1, fault: BoardFault::Word });
            }
        }
        let count = u32::try_from(board.pins.len()).unwrap_or(u32::MAX);
        if board.identification.width != count
            || MAX_PINS < board.pins.len()
            || MAX_MODULES < board.modules.len()
        {
            return Err(BadBoard { line: 0, fault: BoardFault::Count });
        }
        Ok(board)
    }

    fn line<'t>(
        &mut self,
        first: &str,
        words: &mut impl Iterator<Item = &'t str>,
    ) -> Result<(), BoardFault> {
        let id = &mut self.identification;
        match first {
            "name" => self.name = padded(words.next())?,
            "board" => id.board = padded(words.next())?,
            "chip" => (id.chip_size, id.chip_pins) = (number(words)?, number(words)?),
            "ports" => {
                (id.ports, id.port_width) = (number(words)?, number(words)?);
                id.width = id.ports.checked_mul(id.port_width).ok_or(BoardFault::Number)?;
            }
            "clocks" => (id.clock_low, id.clock_high) = (number(words)?, number(words)?),
            "scanned" => self.scanned = byte(number(words)?)?,
            "module" => self.modules.push(module(words)?),
            "pin" => self.pin(words)?,
            _ => return Err(BoardFault::Word),
        }
        Ok(())
    }

    fn pin<'t>(&mut self, words: &mut impl Iterator<Item = &'t str>) -> Result<(), BoardFault> {
        if usize::try_from(number(words)?).ok() != Some(self.pins.len()) {
            return Err(BoardFault::Order);
        }
        let terminal = match words.next().ok_or(BoardFault::Word)? {
            "internal" => Terminal::Internal,
            "unknown" => Terminal::Unknown,
            named => Terminal::Named(named.as_bytes().into()),
        };
        let pin = match words.next() {
            None => Pin::plain(),
            Some(name) => {
                let tag = tag(name)?;
                let instance = byte(number(words)?)?;
                let name = words.next().ok_or(BoardFault::Word)?;
                let mut all = tag.pin_names();
                let (number, is_output, _) =
                    all.find(|pin| is_text(&pin.2, name)).ok_or(BoardFault::Name)?;
                if !self.modules.iter().any(|m| m.tag == tag as u8) {
                    return Err(BoardFault::Module);
                }
                Pin { number, is_output, tag: tag as u8, instance, ..Pin::plain() }
            }
        };
        self.pins.push(pin);
        self.terminals.push(terminal);
        Ok(())
    }
}

/// Returns whether a name is written so.
fn is_text(name: &hal_firmware::PinName, text: &str) -> bool {
    let rest = text.strip_prefix(name.stem);
    match name.index {
        None => rest == Some(""),
        Some(index) => rest.and_then(|rest| rest.parse().ok()) == Some(index),
    }
}

fn module<'t>(words: &mut impl Iterator<Item = &'t str>) -> Result<Module, BoardFault> {
    let tag = tag(words.next().ok_or(BoardFault::Word)?)?;
    let version = byte(number(words)?)?;
    let clock = match words.next() {
        Some("low") => Clock::Low,
        Some("high") => Clock::High,
        _ => return Err(BoardFault::Word),
    };
    let instances = byte(number(words)?)?;
    let base = u16::try_from(hexadecimal(words)?).map_err(|_| BoardFault::Number)?;
    let registers = byte(number(words)?)?;
    let strides = byte(hexadecimal(words)?)?;
    Ok(Module {
        tag: tag as u8,
        version,
        clock,
        instances,
        base,
        registers,
        register_stride: strides & 0x0F,
        instance_stride: strides >> 4,
        multiple: hexadecimal(words)?,
    })
}

/// Returns the kind of module with this name. Kinds whose short names are equal have longer ones here.
fn tag(name: &str) -> Result<Tag, BoardFault> {
    match name {
        "muxed-encoder" => Ok(Tag::MuxedEncoder),
        _ => Tag::all().find(|tag| tag.name() == name).ok_or(BoardFault::Module),
    }
}

fn padded<const N: usize>(word: Option<&str>) -> Result<[u8; N], BoardFault> {
    let word = word.ok_or(BoardFault::Word)?.as_bytes();
    let mut out = [0; N];
    out.get_mut(..word.len()).ok_or(BoardFault::Number)?.copy_from_slice(word);
    Ok(out)
}

fn number<'t>(words: &mut impl Iterator<Item = &'t str>) -> Result<u32, BoardFault> {
    words.next().ok_or(BoardFault::Word)?.parse().map_err(|_| BoardFault::Number)
}

fn hexadecimal<'t>(words: &mut impl Iterator<Item = &'t str>) -> Result<u32, BoardFault> {
    let word = words.next().ok_or(BoardFault::Word)?;
    u32::from_str_radix(word, 16).map_err(|_| BoardFault::Number)
}

fn byte(number: u32) -> Result<u8, BoardFault> {
    u8::try_from(number).map_err(|_| BoardFault::Number)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeSet;

    #[test]
    fn every_board_is_one_that_a_firmware_can_have() {
        let folder = std::fs::read_dir(concat!(env!("CARGO_MANIFEST_DIR"), "/boards")).unwrap();
        assert_eq!(folder.count(), boards().count(), "a file that no row names");
        for (name, text) in FILES {
            let board = Board::parse(text).unwrap_or_else(|fault| panic!("{name}: {fault}"));
            let id = board.identification;
            assert_eq!(Identification::parse(&id.to_words()), Ok(id), "{name}");
            let mut used = BTreeSet::new();
            for (at, pin) in board.pins.iter().enumerate() {
                let Some(tag) = pin.kind() else { continue };
                let module = board.modules.iter().find(|m| m.tag == tag as u8).unwrap();
                let own = tag != Tag::MuxedEncoderSelect;
                assert!(!own || pin.instance < module.instances, "{name}: pin {at}");
                let key = (pin.tag, pin.instance, pin.number, pin.is_output);
                assert!(used.insert(key), "{name}: pin {at} is another's");
            }
            for module in &board.modules {
                for register in 0..module.registers {
                    for instance in 0..module.instances {
                        let own = module.multiple >> register & 1 == 1;
                        let at = module.address(&id, register, instance);
                        assert!(at.is_some() || !own, "{name}: {module:?}");
                    }
                }
            }
        }
    }

    #[test]
    fn a_bad_line_is_named() {
        let good = "name A\nports 1 1\nmodule ioport 0 low 1 1000 5 00 1F\npin 0 X";
        assert!(Board::parse(good).is_ok());
        let rows = [
            ("nonsense", 1, BoardFault::Word),
            ("name", 1, BoardFault::Word),
            ("name 12345678901234567", 1, BoardFault::Number),
            ("name A B", 1, BoardFault::Word),
            ("chip 1 x", 1, BoardFault::Number),
            ("module nothing 0 low 1 0 0 0 0", 1, BoardFault::Module),
            ("module led 0 fast 1 0 0 0 0", 1, BoardFault::Word),
            ("module led 0 low 1 10000 0 0 0", 1, BoardFault::Number),
            ("pin 1 X", 1, BoardFault::Order),
            ("pin 0 X pwmgen 0 PWM", 1, BoardFault::Module),
            ("module pwmgen 0 low 1 0 0 0 0\npin 0 X pwmgen 0 Step", 2, BoardFault::Name),
            ("ports 2 17", 0, BoardFault::Count),
            ("ports 65536 65536", 1, BoardFault::Number),
        ];
        for (text, line, fault) in rows {
            assert_eq!(Board::parse(text), Err(BadBoard { line, fault }), "{text}");
        }
    }
}
