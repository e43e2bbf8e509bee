//! Addresses of the registers, and the table of constants that identifies the firmware.

use crate::board::Board;
use hal_firmware::{
    COOKIE, COOKIE_AT, IDENTIFICATION_AT, Identification, Module, NAME, Tag, registers,
};

/// Address of the identification.
const IDENTIFICATION: u16 = 0x400;
/// Registers of the address space.
const REGISTERS: usize = 0x4000;
/// Channels of a smart-serial port that have addresses.
const CHANNELS: u8 = 16;

/// Register of a module.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Slot {
    pub(crate) tag: Tag,
    pub(crate) register: u8,
    pub(crate) instance: u8,
    /// Channel of a smart-serial port.
    pub(crate) channel: u8,
}

/// Registers by address.
#[derive(Debug)]
pub(crate) struct Decoder {
    slots: Box<[Option<Slot>]>,
    constants: Box<[(u16, u32)]>,
}

impl Decoder {
    pub(crate) fn new(board: &Board) -> Self {
        let mut slots = vec![None; REGISTERS].into_boxed_slice();
        let id = &board.identification;
        for module in &board.modules {
            let Some(tag) = module.kind() else { continue };
            for register in registers::of(tag) {
                for instance in 0..module.instances {
                    for channel in 0..channels(tag, register.index) {
                        let at = address(module, id, register.index, instance, channel);
                        let slot = Slot { tag, register: register.index, instance, channel };
                        if let Some(place) = at.and_then(|at| slots.get_mut(usize::from(at / 4)))
                            && place.is_none()
                        {
                            *place = Some(slot);
                        }
                    }
                }
            }
        }
        Self { slots, constants: constants(board) }
    }

    pub(crate) fn slot(&self, at: u16) -> Option<Slot> {
        self.slots.get(usize::from(at / 4)).copied().flatten()
    }

    /// Returns a constant of the firmware's account of itself.
    pub(crate) fn constant(&self, at: u16) -> Option<u32> {
        let nth = self.constants.binary_search_by_key(&(at & !3), |row| row.0).ok()?;
        self.constants.get(nth).map(|row| row.1)
    }
}

const fn channels(tag: Tag, register: u8) -> u8 {
    let is_serial = matches!(tag, Tag::SmartSerial | Tag::SmartSerialB);
    if is_serial && registers::SERIAL_STATUS.index <= register { CHANNELS } else { 1 }
}

/// Returns the address of a register, also of one that the descriptor does not count.
fn address(
    module: &Module,
    id: &Identification,
    register: u8,
    instance: u8,
    channel: u8,
) -> Option<u16> {
    let all = Module { registers: u8::MAX, ..*module };
    let is_serial = matches!(module.kind(), Some(Tag::SmartSerial | Tag::SmartSerialB));
    // The command and data registers of smart serial exist for each port, though the descriptor shares them.
    let all = if is_serial { Module { multiple: u32::MAX, ..all } } else { all };
    all.address(id, register, instance)?.checked_add(u16::from(channel) * 4)
}

fn constants(board: &Board) -> Box<[(u16, u32)]> {
    let mut out = Vec::new();
    let mut put = |mut at: u32, words: &mut dyn Iterator<Item = u32>| {
        for word in words {
            if let Ok(at) = u16::try_from(at) {
                out.push((at, word));
            }
            at += 4;
        }
    };
    let [a, b, c, d, e, f, g, h] = NAME;
    let id = board.identification;
    let head = [
        COOKIE,
        u32::from_le_bytes([a, b, c, d]),
        u32::from_le_bytes([e, f, g, h]),
        u32::from(IDENTIFICATION),
    ];
    put(u32::from(COOKIE_AT), &mut head.into_iter());
    let at = u32::from(IDENTIFICATION);
    put(at, &mut id.to_words().into_iter());
    put(at + id.modules, &mut board.modules.iter().flat_map(Module::to_words).chain([0; 3]));
    put(at + id.pins, &mut board.pins.iter().map(hal_firmware::Pin::to_word));
    out.sort_unstable_by_key(|row| row.0);
    debug_assert_eq!(IDENTIFICATION_AT, COOKIE_AT + 12);
    out.into()
}
