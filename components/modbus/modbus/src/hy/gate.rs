//! Realtime. The function of an inverter: pins in and out, and the guard of its worker.

use super::{
    halt::Halt,
    pins::{InputPins, Inputs, ResultPins, Results},
    simulated::SimulatedPins,
};
use hal_component::{
    Clock, Hardware, Messages, Period, SeqReader, SeqWriter, StillWatch, Touch, Update,
};
use std::sync::{
    Arc,
    atomic::{AtomicU32, Ordering::Relaxed},
};

/// Time without a step of the worker after which it is taken for dead, in nanoseconds.
const DEAD_NS: i64 = 500_000_000;
/// Time without a step of the worker after which the function lets the time of a simulated inverter pass, in nanoseconds.
const STILL_NS: i64 = 5_000_000;
/// Time between stops that are sent for a dead worker, in nanoseconds.
const AGAIN_NS: i64 = 100_000_000;

/// The function.
#[derive(Debug, Touch)]
pub(crate) struct Gate {
    pub(crate) inputs: InputPins,
    pub(crate) shown: ResultPins,
    pub(crate) results: SeqReader<Results>,
    pub(crate) wanted: SeqWriter<Inputs>,
    pub(crate) simulated: Option<SimulatedPins>,
    pub(crate) clock: Clock,
    pub(crate) messages: Messages,
    pub(crate) hardware: Hardware,
    #[state]
    pub(crate) halt: Arc<Halt>,
    /// Steps of the worker.
    #[state]
    pub(crate) steps: Arc<AtomicU32>,
    #[state]
    pub(crate) was: Was,
}

/// State that the function keeps from one cycle to the next.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Was {
    cycles: u32,
    worker: StillWatch,
    /// Machine time of the last stop for a dead worker.
    stopped: i64,
    lapses: u32,
    gaps: u32,
    errors: u32,
    /// The spindle has to be commanded again: spindle-on must go FALSE first.
    is_blocked: bool,
    /// The message about that is in the log.
    is_told: bool,
    is_limited: bool,
}

impl Was {
    pub(crate) const fn new(gaps: u32) -> Self {
        Self {
            cycles: 0,
            worker: StillWatch::new(),
            stopped: 0,
            lapses: 0,
            gaps,
            errors: 0,
            is_blocked: true,
            is_told: false,
            is_limited: false,
        }
    }
}

/// Values of the pins in one cycle.
#[derive(Clone, Copy, Debug)]
struct Read {
    enable: bool,
    on: bool,
    /// Direction that the pins want.
    direction: i32,
    speed: f64,
    tolerance: f64,
}

impl Read {
    fn new(pins: &InputPins) -> Self {
        let on = pins.on.get();
        let direction = match (on, pins.forward.get(), pins.reverse.get()) {
            (true, true, false) => 1,
            (true, false, true) => -1,
            _ => 0,
        };
        Self {
            enable: pins.enable.get(),
            on,
            direction,
            speed: pins.speed.get(),
            tolerance: pins.tolerance.get().abs(),
        }
    }
}

impl Gate {
    /// Returns whether a worker that has stood still for so long is dead. Stops the inverter then, in its place.
    fn is_worker_dead(&mut self, still_ns: i64, now: i64) -> bool {
        let is_dead = DEAD_NS < still_ns;
        if is_dead && AGAIN_NS <= now.saturating_sub(self.was.stopped) {
            self.was.stopped = now;
            self.halt.stop();
        }
        is_dead
    }

    fn tell(&mut self, read: &Read, run: i32, results: &Results) {
        let is_refused = read.on && read.enable && self.was.is_blocked;
        if is_refused && !self.was.is_told {
            self.messages.warn(
                "the inverter stands although spindle-on is TRUE: it turns again once spindle-on was FALSE while it answers",
                &[],
            );
        }
        self.was.is_told = is_refused;
        let speed = read.speed.abs();
        let top = results.rated_motor_rev;
        let low = if results.max_freq == 0.0 {
            0.0
        } else {
            top * results.freq_lower_limit / results.max_freq
        };
        let tolerance = speed * read.tolerance;
        let is_limited =
            run != 0 && results.ready && (speed + tolerance < low || top < speed - tolerance);
        if is_limited && !self.was.is_limited {
            self.messages.warn(
                "speed-command {} is outside the inverter's limits, {} to {} turns per minute: spindle-at-speed stays FALSE",
                &[speed, low, top],
            );
        }
        self.was.is_limited = is_limited;
    }
}

impl Update for Gate {
    fn update(&mut self, _: Period) {
        let now = self.clock.now_ns();
        let mut results = self.results.get();
        let still_ns = self.was.worker.still_ns(self.steps.load(Relaxed), now);
        let is_dead = self.is_worker_dead(still_ns, now);
        if let Some(simulated) = &mut self.simulated {
            simulated.exchange(now, STILL_NS < still_ns);
        }
        if is_dead {
            (results.fault, results.ready, results.hycomm_ok) = (true, false, false);
        }
        let read = Read::new(&self.inputs);
        let gaps = self.clock.gaps();
        let has_lapsed = results.lapses != self.was.lapses || gaps != self.was.gaps;
        (self.was.lapses, self.was.gaps) = (results.lapses, gaps);
        if has_lapsed || !read.enable || !results.ready {
            self.was.is_blocked = true;
        } else if !read.on {
            self.was.is_blocked = false;
        }
        let run = if self.was.is_blocked { 0 } else { read.direction };
        let (enable, speed) = (read.enable, read.speed);
        self.was.cycles = self.was.cycles.wrapping_add(1).max(1);
        let (seen, cycles) = (results.lapses, self.was.cycles);
        self.wanted.set(&Inputs { enable, run, speed, seen, cycles });
        self.tell(&read, run, &results);
        let errors = results.errors();
        if errors != self.was.errors {
            let more = errors.saturating_sub(self.was.errors);
            let count = &self.inputs.error_count;
            count.set(count.get().saturating_add_unsigned(more));
            self.inputs.retval.set(f64::from(results.last_error));
            self.was.errors = errors;
        }
        let difference = (results.spindle_speed_fb - speed.abs()).abs();
        let is_near = difference <= read.tolerance * speed.abs();
        // The frequency has no sign: while the spindle turns round, the state says it.
        let is_against = results.cnst_running && results.cnst_running_rf != (run == -1);
        let is_commanded = run != 0 && 0.0 < speed.abs() && speed.is_finite() && results.hycomm_ok;
        self.inputs.at_speed.set(is_commanded && is_near && !is_against);
        self.shown.set(&results);
        self.hardware.note(results.fault);
    }
}
