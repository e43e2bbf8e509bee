//! Packets that a controller sends.

use crate::{CommandWord, MAX_PACKET, Size, Space};

/// Packet under construction, and the number of bytes of its answer.
///
/// The packet has room for what one frame carries, and so has the answer: a command that would exceed either is refused
/// and leaves the packet as it was.
#[derive(Clone, Copy, Debug)]
pub struct Packet {
    bytes: [u8; MAX_PACKET],
    len: usize,
    answer: usize,
}

/// Error of a command that has no room in its packet, or whose answer would have none.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Full;

impl core::fmt::Display for Full {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.write_str("the packet has no room for the command or its answer")
    }
}

impl core::error::Error for Full {}

impl Default for Packet {
    fn default() -> Self {
        Self::new()
    }
}

impl Packet {
    /// Returns an empty packet.
    #[must_use]
    pub const fn new() -> Self {
        Self { bytes: [0; MAX_PACKET], len: 0, answer: 0 }
    }

    /// Makes the packet empty.
    pub const fn clear(&mut self) {
        self.len = 0;
        self.answer = 0;
    }

    /// Returns the bytes to send.
    #[must_use]
    pub fn bytes(&self) -> &[u8] {
        self.bytes.get(..self.len).unwrap_or_default()
    }

    /// Returns whether there is no command.
    #[must_use]
    pub const fn is_empty(&self) -> bool {
        self.len == 0
    }

    /// Replaces the word of 16 bits at byte `at` of the packet, such as data that a command writes. Nothing happens beyond
    /// the end of the packet.
    pub fn patch(&mut self, at: usize, word: u16) {
        let end = self.len.min(at.saturating_add(2));
        if let Some(bytes) = self.bytes.get_mut(at..end).and_then(|bytes| bytes.first_chunk_mut()) {
            *bytes = word.to_le_bytes();
        }
    }

    /// Returns the number of bytes that the answer has: 0 if nothing is read, and then there is no answer.
    #[must_use]
    pub const fn answer_bytes(&self) -> usize {
        self.answer
    }

    /// Adds a command that reads `count` items from `address` on. Returns where its data begins in the answer.
    ///
    /// # Errors
    /// The packet is full.
    pub fn read(
        &mut self,
        space: Space,
        size: Size,
        address: u16,
        count: u8,
    ) -> Result<usize, Full> {
        let command = CommandWord::read(space, size, count);
        let (at, answer) = (self.answer, self.answer + command.data_bytes());
        if answer > MAX_PACKET {
            return Err(Full);
        }
        self.put::<0>(command, address, [])?;
        self.answer = answer;
        Ok(at)
    }

    /// Adds a command that reads `count` registers from `address` on. Returns where its data begins in the answer.
    ///
    /// # Errors
    /// The packet is full.
    pub fn read_registers(&mut self, address: u16, count: u8) -> Result<usize, Full> {
        self.read(Space::Registers, Size::Double, address, count)
    }

    /// Adds a command that writes registers from `address` on.
    ///
    /// # Errors
    /// The packet is full, or there are more values than one command can have.
    pub fn write_registers(&mut self, address: u16, values: &[u32]) -> Result<(), Full> {
        let count =
            u8::try_from(values.len()).ok().filter(|n| *n <= crate::MAX_ITEMS).ok_or(Full)?;
        let command = CommandWord::write(Space::Registers, Size::Double, count);
        self.put(command, address, values.iter().map(|value| value.to_le_bytes()))
    }

    /// Adds a command that writes words of 16 bits from `address` on.
    ///
    /// # Errors
    /// The packet is full, or there are more values than one command can have.
    pub fn write_words(&mut self, space: Space, address: u16, values: &[u16]) -> Result<(), Full> {
        let count =
            u8::try_from(values.len()).ok().filter(|n| *n <= crate::MAX_ITEMS).ok_or(Full)?;
        let command = CommandWord::write(space, Size::Word, count);
        self.put(command, address, values.iter().map(|value| value.to_le_bytes()))
    }

    fn put<const N: usize>(
        &mut self,
        command: CommandWord,
        address: u16,
        data: impl IntoIterator<Item = [u8; N]>,
    ) -> Result<(), Full> {
        let mut len = self.len;
        let mut add = |bytes: &[u8]| {
            let end = len + bytes.len();
            self.bytes.get_mut(len..end).ok_or(Full)?.copy_from_slice(bytes);
            len = end;
            Ok(())
        };
        add(&command.to_bits().to_le_bytes())?;
        add(&address.to_le_bytes())?;
        for item in data {
            add(&item)?;
        }
        self.len = len;
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::commands;

    #[test]
    fn a_packet_says_what_its_answer_has() {
        let mut packet = Packet::new();
        assert!(packet.is_empty());
        assert_eq!(packet.read_registers(0x100, 1), Ok(0));
        assert_eq!(packet.read(Space::Board, Size::Word, 0, 8), Ok(4));
        assert_eq!(packet.write_registers(0x0C00, &[0x0102_0304, 5]), Ok(()));
        assert_eq!(packet.answer_bytes(), 20);
        assert_eq!(
            packet.bytes(),
            [
                0x81, 0x42, 0x00, 0x01, 0x88, 0x5D, 0x00, 0x00, 0x82, 0xC2, 0x00, 0x0C, 4, 3, 2, 1,
                5, 0, 0, 0
            ]
        );
        let mut addresses = [None; 4];
        for (request, address) in commands(packet.bytes()).zip(&mut addresses) {
            *address = request.unwrap().address;
        }
        assert_eq!(addresses, [Some(0x100), Some(0), Some(0x0C00), None]);
        packet.patch(14, 0x1122);
        packet.patch(packet.bytes().len() - 1, 0x1122);
        assert_eq!(packet.bytes()[11..], [0x0C, 4, 3, 0x22, 0x11, 5, 0, 0, 0]);
        packet.clear();
        assert!(packet.is_empty() && packet.answer_bytes() == 0);
    }

    #[test]
    fn what_has_no_room_changes_nothing() {
        let mut packet = Packet::new();
        for _ in 0..2 {
            packet.read_registers(0, 127).unwrap();
        }
        packet.read_registers(0, 114).unwrap();
        assert_eq!(packet.answer_bytes(), MAX_PACKET);
        let before = packet;
        assert_eq!(packet.read_registers(0, 1), Err(Full));
        assert_eq!(packet.write_registers(0, &[0; 128]), Err(Full));
        assert_eq!((packet.bytes(), packet.answer_bytes()), (before.bytes(), MAX_PACKET));
        let mut packet = Packet::new();
        for _ in 0..2 {
            packet.write_registers(0, &[7; 127]).unwrap();
        }
        let len = packet.bytes().len();
        assert_eq!(packet.write_registers(0, &[7; 127]), Err(Full));
        assert_eq!(packet.bytes().len(), len);
        packet.write_registers(0, &[7; 111]).unwrap();
        assert_eq!(packet.bytes().len(), MAX_PACKET);
    }
}
