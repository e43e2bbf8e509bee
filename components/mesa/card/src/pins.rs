//! I/O pins: their ports, what drives them, and what the world puts on them.

use crate::{
    board::Board,
    port::{Drive, Port},
    watchdog::Watchdog,
};
use hal_firmware::{Pin, Tag};

/// I/O pins of a card.
#[derive(Debug)]
pub(crate) struct Terminals {
    ports: Box<[Port]>,
    width: usize,
    pins: Box<[Pin]>,
    /// Level of each pin that nothing on the card drives.
    world: Box<[bool]>,
}

impl Terminals {
    pub(crate) fn new(board: &Board) -> Self {
        let ports = usize::try_from(board.identification.ports).unwrap_or(0);
        let width = usize::try_from(board.identification.port_width).unwrap_or(0).max(1);
        Self {
            ports: vec![Port::default(); ports].into(),
            width,
            pins: board.pins.as_slice().into(),
            // Open pins are pulled up.
            world: vec![true; board.pins.len()].into(),
        }
    }

    fn place(&self, pin: usize) -> Option<(&Port, u32)> {
        let port = self.ports.get(pin / self.width)?;
        Some((port, u32::try_from(pin % self.width).ok().filter(|bit| *bit < 32)?))
    }

    pub(crate) fn pin(&self, pin: usize) -> Option<&Pin> {
        self.pins.get(pin)
    }

    /// Returns the pin of an input of the field.
    pub(crate) fn field_input(&self, input: u8) -> Option<usize> {
        let number = input.checked_add(1)?;
        self.pins.iter().position(|pin| pin.kind() == Some(Tag::Inputs) && pin.number == number)
    }

    pub(crate) const fn width(&self) -> usize {
        self.width
    }

    pub(crate) fn drive(&self, pin: usize, module: bool) -> Drive {
        self.place(pin).map_or(Drive::Released, |(port, bit)| port.drive(bit, module))
    }

    pub(crate) fn world(&self, pin: usize) -> bool {
        self.world.get(pin).copied().unwrap_or(false)
    }

    pub(crate) fn set_world(&mut self, pin: usize, level: bool) {
        if let Some(place) = self.world.get_mut(pin) {
            *place = level;
        }
    }

    pub(crate) fn read(&self, register: u8, port: u8) -> u32 {
        self.ports.get(usize::from(port)).map_or(0, |port| port.read(register))
    }

    pub(crate) fn write(&mut self, register: u8, port: u8, value: u32, watchdog: &Watchdog) {
        if let Some(port) = self.ports.get_mut(usize::from(port)) {
            port.write(register, value);
            if watchdog.has_bitten() {
                port.clear();
            }
        }
    }

    pub(crate) fn clear(&mut self) {
        for port in &mut self.ports {
            port.clear();
        }
    }

    /// Calls a function with the instance of each step output, and whether the generator drives the pin.
    pub(crate) fn each_step_output(&self, mut tell: impl FnMut(usize, bool)) {
        for (at, pin) in self.pins.iter().enumerate() {
            if pin.tag == Tag::StepGenerator as u8 && pin.number == 1 && pin.is_output {
                let driven = self.place(at).is_some_and(|(port, bit)| port.is_modules(bit));
                tell(usize::from(pin.instance), driven);
            }
        }
    }
}
