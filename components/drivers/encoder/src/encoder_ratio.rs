//! `encoder_ratio`.
use hal_component::{
    Arg, Builder, Channels, Component, Error, Gives, In, Io, Out, Period, Takes, Touch, Update,
    abi::{ArgSpec, component_flags},
    pins,
};
use std::sync::atomic::{AtomicI32, Ordering::Relaxed};

/// Electronic gear.
pub(crate) struct EncoderRatio;

impl Component for EncoderRatio {
    const NAME: &'static str = "encoder_ratio";
    const DOC: &'static str = "Electronic gear: the error of a slave axis relative to its \
        master.\n\n\
        `num_chan=2` makes `encoder-ratio.0` and `encoder-ratio.1`, `names=x,y` makes `x` and `y`; 1 to 8. \
        The error goes to a position loop that moves the slave: it grows as the slave turns, and, while \
        enabled, shrinks as the master does, in the ratio of the teeth. New numbers of pulses and \
        teeth apply from the next run of `update` on, to the whole error; if one of them is 0, \
        the error is 0.\n\n\
        # Example\n\n\
        The master turns by one of 100 pulses, at a ratio of 3 to 2.\n\n\
        ```hal\n\
        loadrt encoder_ratio\n\
        loadrt threads name1=servo period1=1000000\n\
        addf encoder-ratio.sample servo\n\
        addf encoder-ratio.update servo\n\
        setp encoder-ratio.0.master-ppr 100\n\
        setp encoder-ratio.0.slave-ppr 100\n\
        setp encoder-ratio.0.master-teeth 3\n\
        setp encoder-ratio.0.slave-teeth 2\n\
        setp encoder-ratio.0.enable 1\n\
        start\n\
        run 1ms\n\
        setp encoder-ratio.0.master-A 1\n\
        run 1ms\n\
        getp encoder-ratio.0.error # -> -0.015\n\
        ```";
    const FLAGS: u32 = component_flags::ONCE;
    const ARGS: &'static [&'static ArgSpec] = &[
        &Arg::int("num_chan", "Number of pairs; 0 is taken as 1.").within(0.0, 8.0),
        &Arg::texts("names", "Names of the pairs, instead of `num_chan=`; at most 8.").at_most(8),
    ];

    fn create(b: &mut Builder<'_>) -> Result<(), Error> {
        let channels = Channels { prefix: "encoder-ratio", usual: 1 };
        let (mut samples, mut updates) = (Vec::new(), Vec::new());
        for name in channels.names(b)? {
            let pins = Pins::make(b, &name)?;
            let (gives, raw) = b.shared(AtomicI32::new(0));
            let (master_step, takes_master) = b.shared(AtomicI32::new(0));
            let (slave_step, takes_slave) = b.shared(AtomicI32::new(0));
            samples.push(Sample {
                lines: [pins.master_a, pins.master_b, pins.slave_a, pins.slave_b],
                enable: pins.enable,
                raw: gives,
                master_step: takes_master,
                slave_step: takes_slave,
                master: 0,
                slave: 0,
            });
            updates.push(Tell { pins, raw, master_step, slave_step, whole: 0 });
        }
        let all = Samples { pairs: samples };
        b.fast_function("encoder-ratio.sample", "Counts, for all pairs.", all)?;
        let all = Updates { pairs: updates };
        b.function("encoder-ratio.update", "The errors of all pairs.", all)
    }
}

pins! {
    /// Pins of a pair.
    struct Pins {
        /// Phase A of the master's encoder.
        master_a: In<bool> = "master-A", false;
        /// Phase B of the master's encoder.
        master_b: In<bool> = "master-B", false;
        /// Phase A of the slave's encoder.
        slave_a: In<bool> = "slave-A", false;
        /// Phase B of the slave's encoder.
        slave_b: In<bool> = "slave-B", false;
        /// TRUE counts the master.
        enable: In<bool> = "enable", false;
        /// Lead of the slave over the master, in turns.
        error: Out<f64> = "error", 0.0;
        /// Counts per turn of the master, with all four edges of a pulse.
        master_ppr: Io<u32> = "master-ppr", 0;
        /// Counts per turn of the slave, with all four edges of a pulse.
        slave_ppr: Io<u32> = "slave-ppr", 0;
        /// Number of teeth of the master's wheel.
        master_teeth: Io<u32> = "master-teeth", 0;
        /// Number of teeth of the slave's wheel.
        slave_teeth: Io<u32> = "slave-teeth", 0;
    }
}

/// Returns the direction of a quadrature step: 1, -1, or 0 if there was none or a step was missed.
fn counted(was: u8, now: u8) -> i32 {
    // Phase A is bit 0, phase B is bit 1.
    const NEXT: [u8; 4] = [1, 3, 0, 2];
    let next = |of: u8| NEXT.get(usize::from(of)).copied();
    if was == now {
        0
    } else if next(was) == Some(now) {
        1
    } else if next(now) == Some(was) {
        -1
    } else {
        0
    }
}

#[derive(Touch)]
struct Sample {
    lines: [In<bool>; 4],
    enable: In<bool>,
    raw: Gives<AtomicI32>,
    master_step: Takes<AtomicI32>,
    slave_step: Takes<AtomicI32>,
    #[state]
    master: u8,
    #[state]
    slave: u8,
}

impl Sample {
    fn count(&mut self) {
        let [a, b, c, d] = self.lines.map(|l| u8::from(l.get()));
        let (master, slave) = (a | b << 1, c | d << 1);
        let mut raw = self.raw.load(Relaxed);
        if self.enable.get() {
            let step = self.master_step.load(Relaxed);
            raw = raw.wrapping_sub(step.wrapping_mul(counted(self.master, master)));
        }
        let step = self.slave_step.load(Relaxed);
        raw = raw.wrapping_add(step.wrapping_mul(counted(self.slave, slave)));
        self.raw.store(raw, Relaxed);
        (self.master, self.slave) = (master, slave);
    }
}

#[derive(Touch)]
struct Samples {
    pairs: Vec<Sample>,
}

impl Update for Samples {
    fn update(&mut self, _: Period) {
        self.pairs.iter_mut().for_each(Sample::count);
    }
}

#[derive(Touch)]
struct Tell {
    pins: Pins,
    raw: Takes<AtomicI32>,
    master_step: Gives<AtomicI32>,
    slave_step: Gives<AtomicI32>,
    /// Raw counts per turn.
    #[state]
    whole: u32,
}

impl Tell {
    fn tell(&mut self) {
        let p = &self.pins;
        let raw = f64::from(self.raw.load(Relaxed));
        p.error.set(if self.whole == 0 { 0.0 } else { raw / f64::from(self.whole) });
        let (master, slave) = (p.master_ppr.get(), p.slave_ppr.get());
        let of_slave = master.wrapping_mul(p.slave_teeth.get());
        let of_master = slave.wrapping_mul(p.master_teeth.get());
        self.slave_step.store(of_slave.cast_signed(), Relaxed);
        self.master_step.store(of_master.cast_signed(), Relaxed);
        self.whole = of_slave.wrapping_mul(slave);
    }
}

#[derive(Touch)]
struct Updates {
    pairs: Vec<Tell>,
}

impl Update for Updates {
    fn update(&mut self, _: Period) {
        self.pairs.iter_mut().for_each(Tell::tell);
    }
}

#[cfg(test)]
mod tests {
    use super::EncoderRatio;
    use hal_bench::{Bench, trace::replay};

    #[test]
    fn slave_and_master() {
        let rows = "load encoder_ratio names=g
            set g.master-ppr 10
            set g.slave-ppr 10
            set g.master-teeth 3
            set g.slave-teeth 2
            within 1e-12
            run encoder-ratio.sample encoder-ratio.update
            in g.master-A g.master-B g.slave-A g.slave-B g.enable
            out g.error
            0 0 0 0 0 | 0
            0 0 1 0 0 | 0.1
            0 0 1 1 0 | 0.2
            0 0 1 0 0 | 0.1
            1 0 1 0 0 | 0.1
            1 1 1 0 1 | -0.05
            0 1 1 0 1 | -0.2
            1 1 1 0 1 | -0.05
            0 0 0 1 1 | -0.05";
        assert_eq!(replay::<EncoderRatio>(rows), 9);
    }

    #[test]
    fn refusals() {
        let said = Bench::new().load::<EncoderRatio>(&["num_chan=9"]).unwrap_err();
        assert_eq!(said, "`9' out of range for parameter `num_chan=9'");
    }
}
