//! Kinematics of users in C: compiled by `halcompile`, loaded by ordinary scripts and INI files, used by `motmod`.
//!
//! `tests/kinematics` has the modules, a machine with a program, and scripts with the output expected of them.
#![expect(clippy::indexing_slicing, clippy::unwrap_used, reason = "tests")]

use hal_tests::{
    foreign::{check_clean, check_scripts, compiled, installed, run_beside, run_virtual as run},
    golden,
    programs::root,
    scratch::Scratch,
    tools,
    vcd::Vcd,
};
use std::{collections::BTreeMap, fmt::Write};

/// Modules.
const MODULES: [&str; 9] = [
    "turned.c",
    "crossed.c",
    "leaning.comp",
    "polar.c",
    "elbow.c",
    "round.c",
    "partial.c",
    "half.c",
    "unusual.c",
];

/// LinuxCNC's modules.
const THEIRS: [&str; 19] = [
    "5axiskins",
    "corexykins",
    "genhexkins",
    "genserkins",
    "lineardeltakins",
    "maxkins",
    "pentakins",
    "pumakins",
    "rosekins",
    "rotarydeltakins",
    "rotatekins",
    "scarakins",
    "scorbot-kins",
    "tripodkins",
    "trivkins",
    "userkins",
    "xyzab_tdr_kins",
    "xyzac-trt-kins",
    "xyzbc-trt-kins",
];

/// Agreement with closed forms, and with other kinematics of the same mathematics, in millimetres or degrees.
const NEAR: f64 = 1e-9;

/// Agreement of positions that are shown with seven digits.
const SHOWN: f64 = 2e-5;

/// Returns a folder with the compiled modules, or `None` without a compiler.
fn folder() -> Option<Scratch> {
    compiled("kinematics", &MODULES)
}

/// Returns the recording of the program `part.ngc` on a machine.
fn part(scratch: &Scratch, ini: &str) -> Vcd {
    let output = run(scratch, &["--run", "part.ngc", ini]);
    let said = output.stderr.lines().map(|l| l.starts_with("part.ngc: ended after "));
    assert_eq!((output.status, said.collect()), (Some(0), vec![true]), "{ini}: {}", output.stderr);
    Vcd::parse(&scratch.read("part.vcd"))
}

/// Returns the values of recorded items after each moment at which one of them has changed.
fn rows(vcd: &Vcd, names: &[String]) -> Vec<(i64, Vec<f64>)> {
    let mut changes: BTreeMap<i64, Vec<(usize, f64)>> = BTreeMap::new();
    for (n, name) in names.iter().enumerate() {
        for (time, value) in vcd.of(name) {
            changes.entry(*time).or_default().push((n, *value));
        }
    }
    let mut now = vec![0.0; names.len()];
    let row = |(time, list): (i64, Vec<(usize, f64)>)| {
        for (n, value) in list {
            now[n] = value;
        }
        (time, now.clone())
    };
    changes.into_iter().map(row).collect()
}

fn joints(n: usize) -> Vec<String> {
    (0..n).map(|n| format!("joint.{n}.pos-cmd")).collect()
}

/// Asserts that every row of a program's recording has the joints where `closed` puts them for X Y Z C, and that no limit
/// was broken.
fn assert_positions(vcd: &Vcd, what: &str, closed: fn(&[f64]) -> Vec<f64>) {
    let names: Vec<String> = ["x", "y", "z", "c"].map(|l| format!("axis.{l}.pos-cmd")).into();
    let names = [names, joints(6)].concat();
    let rows = rows(vcd, &names);
    assert!(rows.len() > 1000, "{what}: {} rows", rows.len());
    let mut widest = 0.0_f64;
    for (time, row) in &rows {
        let (pose, places) = row.split_at(4);
        for (n, (place, wanted)) in places.iter().zip(closed(pose)).enumerate() {
            let off = (place - wanted).abs();
            assert!(off < NEAR, "{what}: joint {n} at {time} ns: {place}, not {wanted}");
            widest = widest.max(wanted.abs());
        }
    }
    assert!(widest > 20.0, "{what}: its joints hardly move");
    assert_eq!(vcd.of("motion.watch.violations").last().unwrap().1, 0.0, "{what}");
}

#[test]
fn scripts_run_unchanged_and_say_what_is_expected() {
    let Some(scratch) = folder() else { return };
    check_scripts(&scratch, "kinematics");
}

/// Returns a point turned by an angle in degrees.
fn turned(x: f64, y: f64, degrees: f64) -> [f64; 2] {
    let (s, c) = degrees.to_radians().sin_cos();
    [x * c - y * s, x * s + y * c]
}

#[test]
fn a_program_moves_joints_where_the_closed_form_puts_them() {
    let Some(scratch) = folder() else { return };
    let vcd = part(&scratch, "turned.ini");
    assert_positions(&vcd, "turned", |p| [&turned(p[0], p[1], 30.0)[..], &p[2..3]].concat());
    let first = scratch.read("part.vcd");
    part(&scratch, "turned.ini");
    assert_eq!(first, scratch.read("part.vcd"), "the same bytes twice");
    let vcd = part(&scratch, "leaning.ini");
    assert_positions(&vcd, "leaning", |p| vec![p[0], p[1] + 0.25 * p[0], p[2]]);
}

#[test]
fn the_same_mathematics_moves_the_joints_alike() {
    let Some(scratch) = folder() else { return };
    let vcd = part(&scratch, "round.ini");
    let closed = |p: &[f64]| {
        let [x, y] = turned(p[0], p[1], p[3]);
        vec![x, y, p[2], 0.0, 0.0, p[3]]
    };
    assert_positions(&vcd, "round", closed);
    let places = rows(&vcd, &joints(6));
    alike(&places, &part(&scratch, "rotatekins.ini"), "Rust");
    if tools::linuxcnc().is_some() {
        std::fs::copy(installed().unwrap().join("rotatekins.so"), scratch.path().join("theirs.so"))
            .unwrap();
        alike(&places, &part(&scratch, "theirs.ini"), "LinuxCNC");
    }
}

fn alike(places: &[(i64, Vec<f64>)], other: &Vcd, what: &str) {
    let others = rows(other, &joints(6));
    assert_eq!(places.len(), others.len(), "{what}");
    for ((time, a), (again, b)) in places.iter().zip(&others) {
        assert_eq!(time, again, "{what}");
        let off = a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        assert!(off < NEAR, "{what} at {time} ns: {a:?}, {b:?}");
    }
}

#[test]
fn check_finds_nothing_wrong() {
    let Some(scratch) = folder() else { return };
    check_clean(&scratch, &["turned.ini", "leaning.ini", "round.ini"]);
    for (line, said) in [
        ("loadrt partial type=99", "partial: kinematicsType crashes: segmentation fault"),
        ("loadrt unusual fault=3", "unusual: kinematicsSwitch crashes: segmentation fault"),
    ] {
        scratch.write("crash.hal", line);
        let output = run_beside(&scratch, "halcmd", &["check", "crash.hal"]);
        assert!(output.stdout.contains(said), "{}{}", output.stdout, output.stderr);
    }
}

/// Motion and the planner solve poses at the same time. A module never has two calls in it, and the copy that motion uses
/// solves a few poses in each cycle, however many the planner does.
#[test]
fn the_planner_and_motion_have_a_copy_each() {
    let Some(scratch) = folder() else { return };
    let output = run(&scratch, &["-f", "at-once.hal"]);
    assert_eq!(output.status, Some(0), "{}", output.stderr);
    let vcd = Vcd::parse(&scratch.read("solved.vcd"));
    let solved = vcd.of("turned.solved");
    assert!(solved.len() > 1000, "{} cycles", solved.len());
    for (a, b) in solved.iter().zip(&solved[1..]) {
        assert!(b.1 - a.1 <= 4.0, "{} poses in the cycle at {} ns", b.1 - a.1, b.0);
    }
    let output = run_beside(&scratch, "halrun", &["-f", "at-once.hal"]);
    assert_eq!((output.status, output.stdout.as_str()), (Some(0), "0\n"), "{}", output.stderr);
}

#[test]
fn a_crash_in_kinematics_names_them() {
    let Some(scratch) = folder() else { return };
    let motion = "function 'motion-controller', thread 'servo-thread'";
    let planner = "worker 'motmod.planner'";
    for (fault, by) in [(3, motion), (4, planner), (5, motion), (6, planner)] {
        let start = "loadrt turned coordinates=XYZ\nsource start.hal\n";
        let move_on = "run 10ms\nmotion.move x=10 velocity=50 --wait\n";
        scratch.write("crash.hal", format!("{start}setp turned.fault {fault}\n{move_on}"));
        let output = run(&scratch, &["-f", "crash.hal"]);
        assert_eq!(output.status, None, "it ends by its signal");
        let said =
            format!("component 'motmod', {by}, in code of component 'turned': segmentation fault");
        assert!(output.stderr.contains(&said), "{}", output.stderr);
    }
}

/// Runs the example of each kinematics twice: with ours, and with LinuxCNC's module of that name.
#[test]
fn linuxcncs_modules_move_the_joints_of_our_examples() {
    if tools::linuxcnc().is_none() {
        return;
    }
    let scratch = Scratch::new("linuxcnc-kins");
    let mut said = String::new();
    for name in THEIRS {
        let page = root().join("components/pages").join(format!("{name}.md"));
        let page = std::fs::read_to_string(page).unwrap();
        let (_, example) = page.split_once("```hal\n").unwrap();
        let (example, _) = example.split_once("```").unwrap();
        let lines = format!("{example}show pin joint.*.pos-cmd\n");
        let shown = ["", "--c "].map(|c| {
            let module = format!("loadrt {name}");
            scratch.write("one.hal", lines.replace(&module, &format!("loadrt {c}{name}")));
            let mut command = scratch.command(&[], "halrun");
            command.env("HAL_LINUXCNC_MODULES", "1").args(["--virtual", "-k", "-f", "one.hal"]);
            scratch.run(&mut command)
        });
        let places = shown.each_ref().map(|o| positions(&o.stdout));
        let errors = shown[1].stderr.lines().filter(|l| l.starts_with("motmod: "));
        let errors: Vec<&str> = errors.collect();
        let [ours, theirs] = &places;
        assert!(!ours.is_empty(), "{name}: {shown:?}");
        let same = ours.len() == theirs.len()
            && ours.iter().zip(theirs).all(|(a, b)| a.0 == b.0 && (a.1 - b.1).abs() < SHOWN);
        let same = if same { "the same positions" } else { "other positions" };
        writeln!(
            said,
            "{name}: {same}{}{}",
            if errors.is_empty() { "" } else { "; " },
            errors.join("; ")
        )
        .unwrap();
    }
    golden::check(&root().join("tests/kinematics/linuxcnc.txt"), &said);
}

/// Returns the positions of joints that `show` has printed, by pin.
fn positions(shown: &str) -> Vec<(&str, f64)> {
    let rows = shown.lines().filter(|l| l.contains(" joint.") && l.contains(".pos-cmd"));
    rows.map(|line| {
        let words: Vec<&str> = line.split_whitespace().collect();
        (words[4], words[3].parse().unwrap())
    })
    .collect()
}
