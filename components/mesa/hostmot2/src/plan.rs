//! Registers that are read in each cycle, and where their values stand in the answer.

use hal_component::Error;
use hal_lbp16::{Full, MAX_ITEMS, Packet, Size, Space};

/// First of the card's words that are free for any use, in [`Space::Timers`].
pub(crate) const SCRATCH: u16 = 0x10;

/// Place of the sequence number in the packet that asks.
pub(crate) const NUMBER_AT: usize = 4;

/// Most packets that one cycle writes.
pub(crate) const MAX_WRITES: usize = WRITES as usize;

const WRITES: u8 = 4;

/// Bytes of the sequence numbers at the end of the answer: that of the question, then those of the packets that wrote.
pub(crate) const NUMBERS: usize = 2 * (1 + MAX_WRITES);

/// Place of a register's value in the answer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Place(u16);

/// Registers to read, in the order in which they were added.
#[derive(Clone, Debug, Default)]
pub(crate) struct ReadPlan {
    /// Address and number of registers of each command.
    commands: Vec<(u16, u8)>,
    len: u16,
    /// True if the last register is one whose address changes.
    has_variable: bool,
}

impl ReadPlan {
    /// Returns a place behind all registers, whose value is 0.
    pub(crate) const fn none() -> Place {
        Place(u16::MAX)
    }

    /// Adds a register. Returns where its value stands in the answer.
    pub(crate) fn read(&mut self, address: u16) -> Place {
        let place = Place(self.len);
        self.len = self.len.saturating_add(4);
        match self.commands.last_mut() {
            Some((at, count))
                if *count < MAX_ITEMS
                    && u32::from(*at) + u32::from(*count) * 4 == u32::from(address) =>
            {
                *count += 1;
            }
            _ => self.commands.push((address, 1)),
        }
        place
    }

    /// Adds a register behind all others whose address changes from cycle to cycle.
    pub(crate) fn read_variable(&mut self) -> Place {
        self.commands.push((0, 1));
        self.has_variable = true;
        let place = Place(self.len);
        self.len = self.len.saturating_add(4);
        place
    }

    /// Returns the place of the changing address in the packet.
    pub(crate) fn variable_at(&self, packet: &Packet) -> Option<usize> {
        // Behind it stands the command that reads the sequence numbers.
        self.has_variable.then(|| packet.bytes().len().saturating_sub(6))
    }

    /// Returns the packet that asks: it leaves a sequence number with the card, reads all registers, and reads the numbers
    /// that the card holds.
    pub(crate) fn packet(&self) -> Result<Packet, Error> {
        let mut packet = Packet::new();
        let mut build = || -> Result<(), Full> {
            packet.write_words(Space::Timers, SCRATCH, &[0])?;
            for (address, count) in &self.commands {
                packet.read_registers(*address, *count)?;
            }
            packet.read(Space::Timers, Size::Word, SCRATCH, 1 + WRITES)?;
            Ok(())
        };
        build().map_err(|_| {
            Error::new(
                "the modules of this card have more registers to read than one packet carries: \
                 limit them in config=, such as num_encoders=2",
            )
        })?;
        Ok(packet)
    }
}

/// Answer of a card to the packet of a [`ReadPlan`].
#[derive(Clone, Copy, Debug)]
pub(crate) struct ReadAnswer<'a>(pub(crate) &'a [u8]);

impl ReadAnswer<'_> {
    /// Returns the value of a register; 0 for a place of another plan.
    pub(crate) fn get(&self, place: Place) -> u32 {
        let rest = self.0.get(usize::from(place.0)..).unwrap_or_default();
        rest.first_chunk().map_or(0, |bytes| u32::from_le_bytes(*bytes))
    }

    /// Returns the sequence numbers at the end of the answer: that of the question, and those of the packets that wrote.
    pub(crate) fn numbers(&self) -> Option<(u16, [u16; MAX_WRITES])> {
        let bytes: &[u8; NUMBERS] = self.0.last_chunk()?;
        let mut words = bytes.as_chunks::<2>().0.iter().map(|word| u16::from_le_bytes(*word));
        let question = words.next()?;
        let mut writes = [0; MAX_WRITES];
        for (write, word) in writes.iter_mut().zip(words) {
            *write = word;
        }
        Some((question, writes))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn neighbours_are_read_by_one_command() {
        let mut plan = ReadPlan::default();
        let places = [0x1000, 0x1004, 0x2100, 0x2104, 0x2108, 0x0C00].map(|at| plan.read(at));
        assert_eq!(plan.commands, [(0x1000, 2), (0x2100, 3), (0x0C00, 1)]);
        let packet = plan.packet().unwrap();
        assert_eq!(packet.answer_bytes(), 6 * 4 + NUMBERS);
        let mut answer = [0; 6 * 4 + NUMBERS];
        for (n, byte) in answer.iter_mut().enumerate() {
            *byte = u8::try_from(n).unwrap();
        }
        let answer = ReadAnswer(&answer);
        assert_eq!(places.map(|place| answer.get(place) & 0xFF), [0, 4, 8, 12, 16, 20]);
        assert_eq!(answer.numbers(), Some((0x1918, [0x1B1A, 0x1D1C, 0x1F1E, 0x2120])));
        assert_eq!(ReadAnswer(&[1, 2]).numbers(), None);
        assert_eq!(ReadAnswer(&[1, 2]).get(places[0]), 0);
    }

    #[test]
    fn more_than_a_packet_carries_is_refused() {
        let mut plan = ReadPlan::default();
        for n in 0..365 {
            plan.read(n * 4);
        }
        assert!(plan.packet().is_ok());
        plan.read(0x4000);
        let refused = plan.packet().unwrap_err();
        assert!(refused.text().unwrap().contains("num_encoders"));
    }
}
