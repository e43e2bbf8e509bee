//! Realtime. Pulse generation: the fast function of `pwmgen`.

use crate::handover::{Base, Mode, Wanted};
use hal_component::{Gives, Out, Period, Takes, Touch, Update, Uses};

/// Outputs of a channel, by its type.
pub(crate) enum Outputs {
    /// Types 0 and 1.
    One { pwm: Out<bool> },
    /// Type 2.
    UpDown { up: Out<bool>, down: Out<bool> },
}

impl Touch for Outputs {
    fn touch(&self, uses: &mut Uses) {
        match self {
            Self::One { pwm } => pwm.touch(uses),
            Self::UpDown { up: a, down: b } => {
                a.touch(uses);
                b.touch(uses);
            }
        }
    }
}

/// State of one channel in the fast function.
#[derive(Touch)]
pub(crate) struct Channel {
    outputs: Outputs,
    wanted: Takes<Wanted>,
    /// True while the pulse is on.
    #[state]
    is_high: bool,
    /// Nanoseconds of this pulse so far, or the error carried over to it.
    #[state]
    high: i64,
    /// Nanoseconds of this period so far.
    #[state]
    period: i64,
}

impl Channel {
    pub(crate) fn new(outputs: Outputs, wanted: Takes<Wanted>) -> Self {
        Self { outputs, wanted, is_high: false, high: 0, period: 0 }
    }

    fn run(&mut self, base: i64) {
        let (mode, period, high, down) = self.wanted.get();
        match mode {
            Mode::Off => (self.is_high, self.high, self.period) = (false, 0, 0),
            Mode::Pure => {
                if self.is_high {
                    self.high += base;
                    if self.high >= high {
                        self.is_high = false;
                    }
                }
                self.period += base;
                if self.period >= period {
                    (self.period, self.high) = (0, 0);
                    self.is_high = high > 0;
                }
            }
            Mode::Dither => {
                if self.is_high {
                    self.high -= base;
                    if self.high <= 0 {
                        self.is_high = false;
                    }
                }
                self.period += base;
                if self.period >= period {
                    self.period -= period;
                    self.high += high;
                    self.is_high = self.high > 0;
                }
            }
            Mode::Density => {
                self.high += high;
                if self.is_high {
                    self.high -= base;
                }
                self.is_high = self.high > 0;
            }
        }
        match &self.outputs {
            Outputs::One { pwm } => pwm.set(self.is_high),
            Outputs::UpDown { up, down: back } => {
                up.set(self.is_high && !down);
                back.set(self.is_high && down);
            }
        }
    }
}

/// `pwmgen.make-pulses`.
#[derive(Touch)]
pub(crate) struct MakePulses {
    pub(crate) channels: Vec<Channel>,
    pub(crate) base: Gives<Base>,
}

impl Update for MakePulses {
    fn update(&mut self, period: Period) {
        self.base.set(period.ns());
        for c in &mut self.channels {
            c.run(period.ns());
        }
    }
}
