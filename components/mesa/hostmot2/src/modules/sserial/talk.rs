//! Questions to a smart-serial port and its remotes, before anything runs.

use super::describe::{BadRemote, Memory};
use crate::ask::{self, Unusable};
use hal_firmware::{Identification, Module, Register, registers as r};
use hal_lbp16::{MAX_PACKET, Packet};
use port::Exchange;

/// Most channels of a port.
pub(crate) const CHANNELS: usize = 8;

/// Commands to the port's processor; the low byte selects channels.
pub(crate) const STOP_ALL: u32 = 0x0800;
pub(crate) const START: u32 = 0x0900;
pub(crate) const START_SETUP: u32 = 0x0F00;
pub(crate) const EXCHANGE: u32 = 0x1000;

/// Commands to a remote, in the last byte of the channel's register, before an address.
const READ: u32 = 0x44 << 24;
pub(crate) const WRITE: u32 = 0x64 << 24;
/// Selects parameters that outlast power (1), or the memory (0).
pub(crate) const SELECT: u32 = 0xEC << 24;

/// Status of a channel: the remote has no such mode.
const BAD_MODE: u32 = 1 << 30;

/// Most questions whether a command is done: each takes a packet's way there and back. A start waits for remotes that have
/// just got power.
const START_ATTEMPTS: u32 = 20_000;
const ATTEMPTS: u32 = 2000;

/// Addresses of a port's registers.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Addresses {
    pub(crate) command: u16,
    pub(crate) data: u16,
    /// Status of each channel.
    pub(crate) status: [u16; CHANNELS],
    /// Process data of each channel, three registers.
    pub(crate) user: [[u16; CHANNELS]; 3],
}

impl Addresses {
    /// Returns the addresses of a port; `None` if the firmware's descriptor leaves no room for them.
    pub(crate) fn new(module: &Module, of: &Identification, port: u8) -> Option<Self> {
        // Each port has all registers, and the channels stand side by side.
        let own = Module { multiple: u32::MAX, ..*module };
        let at = |register: Register| own.address(of, register.index, port);
        let channels = |register| -> Option<[u16; CHANNELS]> {
            let first = at(register)?;
            let last = u16::try_from(CHANNELS).ok()?.checked_mul(4)?;
            first.checked_add(last)?;
            let mut all = [0; CHANNELS];
            for (n, channel) in (0_u16..).zip(&mut all) {
                *channel = first + n * 4;
            }
            Some(all)
        };
        Some(Self {
            command: at(r::SERIAL_COMMAND)?,
            data: at(r::SERIAL_DATA)?,
            status: channels(r::SERIAL_STATUS)?,
            user: [
                channels(r::SERIAL_USER_0)?,
                channels(r::SERIAL_USER_1)?,
                channels(r::SERIAL_USER_2)?,
            ],
        })
    }
}

/// Reason why a port cannot be used.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum BadPort {
    /// The card does not answer.
    Card(Unusable),
    /// The port's processor does not finish a command.
    Busy(u32),
}

impl core::fmt::Display for BadPort {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        match self {
            Self::Card(why) => why.fmt(f),
            Self::Busy(command) => write!(
                f,
                "the port's processor does not finish command {command:#06x}: switch the card off and \
                 on again"
            ),
        }
    }
}

impl core::error::Error for BadPort {}

impl From<Unusable> for BadPort {
    fn from(why: Unusable) -> Self {
        Self::Card(why)
    }
}

/// Remote as it answers the start of the setup.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Answered {
    pub(crate) channel: u8,
    pub(crate) unit: u32,
    pub(crate) name: [u8; 4],
    /// Addresses of the lists of process data and of parameters.
    pub(crate) data: u16,
    pub(crate) parameters: u16,
    /// True if the remote has the mode that was asked for.
    pub(crate) has_mode: bool,
}

/// Port under question.
pub(crate) struct Talk<'d> {
    pub(crate) device: &'d dyn Exchange,
    pub(crate) at: Addresses,
}

impl Talk<'_> {
    /// Writes registers, then runs a command, and waits until it is done. Returns the channels with a fault, one bit each.
    fn run(&self, before: &[(u16, u32)], command: u32, attempts: u32) -> Result<u32, BadPort> {
        let mut packet = Packet::new();
        let mut build = || {
            for (at, value) in before {
                packet.write_registers(*at, &[*value])?;
            }
            packet.write_registers(self.at.command, &[command])?;
            packet.read_registers(self.at.command, 2)
        };
        // A packet has room for a few registers.
        let _ = build();
        let mut answer = [0; MAX_PACKET];
        ask::ask(self.device, &packet, &mut answer)?;
        for _ in 0..attempts {
            let [busy] = ask::registers(self.device, self.at.command)?;
            if busy == 0 {
                let [faults] = ask::registers(self.device, self.at.data)?;
                return Ok(faults);
            }
        }
        Err(BadPort::Busy(command))
    }

    /// Stops all channels.
    pub(crate) fn stop(&self) -> Result<(), BadPort> {
        self.run(&[], STOP_ALL, ATTEMPTS).map(|_| ())
    }

    /// Starts the setup of a channel in a mode. Returns the remote, if one answers.
    pub(crate) fn start(&self, channel: u8, mode: u8) -> Result<Option<Answered>, BadPort> {
        let n = usize::from(channel);
        let status = self.at.status.get(n).copied().unwrap_or(0);
        let before = [(status, u32::from(mode) << 24)];
        let faults = self.run(&before, START_SETUP | 1 << channel, START_ATTEMPTS)?;
        let [state] = ask::registers(self.device, status)?;
        let mut words = [0; 3];
        for (word, user) in words.iter_mut().zip(&self.at.user) {
            [*word] = ask::registers(self.device, user.get(n).copied().unwrap_or(0))?;
        }
        let has_mode = state & BAD_MODE == 0;
        let [unit, name, lists] = words;
        if name == 0 || has_mode && faults >> channel & 1 == 1 {
            return Ok(None);
        }
        let [a, b, c, d] = lists.to_le_bytes();
        Ok(Some(Answered {
            channel,
            unit,
            name: name.to_le_bytes(),
            data: u16::from_le_bytes([a, b]),
            parameters: u16::from_le_bytes([c, d]),
            has_mode,
        }))
    }

    /// Lets a remote in its setup run a command with an argument. Returns its answer.
    fn order(&self, channel: u8, order: u32, argument: u32) -> Result<Option<u32>, BadPort> {
        let n = usize::from(channel);
        let [first, ..] = self.at.user;
        let (status, user) = (self.at.status.get(n), first.get(n));
        let (Some(status), Some(user)) = (status.copied(), user.copied()) else { return Ok(None) };
        let before = [(status, order), (user, argument)];
        let faults = self.run(&before, EXCHANGE | 1 << channel, ATTEMPTS)?;
        if faults >> channel & 1 == 1 {
            return Ok(None);
        }
        let [answer] = ask::registers(self.device, user)?;
        Ok(Some(answer))
    }

    /// Reads a value of a parameter. `None` if the remote does not answer.
    pub(crate) fn value(
        &self,
        channel: u8,
        at: u16,
        bytes: u8,
        lasts: bool,
    ) -> Result<Option<u32>, BadPort> {
        if lasts {
            self.order(channel, SELECT, 1)?;
        }
        let value = self.order(channel, READ | size(bytes) | u32::from(at), 0)?;
        if lasts {
            self.order(channel, SELECT, 0)?;
        }
        Ok(value)
    }
}

/// Returns the bits of a command for a number of bytes.
pub(crate) const fn size(bytes: u8) -> u32 {
    match bytes {
        ..=1 => 0,
        2 => 1 << 24,
        _ => 2 << 24,
    }
}

/// Memory of the remote at a channel. Errors of the port are kept: the remote looks silent.
pub(crate) struct RemoteMemory<'t, 'd> {
    pub(crate) talk: &'t Talk<'d>,
    pub(crate) channel: u8,
    pub(crate) fault: Option<BadPort>,
}

impl Memory for RemoteMemory<'_, '_> {
    fn read(&mut self, at: u16, bytes: u8) -> Result<u32, BadRemote> {
        match self.talk.order(self.channel, READ | size(bytes) | u32::from(at), 0) {
            Ok(Some(value)) => Ok(value),
            Ok(None) => Err(BadRemote::Silent(at)),
            Err(fault) => {
                self.fault = Some(fault);
                Err(BadRemote::Silent(at))
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::modules::sserial::describe::Description;
    use core::time::Duration;
    use hal_bench::Random;
    use hal_lbp16::commands;
    use port::Lost;
    use std::sync::Mutex;

    type Values = Box<dyn FnMut() -> u32 + Send>;

    /// A card whose registers read as values in a row; the answer that waits stands behind them.
    struct Row(Mutex<(Values, Vec<u8>)>);

    impl Row {
        fn new(values: impl FnMut() -> u32 + Send + 'static) -> Self {
            Self(Mutex::new((Box::new(values), Vec::new())))
        }
    }

    impl Exchange for Row {
        fn send(&self, packet: &[u8]) -> Result<(), Lost> {
            let (values, answer) = &mut *self.0.lock().unwrap();
            let reads = commands(packet).flatten().filter(|request| !request.command.writes);
            let count = reads.map(|request| usize::from(request.command.count)).sum();
            *answer = (0..count).flat_map(|_| values().to_le_bytes()).collect();
            Ok(())
        }

        fn receive(&self, into: &mut [u8], _: Duration) -> Result<usize, Lost> {
            let answer = core::mem::take(&mut self.0.lock().unwrap().1);
            into[..answer.len()].copy_from_slice(&answer);
            Ok(answer.len())
        }
    }

    const AT: Addresses = Addresses {
        command: 4,
        data: 8,
        status: [12; CHANNELS],
        user: [[16; CHANNELS], [20; CHANNELS], [24; CHANNELS]],
    };

    #[test]
    fn a_port_of_chance_ends_every_question() {
        let mut random = Random::new(11);
        // Small numbers, so that commands end, lists have ends, and records have kinds.
        let device = Row::new(move || {
            let [kind, byte, a, b, c, d, ..] = random.word().to_le_bytes();
            match kind % 16 {
                0..=9 => 0,
                10..=12 => u32::from(byte),
                13 => 0xA0,
                _ => u32::from_le_bytes([a, b, c, d]),
            }
        });
        let talk = Talk { device: &device, at: AT };
        let (mut good, mut bad) = (0, 0);
        for round in 0..20_000_u16 {
            let channel = u8::try_from(round % 8).unwrap();
            let Ok(Some(answered)) = talk.start(channel, 0) else { continue };
            let mut memory = RemoteMemory { talk: &talk, channel, fault: None };
            match Description::read(&mut memory, answered.data | 1, answered.parameters) {
                Ok(_) => good += 1,
                Err(_) => bad += 1,
            }
        }
        assert!(good > 100 && bad > 100, "{good} {bad}");
    }

    #[test]
    fn a_command_without_an_end_is_an_error() {
        let device = Row::new(|| 1);
        let talk = Talk { device: &device, at: AT };
        assert_eq!(talk.stop(), Err(BadPort::Busy(STOP_ALL)));
        assert_eq!(talk.start(3, 0), Err(BadPort::Busy(START_SETUP | 8)));
        // A start may take many milliseconds: the register has the command until it is done.
        let mut left = 15_000;
        let slow = Row::new(move || {
            left -= 1;
            u32::from(left > 0)
        });
        let talk = Talk { device: &slow, at: AT };
        assert_eq!(talk.start(3, 0), Ok(None));
        let silent = Row::new(|| 0);
        let talk = Talk { device: &silent, at: AT };
        assert_eq!(talk.stop(), Ok(()));
        assert_eq!(talk.start(3, 0), Ok(None));
    }
}
