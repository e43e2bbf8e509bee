//! The judge: each of our components compared with LinuxCNC's component of the same name, in one engine on the virtual
//! clock, with the same inputs; every pin and parameter is compared after every cycle.
//!
//! `cargo test -p hal-tests --test system peer::conformance -- --ignored` judges all of them and compares with `tests/compat/conformance.md`;
//! with `UPDATE_EXPECT=1` it writes that file. A single component, with the inputs before its first difference:
//!
//! ```sh
//! CONFORMANCE=pid cargo test -p hal-tests --test system peer::conformance::one_component -- --exact --nocapture
//! ```
//!
//! Without LinuxCNC's package, the test is reported as skipped.
//!
//! Most components need no file here. `tests/conformance/NAME.toml` describes the special needs of a component; the author of
//! a new component adds at most that file. All entries are optional:
//!
//! ```toml
//! skip = "why it is not judged at all"
//!
//! # Reason why only one instance is judged, and not also several with `names=`.
//! single = "theirs keeps something once for all instances"
//!
//! # Arguments of both, each line a configuration that is judged; by default, one without arguments.
//! loads = ["", "count=2", "personality=16"]
//!
//! # More arguments, with which only functions, pins and parameters are compared, by the test `pins`.
//! shapes = ["personality=0x1f02"]
//!
//! # Modules that must be loaded first.
//! before = ["trivkins"]
//!
//! # A state machine needs longer rounds, or more of them, than usual.
//! cycles = 2000
//! rounds = 40
//!
//! # Periods of the fast thread, in ns, where the default ones are unsuitable.
//! periods = [25000, 100000]
//!
//! # Constraints of inputs: one or several of these, and the reason. Names are complete or glob
//! # patterns; an input without constraints receives all values, including NaN.
//! [[inputs]]
//! pins = ["*.maxv"]
//! why = "it is a size"
//! positive = true     # absolute value, and not 0
//! steady = true       # set once after each load
//! alone = true        # never set
//! tame = true         # no extremes
//! number = true       # never NaN
//! finite = true       # neither NaN nor infinite
//! nonzero = true      # not 0
//! larger = 1000       # multiplied by this
//! range = [0, 4]      # from the first to the second
//! evenly = true       # each integer of that range is equally likely
//! set = "1"           # set to this once after each load
//! values = [0, 2.5]   # one of these, at random
//! often = 50          # changed at random, once in 50 cycles on average, so that state sequences can finish
//! follows = "x.0.out" # value of our output after the last cycle, as if a machine were connected
//! times = "x.0.scale" # factor of that value: a pin of ours, or a number
//!
//! # Tolerances of floats, in units of the last place. Only for differences that libm explains.
//! [[tolerance]]
//! pins = ["*.sine"]
//! why = "sine of another library"
//! ulps = 2
//!
//! # First values that differ, as displayed; both sides are then set to ours.
//! [[defaults]]
//! pins = ["*.maxa"]
//! why = "…"
//! ours = "10000000.0"
//! theirs = "1e20"
//!
//! # Pins that only one side has, and the value of ours, if one is required.
//! [[only]]
//! pins = ["*.extra"]
//! why = "…"
//! set = "0"
//!
//! # Items that are a pin on one side and a parameter on the other, with the same meaning.
//! [[kinds]]
//! pins = ["*.size"]
//! why = "…"
//!
//! # Outputs that never change, though every output should.
//! [[still]]
//! pins = ["*.brake"]
//! why = "…"
//!
//! # Known differences and their bounds: the first cycle, the number of cycles for each pin, and
//! # the largest difference.
//! [[differs]]
//! pins = ["*.out"]
//! why = "…"
//! from = 170
//! cycles = 12
//! by = 1e-9           # unbounded if omitted
//! ```
//!
//! An unlisted difference fails the test, and so does a difference beyond its bounds, a listed one that no longer
//! occurs, and a name that no pin has. The message has the figures.
#![expect(clippy::unwrap_used, reason = "tests")]
#![expect(clippy::print_stdout, reason = "one that is asked for is shown")]

use hal_protocol::{Kind, Link, Reply, Request};
use hal_tests::{
    conformance::{
        CYCLES, Style,
        case::{self, Case},
        judge,
        rows::measured,
    },
    foreign::{Bench, installed},
    golden, pins,
    programs::{families, root},
    tools,
};
use std::{
    collections::BTreeMap,
    fmt::Write,
    process::Command,
    sync::{
        Mutex,
        atomic::{AtomicUsize, Ordering::Relaxed},
    },
};

/// Prints the row of the component that the environment names. Runs in a process of its own.
#[test]
fn one_component() {
    let Ok(module) = std::env::var("HAL_TEST_MODULE").or_else(|_| std::env::var("CONFORMANCE"))
    else {
        return;
    };
    let rounds = std::env::var("HAL_TEST_ROUNDS").map_or(usize::MAX, |n| n.parse().unwrap());
    let told = judge(&module, rounds).and_then(|v| Ok(v.row(&Case::of(&module)?)));
    match told {
        Ok(row) => println!("\nROW {row}"),
        Err(e) => println!("\nROW | | | DIFFERS: not judged: {}", e.replace('\n', " ")),
    }
}

fn row(module: &str, rounds: usize) -> String {
    match Case::of(module).map(|c| c.skip) {
        Ok(None) => (),
        Ok(Some(why)) => return format!("| `{module}` | | | | not judged: {why} |"),
        Err(e) => return format!("| `{module}` | | | | DIFFERS: {} |", e.replace('\n', " ")),
    }
    let mut me = Command::new(std::env::current_exe().unwrap());
    me.args([
        "--exact",
        &hal_tests::programs::own_test(module_path!(), "one_component"),
        "--nocapture",
    ])
    .env_remove("CONFORMANCE");
    me.env("HAL_TEST_MODULE", module).env("HAL_TEST_ROUNDS", rounds.to_string());
    let out = me.output().unwrap();
    let text = String::from_utf8_lossy(&out.stdout).into_owned();
    match text.lines().find_map(|l| l.strip_prefix("ROW ")) {
        Some(row) => format!("| `{module}` | {row} |"),
        None => {
            let said = String::from_utf8_lossy(&out.stderr).into_owned();
            let said: Vec<&str> = said.lines().filter(|l| !l.trim().is_empty()).collect();
            format!("| `{module}` | | | | DIFFERS: ended: {} |", said.join(" "))
        }
    }
}

/// Returns the components that both have.
fn shared() -> Vec<String> {
    let folder = installed().unwrap();
    let mut b = Bench::new(&[]);
    let all = Request::List { kind: Kind::Offers, patterns: Vec::new(), ty: None };
    let Ok(Reply::Offers(list)) = b.call(all) else { return Vec::new() };
    let mut names: Vec<String> = list.into_iter().map(|o| o.component).collect();
    names.retain(|n| folder.join(format!("{n}.so")).is_file());
    names.sort();
    names.dedup();
    names
}

/// Returns the rows of all components; judges as many at a time as there are processors.
fn rows(modules: &[String]) -> Vec<String> {
    let (next, rows) = (AtomicUsize::new(0), Mutex::new(BTreeMap::new()));
    let work = || {
        while let Some(module) = modules.get(next.fetch_add(1, Relaxed)) {
            let row = row(module, usize::MAX);
            rows.lock().unwrap().insert(module, row);
        }
    };
    std::thread::scope(|s| {
        for _ in 0..std::thread::available_parallelism().map_or(1, usize::from) {
            s.spawn(work);
        }
    });
    rows.into_inner().unwrap().into_values().collect()
}

/// Judges a component of each kind, for a few rounds.
#[test]
fn some_components_do_as_theirs() {
    if tools::linuxcnc().is_none() {
        return;
    }
    for module in ["and2", "pid", "limit3", "mux2"] {
        let row = row(module, Style::ALL.len());
        assert!(!row.contains("DIFFERS"), "{row}");
    }
}

/// Each file is correct by itself, and describes a component that both have.
#[test]
fn every_file_is_of_a_component() {
    let mut files = Vec::new();
    for entry in std::fs::read_dir(case::folder()).unwrap() {
        let name = entry.unwrap().file_name().into_string().unwrap();
        files.push(name.strip_suffix(".toml").unwrap_or_else(|| panic!("{name}")).to_owned());
    }
    for module in &files {
        Case::of(module).unwrap();
    }
    if installed().is_some() {
        let shared = shared();
        let known = pins::names();
        let is_known = |f: &&String| shared.contains(f) || known.contains(f);
        let strange: Vec<_> = files.iter().filter(|f| !is_known(f)).collect();
        assert!(strange.is_empty(), "not of both: {strange:?}");
    }
}

/// The rows of `components/*/traces/` agree with LinuxCNC's components; with `UPDATE_EXPECT=1` they are rewritten, `?`
/// included. Those rows are the tests on computers without LinuxCNC.
#[test]
fn rows_are_as_theirs() {
    let Some(folder) = tools::linuxcnc() else { return };
    let mut wrong = Vec::new();
    for family in families().values() {
        let Ok(tables) = std::fs::read_dir(family.join("traces")) else { continue };
        for file in tables.map(|t| t.unwrap().path()) {
            let module = file.file_stem().unwrap().to_str().unwrap();
            if !folder.join(module).with_extension("so").is_file() {
                continue;
            }
            let table = std::fs::read_to_string(&file).unwrap();
            match measured(&table) {
                Ok(text) if text == table => {}
                Ok(text) if golden::is_update() => {
                    std::fs::write(&file, text).unwrap();
                }
                Ok(text) => {
                    let apart = text.lines().zip(table.lines()).find(|(a, b)| a != b);
                    wrong.push(format!("{module}: theirs, and the row: {apart:?}"));
                }
                Err(e) => wrong.push(format!("{module}: {e}")),
            }
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
#[ignore = "takes a minute, needs LinuxCNC's package: cargo test -p hal-tests --test system peer::conformance -- --ignored"]
fn every_component_does_as_theirs() {
    if tools::linuxcnc().is_none() {
        return;
    }
    let mut modules = shared();
    // Components that are programs there have no modules to judge, and a file that says why.
    let is_skipped = |name: &String| Case::of(name).is_ok_and(|case| case.skip.is_some());
    modules.extend(pins::names().into_iter().filter(is_skipped));
    modules.sort();
    modules.dedup();
    let rows = rows(&modules);
    let judged = rows.iter().filter(|r| !r.contains("| not judged")).count();
    let equal = rows.iter().filter(|r| r.contains("| equal") && !r.contains("| equal but")).count();
    let mut text = format!(
        "# Our components beside LinuxCNC's, cycle by cycle\n\n\
         Both of a name are loaded into one engine on the virtual clock and given the same inputs\n\
         and parameters: chance, ramps, edges and extremes. Every pin and parameter is compared\n\
         after every cycle, bit for bit, but for the sign of zero: LinuxCNC's `.comp` modules add 0\n\
         to every number that they read, and have no -0. The components are loaded again every {CYCLES} cycles.\n\
         What is known of one stands in `tests/conformance/NAME.toml`; what is not, or is worse, fails.\n\
         `UPDATE_EXPECT=1 cargo test -p hal-tests --test system peer::conformance -- --ignored` writes this file.\n\n\
         Of {} that both have, {judged} are judged; {equal} are equal in all that is compared,\n\
         and the others but for what is listed below the table, one fact to a line.\n\n\
         | component | compared | moved | cycles | result |\n\
         |---|---|---|---|---|\n",
        rows.len()
    );
    let mut facts = String::new();
    for row in &rows {
        let mut parts = row.trim_end_matches(" |").split('\t');
        writeln!(text, "{} |", parts.next().unwrap_or_default()).unwrap();
        let name = row.split(' ').nth(1).unwrap_or_default();
        for (i, fact) in parts.enumerate() {
            let head = if i == 0 { format!("\n## {name}\n\n") } else { String::new() };
            writeln!(facts, "{head}- {fact}").unwrap();
        }
    }
    text += &facts;
    let file = root().join("tests/compat/conformance.md");
    golden::check(&file, &text);
    assert!(!text.contains("DIFFERS"), "{text}");
}
