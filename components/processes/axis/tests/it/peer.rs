//! Replay of scripts that LinuxCNC ran: every sample must be equal.

use axis::Steptest;
use hal_bench::Bench;
use stepgen::Stepgen;

#[path = "../../../../drivers/stepgen/tests/it/replay/mod.rs"]
mod replay;

fn load(bench: &mut Bench, kind: &str, args: &[&str]) -> bool {
    match kind {
        "steptest" => bench.load::<Steptest>(args).is_ok(),
        "stepgen" => bench.load::<Stepgen>(args).is_ok(),
        _ => false,
    }
}

#[test]
fn runs_and_jogs() {
    replay::check("steptest", load);
}
