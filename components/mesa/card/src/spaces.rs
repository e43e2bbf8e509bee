//! Address spaces of the card itself: Ethernet chip, settings, timers, communication, board.
//!
//! Source: section "LBP16" of Mesa's manuals (7I76E, pages 60 to 75).

use hal_lbp16::Space;

/// Addresses in the space of settings.
const MAC_AT: u16 = 0x02;
const NAME_AT: u16 = 0x10;
const IP_AT: u16 = 0x20;
/// First address of the settings that can be written.
const WRITABLE_AT: u16 = 0x20;
const SETTINGS: usize = 0x80;

/// Addresses in the space of communication.
pub(crate) const ERRORS: u16 = 0x00;
pub(crate) const PARSE_ERRORS: u16 = 0x02;
pub(crate) const MEMORY_ERRORS: u16 = 0x04;
pub(crate) const WRITE_ERRORS: u16 = 0x06;
pub(crate) const RECEIVED: u16 = 0x08;
pub(crate) const RECEIVED_UDP: u16 = 0x0A;
pub(crate) const SENT: u16 = 0x0E;
pub(crate) const SENT_UDP: u16 = 0x10;
const LED_MODE: u16 = 0x14;
const DEBUG_LED: u16 = 0x16;
const SCRATCH: u16 = 0x18;
pub(crate) const WRITE_ENABLE: u16 = 0x1A;
/// Value of the write enable, without the number of the space.
const WRITE_KEY: u16 = 0x5A00;

/// Versions in the space of the board.
const LBP_VERSION: u16 = 3;
const FIRMWARE_VERSION: u16 = 17;

/// Spaces other than that of the registers.
#[derive(Debug)]
pub(crate) struct Spaces {
    name: [u8; 16],
    settings: [u16; SETTINGS / 2],
    communication: [u16; 16],
    scratch: [u16; 8],
    time_ns: u64,
}

impl Spaces {
    pub(crate) fn new(name: [u8; 16], mac: [u8; 6], ip: [u8; 4]) -> Self {
        let mut spaces = Self {
            name,
            settings: [0; SETTINGS / 2],
            communication: [0; 16],
            scratch: [0; 8],
            time_ns: 0,
        };
        let [a, b, c, d, e, f] = mac;
        let words = [[f, e], [d, c], [b, a]].map(u16::from_le_bytes);
        spaces.put_settings(MAC_AT, &words);
        let [w, x, y, z] = ip;
        spaces.put_settings(IP_AT, &[[z, y], [x, w]].map(u16::from_le_bytes));
        for at in 0..8 {
            let word = spaces.name_word(at);
            spaces.put_settings(NAME_AT + 2 * at, &[word]);
        }
        spaces
    }

    fn put_settings(&mut self, at: u16, words: &[u16]) {
        for (place, word) in self.settings.iter_mut().skip(usize::from(at / 2)).zip(words) {
            *place = *word;
        }
    }

    fn name_word(&self, at: u16) -> u16 {
        let mut pairs = self.name.chunks_exact(2).skip(usize::from(at));
        let pair = pairs.next().and_then(|pair| pair.try_into().ok());
        pair.map_or(0, u16::from_le_bytes)
    }

    pub(crate) const fn advance(&mut self, ns: u64) {
        self.time_ns = self.time_ns.wrapping_add(ns);
    }

    fn microseconds(&self) -> u16 {
        let [low, high, ..] = (self.time_ns / 1000).to_le_bytes();
        u16::from_le_bytes([low, high])
    }

    /// Adds to a counter of the space of communication.
    pub(crate) fn count(&mut self, at: u16) {
        if let Some(counter) = self.communication.get_mut(usize::from(at / 2)) {
            *counter = counter.wrapping_add(1);
        }
    }

    /// Notes an error: its counter, and its bit in the register of errors.
    pub(crate) fn note(&mut self, counter: u16) {
        self.count(counter);
        if let Some(errors) = self.communication.get_mut(usize::from(ERRORS / 2)) {
            *errors |= 1 << (counter / 2).saturating_sub(1);
        }
    }

    /// Ends a packet: settings are protected again.
    pub(crate) fn end_packet(&mut self) {
        if let Some(enable) = self.communication.get_mut(usize::from(WRITE_ENABLE / 2)) {
            *enable = 0;
        }
    }

    /// Returns a word.
    pub(crate) fn word(&self, space: Space, at: u16) -> u16 {
        let nth = usize::from(at / 2);
        match space {
            Space::Settings => self.settings.get(nth).copied().unwrap_or(0),
            Space::Timers => match at {
                0 | 1 => self.microseconds(),
                0x10..0x20 => self.scratch.get(nth - 8).copied().unwrap_or(0),
                _ => 0,
            },
            Space::Communication => self.communication.get(nth).copied().unwrap_or(0),
            Space::Board => match at {
                0..0x10 => self.name_word(at / 2),
                0x10 | 0x11 => LBP_VERSION,
                0x12 | 0x13 => FIRMWARE_VERSION,
                _ => 0,
            },
            Space::Registers | Space::Ethernet | Space::Flash | Space::Unused => 0,
        }
    }

    /// Writes a word. Returns whether the space has it and lets it be written.
    pub(crate) fn set_word(&mut self, space: Space, at: u16, value: u16) -> bool {
        let nth = usize::from(at / 2);
        let place = match (space, at) {
            (Space::Settings, WRITABLE_AT..) if self.can_write(Space::Settings) => {
                self.settings.get_mut(nth)
            }
            (Space::Timers, 0x10..0x20) => self.scratch.get_mut(nth - 8),
            // Writing the time stamp or a wait is allowed and does nothing here.
            (Space::Timers, 0..0x10) | (Space::Ethernet, _) => return true,
            (
                Space::Communication,
                ERRORS..=SENT_UDP | LED_MODE | DEBUG_LED | SCRATCH | WRITE_ENABLE,
            ) => self.communication.get_mut(nth),
            _ => None,
        };
        place.map(|place| *place = value).is_some()
    }

    fn can_write(&self, space: Space) -> bool {
        let enable = self.communication.get(usize::from(WRITE_ENABLE / 2));
        enable == Some(&(WRITE_KEY | space as u16))
    }

    /// Returns a word of a space's information area.
    pub(crate) fn information(space: Space, at: u16, pointer: u16) -> u16 {
        // Sizes: writable, kind, accesses. Ranges: address bits. Names as the card has them.
        let (sizes, range, name): (u16, u16, &[u8; 8]) = match space {
            Space::Registers => (0x8104, 16, b"HostMot2"),
            Space::Ethernet => (0x8102, 8, b"KSZ8851R"),
            Space::Settings => (0x8E02, 7, b"EtherEEP"),
            Space::Flash => (0x8F04, 24, b"FPGAFlsh"),
            Space::Timers => (0x8102, 5, b"Timers  "),
            Space::Unused => return 0,
            Space::Communication => (0x8102, 5, b"LBPCtrlS"),
            Space::Board => (0x0102, 5, b"LBPROnly"),
        };
        match at & !1 {
            0x00 => WRITE_KEY | space as u16,
            0x02 => sizes,
            0x04 => range,
            0x06 => pointer,
            at @ 0x08..0x10 => {
                let mut pairs = name.chunks_exact(2).skip(usize::from(at / 2 - 4));
                pairs.next().and_then(|pair| pair.try_into().ok()).map_or(0, u16::from_le_bytes)
            }
            _ => 0,
        }
    }
}
