//! Smart serial: the port's processor, discovery, and process data.

use crate::bench::Bench;
use hal_card::{Remote, remotes};
use hal_firmware::registers as r;

fn user(channel: u16, nth: u16) -> u16 {
    0x5E00 + 0x100 * nth + 4 * channel
}

fn status(channel: u16) -> u16 {
    0x5D00 + 4 * channel
}

fn command(bench: &mut Bench, value: u32) -> u32 {
    bench.write(r::SERIAL_COMMAND, 0, value);
    assert_eq!(bench.read(r::SERIAL_COMMAND, 0), 0, "done");
    bench.read(r::SERIAL_DATA, 0)
}

fn remote_byte(bench: &mut Bench, channel: u16, at: u32) -> u8 {
    bench.poke(status(channel), 0x4C00_0000 | at);
    assert_eq!(command(bench, 0x1000 | 1 << channel), 0);
    bench.peek(user(channel, 0)) as u8
}

fn text(bench: &mut Bench, channel: u16, at: &mut u32) -> String {
    let mut out = String::new();
    loop {
        let byte = remote_byte(bench, channel, *at);
        *at += 1;
        if byte == 0 {
            return out;
        }
        out.push(char::from(byte));
    }
}

#[test]
fn the_processor_says_what_it_is() {
    let mut bench = Bench::new("7i92");
    let own: Vec<u32> = (0..8).map(|at| command(&mut bench, 0x2000 | at)).collect();
    assert_eq!(own, [0x12, 8, 0, 43, 0x10, 0x40, 0xD8, 4]);
    // The baud rate of each channel can be written.
    let baud = |bench: &mut Bench| -> Vec<u32> {
        (0..4).map(|at| command(bench, 0x2000 | (0x10 + 0x40 + 42 + at))).collect()
    };
    assert_eq!(baud(&mut bench), 2_500_000_u32.to_le_bytes().map(u32::from));
    bench.write(r::SERIAL_DATA, 0, 0x77);
    command(&mut bench, 0xA000 | (0x10 + 0x40 + 42));
    assert_eq!(baud(&mut bench)[0], 0x77);
    bench.write(r::SERIAL_DATA, 0, 0x77);
    command(&mut bench, 0xA000);
    assert_eq!(command(&mut bench, 0x2000), 0x12, "constants cannot");
    assert_eq!(command(&mut bench, 0xFFFF_FFFF), 0x12, "a command with bit 31 is none");
}

/// Discovery by the manual's steps finds every mode of every remote.
#[test]
fn remotes_tell_their_process_data() {
    assert_eq!(remotes().count(), 7);
    for name in remotes() {
        let mut found = 0;
        for mode in 0..4 {
            let mut bench = Bench::new("7i92");
            assert!(bench.card.plug(0, 1, Remote::named(name).unwrap()));
            bench.poke(status(1), mode << 24);
            let faults = command(&mut bench, 0x0F02);
            if faults != 0 {
                assert_eq!(faults, 2, "{name}");
                continue;
            }
            let letters = bench.peek(user(1, 1)).to_le_bytes();
            let letters = String::from_utf8(letters.to_vec()).unwrap().to_lowercase();
            assert!(name.starts_with(&letters), "{name} is {letters}");
            let mut list = bench.peek(user(1, 2)) & 0xFFFF;
            loop {
                let low = remote_byte(&mut bench, 1, list);
                let high = remote_byte(&mut bench, 1, list + 1);
                let record = u32::from(low) | u32::from(high) << 8;
                list += 2;
                if record == 0 {
                    break;
                }
                let mut at = record + 14;
                match remote_byte(&mut bench, 1, record) {
                    0xA0 => {
                        text(&mut bench, 1, &mut at);
                        let element = text(&mut bench, 1, &mut at);
                        let own = bench.card.remote(0, 1).unwrap();
                        assert_eq!(own.value(&element), Some(0), "{name}: {element}");
                        found += 1;
                    }
                    0xB0 => assert_eq!(u32::from(remote_byte(&mut bench, 1, record + 1)), mode),
                    other => panic!("{name}: record {other:x}"),
                }
            }
        }
        assert!(0 < found, "{name}");
    }
}

#[test]
fn process_data_go_both_ways() {
    let mut bench = Bench::new("7i76e");
    assert!(bench.card.plug(0, 0, Remote::named("7i76").unwrap()));
    bench.poke(status(0), 0x0200_0000);
    assert_eq!(command(&mut bench, 0x0901), 0);
    bench.poke(user(0, 0), 0x8000_A55A);
    bench.poke(user(0, 1), 0x0000_0001);
    let remote = bench.card.remote_mut(0, 0).unwrap();
    assert!(remote.set("Input", 0x1234_5678) && remote.set("AnalogIn3", 0x99));
    assert!(remote.set("FieldVoltage", 0x42) && !remote.set("Output", 1));
    assert_eq!(command(&mut bench, 0x1001), 0);
    let remote = bench.card.remote(0, 0).unwrap();
    assert_eq!(remote.value("Output"), Some(0xA55A));
    assert_eq!(remote.value("SpinOut"), Some(0x8000));
    assert_eq!((remote.value("SpinEna"), remote.value("SpinDir")), (Some(1), Some(0)));
    assert_eq!(bench.peek(user(0, 0)), 0x1234_5678);
    assert_eq!(bench.peek(user(0, 1)), 0x9900_0000);
    assert_eq!(bench.peek(user(0, 2)), 0x0000_0042);
    assert_eq!(bench.peek(status(0)), 0);
}

#[test]
fn a_remote_that_falls_out_is_a_fault_until_it_is_started_again() {
    let mut bench = Bench::new("7i76e");
    assert!(bench.card.plug(0, 0, Remote::named("7i76").unwrap()));
    assert_eq!(command(&mut bench, 0x0903), 2, "nothing is at channel 1");
    assert_eq!(bench.peek(status(1)), 0xC000);
    bench.poke(user(0, 0), 0xFFFF);
    assert_eq!(command(&mut bench, 0x1001), 0);
    bench.card.cut(0, 0, true);
    assert_eq!(command(&mut bench, 0x1001), 1);
    assert_eq!(bench.peek(status(0)) & 0x2008, 0x2008);
    // Its own watchdog switches the outputs off after 50 ms.
    bench.card.advance(50_000_000);
    assert_eq!(bench.card.remote(0, 0).unwrap().value("Output"), Some(0xFFFF));
    bench.card.advance(1_000);
    assert_eq!(bench.card.remote(0, 0).unwrap().value("Output"), Some(0));
    bench.card.cut(0, 0, false);
    assert_eq!(command(&mut bench, 0x1001), 1, "the remote's fault stays");
    assert_eq!(bench.peek(status(0)) >> 24, 1);
    assert_eq!(bench.card.remote(0, 0).unwrap().value("Output"), Some(0));
    assert_eq!(command(&mut bench, 0x0800), 0);
    assert_eq!(command(&mut bench, 0x0901), 0);
    assert_eq!(command(&mut bench, 0x1001), 0);
    assert_eq!(bench.card.remote(0, 0).unwrap().value("Output"), Some(0xFFFF));
}

#[test]
fn records_cannot_be_written() {
    let mut bench = Bench::new("7i76e");
    assert!(bench.card.plug(0, 0, Remote::named("7i76").unwrap()));
    assert_eq!(command(&mut bench, 0x0F01), 0);
    let before = remote_byte(&mut bench, 0, 0x0800);
    bench.poke(user(0, 0), 0x55);
    for at in [0x0800, 0x0400, 0x1FFF, 0xFFFF, 0] {
        bench.poke(status(0), 0x6400_0000 | at);
        assert_eq!(command(&mut bench, 0x1001), 1, "{at:x}");
    }
    assert_eq!(remote_byte(&mut bench, 0, 0x0800), before);
    bench.poke(status(0), 0x6400_0100);
    bench.poke(user(0, 0), 0x55);
    assert_eq!(command(&mut bench, 0x1001), 0);
    assert_eq!(remote_byte(&mut bench, 0, 0x0100), 0x55);
}
