//! The scripts of `tests/peer`, through the whole of Ferrule, beside the figures that LinuxCNC
//! gave: no sample differs.
#![expect(clippy::unwrap_used, reason = "tests")]

use hal_tests::{programs::root, scratch::Scratch};
use std::{collections::BTreeMap, fmt::Write};

/// Side by side what several samplers printed, as `run.sh` puts it.
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

/// Whole periods of the slow thread, as `cut.awk` takes them.
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
