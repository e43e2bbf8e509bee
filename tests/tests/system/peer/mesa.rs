//! The driver of Mesa's cards beside LinuxCNC's: what both write to a simulated card, cycle by cycle.
//!
//! `tests/mesa/*.hal` are machines, `tests/mesa/writes` has what LinuxCNC's driver wrote for each, `tests/mesa/values` the pins that it
//! sampled (`tests/mesa/oracle` records both). Here ours runs the same machines with the same card over UDP. The card's time goes on by
//! one period with each packet that reads, so that the computer's own time changes nothing.

#![expect(clippy::unwrap_used, clippy::print_stdout, reason = "tests")]

use hal_tests::{
    programs::{programs, root},
    scratch::{Scratch, until},
};
use std::{
    collections::{BTreeMap, BTreeSet},
    fs,
    path::PathBuf,
    process::Command,
    sync::atomic::{AtomicU8, Ordering::Relaxed},
};

/// First cycle that is compared: until then both prepare the card, each in its order.
const BEGIN: usize = 5;

/// Difference from LinuxCNC's driver.
struct Known {
    machine: &'static str,
    /// Beginning of the names of registers.
    register: &'static str,
    /// Largest number of cycles that differ, and largest difference of a value.
    cycles: usize,
    most: u32,
    why: &'static str,
}

const ANY: u32 = u32::MAX;

const KNOWN: &[Known] = &[
    Known {
        machine: "",
        register: "SERIAL_",
        cycles: usize::MAX,
        most: ANY,
        why: "orders to the ports come in another order",
    },
    Known {
        machine: "motion",
        register: "STEP_RATE[1]",
        cycles: usize::MAX,
        most: 0x0030_0000,
        why: "without a limit of the acceleration, rounding decides whether a correction comes in this cycle or the next",
    },
    Known {
        machine: "mill",
        register: "STEP_RATE[1]",
        cycles: usize::MAX,
        most: 2,
        why: "other order of sums: one unit in the last place of the rate",
    },
];

/// Value of each register by cycle.
type Writes = BTreeMap<String, BTreeMap<usize, u32>>;

fn folder() -> PathBuf {
    root().join("tests/mesa")
}

fn names() -> Vec<String> {
    let files = fs::read_dir(folder()).unwrap().filter_map(|entry| {
        let name = entry.unwrap().file_name().into_string().unwrap();
        name.strip_suffix(".hal").map(str::to_owned)
    });
    let mut names: Vec<_> = files.collect();
    names.sort();
    names
}

/// Reads a list that `writes.awk` made.
fn writes(text: &str) -> Writes {
    let mut writes = Writes::new();
    let mut cycle = 0;
    for line in text.lines() {
        if let Some(number) = line.strip_prefix("cycle ") {
            cycle = number.parse().unwrap();
        }
        let line = line.strip_prefix("start write").unwrap_or(line).trim_start();
        let Some((register, value)) = line.split_once(" = ") else { continue };
        let value = u32::from_str_radix(value, 16).unwrap();
        writes.entry(register.to_owned()).or_default().insert(cycle, value);
    }
    writes
}

/// Returns a comment of a machine's file, such as `# cycles: 100`.
fn comment<'t>(text: &'t str, name: &str) -> &'t str {
    let start = format!("# {name}: ");
    text.lines().find_map(|line| line.strip_prefix(&start)).unwrap()
}

/// Runs a machine of ours with a card. Returns what it wrote, and the sampled pins.
fn ours(name: &str) -> (Writes, String) {
    static CARDS: AtomicU8 = AtomicU8::new(1);
    let [low, high, ..] = std::process::id().to_le_bytes();
    let address = format!("127.{}.{high}.{}", CARDS.fetch_add(1, Relaxed), low | 1);
    let scratch = Scratch::copy_of(&folder());
    let text = scratch.read(&format!("{name}.hal"));
    let cycles = comment(&text, "cycles");
    // Packets that the card loses on purpose are waited for in vain.
    let longest = if name == "loss" { "400000000" } else { "2000000000" };
    let mut machine = text
        .replace("board_ip=192.168.1.121", &format!("board_ip={address}"))
        .replace("packet-read-timeout 50000000", &format!("packet-read-timeout {longest}"));
    assert!(machine.contains(longest), "{name}");
    machine.push_str(&format!("loadusr -w halsampler -n {cycles} values.own\n"));
    scratch.write("machine.hal", machine);
    let mut card = scratch.command(&[], programs().join("hm2card").to_str().unwrap());
    card.args(["--address", &address, "--record", "record"]);
    let card = scratch.start(card.args(comment(&text, "card").split(' '))).lasting("hm2card");
    until("the card listens", || card.said().0.contains(&address));
    // A busy computer is late; the card waits.
    let output = scratch.halrun(&["--stuck-time", "60s", "-f", "machine.hal"]);
    assert_eq!(output.status, Some(0), "{name}: {}", output.stderr);
    drop(card);
    let cycles = format!("cycles={cycles}");
    let mut awk = Command::new("awk");
    let awk = awk.args(["-v", &cycles, "-f", "writes.awk", "record"]).current_dir(scratch.path());
    let listed = awk.output().unwrap();
    assert!(listed.status.success(), "{}", String::from_utf8_lossy(&listed.stderr));
    (writes(&String::from_utf8_lossy(&listed.stdout)), scratch.read("values.own"))
}

/// Returns the values of a register from the first cycle that is compared to the last.
fn series(written: Option<&BTreeMap<usize, u32>>, last: usize) -> Vec<u32> {
    let mut value = 0;
    let mut values = Vec::new();
    for cycle in 0..=last {
        value = written.and_then(|written| written.get(&cycle)).copied().unwrap_or(value);
        if cycle >= BEGIN {
            values.push(value);
        }
    }
    values
}

/// Difference of a sampled pin from LinuxCNC's.
struct KnownPin {
    machine: &'static str,
    /// Columns of the sampler.
    columns: &'static [usize],
    /// Largest number of cycles that differ, and largest difference.
    cycles: usize,
    most: f64,
    why: &'static str,
}

const FROM_THE_LOAD: &str =
    "ours knows the levels of inputs from the load on, theirs from the second read on";
const FIRST_COUNT: &str = "after a rest, ours tells the speed of the first count from the time since the last one, theirs says 0; \
     a speed that falls is limited by the time since the last count, which ours takes at the read";
const PHASE: &str =
    "the two DPLLs settle at phases that differ by at most 0.25 us, so their latches do";
const PORT_START: &str = "a port of ours starts with the first write, and its states are those of the manual; theirs shows 0 meanwhile";

const KNOWN_PINS: &[KnownPin] = &[
    KnownPin { machine: "mill", columns: &[1], cycles: 3, most: 2e-6, why: PHASE },
    KnownPin { machine: "mill", columns: &[2], cycles: 200, most: 1e-4, why: PHASE },
    KnownPin { machine: "mill", columns: &[3, 4, 5, 6], cycles: 1, most: 1.0, why: FROM_THE_LOAD },
    KnownPin { machine: "mill", columns: &[8], cycles: 2, most: 2.0, why: FIRST_COUNT },
    KnownPin { machine: "servo", columns: &[1], cycles: 5, most: 60.0, why: FIRST_COUNT },
    KnownPin { machine: "servo", columns: &[7, 8], cycles: 1, most: 1.0, why: FROM_THE_LOAD },
    KnownPin { machine: "motion", columns: &[0, 3], cycles: 120, most: 1e-4, why: PHASE },
    KnownPin { machine: "motion", columns: &[5], cycles: 20, most: 1.0, why: PHASE },
    KnownPin { machine: "motion", columns: &[13], cycles: usize::MAX, most: 0.25, why: PHASE },
    KnownPin { machine: "motion", columns: &[7], cycles: 5, most: 0.5, why: FIRST_COUNT },
    KnownPin {
        machine: "motion",
        columns: &[2],
        cycles: usize::MAX,
        most: 0.02,
        why: "without a limit of the acceleration, rounding decides whether a correction comes in this cycle or the next",
    },
    KnownPin {
        machine: "remotes",
        columns: &[0, 2, 3, 4, 5],
        cycles: 20,
        most: 10.0,
        why: PORT_START,
    },
    KnownPin { machine: "remotes", columns: &[7], cycles: 90, most: 7.0, why: PORT_START },
];

/// Pins of a machine that differ, by column: in how many cycles, in which one first, and by how much at most.
type Differ = BTreeMap<usize, (usize, usize, f64)>;

/// Compares what `halsampler` printed. Returns the number of values, and those that differ.
fn sampled(theirs: &str, ours: &str) -> (usize, Differ) {
    let mut differ = Differ::new();
    let mut all = 0;
    assert_eq!(theirs.lines().count(), ours.lines().count());
    for (row, (theirs, ours)) in theirs.lines().zip(ours.lines()).enumerate() {
        let numbers = |line: &str| -> Vec<f64> {
            line.split_whitespace().map(|word| word.parse().unwrap()).collect()
        };
        let (theirs, ours) = (numbers(theirs), numbers(ours));
        assert_eq!(theirs.len(), ours.len(), "{row}");
        for (column, (theirs, ours)) in theirs.iter().zip(&ours).enumerate() {
            all += 1;
            let difference = (theirs - ours).abs();
            // NaN differs from everything.
            let difference = if difference.is_nan() { f64::INFINITY } else { difference };
            if difference > 0.0 {
                let entry = differ.entry(column).or_insert((0, row, 0.0_f64));
                *entry = (entry.0 + 1, entry.1, entry.2.max(difference));
            }
        }
    }
    (all, differ)
}

#[test]
fn registers_have_the_values_that_linuxcncs_driver_writes() {
    let mut wrong = Vec::new();
    let (mut used, mut used_pins) = (BTreeSet::new(), BTreeSet::new());
    let mut pins = (0, 0);
    let (mut compared, mut equal) = (0, 0);
    for name in names() {
        let theirs = fs::read_to_string(folder().join(format!("writes/{name}.txt"))).unwrap();
        let theirs = writes(&theirs);
        let (own, values) = ours(&name);
        let last = *theirs.values().flat_map(BTreeMap::keys).max().unwrap();
        let registers: BTreeSet<_> = theirs.keys().chain(own.keys()).collect();
        for register in registers {
            let pair = [theirs.get(register), own.get(register)].map(|w| series(w, last));
            let differs = pair[0].iter().zip(&pair[1]).map(|(a, b)| {
                // Rates are signed.
                a.cast_signed().wrapping_sub(b.cast_signed()).unsigned_abs()
            });
            let differs: Vec<u32> = differs.collect();
            let cycles = differs.iter().filter(|d| **d > 0).count();
            compared += differs.len();
            equal += differs.len() - cycles;
            if cycles == 0 {
                continue;
            }
            let most = differs.iter().max().copied().unwrap_or(0);
            let at = differs.iter().position(|d| *d > 0).unwrap_or(0);
            let known = KNOWN.iter().position(|known| {
                (known.machine.is_empty() || known.machine == name)
                    && register.starts_with(known.register)
                    && cycles <= known.cycles
                    && most <= known.most
            });
            if let Some(known) = known {
                used.insert(known);
            } else {
                wrong.push(format!(
                    "{name}: {register}: {cycles} cycles, at most {most}; first in cycle {}: {:08X} and ours {:08X}",
                    at + BEGIN,
                    pair[0][at],
                    pair[1][at]
                ));
            }
        }
        let theirs = fs::read_to_string(folder().join(format!("values/{name}.txt"))).unwrap();
        let (all, differ) = sampled(&theirs, &values);
        let known = |column: usize, cycles: usize, most: f64| {
            KNOWN_PINS.iter().position(|known| {
                known.machine == name
                    && known.columns.contains(&column)
                    && cycles <= known.cycles
                    && most <= known.most
            })
        };
        pins = (pins.0 + all, pins.1 + differ.values().map(|row| row.0).sum::<usize>());
        for (column, (cycles, first, most)) in differ {
            match known(column, cycles, most) {
                Some(known) => drop(used_pins.insert((known, column))),
                None => wrong.push(format!(
                    "{name}: sampled pin {column}: {cycles} cycles, at most {most}; first in {first}"
                )),
            }
        }
    }
    println!("{} of {} sampled values are equal", pins.0 - pins.1, pins.0);
    println!("{equal} of {compared} values are equal");
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
    assert!(compared > 20_000, "{compared}");
    let used_pins = &used_pins;
    let unused = KNOWN_PINS.iter().enumerate().flat_map(|(n, known)| {
        let columns = known.columns.iter().filter(move |c| !used_pins.contains(&(n, **c)));
        columns.map(|column| format!("{} {column}: {}", known.machine, known.why))
    });
    let unused = unused.collect::<Vec<_>>();
    assert!(unused.is_empty(), "equal by now: {unused:#?}");
    for (n, known) in KNOWN.iter().enumerate() {
        assert!(used.contains(&n), "{} {}: {}", known.machine, known.register, known.why);
    }
}
