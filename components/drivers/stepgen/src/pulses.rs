//! Realtime. `stepgen.make-pulses`: converts rates to edges, once per fast period.

use crate::{
    handover::{Base, HALF, Made, STEP, Wanted, steps},
    params::Params,
    stepgen::Channel,
    types::StepType,
};
use hal_component::{Error, Gives, In, Out, ParamRo, Period, Takes, Touch, Update, Uses};
use std::borrow::Cow;

/// Function `stepgen.make-pulses`.
#[derive(Touch)]
pub(crate) struct MakePulses {
    pub(crate) channels: Vec<Pulses>,
    pub(crate) base: Gives<Base>,
    #[state]
    pub(crate) base_ns: i64,
}

impl Update for MakePulses {
    fn update(&mut self, period: Period) {
        let ns = period.ns();
        if self.base_ns != ns {
            self.base_ns = ns;
            self.base.set(ns);
        }
        for channel in &mut self.channels {
            channel.update(ns);
        }
    }
}

/// State of one channel.
///
/// Three timers start with each step and expire in turn: the pulse ends, the direction may change, and a step in the
/// other direction may follow.
#[derive(Touch)]
pub(crate) struct Pulses {
    enable: In<bool>,
    rawcounts: ParamRo<i32>,
    params: Params,
    outputs: Outputs,
    wanted: Takes<Wanted>,
    made: Gives<Made>,
    #[state]
    stops: u32,
    #[state]
    rate: i64,
    #[state]
    accum: i64,
    #[state]
    pulse_left: i64,
    #[state]
    turn_left: i64,
    #[state]
    back_left: i64,
    #[state]
    waiting: bool,
    #[state]
    backward: bool,
}

impl Pulses {
    pub(crate) fn new(
        c: &mut Channel<'_, '_>,
        kind: &StepType,
        (enable, params): (In<bool>, Params),
        (wanted, made): (Takes<Wanted>, Gives<Made>),
    ) -> Result<Self, Error> {
        const RAW: &str = "Position in steps, fresh in every period of make-pulses; it wraps";
        Ok(Self {
            enable,
            rawcounts: c.item("rawcounts", RAW, 0)?,
            params,
            outputs: Outputs::new(c, kind)?,
            wanted,
            made,
            stops: 0,
            rate: 0,
            accum: HALF,
            pulse_left: 0,
            turn_left: 0,
            back_left: 0,
            waiting: false,
            backward: false,
        })
    }

    #[inline]
    fn update(&mut self, ns: i64) {
        self.pass(ns);
        let stops = self.wanted.stops();
        if self.stops != stops {
            self.stops = stops;
            self.rate = 0;
        }
        let enabled = self.enable.get();
        if enabled && !self.waiting {
            self.accelerate();
        }
        let step = enabled && !self.waiting && self.advance();
        if self.turn_left == 0 && self.rate != 0 {
            self.backward = self.rate < 0;
        }
        if step {
            let t = self.params.get();
            self.pulse_left = i64::from(t.len);
            self.turn_left = self.pulse_left + i64::from(t.hold);
            self.back_left = self.turn_left + i64::from(t.setup);
        }
        self.outputs.show(step, self.pulse_left != 0, self.backward);
    }

    /// Advances the timers.
    #[inline]
    const fn pass(&mut self, ns: i64) {
        if self.back_left == 0 {
            return;
        }
        self.pulse_left = left(self.pulse_left, ns);
        self.turn_left = left(self.turn_left, ns);
        self.back_left = left(self.back_left, ns);
        if self.back_left == 0 {
            self.waiting = false;
        }
    }

    /// Moves the rate toward the requested rate; a reversal may have to wait.
    #[inline]
    fn accelerate(&mut self) {
        let (wanted, ramp) = self.wanted.rate();
        let was = self.rate;
        let lack = wanted.wrapping_sub(was);
        self.rate = if ramp == 0 || (-ramp <= lack && lack <= ramp) {
            wanted
        } else if lack > 0 {
            was.wrapping_add(ramp)
        } else {
            was.wrapping_sub(ramp)
        };
        if (was < 0) != (self.rate < 0) && self.back_left != 0 {
            self.waiting = true;
        }
    }

    /// Advances the accumulator by one period. Returns whether this makes a step.
    #[inline]
    fn advance(&mut self) -> bool {
        let was = self.accum;
        self.accum = was.wrapping_add(self.rate);
        self.made.set(self.accum);
        self.rawcounts.set(steps(self.accum));
        (was ^ self.accum) & STEP != 0
    }
}

#[inline]
const fn left(time: i64, ns: i64) -> i64 {
    if time > ns { time - ns } else { 0 }
}

/// Output pins of one channel.
enum Outputs {
    StepDir { step: Out<bool>, dir: Out<bool> },
    UpDown { up: Out<bool>, down: Out<bool> },
    Phases { pins: Vec<Out<bool>>, cycle: Cow<'static, [u8]>, state: usize },
}

impl Outputs {
    fn new(c: &mut Channel<'_, '_>, kind: &StepType) -> Result<Self, Error> {
        let mut pin = |name, doc| c.item(name, doc, false);
        Ok(match kind {
            StepType::StepDir => Self::StepDir {
                step: pin("step", "Step pulse, true for steplen")?,
                dir: pin("dir", "Direction of the steps: false forward, true backward")?,
            },
            StepType::UpDown => Self::UpDown {
                up: pin("up", "Pulse of a step forward, true for steplen")?,
                down: pin("down", "Pulse of a step backward, true for steplen")?,
            },
            StepType::Phases { phases, cycle } => {
                let names = ["phase-A", "phase-B", "phase-C", "phase-D", "phase-E"];
                let doc = "A phase of the motor; all of them move on together, one state per step";
                let pins: Result<_, _> = names.iter().take(*phases).map(|n| pin(n, doc)).collect();
                Self::Phases { pins: pins?, cycle: cycle.clone(), state: 0 }
            }
        })
    }

    #[inline]
    fn show(&mut self, stepped: bool, pulse: bool, backward: bool) {
        match self {
            Self::StepDir { step, dir } => {
                step.set(pulse);
                dir.set(backward);
            }
            Self::UpDown { up, down } => {
                up.set(pulse && !backward);
                down.set(pulse && backward);
            }
            Self::Phases { pins, cycle, state } => {
                if stepped {
                    let last = cycle.len().saturating_sub(1);
                    *state = match (backward, *state) {
                        (false, s) if s >= last => 0,
                        (false, s) => s + 1,
                        (true, 0) => last,
                        (true, s) => s - 1,
                    };
                }
                let bits = cycle.get(*state).copied().unwrap_or(0);
                for (bit, pin) in pins.iter().enumerate() {
                    pin.set(bits >> bit & 1 != 0);
                }
            }
        }
    }
}

impl Touch for Outputs {
    fn touch(&self, uses: &mut Uses) {
        match self {
            Self::StepDir { step: a, dir: b } | Self::UpDown { up: a, down: b } => {
                a.touch(uses);
                b.touch(uses);
            }
            Self::Phases { pins, .. } => pins.touch(uses),
        }
    }
}
