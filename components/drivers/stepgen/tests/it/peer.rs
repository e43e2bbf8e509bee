//! Replay of scripts that LinuxCNC ran: every sample must be equal.

use hal_bench::Bench;
use stepgen::Stepgen;

use crate::replay;

fn load(bench: &mut Bench, kind: &str, args: &[&str]) -> bool {
    kind == "stepgen" && bench.load::<Stepgen>(args).is_ok()
}

#[test]
fn every_step_type() {
    replay::check("types", load);
}

#[test]
fn pulse_timing() {
    replay::check("timing", load);
}

#[test]
fn position_mode() {
    replay::check("position", load);
}

#[test]
fn two_threads() {
    replay::check("servo", load);
}

#[test]
fn the_printer() {
    replay::check("printer", load);
}
