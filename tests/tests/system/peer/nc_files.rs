//! The sample programs of LinuxCNC's package, read where they are installed, through `rs274` and `halgcode canon`: the same calls, the
//! same line of an error, the same parameter file and the same written files. `tests/peer/nc_files.differences` has the others.
#![expect(clippy::unwrap_used, reason = "tests")]

use super::known::Known;
use hal_tests::{foreign, scratch::Scratch, tools::linuxcnc};
use std::{
    collections::BTreeMap,
    fs,
    path::{Path, PathBuf},
    process::{Command, Stdio},
};

/// The folders of programs, with their names in the list of differences.
const ROOTS: [(&str, &str); 2] = [
    ("nc_files", "/usr/share/linuxcnc/ncfiles"),
    ("configs", "/usr/share/doc/linuxcnc/examples/sample-configs"),
];

/// Folders of subroutines in `nc_files`. LinuxCNC reads at most ten.
const SUBROUTINES: [&str; 7] = [
    "ngcgui_lib",
    "ngcgui_lib/utilitysubs",
    "ngcgui_lib/lathe",
    "remap_lib/common_nc_subs",
    "gladevcp_lib",
    "probe/basic_probe/macros",
    ".",
];

/// At least this many programs and calls of subroutines must be found, so that an empty folder is no success.
const FEWEST: usize = 300;

/// The processor time in seconds, and the blocks of 1024 bytes that each may write, for each program: they bound a program without end.
const BOUNDS: &str = "ulimit -t 60; ulimit -f 65536; exec \"$@\"";

/// A program, or the call of the subroutine that a file defines.
struct Case {
    label: String,
    folder: PathBuf,
    name: String,
    text: Vec<u8>,
}

fn walk(folder: &Path, out: &mut Vec<PathBuf>) {
    let Ok(entries) = fs::read_dir(folder) else { return };
    for entry in entries {
        let path = entry.unwrap().path();
        if path.is_dir() && !path.is_symlink() {
            walk(&path, out);
        } else if path.is_file() {
            out.push(path);
        }
    }
}

/// Returns the arguments that remarks of ngcgui give to the subroutine of a file, or its number for an argument without one; `None`
/// where the file defines no subroutine of its name.
fn arguments(name: &str, text: &str) -> Option<Vec<String>> {
    let head = format!("o<{name}>sub");
    let plain = |l: &str| l.chars().filter(|c| !c.is_whitespace()).collect::<String>();
    text.lines().find(|l| plain(l).to_lowercase().starts_with(&head.to_lowercase()))?;
    let mut given = BTreeMap::new();
    for line in text.lines().map(plain) {
        let Some((_, value)) = line.strip_prefix("#<").and_then(|l| l.split_once(">=#")) else {
            continue;
        };
        let digits = value.find(|c: char| !c.is_ascii_digit()).unwrap_or(value.len());
        let (number, rest) = value.split_at(digits);
        let Ok(number) = number.parse::<usize>() else { continue };
        let remark = rest.strip_prefix("(=").unwrap_or_default();
        let end = remark.find(|c: char| !c.is_ascii_digit() && c != '.' && c != '-');
        let default = remark.get(..end.unwrap_or(0)).unwrap_or_default().to_owned();
        if (1..=30).contains(&number) {
            given.entry(number).or_insert(default);
        }
    }
    let last = given.last_key_value().map_or(0, |(n, _)| *n);
    let value = |n: usize| given.get(&n).filter(|d| !d.is_empty()).cloned();
    Some((1..=last).map(|n| value(n).unwrap_or_else(|| n.to_string())).collect())
}

fn cases() -> Vec<Case> {
    let mut out = Vec::new();
    for (root, folder) in ROOTS {
        let mut files = Vec::new();
        walk(Path::new(folder), &mut files);
        files.sort();
        for path in files {
            let name = path.file_name().unwrap().to_string_lossy().into_owned();
            // The distribution compresses long files of its documentation.
            let short = name.strip_suffix(".gz").unwrap_or(&name).to_owned();
            let Some(stem) = [".ngc", ".nc"].iter().find_map(|e| short.strip_suffix(e)) else {
                continue;
            };
            let text = if short == name {
                fs::read(&path).unwrap()
            } else {
                Command::new("gzip").arg("-dc").arg(&path).output().unwrap().stdout
            };
            let inner = path.strip_prefix(folder).unwrap().with_file_name(&short);
            let label = format!("{root}/{}", inner.display());
            let folder = path.parent().unwrap().to_path_buf();
            if let Some(given) = arguments(stem, &String::from_utf8_lossy(&text)) {
                let given: String = given.iter().map(|a| format!(" [{a}]")).collect();
                let text = format!("g20 f10 s100\no<{stem}> call{given}\nm2\n").into_bytes();
                let (label, folder) = (format!("{label} call"), folder.clone());
                out.push(Case { label, folder, name: "main.ngc".to_owned(), text });
            }
            out.push(Case { label, folder, name: short, text });
        }
    }
    out
}

/// The result of a program with one interpreter.
struct Run {
    calls: Vec<String>,
    failed: bool,
    line: String,
    files: BTreeMap<String, String>,
}

/// Writes the program and the files that it is given into an empty folder.
fn prepare(folder: &Path, case: &Case) {
    drop(fs::remove_dir_all(folder));
    fs::create_dir_all(folder).unwrap();
    let tool = |i: u32| {
        let turning = if (2..10).contains(&i) { i } else { 0 };
        let size = f64::from(5 + i) / 100.0;
        format!("T{i} P{i} X0.1 Z{:.1} D{size:.2} I95 J155 Q{turning}\n", f64::from(i) / 10.0)
    };
    fs::write(folder.join("tool.tbl"), (1..60).map(tool).collect::<String>()).unwrap();
    fs::write(folder.join("ferrule.var"), "5161 0.0\n").unwrap();
    let own = case.folder.display().to_string();
    let common = SUBROUTINES.map(|f| format!("{}/{f}", ROOTS[0].1));
    let ini = format!("[RS274NGC]\nSUBROUTINE_PATH = {own}:{}\n", common.join(":"));
    fs::write(folder.join("mill.ini"), ini).unwrap();
    fs::write(folder.join(&case.name), &case.text).unwrap();
    if rustix::process::getuid().is_root() {
        // The reference links its parameter file to a second name, which only the owner of a file may do.
        Command::new("chown").args(["-R", "nobody"]).arg(folder).status().unwrap();
    }
}

/// Runs the interpreter, whose words are `interpreter`.
fn run(mut command: Command, folder: &Path, case: &Case) -> Run {
    let words = ["-i", "mill.ini", "-t", "tool.tbl", "-v", "ferrule.var", "-g", &case.name];
    let output = command.args(words).current_dir(folder).stdin(Stdio::null()).output().unwrap();
    let own = [&*case.name, "tool.tbl", "mill.ini", "rs274.err", ".tool.mmap", "ferrule.var.bak"];
    let mut files = BTreeMap::new();
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        let name = path.file_name().unwrap().to_string_lossy().into_owned();
        if !own.contains(&&*name) {
            let text = String::from_utf8_lossy(&fs::read(&path).unwrap()).into_owned();
            files.insert(name, text);
        }
    }
    // The end of the program resets once more or once less; and the entry 0 of a tool table is the reference's copy of another one.
    let silent =
        |call: &&str| call.ends_with("ON_RESET()") || call.contains("SET_TOOL_TABLE_ENTRY(0,");
    // The reference prints the N word with its leading zeros.
    let plain = |line: &str| match line.trim_start().split_once(" N") {
        Some((n, call)) if n.parse::<u64>().is_ok() => {
            let short = call.trim_start_matches('0');
            let (number, call) = short.split_once(' ').unwrap_or((short, ""));
            format!("{number} {}", call.trim_start())
        }
        _ => line.to_owned(),
    };
    let stdout = String::from_utf8_lossy(&output.stdout).into_owned();
    let stderr = String::from_utf8_lossy(&output.stderr).into_owned();
    let calls = stdout.lines().filter(|l| !silent(l)).map(plain).collect();
    let line = stderr.lines().rfind(|l| *l != "executing").unwrap_or_default();
    Run { calls, failed: !output.status.success(), line: line.trim().to_owned(), files }
}

/// Returns whether two lines are equal, but for the last digit of a printed number.
fn same(a: &str, b: &str) -> bool {
    let is_number = |c: char| c.is_ascii_digit() || matches!(c, '.' | '-');
    let (mut a, mut b) = (a, b);
    loop {
        let text = |t: &str| t.find(is_number).unwrap_or(t.len());
        let ((a0, a1), (b0, b1)) = (a.split_at(text(a)), b.split_at(text(b)));
        if a0 != b0 || a1.is_empty() != b1.is_empty() {
            return false;
        }
        if a1.is_empty() {
            return true;
        }
        let number = |t: &str| t.find(|c| !is_number(c)).unwrap_or(t.len());
        let ((a0, a1), (b0, b1)) = (a1.split_at(number(a1)), b1.split_at(number(b1)));
        let close = match (a0.parse::<f64>(), b0.parse::<f64>()) {
            (Ok(x), Ok(y)) => (x - y).abs() < 1.5e-4,
            _ => false,
        };
        if a0 != b0 && !close {
            return false;
        }
        (a, b) = (a1, b1);
    }
}

/// Returns how two runs differ.
fn difference(theirs: &Run, ours: &Run) -> Option<String> {
    let (a, b) = (theirs.calls.join("\n"), ours.calls.join("\n"));
    let equal = theirs.calls.len() == ours.calls.len()
        && theirs.calls.iter().zip(&ours.calls).all(|(a, b)| same(a, b));
    if !equal {
        return Some(hal_golden::differing(&a, &b, same));
    }
    if (theirs.failed, &theirs.line) != (ours.failed, &ours.line) {
        let error =
            |r: &Run| format!("{} at '{}'", if r.failed { "error" } else { "no error" }, r.line);
        return Some(format!("- {}\n+ {}\n", error(theirs), error(ours)));
    }
    let names: Vec<&String> = theirs.files.keys().chain(ours.files.keys()).collect();
    let of = |r: &Run, n: &String| r.files.get(n).cloned().unwrap_or_else(|| "no file".to_owned());
    let is_equal = |n: &String| {
        let (a, b) = (of(theirs, n), of(ours, n));
        a.lines().count() == b.lines().count() && a.lines().zip(b.lines()).all(|(a, b)| same(a, b))
    };
    let other = names.into_iter().find(|n| !is_equal(n))?;
    let told = hal_golden::differing(&of(theirs, other), &of(ours, other), same);
    Some(format!("{other}:\n{told}"))
}

#[test]
fn sample_programs_of_the_package_make_the_calls_that_they_make_with_linuxcnc() {
    if linuxcnc().is_none() {
        return;
    }
    let scratch = Scratch::new("nc-files");
    let folder = scratch.path().join("room");
    let mut known = Known::read("nc_files.differences");
    let cases = cases();
    assert!(cases.len() >= FEWEST, "only {} programs in {ROOTS:?}", cases.len());
    for case in cases {
        prepare(&folder, &case);
        let mut peer = foreign::peer("sh", &folder);
        peer.args(["-c", BOUNDS, "sh", "rs274"]);
        let theirs = run(peer, &folder, &case);
        prepare(&folder, &case);
        let mut own = scratch.command(&[], "sh");
        own.args(["-c", BOUNDS, "sh", "halgcode", "canon"]);
        let ours = run(own, &folder, &case);
        known.judge(&case.label, difference(&theirs, &ours));
    }
    known.report();
}
