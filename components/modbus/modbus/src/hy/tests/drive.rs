//! The conversation by itself: requests, and answers that the test gives.

use super::MS;
use crate::hy::{drive::Drive, note::Note, pins::Inputs};
use hal_modbus::{
    Miss,
    huanyang::{Ask, RUN_FORWARD, STOP},
};
use port::Lost;

/// Settings of an inverter with 24000 turns per minute at 400 Hz.
const fn setting(number: u8) -> u16 {
    match number {
        4 | 5 => 40_000,
        11 => 10_000,
        144 => 3000,
        _ => 2,
    }
}

/// Conversation with a person who has commanded the spindle, and an inverter that answers as it should.
struct Talk {
    drive: Drive,
    now: i64,
    /// State that the inverter answers.
    state: u16,
    asked: Vec<Ask>,
}

impl Talk {
    fn new(writes: &[(u8, u16)]) -> Self {
        let drive = Drive::new(1, writes.to_vec(), 500 * MS);
        Self { drive, now: 0, state: 0, asked: Vec::new() }
    }

    fn want(&mut self, enable: bool, run: i32) {
        let seen = self.drive.results(self.now).lapses;
        self.drive.want(Inputs { enable, run, speed: 12_000.0, seen, cycles: 1 }, self.now);
    }

    /// Lets the next request be answered with this. Returns the request.
    fn ends(&mut self, end: impl Fn(Ask) -> Result<u16, Miss>) -> Option<Ask> {
        let ask = self.drive.next()?.ask;
        self.drive.sent();
        self.asked.push(ask);
        self.now += 20 * MS;
        self.drive.ended(ask, end(ask), self.now);
        Some(ask)
    }

    fn answers(&mut self) -> Option<Ask> {
        let state = self.state;
        self.ends(|ask| {
            Ok(match ask {
                Ask::Setting(number) => setting(number),
                Ask::Write(_, value) | Ask::Frequency(value) => value,
                Ask::Control(_) => state,
                Ask::Measured(_) => 0,
            })
        })
    }

    /// Returns a conversation with an inverter that runs.
    fn running() -> Self {
        let mut talk = Self::new(&[]);
        talk.want(true, 0);
        while !talk.drive.results(talk.now).ready {
            talk.answers();
        }
        talk.want(true, 1);
        while talk.answers() != Some(Ask::Control(RUN_FORWARD)) {}
        talk.state = 0x09;
        for _ in 0..20 {
            talk.answers();
        }
        assert!(talk.drive.may_run());
        talk
    }
}

#[test]
fn the_late_answer_to_a_command_to_run_ends_no_stop() {
    for late in [0x01, 0x09, 0x0D, 0x29] {
        let mut talk = Talk::running();
        talk.want(true, 0);
        for _ in 0..5 {
            assert_eq!(talk.ends(|_| Ok(late)), Some(Ask::Control(STOP)), "{late:#x}");
            assert!(talk.drive.may_run(), "{late:#x}");
        }
        assert_eq!(talk.ends(|_| Ok(0x48)), Some(Ask::Control(STOP)));
        assert!(!talk.drive.may_run());
        // The same without enable.
        let mut talk = Talk::running();
        talk.want(false, 0);
        assert_eq!(talk.ends(|_| Ok(late)), Some(Ask::Control(STOP)));
        assert!(talk.drive.may_run());
        assert_eq!(talk.ends(|_| Ok(0)), Some(Ask::Control(STOP)));
        assert_eq!((talk.drive.may_run(), talk.drive.next()), (false, None));
    }
}

#[test]
fn the_loss_of_a_line_is_a_stop_and_a_person() {
    let mut talk = Talk::running();
    let seen = talk.drive.results(talk.now).lapses;
    talk.drive.lost(Lost(19));
    // The function has not seen it yet.
    talk.drive.want(Inputs { enable: true, run: 1, speed: 12_000.0, seen, cycles: 2 }, talk.now);
    talk.asked.clear();
    talk.state = 0;
    for _ in 0..100 {
        talk.answers();
    }
    assert_eq!(talk.asked[0], Ask::Control(STOP));
    assert!(!talk.asked.contains(&Ask::Control(RUN_FORWARD)));
    assert_ne!(talk.drive.results(talk.now).lapses, seen);
}

#[test]
fn settings_are_written_once() {
    let mut talk = Talk::new(&[(5, 40_000), (14, 30)]);
    talk.want(true, 0);
    // The first answer to a write is lost.
    while !matches!(
        talk.ends(|ask| if let Ask::Control(_) = ask { Ok(0) } else { Err(Miss::Silent) }),
        Some(Ask::Write(..))
    ) {}
    for n in 0..100 {
        talk.answers();
        if n % 25 == 24 {
            talk.drive.lapse();
        }
    }
    let writes: Vec<Ask> =
        talk.asked.iter().copied().filter(|ask| matches!(ask, Ask::Write(..))).collect();
    assert_eq!(writes, [Ask::Write(5, 40_000), Ask::Write(5, 40_000), Ask::Write(14, 30)]);
    assert_eq!(talk.drive.take_note(), None);
}

#[test]
fn an_inverter_that_does_not_take_a_setting_stands() {
    let mut talk = Talk::new(&[(5, 40_000), (14, 30)]);
    talk.want(true, 0);
    assert_eq!(talk.answers(), Some(Ask::Control(STOP)));
    assert_eq!(talk.ends(|_| Ok(30_000)), Some(Ask::Write(5, 40_000)));
    let note = talk.drive.take_note().unwrap();
    assert_eq!(note, Note::Refused(5, 40_000, 30_000));
    assert_eq!(
        note.to_string(),
        "the inverter does not take 40000 for PD005, and answers 30000: the spindle stands until the component is loaded with another value"
    );
    talk.want(true, 1);
    for _ in 0..100 {
        assert_eq!(talk.answers(), Some(Ask::Control(STOP)));
    }
    assert!(!talk.drive.results(talk.now).ready);
}

#[test]
fn time_without_a_failure_is_no_fault() {
    let mut talk = Talk::running();
    talk.now += 10_000 * MS;
    talk.want(true, 1);
    assert!(!talk.drive.is_lost(), "nothing was asked");
    talk.ends(|_| Err(Miss::Other(7)));
    talk.now += 10_000 * MS;
    talk.want(true, 1);
    assert!(talk.drive.is_lost());
    assert_eq!(talk.drive.last_miss(), Miss::Other(7));
    assert_eq!(talk.answers(), Some(Ask::Control(STOP)));
    // A line that cannot be opened is one.
    let mut talk = Talk::new(&[]);
    talk.want(true, 0);
    talk.drive.not_opened();
    talk.now += 501 * MS;
    talk.want(true, 0);
    assert!(talk.drive.is_lost());
}

#[test]
fn what_has_to_be_known_is_said_in_words() {
    assert_eq!(
        Note::Stopped.to_string(),
        "the inverter has stopped by itself, as after a trip: the spindle stands until a person commands it anew"
    );
}
