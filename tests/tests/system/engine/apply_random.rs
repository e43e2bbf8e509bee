//! Random lines, applied at once to one machine and executed one by one on another: the result is the same, or nothing
//! changes.
#![expect(clippy::unwrap_used, reason = "tests")]

use hal_engine::ClockKind;
use hal_protocol::{Kind, Link, Reply, Request};
use hal_tests::{
    machine::{Machine, applied, edits, request, seen},
    random::Random,
};
use std::collections::BTreeSet;

/// Number of files.
const FILES: usize = 3_000;

const SIGNALS: &[&str] = &["s0", "s1", "s2", "s3"];
const PINS: &[&str] = &[
    "and2.0.in0",
    "and2.0.in1",
    "and2.0.out",
    "and2.1.in0",
    "and2.1.in1",
    "and2.1.out",
    "swap.0.a",
    "swap.0.b",
    "swap.0.torn",
    "or2.0.in0",
    "or2.1.out",
    "xor2.0.in0",
    "xor2.0.out",
    "boom.0.line",
    "boom.1.line",
    "boom.0.cycles",
    "doomed.in",
    "doomed.out",
    "x0",
    "x1",
    "no-such-pin",
];
const FUNCTS: &[&str] = &[
    "and2.0",
    "and2.1",
    "swap.0.look",
    "swap.0.one",
    "swap.0.two",
    "or2.0",
    "or2.1",
    "xor2.0",
    "boom.0",
    "doomed.copy",
];
const THREADS: &[&str] = &["fast", "slow", "doomed-thread"];
const MODULES: &[&str] = &["or2 count=2", "xor2", "boom count=2", "doomed", "doomed by=open"];

fn line(d: &mut Random) -> String {
    let (s, p, q, f, t) = (d.one(SIGNALS), d.one(PINS), d.one(PINS), d.one(FUNCTS), d.one(THREADS));
    let n = d.index(4);
    match d.index(20) {
        0 => format!("newsig {s} {}", d.one(&["bit", "u32", "float"])),
        1 => format!("delsig {s}"),
        2..=4 => format!("net {s} {p}"),
        5 | 6 => format!("net {s} {p} {q}"),
        7 => format!("linkps {p} {s}"),
        8 | 9 => format!("unlinkp {p}"),
        10 | 11 => format!("setp {p} {n}"),
        12 => format!("sets {s} {n}"),
        13 | 14 => format!("addf {f} {t} {}", d.one(&["1", "2", "-1", "-2", "3"])),
        15 => format!("delf {f} {t}"),
        16 => format!("alias pin {p} {}", d.one(&["x0", "x1"])),
        17 => format!("unalias pin {p}"),
        18 => format!("loadrt {}", d.one(MODULES)),
        _ => format!("unloadrt {}", d.one(&["or2", "xor2", "boom", "doomed"])),
    }
}

/// Returns some random lines. They do not load again what they unload, which is refused.
fn file(d: &mut Random) -> Vec<String> {
    let mut unloaded = BTreeSet::new();
    let mut lines = Vec::new();
    for _ in 0..=d.index(5) {
        let line = line(d);
        let mut words = line.split(' ');
        let (verb, module) = (words.next().unwrap(), words.next().unwrap().to_owned());
        if verb == "unloadrt" {
            unloaded.insert(module.clone());
        }
        if verb != "loadrt" || !unloaded.contains(&module) {
            lines.push(line);
        }
    }
    lines
}

fn machine() -> Machine {
    let mut m = Machine::new(ClockKind::Virtual);
    m.script(
        "loadrt threads name1=fast period1=500000 name2=slow period2=1000000
         loadrt and2 count=2
         loadrt swap
         addf and2.0 fast
         addf swap.0.look slow
         net s0 and2.0.out and2.1.in0
         newsig s3 u32
         start",
    );
    m
}

/// Returns the state that two machines have in common: everything except addresses.
fn graph(m: &mut Machine) -> String {
    let mut text = String::new();
    for kind in [
        Kind::Components,
        Kind::Pins,
        Kind::Params,
        Kind::Signals,
        Kind::Threads,
        Kind::PinAliases,
        Kind::Commands,
        Kind::Streams,
        Kind::Functs,
    ] {
        match m.call(Request::List { kind, patterns: Vec::new(), ty: None }) {
            Ok(Reply::Functs(list)) => {
                list.iter().for_each(|f| text += &format!("{} {} {}\n", f.name, f.owner, f.users));
            }
            Ok(Reply::Components(list)) => {
                list.iter().for_each(|c| text += &format!("{} {:?}\n", c.name, c.args));
            }
            other => text += &format!("{other:?}\n"),
        }
    }
    // The machine that executes lines singly does not reuse ids of failed lines.
    let ids = text.split("owner: ").map(|part| part.split_once(',').map_or(part, |(_, rest)| rest));
    ids.collect()
}

#[test]
fn at_once_as_one_by_one_or_not_at_all() {
    let mut d = Random::new(1);
    let (mut by_line, mut at_once) = (machine(), machine());
    let (mut good, mut bad, mut lines_done) = (0, 0, 0);
    for n in 0..FILES {
        let lines = file(&mut d);
        if lines.is_empty() {
            continue;
        }
        let mut done = 0;
        let mut failed = None;
        for line in &lines {
            match by_line.call(request(line)) {
                Ok(_) => done += 1,
                Err(failure) => {
                    failed = Some(format!("{}: {}", done + 1, failure.text));
                    break;
                }
            }
        }
        lines_done += done;
        let text = lines.join("\n");
        if let Some(failure) = failed {
            bad += 1;
            let before = seen(&mut at_once);
            assert_eq!(applied(&mut at_once, &text), failure, "{n}: {lines:#?}");
            assert_eq!(seen(&mut at_once), before, "{n}: {lines:#?}");
            // The lines that the other machine has executed.
            let part = lines.get(..done).unwrap().join("\n");
            assert!(done == 0 || applied(&mut at_once, &part) == "ok", "{n}: {lines:#?}");
        } else {
            good += 1;
            if n % 3 == 0 {
                let before = seen(&mut at_once);
                assert!(matches!(at_once.call(edits(&text, true)), Ok(Reply::Applied { .. })));
                assert_eq!(seen(&mut at_once), before, "{n}: {lines:#?}");
            }
            assert_eq!(applied(&mut at_once, &text), "ok", "{n}: {lines:#?}");
        }
        assert_eq!(graph(&mut at_once), graph(&mut by_line), "{n}: {lines:#?}");
        for m in [&mut by_line, &mut at_once] {
            m.script("run 2000000");
            m.engine.take_messages();
        }
        assert_eq!(graph(&mut at_once), graph(&mut by_line), "{n}, after a run: {lines:#?}");
    }
    assert!(good > 200 && bad > 200 && lines_done > 1000, "{good} {bad} {lines_done}");
}
