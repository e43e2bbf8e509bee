//! Sample configurations of LinuxCNC with remaps in Python: their files, unchanged, in `halgcode` and in `rs274`.
#![expect(clippy::unwrap_used, reason = "tests")]

use hal_tests::{scratch::Scratch, tools::linuxcnc};
use std::{
    fs,
    path::Path,
    process::{Command, Stdio},
};

const SAMPLES: &str = "/usr/share/doc/linuxcnc/examples/sample-configs/sim/axis/remap";
const FILES: &str = "/usr/share/linuxcnc/ncfiles";

/// Each sample with its program, and the number of calls that Ferrule makes (lines that functions print are none). `stop-lookahead` remaps G70, which LinuxCNC 2.9
/// has as a code of its own: its program ends with an error there too.
const PROGRAMS: [(&str, &str, &str, usize); 5] = [
    ("cycle", "cycle.ini", "examples.ngc", 12),
    ("extend-builtins", "extend-builtins.ini", "examples.ngc", 51),
    ("getting-started", "demo.ini", "examples.ngc", 248),
    ("manual-toolchange-with-tool-length-switch", "manualtoolchange.ini", "tcdemo.ngc", 173),
    ("rack-toolchange", "racktoolchange.ini", "tcdemo.ngc", 169),
];

/// Lines that differ because `rs274` begins with tool -1 in the spindle, and Ferrule without a tool.
const OF_THE_FIRST_TOOL: usize = 10;

fn copy(from: &Path, to: &Path) {
    fs::create_dir_all(to).unwrap();
    for entry in fs::read_dir(from).unwrap() {
        let entry = entry.unwrap();
        let (path, to) = (entry.path(), to.join(entry.file_name()));
        if path.is_dir() {
            copy(&path, &to);
        } else if path.extension().is_some_and(|e| e == "gz") {
            // The distribution compresses long files of its documentation.
            let text = Command::new("gzip").arg("-dc").arg(&path).output().unwrap();
            fs::write(to.with_extension(""), text.stdout).unwrap();
        } else if path.exists() {
            fs::copy(&path, to).unwrap();
        }
    }
}

/// Returns the calls of an output without their numbers.
fn calls(output: &str) -> Vec<&str> {
    output.lines().filter_map(|l| l.trim_start().split_once(" N").map(|(_, call)| call)).collect()
}

#[test]
fn sample_remaps_make_the_calls_that_they_make_with_linuxcnc() {
    if linuxcnc().is_none() || !Path::new(SAMPLES).is_dir() {
        return;
    }
    let scratch = Scratch::new("remaps");
    std::os::unix::fs::symlink(FILES, scratch.path().join("nc_files")).unwrap();
    let table = Path::new(SAMPLES).join("tool.tbl");
    for (name, ini, program, count) in PROGRAMS {
        let folder = scratch.path().join("configs").join(name);
        copy(&Path::new(SAMPLES).join(name), &folder);
        fs::copy(&table, folder.join("tools.tbl")).unwrap();
        Command::new("chmod").args(["-R", "a+rwX"]).arg(scratch.path()).status().unwrap();
        let program = format!("nc_files/{program}");
        let words = ["-i", ini, "-t", "tools.tbl", "-g", &program];
        let mut theirs =
            match fs::metadata("/proc/self").map(|m| std::os::unix::fs::MetadataExt::uid(&m)) {
                Ok(0) => {
                    let mut command = Command::new("runuser");
                    command.args(["-u", "nobody", "--", "env"]);
                    command.arg(format!("HOME={}", scratch.path().display())).arg("rs274");
                    command
                }
                _ => Command::new("rs274"),
            };
        let theirs = theirs.args(words).current_dir(&folder).stdin(Stdio::null()).output().unwrap();
        let theirs = String::from_utf8_lossy(&theirs.stdout).into_owned();
        let mut command = scratch.command(&[], "halgcode");
        let ours = scratch.run(command.arg("canon").args(words).current_dir(&folder));
        let (theirs, ours) = (calls(&theirs), calls(&ours.stdout));
        assert_eq!(ours.len(), count, "{name}: {ours:#?}");
        let differ = |call: &&&str| !theirs.contains(*call);
        let own: Vec<&&str> = ours.iter().filter(differ).collect();
        let lost: Vec<&&str> = theirs.iter().filter(|call| !ours.contains(*call)).collect();
        let most =
            if name.contains("rack") || name.contains("extend") { OF_THE_FIRST_TOOL } else { 0 };
        assert!(own.len() + lost.len() <= most, "{name}: only here {own:#?}, only there {lost:#?}");
        if most == 0 {
            assert_eq!(ours, theirs, "{name}");
        }
    }
}
