//! The scripts of `tests/peer` through all of Ferrule, compared with the output that LinuxCNC gave: no sample differs.
#![expect(clippy::unwrap_used, reason = "tests")]

use hal_tests::{programs::root, scratch::Scratch};
use std::{collections::BTreeMap, fmt::Write};

/// Returns the output of several samplers side by side, as `run.sh` joins it.
fn pasted(scratch: &Scratch) -> Vec<String> {
    let raw: Vec<String> = scratch
        .files()
        .into_iter()
        .filter(|(name, _)| name.ends_with(".raw"))
        .map(|(_, bytes)| String::from_utf8(bytes).unwrap())
        .collect();
    let columns: Vec<Vec<&str>> = raw.iter().map(|r| r.lines().collect()).collect();
    let rows = columns.iter().map(Vec::len).max().unwrap_or(0);
    (0..rows)
        .map(|i| {
            let cells = columns.iter().map(|c| c.get(i).copied().unwrap_or(""));
            cells.collect::<String>().trim_end().to_owned()
        })
        .collect()
}

/// Returns whole periods of the slow thread, as `cut.awk` selects them.
fn cut(lines: Vec<String>) -> Vec<String> {
    let last = lines.len() / 10 - 2;
    let mut held: BTreeMap<usize, Vec<String>> = BTreeMap::new();
    for line in lines {
        let tick: f64 = line.split_whitespace().next().unwrap().parse().unwrap();
        for i in 1..=last {
            if tick == i as f64 {
                held.entry(i).or_default().push(line.clone());
                break;
            }
        }
    }
    assert!(held.values().all(|h| h.len() == 10), "a slow period does not hold ten fast ones");
    held.into_values().flatten().collect()
}

fn compare(name: &str) {
    let folder = root().join("tests/peer");
    let scratch = Scratch::new(name);
    let script = std::fs::read_to_string(folder.join(format!("{name}.hal"))).unwrap();
    scratch.write(&format!("{name}.hal"), &script);
    for e in std::fs::read_dir(&folder).unwrap() {
        let path = e.unwrap().path();
        if path.extension().is_some_and(|e| e == "in") {
            let file = path.file_name().unwrap().to_string_lossy().into_owned();
            scratch.write(&file, std::fs::read(&path).unwrap());
        }
    }
    let out = scratch.halrun(&["--virtual", "-f", &format!("{name}.hal")]);
    assert_eq!(out.status, Some(0), "{name}: {}{}", out.stdout, out.stderr);
    let mut got = pasted(&scratch);
    assert!(!got.iter().any(|l| l.contains("overrun")), "{name}: samples were lost");
    if script.lines().any(|l| l.starts_with("net tick")) {
        got = cut(got);
    }
    let want = std::fs::read_to_string(folder.join(format!("{name}.out"))).unwrap();
    let want: Vec<&str> = want.lines().collect();
    let mut wrong = String::new();
    for (i, (g, w)) in got.iter().zip(&want).enumerate().filter(|(_, (g, w))| g != w).take(5) {
        writeln!(wrong, "sample {i}: {g}\n  expected: {w}").unwrap();
    }
    assert!(wrong.is_empty(), "{name}:\n{wrong}");
    assert_eq!(got.len(), want.len(), "{name}: another number of samples");
}

macro_rules! peers {
    ($($name:ident)*) => {$(
        #[test]
        fn $name() {
            compare(stringify!($name));
        }
    )*};
}
peers! { types timing position servo printer steptest siggen limit3 }

/// Returns the contents of both registers after `write` and then `reset`, in every period.
fn registers(scratch: &Scratch) -> Vec<String> {
    let script = std::fs::read_to_string(root().join("tests/peer/parport.hal")).unwrap();
    let rows = std::fs::read_to_string(root().join("tests/peer/parport.in")).unwrap();
    let n = rows.lines().count();
    scratch.write("parport.in", &rows);
    let mut own = String::new();
    for line in script.lines() {
        match line {
            "loadrt threads name1=fast period1=1000000" => {
                own.push_str("loadrt sampler depth=1000,1000 cfg=uu,uu\n");
                own.push_str(
                    "net data parport.0.sim.data => sampler.0.pin.0 sampler.1.pin.0\n\
                     net control parport.0.sim.control => sampler.0.pin.1 sampler.1.pin.1\n",
                );
                writeln!(own, "{line}").unwrap();
            }
            "addf parport.read-all fast" => {
                writeln!(own, "addf sampler.0 fast\n{line}").unwrap();
            }
            "addf parport.0.reset fast" => {
                writeln!(own, "{line}\naddf sampler.1 fast").unwrap();
            }
            l if l.starts_with("loadusr -w sleep") => {
                writeln!(own, "run {n}ms").unwrap();
                for s in [0, 1] {
                    writeln!(own, "loadusr -w halsampler -c {s} -n {n} {s}.raw").unwrap();
                }
            }
            l => writeln!(own, "{l}").unwrap(),
        }
    }
    scratch.write("parport.hal", own);
    let out = scratch.halrun(&["--virtual", "-f", "parport.hal"]);
    assert_eq!(out.status, Some(0), "{}{}", out.stdout, out.stderr);
    let read = |s: &str| scratch.read(&format!("{s}.raw"));
    let (write, reset) = (read("0"), read("1"));
    write.lines().zip(reset.lines()).map(|(w, r)| format!("{} / {}", w.trim(), r.trim())).collect()
}

#[test]
fn parport_writes_and_resets_as_the_peer_does() {
    let scratch = Scratch::new("parport");
    let got = registers(&scratch);
    let want = std::fs::read_to_string(root().join("tests/peer/parport.out")).unwrap();
    let mut now = BTreeMap::new();
    let mut expected = Vec::new();
    for line in want.lines() {
        let (write, reset) = line.split_once('/').unwrap();
        let mut state = |words: &str| {
            for word in words.split_whitespace() {
                let (register, value) = word.split_once('=').unwrap();
                now.insert(register.to_owned(), u32::from_str_radix(value, 16).unwrap());
            }
            let at = |r: &str| now.get(r).copied().unwrap_or(0);
            format!("{} {}", at("378"), at("37a"))
        };
        expected.push(format!("{} / {}", state(write), state(reset)));
    }
    assert!(got.len() >= 161 && expected.len() >= 161);
    for (i, (g, e)) in got.iter().zip(&expected).enumerate() {
        assert_eq!(g, e, "period {i}: data control / data control");
    }
    let reset = expected.iter().filter(|e| e.split_once(" / ").is_some_and(|(w, r)| w != r));
    assert!(reset.count() > 20, "the figures show no reset");
}
