//! `sim_encoder`.
use hal_component::{
    Arg, Builder, Channels, Component, Error, Gives, In, InSet, Io, Out, Period, Takes, Touch,
    Update,
    abi::{ArgSpec, component_flags},
    pins,
};
use std::sync::atomic::{
    AtomicI64,
    Ordering::{Acquire, Release},
};

const CHANNELS: Channels = Channels { prefix: "sim-encoder", usual: 1 };

/// Simulated encoders.
pub(crate) struct SimEncoder;

impl Component for SimEncoder {
    const NAME: &'static str = "sim_encoder";
    const DOC: &'static str = "Simulated encoders: two phases and an index pulse.\n\n\
        `num_chan=2` makes `sim-encoder.0` and `sim-encoder.1`, `names=x,z` makes `x` and `z`, nothing \
        makes one; at most 8. `sim-encoder.make-pulses` belongs in the fastest thread, where it can \
        move one count per run; `sim-encoder.update-speed` reads the speed, in a slower one.\n\n\
        # Example\n\n\
        ```hal\n\
        loadrt encoder num_chan=1\n\
        loadrt sim_encoder num_chan=1\n\
        loadrt threads name1=base period1=50000 name2=servo period2=1000000\n\
        addf sim-encoder.make-pulses base\n\
        addf encoder.update-counters base\n\
        addf sim-encoder.update-speed servo\n\
        addf encoder.capture-position servo\n\
        net a sim-encoder.0.phase-A encoder.0.phase-A\n\
        net b sim-encoder.0.phase-B encoder.0.phase-B\n\
        start\n\
        setp sim-encoder.0.ppr 100\n\
        setp sim-encoder.0.speed 5\n\
        setp encoder.0.position-scale 400\n\
        # The first two counts are made before the speed is known.\n\
        run 1s\n\
        getp encoder.0.counts # -> 1998\n\
        ```";
    const FLAGS: u32 = component_flags::ONCE;
    const ARGS: &'static [&'static ArgSpec] = &[
        &Arg::int("num_chan", "Number of channels; 0 is taken as 1.").within(0.0, 8.0),
        &Arg::texts("names", "Names of the channels, instead of `num_chan=`; at most 8.")
            .at_most(8),
    ];

    fn create(b: &mut Builder<'_>) -> Result<(), Error> {
        let names = CHANNELS.names(b)?;
        let (gives_base, takes_base) = b.shared(AtomicI64::new(ASSUMED_NS));
        let mut make = MakePulses { channels: Vec::with_capacity(names.len()), base: gives_base };
        let mut update =
            UpdateSpeed { channels: Vec::with_capacity(names.len()), base: takes_base };
        for name in names {
            let pins = Pins::make(b, &name)?;
            let (gives, takes) = b.shared(Rate::default());
            make.channels.push(Turning::new(&pins, takes));
            let Pins { speed, ppr, scale, .. } = pins;
            update.channels.push(Speed { speed, ppr, scale, rate: gives });
        }
        b.fast_function("sim-encoder.make-pulses", "Turns all channels.", make)?;
        b.function("sim-encoder.update-speed", "Reads the speeds of all channels.", update)
    }
}

pins! {
    /// Pins of a channel.
    struct Pins {
        /// Encoder phase A.
        phase_a: Out<bool> = "phase-A", false;
        /// Encoder phase B, a quarter of a cycle later than A in forward direction.
        phase_b: Out<bool> = "phase-B", false;
        /// Index pulse: one count long, once per turn.
        phase_z: Out<bool> = "phase-Z", false;
        /// Speed; divided by `scale`, it is in turns per second.
        speed: In<f64> = "speed", 0.0;
        /// Simulated count; the component keeps its own count if the pin is set or linked to a writer.
        rawcounts: InSet<i32> = "rawcounts", 0;
        /// Quadrature cycles per turn, each of four counts; at least 1.
        ppr: Io<u32> = "ppr", 100;
        /// Divisor of the speed; 60 for a speed in turns per minute. A value closer to 0 than 1e-20 is set to 1.
        scale: Io<f64> = "scale", 1.0;
    }
}

/// Data of a channel that the slow function passes to the fast one.
#[derive(Debug, Default)]
struct Rate {
    /// Counts per fast period, times 2^31; negative: backward.
    step: AtomicI64,
}

/// State of a channel in the slow function.
#[derive(Touch)]
struct Speed {
    speed: In<f64>,
    ppr: Io<u32>,
    scale: Io<f64>,
    rate: Gives<Rate>,
}

/// `sim-encoder.update-speed`.
#[derive(Touch)]
struct UpdateSpeed {
    channels: Vec<Speed>,
    base: Takes<AtomicI64>,
}

impl Update for UpdateSpeed {
    fn update(&mut self, _: Period) {
        let base = self.base.load(Acquire); // Pairs with `MakePulses`.
        let secs = base as f64 * 1e-9;
        for c in &mut self.channels {
            if c.ppr.get() == 0 {
                c.ppr.set(1);
            }
            let scale = c.scale.get();
            if scale.abs() < 1e-20 {
                c.scale.set(1.0);
            }
            let turns = c.speed.get() / c.scale.get();
            let rate = turns * f64::from(c.ppr.get()) * 4.0 * secs;
            c.rate.step.store(step(rate), Release); // Pairs with `Turning`.
        }
    }
}

/// Period assumed until the fast function has run, in nanoseconds.
const ASSUMED_NS: i64 = 50_000;

/// Number of fraction bits of an accumulator.
const FRACTION: u32 = 31;

/// Converts counts per period to the step of an accumulator, limited to one count.
#[expect(clippy::cast_possible_truncation, reason = "what is too fast is limited")]
fn step(rate: f64) -> i64 {
    let most = 1_i64 << FRACTION;
    ((rate * most as f64) as i64).max(-most).min(most)
}

/// State of a channel in the fast function.
#[derive(Touch)]
struct Turning {
    phase_a: Out<bool>,
    phase_b: Out<bool>,
    phase_z: Out<bool>,
    rawcounts: InSet<i32>,
    ppr: Io<u32>,
    rate: Takes<Rate>,
    /// Counts so far, times 2^31.
    #[state]
    accum: i64,
    /// Index of the count within the quadrature cycle, 0 to 3.
    #[state]
    state: u8,
    /// Index of the quadrature cycle within the turn.
    #[state]
    cycle: u32,
}

impl Turning {
    fn new(pins: &Pins, rate: Takes<Rate>) -> Self {
        let (phase_a, phase_b, phase_z) = (pins.phase_a, pins.phase_b, pins.phase_z);
        Self {
            phase_a,
            phase_b,
            phase_z,
            rawcounts: pins.rawcounts,
            ppr: pins.ppr,
            rate,
            accum: 0,
            state: 0,
            cycle: 0,
        }
    }

    fn run(&mut self) {
        let step = self.rate.step.load(Acquire); // Pairs with `UpdateSpeed`.
        let cycles = self.ppr.get();
        let before = self.accum >> FRACTION;
        self.accum = self.accum.wrapping_add(step);
        let now = self.accum >> FRACTION;
        if now > before {
            self.forth(cycles);
        } else if now < before {
            self.back(cycles);
        }
        self.phase_a.set(matches!(self.state, 0 | 1));
        self.phase_b.set(matches!(self.state, 1 | 2));
        self.phase_z.set(self.state == 0 && self.cycle == 0);
    }

    fn forth(&mut self, cycles: u32) {
        self.rawcounts.set(self.rawcounts.get().wrapping_add(1));
        self.state = (self.state + 1) % 4;
        if self.state == 0 {
            self.cycle = self.cycle.wrapping_add(1);
            if self.cycle >= cycles {
                self.cycle -= cycles;
            }
        }
    }

    fn back(&mut self, cycles: u32) {
        self.rawcounts.set(self.rawcounts.get().wrapping_sub(1));
        if self.state == 0 {
            self.state = 3;
            self.cycle = self.cycle.checked_sub(1).unwrap_or(cycles.saturating_sub(1));
        } else {
            self.state -= 1;
        }
    }
}

/// `sim-encoder.make-pulses`.
#[derive(Touch)]
struct MakePulses {
    channels: Vec<Turning>,
    base: Gives<AtomicI64>,
}

impl Update for MakePulses {
    fn update(&mut self, period: Period) {
        self.base.store(period.ns(), Release); // Pairs with `UpdateSpeed`.
        for c in &mut self.channels {
            c.run();
        }
    }
}

#[cfg(test)]
mod tests {
    use super::SimEncoder;
    use hal_bench::{Bench, trace::replay};

    #[test]
    fn as_recorded() {
        assert_eq!(replay::<SimEncoder>(include_str!("../traces/sim_encoder.txt")), 634);
    }

    #[test]
    fn names_and_numbers() {
        for (args, wanted) in [
            (&[][..], Ok(1)),
            (&["num_chan=8"], Ok(8)),
            (&["num_chan=9"], Err("`9' out of range for parameter `num_chan=9'")),
            (&["num_chan=-1"], Err("`-1' out of range for parameter `num_chan=-1'")),
        ] {
            let mut bench = Bench::new();
            let made = bench.load::<SimEncoder>(args).map(|()| bench.names().len() / 7);
            assert_eq!(made, wanted.map_err(str::to_owned), "{args:?}");
        }
    }
}
