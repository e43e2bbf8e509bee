//! The decoder of the display, and readers of its screens.
#![expect(clippy::unwrap_used, clippy::indexing_slicing, reason = "tests")]

use hal_handheld::{
    Decode, RECORD_LEN, ScreenReader, Screens, St7920, TEXT_LEN,
    screen::{QUIET_NS, row},
    st7920::{command_bytes, row_bytes},
};

const VECTOR: [u8; 23] = [
    0xF8, 0x00, 0x10, 0xF8, 0x90, 0x00, 0xFA, 0x50, 0x80, 0x30, 0xA0, 0x30, 0x10, 0x30, 0x20, 0x30,
    0x30, 0x20, 0xE0, 0x30, 0x40, 0x30, 0x50,
];

fn text_of(bytes: &[u8]) -> (String, u32) {
    let mut display = St7920::default();
    bytes.iter().for_each(|b| display.feed(*b));
    (String::from_utf8(display.text().to_vec()).unwrap(), display.errors())
}

#[test]
fn the_vector_of_the_reference_is_in_row_two() {
    let (text, errors) = text_of(&VECTOR);
    assert_eq!((&text[16..32], errors), ("X:123.45        ", 0));
    assert_eq!(text.replace(' ', ""), "X:123.45");
}

/// The stream may be cut anywhere, and quiet before the end shows no half screen.
#[test]
fn a_stream_cut_at_every_byte_gives_the_same_screen() {
    for cut in 0..VECTOR.len() {
        let mut screens = Screens::new(St7920::default(), QUIET_NS);
        let (first, rest) = VECTOR.split_at(cut);
        assert!(!screens.feed(first, 0));
        assert!(!screens.feed(rest, QUIET_NS - 1), "cut at {cut}");
        assert!(!screens.poll(2 * QUIET_NS - 2), "cut at {cut}");
        assert!(screens.poll(2 * QUIET_NS), "cut at {cut}");
        assert_eq!(row(screens.text(), 1), b"X:123.45        ");
        assert_eq!(screens.decoder().errors(), 0, "cut at {cut}");
        assert!(!screens.poll(i64::MAX), "the same screen is not new");
    }
}

#[test]
fn rows_are_drawn_where_they_are_shown() {
    let mut bytes = Vec::new();
    for (n, text) in
        [b"the first row   ", b"row 2           ", b"3               ", b"            four"]
            .into_iter()
            .enumerate()
    {
        bytes.extend(row_bytes(n, text));
    }
    let (text, errors) = text_of(&bytes);
    assert_eq!(text, "the first row   row 2           3                           four");
    assert_eq!(errors, 0);
}

fn data(text: &[u8]) -> Vec<u8> {
    [0xFA].into_iter().chain(text.iter().flat_map(|c| [c & 0xF0, c << 4])).collect()
}

#[test]
fn commands_do_what_the_data_sheet_says() {
    let check = |parts: &[Vec<u8>], expected: &str| {
        let (text, errors) = text_of(&parts.concat());
        assert_eq!((text.trim_end(), errors), (expected, 0));
    };
    let command = |c: u8| command_bytes(c).to_vec();
    // Clear blanks and goes home; home alone keeps the text.
    check(&[data(b"abcd"), command(0x01), data(b"ef")], "ef");
    check(&[data(b"abcd"), command(0x02), data(b"ef")], "efcd");
    // Backwards, word by word.
    check(&[command(0x04), command(0x81), data(b"abcd")], "cdab");
    // Glyphs go elsewhere, until an address of the display.
    check(&[command(0x40), data(b"abcd"), command(0x80), data(b"ef")], "ef");
    // In the extended set everything is ignored until the set is left.
    check(&[command(0x24), command(0x01), data(b"ab"), command(0x20), data(b"cd")], "cd");
    // Display on, cursor, shifts and function set change no text.
    check(&[data(b"ab"), command(0x0C), command(0x14), command(0x30), data(b"cd")], "abcd");
    // Characters outside ASCII.
    check(&[data(&[b'a', 0x80, 0xFF, 0x03, b'b'])], "a???b");
    // Words beyond the display are not shown.
    check(&[command(0xA0), data(b"ab"), command(0x80), data(b"c")], "c");
    // A reading controller clocks bytes that are no data.
    check(&[vec![0xFC, 0x12, 0x34, 0x51], data(b"ab")], "ab");
    // The text goes on in row 3 after row 1, and wraps after the last word.
    check(&[command(0x87), data(b"abc")], &format!("{:14}ab{:16}c", "", ""));
    check(&[command(0xBF), data(b"xyab")], "ab");
}

#[test]
fn garbage_is_counted_and_ends_at_the_next_sync_byte() {
    let mut display = St7920::default();
    [0x12, 0x00, 0xFA, 0x61].into_iter().for_each(|b| display.feed(b));
    assert_eq!(display.errors(), 3);
    // Everything is lost until a sync byte.
    [0x60, 0x10].into_iter().for_each(|b| display.feed(b));
    assert_eq!(display.errors(), 5);
    // A sync byte between two halves.
    [0xFA, 0x60].into_iter().chain(data(b"ok")).for_each(|b| display.feed(b));
    assert_eq!((display.errors(), &display.text()[..2]), (6, &b"ok"[..]));
}

/// Random bytes, over all of which the decoder has only characters that can be shown.
#[test]
fn random_bytes_leave_a_text() {
    let mut seed = 1_u64;
    let mut display = St7920::default();
    for _ in 0..200_000 {
        seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        display.feed(seed.to_be_bytes()[0]);
    }
    assert!(display.text().iter().all(|c| (b' '..=b'~').contains(c)));
    assert!(display.errors() > 1000 && display.frames() > 1000);
}

fn record(reader: &mut ScreenReader, screens: &Screens<St7920>, most: usize) -> Vec<u8> {
    let bytes = reader.next(screens.text(), screens.number());
    let bytes = bytes[..bytes.len().min(most)].to_vec();
    reader.took(bytes.len());
    bytes
}

#[test]
fn a_record_has_the_text_and_the_readers_counter() {
    let mut screens = Screens::new(St7920::default(), QUIET_NS);
    screens.feed(&VECTOR, 0);
    screens.poll(QUIET_NS);
    let mut reader = ScreenReader::default();
    let bytes = record(&mut reader, &screens, usize::MAX);
    assert_eq!((bytes.len(), RECORD_LEN), (71, 71));
    assert_eq!(&bytes[..TEXT_LEN], screens.text());
    assert_eq!(&bytes[TEXT_LEN..], b"00000\r\n");
    assert!(record(&mut reader, &screens, usize::MAX).is_empty(), "nothing newer");
}

/// Three readers at different speeds: each has whole screens, and a counter without gaps.
#[test]
fn readers_have_counters_of_their_own() {
    let mut screens = Screens::new(St7920::default(), QUIET_NS);
    let mut readers = [1_u32, 3, 7].map(|every| (every, ScreenReader::default(), Vec::new()));
    for n in 0_u32..200 {
        let now = i64::from(n) * 20_000_000;
        let text = format!("{n:016}");
        for line in 0..4 {
            // A row in each millisecond: the screen is whole after the fourth.
            let bytes = row_bytes(line, text.as_bytes().try_into().unwrap());
            screens.feed(&bytes, now + i64::try_from(line).unwrap() * 1_000_000);
        }
        screens.poll(now + 15_000_000);
        for (every, reader, read) in &mut readers {
            if n % *every == 0 {
                // Short reads: a record in three parts.
                for most in [10, 50, 100] {
                    read.extend(record(reader, &screens, most));
                }
            }
        }
    }
    for (every, _, read) in &readers {
        assert_eq!(read.len() % RECORD_LEN, 0);
        let records: Vec<&[u8]> = read.chunks(RECORD_LEN).collect();
        assert_eq!(records.len(), 200_usize.div_ceil(*every as usize));
        for (n, record) in records.iter().enumerate() {
            assert_eq!(&record[TEXT_LEN..], format!("{n:05}\r\n").as_bytes());
            let rows: Vec<&[u8]> = record[..TEXT_LEN].chunks(16).collect();
            assert!(rows.iter().all(|r| *r == rows[0]), "half a screen");
        }
    }
}

#[test]
fn a_counter_begins_again_after_99999() {
    let mut reader = ScreenReader::default();
    let text = [b'x'; TEXT_LEN];
    for number in 1..=100_001_u64 {
        let len = reader.next(&text, number).len();
        if number == 100_000 {
            assert_eq!(&reader.next(&text, number)[TEXT_LEN..], b"99999\r\n");
        }
        reader.took(len);
    }
    assert_eq!(reader.counter(), 1);
}
