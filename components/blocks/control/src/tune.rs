//! Realtime. Automatic tuning of a loop with a relay that makes it oscillate.

use crate::pid::Pins;

#[cfg(test)]
mod closed;

/// Value of π in the formula of the gain.
#[expect(clippy::approx_constant, reason = "the figures that users know come from this one")]
const PI: f64 = 3.141_592_653_589;

/// State of tuning.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
enum State {
    /// The loop controls normally.
    #[default]
    Off,
    /// Ready to be started.
    Idle,
    /// Oscillation is about to start.
    Start,
    /// The error was positive or zero.
    Positive,
    /// The error was negative.
    Negative,
}

/// Tuner of one loop.
#[derive(Debug, Default)]
pub(crate) struct Tuner {
    state: State,
    /// Number of half cycles so far.
    cycles: u32,
    /// Number of thread cycles in this half cycle.
    runs: u32,
    /// Duration of the oscillation in seconds, without this half cycle.
    time: f64,
    /// Largest error in this half cycle.
    peak: f64,
    /// Contribution of the peaks so far to the average of all.
    average: f64,
    /// Ultimate gain.
    pub(crate) gain: f64,
    /// Ultimate period, in seconds.
    pub(crate) period: f64,
}

impl Tuner {
    /// Returns whether tuning controls the loop.
    pub(crate) fn is_on(&self) -> bool {
        self.state != State::Off
    }

    /// Runs one cycle of tuning; a state that sets no output leaves the output unchanged.
    pub(crate) fn run(&mut self, pins: &Pins, error: f64, ns: u32) {
        let mode = pins.tune_mode.get();
        match self.state {
            State::Off => self.rest(pins, 0.0, State::Idle),
            _ if !mode => self.end(pins, State::Off),
            _ if !pins.enable.get() => self.end(pins, State::Idle),
            State::Idle => {
                if pins.tune_start.get() {
                    self.state = State::Start;
                }
            }
            State::Start => {
                *self = Self { state: State::Positive, ..Self::default() };
                pins.output.set(pins.bias.get() + effort(pins));
            }
            State::Positive | State::Negative => self.swing(pins, error, ns),
        }
    }

    /// Runs one cycle of the oscillation.
    fn swing(&mut self, pins: &Pins, error: f64, ns: u32) {
        self.runs = self.runs.wrapping_add(1);
        self.peak = if error.abs() > self.peak { error.abs() } else { self.peak };
        let now = if error < 0.0 { State::Negative } else { State::Positive };
        if now != self.state {
            self.state = now;
            self.average += self.peak / f64::from(pins.tune_cycles.get());
            // In 32 bits, as in LinuxCNC: a half cycle of more than 4.29 s wraps to a shorter time.
            self.time += f64::from(self.runs.wrapping_mul(ns)) * 1e-9;
            (self.runs, self.peak) = (0, 0.0);
            self.cycles = self.cycles.wrapping_add(1);
        }
        // `tune-cycles` may have been reduced meanwhile; without a complete half cycle there is no result.
        if self.cycles > 0 && self.cycles >= pins.tune_cycles.get() {
            self.conclude(pins);
            return;
        }
        let effort = effort(pins);
        let effort = if now == State::Negative { -effort } else { effort };
        pins.output.set(pins.bias.get() + effort);
    }

    /// Sets the gains from the measurement.
    fn conclude(&mut self, pins: &Pins) {
        self.gain = 4.0 * effort(pins) / (PI * self.average);
        self.period = 2.0 * self.time / f64::from(pins.tune_cycles.get());
        pins.ff0.set(0.0);
        pins.ff2.set(0.0);
        if pins.tune_type.get() == 0 {
            pins.p_gain.set(0.6 * self.gain);
            pins.i_gain.set(1.2 * self.gain / self.period);
            pins.d_gain.set(0.075 * self.gain * self.period);
            pins.ff1.set(0.0);
        } else {
            pins.p_gain.set(0.45 * self.gain);
            pins.i_gain.set(0.54 * self.gain / self.period);
            pins.d_gain.set(0.0);
            pins.ff1.set(1.0);
        }
        self.end(pins, State::Idle);
    }

    fn end(&mut self, pins: &Pins, next: State) {
        pins.tune_start.set(false);
        self.rest(pins, pins.bias.get(), next);
    }

    fn rest(&mut self, pins: &Pins, output: f64, state: State) {
        pins.output.set(output);
        self.state = state;
    }
}

fn effort(pins: &Pins) -> f64 {
    pins.tune_effort.get().abs()
}
