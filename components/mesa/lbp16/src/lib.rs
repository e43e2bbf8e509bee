//! Packets of LBP16, the protocol of Mesa's Ethernet cards, over UDP port 27181.
//!
//! A packet is a row of commands. A command is a little-endian word of 16 bits, an address of 16 bits if it has one, and
//! the data if it writes:
//!
//! | bits | meaning |
//! |---|---|
//! | 15 | the command writes |
//! | 14 | an address follows; otherwise the space goes on where its last command ended |
//! | 13 | the command is for the space's information area |
//! | 12–10 | the space |
//! | 9–8 | bytes of an item: 1, 2, 4 or 8 |
//! | 7 | the address moves on with each item |
//! | 6–0 | number of items, 0 to 127 |
//!
//! The card answers a packet that reads with one packet: the data of all its reads, in order, and nothing else. The reader
//! of an answer must therefore know what was asked. [`Packet`] builds packets and counts the bytes of their answer,
//! [`commands`] reads them.
//!
//! Without `std` and `alloc`: realtime code may use all of it. Source: Mesa's manuals of its Ethernet cards, section
//! "LBP16".
#![no_std]
#![forbid(unsafe_code)]

mod packet;
mod read;

pub use packet::{Full, Packet};
pub use read::{Commands, Malformed, PacketRequest, commands};

/// UDP port of the cards.
pub const PORT: u16 = 27181;

/// Most bytes of a packet: what Ethernet carries in one frame of UDP over IPv4.
pub const MAX_PACKET: usize = 1472;

/// Most items of one command.
pub const MAX_ITEMS: u8 = 127;

/// Address spaces of a card.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
pub enum Space {
    /// Registers of the firmware, 32 bits each.
    Registers = 0,
    /// The chip that drives the Ethernet line, 16 bits.
    Ethernet = 1,
    /// The memory of settings: the hardware address at 2, the IP address at 0x20; 16 bits.
    Settings = 2,
    /// The memory that holds the firmware.
    Flash = 3,
    /// Timers and utilities of the card, 16 bits.
    Timers = 4,
    /// A space that no card uses.
    Unused = 5,
    /// Errors, counters of packets, and what writes need to be allowed; 16 bits.
    Communication = 6,
    /// Names of the card and of its configuration, 8 or 16 bits.
    Board = 7,
}

impl Space {
    /// Returns the space with this number; only the low three bits count.
    #[must_use]
    pub const fn from_bits(bits: u16) -> Self {
        match bits & 7 {
            0 => Self::Registers,
            1 => Self::Ethernet,
            2 => Self::Settings,
            3 => Self::Flash,
            4 => Self::Timers,
            5 => Self::Unused,
            6 => Self::Communication,
            _ => Self::Board,
        }
    }
}

/// Size of an item.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
pub enum Size {
    /// A byte.
    Byte = 0,
    /// Two bytes.
    Word = 1,
    /// Four bytes.
    Double = 2,
    /// Eight bytes.
    Quad = 3,
}

impl Size {
    /// Returns the number of bytes.
    #[must_use]
    pub const fn bytes(self) -> usize {
        1 << self as u8
    }

    const fn from_bits(bits: u16) -> Self {
        match bits & 3 {
            0 => Self::Byte,
            1 => Self::Word,
            2 => Self::Double,
            _ => Self::Quad,
        }
    }
}

/// First word of a command.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[expect(clippy::struct_excessive_bools, reason = "each is a bit of the word")]
pub struct CommandWord {
    /// Space of the command.
    pub space: Space,
    /// True for the space's information area in place of its contents.
    pub is_info: bool,
    /// True if the command writes.
    pub writes: bool,
    /// True if an address follows.
    pub has_address: bool,
    /// True if the address moves on with each item.
    pub increments: bool,
    /// Size of an item.
    pub size: Size,
    /// Number of items, 0 to [`MAX_ITEMS`].
    pub count: u8,
}

impl CommandWord {
    /// Returns a command that reads `count` items from a stated address, which moves on.
    #[must_use]
    pub const fn read(space: Space, size: Size, count: u8) -> Self {
        Self {
            space,
            is_info: false,
            writes: false,
            has_address: true,
            increments: true,
            size,
            count: count & MAX_ITEMS,
        }
    }

    /// Returns a command that writes `count` items from a stated address, which moves on.
    #[must_use]
    pub const fn write(space: Space, size: Size, count: u8) -> Self {
        Self { writes: true, ..Self::read(space, size, count) }
    }

    /// Returns the word on the wire.
    #[must_use]
    pub const fn to_bits(self) -> u16 {
        (self.writes as u16) << 15
            | (self.has_address as u16) << 14
            | (self.is_info as u16) << 13
            | (self.space as u16) << 10
            | (self.size as u16) << 8
            | (self.increments as u16) << 7
            | (self.count & MAX_ITEMS) as u16
    }

    /// Returns the command of a word. Every word is a command.
    #[must_use]
    pub const fn from_bits(bits: u16) -> Self {
        let [low, _] = bits.to_le_bytes();
        Self {
            space: Space::from_bits(bits >> 10),
            is_info: bits & 0x2000 != 0,
            writes: bits & 0x8000 != 0,
            has_address: bits & 0x4000 != 0,
            increments: bits & 0x80 != 0,
            size: Size::from_bits(bits >> 8),
            count: low & MAX_ITEMS,
        }
    }

    /// Returns the bytes of all items.
    #[must_use]
    pub const fn data_bytes(self) -> usize {
        self.count as usize * self.size.bytes()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_word_is_one_command() {
        for bits in 0..=u16::MAX {
            assert_eq!(CommandWord::from_bits(bits).to_bits(), bits);
        }
    }

    /// Words from Mesa's manuals.
    #[test]
    fn commands_have_the_manuals_words() {
        let one = CommandWord::read(Space::Registers, Size::Double, 1);
        assert_eq!(one.to_bits(), 0x4281);
        assert_eq!(CommandWord { increments: false, ..one }.to_bits(), 0x4201);
        assert_eq!(CommandWord::write(Space::Registers, Size::Double, 4).to_bits(), 0xC284);
        assert_eq!(CommandWord::read(Space::Settings, Size::Word, 3).to_bits(), 0x4983);
        assert_eq!(CommandWord::write(Space::Communication, Size::Word, 1).to_bits(), 0xD981);
        assert_eq!(CommandWord::read(Space::Board, Size::Word, 8).to_bits(), 0x5D88);
    }
}
