//! Huanyang's inverters. The frames were recorded between LinuxCNC's `hy_vfd` and a device that answers.

use super::hex;
use crate::{
    Miss,
    huanyang::{self, Ask, find, miss},
    push_crc,
};
use hal_bench::Random;

/// Request, its frame, an answer, and the value in it.
const RECORDED: &[(Ask, &str, &str, u16)] = &[
    (Ask::Setting(5), "01 01 03 05 00 00 2c 4f", "01 01 03 05 9c 40 44 bf", 40000),
    (Ask::Setting(11), "01 01 03 0b 00 00 4d 8c", "01 01 03 0b 2e e0 51 a4", 12000),
    (Ask::Setting(141), "01 01 03 8d 00 00 ac 65", "01 01 03 8d 00 dc ad fc", 220),
    (Ask::Setting(144), "01 01 03 90 00 00 3c 63", "01 01 03 90 05 a0 3f 4b", 1440),
    (Ask::Measured(0), "01 04 01 00 41 89", "01 04 03 00 2e e0 ec 66", 12000),
    (Ask::Measured(4), "01 04 01 04 40 4a", "01 04 03 04 0c 1c b5 46", 3100),
    (Ask::Measured(7), "01 04 01 07 00 4b", "01 04 03 07 01 36 c0 09", 310),
    (Ask::Frequency(12000), "01 05 02 2e e0 a4 e4", "01 05 02 2e e0 a4 e4", 12000),
    (Ask::Frequency(40000), "01 05 02 9c 40 d0 3c", "01 05 02 9c 40 d0 3c", 40000),
    (Ask::Control(huanyang::STOP), "01 03 01 08 f1 8e", "01 03 01 00 f0 48", 0),
    (Ask::Control(huanyang::RUN_FORWARD), "01 03 01 01 31 88", "01 03 01 09 30 4e", 9),
    (Ask::Control(huanyang::RUN_REVERSE), "01 03 01 11 30 44", "01 03 01 2d 30 55", 0x2d),
];

#[test]
fn frames_are_those_of_linuxcnc() {
    for (ask, request, answer, value) in RECORDED {
        assert_eq!(ask.frame(1), hex(request), "{ask:?}");
        assert_eq!(find(1, *ask, &hex(answer)), Some(*value), "{ask:?}");
    }
}

#[test]
fn each_answer_belongs_to_its_request_alone() {
    for (n, (ask, ..)) in RECORDED.iter().enumerate() {
        for (m, (_, _, answer, _)) in RECORDED.iter().enumerate() {
            let answer = hex(answer);
            // The states after all commands have the same form.
            let same = n == m || matches!((n, m), (9..=11, 9..=11));
            assert_eq!(find(1, *ask, &answer).is_some(), same, "{ask:?} {answer:x?}");
            assert_eq!(find(2, *ask, &answer), None);
            for cut in 0..answer.len() {
                assert_eq!(find(1, *ask, &answer[..cut]), None, "half an answer");
            }
        }
    }
}

#[test]
fn an_answer_is_found_in_noise() {
    let mut random = Random::new(7);
    for (ask, _, answer, value) in RECORDED {
        let mut bytes: Vec<u8> =
            (0..random.below(40)).map(|_| random.word() as u8 | 0x80).collect();
        bytes.extend(hex(answer));
        bytes.extend((0..random.below(9)).map(|_| random.word() as u8));
        assert_eq!(find(1, *ask, &bytes), Some(*value), "{bytes:x?}");
    }
}

#[test]
fn an_answer_to_another_frequency_is_wrong() {
    let late = huanyang::frame(1, 5, &[0x2E, 0xE0]);
    assert_eq!(find(1, Ask::Frequency(40_000), &late), None);
    assert_eq!(miss(1, &late), Miss::Wrong);
    // Which setting does not take its value is for the caller to say.
    assert_eq!(find(1, Ask::Write(5, 7), &huanyang::frame(1, 2, &[5, 0, 8])), Some(8));
}

#[test]
fn a_setting_of_one_byte_is_read() {
    let frame = huanyang::frame(1, 1, &[143, 2]);
    assert_eq!(find(1, Ask::Setting(143), &frame), Some(2));
}

#[test]
fn what_came_instead_has_a_name() {
    let other = huanyang::frame(2, 4, &[1, 0, 0]);
    let wrong = huanyang::frame(1, 4, &[1, 0, 0, 0]);
    for (bytes, wanted) in [
        (&[][..], Miss::Silent),
        (&other, Miss::Other(2)),
        (&wrong, Miss::Wrong),
        (&other[..4], Miss::Noise),
        (&[0x55; 20], Miss::Noise),
    ] {
        assert_eq!(miss(1, bytes), wanted, "{bytes:x?}");
    }
}

#[test]
fn a_million_random_frames_are_read_without_a_panic() {
    let mut random = Random::new(42);
    let (mut found, mut other) = (0_u32, 0_u32);
    for n in 0..500_000 {
        let length = random.below(14) as usize;
        let mut bytes: Vec<u8> = (0..length).map(|_| random.word() as u8).collect();
        if n % 2 == 0 && 3 <= length {
            (bytes[0], bytes[1], bytes[2]) = (1, 1 + (n / 2 % 6) as u8, (length - 3) as u8);
            push_crc(&mut bytes);
        }
        for (ask, ..) in RECORDED {
            found += u32::from(find(1, *ask, &bytes).is_some());
        }
        other += u32::from(miss(1, &bytes) == Miss::Wrong);
    }
    assert!(1000 < found && 100_000 < other, "{found} {other}");
}
