//! Step generators against closed forms, and against the published circuit, tick by tick.

use crate::bench::{Bench, Random};
use hal_firmware::registers as r;

/// Nanoseconds of a tick: 100 MHz.
const TICK: u64 = 10;

/// Step generator as Mesa's VHDL has it, a clock edge at a time.
#[derive(Default)]
struct Circuit {
    rate: i32,
    accumulator: i64,
    setup: u32,
    hold: u32,
    length: u32,
    space: u32,
    held: bool,
    top: bool,
    old_top: bool,
    old_direction: bool,
    direction_out: bool,
    pulse: bool,
    old_wait: bool,
    pulse_count: u32,
    direction_count: u32,
    is_hold: bool,
    steps: i64,
}

impl Circuit {
    fn tick(&mut self) {
        // What the wires have before the edge.
        let backward = self.rate < 0;
        let next = self.accumulator + i64::from(self.rate);
        let next_top = next >> 31 & 1 == 1;
        let wait = self.pulse_count != 0;
        let direction_wait = self.direction_count != 0;
        let hold_wait = self.is_hold && direction_wait;
        let setup_wait = !self.is_hold && direction_wait;
        let change = self.direction_out != backward;
        let would = self.top && !next_top && !backward || !self.top && next_top && backward;
        let held = would && (setup_wait || wait || self.old_wait || change);
        // The edge.
        let counted_up = !self.top && self.old_top && !self.old_direction;
        let counted_down = self.top && !self.old_top && self.old_direction;
        let mut pulse_count = if wait { self.pulse_count - 1 } else { 0 };
        let mut pulse = self.pulse;
        if !wait && self.old_wait && self.pulse {
            (pulse_count, pulse) = (self.space, false);
        }
        let mut direction_count = self.direction_count.saturating_sub(1);
        if counted_up || counted_down {
            (pulse_count, pulse) = (self.length, true);
            (direction_count, self.is_hold) = (self.hold, true);
            self.steps += if counted_up { 1 } else { -1 };
        } else if !hold_wait && change {
            (direction_count, self.is_hold) = (self.setup, false);
            self.direction_out = backward;
        }
        self.old_top = self.top;
        self.old_wait = wait;
        if !held {
            self.accumulator = next;
            self.top = next_top;
            self.old_direction = backward;
        }
        self.held = held;
        (self.pulse_count, self.pulse, self.direction_count) =
            (pulse_count, pulse, direction_count);
    }
}

fn set(bench: &mut Bench, times: [u32; 4]) {
    let all = [r::STEP_SETUP, r::STEP_HOLD, r::STEP_LENGTH, r::STEP_SPACE];
    for (register, time) in all.into_iter().zip(times) {
        bench.write(register, 0, time);
    }
}

#[test]
fn position_is_rate_times_time() {
    let mut bench = Bench::new("7i92");
    for (rate, ticks) in [(1_i32, 1000_u64), (42_949_673, 123_456), (-42_949_673, 999_999)] {
        // At a half the first count comes late enough for a change of direction.
        bench.write(r::STEP_ACCUMULATOR, 3, 0x8000);
        let before = bench.card.steps(3).unwrap();
        bench.write(r::STEP_RATE, 3, rate as u32);
        // Times are short, and the rate is far below the fastest.
        bench.card.advance(ticks * TICK);
        let way = f64::from(rate) * ticks as f64 / 4_294_967_296.0;
        let position = bench.card.steps(3).unwrap() - before;
        assert!((position - way).abs() < 1e-9, "{rate}: {position} of {way}");
        let whole = i64::from(rate) * ticks.cast_signed();
        let read = bench.read(r::STEP_ACCUMULATOR, 3);
        assert_eq!(read, ((whole + (1 << 31)) >> 16) as u32, "{rate}");
    }
}

/// Positions beyond the 16 bits of the register go on, and time in pieces is time.
#[test]
fn positions_wrap_nowhere() {
    let (mut whole, mut pieces) = (Bench::new("7i92"), Bench::new("7i92"));
    let rate = 0x0100_0000_u32;
    for bench in [&mut whole, &mut pieces] {
        bench.write(r::STEP_RATE, 0, rate);
    }
    whole.card.advance(10_000_000_000);
    let mut random = Random(3);
    let mut left = 10_000_000_000_u64;
    while left != 0 {
        let part = (1 + random.below(30_000_000)).min(left);
        pieces.card.advance(part);
        left -= part;
    }
    // 10^9 ticks of 2^24 of 2^32.
    assert_eq!(whole.card.steps(0), Some(1e9 / 256.0));
    assert_eq!(pieces.card.steps(0), whole.card.steps(0));
    assert_eq!(pieces.read(r::STEP_ACCUMULATOR, 0), whole.read(r::STEP_ACCUMULATOR, 0));
}

#[test]
fn lengths_limit_the_rate() {
    let mut bench = Bench::new("7i92");
    set(&mut bench, [100, 200, 300, 500]);
    // Far faster than a step in 804 ticks.
    bench.write(r::STEP_RATE, 0, 0x1000_0000);
    bench.card.advance(804 * 1000 * TICK);
    let steps = bench.card.steps(0).unwrap();
    assert!((999.0..=1001.0).contains(&steps), "{steps}");
}

#[test]
fn steps_leave_only_while_the_generator_drives_its_pin() {
    let mut bench = Bench::new("7i92");
    // Pin 1 is the step of the first generator.
    bench.write(r::STEP_RATE, 0, 1 << 24);
    bench.card.advance(256 * 10 * TICK);
    assert_eq!(bench.card.emitted_steps(0), Some(0));
    bench.write(r::PORT_SOURCE, 0, 2);
    bench.card.advance(256 * 10 * TICK);
    assert_eq!(bench.card.emitted_steps(0), Some(0));
    bench.write(r::PORT_DIRECTION, 0, 2);
    bench.card.advance(256 * 10 * TICK);
    assert_eq!(bench.card.emitted_steps(0), Some(10));
    bench.write(r::WATCHDOG_TIMEOUT, 0, 256 * 5 - 1);
    bench.card.advance(256 * 10 * TICK);
    assert!(bench.card.watchdog_has_bitten());
    assert_eq!(bench.card.emitted_steps(0), Some(15));
    assert_eq!(bench.card.steps(0), Some(40.0));
}

#[test]
fn outputs_have_the_forms_of_the_modes() {
    let mut bench = Bench::new("7i92");
    bench.write(r::PORT_SOURCE, 0, 3);
    bench.write(r::PORT_DIRECTION, 0, 3);
    set(&mut bench, [0, 0, 50, 50]);
    // (mode, rate, levels of step and direction 10 ticks after a step, and long after it)
    let rows = [
        (0, 1 << 22, (true, false), (false, false)),
        (0, -(1 << 22), (true, true), (false, true)),
        (1, 1 << 22, (true, false), (false, false)),
        (1, -(1 << 22), (false, true), (false, false)),
        (4, 1 << 22, (false, true), (false, false)),
    ];
    for (mode, rate, early, late) in rows {
        bench.write(r::STEP_MODE, 0, mode);
        bench.write(r::STEP_ACCUMULATOR, 0, if rate < 0 { 0 } else { 0xFFFF_FFFF });
        bench.write(r::STEP_RATE, 0, rate as u32);
        bench.card.advance(10 * TICK);
        let levels = |bench: &Bench| (bench.card.level(1), bench.card.level(0));
        assert_eq!(levels(&bench), early, "mode {mode}, rate {rate}");
        bench.card.advance(100 * TICK);
        assert_eq!(levels(&bench), late, "mode {mode}, rate {rate}");
    }
    bench.write(r::STEP_MODE, 0, 2);
    bench.write(r::STEP_RATE, 0, 0);
    for (quarter, levels) in
        [(0_u32, (false, false)), (1, (true, false)), (2, (true, true)), (3, (false, true))]
    {
        bench.write(r::STEP_ACCUMULATOR, 0, quarter << 14);
        assert_eq!((bench.card.level(1), bench.card.level(0)), levels, "{quarter}");
    }
}

/// Random rates, times and changes: the same counts as the circuit, at most a step that the circuit notes a tick later.
#[test]
fn steps_come_as_the_circuit_lets_them() {
    let mut random = Random(0x5EED);
    let mut total = 0;
    for case in 0..300 {
        let mut bench = Bench::new("7i92");
        let mut circuit = Circuit::default();
        let mut time = |limit| random.below(limit) as u32;
        let times = [time(60), time(60), time(40), time(40)];
        set(&mut bench, times);
        [circuit.setup, circuit.hold, circuit.length, circuit.space] = times;
        for part in 0..12 {
            let size = random.below(31);
            let rate = (random.next() as i32) >> size;
            bench.write(r::STEP_RATE, 0, rate as u32);
            circuit.rate = rate;
            let ticks = 1 + random.below(3000);
            bench.card.advance(ticks * TICK);
            for _ in 0..ticks {
                circuit.tick();
            }
            let read = bench.read(r::STEP_ACCUMULATOR, 0);
            assert_eq!(
                read,
                (circuit.accumulator >> 16) as u32,
                "case {case}, part {part}: {times:?}, rate {rate}, {ticks} ticks"
            );
        }
        let steps = bench.card.steps(0).unwrap().floor();
        // The circuit notes a step one edge after its count.
        let late = (steps - circuit.steps as f64).abs();
        assert!(late <= 1.0, "case {case}: {steps} of {}", circuit.steps);
        total += circuit.steps.abs();
    }
    assert!(10_000 < total, "{total}");
}
