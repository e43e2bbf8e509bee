//! Realtime. Terminals of smart-serial remotes as pins.

use hal_card::{Card, Remote};
use hal_component::{In, Out, Touch, Uses};

/// Terminals of one remote, and its cable.
#[derive(Clone)]
pub(super) struct RemoteWorld {
    pub(super) port: usize,
    pub(super) channel: usize,
    pub(super) plugged: In<bool>,
    pub(super) terminals: Vec<RemoteTerminals>,
}

/// Terminals of one datum.
#[derive(Clone)]
pub(super) struct RemoteTerminals {
    /// Name of the datum, as the remote has it.
    pub(super) name: Box<str>,
    pub(super) bits: u8,
    pub(super) max: f64,
    pub(super) pins: TerminalPins,
}

#[derive(Clone)]
pub(super) enum TerminalPins {
    Levels(Vec<In<bool>>),
    Value(In<f64>),
    Raw(In<u32>),
    ShownLevels(Vec<Out<bool>>),
    ShownValue(Out<f64>),
    ShownRaw(Out<u32>),
}

impl Touch for RemoteWorld {
    fn touch(&self, uses: &mut Uses) {
        self.plugged.touch(uses);
        for terminal in &self.terminals {
            match &terminal.pins {
                TerminalPins::Levels(pins) => pins.touch(uses),
                TerminalPins::Value(pin) => pin.touch(uses),
                TerminalPins::Raw(pin) => pin.touch(uses),
                TerminalPins::ShownLevels(pins) => pins.touch(uses),
                TerminalPins::ShownValue(pin) => pin.touch(uses),
                TerminalPins::ShownRaw(pin) => pin.touch(uses),
            }
        }
    }
}

impl RemoteWorld {
    pub(super) fn put_in(&self, card: &mut Card) {
        card.cut(self.port, self.channel, !self.plugged.get());
        let Some(remote) = card.remote_mut(self.port, self.channel) else { return };
        for terminal in &self.terminals {
            terminal.put_in(remote);
        }
    }

    pub(super) fn put_out(&self, card: &Card) {
        let Some(remote) = card.remote(self.port, self.channel) else { return };
        for terminal in &self.terminals {
            terminal.put_out(remote);
        }
    }
}

impl RemoteTerminals {
    fn put_in(&self, remote: &mut Remote) {
        let value = match &self.pins {
            TerminalPins::Levels(levels) => levels
                .iter()
                .take(64)
                .enumerate()
                .fold(0, |all, (n, level)| all | u64::from(level.get()) << n),
            TerminalPins::Value(value) => raw(value.get() / self.max * full(self.bits)),
            TerminalPins::Raw(value) => u64::from(value.get()),
            TerminalPins::ShownLevels(_)
            | TerminalPins::ShownValue(_)
            | TerminalPins::ShownRaw(_) => return,
        };
        remote.set(&self.name, value);
    }

    fn put_out(&self, remote: &Remote) {
        let Some(value) = remote.value(&self.name) else { return };
        match &self.pins {
            TerminalPins::ShownLevels(levels) => {
                for (n, level) in levels.iter().take(64).enumerate() {
                    level.set(value >> n & 1 == 1);
                }
            }
            TerminalPins::ShownValue(pin) => pin.set(value as f64 / full(self.bits) * self.max),
            TerminalPins::ShownRaw(pin) => pin.set(u32::try_from(value).unwrap_or(u32::MAX)),
            TerminalPins::Levels(_) | TerminalPins::Value(_) | TerminalPins::Raw(_) => {}
        }
    }
}

/// Returns the largest number of so many bits.
fn full(bits: u8) -> f64 {
    libm::exp2(f64::from(bits)) - 1.0
}

#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "the conversion saturates"
)]
fn raw(x: f64) -> u64 {
    libm::floor(x + 0.5) as u64
}
