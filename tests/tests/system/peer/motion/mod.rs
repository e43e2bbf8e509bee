//! Programs through LinuxCNC's motion controller and through ours, on machines with the same limits, tolerances and servo period.
//!
//! The programs, the machine and LinuxCNC's display stand in `tests/peer/motion`. The sampler notes the joint positions of every servo
//! cycle, and the watchman judges both from these positions alone: velocity and acceleration of each joint, and the distance
//! from the programmed path. Time counts from the first cycle of motion to the last. LinuxCNC runs in real time, as an
//! ordinary user; ours runs on the virtual clock. No joint has a limit of jerk, because LinuxCNC 2.9 has none.
//!
//! `cargo test -p hal-tests --test system peer::motion -- --ignored` runs all programs through both, which takes eight minutes;
//! with `UPDATE_EXPECT=1` it writes `components/motion/motion/PEER.md`.
#![expect(clippy::unwrap_used, clippy::expect_used, clippy::panic, reason = "tests")]

mod path;

use hal_tests::{foreign, golden, programs::root, scratch::Scratch, tools};
use hal_watchman::{Limits, Watchman};
use path::Programmed;
use std::{fmt::Write, path::PathBuf, process::Command};

/// Number of joints: X Y Z A B.
const JOINTS: usize = 5;
/// Servo period in seconds.
const PERIOD: f64 = 0.001;
/// Velocity and acceleration of each joint, as `machine.ini` has them.
const LIMITS: [(f64, f64); JOINTS] =
    [(120.0, 1000.0), (120.0, 1000.0), (60.0, 500.0), (90.0, 900.0), (90.0, 900.0)];
/// Samples are integers and six places, of a millionth of a unit.
const SCALE: f64 = 1e-6;
/// Part of a limit that the rounding of samples to 1e-12 units makes, at most.
const ROUNDING: f64 = 1e-7;
/// Programs that each run of the tests puts through ours.
const QUICK: &[&str] = &["engraving", "gear", "surface-rounded", "tilt", "slots"];

/// Program number and joint positions of a servo cycle.
type Sample = (f64, [f64; JOINTS]);

/// Figures of one program on one controller.
#[derive(Clone, Copy, Debug)]
struct Figures {
    seconds: f64,
    /// Worst velocity and acceleration of a joint as a part of its limit.
    velocity: f64,
    acceleration: f64,
    /// Largest distance from the path as a part of the tolerance.
    distance: f64,
}

impl Figures {
    fn of(samples: &[[f64; JOINTS]], path: &Programmed) -> Self {
        let (Some(first), Some(last)) = (samples.first(), samples.last()) else {
            panic!("no samples")
        };
        let start = samples.iter().position(|s| s != first).expect("it moves");
        let end = samples.iter().rposition(|s| s != last).expect("it moves") + 1;
        let limits = LIMITS.map(|(velocity, acceleration)| Limits {
            velocity,
            acceleration,
            jerk: f64::INFINITY,
        });
        let mut watch = Watchman::new(limits, PERIOD, 1.0);
        for sample in samples {
            watch.step(sample, 0);
        }
        let report = watch.report();
        let poses = samples.iter().map(|[x, y, z, a, b]| {
            let mut pose = [0.0; 9];
            pose[..JOINTS].copy_from_slice(&[*x, *y, *z, *a, *b]);
            pose
        });
        Self {
            seconds: (end + 1 - start) as f64 * PERIOD,
            velocity: report.velocity.ratio,
            acceleration: report.acceleration.ratio,
            distance: path.worst(poses),
        }
    }

    fn keeps_all(&self) -> bool {
        [self.velocity, self.acceleration, self.distance].iter().all(|r| *r <= 1.0 + ROUNDING)
    }
}

/// Returns the folder of the programs.
fn folder() -> PathBuf {
    root().join("tests/peer/motion")
}

/// Returns the names of all programs.
fn names() -> Vec<String> {
    let mut names: Vec<String> = std::fs::read_dir(folder())
        .unwrap()
        .filter_map(|e| e.unwrap().file_name().to_str()?.strip_suffix(".ngc").map(str::to_owned))
        .collect();
    names.sort();
    names
}

/// Reads what the sampler noted.
fn samples(text: &str) -> Vec<Sample> {
    text.lines()
        .map(|line| {
            let mut words = line.split_whitespace();
            let mut next = || words.next().and_then(|w| w.parse::<f64>().ok());
            let (Some(program), joints) = (next(), [(); JOINTS].map(|()| next())) else {
                panic!("samples were lost: {line}")
            };
            let joints = joints.map(|j| SCALE * j.unwrap_or_else(|| panic!("cut: {line}")));
            (program, joints)
        })
        .collect()
}

/// Runs a program through ours, on the virtual clock.
fn ours(name: &str) -> Figures {
    let scratch = Scratch::copy_of(&folder());
    let ini = scratch.read("machine.ini");
    scratch.write("ours.ini", ini.replace(".hal\n", ".hal\nHALFILE = record.hal\n"));
    scratch.write("record.hal", "loadusr -Wn halsampler0 halsampler samples\n");
    let program = format!("{name}.ngc");
    let out = scratch.halrun(&["--virtual", "--headless", "--run", &program, "ours.ini"]);
    assert_eq!(out.status, Some(0), "{name}: {}{}", out.stdout, out.stderr);
    let positions: Vec<_> = samples(&scratch.read("samples")).into_iter().map(|s| s.1).collect();
    Figures::of(&positions, &Programmed::read(scratch.path(), &program))
}

/// Runs programs through LinuxCNC; `None` without it.
fn theirs(names: &[String]) -> Option<Vec<Figures>> {
    let here = foreign::installed().filter(|_| PathBuf::from("/usr/bin/linuxcnc").is_file());
    tools::LINUXCNC.or_skip(here)?;
    let scratch = Scratch::copy_of(&folder());
    let mut allow = Command::new("chmod");
    assert!(allow.args(["-R", "a+rwX,a+x"]).arg(scratch.path()).status().unwrap().success());
    let programs: Vec<String> = names.iter().map(|n| format!("{n}.ngc")).collect();
    let mut command = foreign::peer("/usr/bin/linuxcnc", scratch.path());
    command
        .arg("machine.ini")
        .env("PROGRAMS", programs.join(" "))
        .env("PATH", "/usr/bin:/bin:/usr/sbin:/sbin");
    let out = command.output().unwrap();
    let text = String::from_utf8_lossy(&out.stdout);
    let all = samples(&scratch.read("samples"));
    let figures = programs.iter().zip(1_u32..).map(|(program, number)| {
        let positions: Vec<_> =
            all.iter().filter(|s| s.0 == f64::from(number)).map(|s| s.1).collect();
        assert!(!positions.is_empty(), "LinuxCNC did not run {program}: {text}");
        Figures::of(&positions, &Programmed::read(scratch.path(), program))
    });
    Some(figures.collect())
}

/// Asserts that ours kept every limit and the tolerance.
fn check(name: &str, ours: &Figures) {
    assert!(ours.keeps_all(), "{name}: {ours:?}");
}

#[test]
fn limits_and_tolerance_hold_on_the_joint_pins() {
    for name in QUICK {
        check(name, &ours(name));
    }
}

#[test]
#[ignore = "eight minutes, and needs LinuxCNC: cargo test -p hal-tests --test system peer::motion -- --ignored"]
fn all_programs_beside_linuxcnc() {
    let names = names();
    let Some(theirs) = theirs(&names) else { return };
    let mut table = String::from(HEAD);
    let (mut total, mut kept) = ([0.0; 2], 0);
    for (name, theirs) in names.iter().zip(&theirs) {
        let ours = ours(name);
        check(name, &ours);
        total[0] += ours.seconds;
        total[1] += theirs.seconds;
        kept += usize::from(theirs.keeps_all());
        let tolerance = Programmed::read(&folder(), &format!("{name}.ngc")).tolerance;
        write!(table, "| {name} | {tolerance} | {:.3} | {:.3} ", ours.seconds, theirs.seconds)
            .unwrap();
        write!(table, "| {:.3} ", ours.seconds / theirs.seconds).unwrap();
        for f in [&ours, theirs] {
            write!(table, "| {:.3} | {:.3} | {:.3} ", f.velocity, f.acceleration, f.distance)
                .unwrap();
        }
        table.push_str("|\n");
    }
    writeln!(
        table,
        "\nAll {} programs: {:.1} s ours, {:.1} s LinuxCNC's, which kept limits and tolerance in {kept} of them.",
        names.len(),
        total[0],
        total[1]
    )
    .unwrap();
    // LinuxCNC's figures vary from run to run, so that only a person can compare them.
    if golden::is_update() {
        golden::check(&root().join("components/motion/motion/PEER.md"), &table);
    }
}

/// Beginning of the table.
const HEAD: &str = "\
# Ferrule's motion beside LinuxCNC's

`UPDATE_EXPECT=1 cargo test -p hal-tests --test system peer::motion -- --ignored` writes this page. It runs the programs of
`tests/peer/motion` through LinuxCNC 2.9, headless, and through Ferrule, on one machine: servo period 1 ms, X and Y 120 mm/s and
1000 mm/s², Z 60 and 500, A and B 90 °/s and 900 °/s², no limit of jerk. Both sets of figures come from the joint positions of every
servo cycle alone, judged by `hal-watchman`.

- Seconds: from the first cycle of motion to the last. Ratio: ours to LinuxCNC's; below 1, ours is faster.
- v, a: the worst velocity and acceleration of a joint as a part of its limit.
- d: the largest distance from the programmed path as a part of the tolerance: P of G64, 0.002 mm in G61 and G61.1, and 0.05° of the
  rotary axes, which LinuxCNC does not have.

| program | P, mm | ours, s | LinuxCNC, s | ratio | ours v | a | d | LinuxCNC v | a | d |
|---|---|---|---|---|---|---|---|---|---|---|
";
