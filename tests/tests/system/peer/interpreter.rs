//! LinuxCNC's own tests of its interpreter, read from its source and never copied here, with `halgcode canon` in place of `rs274`.
//! `tests/peer/interpreter.differences` has those that differ.
#![expect(clippy::unwrap_used, reason = "tests")]

use super::known::Known;
use hal_tests::{scratch::Scratch, tools::report};
use std::{
    fs,
    path::{Path, PathBuf},
};

/// Names the folder of LinuxCNC's source, as `apt-get source linuxcnc` makes it.
const SOURCE: &str = "FERRULE_LINUXCNC_SOURCE";

/// Folders of `tests` whose tests are of the interpreter.
const FOLDERS: [&str; 5] = ["ccomp", "interp", "m70-m73", "oword", "remap"];

/// At least this many tests must be found, so that an empty folder is no success.
const FEWEST: usize = 80;

fn copy(from: &Path, to: &Path) {
    fs::create_dir_all(to).unwrap();
    for entry in fs::read_dir(from).unwrap() {
        let entry = entry.unwrap();
        let (path, to) = (entry.path(), to.join(entry.file_name()));
        if path.is_dir() {
            copy(&path, &to);
        } else if path.exists() {
            fs::copy(&path, to).unwrap();
        }
    }
}

/// Returns the folders that have a test.
fn tests(folder: &Path, out: &mut Vec<(PathBuf, &'static str)>) {
    let mut folders = Vec::new();
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            folders.push(path);
        }
    }
    // The reference leaves these out, too.
    if !folder.join("skip").exists() {
        let script = ["test.sh", "test"].into_iter().find(|s| folder.join(s).is_file());
        out.extend(script.map(|s| (folder.to_path_buf(), s)));
    }
    folders.sort();
    for folder in folders {
        tests(&folder, out);
    }
}

/// Returns whether a script starts a whole machine of LinuxCNC.
fn starts_machine(script: &str) -> bool {
    let plain = script.lines().map(|l| l.trim_start().trim_start_matches("exec "));
    plain.into_iter().any(|l| l.starts_with("linuxcnc "))
}

/// Returns how a test's result differs from the expected one.
fn difference(scratch: &Scratch, folder: &Path, script: &str) -> Option<String> {
    if starts_machine(&fs::read_to_string(folder.join(script)).unwrap()) {
        return Some("it starts a whole machine".to_owned());
    }
    let mut command = scratch.command(&[], "sh");
    let path = std::env::var("PATH").unwrap_or_default();
    let own = command.get_envs().find(|(n, _)| *n == "PATH").and_then(|(_, v)| v);
    let path = own.map_or(path, |p| p.to_string_lossy().into_owned());
    command.env("PATH", format!("{}:{path}", scratch.path().join("bin").display()));
    // Bounds of processor time and of what is written: a program without end ends.
    let start = if script == "test" { "./test" } else { "bash -x ./test.sh" };
    command.args(["-c", &format!("ulimit -t 60; ulimit -f 65536; exec {start}")]);
    let output = scratch.run(command.env("LIBDIR", "/usr/lib").current_dir(folder));
    let result = folder.join("result");
    fs::write(&result, &output.stdout).unwrap();
    if output.status != Some(0) {
        let tail: Vec<&str> = output.stdout.lines().chain(output.stderr.lines()).collect();
        let tail = tail.get(tail.len().saturating_sub(6)..).unwrap_or_default();
        return Some(format!("status {:?}\n{}", output.status, tail.join("\n")));
    }
    let judge = folder.join("checkresult");
    if judge.exists() {
        let output = scratch.run(
            scratch
                .command(&["sh", "-c", "exec \"$@\"", "sh"], &judge.display().to_string())
                .arg(&result)
                .current_dir(folder),
        );
        return (output.status != Some(0)).then(|| format!("checkresult: {output:?}"));
    }
    let expected =
        String::from_utf8_lossy(&fs::read(folder.join("expected")).unwrap()).into_owned();
    (expected != output.stdout).then(|| hal_golden::difference(&expected, &output.stdout))
}

#[test]
fn tests_of_linuxcncs_interpreter_have_their_expected_output() {
    let Some(source) = std::env::var_os(SOURCE).filter(|s| !s.is_empty()) else {
        report(&format!("{SOURCE} names no source of LinuxCNC (apt-get source linuxcnc)"));
        return;
    };
    let scratch = Scratch::new("interpreter");
    let all = scratch.path().join("tests");
    for folder in FOLDERS {
        copy(&Path::new(&source).join("tests").join(folder), &all.join(folder));
    }
    let bin = scratch.path().join("bin");
    fs::create_dir_all(&bin).unwrap();
    scratch.write("bin/rs274", "#!/bin/sh\nexec halgcode canon \"$@\"\n");
    let mode = std::os::unix::fs::PermissionsExt::from_mode(0o755);
    fs::set_permissions(bin.join("rs274"), mode).unwrap();
    let mut found = Vec::new();
    tests(&all, &mut found);
    assert!(found.len() >= FEWEST, "only {} tests in {}", found.len(), source.display());
    let mut known = Known::read("interpreter.differences");
    for (folder, script) in found {
        let name = folder.strip_prefix(&all).unwrap().display().to_string();
        known.judge(&name, difference(&scratch, &folder, script));
    }
    known.report();
}
