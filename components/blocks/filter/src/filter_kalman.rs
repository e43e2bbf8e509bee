//! `filter_kalman`.
use hal_component::{
    Builder, Component, Error, In, Messages, Out, ParamRw, Period, Touch, Update,
    abi::component_flags,
};

#[cfg(test)]
mod closed;

/// Variance of the initial estimate.
const FIRST: f32 = 1.0;
/// Default of the variances: nearly 0.
const LEAST: f64 = 1.17549e-38;

/// Kalman filter of one number.
#[derive(Touch)]
pub(crate) struct FilterKalman {
    debug: In<bool>,
    passthrough: In<bool>,
    reset: In<bool>,
    measured: In<f64>,
    estimated: Out<f64>,
    noise: ParamRw<f64>,
    change: ParamRw<f64>,
    messages: Messages,
    /// State between cycles, in LinuxCNC's precision.
    #[state]
    estimate: f32,
    #[state]
    uncertain: f32,
}

impl Component for FilterKalman {
    const NAME: &'static str = "filter_kalman";
    const DOC: &'static str = "Kalman filter of one number, such as a noisy temperature.\n\n\
        The smaller `Qk` is relative to `Rk`, the smoother and slower the estimate. Measure to \
        find useful values: `Rk` is the variance of the sensor's noise, `Qk` that of the change \
        between two runs.\n\n\
        # Example\n\n\
        ```hal\n\
        loadrt filter_kalman\n\
        loadrt threads name1=servo period1=1000000\n\
        addf filter-kalman.0 servo\n\
        start\n\
        setp filter-kalman.0.Qk 0.5\n\
        setp filter-kalman.0.Rk 1.5\n\
        setp filter-kalman.0.zk 8\n\
        run 1ms\n\
        getp filter-kalman.0.xk-out # -> 4\n\
        run 100ms\n\
        getp filter-kalman.0.xk-out # -> 8\n\
        ```";
    const FLAGS: u32 = component_flags::PARALLEL;

    fn create(b: &mut Builder<'_>) -> Result<(), Error> {
        let doc = "True prints the measured and the estimated value in each run.";
        let debug = b.item("debug", doc, false)?;
        let doc = "True passes the measured number unfiltered; the filter then pauses.";
        let passthrough = b.item("passthrough", doc, false)?;
        let doc = "While true, the estimate is 0 and the filter as at the beginning; it goes \
            before `passthrough`.";
        let reset = b.item("reset", doc, false)?;
        let measured = b.item("zk", "The measured number, in units.", 0.0)?;
        let estimated = b.item("xk-out", "The estimated number, in units.", 0.0)?;
        let doc = "Variance of the measurement, in units squared.";
        let noise = b.item("Rk", doc, LEAST)?;
        let doc = "Variance of the change between two runs, in units squared. If both variances \
            are 0, the estimate becomes NaN.";
        let change = b.item("Qk", doc, LEAST)?;
        let messages = b.messages();
        let run = Self {
            debug,
            passthrough,
            reset,
            measured,
            estimated,
            noise,
            change,
            messages,
            estimate: 0.0,
            uncertain: FIRST,
        };
        b.function("", "Estimates.", run)
    }
}

impl Update for FilterKalman {
    fn update(&mut self, _: Period) {
        let measured = self.measured.get();
        if self.reset.get() {
            (self.estimate, self.uncertain) = (0.0, FIRST);
            self.estimated.set(0.0);
        } else if self.passthrough.get() {
            self.estimated.set(measured);
        } else {
            let before = f64::from(self.uncertain) + self.change.get();
            let gain = before / (before + self.noise.get());
            let last = f64::from(self.estimate);
            let estimate = last + gain * (measured - last);
            self.keep(estimate, (1.0 - gain) * before);
            self.estimated.set(estimate);
        }
        if self.debug.get() {
            self.messages.info("measured {}, estimated {}", &[measured, self.estimated.get()]);
        }
    }
}

impl FilterKalman {
    #[expect(clippy::cast_possible_truncation, reason = "to be kept")]
    const fn keep(&mut self, estimate: f64, uncertain: f64) {
        self.estimate = estimate as f32;
        self.uncertain = uncertain as f32;
    }
}

#[cfg(test)]
mod tests {
    use super::FilterKalman;
    use hal_bench::{Bench, trace::replay};

    #[test]
    fn the_estimate_follows() {
        // The variance is 1, then 0.75 and so on; the gains are 1/2, 5/11, 17/39.
        let rows = replay::<FilterKalman>(
            "load filter_kalman
             set filter-kalman.0.Qk 0.5
             set filter-kalman.0.Rk 1.5
             within 1e-6
             run filter-kalman.0
             in filter-kalman.0.zk filter-kalman.0.reset filter-kalman.0.passthrough
             out filter-kalman.0.xk-out
             8 0 0 | 4
             4 0 0 | 4
             9 0 1 | 9
             4 0 0 | 4
             9 1 1 | 0
             8 0 0 | 4",
        );
        assert_eq!(rows, 6);
    }

    #[test]
    fn it_comes_to_rest_where_the_theory_says() {
        // p = (p + q)·r / (p + q + r) with q = 2, r = 4 gives p = 2, so the gain converges to 1/2.
        let mut bench = Bench::new();
        bench.load::<FilterKalman>(&[]).unwrap();
        bench.set("filter-kalman.0.Qk", 2.0);
        bench.set("filter-kalman.0.Rk", 4.0);
        for _ in 0..100 {
            bench.run("filter-kalman.0", 1_000_000);
        }
        bench.set("filter-kalman.0.zk", 1.0);
        for wanted in [0.5, 0.75, 0.875] {
            bench.run("filter-kalman.0", 1_000_000);
            let is = bench.get::<f64>("filter-kalman.0.xk-out");
            assert!((is - wanted).abs() < 1e-6, "{is} {wanted}");
        }
    }

    #[test]
    fn it_tells_if_asked() {
        let mut bench = Bench::new();
        bench.load::<FilterKalman>(&[]).unwrap();
        bench.set("filter-kalman.0.debug", true);
        bench.set("filter-kalman.0.zk", 3.0);
        bench.run("filter-kalman.0", 1_000_000);
        assert!(bench.said()[0].contains("measured 3, estimated 3"));
    }
}
