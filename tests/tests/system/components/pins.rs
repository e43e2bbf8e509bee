//! Arguments, functions, pins and parameters of our components, with types, directions and first values, compared with
//! those of LinuxCNC's components of the same name.
//!
//! `cargo test -p hal-tests --test system components::pins -- --ignored` loads the components of LinuxCNC's package and compares them with
//! `tests/compat/pins`; with `UPDATE_EXPECT=1` it writes those files (`PINS=NAME`: of one component). Without the
//! package, that test is reported as skipped. Our components are always compared with the files.
//!
//! `tests/conformance/NAME.toml` lists the intended differences; the head of `tests/tests/system/peer/conformance.rs` describes the format. The
//! records of components that LinuxCNC 2.9 lacks were taken from 2.10 and are written by hand.
#![expect(clippy::unwrap_used, clippy::panic, reason = "tests")]
#![expect(clippy::print_stdout, reason = "one that is asked for is shown")]

use hal_protocol::{Kind, Link, Offer, Reply, Request};
use hal_tests::{
    foreign::{Bench, installed},
    golden,
    pins::{self, Version},
    tools,
};
use object::{Object, ObjectSymbol};
use std::{collections::BTreeSet, fs, process::Command};

fn offers() -> Vec<Offer> {
    let mut bench = Bench::new(&[]);
    let all = Request::List { kind: Kind::Offers, patterns: Vec::new(), ty: None };
    let Ok(Reply::Offers(list)) = bench.call(all) else { panic!("no offers") };
    bench.engine.close();
    list
}

#[test]
fn every_component_has_what_theirs_has() {
    let only = std::env::var("PINS").ok();
    let (mut wrong, mut seen) = (Vec::new(), 0);
    for offer in offers() {
        let name = &offer.component;
        if only.as_ref().is_some_and(|only| only != name) {
            continue;
        }
        match pins::beside(&offer) {
            Ok(found) => {
                seen += usize::from(!found.versions.is_empty());
                wrong.extend(found.faults.into_iter().map(|fault| format!("{name}: {fault}")));
            }
            Err(e) => wrong.push(format!("{name}: {e}")),
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
    assert!(only.is_some() || seen > 150, "only {seen} components were compared");
}

/// Returns the arguments that a LinuxCNC module accepts, according to its file.
fn arguments(module: &str) -> BTreeSet<String> {
    let bytes = fs::read(installed().unwrap().join(format!("{module}.so"))).unwrap();
    let file = object::File::parse(&*bytes).unwrap();
    let names = file.dynamic_symbols().filter_map(|s| {
        s.name().ok().and_then(|n| n.strip_prefix("rtapi_info_address_")).map(str::to_owned)
    });
    names.collect()
}

/// Prints the result of the load that the environment names. Runs in a process of its own because some LinuxCNC modules
/// cannot be loaded twice.
#[test]
fn one_load() {
    let Ok(line) = std::env::var("HAL_TEST_LOAD") else { return };
    let (module, args) = line.split_once(' ').unwrap();
    match pins::measured(module, args) {
        Ok(load) => {
            let version = Version { loads: vec![load], ..Version::default() };
            println!("\nMADE\n{}MADE", pins::written(module, &version));
        }
        Err(e) => println!("\nMADE\nrefused {e}\nMADE"),
    }
}

/// Measures a LinuxCNC module.
fn measured(module: &str) -> Result<Version, String> {
    let args = arguments(module);
    let mut loads = Vec::new();
    for line in pins::lines(module, &args)? {
        let mut me = Command::new(std::env::current_exe().unwrap());
        me.args([
            "--exact",
            &hal_tests::programs::own_test(module_path!(), "one_load"),
            "--nocapture",
        ]);
        let out = me.env("HAL_TEST_LOAD", format!("{module} {line}")).output().unwrap();
        let text = String::from_utf8_lossy(&out.stdout).into_owned();
        match text.split("MADE\n").nth(1) {
            Some(made) if made.starts_with("LinuxCNC") => {
                loads.extend(pins::parse(made).into_iter().flat_map(|v| v.loads));
            }
            Some(refused) => return Err(format!("{line}: {refused}")),
            None => return Err(format!("{line}: {}", String::from_utf8_lossy(&out.stderr))),
        }
    }
    Ok(Version { name: "2.9".to_owned(), args, loads })
}

#[test]
#[ignore = "needs LinuxCNC's package: cargo test -p hal-tests --test system components::pins -- --ignored"]
fn every_file_is_what_theirs_has() {
    let Some(folder) = tools::linuxcnc() else { return };
    let only = std::env::var("PINS").ok();
    let update = golden::is_update();
    let mut wrong = Vec::new();
    for offer in offers() {
        let name = &offer.component;
        let is_asked = only.as_ref().is_none_or(|only| only == name);
        if !is_asked || !folder.join(format!("{name}.so")).is_file() {
            continue;
        }
        let version = match measured(name) {
            Ok(version) => version,
            Err(e) => {
                wrong.push(format!("{name}: {e}"));
                continue;
            }
        };
        let known = pins::read(name);
        if update {
            let later = known.iter().filter(|v| v.name != version.name);
            let all = std::iter::once(&version).chain(later);
            let text: Vec<String> = all.map(|v| pins::written(name, v)).collect();
            fs::write(pins::folder().join(format!("{name}.txt")), text.join("\n")).unwrap();
        } else if known.first() != Some(&version) {
            wrong.push(format!("{name}: its file is not what LinuxCNC's has"));
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}
