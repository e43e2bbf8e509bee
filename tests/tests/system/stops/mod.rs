//! The table of stops: every machine of `configs/` × every stop control × every kind of motion.
#![expect(
    clippy::unwrap_used,
    clippy::indexing_slicing,
    clippy::panic,
    clippy::print_stdout,
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "whatever fails here fails a test; figures are shown"
)]

mod bad;
mod cell;
mod clients;
mod cover;
mod data;
mod faults;
mod judge;
mod lost;
mod motion;
mod page;
mod real;
mod rig;
mod robot;
mod soak;
mod table;
mod unstoppable;

use cell::{Outcome, Phase, cell};
use data::{Motion, controls, machines};
use hal_tests::{golden, programs::root};
use rig::Rig;
use table::Table;

/// Cells of a walk.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Part {
    /// All cells.
    Whole,
    /// Each machine with each control once, and each control with each kind of motion on some machine.
    Pairs,
}

impl Part {
    /// Returns whether a machine is taken with a control and a kind of motion.
    const fn takes(self, machine: usize, control: usize, motion: usize) -> bool {
        matches!(self, Self::Whole)
            || (machine + control + motion).is_multiple_of(Motion::ALL.len())
    }
}

/// Runs the cells of the table that need neither the real clock nor a browser; the environment variables `CASE` and `CONTROL`
/// choose some.
fn walk(phase: Phase, part: Part) -> Table {
    let wanted = |name| std::env::var(name).unwrap_or_default();
    let (case, only) = (wanted("CASE"), wanted("CONTROL"));
    let mut table = Table::default();
    let controls = controls();
    for (m, machine) in machines().iter().enumerate().filter(|(_, m)| m.name.starts_with(&case)) {
        let mut rig = None;
        for (n, control) in controls.iter().enumerate().filter(|(_, c)| c.name.contains(&only)) {
            for (k, motion) in Motion::ALL.into_iter().enumerate() {
                if !part.takes(m, n, k) {
                    continue;
                }
                let outcome =
                    cell(rig.get_or_insert_with(|| Rig::start(machine)), control, motion, phase);
                // What a bad cell leaves is not judged again.
                if machine.needs_fresh || matches!(outcome, Outcome::Bad(_)) {
                    rig = None;
                }
                table.add((&machine.name, machine.unit()), n, motion, outcome);
            }
        }
    }
    table
}

/// Prints the number of cells, and fails if a cell is not as its rule says.
fn report(table: &Table, phase: Phase) {
    let [good, on, cannot, bad] = table.counts();
    println!("{phase:?}: {good} stops, {on} go on, {cannot} cannot be, {bad} bad");
    let bad = table.bad(&controls());
    assert!(bad.is_empty(), "{} cells are not as their rules say:\n{}", bad.len(), bad.join("\n"));
}

#[test]
fn every_control_stops_every_machine() {
    report(&walk(Phase::Constant, Part::Pairs), Phase::Constant);
}

#[test]
fn every_control_stops_what_accelerates() {
    report(&walk(Phase::Accelerates, Part::Pairs), Phase::Accelerates);
}

#[test]
#[ignore = "takes minutes: cargo test -p hal-tests --test system stops::the_whole -- --ignored --nocapture"]
fn the_whole_table() {
    let table = walk(Phase::Constant, Part::Whole);
    let is_whole = std::env::var_os("CASE").is_none() && std::env::var_os("CONTROL").is_none();
    report(&table, Phase::Constant);
    if is_whole {
        golden::check(&root().join("tests/stops/table.md"), &table.page(&controls()));
    }
}

#[test]
#[ignore = "takes minutes: cargo test -p hal-tests --test system stops::the_whole -- --ignored --nocapture"]
fn the_whole_table_of_what_accelerates() {
    report(&walk(Phase::Accelerates, Part::Whole), Phase::Accelerates);
}
