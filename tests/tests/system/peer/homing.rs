//! Homing modules of users in C: compiled by `halcompile`, loaded by ordinary scripts and INI files, used by `motmod`.
//!
//! `tests/homing` has the modules, a machine, and scripts with the output expected of them.

use hal_tests::{
    foreign::{check_clean, check_scripts, compiled, run_beside, run_virtual as run},
    golden,
    programs::root,
    scratch::Scratch,
    tools,
};
use std::collections::BTreeMap;

/// Modules.
const MODULES: [&str; 5] = ["at_once.comp", "search.c", "bad.c", "half.c", "elsewhere.c"];

/// Agreement with LinuxCNC's positions, in units: the distance that the latch velocity covers in two cycles.
const NEAR: f64 = 0.004;

/// Returns a folder with the compiled modules, or `None` without a compiler.
fn folder() -> Option<Scratch> {
    compiled("homing", &MODULES)
}

#[test]
fn scripts_say_what_is_expected() {
    let Some(scratch) = folder() else { return };
    check_scripts(&scratch, "homing");
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
    check_clean(&scratch, &["search.ini", "own.ini", "at_once.ini"]);
    for (crash, said) in [
        (1, "the homing module 'bad': homing_init crashes: segmentation fault"),
        (2, "the homing module 'bad': homing_init does not return"),
    ] {
        scratch.write(
            "crash.hal",
            format!("loadrt trivkins coordinates=X\nloadrt bad crash={crash}\nloadrt motmod num_joints=1\n"),
        );
        let output = run_beside(&scratch, "halcmd", &["check", "crash.hal"]);
        assert!(output.stdout.contains(said), "{}{}", output.stdout, output.stderr);
    }
}

/// An INI file that names a module without homing, one that does not exist, or another one than its HAL file, does not
/// start.
#[test]
fn a_module_that_does_not_home_is_refused_by_name() {
    let Some(scratch) = folder() else { return };
    let ini = scratch.read("at_once.ini");
    let machine = scratch.read("machine.hal");
    let refuses = |module: &str, said: &str| {
        scratch.write("other.ini", ini.replace("at_once home_parms=quick", module));
        let output = run(&scratch, &["--for", "1s", "other.ini"]);
        assert_ne!(output.status, Some(0), "{module}: {}", output.stdout);
        assert!(output.stderr.contains(said), "{module}: {}", output.stderr);
    };
    for (module, said) in [
        ("and2", "the module 'and2' offers no homing: it needs the functions of homing.h"),
        ("half", "it has homing without homing_init"),
        (
            "elsewhere",
            "the homing module 'elsewhere': it was compiled for joint records of another kind",
        ),
        ("nowhere", "other.ini:6: nowhere: no plugin library offers this component"),
    ] {
        refuses(module, said);
    }
    scratch.write("machine.hal", format!("loadrt bad\n{machine}"));
    refuses("search", "homing is loaded already, by component 'search'");
    scratch.write("machine.hal", format!("loadrt at_once\n{machine}"));
    refuses(
        "and2",
        "the module 'at_once' offers homing, and 'and2' is to home: load that one alone",
    );
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

/// LinuxCNC's `homecomp` touches no joint; all joints are homed at once. Its `homemod` is refused.
#[test]
fn linuxcncs_own_modules() {
    if tools::linuxcnc().is_none() {
        return;
    }
    let scratch = Scratch::copy_of(&root().join("tests/homing"));
    let lines = scratch.read("at_once.hal");
    let (start, _) = lines.split_once("print ").unwrap();
    let start = start.replace("loadrt at_once home_parms=\"any text\"", "loadrt --c homecomp");
    let end =
        "unloadrt motmod\nunloadrt homecomp\nloadrt --c homemod\nloadrt motmod num_joints=1\n";
    scratch.write("theirs.hal", start.replace("at-once.*", "homecomp.*") + end);
    let mut command = scratch.command(&[], "halrun");
    command.env("HAL_LINUXCNC_MODULES", "1").args(["--virtual", "-k", "-f", "theirs.hal"]);
    let output = scratch.run(&mut command);
    let text = format!("{}--- standard error\n{}", output.stdout, output.stderr);
    golden::check(&root().join("tests/homing/homecomp.txt"), &text);
}
