//! Packets: counters, protected settings, malformed ones, and random ones.

use crate::bench::{Bench, Random};
use hal_card::{Card, Remote};
use hal_lbp16::{CommandWord, MAX_PACKET, Packet, Size, Space};

#[test]
fn packets_are_counted() {
    let mut bench = Bench::new("7i92");
    assert_eq!(bench.word(Space::Communication, 0x08), 1);
    assert_eq!(bench.word(Space::Communication, 0x0A), 2);
    assert_eq!(bench.word(Space::Communication, 0x0E), 2, "the present answer is not sent yet");
    assert_eq!(bench.card.answer(&[0x81], &mut [0; 8]), None);
    assert_eq!(bench.word(Space::Communication, 0x08), 5);
    assert_eq!(bench.word(Space::Communication, 0x02), 1, "malformed");
    assert_eq!(bench.word(Space::Communication, 0x00), 1);
    assert_eq!(bench.card.malformed(), 1);
}

#[test]
fn scratch_words_come_back_in_the_same_packet() {
    let mut bench = Bench::new("7i92");
    let mut packet = Packet::new();
    packet.read(Space::Communication, Size::Word, 0x18, 1).unwrap();
    packet.write_words(Space::Communication, 0x18, &[0x1234]).unwrap();
    packet.write_words(Space::Timers, 0x10, &[0x5678, 0x9ABC]).unwrap();
    packet.read(Space::Timers, Size::Word, 0x10, 2).unwrap();
    packet.read(Space::Communication, Size::Word, 0x18, 1).unwrap();
    let mut answer = [0; MAX_PACKET];
    assert_eq!(bench.card.answer(packet.bytes(), &mut answer), Some(8));
    assert_eq!(answer[..8], [0, 0, 0x78, 0x56, 0xBC, 0x9A, 0x34, 0x12]);
}

#[test]
fn the_time_stamp_is_in_microseconds() {
    let mut bench = Bench::new("7i92");
    bench.card.advance(1_234_567);
    assert_eq!(bench.word(Space::Timers, 0), 1234);
    bench.card.advance(100_000_000);
    assert_eq!(bench.word(Space::Timers, 0), (101_234 % 65_536) as u16);
}

#[test]
fn settings_need_their_key_in_the_same_packet() {
    let mut bench = Bench::new("7i92");
    let set = |bench: &mut Bench, key: &[u16], at: u16| {
        let mut packet = Packet::new();
        if !key.is_empty() {
            packet.write_words(Space::Communication, 0x1A, key).unwrap();
        }
        packet.write_words(Space::Settings, at, &[0x0A0A]).unwrap();
        bench.card.answer(packet.bytes(), &mut [0; MAX_PACKET]);
        bench.word(Space::Settings, at)
    };
    let before = bench.word(Space::Settings, 0x20);
    assert_eq!(set(&mut bench, &[], 0x20), before);
    assert_eq!(set(&mut bench, &[0x5A03], 0x20), before);
    assert_eq!(set(&mut bench, &[0x5A02], 0x20), 0x0A0A);
    bench.put_word(Space::Communication, 0x1A, 0x5A02);
    assert_eq!(set(&mut bench, &[], 0x22), 0xC0A8, "the key is for its own packet");
    let mac = bench.word(Space::Settings, 0x02);
    assert_eq!(set(&mut bench, &[0x5A02], 0x02), mac, "the first 32 bytes cannot be written");
    assert_eq!(bench.word(Space::Communication, 0x06), 4, "refused writes are counted");
}

#[test]
fn spaces_remember_where_they_were() {
    let mut bench = Bench::new("7i92");
    let whole = bench.get(Space::Registers, Size::Double, 0x400, 8);
    // With its address, without it, and standing still.
    let go = CommandWord::read(Space::Registers, Size::Double, 4);
    let on = CommandWord { has_address: false, ..go };
    let still = CommandWord { increments: false, count: 2, ..on };
    let mut packet = Vec::new();
    packet.extend(go.to_bits().to_le_bytes());
    packet.extend([0x00, 0x04]);
    packet.extend(on.to_bits().to_le_bytes());
    packet.extend(still.to_bits().to_le_bytes());
    let mut answer = [0; MAX_PACKET];
    assert_eq!(bench.card.answer(&packet, &mut answer), Some(40));
    assert_eq!(answer[..32], whole[..]);
    assert_eq!(answer[32..36], answer[36..40]);
    let information =
        CommandWord { is_info: true, ..CommandWord::read(Space::Settings, Size::Word, 1) };
    let mut packet = information.to_bits().to_le_bytes().to_vec();
    packet.extend([0, 0]);
    assert_eq!(bench.card.answer(&packet, &mut answer), Some(2));
    assert_eq!(answer[..2], [0x02, 0x5A]);
}

/// Returns all registers of all modules, and the settings.
fn state(card: &mut Card) -> Vec<u8> {
    let mut out = Vec::new();
    for page in 0..0x100_u16 {
        let mut packet = Packet::new();
        packet.read_registers(page << 8, 64).unwrap();
        let mut answer = [0; MAX_PACKET];
        let length = card.answer(packet.bytes(), &mut answer).unwrap();
        out.extend(&answer[..length]);
    }
    let mut packet = Packet::new();
    packet.read(Space::Settings, Size::Word, 0, 64).unwrap();
    packet.read(Space::Timers, Size::Word, 0x10, 8).unwrap();
    let mut answer = [0; MAX_PACKET];
    let length = card.answer(packet.bytes(), &mut answer).unwrap();
    out.extend(&answer[..length]);
    out
}

#[test]
fn malformed_packets_change_nothing() {
    let mut bench = Bench::new("7i96s");
    bench.card.plug(0, 0, Remote::named("7i76").unwrap());
    let before = state(&mut bench.card);
    let mut good = Packet::new();
    good.write_registers(0x1000, &[0xFFFF_FFFF; 3]).unwrap();
    good.write_registers(0x2000, &[0x0100_0000; 5]).unwrap();
    good.write_words(Space::Timers, 0x10, &[1, 2]).unwrap();
    good.read_registers(0x1000, 3).unwrap();
    let mut answer = [0; MAX_PACKET];
    let mut seen = 0;
    for length in 1..good.bytes().len() {
        let cut = &good.bytes()[..length];
        // A cut between two commands is a good packet.
        if hal_lbp16::commands(cut).all(|request| request.is_ok()) {
            continue;
        }
        assert_eq!(bench.card.answer(cut, &mut answer), None, "{length}");
        seen += 1;
    }
    // No items, and an answer without room.
    assert_eq!(bench.card.answer(&[0x80, 0x42, 0, 1], &mut answer), None);
    let mut big = Packet::new();
    big.write_registers(0x1000, &[1]).unwrap();
    big.read_registers(0x100, 8).unwrap();
    assert_eq!(bench.card.answer(big.bytes(), &mut [0; 31]), None);
    assert_eq!(bench.card.malformed(), seen + 2);
    assert!(state(&mut bench.card) == before, "a register changed");
}

/// A million random packets, half of them made of commands: no panic, and the account of the firmware stays.
#[test]
fn random_packets_break_nothing() {
    let mut bench = Bench::new("7i96s");
    bench.card.plug(0, 0, Remote::named("7i73").unwrap());
    let account = |card: &mut Card| {
        let mut packet = Packet::new();
        packet.read_registers(0x100, 4).unwrap();
        packet.read_registers(0x400, 127).unwrap();
        packet.read_registers(0x600, 127).unwrap();
        packet.read(Space::Settings, Size::Word, 0, 16).unwrap();
        packet.read(Space::Board, Size::Word, 0, 8).unwrap();
        let mut answer = [0; MAX_PACKET];
        let length = card.answer(packet.bytes(), &mut answer).unwrap();
        answer[..length].to_vec()
    };
    let before = account(&mut bench.card);
    let mut random = Random(0xF022);
    let (mut answers, mut bytes) = (0, 0);
    let mut answer = [0; MAX_PACKET];
    for nth in 0..1_000_000_u32 {
        let mut packet = [0_u8; 64];
        let length = random.below(65) as usize;
        for part in packet.chunks_mut(8) {
            part.copy_from_slice(&random.next().to_le_bytes());
        }
        if nth % 2 == 0 {
            // A command that writes to a module.
            let at = (random.below(0x9000) as u16) & !3;
            let command =
                CommandWord::write(Space::Registers, Size::Double, 1 + random.below(8) as u8);
            packet[..2].copy_from_slice(&command.to_bits().to_le_bytes());
            packet[2..4].copy_from_slice(&at.to_le_bytes());
        }
        if let Some(length) = bench.card.answer(&packet[..length], &mut answer) {
            answers += 1;
            bytes += length;
        }
        if nth % 64 == 0 {
            bench.card.advance(random.below(100_000));
        }
    }
    assert!(10_000 < answers && 100_000 < bytes, "{answers} answers, {bytes} bytes");
    assert!(10_000 < bench.card.malformed());
    assert_eq!(account(&mut bench.card), before);
    assert!((0..60).any(|pin| bench.card.level(pin)));
}
