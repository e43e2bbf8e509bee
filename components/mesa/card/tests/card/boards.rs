//! The account that each card gives of itself.

use crate::bench::Bench;
use hal_card::{ADDRESS, MAC, boards};
use hal_firmware::{
    COOKIE, COOKIE_AT, IDENTIFICATION_AT, Identification, Module, NAME, Pin, registers,
};
use hal_lbp16::{Size, Space};

/// Reads the account as a driver does, from the cookie on.
#[test]
fn every_card_says_what_its_board_has() {
    assert_eq!(boards().count(), 15);
    for name in boards() {
        let mut bench = Bench::new(name);
        assert_eq!(bench.peek(COOKIE_AT), COOKIE, "{name}");
        assert_eq!(bench.get(Space::Registers, Size::Double, COOKIE_AT + 4, 2), NAME);
        let at = bench.peek(IDENTIFICATION_AT) as u16;
        let words: Vec<u32> = (0..16).map(|nth| bench.peek(at + 4 * nth)).collect();
        let id = Identification::parse(&words.try_into().unwrap()).unwrap();
        assert_eq!(id, bench.board.identification, "{name}");
        for (nth, module) in bench.board.modules.clone().into_iter().enumerate() {
            let at = at + id.modules as u16 + 12 * nth as u16;
            let words = [bench.peek(at), bench.peek(at + 4), bench.peek(at + 8)];
            assert_eq!(Module::parse(words), module, "{name}: module {nth}");
        }
        let end = at + id.modules as u16 + 12 * bench.board.modules.len() as u16;
        assert_eq!(bench.peek(end), 0, "{name}: the table of modules ends");
        for (nth, pin) in bench.board.pins.clone().into_iter().enumerate() {
            let word = bench.peek(at + id.pins as u16 + 4 * nth as u16);
            assert_eq!(Pin::parse(word), pin, "{name}: pin {nth}");
        }
        let card = bench.get(Space::Board, Size::Word, 0, 8);
        assert_eq!(card, bench.board.name, "{name}");
        let text = String::from_utf8(card).unwrap().to_lowercase();
        let text = text.trim_end_matches('\0');
        let same = name.starts_with(text) || text.starts_with(name);
        assert!(same, "{name} is {text}");
        bench.poke(at, 0);
        assert_eq!(bench.peek(at), 3, "{name}: the account cannot be written");
    }
}

#[test]
fn settings_have_the_addresses() {
    let mut bench = Bench::new("7i92");
    let mut mac = bench.get(Space::Settings, Size::Word, 2, 3);
    mac.reverse();
    assert_eq!(mac, MAC);
    let mut ip = bench.get(Space::Settings, Size::Word, 0x20, 2);
    ip.reverse();
    assert_eq!(ip, ADDRESS);
    assert_eq!(&bench.get(Space::Settings, Size::Byte, 0x10, 4), b"7I92");
}

/// Every register that the driver's table has is decoded, and no two have one address.
#[test]
fn registers_have_names_by_their_addresses() {
    let bench = Bench::new("7i96s");
    let name = |at| hal_card::Card::register_name(&bench.board, at);
    let rows = [
        (registers::STEP_RATE, 2, "STEP_RATE[2]"),
        (registers::STEP_TIMER, 0, "STEP_TIMER[0]"),
        (registers::ENCODER_TIMER, 0, "ENCODER_TIMER[0]"),
        (registers::PORT_INVERT, 1, "PORT_INVERT[1]"),
        (registers::WATCHDOG_RESET, 0, "WATCHDOG_RESET[0]"),
        (registers::OUTPUTS_DATA, 0, "OUTPUTS_DATA[0]"),
    ];
    for (register, instance, text) in rows {
        assert_eq!(name(bench.at(register, instance)).as_deref(), Some(text));
    }
    assert_eq!(name(0x5D04).as_deref(), Some("SERIAL_STATUS[0].1"));
    assert_eq!(name(0x0000), None);
    assert_eq!(name(0xFFFC), None);
}
