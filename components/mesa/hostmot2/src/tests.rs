//! Tests of the driver on the bench, with simulated cards.

mod cycles;
mod listing;
mod losses;
mod names;

use crate::Hm2Eth;
use hal_bench::Bench;

/// Period of the servo thread in nanoseconds.
const PERIOD: i64 = 1_000_000;

/// Returns a bench with a simulated card.
fn card(kind: &str, config: &str) -> Bench {
    let mut bench = Bench::new();
    let (kind, config) = (format!("card={kind}"), format!("config={config}"));
    bench.load::<Hm2Eth>(&[&kind, &config]).unwrap();
    bench
}

/// A card with its name.
struct Rig {
    bench: Bench,
    name: String,
}

impl Rig {
    fn new(kind: &str) -> Self {
        let bench = card(kind, "");
        let name = bench.names().into_iter().find(|name| name.contains(".io_error")).unwrap();
        let name = name.split(".io_error").next().unwrap().to_owned();
        Self { bench, name }
    }

    fn at(&self, pin: &str) -> String {
        format!("{}.{pin}", self.name)
    }

    fn cycle(&self) {
        self.bench.pass(PERIOD);
        self.bench.run(&self.at("read"), PERIOD);
        self.bench.run(&self.at("write"), PERIOD);
    }

    fn cycles(&self, n: usize) {
        for _ in 0..n {
            self.cycle();
        }
    }

    fn set(&self, pin: &str, value: impl hal_component::Value) {
        self.bench.set(&self.at(pin), value);
    }

    fn bit(&self, pin: &str) -> bool {
        self.bench.get(&self.at(pin))
    }

    fn float(&self, pin: &str) -> f64 {
        self.bench.get(&self.at(pin))
    }

    fn int(&self, pin: &str) -> i32 {
        self.bench.get(&self.at(pin))
    }

    /// Prepares step generator 0 with fast pulses.
    fn stepgen(&self, scale: f64, maxaccel: f64) {
        for pin in ["steplen", "stepspace", "dirsetup", "dirhold"] {
            self.set(&format!("stepgen.00.{pin}"), 1000_u32);
        }
        self.set("stepgen.00.position-scale", scale);
        self.set("stepgen.00.maxaccel", maxaccel);
        self.set("stepgen.00.enable", true);
    }
}
