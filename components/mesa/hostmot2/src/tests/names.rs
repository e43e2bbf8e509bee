//! Names, types, directions and initial values of pins, beside what LinuxCNC's driver makes of the same cards.
//!
//! `tests/mesa/pins` has a list of LinuxCNC's driver for each card.

use super::card;
use crate::Hostmot2;
use hal_bench::Bench;
use std::{
    collections::{BTreeMap, BTreeSet},
    fs,
    path::{Path, PathBuf},
};

/// Items by name: type, direction and initial value.
type Items = BTreeMap<String, String>;

fn folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../tests/mesa")
}

/// Reads a list, without the times of functions, which the engine makes.
fn theirs(text: &str) -> Items {
    let mut items = Items::new();
    for line in text.lines() {
        let words: Vec<_> = line.split_whitespace().collect();
        let ["pin" | "param", name, ty, dir, value] = words[..] else { continue };
        let last = name.rsplit('.').next().unwrap();
        if ["time", "tmax", "tmax-increased"].contains(&last) {
            continue;
        }
        let value = match value.strip_prefix("0x") {
            Some(hex) => u32::from_str_radix(hex, 16).unwrap().to_string(),
            None if ty == "float" => digits(value.parse().unwrap()),
            None => value.to_owned(),
        };
        items.insert(name.to_owned(), item(ty, dir, &value));
    }
    items
}

/// Returns a number with the seven digits that the lists have.
fn digits(x: f64) -> String {
    format!("{x:.6e}")
}

/// Returns type, direction and initial value. The initial value of an output is what the card shows: LinuxCNC's driver reads
/// some of them while it is loaded, ours reads all.
fn item(ty: &str, dir: &str, value: &str) -> String {
    match dir {
        "OUT" => format!("{ty} {dir}"),
        _ => format!("{ty} {dir} {value}"),
    }
}

/// Pins that LinuxCNC's driver does not have.
const OWN: [&str; 4] = ["packet-round-trip", "packet-wait", ".fault", ".dither"];

/// Returns the value of an item as text.
pub(super) fn value(bench: &Bench, name: &str, ty: &str) -> String {
    match ty {
        "bit" => bench.get::<bool>(name).to_string().to_uppercase(),
        "float" => bench.get::<f64>(name).to_string(),
        "s32" => bench.get::<i32>(name).to_string(),
        "u32" => bench.get::<u32>(name).to_string(),
        _ => panic!("{name}: {ty}"),
    }
}

fn ours(bench: &Bench) -> Items {
    let items = bench.names().into_iter().map(|line| {
        let words: Vec<_> = line.split(' ').collect();
        let [name, ty, dir] = words[..] else { panic!("{line}") };
        let value = match ty {
            "float" => digits(bench.get(name)),
            _ => value(bench, name, ty),
        };
        (name.to_owned(), item(ty, dir, &value))
    });
    let is_own =
        |name: &String| name.contains(".sim.") || OWN.iter().any(|own| name.ends_with(own));
    items.filter(|(name, _)| !is_own(name)).collect()
}

/// Scripts load `hostmot2` before `hm2_eth`; alone it makes no pin.
#[test]
fn hostmot2_makes_nothing_and_takes_its_arguments() {
    let mut bench = Bench::new();
    bench.load::<Hostmot2>(&["debug_idrom=1", "use_serial_numbers=0"]).unwrap();
    assert!(bench.names().is_empty());
    let refused = Bench::new().load::<Hostmot2>(&["use_serial_numbers=1"]).unwrap_err();
    assert!(refused.contains("use_serial_numbers"), "{refused}");
}

#[test]
fn every_card_has_linuxcncs_pins() {
    let mut bad = Vec::new();
    let mut cards = 0;
    for line in fs::read_to_string(folder().join("boards")).unwrap().lines() {
        let words: Vec<_> = line.split_whitespace().collect();
        let [name, config, "--board", kind, ref rest @ ..] = words[..] else { continue };
        let text = fs::read_to_string(folder().join(format!("pins/{name}.txt"))).unwrap();
        let theirs = theirs(&text);
        if theirs.is_empty() {
            // LinuxCNC of that release refuses the card.
            continue;
        }
        cards += 1;
        let mut remotes: Vec<_> = rest.iter().copied().filter(|word| *word != "--remote").collect();
        if remotes.is_empty() {
            remotes.push("alone");
        }
        let simulated = format!("{kind} {}", remotes.join(" "));
        let bench = card(&simulated, &config.trim_matches('-').replace(',', " "));
        let ours = ours(&bench);
        let names: BTreeSet<_> = theirs.keys().chain(ours.keys()).collect();
        // That release does not know the lights of these boards.
        let unknown = ["7i76eu", "7i95t"].contains(&kind);
        for item in names {
            if unknown && item.contains(".led.CR") {
                continue;
            }
            if theirs.get(item) != ours.get(item) {
                bad.push(format!("{name}: {item}: {:?} {:?}", theirs.get(item), ours.get(item)));
            }
        }
    }
    assert!(bad.is_empty(), "{cards} cards, {} differences:\n{}", bad.len(), bad.join("\n"));
    assert!(cards > 10);
}
