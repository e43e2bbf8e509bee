//! `counter`.
use hal_component::{
    Arg, Builder, Component, Error, Gives, In, Io, Out, Period, Takes, Touch, Update,
    abi::{ArgSpec, component_flags},
    pins,
};
use std::sync::atomic::{
    AtomicBool, AtomicI32,
    Ordering::{Acquire, Release},
};

/// Pulse counters.
pub(crate) struct Counter;

impl Component for Counter {
    const NAME: &'static str = "counter";
    const DOC: &'static str = "Counts the pulses of one line, such as a spindle's sensor.\n\n\
        `num_chan=2` makes `counter.0` and `counter.1`; 1 to 8. `encoder` with `counter-mode` does \
        this better; it is here for scripts that have it. `counter.update-counters` belongs in the \
        fastest thread, `counter.capture-position` in a slower one.\n\n\
        # Example\n\n\
        ```hal\n\
        loadrt counter\n\
        loadrt threads name1=servo period1=1000000\n\
        addf counter.update-counters servo\n\
        addf counter.capture-position servo\n\
        start\n\
        setp counter.0.position-scale 2\n\
        run 1ms\n\
        setp counter.0.phase-A 1\n\
        run 1ms\n\
        setp counter.0.phase-A 0\n\
        run 1ms\n\
        setp counter.0.phase-A 1\n\
        run 2ms\n\
        getp counter.0.counts # -> 2\n\
        getp counter.0.position # -> 1\n\
        ```";
    const FLAGS: u32 = component_flags::ONCE;
    const ARGS: &'static [&'static ArgSpec] =
        &[&Arg::int("num_chan", "Number of channels.").within(1.0, 8.0).or("1")];

    fn create(b: &mut Builder<'_>) -> Result<(), Error> {
        let channels = b.arg_int("num_chan").unwrap_or(1);
        let (mut counts, mut captures) = (Vec::new(), Vec::new());
        for i in 0..channels {
            let pins = Pins::make(b, &format!("counter.{i}"))?;
            let (gives, takes) = b.shared(Index::default());
            counts.push(Count {
                phase_a: pins.phase_a,
                phase_z: pins.phase_z,
                rawcounts: pins.rawcounts,
                index_enable: pins.index_enable,
                index: gives,
                a_was: false,
                z_was: false,
            });
            captures.push(Capture { pins, index: takes, raw: 0, zero: 0, scale: 1.0, unit: 1.0 });
        }
        b.fast_function(
            "counter.update-counters",
            "Counts, for all channels.",
            Counts { channels: counts },
        )?;
        let captures = Captures { channels: captures };
        b.function("counter.capture-position", "Positions and speeds of all channels.", captures)
    }
}

pins! {
    /// Pins of a channel.
    struct Pins {
        /// Pulse input; its rising edges are counted.
        phase_a: In<bool> = "phase-A", false;
        /// Index pulse, once per turn.
        phase_z: In<bool> = "phase-Z", false;
        /// While true, waits for the index; the index sets it to false, and the position to zero.
        index_enable: Io<bool> = "index-enable", false;
        /// While true, the position is zero.
        reset: In<bool> = "reset", false;
        /// Raw count, which neither index nor reset changes.
        rawcounts: Out<i32> = "rawcounts", 0, measured;
        /// Count since the last index or reset.
        counts: Out<i32> = "counts", 0, measured;
        /// Position, in units.
        position: Out<f64> = "position", 0.0, measured;
        /// Speed, in units per second.
        velocity: Out<f64> = "velocity", 0.0;
        /// Counts per unit; a negative value reverses the direction. A value closer to 0 than 1e-20 is set to 1.
        position_scale: Io<f64> = "position-scale", 1.0;
    }
}

/// Index data that counting and capturing exchange.
#[derive(Debug, Default)]
struct Index {
    /// True if the index came.
    came: AtomicBool,
    /// Raw count at the index.
    raw: AtomicI32,
    /// True if the next index counts, as of the last capture.
    armed: AtomicBool,
}

/// State of a channel in the fast function.
#[derive(Touch)]
struct Count {
    phase_a: In<bool>,
    phase_z: In<bool>,
    index_enable: Io<bool>,
    rawcounts: Out<i32>,
    index: Gives<Index>,
    #[state]
    a_was: bool,
    #[state]
    z_was: bool,
}

/// `counter.update-counters`.
#[derive(Touch)]
struct Counts {
    channels: Vec<Count>,
}

impl Update for Counts {
    fn update(&mut self, _: Period) {
        for c in &mut self.channels {
            let (a, z) = (c.phase_a.get(), c.phase_z.get());
            if a && !c.a_was {
                c.rawcounts.set(c.rawcounts.get().wrapping_add(1));
            }
            let armed = c.index.armed.load(Acquire); // Pairs with `Captures`.
            if z && !c.z_was && armed {
                c.index.raw.store(c.rawcounts.get(), Release); // Pairs with `Captures`.
                c.index.came.store(true, Release); // Pairs with `Captures`.
                c.index_enable.set(false);
            }
            (c.a_was, c.z_was) = (a, z);
        }
    }
}

/// State of a channel in the slow function.
#[derive(Touch)]
struct Capture {
    pins: Pins,
    index: Takes<Index>,
    #[state]
    raw: i32,
    #[state]
    zero: i32,
    #[state]
    scale: f64,
    /// Units per count.
    #[state]
    unit: f64,
}

/// `counter.capture-position`.
#[derive(Touch)]
struct Captures {
    channels: Vec<Capture>,
}

impl Update for Captures {
    fn update(&mut self, period: Period) {
        for c in &mut self.channels {
            let p = &c.pins;
            if c.index.came.swap(false, Acquire) {
                c.zero = c.index.raw.load(Acquire); // Pairs with `Counts`.
            }
            c.index.armed.store(p.index_enable.get(), Release); // Pairs with `Counts`.
            if p.reset.get() {
                p.rawcounts.set(0);
                (c.raw, c.zero) = (0, 0);
            }
            let raw = p.rawcounts.get();
            let scale = p.position_scale.get();
            if scale != c.scale {
                // Stored as given: a second 0 is not corrected and has no effect.
                c.scale = scale;
                if scale.abs() < 1e-20 {
                    p.position_scale.set(1.0);
                }
                c.unit = 1.0 / p.position_scale.get();
            }
            let moved = raw.wrapping_sub(c.raw);
            c.raw = raw;
            let counts = raw.wrapping_sub(c.zero);
            p.counts.set(counts);
            p.position.set(f64::from(counts) * c.unit);
            p.velocity.set(f64::from(moved) * c.unit * 1e9 / period.ns() as f64);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::Counter;
    use hal_bench::{Bench, trace::replay};

    #[test]
    fn as_recorded() {
        assert_eq!(replay::<Counter>(include_str!("../traces/counter.txt")), 560);
    }

    #[test]
    fn refusals() {
        for n in [0, 9, -1] {
            let refused = Bench::new().load::<Counter>(&[&format!("num_chan={n}")]).unwrap_err();
            assert_eq!(refused, format!("`{n}' out of range for parameter `num_chan={n}'"));
        }
    }
}
