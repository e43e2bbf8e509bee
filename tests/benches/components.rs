//! Cost of each function of every component per call, and load time of each library.
//!
//! Instances of one component run together in one thread on the virtual clock, their inputs linked to values that
//! change in every cycle; the time of an empty function is subtracted. Run it with
//! `cargo bench -p hal-tests --bench components`; with `UPDATE_EXPECT=1` it writes `components/SPEED.md`.
//! `COMPONENT=NAME` measures one; `LIBRARIES=1` prints only the load times of the libraries.
#![expect(
    clippy::unwrap_used,
    clippy::panic,
    clippy::indexing_slicing,
    clippy::print_stdout,
    clippy::disallowed_methods,
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "a benchmark measures the wall clock and prints"
)]

mod speed;

use hal_tests::{costs::with_rows_of, every, golden, programs::root};
use speed::{Cost, bench::HAL_LIBRARY, costs, loads, nothing};
use std::fmt::Write;

const BEGIN: &str = "<!-- speed:begin -->";
const END: &str = "<!-- speed:end -->";

/// Returns the costs of all functions, the most expensive first, and the components that cannot be measured.
fn functions() -> (Vec<Cost>, Vec<String>) {
    let only = std::env::var("COMPONENT").ok();
    let mut engine = every::engine();
    engine.add_static(&HAL_LIBRARY);
    let empty = nothing(&mut engine);
    let (mut all, mut refused) = (Vec::new(), Vec::new());
    for offer in every::offers() {
        if only.as_ref().is_some_and(|only| *only != offer.component) {
            continue;
        }
        match costs(&mut engine, &offer) {
            Ok(costs) => all.extend(costs),
            Err(why) => refused.push(format!("{}: {why}", offer.component)),
        }
    }
    all.iter_mut().for_each(|c| c.ns = (c.ns - empty).max(0.0));
    all.sort_by(|a, b| b.ns.total_cmp(&a.ns));
    (all, refused)
}

fn table() -> String {
    let mut out = String::from("\n\n| component | function | ns |\n|---|---|---|\n");
    let (costs, refused) = functions();
    for Cost { component, function, args, ns } in costs {
        let with = if args.is_empty() { String::new() } else { format!(", `{args}`") };
        // Below one nanosecond, the difference to an empty function is noise.
        let ns = match ns {
            ns if ns < 1.0 => "< 1".to_owned(),
            ns if ns < 100.0 => format!("{ns:.1}"),
            ns => format!("{ns:.0}"),
        };
        writeln!(out, "| `{component}` | `{function}`{with} | {ns} |").unwrap();
    }
    if std::env::var_os("COMPONENT").is_none() {
        assert!(refused.is_empty(), "{out}not measured: {refused:#?}");
        out.push_str(&libraries());
    }
    out.push('\n');
    out
}

/// Times to load the first component of each library.
fn libraries() -> String {
    let mut out = String::from(
        "\n| library | components | KiB | first load, ms | again, ms |\n|---|---|---|---|---|\n",
    );
    for l in loads::loads() {
        let (library, n, kib) = (l.library, l.components, l.kib);
        writeln!(out, "| `{library}` | {n} | {kib} | {:.2} | {:.2} |", l.first, l.again).unwrap();
    }
    out
}

fn main() {
    if std::env::args().any(|a| a == "--test" || a == "--list") || loads::child() {
        return;
    }
    if std::env::var_os("LIBRARIES").is_some() {
        return println!("{}", libraries());
    }
    let table = table();
    println!("{table}");
    if golden::is_update() {
        let path = root().join("components/SPEED.md");
        golden::rewrite_part(&path, BEGIN, END, |old| match std::env::var("COMPONENT") {
            Ok(only) => with_rows_of(old, &table, &only),
            Err(_) => table,
        });
    }
}
