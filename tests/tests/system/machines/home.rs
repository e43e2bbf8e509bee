//! Entries of the INI file that name files and folders: relative to the INI file, and in the user's home.
#![expect(clippy::unwrap_used, reason = "tests")]

use hal_tests::{programs::root, scratch::Scratch};
use std::{collections::BTreeMap, fs, os::unix::fs::PermissionsExt as _, path::Path};

/// Entries, each with a file or folder beside the INI file.
const ENTRIES: [(&str, &str, &str); 11] = [
    ("HAL", "HALFILE", "printer.hal"),
    ("HAL", "POSTGUI_HALFILE", "custom_postgui.hal"),
    ("EMCIO", "TOOL_TABLE", "tool.tbl"),
    ("EMCIO", "SPINDLE_FILE", "kept.spindle"),
    ("RS274NGC", "PARAMETER_FILE", "kept.var"),
    ("TASK", "JOURNAL", "kept.journal"),
    ("AXIS_0", "COMP_FILE", "x.comp"),
    ("DISPLAY", "PROGRAM_PREFIX", "programs"),
    ("RS274NGC", "SUBROUTINE_PATH", "subs"),
    ("RS274NGC", "USER_M_PATH", "codes"),
    ("RS274NGC", "OUTPUT_DIR", "logs"),
];

/// Program that needs each of them.
const JOB: &str = "G10 L1 P1 Z-12.5\nG10 L2 P1 X7\n(LOGOPEN,said.txt)\n(LOG,logged)\n(LOGCLOSE)\no<in-subs> call\n\
                   o<in-programs> call\nM110 P3\nM61 Q1\nG0 X1\nM2\n";

/// Returns an INI file whose entries have names that `write` gives, and all others as they were.
fn ini(write: impl Fn(usize, &str) -> String) -> String {
    let text = fs::read_to_string(root().join("configs/printer/printer.ini")).unwrap();
    let is_ours = |line: &str| {
        let name = line.split('=').next().unwrap_or_default().trim();
        ENTRIES
            .iter()
            .any(|(_, entry, file)| *entry == name && (name != "HALFILE" || line.ends_with(file)))
    };
    let mut lines: Vec<String> =
        text.lines().filter(|line| !is_ours(line)).map(str::to_owned).collect();
    // From the last, since the printer's file comes before that of the user.
    for (n, (section, name, file)) in ENTRIES.iter().enumerate() {
        let at = lines.iter().position(|line| *line == format!("[{section}]")).unwrap();
        lines.insert(at + 1, format!("{name} = {}", write(n, file)));
    }
    lines.join("\n") + "\n"
}

/// Runs the job on the machine in the folder `m` of the home, and returns all files of the home.
fn run(ini: &str) -> BTreeMap<String, String> {
    let scratch = Scratch::new("home");
    let from = root().join("configs/printer");
    let machine = scratch.path().join("m");
    for folder in ["programs", "subs", "codes"] {
        fs::create_dir_all(machine.join(folder)).unwrap();
    }
    for file in ["printer.hal", "custom.hal", "custom_postgui.hal", "tool.tbl"] {
        fs::copy(from.join(file), machine.join(file)).unwrap();
    }
    let write = |name: &str, text: &str| fs::write(machine.join(name), text).unwrap();
    write("subs/in-subs.ngc", "o<in-subs> sub\nG10 L2 P2 X8\no<in-subs> endsub\n");
    write("programs/in-programs.ngc", "o<in-programs> sub\nG10 L2 P3 X9\no<in-programs> endsub\n");
    write("codes/M110", "#!/bin/sh\necho code $1 > \"$HOME/m/code.txt\"\n");
    fs::set_permissions(machine.join("codes/M110"), fs::Permissions::from_mode(0o755)).unwrap();
    write("x.comp", "-50 -50.1 -50.1\n200 199.9 199.9\n");
    write("job.ngc", JOB);
    write("m.ini", ini);
    let mut command = scratch.command(&[], "halrun");
    command.env("HOME", scratch.path());
    let output =
        scratch.run(command.args(["--virtual", "--headless", "--run", "m/job.ngc", "m/m.ini"]));
    assert_eq!(output.status, Some(0), "{ini}\n{output:?}");
    let mut out = BTreeMap::new();
    files(scratch.path(), scratch.path(), &mut out);
    out
}

/// Collects the files below a folder by their names; a journal by its name alone, since it has the times of files.
fn files(home: &Path, folder: &Path, out: &mut BTreeMap<String, String>) {
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        let name = path.strip_prefix(home).unwrap().to_str().unwrap().to_owned();
        if path.is_dir() {
            if name != ".run" && !name.ends_with(".ferrule") {
                files(home, &path, out);
            }
        } else if name != "m/m.ini" {
            let text = String::from_utf8_lossy(&fs::read(&path).unwrap()).into_owned();
            out.insert(name.clone(), if name.ends_with(".journal") { String::new() } else { text });
        }
    }
}

#[test]
fn each_entry_names_a_file_beside_the_ini_file_or_in_the_home() {
    let beside = run(&ini(|_, file| file.to_owned()));
    for name in ["kept.spindle", "kept.var", "kept.journal", "logs/said.txt", "code.txt"] {
        assert!(beside.contains_key(&format!("m/{name}")), "{name}: {:?}", beside.keys());
    }
    for (n, (section, entry, _)) in ENTRIES.iter().enumerate() {
        let in_home = run(&ini(|other, file| match other == n {
            true => format!("~/m/{file}"),
            false => file.to_owned(),
        }));
        assert_eq!(in_home, beside, "[{section}]{entry}");
    }
}
