//! Modbus. The frames of the table are the examples of the Modbus application protocol, version 1.1b3, chapter 6.

use super::hex;
use crate::{
    Call, Exception, Miss, ModbusAnswer, ModbusRequest, ModbusTable, char_ns, find_rtu, find_tcp,
    push_crc, silence_ns,
};
use hal_bench::Random;
use rmodbus::{
    ModbusProto,
    server::{ModbusFrame, context::ModbusContext as _, storage::ModbusStorageSmall},
};

fn read(table: ModbusTable, first: u16, count: u16) -> Call {
    Call::Read { table, first, count }
}

/// Returns calls with function and data of their requests and answers, and what these mean.
fn examples() -> Vec<(Call, &'static str, &'static str, ModbusAnswer)> {
    let bits = |text: &str| ModbusAnswer::Bits(text.chars().map(|c| c == '1').collect());
    vec![
        (
            read(ModbusTable::Coils, 19, 19),
            "01 0013 0013",
            "01 03 CD 6B 05",
            bits("1011001111010110101"),
        ),
        (
            read(ModbusTable::Discretes, 196, 22),
            "02 00C4 0016",
            "02 03 AC DB 35",
            bits("0011010111011011101011"),
        ),
        (
            read(ModbusTable::Holding, 107, 3),
            "03 006B 0003",
            "03 06 02 2B 00 00 00 64",
            ModbusAnswer::Words(vec![555, 0, 100]),
        ),
        (
            read(ModbusTable::Inputs, 8, 1),
            "04 0008 0001",
            "04 02 00 0A",
            ModbusAnswer::Words(vec![10]),
        ),
        (
            Call::WriteCoil { at: 172, on: true },
            "05 00AC FF00",
            "05 00AC FF00",
            ModbusAnswer::Written,
        ),
        (
            Call::WriteRegister { at: 1, value: 3 },
            "06 0001 0003",
            "06 0001 0003",
            ModbusAnswer::Written,
        ),
        (
            Call::WriteCoils { first: 19, on: "1011001110".chars().map(|c| c == '1').collect() },
            "0F 0013 000A 02 CD 01",
            "0F 0013 000A",
            ModbusAnswer::Written,
        ),
        (
            Call::WriteRegisters { first: 1, values: vec![10, 0x0102] },
            "10 0001 0002 04 000A 0102",
            "10 0001 0002",
            ModbusAnswer::Written,
        ),
        (
            read(ModbusTable::Coils, 0x04A1, 1),
            "01 04A1 0001",
            "81 02",
            ModbusAnswer::Refused(Exception(2)),
        ),
    ]
}

/// Returns the bytes of a text in which some stand together.
fn bytes(text: &str) -> Vec<u8> {
    let digits: String = text.split_whitespace().collect();
    let spaced: Vec<String> =
        digits.as_bytes().chunks(2).map(|c| String::from_utf8(c.to_vec()).unwrap()).collect();
    hex(&spaced.join(" "))
}

fn rtu(unit: u8, text: &str) -> Vec<u8> {
    let mut frame = vec![unit];
    frame.extend(bytes(text));
    push_crc(&mut frame);
    frame
}

fn tcp(transaction: u16, unit: u8, text: &str) -> Vec<u8> {
    let data = bytes(text);
    let mut frame = transaction.to_be_bytes().to_vec();
    frame.extend([0, 0, 0, data.len() as u8 + 1, unit]);
    frame.extend(data);
    frame
}

#[test]
fn examples_of_the_standard_on_both_lines() {
    for (call, asked, answered, wanted) in examples() {
        let request = ModbusRequest { unit: 17, call };
        assert_eq!(request.rtu().unwrap(), rtu(17, asked), "{request:?}");
        assert_eq!(request.tcp(0x1501).unwrap(), tcp(0x1501, 17, asked), "{request:?}");
        let answer = rtu(17, answered);
        assert_eq!(find_rtu(&request, &answer), Some(wanted.clone()), "{request:?}");
        for cut in 0..answer.len() {
            assert_eq!(find_rtu(&request, &answer[..cut]), None, "half an answer");
        }
        let mut noisy = hex("00 FF 11 80 81 FE");
        noisy.extend(&answer);
        noisy.push(0);
        assert_eq!(find_rtu(&request, &noisy), Some(wanted.clone()));
        assert_eq!(find_rtu(&request, &rtu(18, answered)), None, "another device");
        assert_eq!(Miss::of_rtu(&request, &rtu(18, answered)), Miss::Other(18));
        // A late answer to an earlier request, and then its own in two pieces.
        let mut stream = tcp(0x1500, 17, "03 02 00 00");
        stream.extend(tcp(0x1501, 17, answered));
        assert_eq!(find_tcp(&request, 0x1501, &stream), Ok(Some(wanted)));
        for cut in 0..stream.len() {
            assert_eq!(find_tcp(&request, 0x1501, &stream[..cut]), Ok(None));
        }
        let other = find_tcp(&request, 1, &tcp(1, 18, answered));
        assert_eq!(other, Err(Miss::Other(18)));
    }
}

#[test]
fn a_frame_on_the_line_has_its_published_check_sum() {
    // Read of ten registers from 0 of device 1: the most printed of all frames.
    let request = ModbusRequest { unit: 1, call: read(ModbusTable::Holding, 0, 10) };
    assert_eq!(request.rtu().unwrap(), hex("01 03 00 00 00 0A C5 CD"));
}

#[test]
fn a_frame_is_found_anywhere_in_noise() {
    let request = ModbusRequest { unit: 9, call: read(ModbusTable::Holding, 0, 1) };
    let mut random = Random::new(7);
    for (length, wanted) in
        [(4, Miss::Noise), (5, Miss::Other(7)), (256, Miss::Other(7)), (257, Miss::Noise)]
    {
        let mut frame: Vec<u8> = vec![7; length - 2];
        push_crc(&mut frame);
        assert_eq!(Miss::of_rtu(&request, &frame), wanted, "{length}");
    }
    for _ in 0..10_000 {
        let mut bytes: Vec<u8> = (0..random.below(20)).map(|_| random.word() as u8).collect();
        if random.below(2) == 0 {
            push_crc(&mut bytes);
        }
        let frames = (0..bytes.len())
            .find(|at| (at + 5..=bytes.len()).any(|end| crate::is_whole(&bytes[*at..end])));
        let wanted = match frames {
            _ if bytes.is_empty() => Miss::Silent,
            Some(at) if bytes[at] == 9 => Miss::Wrong,
            Some(at) => Miss::Other(bytes[at]),
            None => Miss::Noise,
        };
        assert_eq!(Miss::of_rtu(&request, &bytes), wanted, "{bytes:x?}");
    }
}

#[test]
fn answers_of_other_lengths_addresses_and_values_are_refused() {
    for (call, wrong) in [
        (read(ModbusTable::Holding, 0, 2), "03 02 00 01"),
        (read(ModbusTable::Holding, 0, 2), "03 04 00 01 00 02 00 03"),
        (read(ModbusTable::Holding, 0, 1), "03 04 00 01"),
        (read(ModbusTable::Holding, 0, 1), "04 02 00 01"),
        (read(ModbusTable::Coils, 0, 9), "01 01 FF"),
        (Call::WriteCoil { at: 5, on: true }, "05 0005 0000"),
        (Call::WriteRegister { at: 5, value: 1 }, "06 0006 0001"),
        (Call::WriteRegisters { first: 5, values: vec![1, 2] }, "10 0005 0001"),
    ] {
        let request = ModbusRequest { unit: 1, call };
        let answer = rtu(1, wrong);
        assert_eq!(find_rtu(&request, &answer), None, "{request:?}");
        assert_eq!(Miss::of_rtu(&request, &answer), Miss::Wrong, "{request:?}");
        assert_eq!(find_tcp(&request, 1, &tcp(1, 1, wrong)), Err(Miss::Wrong), "{request:?}");
    }
    let request = ModbusRequest { unit: 1, call: read(ModbusTable::Holding, 0, 1) };
    for broken in ["0001 0001 0005 01", "0001 0000 0002 01", "0001 0000 0100 01"] {
        assert_eq!(find_tcp(&request, 1, &bytes(broken)), Err(Miss::Noise), "{broken}");
    }
}

#[test]
fn too_many_elements_are_refused_in_words() {
    for (call, text) in [
        (read(ModbusTable::Coils, 0, 2001), "2001 elements in one request: 1 to 2000 are possible"),
        (read(ModbusTable::Inputs, 0, 126), "126 elements in one request: 1 to 125 are possible"),
        (read(ModbusTable::Holding, 0, 0), "0 elements in one request: 1 to 125 are possible"),
        (
            Call::WriteCoils { first: 0, on: vec![true; 1969] },
            "1969 elements in one request: 1 to 1968 are possible",
        ),
        (
            Call::WriteRegisters { first: 0, values: vec![0; 124] },
            "124 elements in one request: 1 to 123 are possible",
        ),
    ] {
        let request = ModbusRequest { unit: 1, call };
        assert_eq!(request.rtu().unwrap_err().to_string(), text);
        assert_eq!(request.tcp(1).unwrap_err().to_string(), text);
    }
    let longest = ModbusRequest { unit: 1, call: read(ModbusTable::Coils, 0, 2000) };
    let mut answer = vec![1, 1, 250];
    answer.extend([0xFF; 250]);
    push_crc(&mut answer);
    assert_eq!(find_rtu(&longest, &answer), Some(ModbusAnswer::Bits(vec![true; 2000])));
}

#[test]
fn exceptions_are_named() {
    for (code, words) in [
        (1, "the device refuses: it does not know this function (exception 1)"),
        (2, "the device refuses: it has no such address (exception 2)"),
        (11, "the device refuses: the gateway has no answer of it (exception 11)"),
        (99, "the device refuses: its maker knows the reason (exception 99)"),
    ] {
        assert_eq!(Exception(code).to_string(), words);
    }
}

#[test]
fn silences_are_those_of_the_standard() {
    assert_eq!(char_ns(9600, 10), 1_041_666);
    assert_eq!(silence_ns(9600, 11), 4_010_415);
    assert_eq!(silence_ns(115_200, 10), 1_750_000);
    assert!(0 < silence_ns(0, 10));
}

/// Returns a random request within the standard.
fn any(random: &mut Random) -> ModbusRequest {
    let first = random.below(400) as u16;
    let count = 1 + random.below(100) as u16;
    let bits = |random: &mut Random| (0..count).map(|_| random.below(2) == 1).collect();
    let words = |random: &mut Random| (0..count).map(|_| random.word() as u16).collect();
    let call = match random.below(8) {
        0 => read(ModbusTable::Coils, first, count),
        1 => read(ModbusTable::Discretes, first, count),
        2 => read(ModbusTable::Holding, first, count),
        3 => read(ModbusTable::Inputs, first, count),
        4 => Call::WriteCoil { at: first, on: random.below(2) == 1 },
        5 => Call::WriteRegister { at: first, value: random.word() as u16 },
        6 => Call::WriteCoils { first, on: bits(random) },
        _ => Call::WriteRegisters { first, values: words(random) },
    };
    ModbusRequest { unit: 1 + random.below(247) as u8, call }
}

#[test]
fn the_devices_of_another_library_understand_and_are_understood() {
    let mut random = Random::new(3);
    let mut storage = ModbusStorageSmall::new();
    for n in 0..20_000_u32 {
        let request = any(&mut random);
        let is_tcp = n % 2 == 0;
        let (frame, proto) = match is_tcp {
            true => (request.tcp(n as u16).unwrap(), ModbusProto::TcpUdp),
            false => (request.rtu().unwrap(), ModbusProto::Rtu),
        };
        let mut answer = Vec::new();
        let mut theirs = ModbusFrame::new(request.unit, &frame, proto, &mut answer);
        theirs.parse().unwrap();
        assert!(theirs.processing_required && theirs.response_required, "{request:?}");
        match theirs.readonly {
            true => theirs.process_read(&storage).unwrap(),
            false => theirs.process_write(&mut storage).unwrap(),
        }
        theirs.finalize_response().unwrap();
        let found = match is_tcp {
            true => find_tcp(&request, n as u16, &answer).unwrap(),
            false => find_rtu(&request, &answer),
        };
        match (found.unwrap(), &request.call) {
            (ModbusAnswer::Written, Call::WriteRegister { at, value }) => {
                assert_eq!(storage.get_holding(*at), Ok(*value));
            }
            (ModbusAnswer::Written, Call::WriteRegisters { first, values }) => {
                let mut theirs = Vec::new();
                storage.get_holdings_bulk(*first, values.len() as u16, &mut theirs).unwrap();
                assert_eq!(&theirs, values);
            }
            (ModbusAnswer::Written, Call::WriteCoil { at, on }) => {
                assert_eq!(storage.get_coil(*at), Ok(*on));
            }
            (ModbusAnswer::Written, Call::WriteCoils { first, on }) => {
                let mut theirs = Vec::new();
                storage.get_coils_bulk(*first, on.len() as u16, &mut theirs).unwrap();
                assert_eq!(&theirs, on);
            }
            (ModbusAnswer::Words(words), Call::Read { table, first, count }) => {
                let mut theirs = Vec::new();
                match table {
                    ModbusTable::Holding => storage.get_holdings_bulk(*first, *count, &mut theirs),
                    _ => storage.get_inputs_bulk(*first, *count, &mut theirs),
                }
                .unwrap();
                assert_eq!(words, theirs);
            }
            (ModbusAnswer::Bits(bits), Call::Read { table, first, count }) => {
                let mut theirs = Vec::new();
                match table {
                    ModbusTable::Coils => storage.get_coils_bulk(*first, *count, &mut theirs),
                    _ => storage.get_discretes_bulk(*first, *count, &mut theirs),
                }
                .unwrap();
                assert_eq!(bits, theirs);
            }
            (found, call) => panic!("{call:?}: {found:?}"),
        }
    }
}

#[test]
fn a_million_random_frames_are_read_without_a_panic() {
    let mut random = Random::new(11);
    let (mut found, mut refused) = (0_u32, 0_u32);
    for n in 0..500_000 {
        let mut request = any(&mut random);
        request.unit = 1 + random.below(4) as u8;
        let mut bytes: Vec<u8> = (0..random.below(40)).map(|_| random.word() as u8).collect();
        // Half of them look like answers.
        if n % 2 == 0 && 3 <= bytes.len() {
            (bytes[0], bytes[1]) = (request.unit, request.function() | (n % 4 * 0x40) as u8);
            if n % 8 == 0 {
                push_crc(&mut bytes);
            }
        }
        found += u32::from(find_rtu(&request, &bytes).is_some());
        assert_ne!(Miss::of_rtu(&request, &bytes) == Miss::Silent, !bytes.is_empty());
        if n % 3 == 0 && 6 <= bytes.len() {
            let length = bytes.len() - 6;
            bytes[..6].copy_from_slice(&[0, 1, 0, 0, 0, length as u8]);
        }
        refused += u32::from(find_tcp(&request, 1, &bytes).is_err());
    }
    assert!(100 < refused, "{found} {refused}");
}
