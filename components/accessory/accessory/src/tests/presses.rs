//! STOP passes what waits, and no press is lost on its way.

use super::{MS, piped, writer};
use crate::{
    keypad::KeypadComponent,
    presses::{PressQueue, Presses},
};
use hal_bench::Bench;
use hal_component::{Builder, Component, Error, abi::TicketState};
use hal_handheld::Press;
use std::{io::Write as _, sync::Mutex};

fn loaded() -> Bench {
    let mut bench = Bench::new();
    bench.load::<KeypadComponent>(&[]).unwrap();
    bench
}

fn is_down(bench: &Bench, key: &str) -> bool {
    bench.get::<bool>(&format!("keypad.down-{key}"))
}

#[test]
fn stop_passes_the_presses_that_wait() {
    let bench = loaded();
    for _ in 0..5 {
        bench.command("keypad.press", &["key=X+", "hold=10000"]).unwrap();
    }
    bench.run("keypad.update", 20 * MS);
    assert!(is_down(&bench, "15"));
    bench.command("keypad.press", &["key=STOP"]).unwrap();
    // What comes after STOP stays.
    bench.command("keypad.press", &["key=OK"]).unwrap();
    bench.run("keypad.update", 20 * MS);
    assert!(is_down(&bench, "14") && !is_down(&bench, "15"));
    assert_eq!(bench.get::<u32>("keypad.queue"), 1);
    let failed =
        bench.tickets().iter().filter(|t| **t == TicketState::Failed("STOP was pressed")).count();
    assert_eq!(failed, 5, "{:?}", bench.tickets());
    let mut pressed = Vec::new();
    for _ in 0..20 {
        bench.run("keypad.update", 20 * MS);
        pressed.extend(["13", "15"].into_iter().filter(|key| is_down(&bench, key)));
    }
    assert_eq!(pressed, ["13"; 3]);
}

/// STOP twice is two presses, and finds room where nothing else does.
#[test]
fn stop_needs_no_room() {
    let bench = loaded();
    bench.command("keypad.type", &[&format!("text={}", "1".repeat(64))]).unwrap();
    assert!(bench.command("keypad.press", &["key=X+"]).unwrap_err().contains("room for 0"));
    bench.command("keypad.press", &["key=STOP"]).unwrap();
    bench.command("keypad.press", &["key=14", "hold=1"]).unwrap();
    let mut frames = String::new();
    for _ in 0..12 {
        bench.run("keypad.update", 20 * MS);
        assert!(!is_down(&bench, "01"));
        frames.push(if is_down(&bench, "14") { '#' } else { '.' });
    }
    assert_eq!(frames, "###..#......");
    bench.command("keypad.press", &["key=STOP"]).unwrap();
    bench.set("keypad.enable", false);
    bench.run("keypad.update", 20 * MS);
    assert!(!is_down(&bench, "14"));
    assert_eq!(bench.get::<u32>("keypad.queue"), 0);
}

#[test]
fn stop_of_the_pipe_passes_its_lines() {
    let (_scratch, bench, path) = piped("stops");
    let mut writer = writer(&path);
    writer.write_all("15 10000\n".repeat(200).as_bytes()).unwrap();
    bench.work("keypad.pipe", 1000).unwrap();
    bench.run("keypad.update", 20 * MS);
    assert!(is_down(&bench, "15"));
    writer.write_all(b"14\n13\n").unwrap();
    bench.work("keypad.pipe", 1000).unwrap();
    bench.run("keypad.update", 20 * MS);
    assert!(is_down(&bench, "14") && !is_down(&bench, "15"));
    bench.work("keypad.pipe", 1000).unwrap();
    bench.run("keypad.update", 20 * MS);
    assert!(is_down(&bench, "14"));
    assert_eq!(bench.get::<u32>("keypad.queue"), 1);
    // A command's STOP, too: what is in the pipe was for a machine that ran.
    writer.write_all("15 10000\n".repeat(200).as_bytes()).unwrap();
    bench.work("keypad.pipe", 100).unwrap();
    bench.command("keypad.press", &["key=STOP"]).unwrap();
    for _ in 0..20 {
        bench.work("keypad.pipe", 1000).unwrap();
        bench.run("keypad.update", 20 * MS);
        assert!(!is_down(&bench, "15"));
    }
    assert_eq!(bench.get::<u32>("keypad.queue"), 0);
    writer.write_all(b"13\n").unwrap();
    bench.work("keypad.pipe", 1000).unwrap();
    bench.run("keypad.update", 20 * MS);
    assert!(is_down(&bench, "13"));
}

#[test]
fn a_line_without_an_end_does_not_keep_the_worker() {
    let (_scratch, bench, path) = piped("endless");
    let mut writer = writer(&path);
    writer.write_all(&[0; 60_000]).unwrap();
    assert_eq!(bench.work("keypad.pipe", 2).unwrap(), 2);
    assert_eq!(bench.work("keypad.pipe", 1000).unwrap(), 12);
    writer.write_all(b"\n13\n").unwrap();
    bench.work("keypad.pipe", 1000).unwrap();
    bench.run("keypad.update", 20 * MS);
    assert!(is_down(&bench, "13"));
    assert_eq!(bench.get::<u32>("keypad.bad-lines"), 1);
}

/// Two senders at once: what was accepted is pressed, a number is typed whole or refused.
#[test]
fn senders_do_not_take_each_others_room() {
    let (_scratch, bench, path) = piped("senders");
    let mut writer = writer(&path);
    // 63 wait: there is room for one line, and none for three digits behind it.
    writer.write_all("1 1\n".repeat(63).as_bytes()).unwrap();
    bench.work("keypad.pipe", 1000).unwrap();
    assert!(bench.command("keypad.type", &["text=234"]).unwrap_err().contains("room for 1"));
    bench.command("keypad.press", &["key=5", "hold=1"]).unwrap();
    writer.write_all(b"6 1\n7 1\n").unwrap();
    bench.work("keypad.pipe", 1000).unwrap();
    let mut typed = String::new();
    for _ in 0..70 * 3 {
        bench.work("keypad.pipe", 1000).unwrap();
        bench.run("keypad.update", 20 * MS);
        let down = ["02", "03", "04", "05", "06", "07"].into_iter();
        typed.extend(down.filter(|key| is_down(&bench, key)));
    }
    assert_eq!(typed, "050607");
}

static ENDS: Mutex<Option<(Presses, PressQueue)>> = Mutex::new(None);

/// Both ends of the presses, for the test that plays two senders and the function.
struct Ends;

impl Component for Ends {
    const NAME: &'static str = "ends";
    const DOC: &'static str = "Both ends of the presses.";

    fn create(b: &mut Builder<'_>) -> Result<(), Error> {
        *ENDS.lock().unwrap() = Some(Presses::make(b));
        Ok(())
    }
}

#[test]
fn numbers_of_two_senders_stay_whole() {
    const NUMBERS: u32 = 2000;
    const DIGITS: usize = 20;
    let mut bench = Bench::new();
    bench.load::<Ends>(&[]).unwrap();
    let (presses, mut queue) = ENDS.lock().unwrap().take().unwrap();
    let sender = |key: u8| {
        let presses = presses.clone();
        move || {
            for number in 0..NUMBERS {
                let digits = [Press { key, periods: number }; DIGITS];
                loop {
                    let mut sending = presses.lock();
                    if sending.room(&digits) >= digits.len() {
                        sending.send(&digits, None);
                        break;
                    }
                    drop(sending);
                    std::thread::yield_now();
                }
            }
        }
    };
    let mut taken = Vec::new();
    std::thread::scope(|scope| {
        let senders = [1, 2].map(|key| scope.spawn(sender(key)));
        loop {
            let all_sent = senders.iter().all(std::thread::ScopedJoinHandle::is_finished);
            match queue.take() {
                Some(entry) => taken.push(entry.press),
                None if all_sent => break,
                None => std::thread::yield_now(),
            }
        }
    });
    assert_eq!(taken.len(), 2 * DIGITS * NUMBERS as usize);
    assert!(taken.chunks(DIGITS).all(|digits| digits.iter().all(|digit| *digit == digits[0])));
}
