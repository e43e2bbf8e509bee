//! A card at a bench: registers by name, through packets.

use hal_card::{Board, Card};
use hal_firmware::Register;
use hal_lbp16::{MAX_PACKET, Packet, Space};

pub(crate) struct Bench {
    pub(crate) card: Card,
    pub(crate) board: Board,
}

impl Bench {
    pub(crate) fn new(name: &str) -> Self {
        let board = Board::named(name).unwrap();
        Self { card: Card::new(&board), board }
    }

    /// Returns the address of a register by the module's base: 256 bytes to the next register, 4 to the next instance.
    pub(crate) fn at(&self, register: Register, instance: u16) -> u16 {
        let module = self.board.modules.iter().find(|m| m.tag == register.of as u8).unwrap();
        let own = module.multiple >> register.index & 1 == 1;
        module.base + 256 * u16::from(register.index) + if own { 4 * instance } else { 0 }
    }

    pub(crate) fn write(&mut self, register: Register, instance: u16, value: u32) {
        let at = self.at(register, instance);
        self.poke(at, value);
    }

    pub(crate) fn read(&mut self, register: Register, instance: u16) -> u32 {
        let at = self.at(register, instance);
        self.peek(at)
    }

    pub(crate) fn poke(&mut self, at: u16, value: u32) {
        let mut packet = Packet::new();
        packet.write_registers(at, &[value]).unwrap();
        assert_eq!(self.card.answer(packet.bytes(), &mut [0; MAX_PACKET]), None);
    }

    pub(crate) fn peek(&mut self, at: u16) -> u32 {
        let bytes = self.get(Space::Registers, hal_lbp16::Size::Double, at, 1);
        u32::from_le_bytes(bytes.try_into().unwrap())
    }

    pub(crate) fn get(
        &mut self,
        space: Space,
        size: hal_lbp16::Size,
        at: u16,
        count: u8,
    ) -> Vec<u8> {
        let mut packet = Packet::new();
        packet.read(space, size, at, count).unwrap();
        let mut answer = [0; MAX_PACKET];
        let length = self.card.answer(packet.bytes(), &mut answer).unwrap();
        assert_eq!(length, packet.answer_bytes());
        answer[..length].to_vec()
    }

    pub(crate) fn word(&mut self, space: Space, at: u16) -> u16 {
        let bytes = self.get(space, hal_lbp16::Size::Word, at, 1);
        u16::from_le_bytes(bytes.try_into().unwrap())
    }

    pub(crate) fn put_word(&mut self, space: Space, at: u16, value: u16) {
        let mut packet = Packet::new();
        packet.write_words(space, at, &[value]).unwrap();
        assert_eq!(self.card.answer(packet.bytes(), &mut [0; MAX_PACKET]), None);
    }
}

/// Random numbers that repeat.
pub(crate) struct Random(pub(crate) u64);

impl Random {
    pub(crate) const fn next(&mut self) -> u64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        self.0
    }

    pub(crate) const fn below(&mut self, limit: u64) -> u64 {
        self.next() % limit
    }
}
