//! Reasons why a card, a port or a remote cannot be used, in words.

use crate::{
    ask::Unusable,
    modules::sserial::{BadPort, BadRemote},
};
use hal_firmware::BadIdentification;
use port::Lost;

#[test]
fn each_reason_says_what_is_wrong() {
    let rows: [(&dyn core::fmt::Display, &str); 21] = [
        (
            &Unusable::Silent,
            "no card answers: check the cable, the card's power, its address (jumpers select 192.168.1.121 or 10.10.10.10), and that this computer has an address in the same network",
        ),
        (
            &Unusable::Lost(Lost(101)),
            "no way to the card: the device does not answer (Network is unreachable (os error 101))",
        ),
        (
            &Unusable::NotOurs(0x1234),
            "the device answers 0x00001234 where a card with hostmot2 firmware has 0x55aacafe",
        ),
        (
            &Unusable::Firmware(*b"OTHER\0\"\n"),
            "the card's firmware is 'OTHER\\x00\\\"\\n', not HOSTMOT2: load one with mesaflash",
        ),
        (
            &Unusable::Modules,
            "the card's firmware cannot be used: its table of modules has no end within 32",
        ),
        (
            &Unusable::Identification(BadIdentification::Layout(9)),
            "the card's firmware cannot be used: its identification has layout 9, where 2 and 3 are known",
        ),
        (
            &BadIdentification::PortWidth(0),
            "its ports have 0 pins each, where 1 to 32 are possible",
        ),
        (
            &BadIdentification::Width { pins: 34, ports: 3, port_width: 17 },
            "it has 34 pins in 3 ports of 17",
        ),
        (&BadIdentification::Clock(50), "it has a clock of 50 Hz, where at least 1 MHz is known"),
        (&BadIdentification::TooManyPins(999), "it has 999 I/O pins, where at most 144 are known"),
        (
            &BadIdentification::Offset(0xFFFF),
            "a table of its identification is at 0xffff, where no table can be",
        ),
        (
            &BadPort::Card(Unusable::Modules),
            "the card's firmware cannot be used: its table of modules has no end within 32",
        ),
        (
            &BadPort::Busy(0x1001),
            "the port's processor does not finish command 0x1001: switch the card off and on again",
        ),
        (&BadRemote::Silent(0x10), "it does not answer a question about address 0x0010"),
        (&BadRemote::Nothing, "it says nothing about its process data"),
        (&BadRemote::Endless(0x20), "its list at address 0x0020 has no end within 64 records"),
        (
            &BadRemote::Record { at: 0x30, kind: 0xB0 },
            "its record at address 0x0030 is of kind 0xb0, which is none",
        ),
        (
            &BadRemote::Datum { at: 0x40 },
            "its record at address 0x0040 has a form, direction or width that is not known",
        ),
        (
            &BadRemote::Name { at: 0x50 },
            "the name at address 0x0050 is longer than 32 letters, or has letters that no pin can have",
        ),
        (&BadRemote::Width, "it has more than 96 bits of process data in one direction"),
        (
            &Unusable::Identification(BadIdentification::Offset(3)),
            "the card's firmware cannot be used: a table of its identification is at 0x3, where no table can be",
        ),
    ];
    for (reason, expected) in rows {
        assert_eq!(reason.to_string(), expected);
    }
}
