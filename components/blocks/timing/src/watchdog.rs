//! `watchdog`.
use hal_component::{
    Arg, Builder, Component, Error, Gives, In, Out, ParamRw, Period, Takes, Touch, Update,
    abi::{ArgSpec, component_flags},
};
use std::sync::atomic::{
    AtomicI64, AtomicU32,
    Ordering::{Acquire, Release},
};

/// Watchdog for heartbeats.
pub(crate) struct Watchdog;

impl Component for Watchdog {
    const NAME: &'static str = "watchdog";
    const DOC: &'static str = "Checks that several bits, such as heartbeats, keep changing.\n\n\
        `num_inputs=2` makes `watchdog.input-0` and `watchdog.input-1`, each with a timeout. \
        `watchdog.process` checks them and belongs in a fast thread; `watchdog.set-timeouts` \
        applies the timeouts and reads `enable-in`, in a slower one.\n\n\
        # Example\n\n\
        ```hal\n\
        loadrt watchdog num_inputs=1\n\
        loadrt threads name1=servo period1=1000000\n\
        addf watchdog.process servo\n\
        addf watchdog.set-timeouts servo\n\
        start\n\
        setp watchdog.timeout-0 0.005\n\
        setp watchdog.enable-in 1\n\
        run 3ms\n\
        getp watchdog.ok-out # -> TRUE\n\
        run 10ms\n\
        getp watchdog.ok-out # -> FALSE\n\
        ```";
    const FLAGS: u32 = component_flags::ONCE;
    const ARGS: &'static [&'static ArgSpec] =
        &[&Arg::int("num_inputs", "Number of inputs.").required().within(1.0, 32.0)];

    fn create(b: &mut Builder<'_>) -> Result<(), Error> {
        let n = b.arg_int("num_inputs").unwrap_or(0);
        let enable = b.item(
            "watchdog.enable-in",
            "Starts it as it rises, also after a timeout. While false, nothing changes.",
            false,
        )?;
        let ok = b.item(
            "watchdog.ok-out",
            "True from the start on, while all inputs keep changing.",
            false,
        )?;
        let (mut beats, mut times) = (Vec::new(), Vec::new());
        for i in 0..n {
            let input = b.item(&format!("watchdog.input-{i}"), "A bit that must change.", false)?;
            let doc = "Longest time without a change, in seconds. A negative time counts as 0, NaN as 2.1 s; a \
                time of 292 years or more, also infinity, never ends. A new value applies from the next \
                change on.";
            let timeout = b.item(&format!("watchdog.timeout-{i}"), doc, 0.0)?;
            let (gives, takes) = b.shared(Limit::default());
            beats.push(Beat { input, limit: takes, was: false, left: 0 });
            times.push(Timeout { timeout, limit: gives });
        }
        let (start, starts) = b.shared(AtomicU32::new(0));
        let process = Process { enable, ok, beats, starts, seen: 0 };
        let set = SetTimeouts { enable, ok, times, start, was_enabled: false };
        b.fast_function("watchdog.process", "Checks the inputs.", process)?;
        b.function("watchdog.set-timeouts", "Applies new timeouts.", set)
    }
}

/// Time for which an input may stay the same, in nanoseconds.
#[derive(Debug, Default)]
struct Limit {
    /// Limit from the next change on.
    next: AtomicI64,
    /// Limit from the last start on.
    start: AtomicI64,
}

/// State of one monitored input.
#[derive(Touch)]
struct Beat {
    input: In<bool>,
    limit: Takes<Limit>,
    #[state]
    was: bool,
    /// Remaining time for which it may stay the same, in nanoseconds.
    #[state]
    left: i64,
}

/// `watchdog.process`.
#[derive(Touch)]
struct Process {
    enable: In<bool>,
    ok: Out<bool>,
    beats: Vec<Beat>,
    starts: Takes<AtomicU32>,
    #[state]
    seen: u32,
}

impl Update for Process {
    fn update(&mut self, period: Period) {
        let starts = self.starts.load(Acquire); // Pairs with `SetTimeouts`.
        if !self.enable.get() || !self.ok.get() {
            return;
        }
        let begins = starts != self.seen;
        self.seen = starts;
        for b in &mut self.beats {
            let input = b.input.get();
            let changed = input != b.was;
            if begins {
                b.left = b.limit.start.load(Acquire); // Pairs with `SetTimeouts`.
            }
            if changed {
                b.left = b.limit.next.load(Acquire); // Pairs with `SetTimeouts`.
            } else {
                b.left = b.left.saturating_sub(period.ns());
            }
            b.was = input;
            if b.left < 0 {
                self.ok.set(false);
            }
        }
    }
}

/// Timeout of one input.
#[derive(Touch)]
struct Timeout {
    timeout: ParamRw<f64>,
    limit: Gives<Limit>,
}

/// Converts a timeout in seconds to nanoseconds, truncated. A timeout below 0 becomes 0, and NaN becomes 2.1 s, as in
/// LinuxCNC. A timeout of 2^63 ns or more becomes the longest time.
fn nanoseconds(timeout: f64) -> i64 {
    if timeout.is_nan() {
        return 1 << 31;
    }
    if timeout < 0.0 {
        return 0;
    }
    let secs = timeout.trunc();
    #[expect(clippy::cast_possible_truncation, reason = "`as` saturates, and the fraction fits")]
    let (secs, rest) = (secs as i64, ((timeout - secs) * 1e9) as i64);
    secs.saturating_mul(1_000_000_000).saturating_add(rest)
}

/// `watchdog.set-timeouts`.
#[derive(Touch)]
struct SetTimeouts {
    enable: In<bool>,
    ok: Out<bool>,
    times: Vec<Timeout>,
    start: Gives<AtomicU32>,
    #[state]
    was_enabled: bool,
}

impl Update for SetTimeouts {
    fn update(&mut self, _: Period) {
        for t in &self.times {
            t.limit.next.store(nanoseconds(t.timeout.get()), Release); // Pairs with `Process`.
        }
        let enable = self.enable.get();
        if enable && !self.was_enabled {
            if !self.ok.get() {
                for t in &self.times {
                    let limit = t.limit.next.load(Acquire); // Only this side stores.
                    t.limit.start.store(limit, Release); // Pairs with `Process`.
                }
                let next = self.start.load(Acquire).wrapping_add(1); // Only this side stores.
                self.start.store(next, Release); // Pairs with `Process`.
            }
            self.ok.set(true);
        }
        self.was_enabled = enable;
    }
}

#[cfg(test)]
mod tests {
    use super::{Watchdog, nanoseconds};
    use hal_bench::{Bench, trace::replay};

    #[test]
    fn as_recorded() {
        assert_eq!(replay::<Watchdog>(include_str!("../traces/watchdog.txt")), 710);
    }

    #[test]
    fn a_long_timeout_is_long() {
        for (timeout, ns) in [
            (-1.0, 0),
            (f64::NEG_INFINITY, 0),
            (f64::NAN, 2_147_483_648),
            (0.0, 0),
            (0.25, 250_000_000),
            (2_147_483_647.5, 2_147_483_647_500_000_000),
            (2_147_483_648.0, 2_147_483_648_000_000_000),
            (9e9, 9_000_000_000_000_000_000),
            (1e10, i64::MAX),
            (f64::INFINITY, i64::MAX),
        ] {
            assert_eq!(nanoseconds(timeout), ns, "{timeout}");
        }
        let mut bench = Bench::new();
        bench.load::<Watchdog>(&["num_inputs=1"]).unwrap();
        bench.set("watchdog.timeout-0", 3e9);
        bench.set("watchdog.enable-in", true);
        bench.run("watchdog.set-timeouts", 1_000_000_000);
        for _ in 0..10 {
            bench.run("watchdog.process", 1_000_000_000);
            assert!(bench.get::<bool>("watchdog.ok-out"), "ten of 3e9 seconds have passed");
        }
    }

    #[test]
    fn inputs() {
        for (args, wanted) in [
            (&[][..], "parameter `num_inputs' is missing"),
            (&["num_inputs=0"], "`0' out of range for parameter `num_inputs=0'"),
            (&["num_inputs=33"], "`33' out of range for parameter `num_inputs=33'"),
        ] {
            assert_eq!(Bench::new().load::<Watchdog>(args).unwrap_err(), wanted);
        }
        let mut bench = Bench::new();
        bench.load::<Watchdog>(&["num_inputs=32"]).unwrap();
        assert_eq!(bench.names().len(), 66);
    }
}
