//! `encoder`.
use crate::{
    capture::{Capture, CapturePosition},
    count::{Channel, UpdateCounters},
    handover::{Notes, TimeBase},
};
use hal_component::{
    Arg, Builder, Channels, Component, Error, In, InSet, Io, Out,
    abi::{ArgSpec, component_flags},
    pins,
};

#[cfg(test)]
mod closed;

const CHANNELS: Channels = Channels { prefix: "encoder", usual: 3 };

/// Quadrature encoder counters.
pub(crate) struct Encoder;

impl Component for Encoder {
    const NAME: &'static str = "encoder";
    const DOC: &'static str = "Counts the pulses of encoders: position and speed.\n\n\
        `num_chan=2` makes `encoder.0` and `encoder.1`, `names=x,z` makes `x` and `z`, nothing makes \
        three; at most 8. `encoder.update-counters` reads the phases and belongs in the fastest \
        thread: a phase that changes twice between two runs loses counts. \
        `encoder.capture-position` computes positions and speeds, in a slower one.\n\n\
        If A leads B it counts up, with four counts per cycle. With `index-enable` true, the next \
        rising edge of Z makes the position zero there and `index-enable` false. The speed is \
        computed from the time between counts, not from the number of counts in a period.\n\n\
        # Example\n\n\
        ```hal\n\
        loadrt encoder num_chan=1\n\
        loadrt threads name1=servo period1=1000000\n\
        addf encoder.update-counters servo\n\
        addf encoder.capture-position servo\n\
        start\n\
        setp encoder.0.position-scale 4\n\
        run 1ms\n\
        setp encoder.0.phase-A 1\n\
        run 1ms\n\
        setp encoder.0.phase-B 1\n\
        run 1ms\n\
        setp encoder.0.phase-A 0\n\
        run 1ms\n\
        setp encoder.0.phase-B 0\n\
        run 1ms\n\
        getp encoder.0.counts # -> 4\n\
        getp encoder.0.position # -> 1\n\
        ```";
    const FLAGS: u32 = component_flags::ONCE;
    const ARGS: &'static [&'static ArgSpec] = &[
        &Arg::int("num_chan", "Number of channels; 0 is taken as 3.").within(0.0, 8.0),
        &Arg::texts("names", "Names of the channels, instead of `num_chan=`; at most 8.")
            .at_most(8),
    ];

    fn create(b: &mut Builder<'_>) -> Result<(), Error> {
        let names = CHANNELS.names(b)?;
        let (gives_time, takes_time) = b.shared(TimeBase::default());
        let mut count =
            UpdateCounters { channels: Vec::with_capacity(names.len()), time: gives_time };
        let mut capture =
            CapturePosition { channels: Vec::with_capacity(names.len()), time: takes_time };
        for name in names {
            let pins = Pins::make(b, &name)?;
            let (gives, takes) = b.shared(Notes::default());
            count.channels.push(Channel::new(&pins, gives));
            capture.channels.push(Capture::new(pins, takes));
        }
        b.fast_function("encoder.update-counters", "Counts, for all channels.", count)?;
        b.function("encoder.capture-position", "Positions and speeds of all channels.", capture)
    }
}

pins! {
    /// Pins of a channel.
    pub(crate) struct Pins {
        /// Encoder phase A.
        phase_a: In<bool> = "phase-A", false;
        /// Encoder phase B, a quarter of a cycle later than A in forward direction.
        phase_b: In<bool> = "phase-B", false;
        /// Index pulse, once per turn.
        phase_z: In<bool> = "phase-Z", false;
        /// While true, the position is zero.
        reset: In<bool> = "reset", false;
        /// While true, waits for the index; the index sets it to false, and the position to zero.
        index_enable: Io<bool> = "index-enable", false;
        /// Latch input; its edges store the position.
        latch_input: In<bool> = "latch-input", false;
        /// TRUE: the rising edge of `latch-input` stores the position.
        latch_rising: In<bool> = "latch-rising", true;
        /// TRUE: the falling edge of `latch-input` stores the position.
        latch_falling: In<bool> = "latch-falling", true;
        /// TRUE counts every edge of both phases (x4); FALSE counts one per quadrature cycle.
        x4_mode: Io<bool> = "x4-mode", true;
        /// TRUE counts only the rising edges of A, upward.
        counter_mode: Io<bool> = "counter-mode", false;
        /// With `counter-mode`: number of teeth that a gear lacks at the index; 0: none. Set it while the gear turns:
        /// when the gear starts from rest at constant speed, every tooth is taken for a gap, as in LinuxCNC.
        missing_teeth: In<i32> = "missing-teeth", 0;
        /// Counts per unit; a negative value reverses the direction. A value closer to 0 than 1e-20 is set to 1.
        position_scale: Io<f64> = "position-scale", 1.0;
        /// Lowest speed that is estimated, in units per second: without a count for `position-scale` divided by this,
        /// in seconds, the speed is 0. A value of 0 counts as 1; with a negative scale it must be negative.
        min_speed_estimate: InSet<f64> = "min-speed-estimate", 1.0;
        /// Raw count, which neither index nor reset changes.
        rawcounts: Out<i32> = "rawcounts", 0, measured;
        /// Count since the last index or reset.
        counts: Out<i32> = "counts", 0, measured;
        /// Position, in units.
        position: Out<f64> = "position", 0.0, measured;
        /// Position interpolated between counts from the speed, in units.
        position_interpolated: Out<f64> = "position-interpolated", 0.0, measured;
        /// Count at the last edge of `latch-input`.
        counts_latched: Out<i32> = "counts-latched", 0;
        /// Position at the last edge of `latch-input`, in units.
        position_latched: Out<f64> = "position-latched", 0.0;
        /// Speed, in units per second.
        velocity: Out<f64> = "velocity", 0.0;
        /// Speed, in units per minute.
        velocity_rpm: Out<f64> = "velocity-rpm", 0.0;
    }
}

#[cfg(test)]
mod tests {
    use super::Encoder;
    use hal_bench::{Bench, trace::replay};

    #[test]
    fn as_recorded() {
        assert_eq!(replay::<Encoder>(include_str!("../traces/encoder.txt")), 2248);
    }

    #[test]
    fn names_and_numbers() {
        for (args, wanted) in [
            (&[][..], Ok(3)),
            (&["num_chan=0"], Ok(3)),
            (&["num_chan=8"], Ok(8)),
            (&["names=a,,b"], Ok(1)),
            (&["num_chan=9"], Err("`9' out of range for parameter `num_chan=9'")),
            (&["num_chan=1", "names=a"], Err("num_chan= and names= are mutually exclusive")),
        ] {
            let mut bench = Bench::new();
            let made = bench.load::<Encoder>(args).map(|()| bench.names().len() / 21);
            assert_eq!(made, wanted.map_err(str::to_owned), "{args:?}");
        }
    }

    #[test]
    fn a_count_that_wraps() {
        let mut bench = Bench::new();
        bench.load::<Encoder>(&["names=x"]).unwrap();
        assert_eq!(bench.functs(), ["encoder.capture-position", "encoder.update-counters"]);
        // Ten counts between two captures: the speed is that of all of them.
        for _ in 0..20 {
            for (a, b) in [(true, false), (true, true), (false, true), (false, false)] {
                bench.set("x.phase-A", a);
                bench.set("x.phase-B", b);
                bench.run("encoder.update-counters", 50_000);
            }
            bench.run("encoder.capture-position", 200_000);
        }
        assert_eq!(bench.get::<i32>("x.counts"), 80);
        assert_eq!(bench.get::<f64>("x.velocity"), 20_000.0);
    }
}
