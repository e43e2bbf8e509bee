//! Tests of the driver on the bench, with simulated cards.

mod cycles;
mod listing;
mod losses;
mod names;
mod noise;
mod reasons;
mod remotes;
mod serial;

use crate::{Hm2Eth, simulated::SimulatedCard};
use hal_bench::Bench;
use std::{cell::RefCell, sync::Arc};

/// Period of the servo thread in nanoseconds.
const PERIOD: i64 = 1_000_000;

thread_local! {
    static LAST_CARD: RefCell<Option<Arc<SimulatedCard>>> = const { RefCell::new(None) };
}

/// Keeps the card that was simulated last in this thread.
pub(crate) fn keep_card(card: &Arc<SimulatedCard>) {
    LAST_CARD.set(Some(Arc::clone(card)));
}

/// Returns the card that was simulated last in this thread.
fn last_card() -> Arc<SimulatedCard> {
    LAST_CARD.with_borrow(Clone::clone).unwrap()
}

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
        Self::with(kind, "")
    }

    fn with(kind: &str, config: &str) -> Self {
        let bench = card(kind, config);
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

    fn word(&self, pin: &str) -> u32 {
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
