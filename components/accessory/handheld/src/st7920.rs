//! Realtime. The serial protocol of the ST7920, a controller of text displays with four rows of 16 characters.
//!
//! A sync byte `11111 RW RS 0` heads any number of bytes, each sent as two: the high half first, both in bits 7 to 4.

/// Number of characters of the display.
pub const TEXT_LEN: usize = 64;
/// Number of characters in a row.
pub const COLUMNS: usize = 16;
/// Number of rows.
pub const ROWS: usize = 4;
/// Commands that set the address of the first character of each row.
pub const ROW_ADDRESS: [u8; ROWS] = [0x80, 0x90, 0x88, 0x98];

/// Decoder of the bytes that a display receives.
pub trait Decode {
    /// Takes a byte from the bus.
    fn feed(&mut self, byte: u8);

    /// Returns the text on the display, row by row.
    fn text(&self) -> &[u8; TEXT_LEN];

    /// Returns the number of frames: sync bytes with what they head.
    fn frames(&self) -> u32;

    /// Returns the number of bytes that the protocol does not allow.
    fn errors(&self) -> u32;
}

/// Meaning of the bytes after a sync byte.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
enum Heading {
    /// No sync byte yet, or an error since.
    Lost,
    Command,
    Data,
    /// The controller reads from the display: the bytes are clock pulses.
    Reading,
}

/// Decoder of an ST7920's bytes.
#[derive(Clone, Debug)]
pub struct St7920 {
    text: [u8; TEXT_LEN],
    heading: Heading,
    /// The first half of a byte.
    high: Option<u8>,
    /// Address of a word of two characters, 0 to 63.
    word: u8,
    /// True if the next character is the second of its word.
    is_second: bool,
    is_increasing: bool,
    is_extended: bool,
    /// True if data are not characters of the display: they go to the memory of glyphs.
    is_elsewhere: bool,
    frames: u32,
    errors: u32,
}

impl Default for St7920 {
    fn default() -> Self {
        Self {
            text: [b' '; TEXT_LEN],
            heading: Heading::Lost,
            high: None,
            word: 0,
            is_second: false,
            is_increasing: true,
            is_extended: false,
            is_elsewhere: false,
            frames: 0,
            errors: 0,
        }
    }
}

impl St7920 {
    fn fault(&mut self) {
        self.errors = self.errors.wrapping_add(1);
        (self.heading, self.high) = (Heading::Lost, None);
    }

    fn command(&mut self, command: u8) {
        if self.is_extended && command & 0xE0 != 0x20 {
            return;
        }
        match command {
            0x01 => {
                self.text = [b' '; TEXT_LEN];
                (self.is_increasing, self.is_elsewhere) = (true, false);
                (self.word, self.is_second) = (0, false);
            }
            0x02 | 0x03 => {
                (self.word, self.is_second, self.is_elsewhere) = (0, false, false);
            }
            0x04..=0x07 => self.is_increasing = command & 2 != 0,
            0x20..=0x3F => self.is_extended = command & 4 != 0,
            0x40..=0x7F => self.is_elsewhere = true,
            0x80..=0xFF => {
                (self.word, self.is_second, self.is_elsewhere) = (command & 0x3F, false, false);
            }
            // No operation; display on and off, shifts.
            0x00 | 0x08..=0x1F => {}
        }
    }

    fn data(&mut self, byte: u8) {
        if self.is_extended || self.is_elsewhere {
            return;
        }
        // Two rows of the memory follow each other before the next two: rows 1, 3, 2 and 4 of the display.
        let row = match self.word / 8 {
            0 => Some(0),
            1 => Some(2),
            2 => Some(1),
            3 => Some(3),
            _ => None,
        };
        let column = usize::from(self.word % 8) * 2 + usize::from(self.is_second);
        if let Some(shown) = row.and_then(|row| self.text.get_mut(row * COLUMNS + column)) {
            *shown = if matches!(byte, b' '..=b'~') { byte } else { b'?' };
        }
        if self.is_second {
            let step = if self.is_increasing { 1 } else { 63 };
            self.word = (self.word + step) % 64;
        }
        self.is_second = !self.is_second;
    }
}

impl Decode for St7920 {
    fn feed(&mut self, byte: u8) {
        if byte & 0xF9 == 0xF8 {
            if self.high.is_some() {
                self.fault();
            }
            self.frames = self.frames.wrapping_add(1);
            self.heading = match byte & 0x06 {
                0x00 => Heading::Command,
                0x02 => Heading::Data,
                _ => Heading::Reading,
            };
            return;
        }
        if self.heading == Heading::Reading {
            return;
        }
        if byte & 0x0F != 0 || self.heading == Heading::Lost {
            self.fault();
            return;
        }
        let Some(high) = self.high.take() else {
            self.high = Some(byte);
            return;
        };
        let whole = high | byte >> 4;
        if self.heading == Heading::Command {
            self.command(whole);
        } else {
            self.data(whole);
        }
    }

    fn text(&self) -> &[u8; TEXT_LEN] {
        &self.text
    }

    fn frames(&self) -> u32 {
        self.frames
    }

    fn errors(&self) -> u32 {
        self.errors
    }
}

/// Largest number of bytes that draw a row: a command, and 16 characters.
pub const ROW_BYTES: usize = 4 + 2 * COLUMNS;

/// Returns the bytes of a command.
#[must_use]
pub const fn command_bytes(command: u8) -> [u8; 3] {
    [0xF8, command & 0xF0, command << 4]
}

/// Returns the bytes that draw a row, 0 to 3.
#[must_use]
pub fn row_bytes(row: usize, text: &[u8; COLUMNS]) -> [u8; ROW_BYTES] {
    let mut bytes = [0; ROW_BYTES];
    let address = ROW_ADDRESS.get(row).copied().unwrap_or_default();
    let halves = text.iter().flat_map(|c| [c & 0xF0, c << 4]);
    let all = command_bytes(address).into_iter().chain([0xFA]).chain(halves);
    for (free, byte) in bytes.iter_mut().zip(all) {
        *free = byte;
    }
    bytes
}
