//! The card: packets in, packets out, time, and the registers between them.

use crate::{
    board::Board,
    decode::{Decoder, Slot},
    dpll::Dpll,
    encoder::Counters,
    inputs::FilteredInputs,
    pins::Terminals,
    pwm::PulseWidths,
    relays::Relays,
    serial::SerialPort,
    spaces::{self, Spaces},
    step::Generators,
    timer::Ticks,
    watchdog::Watchdog,
};
use hal_firmware::{Tag, registers};
use hal_lbp16::{MAX_ITEMS, PacketRequest, Size, Space, commands};

/// Longest time that the modules advance in one go.
const SECOND: u64 = 1_000_000_000;

/// Simulated card. After [`Card::new`] nothing allocates, locks or panics.
#[derive(Debug)]
pub struct Card {
    pub(crate) decoder: Decoder,
    pub(crate) spaces: Spaces,
    pointers: [u16; 8],
    low: Ticks,
    high: Ticks,
    pub(crate) clock_high: u32,
    pub(crate) terminals: Terminals,
    pub(crate) watchdog: Watchdog,
    pub(crate) dpll: Option<Dpll>,
    pub(crate) steps: Generators,
    pub(crate) encoders: Counters,
    pub(crate) muxed: Counters,
    pub(crate) pwm: PulseWidths,
    pub(crate) inputs: FilteredInputs,
    pub(crate) scanned: FilteredInputs,
    pub(crate) relays: Relays,
    pub(crate) outputs: u32,
    pub(crate) lights: u32,
    pub(crate) serial: Vec<SerialPort>,
    malformed: u64,
}

/// Hardware address of the card: Mesa's prefix, as the settings have it.
pub const MAC: [u8; 6] = [0x00, 0x60, 0x1B, 0x11, 0x80, 0x01];

/// Address of the card as it comes from the factory.
pub const ADDRESS: [u8; 4] = [192, 168, 1, 121];

impl Card {
    /// Returns a card that has just got power.
    #[must_use]
    pub fn new(board: &Board) -> Self {
        let count = |tag: Tag| {
            let modules = board.modules.iter().filter(|m| m.tag == tag as u8);
            modules.map(|m| usize::from(m.instances)).sum::<usize>()
        };
        let numbers = |tag: Tag, instance: Option<usize>| {
            let own = move |pin: &&hal_firmware::Pin| {
                let is_own = instance.is_none_or(|i| i == usize::from(pin.instance));
                pin.tag == tag as u8 && is_own && !pin.is_output
            };
            board.pins.iter().filter(own).map(|pin| pin.number).max().unwrap_or(0)
        };
        let low_hz = board.identification.clock_low;
        let serial = (0..count(Tag::SmartSerial))
            .map(|i| SerialPort::new(numbers(Tag::SmartSerial, Some(i)).into(), low_hz));
        let mut card = Self {
            decoder: Decoder::new(board),
            spaces: Spaces::new(board.name, MAC, ADDRESS),
            pointers: [0; 8],
            low: Ticks::new(low_hz),
            high: Ticks::new(board.identification.clock_high),
            clock_high: board.identification.clock_high,
            terminals: Terminals::new(board),
            watchdog: Watchdog::new(),
            dpll: (count(Tag::Dpll) != 0).then(Dpll::new),
            steps: Generators::new(count(Tag::StepGenerator)),
            encoders: Counters::new(count(Tag::Encoder)),
            muxed: Counters::new(count(Tag::MuxedEncoder)),
            pwm: PulseWidths::new(count(Tag::Pwm)),
            inputs: FilteredInputs::new(numbers(Tag::Inputs, None)),
            scanned: FilteredInputs::new(board.scanned),
            relays: Relays::default(),
            outputs: 0,
            lights: 0,
            serial: serial.collect(),
            malformed: 0,
        };
        card.connect();
        card
    }

    /// Takes a packet, and writes its answer. Returns the bytes of the answer; `None` if the packet reads nothing, if it is
    /// malformed, or if `answer` has no room. A malformed packet is counted and changes nothing.
    pub fn answer(&mut self, packet: &[u8], answer: &mut [u8]) -> Option<usize> {
        self.spaces.count(spaces::RECEIVED);
        self.spaces.count(spaces::RECEIVED_UDP);
        let Some(length) = answer_bytes(packet).filter(|length| *length <= answer.len()) else {
            self.malformed = self.malformed.wrapping_add(1);
            self.spaces.note(spaces::PARSE_ERRORS);
            return None;
        };
        let mut rest = answer;
        for request in commands(packet).flatten() {
            rest = self.serve(&request, rest);
        }
        self.spaces.end_packet();
        self.connect();
        if length == 0 {
            return None;
        }
        self.spaces.count(spaces::SENT);
        self.spaces.count(spaces::SENT_UDP);
        Some(length)
    }

    /// Returns the number of malformed packets so far.
    #[must_use]
    pub const fn malformed(&self) -> u64 {
        self.malformed
    }

    /// Returns whether a packet reads the levels of the I/O pins, as a controller does once per cycle.
    #[must_use]
    pub fn reads_levels(&self, packet: &[u8]) -> bool {
        let mut requests = commands(packet).flatten();
        requests.any(|request| {
            let command = request.command;
            let is_read = !command.writes && !command.is_info && command.space == Space::Registers;
            let slot = request.address.filter(|_| is_read).and_then(|at| self.decoder.slot(at));
            slot.is_some_and(|slot| {
                slot.tag == Tag::IoPort && slot.register == registers::PORT_DATA.index
            })
        })
    }

    /// Lets time pass.
    pub fn advance(&mut self, ns: u64) {
        let mut left = ns;
        while 0 < left {
            let part = left.min(SECOND);
            self.pass(part);
            left -= part;
        }
    }

    fn pass(&mut self, ns: u64) {
        self.spaces.advance(ns);
        for port in &mut self.serial {
            port.advance(ns);
        }
        self.pwm.advance(self.high.take(ns));
        let mut left = self.low.take(ns);
        self.encoders.begin(left);
        self.muxed.begin(left);
        while 0 < left {
            let part = self.watchdog.until_bite().map_or(left, |bite| bite.min(left));
            let timers = self.steps.timers() | self.encoders.timers() | self.muxed.timers();
            let (used, events) = match &mut self.dpll {
                Some(dpll) => dpll.run(part, timers),
                None => (part, 0),
            };
            // A timer that rises before the first tick uses none.
            let used = if events == 0 { used.max(1) } else { used };
            self.steps.advance(used);
            self.encoders.advance(used);
            self.muxed.advance(used);
            self.inputs.advance(used);
            self.scanned.advance(used);
            self.relays.advance(used);
            self.watchdog.advance(used);
            if events != 0 {
                self.steps.latch(events);
                self.encoders.latch(events);
                self.muxed.latch(events);
            }
            if self.watchdog.has_bitten() {
                self.bite();
            }
            left = left.saturating_sub(used);
        }
    }

    /// Does what a watchdog that has bitten does: all I/O pins are inputs.
    fn bite(&mut self) {
        self.terminals.clear();
        self.outputs = 0;
        self.connect();
    }

    /// Serves one command. Returns what it leaves of the answer.
    fn serve<'a>(&mut self, request: &PacketRequest<'_>, mut answer: &'a mut [u8]) -> &'a mut [u8] {
        let command = request.command;
        let pointer = usize::from(command.space as u8);
        let before = self.pointers.get(pointer).copied().unwrap_or(0);
        let mut at = request.address.unwrap_or(before);
        let bytes = command.size.bytes();
        let step = u16::try_from(bytes).unwrap_or(0);
        let mut data = request.data.chunks_exact(bytes);
        for _ in 0..command.count {
            if command.writes {
                let item = data.next().unwrap_or_default();
                if command.is_info || !self.store(command.space, command.size, at, item) {
                    self.spaces.note(spaces::WRITE_ERRORS);
                }
            } else {
                let (item, rest) = answer.split_at_mut_checked(bytes).unwrap_or_default();
                answer = rest;
                self.load(command.space, command.is_info, at, item, before);
            }
            if command.increments {
                at = at.wrapping_add(step);
            }
        }
        if !command.is_info
            && let Some(pointer) = self.pointers.get_mut(pointer)
        {
            *pointer = at;
        }
        answer
    }

    /// Reads an item.
    fn load(&mut self, space: Space, is_info: bool, at: u16, item: &mut [u8], pointer: u16) {
        if is_info {
            let word = |at| Spaces::information(space, at, pointer);
            fill(item, at, word);
        } else if space == Space::Registers {
            if item.len() != Size::Double.bytes() {
                self.spaces.note(spaces::MEMORY_ERRORS);
            }
            let value = self.register(at).to_le_bytes();
            for (place, byte) in item.iter_mut().zip(value.into_iter().chain([0; 4])) {
                *place = byte;
            }
        } else {
            fill(item, at, |at| self.spaces.word(space, at));
        }
    }

    /// Writes an item. Returns whether the card lets it be written.
    fn store(&mut self, space: Space, size: Size, at: u16, item: &[u8]) -> bool {
        match (space, size) {
            (Space::Registers, Size::Double) => {
                let Ok(value) = item.try_into() else { return false };
                self.set_register(at, u32::from_le_bytes(value));
                true
            }
            (Space::Registers, _) | (_, Size::Byte | Size::Double | Size::Quad) => false,
            (_, Size::Word) => {
                let Ok(value) = item.try_into() else { return false };
                self.spaces.set_word(space, at, u16::from_le_bytes(value))
            }
        }
    }

    /// Reads a register as the controller does: some reads do something.
    pub(crate) fn register(&mut self, at: u16) -> u32 {
        let Some(slot) = self.decoder.slot(at) else {
            return self.decoder.constant(at).unwrap_or(0);
        };
        let Slot { tag, register, instance, channel } = slot;
        match tag {
            Tag::Watchdog => self.watchdog.read(register),
            Tag::IoPort if register == registers::PORT_DATA.index => self.levels(instance),
            Tag::IoPort => self.terminals.read(register, instance),
            Tag::Encoder => self.encoders.read(register, instance),
            Tag::MuxedEncoder => self.muxed.read(register, instance),
            Tag::StepGenerator => self.steps.read(register, instance),
            Tag::Dpll => self.dpll.as_mut().map_or(0, |dpll| dpll.read(register)),
            Tag::Ssr => self.relays.read(register),
            Tag::Inputs => self.inputs.read(register),
            Tag::InputMux => self.scanned.read(register),
            Tag::Led => self.lights,
            Tag::SmartSerial => {
                let port = self.serial.get(usize::from(instance));
                port.map_or(0, |port| port.read(register, usize::from(channel)))
            }
            _ => 0,
        }
    }

    pub(crate) fn set_register(&mut self, at: u16, value: u32) {
        let Some(slot) = self.decoder.slot(at) else { return };
        let Slot { tag, register, instance, channel } = slot;
        match tag {
            Tag::Watchdog => {
                self.watchdog.write(register, value);
                if self.watchdog.has_bitten() {
                    self.bite();
                }
            }
            Tag::IoPort => self.terminals.write(register, instance, value, &self.watchdog),
            Tag::Encoder => self.encoders.write(register, instance, value),
            Tag::MuxedEncoder => self.muxed.write(register, instance, value),
            Tag::StepGenerator => self.steps.write(register, instance, value),
            Tag::Pwm => self.pwm.write(register, instance, value),
            Tag::Dpll => {
                if let Some(dpll) = &mut self.dpll {
                    dpll.write(register, value);
                }
            }
            Tag::Ssr => self.relays.write(register, value),
            Tag::Inputs => self.inputs.write(register, value),
            Tag::InputMux => self.scanned.write(register, value),
            Tag::Outputs if !self.watchdog.has_bitten() => self.outputs = value,
            Tag::Led => self.lights = value,
            Tag::SmartSerial => {
                if let Some(port) = self.serial.get_mut(usize::from(instance)) {
                    port.write(register, usize::from(channel), value);
                }
            }
            _ => {}
        }
    }

    /// Tells the step generators whether their pulses leave the card.
    fn connect(&mut self) {
        self.terminals.each_step_output(|instance, is_driven| {
            self.steps.connect(instance, is_driven);
        });
    }
}

/// Fills an item from words.
fn fill(item: &mut [u8], at: u16, word: impl Fn(u16) -> u16) {
    for (place, offset) in item.iter_mut().zip(0_u16..) {
        let at = at.wrapping_add(offset);
        let [low, high] = word(at & !1).to_le_bytes();
        *place = if at & 1 == 0 { low } else { high };
    }
}

/// Returns the bytes of a packet's answer; `None` if a command is unfinished, or has no items.
fn answer_bytes(packet: &[u8]) -> Option<usize> {
    let mut bytes = 0;
    for request in commands(packet) {
        let command = request.ok()?.command;
        if command.count == 0 || MAX_ITEMS < command.count {
            return None;
        }
        if !command.writes {
            bytes += command.data_bytes();
        }
    }
    Some(bytes)
}
