//! Tests of the plugin on a bench: a pseudo-terminal as serial line and as bus, a pipe, a socket, a folder like configfs.

mod storage;

use crate::{
    keypad::KeypadComponent, lcd_reader::LcdReader, sim_handheld::SimHandheld, sim_nk105::SimNk105,
};
use hal_bench::Bench;
use hal_handheld::{FrameFormat, KeySet, RECORD_LEN, st7920::row_bytes};
use rustix::{
    fs::{OFlags, fcntl_setfl},
    pty::{OpenptFlags, grantpt, openpt, ptsname, unlockpt},
};
use std::{
    fs::File,
    io::{Read as _, Write as _},
    os::unix::net::UnixStream,
    path::PathBuf,
};

const MS: i64 = 1_000_000;

/// Folder that goes again.
struct Scratch(PathBuf);

impl Scratch {
    fn new(name: &str) -> Self {
        let path = std::env::temp_dir().join(format!("ferrule-{name}-{}", std::process::id()));
        drop(std::fs::remove_dir_all(&path));
        std::fs::create_dir_all(&path).unwrap();
        Self(path)
    }

    fn path(&self, name: &str) -> String {
        self.0.join(name).display().to_string()
    }
}

impl Drop for Scratch {
    fn drop(&mut self) {
        drop(std::fs::remove_dir_all(&self.0));
    }
}

/// Returns the end of a pseudo-terminal that stands for the hardware, and the path of the other one.
fn terminal() -> (File, String) {
    let master = openpt(OpenptFlags::RDWR | OpenptFlags::NOCTTY).unwrap();
    grantpt(&master).unwrap();
    unlockpt(&master).unwrap();
    let path = ptsname(&master, Vec::new()).unwrap().into_string().unwrap();
    fcntl_setfl(&master, OFlags::NONBLOCK).unwrap();
    (File::from(master), path)
}

fn frame(key: u8) -> Vec<u8> {
    let (bytes, len) = FrameFormat::default().encode(KeySet::of(key));
    bytes[..len].to_vec()
}

fn hardware() -> Bench {
    Bench::new().with_hardware()
}

/// Returns a keypad with a pipe, and the path of the pipe.
fn piped(name: &str) -> (Scratch, Bench, String) {
    let scratch = Scratch::new(name);
    let path = scratch.path("keys");
    let mut bench = hardware();
    bench.load::<KeypadComponent>(&[&format!("pipe={path}")]).unwrap();
    (scratch, bench, path)
}

/// Opens a pipe as a program that writes to it.
fn writer(path: &str) -> File {
    File::options().write(true).open(path).unwrap()
}

#[test]
fn frames_pass_a_serial_line_in_both_directions() {
    let (mut cable, path) = terminal();
    let mut bench = hardware();
    bench.load::<KeypadComponent>(&[&format!("device={path}"), "baud=115200"]).unwrap();
    cable.write_all(&frame(14)).unwrap();
    bench.work("keypad.line", 64).unwrap();
    bench.command("keypad.press", &["key=1"]).unwrap();
    bench.run("keypad.update", 20 * MS);
    assert!(bench.get::<bool>("keypad.down-14") && bench.get::<bool>("keypad.down-01"));
    bench.work("keypad.line", 64).unwrap();
    let mut sent = [0; 16];
    assert_eq!(cable.read(&mut sent).unwrap(), 8);
    let both = KeySet::of(1).with(KeySet::of(14));
    assert_eq!(sent[..8], FrameFormat::default().encode(both).0[..8]);
    // A wrong check byte.
    let mut bad = frame(14);
    bad[7] ^= 1;
    cable.write_all(&bad).unwrap();
    bench.work("keypad.line", 64).unwrap();
    bench.run("keypad.update", MS);
    assert_eq!(bench.get::<u32>("keypad.bad-frames"), 1);
}

#[test]
fn a_device_that_goes_is_reported_once() {
    let (cable, path) = terminal();
    let mut bench = hardware();
    bench.load::<KeypadComponent>(&[&format!("device={path}")]).unwrap();
    drop(cable);
    for _ in 0..50 {
        bench.work("keypad.line", 64).unwrap();
        bench.run("keypad.update", 20 * MS);
        bench.pass(20 * MS);
    }
    assert_eq!(bench.said(), Vec::<String>::new(), "it may be there again");
    for _ in 0..200 {
        bench.work("keypad.line", 64).unwrap();
        bench.run("keypad.update", 20 * MS);
        bench.pass(20 * MS);
    }
    let said = bench.said();
    assert!(said.len() == 1 && said[0].contains("a device has failed"), "{said:?}");
}

#[test]
fn several_programs_write_to_the_pipe() {
    let (_scratch, bench, path) = piped("pipe");
    let mut writers = [(); 3].map(|()| writer(&path));
    writers[0].write_all(b"13\n").unwrap();
    writers[1].write_all(b"15 100\n").unwrap();
    writers[2].write_all(b"what\n49\n\xff\n").unwrap();
    // A line without its end waits for the rest.
    writers[0].write_all(b"1").unwrap();
    bench.work("keypad.pipe", 64).unwrap();
    bench.run("keypad.update", MS);
    assert_eq!((bench.get::<u32>("keypad.queue"), bench.get::<u32>("keypad.bad-lines")), (2, 3));
    let said = bench.said();
    assert!(said[0].contains("no whole number") && said[1].contains("keys are 1 to"), "{said:?}");
    writers[0].write_all(b"3\n").unwrap();
    bench.work("keypad.pipe", 64).unwrap();
    bench.run("keypad.update", MS);
    assert_eq!(bench.get::<u32>("keypad.queue"), 3);
}

#[test]
fn writers_wait_while_64_presses_wait() {
    let (_scratch, bench, path) = piped("full");
    let mut writer = writer(&path);
    writer.write_all("1\n2\n".repeat(50).as_bytes()).unwrap();
    bench.work("keypad.pipe", 1000).unwrap();
    bench.run("keypad.update", MS);
    assert_eq!(bench.get::<u32>("keypad.queue"), 64);
    // Each press takes five periods: the rest comes in as there is room, and none is lost.
    let mut presses = 0;
    let mut was = [false; 2];
    for _ in 0..100 * 5 + 10 {
        bench.work("keypad.pipe", 1000).unwrap();
        bench.run("keypad.update", 20 * MS);
        let is = ["keypad.down-01", "keypad.down-02"].map(|pin| bench.get::<bool>(pin));
        presses += is.iter().zip(was).filter(|(is, was)| **is && !was).count();
        was = is;
    }
    assert_eq!((presses, bench.get::<u32>("keypad.queue")), (100, 0));
}

#[test]
fn the_screen_is_read_from_a_device_by_many_readers() {
    let scratch = Scratch::new("screen");
    let socket = scratch.path("lcd");
    let (mut bus, path) = terminal();
    let mut bench = hardware();
    let args = [format!("device={path}"), format!("socket={socket}"), "find=ROW".to_owned()];
    bench.load::<LcdReader>(&args.each_ref().map(String::as_str)).unwrap();
    let mut readers: Vec<UnixStream> =
        (0..3).map(|_| UnixStream::connect(&socket).unwrap()).collect();
    let mut draw = |bench: &Bench, text: &[u8; 16]| {
        // Split anywhere.
        for part in row_bytes(0, text).chunks(5) {
            bus.write_all(part).unwrap();
            bench.work("lcd.line", 64).unwrap();
            bench.run("lcd.update", MS);
            bench.pass(MS);
        }
        bench.pass(6 * MS);
        bench.work("lcd.line", 64).unwrap();
        bench.run("lcd.update", MS);
        bench.work("lcd.readers", 1).unwrap();
    };
    let record = |reader: &mut UnixStream| {
        let mut bytes = [0; RECORD_LEN];
        reader.read_exact(&mut bytes).unwrap();
        String::from_utf8(bytes.to_vec()).unwrap()
    };
    draw(&bench, b"FIRST ROW       ");
    assert!(bench.get::<bool>("lcd.found-0"));
    for reader in &mut readers {
        let text = record(reader);
        assert!(text.starts_with("FIRST ROW ") && text.ends_with("00000\r\n"), "{text:?}");
    }
    draw(&bench, b"ANOTHER         ");
    assert!(!bench.get::<bool>("lcd.found-0"));
    assert!(record(&mut readers[0]).ends_with("00001\r\n"));
    // One reader goes, a new one comes.
    readers.remove(1);
    readers.push(UnixStream::connect(&socket).unwrap());
    draw(&bench, b"THIRD           ");
    assert!(record(&mut readers[0]).ends_with("00002\r\n"));
    assert!(record(&mut readers[1]).starts_with("ANOTHER"));
    let text = record(&mut readers[2]);
    assert!(text.starts_with("THIRD") && text.ends_with("00000\r\n"), "{text:?}");
    assert_eq!(bench.get::<u32>("lcd.errors"), 0);
}

/// A reader that does not read loses whole screens, and the others none.
#[test]
fn a_slow_reader_delays_nobody() {
    let scratch = Scratch::new("slow");
    let socket = scratch.path("lcd");
    let mut bench = hardware();
    bench.load::<LcdReader>(&[&format!("socket={socket}")]).unwrap();
    bench.port("lcd.bus", 512);
    let bus = bench.get::<hal_component::Port>("lcd.bus");
    let mut slow = UnixStream::connect(&socket).unwrap();
    let mut fast = UnixStream::connect(&socket).unwrap();
    let mut record = [0; RECORD_LEN];
    for n in 0..6000_u32 {
        let text = format!("{n:016}");
        assert!(bus.write(&row_bytes(0, text.as_bytes().try_into().unwrap())));
        bench.run("lcd.update", MS);
        bench.pass(6 * MS);
        bench.run("lcd.update", MS);
        bench.work("lcd.readers", 1).unwrap();
        fast.read_exact(&mut record).unwrap();
        assert_eq!(&record[..16], text.as_bytes());
        assert_eq!(&record[64..69], format!("{n:05}").as_bytes());
    }
    drop(bench);
    let mut all = Vec::new();
    slow.read_to_end(&mut all).unwrap();
    let whole: Vec<&[u8]> = all.chunks_exact(RECORD_LEN).collect();
    assert!(whole.len() > 10 && whole.len() < 6000, "{} records", whole.len());
    for (n, record) in whole.iter().enumerate() {
        assert_eq!(&record[64..], format!("{n:05}\r\n").as_bytes());
    }
}

#[test]
fn devices_pipes_and_sockets_that_are_none_are_refused_by_name() {
    let scratch = Scratch::new("refused");
    let file = scratch.path("file");
    std::fs::write(&file, "text").unwrap();
    let missing = scratch.path("missing/tty");
    let keypad = |arg: String| hardware().load::<KeypadComponent>(&[&arg]).unwrap_err();
    let lcd = |arg: String| hardware().load::<LcdReader>(&[&arg]).unwrap_err();
    assert!(keypad(format!("device={missing}")).contains(&missing));
    assert!(keypad(format!("pipe={missing}")).contains(&missing));
    assert!(keypad(format!("pipe={file}")).contains("it is no named pipe"));
    assert!(lcd(format!("socket={file}")).contains("something else of this name"));
    assert_eq!(std::fs::read_to_string(&file).unwrap(), "text");
    // A socket that is served is not taken, and one that was left behind is replaced.
    let socket = scratch.path("socket");
    let mut first = hardware();
    first.load::<LcdReader>(&[&format!("socket={socket}")]).unwrap();
    first.work("lcd.readers", 1).unwrap();
    assert!(lcd(format!("socket={socket}")).contains("another process serves it"));
    drop(first);
    drop(std::os::unix::net::UnixListener::bind(&socket).unwrap());
    hardware().load::<LcdReader>(&[&format!("socket={socket}")]).unwrap();
}

#[test]
fn formats_that_are_none_are_refused() {
    let refused = |args: &[&str]| Bench::new().load::<KeypadComponent>(args).unwrap_err();
    assert!(refused(&["check=md5"]).contains("check is md5, must be crc8, sum or xor"));
    assert!(refused(&["size=3", "map=0,8"]).contains("key 2 is bit 8, must be 0 to 7"));
    assert!(refused(&["map=4,4"]).contains("keys 1 and 2 are the same bit"));
    let lcd = |arg: &str| Bench::new().load::<LcdReader>(&[arg]).unwrap_err();
    assert!(lcd("find=ä").contains("1 to 64 ASCII characters"));
}

#[test]
fn numbers_are_read_from_rows() {
    let mut bench = Bench::new();
    bench.load::<LcdReader>(&["values=X,Feed"]).unwrap();
    bench.port("lcd.bus", 512);
    let bus = bench.get::<hal_component::Port>("lcd.bus");
    let check = |row: usize, text: &[u8; 16], expected: (f64, bool, f64, bool)| {
        assert!(bus.write(&row_bytes(row, text)));
        bench.run("lcd.update", MS);
        bench.pass(6 * MS);
        bench.run("lcd.update", MS);
        let value = |n: u32| bench.get::<f64>(&format!("lcd.value-{n}"));
        let has = |n: u32| bench.get::<bool>(&format!("lcd.has-{n}"));
        assert_eq!((value(0), has(0), value(1), has(1)), expected, "{text:?}");
    };
    check(0, b"X   -12.500 IDLE", (-12.5, true, 0.0, false));
    check(2, b"Feed100         ", (-12.5, true, 100.0, true));
    check(0, b"X    ------ IDLE", (-12.5, false, 100.0, true));
    check(0, b"X       nan IDLE", (-12.5, false, 100.0, true));
    check(0, b"Y   -12.500 X  5", (-12.5, false, 100.0, true));
    check(3, b"X12345678901.234", (12_345_678_901.234, true, 100.0, true));
}

/// Keys of the simulated handheld move the simulated controller, which shows that in the bytes of its display.
#[test]
fn the_simulations_understand_each_other() {
    let mut bench = Bench::new();
    bench.load::<SimHandheld>(&[]).unwrap();
    bench.load::<SimNk105>(&[]).unwrap();
    bench.load::<LcdReader>(&["values=X", "find=JOG"]).unwrap();
    for (port, size) in [
        ("sim-handheld.frames", 64),
        ("sim-nk105.keys", 64),
        ("sim-nk105.lcd", 512),
        ("lcd.bus", 512),
    ] {
        bench.port(port, size);
    }
    let pass = |from: &str, to: &str| {
        let from = bench.get::<hal_component::Port>(from);
        let mut bytes = vec![0; usize::try_from(from.readable()).unwrap()];
        assert!(bytes.is_empty() || from.read(&mut bytes));
        assert!(bytes.is_empty() || bench.get::<hal_component::Port>(to).write(&bytes));
    };
    let run = |ms: u32| {
        for _ in 0..ms {
            bench.pass(MS);
            bench.run("sim-handheld.update", MS);
            pass("sim-handheld.frames", "sim-nk105.keys");
            bench.run("sim-nk105.update", MS);
            pass("sim-nk105.lcd", "lcd.bus");
            bench.run("lcd.update", MS);
        }
    };
    run(100);
    bench.set("sim-handheld.key-15", true);
    run(500);
    assert!(bench.get::<bool>("lcd.found-0"));
    bench.set("sim-handheld.key-15", false);
    run(200);
    let x = bench.get::<f64>("sim-nk105.x");
    assert!(20.0 < x && x < 30.0, "{x}");
    assert!((bench.get::<f64>("lcd.value-0") - x).abs() < 0.001);
    // Faults of the cable are counted by the controller, which takes the keys as released.
    bench.set("sim-handheld.key-15", true);
    bench.set("sim-handheld.corrupt", true);
    run(200);
    assert_eq!((bench.get::<f64>("sim-nk105.x"), bench.get::<u32>("sim-nk105.mode")), (x, 0));
    assert_eq!(bench.get::<u32>("sim-nk105.bad-frames"), 10);
}

mod device;
mod presses;
