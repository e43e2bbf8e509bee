//! All orders of events: breadth first, with a visited set, and invariants in every state and every transition.
//!
//! The invariants ([`watch`]) know what happened and what moves; they do not know the machine's own state. Each planted fault
//! ([`mutants`]) must break one of them.
#![expect(clippy::unwrap_used, clippy::indexing_slicing, clippy::print_stdout, reason = "tests")]

mod answers;
mod lease;
mod model;
mod mutants;
mod remote;
mod visited;
mod watch;

use hal_safety::{Reaction, SafetyMachine, plant::Config};
use model::{Model, Move, Parts};
use visited::Visited;

/// Depth to which every search goes at least.
const DEPTH: usize = 12;

/// Result of a search.
#[derive(Debug)]
struct Found {
    states: usize,
    transitions: u64,
    /// Depth at which there was no new state, if the search got there.
    emptied: Option<usize>,
}

/// Searches from a state; fails with the events that lead to a broken invariant.
fn search(start: Model, moves: &[Move], parts: &Parts, depth: usize) -> Result<Found, String> {
    let mut visited = Visited::new();
    visited.insert(start.key());
    // A state, the place of the state before it, and the event between both.
    let mut all = vec![(start, 0_u32, 0_u8)];
    let (mut from, mut transitions) = (0, 0);
    for level in 1..=depth {
        let to = all.len();
        for place in from..to {
            for (n, next) in moves.iter().enumerate() {
                let (before, ..) = all[place];
                let Some((after, broken)) = before.step(*next, parts) else { continue };
                transitions += 1;
                if let Some(broken) = broken {
                    return Err(trail(&all, place, moves, *next, broken, &after));
                }
                if visited.insert(after.key()) {
                    all.push((after, u32::try_from(place).unwrap(), u8::try_from(n).unwrap()));
                }
            }
        }
        if all.len() == to {
            return Ok(Found { states: to, transitions, emptied: Some(level) });
        }
        from = to;
    }
    Ok(Found { states: all.len(), transitions, emptied: None })
}

/// Tells the events that lead to a broken invariant.
fn trail(
    all: &[(Model, u32, u8)],
    mut place: usize,
    moves: &[Move],
    last: Move,
    broken: &str,
    after: &Model,
) -> String {
    let mut steps = vec![format!("{last:?}")];
    while place != 0 {
        let (_, before, n) = all[place];
        steps.push(format!("{:?}", moves[usize::from(n)]));
        place = usize::try_from(before).unwrap();
    }
    steps.reverse();
    format!("{broken}: {}\n{after:?}", steps.join(", "))
}

/// The parts as they are in the product.
fn right() -> Parts {
    Parts { decide: SafetyMachine::on, ..Parts::default() }
}

/// Settings of the body that are searched: one that drops and one that ramps.
const CONFIGS: [Config; 2] = [
    Config {
        fault_stop: Reaction::Drop,
        needs_homed: false,
        is_volatile: false,
        is_open_loop: true,
    },
    Config {
        fault_stop: Reaction::Ramp,
        needs_homed: true,
        is_volatile: true,
        is_open_loop: false,
    },
];

/// Searches motion alone until there is no new state, and with a remote operator to a depth; prints what was found.
fn both(config: Config, depth: usize) -> [(usize, u64, Option<usize>); 2] {
    let alone = (Model::new(config, false), model::alone(), usize::MAX);
    let remote = (Model::new(config, true), model::with_remote(), depth);
    [("motion alone", alone), ("with a remote operator", remote)].map(
        |(what, (start, moves, depth))| {
            let found = search(start, &moves, &right(), depth).unwrap();
            let Found { states, transitions, emptied } = found;
            let end = emptied.map_or("not empty".to_owned(), |at| format!("empty at depth {at}"));
            let by = config.fault_stop;
            println!("{by:?}, {what}: {states} states, {transitions} transitions, frontier {end}");
            (states, transitions, emptied)
        },
    )
}

#[test]
fn a_machine_that_drops_breaks_no_invariant() {
    let found = both(CONFIGS[0], DEPTH);
    assert_eq!(found, [(2204, 92_836, Some(15)), (949_189, 21_853_394, None)]);
}

#[test]
fn a_machine_that_ramps_breaks_no_invariant() {
    let found = both(CONFIGS[1], DEPTH);
    assert_eq!(found, [(1642, 68_682, Some(15)), (703_902, 15_024_919, None)]);
}

/// Until no order of events leads to a new state.
#[test]
#[ignore = "minutes: cargo test -p hal-safety --test search --release -- --ignored --nocapture"]
fn the_search_ends() {
    for config in CONFIGS {
        let found = both(config, usize::MAX);
        assert!(found.iter().all(|(.., emptied)| emptied.is_some()));
    }
}
