//! Packets in words: a line for each read and for each item that is written.

use crate::{Board, card::Card, decode::Decoder};
use hal_firmware::registers;
use hal_lbp16::{PacketRequest, Size, Space, commands};

/// Packet that displays as a line for each command that reads, and a line for each item that is written.
///
/// Registers have the names of [`hal_firmware::registers`], with the instance behind them.
#[derive(Debug)]
pub struct Recorded<'p> {
    decoder: &'p Decoder,
    packet: &'p [u8],
}

impl Card {
    /// Returns a packet that can be written down.
    #[must_use]
    pub const fn recorded<'p>(&'p self, packet: &'p [u8]) -> Recorded<'p> {
        Recorded { decoder: &self.decoder, packet }
    }

    /// Returns the name of a register, such as `STEP_RATE[2]`; none for an address that no module has.
    #[must_use]
    pub fn register_name(board: &Board, at: u16) -> Option<Box<str>> {
        let decoder = Decoder::new(board);
        decoder.slot(at)?;
        Some(Name { decoder: &decoder, at }.to_string().into())
    }
}

/// Name of an address in the space of registers.
struct Name<'d> {
    decoder: &'d Decoder,
    at: u16,
}

impl core::fmt::Display for Name<'_> {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        let Some(slot) = self.decoder.slot(self.at) else { return f.write_str("-") };
        let mut all = registers::of(slot.tag);
        let name = all.find(|r| r.index == slot.register).map_or("-", |r| r.name);
        write!(f, "{name}[{}]", slot.instance)?;
        let is_channel =
            name.starts_with("SERIAL_") && registers::SERIAL_STATUS.index <= slot.register;
        if is_channel { write!(f, ".{}", slot.channel) } else { Ok(()) }
    }
}

impl core::fmt::Display for Recorded<'_> {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        for request in commands(self.packet) {
            match request {
                Ok(request) => self.request(f, &request)?,
                Err(fault) => writeln!(f, "  malformed: {fault}")?,
            }
        }
        Ok(())
    }
}

impl Recorded<'_> {
    fn request(
        &self,
        f: &mut core::fmt::Formatter<'_>,
        request: &PacketRequest<'_>,
    ) -> core::fmt::Result {
        let command = request.command;
        let space = command.space as u8;
        let info = if command.is_info { " information" } else { "" };
        let mut at = request.address;
        let place = |f: &mut core::fmt::Formatter<'_>, at: Option<u16>| match at {
            Some(at) if command.space == Space::Registers && !command.is_info => {
                write!(f, "{at:04X} {}", Name { decoder: self.decoder, at })
            }
            Some(at) => write!(f, "{space}:{at:04X}{info}"),
            None => write!(f, "{space}:on{info}"),
        };
        if !command.writes {
            f.write_str("  read  ")?;
            place(f, at)?;
            let still = if command.increments { "" } else { " still" };
            return writeln!(f, " x{}{}{still}", command.count, size(command.size));
        }
        for item in request.data.chunks_exact(command.size.bytes()) {
            f.write_str("  write ")?;
            place(f, at)?;
            f.write_str(" = ")?;
            for byte in item.iter().rev() {
                write!(f, "{byte:02X}")?;
            }
            writeln!(f)?;
            if command.increments {
                let step = u16::try_from(command.size.bytes()).unwrap_or(0);
                at = at.map(|at| at.wrapping_add(step));
            }
        }
        Ok(())
    }
}

/// Returns a mark for items of other than 32 bits.
const fn size(size: Size) -> &'static str {
    match size {
        Size::Byte => " bytes",
        Size::Word => " words",
        Size::Double => "",
        Size::Quad => " quads",
    }
}
