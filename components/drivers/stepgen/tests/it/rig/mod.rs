//! Stepgen with its two threads.

#![allow(dead_code, clippy::allow_attributes, reason = "each test uses its part")]
#![expect(clippy::unwrap_used, reason = "tests")]

use hal_bench::Bench;
use stepgen::Stepgen;

/// Base thread, with a period of 100 µs by default, and a servo thread with ten times its period.
pub(crate) struct Rig {
    pub(crate) bench: Bench,
    pub(crate) base_ns: i64,
    pub(crate) cycles: i64,
}

impl Rig {
    pub(crate) fn new(args: &[&str]) -> Self {
        let mut bench = Bench::new();
        bench.load::<Stepgen>(args).unwrap();
        Self { bench, base_ns: 100_000, cycles: 0 }
    }

    pub(crate) fn float(&self, name: &str, value: f64) {
        self.bench.set(&format!("stepgen.{name}"), value);
    }

    pub(crate) fn ns(&self, name: &str, value: u32) {
        self.bench.set(&format!("stepgen.{name}"), value);
    }

    pub(crate) fn enable(&self, n: usize, on: bool) {
        self.bench.set(&format!("stepgen.{n}.enable"), on);
    }

    pub(crate) fn get<T: hal_component::Value>(&self, name: &str) -> T {
        self.bench.get(&format!("stepgen.{name}"))
    }

    /// Runs one base period, and every tenth time the servo thread after it.
    pub(crate) fn tick(&mut self) {
        self.bench.run("stepgen.make-pulses", self.base_ns);
        if self.cycles % 10 == 0 {
            self.bench.run("stepgen.capture-position", 10 * self.base_ns);
            self.bench.run("stepgen.update-freq", 10 * self.base_ns);
        }
        self.cycles += 1;
    }

    pub(crate) fn run(&mut self, ticks: usize) {
        (0..ticks).for_each(|_| self.tick());
    }

    /// Records a pin over some base periods: `#` true, `.` false.
    pub(crate) fn trace(&mut self, pin: &str, ticks: usize) -> String {
        let mut line = String::new();
        for _ in 0..ticks {
            self.tick();
            line.push(if self.get(pin) { '#' } else { '.' });
        }
        line
    }
}
