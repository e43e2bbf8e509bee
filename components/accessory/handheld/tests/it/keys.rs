//! Frames of keys, virtual keys and their lines.
#![expect(clippy::indexing_slicing, reason = "tests")]

use hal_handheld::{
    Check, FrameFormat, FrameReader, KeySet, Keypad, LineReader, Press, WrongFormat,
    frame::Received,
    keys::{NAMES, number_of},
    line,
};

fn set(keys: &[u8]) -> KeySet {
    keys.iter().fold(KeySet::NONE, |all, key| all.with(KeySet::of(*key)))
}

fn hex(bytes: &[u8]) -> String {
    bytes.iter().map(|b| format!("{b:02X}")).collect::<Vec<_>>().join(" ")
}

const VECTORS: &[(&[u8], &str)] = &[
    (&[], "A5 00 00 00 00 00 00 81"),
    (&[1], "A5 01 00 00 00 00 00 A8"),
    (&[9], "A5 00 01 00 00 00 00 E3"),
    (&[40], "A5 00 00 00 00 80 00 37"),
    (&[48], "A5 00 00 00 00 00 80 08"),
    (&[1, 9], "A5 01 01 00 00 00 00 CA"),
];

fn frame(keys: &[u8]) -> Vec<u8> {
    let (bytes, len) = FrameFormat::default().encode(set(keys));
    bytes[..len].to_vec()
}

#[test]
fn frames_are_those_of_the_reference() {
    assert_eq!(Check::Crc8.over(b"123456789"), 0xF4);
    for (keys, text) in VECTORS {
        assert_eq!(hex(&frame(keys)), *text, "{keys:?}");
        let mut reader = FrameReader::new(FrameFormat::default());
        let found: Vec<_> = frame(keys).into_iter().filter_map(|b| reader.feed(b)).collect();
        assert_eq!(found, [Received::Keys(set(keys))]);
    }
}

/// Each single wrong bit is found, and the frame after it is read.
#[test]
fn a_wrong_bit_loses_its_frame_alone() {
    for bit in 0..64 {
        let mut bytes = frame(&[1, 9]);
        bytes[bit / 8] ^= 1 << (bit % 8);
        bytes.extend(frame(&[40]));
        bytes.extend(frame(&[48]));
        let mut reader = FrameReader::new(FrameFormat::default());
        let found: Vec<_> = bytes.into_iter().filter_map(|b| reader.feed(b)).collect();
        let bad = found.iter().filter(|r| **r == Received::Bad).count();
        assert!(bad >= 1, "bit {bit}");
        assert!(!found.contains(&Received::Keys(set(&[1, 9]))), "bit {bit}");
        assert_eq!(found.last(), Some(&Received::Keys(set(&[48]))), "bit {bit}");
    }
}

#[test]
fn frames_follow_each_other_after_lost_bytes() {
    for lost in 0..8 {
        let mut bytes = frame(&[5]);
        bytes.remove(lost);
        for key in 1..4 {
            bytes.extend(frame(&[key]));
        }
        let mut reader = FrameReader::new(FrameFormat::default());
        let found: Vec<_> = bytes.into_iter().filter_map(|b| reader.feed(b)).collect();
        // Only the damaged frame is lost: the header of the next one ends it.
        let good = (1..4).map(|key| Received::Keys(set(&[key])));
        let read = found.iter().copied().filter(|r| *r != Received::Bad);
        assert!(read.eq(good), "byte {lost}: {found:?}");
    }
}

#[test]
fn bytes_without_a_header_and_half_frames_are_counted() {
    let mut reader = FrameReader::new(FrameFormat::default());
    let bad = [0x55; 24].into_iter().filter_map(|b| reader.feed(b)).count();
    assert_eq!(bad, 3);
    assert!(!reader.silence());
    frame(&[1]).into_iter().take(5).for_each(|b| assert_eq!(reader.feed(b), None));
    assert!(reader.silence());
    let found: Vec<_> = frame(&[2]).into_iter().filter_map(|b| reader.feed(b)).collect();
    assert_eq!(found, [Received::Keys(set(&[2]))]);
}

#[test]
fn other_formats_are_read_back_and_wrong_ones_refused() {
    let format = FrameFormat::new(0x7E, 5, Check::Xor, &[23, 0, 8]).unwrap();
    let (bytes, len) = format.encode(set(&[1, 3]));
    assert_eq!(hex(&bytes[..len]), "7E 00 01 80 FF");
    let mut reader = FrameReader::new(format);
    let found: Vec<_> = bytes[..len].iter().filter_map(|b| reader.feed(*b)).collect();
    assert_eq!(found, [Received::Keys(set(&[1, 3]))]);
    let sum = FrameFormat::new(1, 3, Check::Sum, &[]).unwrap();
    assert_eq!((sum.keys(), hex(&sum.encode(set(&[8])).0[..3])), (8, "01 80 81".to_owned()));
    let refused =
        |header, size, map: &[i64]| FrameFormat::new(header, size, Check::Crc8, map).unwrap_err();
    assert_eq!(refused(256, 8, &[]), WrongFormat::Header(256));
    assert_eq!(refused(-1, 8, &[]), WrongFormat::Header(-1));
    assert_eq!(refused(1, 2, &[]), WrongFormat::Size(2));
    assert_eq!(refused(1, 17, &[]), WrongFormat::Size(17));
    assert_eq!(refused(1, 3, &[0, 8]), WrongFormat::Bit(2, 8, 7));
    assert_eq!(refused(1, 3, &[0, -1]), WrongFormat::Bit(2, -1, 7));
    assert_eq!(refused(1, 8, &[4, 7, 4]), WrongFormat::Twice(1, 3));
    assert_eq!(refused(1, 8, &[0; 49]), WrongFormat::Keys(49));
}

/// Runs periods; returns the keys of each as text.
fn periods(keypad: &mut Keypad, presses: &[Press], count: usize) -> String {
    let mut waiting = presses.iter().copied();
    let mut out = Vec::new();
    for _ in 0..count {
        let keys = keypad.period(KeySet::NONE, || waiting.next());
        let names: Vec<_> = keys.numbers().map(|n| n.to_string()).collect();
        out.push(if names.is_empty() { "-".to_owned() } else { names.join("+") });
    }
    out.join(" ")
}

#[test]
fn a_virtual_key_is_down_for_three_periods_and_up_for_two() {
    let presses: Vec<Press> = [1, 1, 2].into_iter().map(Press::short).collect();
    let found = periods(&mut Keypad::default(), &presses, 16);
    assert_eq!(found, "1 1 1 - - 1 1 1 - - 2 2 2 - - -");
}

/// "1234" takes 20 periods, which are 400 ms.
#[test]
fn four_keys_take_twenty_periods() {
    let presses: Vec<Press> = (1..=4).map(Press::short).collect();
    let found = periods(&mut Keypad::default(), &presses, 21);
    assert!(found.starts_with("1 1 1 - - 2 2 2 - - 3 3 3 - - 4 4 4 - - -"), "{found}");
}

#[test]
fn physical_and_virtual_keys_are_down_together() {
    let mut keypad = Keypad::default();
    keypad.physical(set(&[15]));
    // The physical keys count for three periods after their frame.
    assert_eq!(periods(&mut keypad, &[Press::short(3)], 5), "3+15 3+15 3+15 - -");
    keypad.physical(set(&[14]));
    assert_eq!(periods(&mut keypad, &[], 1), "14");
    assert_eq!(keypad.period(set(&[20]), || None), set(&[14, 20]));
}

#[test]
fn a_virtual_key_can_be_held_and_released() {
    let mut keypad = Keypad::default();
    assert_eq!(periods(&mut keypad, &[Press { key: 15, periods: 6 }], 4), "15 15 15 15");
    keypad.release();
    assert_eq!(periods(&mut keypad, &[], 2), "- -");
}

#[test]
fn lines_are_numbers_with_a_time() {
    let check = |text: &str, expected: &str| {
        let found = match line::parse(text.as_bytes(), 48, 20.0) {
            Ok(press) => format!("{} for {}", press.key, press.periods),
            Err(bad) => bad.to_string(),
        };
        assert_eq!(found, expected, "{text:?}");
    };
    check("13", "13 for 3");
    check(" 48 \r", "48 for 3");
    check("15 500", "15 for 25");
    check("15 501", "15 for 26");
    check("1 1", "1 for 1");
    check("1 10000", "1 for 500");
    check("0", "there is no such key: keys are 1 to 48");
    check("49", "there is no such key: keys are 1 to 48");
    check("99999999999", "there is no such key: keys are 1 to 48");
    check("1 0", "the time is not 1 to 10000 ms: a line is N, or N MS, such as '13' or '15 500'");
    check(
        "1 10001",
        "the time is not 1 to 10000 ms: a line is N, or N MS, such as '13' or '15 500'",
    );
    check("", "it is empty: a line is N, or N MS, such as '13' or '15 500'");
    check("one", "a word is no whole number: a line is N, or N MS, such as '13' or '15 500'");
    check("-1", "a word is no whole number: a line is N, or N MS, such as '13' or '15 500'");
    check("1.5", "a word is no whole number: a line is N, or N MS, such as '13' or '15 500'");
    check("1 2 3", "it has more than two words: a line is N, or N MS, such as '13' or '15 500'");
    check("\u{661}", "it is not ASCII text: a line is N, or N MS, such as '13' or '15 500'");
    let long = "1".repeat(33);
    check(&long, "it is longer than 32 bytes: a line is N, or N MS, such as '13' or '15 500'");
    assert!(line::parse(&[0xff, b'1'], 48, 20.0).is_err());
    assert!(line::press_for(1, 5, f64::NAN).is_err());
}

#[test]
fn an_overlong_line_ends_at_its_end() {
    let mut reader = LineReader::default();
    let text = [&[b'1'; 1000][..], b"\n13\n"].concat();
    let mut found = Vec::new();
    for byte in text {
        if let Some(line) = reader.feed(byte) {
            found.push(line.map(|len| reader.line(len).to_vec()));
        }
    }
    assert_eq!(found, [Err(line::BadLine::Long), Ok(b"13".to_vec())]);
}

#[test]
fn each_key_has_its_name() {
    assert_eq!(NAMES.len(), 29);
    for (name, number) in [("1", 1), ("0", 10), ("ok", 13), ("Stop", 14), ("X+", 15), ("SHIFT", 29)]
    {
        assert_eq!(number_of(name), Some(number), "{name}");
    }
    assert_eq!(number_of("X"), None);
}
