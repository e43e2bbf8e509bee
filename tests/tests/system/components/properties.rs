//! Properties of every component of every plugin library, with random inputs that are the same in every run: numbers,
//! ramps, edges, then every value of a type (NaN, infinities, the largest and the smallest, crossed limits), then sane
//! values again. Functions run in other orders, in two threads, with periods from 1 us to 1 s that change in between.
//!
//! Nothing panics. While inputs are sane, outputs are finite and within their limits; when inputs are sane again, so
//! are the outputs, and no integer stays at an end of its type. A second run gives the same bits. `realtime.rs` tests,
//! with the same configurations, that no cycle allocates.
//!
//! `PROPERTIES=pid cargo test -p hal-tests --test system components::properties::one_component` tests one component.
//!
//! Most components need no file here. Special needs of a component are listed in `tests/properties/NAME.toml`, those of
//! all other components of a library in `lib-LIBRARY.toml`. All entries are optional:
//!
//! ```toml
//! # Component whose file also applies.
//! like = "pid"
//!
//! # Arguments of loadrt, each a configuration, in addition to those of tests/conformance/NAME.toml and
//! # tests/src/every.rs.
//! loads = ["num_chan=2"]
//! # Lines before and after it is loaded, and the threads that they create.
//! before = ["loadrt trivkins"]
//! after = []
//! threads = ["servo-thread"]
//!
//! # Sane inputs, in the format of tests/tests/system/peer/conformance.rs.
//! [[inputs]]
//! pins = ["*.gain"]
//! why = "its range is documented"
//! range = [0, 1]
//!
//! # Documented limits of an output; `#` is the same text in all names. Each limit is the product of
//! # the listed names and numbers.
//! [[bounds]]
//! pin = "#.output"
//! low = ["-1", "#.maxoutput"]     # without it: -high
//! high = ["#.maxoutput"]
//! unless = "#.maxoutput"          # no limit while this is 0
//! off = "#.tune-mode"             # no limit once this has been true
//! rate = "#.maxv"                 # units per second
//!
//! # Outputs that may be NaN or infinite while all inputs are finite.
//! [[open]]
//! pins = ["*.out"]
//! why = "…"
//!
//! # Outputs that stay NaN or too large, and the steps that reset them; without steps, only a new load
//! # resets them.
//! [[stays]]
//! pins = ["*.out"]
//! why = "it is a sum"
//! reset = [{ "*.reset" = "1" }, { "*.reset" = "0" }]
//! ```
//!
//! An unused row fails the test.

use hal_protocol::Offer;
use hal_tests::{
    every::offers,
    properties::{case, examine},
};

fn wrong(offer: &Offer) -> Vec<String> {
    let found = examine(offer).unwrap_or_else(|e| vec![e]);
    found.into_iter().map(|what| format!("{}: {what}", offer.component)).collect()
}

/// Tests every fourth component, so that the tests run in parallel.
fn share(of: usize) {
    let offers = offers();
    // It has threads and nothing else.
    let some = offers.iter().filter(|o| o.component != "threads");
    let mine = some.enumerate().filter(|(i, _)| i % 4 == of);
    let all: Vec<String> = mine.flat_map(|(_, o)| wrong(o)).collect();
    assert!(all.is_empty(), "{}", all.join("\n"));
}

#[test]
fn a_first_share_of_all() {
    share(0);
}

#[test]
fn a_second_share_of_all() {
    share(1);
}

#[test]
fn a_third_share_of_all() {
    share(2);
}

#[test]
fn a_fourth_share_of_all() {
    share(3);
}

#[test]
fn one_component() {
    let Ok(name) = std::env::var("PROPERTIES") else { return };
    let offers = offers();
    let offer = offers.iter().find(|o| o.component == name).unwrap();
    let all = wrong(offer);
    assert!(all.is_empty(), "{}", all.join("\n"));
}

#[test]
fn every_file_is_of_a_component_or_a_library() {
    let offers = offers();
    for entry in std::fs::read_dir(case::folder()).unwrap() {
        let name = entry.unwrap().file_name().into_string().unwrap();
        let of = name.strip_suffix(".toml").unwrap_or_else(|| panic!("{name}"));
        let is = |o: &Offer| o.component == of || format!("lib-{}", o.library) == of;
        assert!(offers.iter().any(is), "{name}");
    }
}
