//! The side of the world: what is connected to the card's terminals.

use crate::{card::Card, encoder::EncoderLine, port::Drive, remote::Remote};
use hal_firmware::{Pin, Tag};

impl Card {
    /// Puts a level on a pin. A pin of an encoder takes it as a line of that encoder.
    pub fn set_input(&mut self, pin: usize, level: bool) {
        let Some(own) = self.terminals.pin(pin).copied() else { return };
        let line = EncoderLine::of_pin(own.number).filter(|_| !own.is_output);
        let instance = usize::from(own.instance);
        match (own.kind(), line) {
            (Some(Tag::Encoder), Some(line)) => self.encoders.set_line(instance, line, level),
            (Some(Tag::MuxedEncoder), Some(line)) => {
                self.muxed.set_line(instance * 2, line, level);
            }
            (Some(Tag::Inputs), _) => self.inputs.set(own.number.saturating_sub(1), level),
            _ => {}
        }
        self.terminals.set_world(pin, level);
    }

    /// Switches an input of the field on or off: one with filters, or a scanned one. An input that is on pulls its line down.
    pub fn set_field_input(&mut self, input: u8, is_on: bool) {
        match self.terminals.field_input(input) {
            Some(pin) => self.set_input(pin, !is_on),
            None => self.scanned.set(input, !is_on),
        }
    }

    /// Returns the level that a meter reads at a pin.
    #[must_use]
    pub fn level(&self, pin: usize) -> bool {
        let Some(own) = self.terminals.pin(pin) else { return false };
        match self.terminals.drive(pin, self.module_level(own)) {
            Drive::Level(level) => level,
            Drive::Released => self.outside(pin, own),
        }
    }

    /// Returns whether the card drives a pin.
    #[must_use]
    pub fn is_driven(&self, pin: usize) -> bool {
        let own = self.terminals.pin(pin);
        own.is_some_and(|own| self.terminals.drive(pin, self.module_level(own)) != Drive::Released)
    }

    /// Returns the level of a pin that the card does not drive.
    fn outside(&self, pin: usize, own: &Pin) -> bool {
        let line = EncoderLine::of_pin(own.number).filter(|_| !own.is_output);
        let instance = usize::from(own.instance);
        match (own.kind(), line) {
            (Some(Tag::Encoder), Some(line)) => self.encoders.line(instance, line),
            (Some(Tag::MuxedEncoder), Some(line)) => self.muxed.line(instance * 2, line),
            (Some(Tag::Inputs), _) => self.inputs.level(own.number.saturating_sub(1)),
            _ => self.terminals.world(pin),
        }
    }

    /// Returns the level that a module gives to its output.
    fn module_level(&self, own: &Pin) -> bool {
        if !own.is_output {
            return false;
        }
        let bit = own.number.wrapping_sub(1);
        match own.kind() {
            Some(Tag::StepGenerator) => self.steps.level(own.instance, own.number),
            Some(Tag::Pwm) => self.pwm.level(own.instance, own.number),
            Some(Tag::Ssr) => self.relays.level(own.number),
            Some(Tag::Outputs) => bit < 32 && self.outputs >> bit & 1 == 1,
            _ => false,
        }
    }

    /// Returns the levels of the pins of a port.
    pub(crate) fn levels(&self, port: u8) -> u32 {
        let width = self.terminals.width();
        let first = usize::from(port) * width;
        let bits = (0_u32..).zip(first..first + width);
        bits.take(32).fold(0, |word, (bit, pin)| word | u32::from(self.level(pin)) << bit)
    }

    /// Returns the position of a step generator in counts with their fraction. It wraps nowhere.
    #[must_use]
    pub fn steps(&self, generator: usize) -> Option<f64> {
        self.steps.position(generator)
    }

    /// Returns the steps that left the card: forward less backward, while the generator drove its pin.
    #[must_use]
    pub fn emitted_steps(&self, generator: usize) -> Option<i64> {
        self.steps.emitted(generator)
    }

    /// Lets an encoder turn to these counts during the time that passes next.
    pub fn set_counts(&mut self, encoder: usize, counts: i64) {
        self.encoders.turn_to(encoder, counts);
    }

    /// Lets an encoder turn by counts during the time that passes next.
    pub fn turn(&mut self, encoder: usize, counts: i64) {
        let at = self.encoders.position(encoder).unwrap_or(0);
        self.encoders.turn_to(encoder, at.wrapping_add(counts));
    }

    /// Gives an encoder an index at each multiple of so many counts; 0 for none.
    pub fn set_index(&mut self, encoder: usize, counts: u32) {
        self.encoders.set_turn(encoder, counts);
    }

    /// Sets the probe line of an encoder.
    pub fn set_probe(&mut self, encoder: usize, level: bool) {
        self.encoders.set_line(encoder, EncoderLine::Probe, level);
    }

    /// As [`Card::set_counts`], for an encoder that shares its lines with another.
    pub fn set_muxed_counts(&mut self, encoder: usize, counts: i64) {
        self.muxed.turn_to(encoder, counts);
    }

    /// As [`Card::turn`], for an encoder that shares its lines with another.
    pub fn turn_muxed(&mut self, encoder: usize, counts: i64) {
        let at = self.muxed.position(encoder).unwrap_or(0);
        self.muxed.turn_to(encoder, at.wrapping_add(counts));
    }

    /// As [`Card::set_index`], for an encoder that shares its lines with another.
    pub fn set_muxed_index(&mut self, encoder: usize, counts: u32) {
        self.muxed.set_turn(encoder, counts);
    }

    /// Returns the duty of a generator of pulse width, from -1 to 1.
    #[must_use]
    pub fn duty(&self, generator: usize) -> Option<f64> {
        self.pwm.duty(generator)
    }

    /// Returns the frequency of a generator of pulse width in hertz.
    #[must_use]
    pub fn pulse_frequency(&self, generator: usize) -> Option<f64> {
        self.pwm.frequency(generator, self.clock_high)
    }

    /// Returns whether a generator of pulse width is enabled.
    #[must_use]
    pub fn is_pulse_enabled(&self, generator: usize) -> bool {
        self.pwm.is_enabled(generator)
    }

    /// Returns whether a relay is closed. It opens when the watchdog has bitten: its driver gets no wave.
    #[must_use]
    pub const fn relay(&self, relay: u8) -> bool {
        !self.watchdog.has_bitten() && self.relays.is_on(relay)
    }

    /// Returns whether a light is on.
    #[must_use]
    pub const fn light(&self, light: u8) -> bool {
        light < 8 && self.lights >> (24 + light) & 1 == 1
    }

    /// Returns whether the watchdog has bitten and was not released.
    #[must_use]
    pub const fn watchdog_has_bitten(&self) -> bool {
        self.watchdog.has_bitten()
    }

    /// Plugs a remote into a channel of a smart-serial port. Returns whether the port has that channel.
    pub fn plug(&mut self, port: usize, channel: usize, remote: Remote) -> bool {
        self.serial.get_mut(port).is_some_and(|port| port.plug(channel, remote))
    }

    /// Cuts the cable of a remote, or joins it again.
    pub fn cut(&mut self, port: usize, channel: usize, is_cut: bool) {
        if let Some(port) = self.serial.get_mut(port) {
            port.cut(channel, is_cut);
        }
    }

    /// Lets the processor of a smart-serial port finish no command from now on, or each again.
    pub fn hang_serial(&mut self, port: usize, hangs: bool) {
        if let Some(port) = self.serial.get_mut(port) {
            port.hang(hangs);
        }
    }

    /// Returns the remote of a channel.
    #[must_use]
    pub fn remote(&self, port: usize, channel: usize) -> Option<&Remote> {
        self.serial.get(port)?.remote(channel)
    }

    /// Returns the remote of a channel, to set its inputs.
    pub fn remote_mut(&mut self, port: usize, channel: usize) -> Option<&mut Remote> {
        self.serial.get_mut(port)?.remote_mut(channel)
    }
}
