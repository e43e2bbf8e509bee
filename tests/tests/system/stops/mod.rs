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
mod motion;
mod real;
mod rig;
mod robot;
mod soak;
mod table;

use cell::{Outcome, Phase, cell};
use data::{Control, Motion, controls, machines};
use hal_tests::{golden, programs::root};
use rig::Rig;
use table::Table;

/// Machines whose own controls are walked with each run of the tests; the whole table takes minutes.
const EACH_RUN: [&str; 2] = ["lathe", "mill"];

/// Runs all cells of the table that need neither the real clock nor a browser; the environment variables `CASE` and `CONTROL`
/// choose some. Its own are those in which nothing waits for a program or a planner on the real clock.
fn walk(phase: Phase, is_own: bool) -> Table {
    let wanted = |name| std::env::var(name).unwrap_or_default();
    let (case, only) = (wanted("CASE"), wanted("CONTROL"));
    let mut table = Table::default();
    let takes = |name: &str| name.starts_with(&case) && (!is_own || EACH_RUN.contains(&name));
    for machine in machines().into_iter().filter(|m| takes(m.name.as_str())) {
        let mut rig = Rig::start(&machine);
        let takes = |c: &Control| c.name.contains(&only) && !(is_own && c.client().is_some());
        for (n, control) in controls().iter().enumerate().filter(|(_, c)| takes(c)) {
            for motion in Motion::ALL {
                let mut outcome = cell(&mut rig, control, motion, phase);
                if let Outcome::Bad(why) = &outcome {
                    // Planning and clients are on the real clock: on a computer with other work they may be late for the cell. What
                    // the machine itself does wrong, it does again.
                    println!("{}, {}, {motion:?}: {why}; again", machine.name, control.name);
                    rig = Rig::start(&machine);
                    outcome = cell(&mut rig, control, motion, phase);
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
fn every_control_of_a_machine_stops_it() {
    report(&walk(Phase::Constant, true), Phase::Constant);
}

#[test]
fn every_control_of_a_machine_stops_what_accelerates() {
    report(&walk(Phase::Accelerates, true), Phase::Accelerates);
}

#[test]
#[ignore = "minutes on a computer without other work: cargo test -p hal-tests --test system stops::every_stop -- --ignored"]
fn every_stop_stops_every_machine() {
    let table = walk(Phase::Constant, false);
    let is_whole = std::env::var_os("CASE").is_none() && std::env::var_os("CONTROL").is_none();
    report(&table, Phase::Constant);
    if is_whole {
        golden::check(&root().join("tests/stops/table.md"), &table.page(&controls()));
    }
}

#[test]
#[ignore = "minutes on a computer without other work: cargo test -p hal-tests --test system stops::every_stop -- --ignored"]
fn every_stop_stops_what_accelerates() {
    report(&walk(Phase::Accelerates, false), Phase::Accelerates);
}
