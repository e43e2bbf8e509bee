//! The stop that needs no worker, on a line whose bytes come when the test says.

use super::MS;
use crate::{
    hy::halt::Halt,
    line::{Carrier, OpenLine},
};
use core::time::Duration;
use hal_bench::Bench;
use hal_component::{Builder, Clock, Component, Error};
use hal_modbus::huanyang::{Ask, STOP, frame};
use port::{Exchange, Lost};
use std::{
    cell::{Cell, RefCell},
    collections::VecDeque,
    sync::{Arc, Mutex},
};

thread_local! {
    static CLOCK: Cell<Option<Clock>> = const { Cell::new(None) };
    static BENCH: RefCell<Bench> = RefCell::new(Bench::new());
}

/// Gives the clock of the bench to a test.
enum ClockOfTest {}

impl Component for ClockOfTest {
    const NAME: &'static str = "clock_of_test";
    const DOC: &'static str = "The clock of the bench.";

    fn create(b: &mut Builder<'_>) -> Result<(), Error> {
        CLOCK.set(Some(b.clock()));
        Ok(())
    }
}

fn clock() -> Clock {
    BENCH.with_borrow_mut(|bench| bench.load::<ClockOfTest>(&[]).unwrap());
    CLOCK.get().unwrap()
}

fn now() -> i64 {
    BENCH.with_borrow(Bench::now_ns)
}

/// Bytes with the time at which they come.
type Bytes = VecDeque<(i64, Vec<u8>)>;

/// Line whose far end is a table.
#[derive(Default)]
struct Table {
    coming: Bytes,
    /// Answers to each frame, with the time after it.
    answers: VecDeque<Vec<(i64, Vec<u8>)>>,
    sent: Vec<(i64, Vec<u8>)>,
    /// Noise without an end: a byte in each millisecond.
    is_noisy: bool,
}

#[derive(Clone, Default)]
struct TableLine(Arc<Mutex<Table>>);

impl TableLine {
    /// Returns a stop on this line, of an inverter that may run.
    fn halt(&self) -> Halt {
        let halt = Halt::new(1, clock());
        halt.on(Some(Arc::new(OpenLine::new(self.clone()))));
        assert!(halt.flags.may_send(true));
        halt
    }

    fn answers(self, answers: &[&[(i64, Vec<u8>)]]) -> Self {
        self.0.lock().unwrap().answers = answers.iter().map(|all| all.to_vec()).collect();
        self
    }

    fn comes(self, bytes: &[(i64, Vec<u8>)]) -> Self {
        self.0.lock().unwrap().coming.extend(bytes.iter().cloned());
        self
    }

    fn sent(&self) -> usize {
        self.0.lock().unwrap().sent.len()
    }
}

impl Exchange for TableLine {
    fn send(&self, packet: &[u8]) -> Result<(), Lost> {
        let mut table = self.0.lock().unwrap();
        table.sent.push((now(), packet.to_vec()));
        let answers = table.answers.pop_front().unwrap_or_default();
        table.coming.extend(answers.into_iter().map(|(after, bytes)| (now() + after, bytes)));
        Ok(())
    }

    fn receive(&self, into: &mut [u8], within: Duration) -> Result<usize, Lost> {
        let mut table = self.0.lock().unwrap();
        let until = now() + i64::try_from(within.as_nanos()).unwrap_or(i64::MAX / 2);
        if table.is_noisy {
            BENCH.with_borrow(|bench| bench.pass(MS));
            into[0] = 0x55;
            return Ok(1);
        }
        let Some((at, bytes)) = table.coming.pop_front_if(|(at, _)| *at <= until) else {
            BENCH.with_borrow(|bench| bench.pass(until - now()));
            return Ok(0);
        };
        BENCH.with_borrow(|bench| bench.pass((at - now()).max(0)));
        into[..bytes.len()].copy_from_slice(&bytes);
        Ok(bytes.len())
    }
}

impl Carrier for TableLine {}

fn state(state: u8) -> Vec<u8> {
    frame(1, 3, &[state])
}

/// The answer to an earlier stop is still to come, or has come and was not taken.
#[test]
fn the_last_stop_takes_no_answer_from_before_it() {
    for at in [0, 5 * MS, 30 * MS, 39 * MS] {
        let line = TableLine::default()
            .comes(&[(now() + at, state(0x08))])
            .answers(&[&[], &[(10 * MS, state(0x48))]]);
        line.halt().last_stop();
        // Nothing answers the first stop: there is a second one, which is answered.
        assert_eq!(line.sent(), 2, "{at} ns");
    }
}

#[test]
fn the_answer_to_a_command_to_run_is_none_to_a_stop() {
    for run in [0x01, 0x09, 0x0D, 0x2D] {
        let line =
            TableLine::default().answers(&[&[(10 * MS, state(run))], &[(10 * MS, state(0x00))]]);
        line.halt().last_stop();
        assert_eq!(line.sent(), 2, "{run:#x}");
    }
    // Behind it comes the one to the stop, also in pieces.
    let [mut head, tail] = [state(0x48), state(0x48)];
    let tail = tail[3..].to_vec();
    head.truncate(3);
    let line =
        TableLine::default().answers(&[&[(5 * MS, state(0x09)), (20 * MS, head), (25 * MS, tail)]]);
    line.halt().last_stop();
    assert_eq!(line.sent(), 1);
}

#[test]
fn an_answered_last_stop_is_the_only_one() {
    for answer in [0x00, 0x08, 0x48] {
        let line = TableLine::default().answers(&[&[(10 * MS, state(answer))]]);
        let halt = line.halt();
        halt.last_stop();
        assert_eq!(line.sent(), 1);
        assert_eq!(line.0.lock().unwrap().sent[0].1, Ask::Control(STOP).frame(1));
        halt.last_stop();
        assert_eq!(line.sent(), 1, "the line is closed");
    }
    // An inverter that stands needs none.
    let line = TableLine::default();
    let halt = line.halt();
    halt.flags.set_may_run(false);
    halt.last_stop();
    assert_eq!(line.sent(), 0);
}

#[test]
fn the_last_stops_take_half_a_second_at_most() {
    for is_noisy in [false, true] {
        let line = TableLine::default();
        line.0.lock().unwrap().is_noisy = is_noisy;
        let halt = line.halt();
        let begin = now();
        halt.last_stop();
        let took = now() - begin;
        assert!((300 * MS..=500 * MS).contains(&took), "{took} ns");
        assert_eq!(line.sent(), 3);
    }
}

#[test]
fn a_stop_that_comes_before_the_worker_sends_holds_its_frame_back() {
    let line = TableLine::default();
    let halt = line.halt();
    halt.flags.set_may_run(false);
    halt.stop();
    assert_eq!(line.sent(), 0, "the inverter stands");
    assert!(!halt.flags.may_send(true), "the command to run must not leave behind the stop");
    assert!(halt.flags.notice() && !halt.flags.notice());
    assert!(halt.flags.may_send(true));
    halt.stop();
    assert_eq!(line.sent(), 1);
}

#[test]
fn the_stop_action_waits_no_longer_than_the_line_is_busy() {
    // The fake line cannot wait by itself, and a wait of real time would show in no virtual clock: a quiet line needs none.
    let line = TableLine::default();
    let halt = line.halt();
    halt.set_quiet_at(now());
    halt.stop_action();
    assert_eq!(line.sent(), 1);
    // One that is busy is waited for by the simulated line's own time.
    let asked: Arc<Mutex<Vec<Duration>>> = Arc::default();
    for (left, wanted) in [(30 * MS, 30), (150 * MS, 150), (10_000 * MS, 150)] {
        let halt = Halt::new(1, clock());
        halt.on(Some(Arc::new(OpenLine::new(Later(asked.clone())))));
        assert!(halt.flags.may_send(true));
        halt.set_quiet_at(now() + left);
        halt.stop_action();
        assert_eq!(asked.lock().unwrap().pop(), Some(Duration::from_millis(wanted)));
    }
}

/// Line that sends later by itself, and notes when.
struct Later(Arc<Mutex<Vec<Duration>>>);

impl Exchange for Later {
    fn send(&self, _: &[u8]) -> Result<(), Lost> {
        panic!("it is busy")
    }

    fn receive(&self, _: &mut [u8], _: Duration) -> Result<usize, Lost> {
        Ok(0)
    }
}

impl Carrier for Later {
    fn send_later(&self, frame: &[u8], wait: Duration, _: i64) -> bool {
        assert_eq!(frame, Ask::Control(STOP).frame(1));
        self.0.lock().unwrap().push(wait);
        true
    }
}
