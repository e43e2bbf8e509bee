//! Serial lines pass nothing that is old, and a screen is whole however late its bytes are read.

use super::{MS, Scratch, frame, hardware, terminal};
use crate::{keypad::KeypadComponent, lcd_reader::LcdReader};
use hal_handheld::{FrameFormat, KeySet, st7920::row_bytes};
use rustix::termios::{ControlModes, OptionalActions, tcgetattr, tcsetattr};
use std::{
    fs::File,
    io::{ErrorKind, Read as _, Write as _},
    os::unix::fs::symlink,
};

#[test]
fn a_line_that_is_too_slow_is_refused() {
    let refused = |args: &[&str]| hardware().load::<KeypadComponent>(args).unwrap_err();
    let said = refused(&["device=/dev/null", "baud=1200", "period=20", "size=8"]);
    assert_eq!(said, "a frame of 8 bytes takes 66.7 ms at 1200 Bd, and period is 20 ms");
    let (_cable, path) = terminal();
    let args = [&format!("device={path}"), "baud=1200", "period=67"];
    hardware().load::<KeypadComponent>(&args).unwrap();
}

#[test]
fn other_wires_of_the_line_do_not_stop_it() {
    let (_cable, path) = terminal();
    let line = File::options().read(true).write(true).open(&path).unwrap();
    let mut settings = tcgetattr(&line).unwrap();
    settings.control_modes |= ControlModes::CRTSCTS | ControlModes::CSTOPB;
    tcsetattr(&line, OptionalActions::Now, &settings).unwrap();
    let mut bench = hardware();
    bench.load::<KeypadComponent>(&[&format!("device={path}")]).unwrap();
    let modes = tcgetattr(&line).unwrap().control_modes;
    assert!(!modes.intersects(ControlModes::CRTSCTS | ControlModes::CSTOPB), "{modes:?}");
}

/// The worker is held up while a key goes down and up: the controller gets the latest frame alone.
#[test]
fn frames_that_could_not_leave_are_replaced() {
    let (mut cable, path) = terminal();
    let mut bench = hardware();
    bench.load::<KeypadComponent>(&[&format!("device={path}")]).unwrap();
    bench.set("keypad.key-15", true);
    for _ in 0..600 {
        bench.run("keypad.update", 20 * MS);
    }
    bench.set("keypad.key-15", false);
    bench.run("keypad.update", 20 * MS);
    bench.work("keypad.line", 64).unwrap();
    let mut sent = [0; 4096];
    assert_eq!(cable.read(&mut sent).unwrap(), 8);
    assert_eq!(sent[..8], FrameFormat::default().encode(KeySet::NONE).0[..8]);
}

/// Keys that were pressed while the function stood still press nothing when it runs again.
#[test]
fn keys_from_before_a_pause_are_dropped() {
    let (mut cable, path) = terminal();
    let mut bench = hardware();
    bench.load::<KeypadComponent>(&[&format!("device={path}")]).unwrap();
    cable.write_all(&frame(21)).unwrap();
    bench.work("keypad.line", 64).unwrap();
    bench.pass(70 * MS);
    bench.run("keypad.update", 20 * MS);
    assert!(!bench.get::<bool>("keypad.physical") && !bench.get::<bool>("keypad.down-21"));
    cable.write_all(&frame(13)).unwrap();
    bench.work("keypad.line", 64).unwrap();
    bench.pass(10 * MS);
    bench.run("keypad.update", 20 * MS);
    assert!(bench.get::<bool>("keypad.down-13"));
}

/// The worker is held up between the halves of a screen: the first half is no screen.
#[test]
fn a_screen_that_is_read_late_is_whole() {
    let (mut bus, path) = terminal();
    let mut bench = hardware();
    bench.load::<LcdReader>(&[&format!("device={path}"), "find=RUN,IDLE"]).unwrap();
    let run = |bench: &hal_bench::Bench, ms: u32| {
        for _ in 0..ms {
            bench.pass(MS);
            bench.run("lcd.update", MS);
        }
        bench.get::<u32>("lcd.screens")
    };
    let bytes = row_bytes(0, b"IDLE WAS RUN    ");
    let (first, second) = bytes.split_at(bytes.len() / 2);
    bus.write_all(first).unwrap();
    bench.work("lcd.line", 64).unwrap();
    bus.write_all(second).unwrap();
    assert_eq!(run(&bench, 50), 0, "nobody has looked at the bus");
    bench.work("lcd.line", 64).unwrap();
    assert_eq!(run(&bench, 1), 0);
    // A look that finds nothing, too early and late enough.
    bench.work("lcd.line", 64).unwrap();
    assert_eq!(run(&bench, 4), 0);
    bench.work("lcd.line", 64).unwrap();
    assert_eq!(run(&bench, 1), 1);
    assert!(bench.get::<bool>("lcd.found-0") && bench.get::<bool>("lcd.found-1"));
}

/// An adapter is pulled, and plugged in again under the same name.
#[test]
fn a_device_that_has_gone_is_opened_again() {
    let scratch = Scratch::new("gone");
    let path = scratch.path("tty");
    let plug = || {
        let (cable, own) = terminal();
        symlink(own, &path).unwrap();
        cable
    };
    let mut cable = plug();
    let mut bench = hardware();
    bench.load::<KeypadComponent>(&[&format!("device={path}")]).unwrap();
    let run = |periods: u32| {
        for _ in 0..periods {
            bench.pass(20 * MS);
            bench.work("keypad.line", 64).unwrap();
            bench.run("keypad.update", 20 * MS);
        }
        bench.get::<bool>("keypad.down-14")
    };
    cable.write_all(&frame(14)).unwrap();
    assert!(run(1));
    drop(cable);
    std::fs::remove_file(&path).unwrap();
    assert!(!run(200), "keys of a handheld that has gone are up");
    assert!(bench.said().len() == 1, "{:?}", bench.said());
    let mut cable = plug();
    // The next attempt is at most a second later.
    run(51);
    cable.write_all(&frame(14)).unwrap();
    // Read in one period, and sent on in the next.
    assert!(run(2));
    // The kernel delivers the latest bytes to a read that finds no others.
    let mut sent = Vec::new();
    assert_eq!(cable.read_to_end(&mut sent).unwrap_err().kind(), ErrorKind::WouldBlock);
    let (none, own) = (frame(0), frame(14));
    let frames: Vec<&[u8]> = sent.chunks(8).collect();
    let last = frames.len() - 1;
    assert!(frames[..last].iter().all(|f| *f == none) && frames[last] == own, "{frames:?}");
    let said = bench.said();
    assert!(said.len() == 1 && said[0].contains("passes bytes again"), "{said:?}");
    assert_eq!(bench.get::<u32>("keypad.bad-frames"), 0);
}
