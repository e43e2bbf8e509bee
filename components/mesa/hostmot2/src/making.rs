//! A card's pins under construction.

use crate::{
    ask::{self, Described},
    config::CardConfig,
    link::Renewals,
    module::{Reads, Writes},
    modules::UsedRemote,
    plan::{Place, ReadPlan},
};
use hal_component::{Builder, Error, ParamRw, lasting};
use hal_firmware::{Module, Register, Tag};
use port::Exchange;
use std::sync::{Arc, atomic::AtomicU16};

/// Pins, registers to read, and parts of the functions of one card, so far.
pub(crate) struct Making<'m, 'h> {
    pub(crate) b: &'m mut Builder<'h>,
    /// Beginning of all names, such as `hm2_7i92.0`.
    pub(crate) name: &'m str,
    pub(crate) renewals: Renewals,
    /// Address of the register that the raw pins read.
    pub(crate) raw_address: Arc<AtomicU16>,
    pub(crate) device: &'m dyn Exchange,
    pub(crate) card: &'m Described,
    pub(crate) config: &'m CardConfig,
    pub(crate) plan: ReadPlan,
    pub(crate) reads: Vec<Box<dyn Reads>>,
    pub(crate) writes: Vec<Box<dyn Writes>>,
    /// Counts per unit of each encoder.
    pub(crate) encoder_scales: Vec<ParamRw<f64>>,
    /// For each I/O pin, whether a module uses it.
    pub(crate) taken: Vec<bool>,
    /// Channels of each smart-serial port that are used, one bit each.
    pub(crate) channels: Vec<u8>,
    /// Remotes of smart serial.
    pub(crate) remotes: Vec<UsedRemote>,
    /// Number of used instances of each kind of module.
    pub(crate) used: Vec<(Tag, u8)>,
}

impl Making<'_, '_> {
    /// Returns a message that begins with the card's name.
    pub(crate) fn says(&self, text: &str) -> &'static str {
        lasting(format!("{}: {text}", self.name))
    }

    /// Returns the module of a kind with the number of its instances that are used, if that is not 0.
    pub(crate) fn module(&self, tag: Tag) -> Option<(Module, u8)> {
        let used = self.used.iter().find(|row| row.0 == tag).map_or(0, |row| row.1);
        let module = self.card.modules.iter().find(|module| module.kind() == Some(tag))?;
        (used > 0).then_some((*module, used))
    }

    /// Returns the address of a register of an instance.
    pub(crate) fn address(
        &self,
        module: &Module,
        register: Register,
        instance: u8,
    ) -> Result<u16, Error> {
        module.address(&self.card.identification, register.index, instance).ok_or_else(|| {
            Error::new(format!(
                "{}: the card's firmware has no register {} of {} {instance}",
                self.name,
                register.name,
                register.of.name()
            ))
        })
    }

    /// Adds a register of an instance to those that are read in each cycle.
    pub(crate) fn read(
        &mut self,
        module: &Module,
        register: Register,
        instance: u8,
    ) -> Result<Place, Error> {
        let address = self.address(module, register, instance)?;
        Ok(self.plan.read(address))
    }

    /// Returns the present value of a register of an instance.
    pub(crate) fn peek(
        &self,
        module: &Module,
        register: Register,
        instance: u8,
    ) -> Result<u32, Error> {
        let address = self.address(module, register, instance)?;
        let [value] = ask::registers(self.device, address)
            .map_err(|why| Error::new(format!("{}: {why}", self.name)))?;
        Ok(value)
    }

    /// Returns the address of a module's register that selects a timer, which descriptors do not count; `None` if the
    /// firmware has no clock with timers.
    pub(crate) fn timer(&self, module: &Module, register: Register) -> Option<u16> {
        self.card.modules.iter().find(|module| module.kind() == Some(Tag::Dpll))?;
        let whole = Module { registers: u8::MAX, ..*module };
        whole.address(&self.card.identification, register.index, 0)
    }

    /// Returns the frequency of a module's clock in hertz.
    pub(crate) fn clock(&self, module: &Module) -> Result<f64, Error> {
        let hz = module.clock_hz(&self.card.identification).ok_or_else(|| {
            Error::new(format!(
                "{}: the card's firmware does not say the clock of module {}",
                self.name, module.tag
            ))
        })?;
        Ok(f64::from(hz))
    }

    /// Returns the name of a pin of the card: `hm2_7i92.0.` and `part`.
    pub(crate) fn at(&self, part: &str) -> String {
        format!("{}.{part}", self.name)
    }

    /// Returns the numbers of the outputs of an instance that the card has, from 0 on, of at most `most`.
    pub(crate) fn outputs(&self, tag: Tag, instance: u8, most: u8) -> Vec<u8> {
        let mut numbers: Vec<u8> = self
            .pins_of(tag, instance)
            .filter(|pin| pin.is_output && (1..=most).contains(&pin.number))
            .map(|pin| pin.number - 1)
            .collect();
        numbers.sort_unstable();
        numbers.dedup();
        numbers
    }

    /// Returns whether an instance has an I/O pin of this number that is an input.
    pub(crate) fn has_pin(&self, tag: Tag, instance: u8, number: u8) -> bool {
        self.pins_of(tag, instance).any(|pin| !pin.is_output && pin.number == number)
    }

    fn pins_of(&self, tag: Tag, instance: u8) -> impl Iterator<Item = &hal_firmware::Pin> {
        let of =
            move |pin: &&hal_firmware::Pin| pin.kind() == Some(tag) && pin.instance == instance;
        self.card.pins.iter().filter(of)
    }
}
