//! Realtime. Parameters of remotes: their values reach a remote while its port does not run.

use super::{
    describe::Setting,
    talk::{SELECT, WRITE, size},
};
use hal_component::{ParamRw, Touch, Uses};

/// Parameter of the remote at a channel.
pub(crate) struct RemoteSetting {
    pub(crate) channel: usize,
    at: u16,
    bytes: u8,
    lasts: bool,
    pin: SettingPin,
    /// Value that the remote has.
    known: u32,
    /// Value of the last command.
    sent: u32,
}

pub(super) enum SettingPin {
    Unsigned(ParamRw<u32>),
    Signed(ParamRw<i32>),
    Float(ParamRw<f64>),
}

impl Touch for RemoteSetting {
    fn touch(&self, uses: &mut Uses) {
        match &self.pin {
            SettingPin::Unsigned(pin) => pin.touch(uses),
            SettingPin::Signed(pin) => pin.touch(uses),
            SettingPin::Float(pin) => pin.touch(uses),
        }
    }
}

impl RemoteSetting {
    /// Returns the parameter, whose pin has the value of the remote.
    pub(super) fn new(channel: usize, setting: &Setting, pin: SettingPin) -> Self {
        let (at, bytes, lasts) = (setting.at, bytes(setting.bits), setting.lasts);
        let mut made = Self { channel, at, bytes, lasts, pin, known: 0, sent: 0 };
        made.known = made.value();
        made
    }

    fn value(&self) -> u32 {
        match &self.pin {
            SettingPin::Unsigned(pin) => pin.get(),
            SettingPin::Signed(pin) => pin.get().cast_unsigned(),
            SettingPin::Float(pin) => single(pin.get()).to_bits(),
        }
    }

    /// Returns whether the remote has another value than the pin.
    pub(crate) fn is_new(&self) -> bool {
        self.known != self.value()
    }

    /// Notes that the remote has taken or refused the value of the last command.
    pub(crate) const fn done(&mut self) {
        self.known = self.sent;
    }

    /// Returns the command with this number, from 0, that gives the remote the value, and its argument; `None` behind the last.
    pub(crate) fn order(&mut self, number: u8) -> Option<(u32, u32)> {
        if number == 0 {
            self.sent = self.value();
        }
        let write = (WRITE | size(self.bytes) | u32::from(self.at), self.sent);
        nth(number, self.lasts, write)
    }
}

/// Returns the command with this number for a value: one that outlasts power is selected before, and the memory behind it.
const fn nth(number: u8, lasts: bool, write: (u32, u32)) -> Option<(u32, u32)> {
    match (number, lasts) {
        (0, false) | (1, true) => Some(write),
        (0, true) => Some((SELECT, 1)),
        (2, true) => Some((SELECT, 0)),
        _ => None,
    }
}

#[expect(clippy::cast_possible_truncation, reason = "the remote has single precision")]
const fn single(x: f64) -> f32 {
    x as f32
}

/// Returns the bytes of a value with so many bits.
pub(crate) const fn bytes(bits: u8) -> u8 {
    match bits {
        ..=8 => 1,
        9..=16 => 2,
        _ => 4,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Commands as LinuxCNC's driver sends them.
    #[test]
    fn a_lasting_value_is_selected_and_the_memory_behind_it() {
        let write = (WRITE | size(bytes(16)) | 0x190, 0x12D);
        assert_eq!(write.0, 0x6500_0190);
        let all = |lasts| (0..4).map_while(|n| nth(n, lasts, write)).collect::<Vec<_>>();
        assert_eq!(all(false), [write]);
        assert_eq!(all(true), [(0xEC00_0000, 1), write, (0xEC00_0000, 0)]);
        assert_eq!([1, 8, 9, 16, 17, 32].map(bytes), [1, 1, 2, 2, 4, 4]);
        assert_eq!([1, 2, 4].map(size), [0, 1 << 24, 2 << 24]);
    }
}
