//! Smart-serial ports: the port's processor, its channels, and the remotes behind them.
//!
//! Source: section "SSLBP" of Mesa's manuals (7I76E, pages 30 to 59).

use crate::remote::Remote;
use hal_firmware::registers as r;

// Numbers of registers.
const COMMAND: u8 = r::SERIAL_COMMAND.index;
const DATA: u8 = r::SERIAL_DATA.index;
const STATUS: u8 = r::SERIAL_STATUS.index;
const USER_0: u8 = r::SERIAL_USER_0.index;
const USER_1: u8 = r::SERIAL_USER_1.index;
const USER_2: u8 = r::SERIAL_USER_2.index;

/// Channels of a port at most.
pub(crate) const CHANNELS: usize = 8;
/// Bits of a command.
const IGNORE: u32 = 1 << 31;
const WRITE: u32 = 1 << 15;
const REQUEST: u32 = 1 << 13;
const DO: u32 = 1 << 12;
const START: u32 = 1 << 11;
/// Kinds of a start, in bits 8 to 10.
const NORMAL: u32 = 1;
const SETUP: u32 = 7;

/// Faults of a channel in its status register.
const NOT_READY: u32 = 0x8000;
const NO_REMOTE: u32 = 0x4000;
const LINK_ERROR: u32 = 0x2000;
const TIMEOUT: u32 = 0x08;
/// Faults that the remote reports, in the last byte.
const BAD_MODE: u32 = 0x4000_0000;
const BITTEN: u32 = 0x0100_0000;

/// Version of the processor's program.
const VERSION: [u8; 2] = [0, 43];
/// Local memory: the first channel's block, the length of a block, and the baud rate in it.
const BLOCKS_AT: u16 = 0x10;
const BLOCK: u16 = 0x40;
const BAUD_AT: usize = 42;
const CLOCK_AT: u16 = 0xEA;
const BAUD: u32 = 2_500_000;

/// Time after which a remote switches its outputs off.
const REMOTE_WATCHDOG: u64 = 50_000_000;

/// Port with its channels.
#[derive(Debug)]
pub(crate) struct SerialPort {
    command: u32,
    /// True if its processor finishes no command.
    hangs: bool,
    data: u8,
    channels: usize,
    clock_hz: u32,
    links: [Link; CHANNELS],
}

#[derive(Debug, Default)]
struct Link {
    remote: Option<Box<Remote>>,
    is_cut: bool,
    run: Running,
    /// Written by the controller.
    control: u32,
    from: [u32; 3],
    /// Read by the controller.
    status: u32,
    to: [u32; 3],
    baud: u32,
    /// Time since the last exchange, once there was one.
    idle: Option<u64>,
}

#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
enum Running {
    #[default]
    Stopped,
    Normal,
    Setup,
}

impl SerialPort {
    pub(crate) fn new(channels: usize, clock_hz: u32) -> Self {
        let mut port = Self {
            command: 0,
            hangs: false,
            data: 0,
            channels: channels.min(CHANNELS),
            clock_hz,
            links: Default::default(),
        };
        for link in &mut port.links {
            link.baud = BAUD;
        }
        port
    }

    pub(crate) fn plug(&mut self, channel: usize, remote: Remote) -> bool {
        match self.links.get_mut(channel).filter(|_| channel < self.channels) {
            Some(link) => {
                link.remote = Some(Box::new(remote));
                true
            }
            None => false,
        }
    }

    /// Lets the processor of the port finish no command from now on, or each again.
    pub(crate) const fn hang(&mut self, hangs: bool) {
        self.hangs = hangs;
    }

    pub(crate) fn cut(&mut self, channel: usize, is_cut: bool) {
        if let Some(link) = self.links.get_mut(channel) {
            link.is_cut = is_cut;
        }
    }

    pub(crate) fn remote(&self, channel: usize) -> Option<&Remote> {
        self.links.get(channel)?.remote.as_deref()
    }

    pub(crate) fn remote_mut(&mut self, channel: usize) -> Option<&mut Remote> {
        self.links.get_mut(channel)?.remote.as_deref_mut()
    }

    pub(crate) fn advance(&mut self, ns: u64) {
        for link in &mut self.links {
            let Some(idle) = &mut link.idle else { continue };
            *idle = idle.saturating_add(ns);
            if REMOTE_WATCHDOG < *idle
                && let Some(remote) = &mut link.remote
            {
                remote.release();
            }
        }
    }

    pub(crate) fn read(&self, register: u8, channel: usize) -> u32 {
        let link = self.links.get(channel);
        let [first, second, third] = link.map_or([0; 3], |link| link.to);
        match register {
            COMMAND => self.command,
            DATA => u32::from(self.data),
            STATUS => link.map_or(0, |link| link.status),
            USER_0 => first,
            USER_1 => second,
            USER_2 => third,
            _ => 0,
        }
    }

    pub(crate) fn write(&mut self, register: u8, channel: usize, value: u32) {
        let [low, ..] = value.to_le_bytes();
        let link = self.links.get_mut(channel);
        match (register, link) {
            (COMMAND, _) => self.run(value),
            (DATA, _) => self.data = low,
            (STATUS, Some(link)) => link.control = value,
            (USER_0, Some(link)) => link.from[0] = value,
            (USER_1, Some(link)) => link.from[1] = value,
            (USER_2, Some(link)) => link.from[2] = value,
            _ => {}
        }
    }

    /// Runs a command at once: the register reads 0 afterwards.
    fn run(&mut self, command: u32) {
        if command & IGNORE != 0 {
            return;
        }
        self.command = if self.hangs { command } else { 0 };
        if self.hangs {
            return;
        }
        let mask = command & 0xFF;
        if command & REQUEST != 0 {
            let [low, high, ..] = (command & 0x1FFF).to_le_bytes();
            self.local(u16::from_le_bytes([low, high]), command & WRITE != 0);
        } else if command & DO != 0 {
            self.each(mask, Link::exchange);
        } else if command & START != 0 {
            match command >> 8 & 7 {
                NORMAL => self.each(mask, |link| link.start(Running::Normal)),
                SETUP => self.each(mask, |link| link.start(Running::Setup)),
                _ if mask == 0 => self.each(0xFF, Link::reset),
                _ => self.each(mask, Link::stop),
            }
        }
    }

    /// Lets the channels of a mask do something, and collects their faults in the data register.
    fn each(&mut self, mask: u32, mut run: impl FnMut(&mut Link) -> bool) {
        self.data = 0;
        for (nth, link) in self.links.iter_mut().enumerate().take(self.channels) {
            if mask >> nth & 1 == 1 && !run(link) {
                self.data |= 1 << nth;
            }
        }
    }

    /// Reads or writes a byte of the processor's memory. Only the baud rates can be written.
    fn local(&mut self, at: u16, writes: bool) {
        let within = at.wrapping_sub(BLOCKS_AT);
        let link = self.links.get_mut(usize::from(within / BLOCK));
        let of = usize::from(within % BLOCK).checked_sub(BAUD_AT);
        if let Some((link, of)) = link.zip(of) {
            let mut baud = link.baud.to_le_bytes();
            if let Some(byte) = baud.get_mut(of) {
                if writes {
                    *byte = self.data;
                    link.baud = u32::from_le_bytes(baud);
                } else {
                    self.data = *byte;
                }
                return;
            }
        }
        if !writes {
            self.data = self.constant(at);
        }
    }

    fn constant(&self, at: u16) -> u8 {
        let [blocks, _] = BLOCKS_AT.to_le_bytes();
        let [block, _] = BLOCK.to_le_bytes();
        let channels = u8::try_from(self.channels).unwrap_or(0);
        let own = [0x12, 8, VERSION[0], VERSION[1], blocks, block, 0xD8, channels];
        let of_clock = usize::from(at.wrapping_sub(CLOCK_AT));
        let clock = self.clock_hz.to_le_bytes();
        own.get(usize::from(at)).or_else(|| clock.get(of_clock)).copied().unwrap_or(0)
    }
}

impl Link {
    fn reset(&mut self) -> bool {
        (self.status, self.to) = (0, [0; 3]);
        self.stop()
    }

    /// Ends the exchange. The remote goes on by itself: its own watchdog releases its outputs.
    const fn stop(&mut self) -> bool {
        self.run = Running::Stopped;
        true
    }

    fn start(&mut self, run: Running) -> bool {
        let [.., mode] = self.control.to_le_bytes();
        let is_reachable = !self.is_cut && self.baud == BAUD;
        let Some(remote) = self.remote.as_mut().filter(|_| is_reachable) else {
            (self.run, self.status, self.to) = (Running::Stopped, NOT_READY | NO_REMOTE, [0; 3]);
            return false;
        };
        let known = remote.start(mode);
        if run == Running::Normal {
            remote.release();
        }
        self.status = if known { 0 } else { BAD_MODE };
        (self.run, self.to, self.idle) = (run, remote.account(), None);
        known
    }

    fn exchange(&mut self) -> bool {
        let Some(remote) = self.remote.as_mut().filter(|_| !self.is_cut) else {
            self.status |= LINK_ERROR | TIMEOUT;
            return false;
        };
        match self.run {
            Running::Stopped => {
                self.status |= NOT_READY;
                false
            }
            Running::Normal => {
                if self.idle.is_some_and(|idle| REMOTE_WATCHDOG < idle) {
                    self.status |= BITTEN;
                    return false;
                }
                self.to = remote.exchange(self.from);
                self.idle = Some(0);
                true
            }
            Running::Setup => {
                let [low, high, _, command] = self.control.to_le_bytes();
                let data = u64::from(self.from[0]) | u64::from(self.from[1]) << 32;
                match remote.command(command, u16::from_le_bytes([low, high]), data) {
                    Some(answer) => {
                        let [a, b, c, d, e, f, g, h] = answer.to_le_bytes();
                        self.to[0] = u32::from_le_bytes([a, b, c, d]);
                        self.to[1] = u32::from_le_bytes([e, f, g, h]);
                        true
                    }
                    None => {
                        self.status |= LINK_ERROR;
                        false
                    }
                }
            }
        }
    }
}
