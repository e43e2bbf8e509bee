//! Packets that a card receives.

use crate::CommandWord;

/// Command of a packet with its address and its data.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PacketRequest<'p> {
    /// First word of the command.
    pub command: CommandWord,
    /// Address, if the command has one.
    pub address: Option<u16>,
    /// Bytes that the command writes; empty if it reads.
    pub data: &'p [u8],
}

/// Commands of a packet, in order.
#[derive(Clone, Debug)]
pub struct Commands<'p> {
    rest: &'p [u8],
}

/// Error of a packet that ends within a command.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Malformed {
    /// Bytes from the start of the unfinished command to the end of the packet.
    pub bytes: usize,
}

impl core::fmt::Display for Malformed {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        write!(f, "the packet ends within a command, of which it has {} bytes", self.bytes)
    }
}

impl core::error::Error for Malformed {}

/// Returns the commands of a packet. After an error there is no further command.
#[must_use]
pub const fn commands(packet: &[u8]) -> Commands<'_> {
    Commands { rest: packet }
}

impl<'p> Iterator for Commands<'p> {
    type Item = Result<PacketRequest<'p>, Malformed>;

    fn next(&mut self) -> Option<Self::Item> {
        if self.rest.is_empty() {
            return None;
        }
        let whole = self.rest;
        let request = take(&mut self.rest);
        if request.is_none() {
            self.rest = &[];
        }
        Some(request.ok_or(Malformed { bytes: whole.len() }))
    }
}

fn take<'p>(rest: &mut &'p [u8]) -> Option<PacketRequest<'p>> {
    let command = CommandWord::from_bits(word(rest)?);
    let address = if command.has_address { Some(word(rest)?) } else { None };
    let bytes = if command.writes { command.data_bytes() } else { 0 };
    let (data, behind) = rest.split_at_checked(bytes)?;
    *rest = behind;
    Some(PacketRequest { command, address, data })
}

fn word(rest: &mut &[u8]) -> Option<u16> {
    let (word, behind) = rest.split_first_chunk()?;
    *rest = behind;
    Some(u16::from_le_bytes(*word))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{MAX_PACKET, Size, Space};

    #[test]
    fn a_packet_that_ends_within_a_command_is_refused_there() {
        // (packet, commands before the fault, bytes of the unfinished one)
        let rows: &[(&[u8], usize, usize)] = &[
            (&[0x81], 0, 1),
            (&[0x81, 0x42], 0, 2),
            (&[0x81, 0x42, 0], 0, 3),
            (&[0x81, 0x42, 0, 1, 0x81], 1, 1),
            (&[0x81, 0xC2, 0, 1, 1, 2, 3], 0, 7),
            (&[0x01, 0x02, 0x81, 0xC2, 0, 1, 1, 2, 3], 1, 7),
        ];
        for (packet, good, bytes) in rows {
            let mut all = commands(packet);
            for _ in 0..*good {
                assert!(all.next().is_some_and(|r| r.is_ok()), "{packet:?}");
            }
            assert_eq!(all.next(), Some(Err(Malformed { bytes: *bytes })), "{packet:?}");
            assert_eq!(all.next(), None, "{packet:?}");
        }
    }

    #[test]
    fn a_write_has_its_data() {
        let mut all = commands(&[0x82, 0xD9, 0x1A, 0, 0xAA, 0x55, 1, 0]);
        let request = all.next().unwrap().unwrap();
        assert_eq!(request.command, CommandWord::write(Space::Communication, Size::Word, 2));
        assert_eq!((request.address, request.data), (Some(0x1A), &[0xAA, 0x55, 1, 0][..]));
        assert_eq!(all.next(), None);
    }

    /// Random packets: each byte belongs to one command or to the fault.
    #[test]
    fn random_packets_are_read_to_their_ends() {
        let mut seed = 0x2545_F491_4F6C_DD1D_u64;
        let mut packet = [0_u8; MAX_PACKET];
        for _ in 0..1_000_000 {
            let mut random = || {
                seed ^= seed << 13;
                seed ^= seed >> 7;
                seed ^= seed << 17;
                seed
            };
            let len = usize::try_from(random() % 24).unwrap();
            for byte in &mut packet[..len] {
                *byte = random().to_le_bytes()[3];
            }
            let mut bytes = 0;
            for request in commands(&packet[..len]) {
                bytes += match request {
                    Ok(r) => 2 + 2 * usize::from(r.address.is_some()) + r.data.len(),
                    Err(fault) => fault.bytes,
                };
            }
            assert_eq!(bytes, len);
        }
    }
}
