//! Homing modules of users in C: compiled by `halcompile`, loaded by ordinary scripts and INI files, used by `motmod`.
//!
//! `tests/homing` has the modules, a machine, and scripts with the output expected of them.

use hal_tests::{
    golden,
    programs::root,
    scratch::{Output, Scratch},
    tools,
};
use std::collections::BTreeMap;

/// Modules.
const MODULES: [&str; 5] = ["at_once.comp", "search.c", "bad.c", "half.c", "elsewhere.c"];

/// Agreement with LinuxCNC's positions, in units: the distance that the latch velocity covers in two cycles.
const NEAR: f64 = 0.004;

/// Returns a folder with the compiled modules, or `None` without a compiler.
fn folder() -> Option<Scratch> {
    tools::compiler()?;
    let scratch = Scratch::copy_of(&root().join("tests/homing"));
    for module in MODULES {
        let output = scratch.run(scratch.command(&[], "halcompile").args(["--compile", module]));
        assert_eq!((output.status, output.stderr.as_str()), (Some(0), ""), "{module}");
    }
    Some(scratch)
}

/// Runs halrun on the virtual clock with the modules of the folder.
fn run(scratch: &Scratch, words: &[&str]) -> Output {
    let mut command = scratch.command(&[], "halrun");
    command.env("HAL_RTMOD_DIR", scratch.path()).arg("--virtual").args(words);
    scratch.run(&mut command)
}

#[test]
fn scripts_say_what_is_expected() {
    let Some(scratch) = folder() else { return };
    let files = std::fs::read_dir(root().join("tests/homing")).unwrap();
    let files = files.map(|file| file.unwrap().path());
    for file in files.filter(|file| file.extension().is_some_and(|e| e == "out")) {
        let name = file.file_stem().unwrap().to_str().unwrap();
        let script = format!("{name}.hal");
        let output = run(&scratch, &["-k", "-f", &script]);
        assert_eq!(output, run(&scratch, &["-k", "-f", &script]), "{name}: not the same twice");
        let shown = scratch.path().display().to_string();
        let text = format!("{}--- standard error\n{}", output.stdout, output.stderr);
        golden::check(&file, &text.replace(&shown, "FOLDER"));
    }
}

/// Takes LinuxCNC's display out of the INI files.
fn without_display(scratch: &Scratch) {
    for name in ["search.ini", "own.ini", "at_once.ini"] {
        let text = scratch.read(name).replace("[DISPLAY]\nDISPLAY = ./drive.py\n", "");
        scratch.write(name, text);
    }
}

/// Returns the homed positions that a file of LinuxCNC's or a listing shows, by pin.
fn positions(text: &str) -> BTreeMap<String, f64> {
    let rows = text.lines().map(|line| line.split_whitespace().collect::<Vec<_>>());
    let pairs = rows.filter_map(|words| match words[..] {
        [pin, value] | [_, _, _, value, pin, ..] => Some((pin.to_owned(), value.parse().ok()?)),
        _ => None,
    });
    pairs.filter(|(pin, _)| pin.starts_with("joint.")).collect()
}

/// `linuxcnc.txt` has the positions of LinuxCNC 2.9 with the same modules, compiled by its own halcompile.
#[test]
fn a_machine_homes_where_it_does_in_linuxcnc() {
    let Some(scratch) = folder() else { return };
    let recorded = scratch.read("linuxcnc.txt");
    without_display(&scratch);
    for part in recorded.split("== ").skip(1) {
        let (name, theirs) = part.split_once('\n').unwrap();
        let output = run(&scratch, &["--for", "60s", &format!("{name}.ini")]);
        assert_eq!(output.status, Some(0), "{name}: {}{}", output.stdout, output.stderr);
        let (ours, theirs) = (positions(&output.stdout), positions(theirs));
        assert_eq!(theirs.len(), 9, "{name}");
        for (pin, value) in &theirs {
            let own = ours.get(pin).unwrap_or_else(|| panic!("{name}: {pin} {}", output.stdout));
            assert!((own - value).abs() <= NEAR, "{name}: {pin} is {own}, not {value}");
        }
        let kept = |line: &str| line.contains(" 0x00000000  motion.watch.violations");
        let kept = output.stdout.lines().any(kept);
        assert!(kept, "{name}: {}", output.stdout);
    }
}

#[test]
fn check_finds_nothing_wrong() {
    let Some(scratch) = folder() else { return };
    let check = |file: &str| {
        let mut command = scratch.command(&[], "halcmd");
        command.env("HAL_RTMOD_DIR", scratch.path()).args(["check", file]);
        scratch.run(&mut command)
    };
    for ini in ["search.ini", "own.ini", "at_once.ini"] {
        let Output { stdout, stderr, status, .. } = check(ini);
        assert_eq!((status, stderr.as_str()), (Some(0), ""), "{ini}: {stdout}");
        assert!(!stdout.contains("error[") && !stdout.contains("warning["), "{ini}: {stdout}");
    }
    for (crash, said) in [
        (1, "the homing module 'bad': homing_init crashes: segmentation fault"),
        (2, "the homing module 'bad': homing_init does not return"),
    ] {
        scratch.write(
            "crash.hal",
            format!("loadrt trivkins coordinates=X\nloadrt bad crash={crash}\nloadrt motmod num_joints=1\n"),
        );
        let output = check("crash.hal");
        assert!(output.stdout.contains(said), "{}{}", output.stdout, output.stderr);
    }
}

/// An INI file that names a module without homing, or none that exists, does not start.
#[test]
fn a_module_that_does_not_home_is_refused_by_name() {
    let Some(scratch) = folder() else { return };
    without_display(&scratch);
    let ini = scratch.read("at_once.ini");
    for (module, said) in [
        ("and2", "the module 'and2' offers no homing: it needs the functions of homing.h"),
        ("half", "it has homing without homing_init"),
        (
            "elsewhere",
            "the homing module 'elsewhere': it was compiled for joint records of another kind",
        ),
        ("nowhere", "nowhere"),
    ] {
        scratch.write("other.ini", ini.replace("at_once home_parms=quick", module));
        let output = run(&scratch, &["--for", "1s", "other.ini"]);
        assert_ne!(output.status, Some(0), "{module}: {}", output.stdout);
        assert!(output.stderr.contains(said), "{module}: {}", output.stderr);
    }
}

#[test]
fn a_crash_in_homing_names_the_module() {
    let Some(scratch) = folder() else { return };
    let script = scratch.read("bad.hal");
    let (start, _) = script.split_once("motion.enable").unwrap();
    scratch.write(
        "crash.hal",
        format!("{start}motion.enable --wait\nsetp bad.fault 15\nmotion.home joint=0 --wait\n"),
    );
    let output = run(&scratch, &["-f", "crash.hal"]);
    assert_eq!(output.status, None, "it ends by its signal");
    let said = "component 'motmod', function 'motion-controller', thread 'servo-thread', in code of \
                component 'bad': segmentation fault";
    assert!(output.stderr.contains(said), "{}", output.stderr);
}

/// LinuxCNC's own module touches no joint; all joints are homed at once.
#[test]
fn linuxcncs_homecomp_homes() {
    if tools::linuxcnc().is_none() {
        return;
    }
    let scratch = Scratch::copy_of(&root().join("tests/homing"));
    let lines = scratch.read("at_once.hal");
    let (start, _) = lines.split_once("print ").unwrap();
    scratch.write(
        "theirs.hal",
        start
            .replace("loadrt at_once home_parms=\"any text\"", "loadrt --c homecomp")
            .replace("at-once.*", "homecomp.*"),
    );
    let mut command = scratch.command(&[], "halrun");
    command.env("HAL_LINUXCNC_MODULES", "1").args(["--virtual", "-k", "-f", "theirs.hal"]);
    let output = scratch.run(&mut command);
    let text = format!("{}--- standard error\n{}", output.stdout, output.stderr);
    golden::check(&root().join("tests/homing/homecomp.txt"), &text);
}
