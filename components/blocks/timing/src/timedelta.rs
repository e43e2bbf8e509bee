//! `timedelta`.
use hal_component::{
    Builder, Clock, Component, Error, In, Out, Period, Touch, Update, abi::component_flags,
};

/// Regularity of a thread.
#[derive(Touch)]
pub(crate) struct Timedelta {
    out: Out<i32>,
    err: Out<i32>,
    min: Out<i32>,
    max: Out<i32>,
    jitter: Out<i32>,
    current_jitter: Out<i32>,
    current_error: Out<i32>,
    avg_err: Out<f64>,
    reset: In<bool>,
    clock: Clock,
    /// Time of the previous cycle, in nanoseconds.
    #[state]
    before: Option<i64>,
    /// Sum of all errors, in nanoseconds.
    #[state]
    total: i64,
    /// Number of cycles in that sum.
    #[state]
    runs: u32,
}

impl Component for Timedelta {
    const NAME: &'static str = "timedelta";
    const DOC: &'static str = "Regularity of a thread: periods and jitter.\n\n\
        On the virtual clock a thread runs exactly at its period.\n\n\
        # Example\n\n\
        ```hal\n\
        loadrt timedelta\n\
        loadrt threads name1=servo period1=1000000\n\
        addf timedelta.0 servo\n\
        start\n\
        run 10ms\n\
        getp timedelta.0.out # -> 1000000\n\
        getp timedelta.0.jitter # -> 0\n\
        ```";
    const FLAGS: u32 = component_flags::PARALLEL;

    fn create(b: &mut Builder<'_>) -> Result<(), Error> {
        let mut pin = |name: &str, doc: &str| b.item(name, doc, 0);
        let out = pin("out", "Time since the run before, in nanoseconds.")?;
        let err = pin("err", "All errors added, in nanoseconds; it wraps at 32 bits.")?;
        let min = pin("min", "Shortest time between two runs, in nanoseconds.")?;
        let max = pin("max", "Longest time between two runs, in nanoseconds.")?;
        let doc = "Largest error of either sign since the second run, in nanoseconds.";
        let jitter = pin("jitter", doc)?;
        let doc = "Size of the error of this run, in nanoseconds.";
        let current_jitter = pin("current-jitter", doc)?;
        let doc = "Error of this run, in nanoseconds: above 0 when it came late.";
        let current_error = pin("current-error", doc)?;
        let avg_err = b.item("avg-err", "Mean error, in nanoseconds.", 0.0)?;
        let doc = "While true, nothing is measured, and `jitter`, `min` and `max` are reset.";
        let reset = b.item("reset", doc, false)?;
        let clock = b.clock();
        let run = Self {
            out,
            err,
            min,
            max,
            jitter,
            current_jitter,
            current_error,
            avg_err,
            reset,
            clock,
            before: None,
            total: 0,
            runs: 1,
        };
        b.integer_function("", "Measures.", run)
    }
}

impl Update for Timedelta {
    fn update(&mut self, period: Period) {
        let now = self.clock.now_ns();
        let Some(before) = self.before.replace(now) else {
            if self.reset.get() {
                self.before = None;
            }
            return;
        };
        let passed = now.wrapping_sub(before);
        let error = passed.wrapping_sub(period.ns());
        self.total = self.total.wrapping_add(error);
        self.runs = self.runs.wrapping_add(1);
        self.err.set(wrapped(self.total));
        self.avg_err.set(self.total as f64 / f64::from(self.runs));
        self.measure(wrapped(passed), wrapped(error));
        if self.reset.get() {
            self.before = None;
            for pin in [self.out, self.max, self.jitter, self.current_jitter, self.current_error] {
                pin.set(0);
            }
        }
    }
}

impl Timedelta {
    fn measure(&self, passed: i32, error: i32) {
        self.out.set(passed);
        if self.max.get() == 0 {
            self.min.set(passed);
            self.max.set(passed);
            return;
        }
        self.min.set(self.min.get().min(passed));
        self.max.set(self.max.get().max(passed));
        self.current_error.set(error);
        self.current_jitter.set(error.wrapping_abs());
        self.jitter.set(self.jitter.get().max(error.wrapping_abs()));
    }
}

#[expect(clippy::cast_possible_truncation, reason = "it wraps, as its pin tells")]
const fn wrapped(ns: i64) -> i32 {
    ns as i32
}

#[cfg(test)]
mod tests {
    use super::Timedelta;
    use hal_bench::Bench;

    fn ran(bench: &Bench, after: i64) {
        bench.pass(after);
        bench.run("timedelta.0", 1_000_000);
    }

    fn is(bench: &Bench, pins: &[&str]) -> Vec<i32> {
        pins.iter().map(|p| bench.get::<i32>(&format!("timedelta.0.{p}"))).collect()
    }

    #[test]
    fn early_and_late() {
        let mut bench = Bench::new();
        bench.load::<Timedelta>(&[]).unwrap();
        ran(&bench, 5);
        assert_eq!(is(&bench, &["out", "min", "max"]), [0, 0, 0]);
        ran(&bench, 1_000_000);
        assert_eq!(
            is(&bench, &["out", "min", "max", "jitter"]),
            [1_000_000; 3].into_iter().chain([0]).collect::<Vec<_>>()
        );
        ran(&bench, 1_000_400);
        ran(&bench, 999_500);
        let pins = ["out", "min", "max", "jitter", "current-jitter", "current-error", "err"];
        assert_eq!(is(&bench, &pins), [999_500, 999_500, 1_000_400, 500, 500, -500, -100]);
        assert_eq!(bench.get::<f64>("timedelta.0.avg-err"), -25.0);
    }

    #[test]
    fn reset_begins_anew() {
        let mut bench = Bench::new();
        bench.load::<Timedelta>(&[]).unwrap();
        for after in [1, 1_000_000, 3_000_000] {
            ran(&bench, after);
        }
        bench.set("timedelta.0.reset", true);
        ran(&bench, 1_000_000);
        assert_eq!(is(&bench, &["out", "max", "jitter"]), [0, 0, 0]);
        bench.set("timedelta.0.reset", false);
        ran(&bench, 9_000_000);
        ran(&bench, 1_000_000);
        assert_eq!(
            is(&bench, &["out", "min", "max", "jitter"]),
            [1_000_000, 1_000_000, 1_000_000, 0]
        );
    }
}
