//! Tests of the driver on the bench, with simulated cards.

mod names;

use crate::Hm2Eth;
use hal_bench::Bench;

/// Returns a bench with a simulated card.
fn card(kind: &str, config: &str) -> Bench {
    let mut bench = Bench::new();
    let (kind, config) = (format!("card={kind}"), format!("config={config}"));
    bench.load::<Hm2Eth>(&[&kind, &config]).unwrap();
    bench
}
