//! Programs through LinuxCNC's motion controller and through ours, on machines with the same limits, tolerances and servo period.
//!
//! The programs, the machine and LinuxCNC's display stand in `tests/peer/motion`. The sampler notes the joint positions of every servo
//! cycle, and the watchman judges both from these positions alone: velocity and acceleration of each joint, and the distance
//! from the programmed path. Time counts from the first cycle of motion to the last. LinuxCNC runs in real time, as an
//! ordinary user; ours runs on the virtual clock. No joint has a limit of jerk, because LinuxCNC 2.9 has none.
//!
//! Ours runs in each run of the tests, and its figures are those of `components/motion/motion/PEER.md`. Those of LinuxCNC come from
//! that page; `UPDATE_EXPECT=1 cargo test -p hal-tests --test system peer::motion -- --ignored` measures them again, which takes eight
//! minutes.
#![expect(clippy::unwrap_used, clippy::expect_used, clippy::panic, reason = "tests")]

mod path;

use hal_tests::{foreign, golden, programs::root, scratch::Scratch, tools};
use hal_watchman::{Limits, Watchman};
use path::Programmed;
use std::{fmt::Write, path::PathBuf, process::Command};

/// Number of joints: X Y Z A B.
pub(super) const JOINTS: usize = 5;
/// Servo period in seconds.
const PERIOD: f64 = 0.001;
/// Velocity and acceleration of each joint, as `machine.ini` has them.
const LIMITS: [(f64, f64); JOINTS] =
    [(120.0, 1000.0), (120.0, 1000.0), (60.0, 500.0), (90.0, 900.0), (90.0, 900.0)];
/// Samples are integers and six places, of a millionth of a unit.
const SCALE: f64 = 1e-6;
/// Part of a limit that the rounding of samples to 1e-12 units makes, at most.
const ROUNDING: f64 = 1e-7;
/// Largest distance of the last position from the end of the path, in mm and degrees.
const REST: f64 = 1e-5;

/// Program number and joint positions of a servo cycle.
pub(super) type Sample = (f64, [f64; JOINTS]);

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
        let last = samples.last().expect("samples");
        let apart = last.iter().zip(path.end).map(|(is, end)| (is - end).abs());
        assert!(
            apart.fold(0.0, f64::max) < REST,
            "the run ended at {last:?} before {:?}",
            path.end
        );
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
            seconds: seconds(samples),
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
pub(super) fn folder() -> PathBuf {
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
pub(super) fn samples(text: &str) -> Vec<Sample> {
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

/// Returns the overrides that the first line of a program names, as arguments of `motion.feed`.
fn overrides(program: &str) -> Option<String> {
    let named = program.lines().next()?.strip_prefix("(overrides: feed ")?.strip_suffix(')')?;
    let (feed, rapid) = named.split_once(", rapid ")?;
    Some(format!("override={feed} rapid-override={rapid}"))
}

/// Copies the folder of the programs; with `free`, their G64 is without P.
fn copied(free: bool) -> Scratch {
    let scratch = Scratch::copy_of(&folder());
    for name in names() {
        let name = format!("{name}.ngc");
        let text = scratch.read(&name);
        let mut out = String::new();
        for line in text.lines() {
            let words = line.split(' ').scan(false, |blends, word| {
                let is_tolerance = *blends && word.starts_with(['P', 'Q']);
                *blends |= word == "G64";
                Some((word, is_tolerance))
            });
            let kept: Vec<_> = words.filter(|(_, t)| !(free && *t)).map(|(word, _)| word).collect();
            out.push_str(&kept.join(" "));
            out.push('\n');
        }
        scratch.write(&name, out);
    }
    scratch
}

/// Lets the sampler keep whole programs: on the virtual clock the machine is ahead of the program that reads it.
pub(super) fn keep_all_samples(scratch: &Scratch) {
    let (few, many) = ("depth=16000 ", "depth=1000000 ");
    let machine = scratch.read("machine.hal");
    assert!(machine.contains(few));
    scratch.write("machine.hal", machine.replace(few, many));
}

/// Runs a program through ours, on the virtual clock; returns the joint positions and the programmed path.
fn run_ours(name: &str, free: bool) -> (Vec<[f64; JOINTS]>, Programmed) {
    let scratch = copied(free);
    keep_all_samples(&scratch);
    let ini = scratch.read("machine.ini");
    scratch.write("ours.ini", ini.replace(".hal\n", ".hal\nHALFILE = record.hal\n"));
    let program = format!("{name}.ngc");
    let feed = overrides(&scratch.read(&program)).map(|o| format!("motion.feed {o}\n"));
    let record = "loadusr -Wn halsampler0 halsampler samples\n".to_owned();
    scratch.write("record.hal", record + &feed.unwrap_or_default());
    let out = scratch.halrun(&["--virtual", "--headless", "--run", &program, "ours.ini"]);
    assert_eq!(out.status, Some(0), "{name}: {}{}", out.stdout, out.stderr);
    let positions = samples(&scratch.read("samples")).into_iter().map(|s| s.1).collect();
    (positions, Programmed::read(&folder(), &program))
}

/// Runs a program through ours.
fn ours(name: &str) -> Figures {
    let (positions, path) = run_ours(name, false);
    Figures::of(&positions, &path)
}

/// Returns the time from the first cycle of motion to the last, in seconds.
fn seconds(samples: &[[f64; JOINTS]]) -> f64 {
    let (first, last) = (samples.first().expect("samples"), samples.last().expect("samples"));
    let start = samples.iter().position(|s| s != first).expect("it moves");
    let end = samples.iter().rposition(|s| s != last).expect("it moves") + 1;
    (end + 1 - start) as f64 * PERIOD
}

/// Seconds of all programs without P through ours.
fn free_ours(names: &[String]) -> Vec<f64> {
    names.iter().map(|name| seconds(&run_ours(name, true).0)).collect()
}

/// Seconds of all programs without P through LinuxCNC; `None` without it.
fn free_theirs(names: &[String]) -> Option<Vec<f64>> {
    let programs: Vec<String> = names.iter().map(|n| format!("{n}.ngc")).collect();
    let (all, text) = run_theirs(&copied(true), &programs)?;
    let each = (1..=programs.len()).map(|number| {
        let of = all.iter().filter(|s| s.0 == number as f64).map(|s| s.1);
        let positions: Vec<_> = of.collect();
        assert!(!positions.is_empty(), "LinuxCNC did not run program {number}: {text}");
        seconds(&positions)
    });
    Some(each.collect())
}

/// Reads LinuxCNC's seconds without P from the page.
fn free_recorded(names: &[String]) -> Vec<f64> {
    let page = std::fs::read_to_string(root().join(FREE_PAGE)).unwrap();
    let one = |name: &String| {
        let row = page.lines().find(|l| l.starts_with(&format!("| {name} |")));
        let row = row.unwrap_or_else(|| panic!("{FREE_PAGE} has no row for {name}"));
        row.split('|').nth(3).unwrap().trim().parse().unwrap()
    };
    names.iter().map(one).collect()
}

/// Compares the page of programs without P with these figures, and the sums with each other.
fn check_free(names: &[String], ours: &[f64], theirs: &[f64]) {
    let mut table = String::from(FREE_HEAD);
    let mut total = [0.0; 2];
    for ((name, ours), theirs) in names.iter().zip(ours).zip(theirs) {
        let [a, b] = [ours, theirs].map(|f| (f * 1000.0).round() / 1000.0);
        total = [total[0] + a, total[1] + b];
        writeln!(table, "| {name} | {a:.3} | {b:.3} | {:.3} |", a / b).unwrap();
    }
    let [a, b] = total;
    writeln!(table, "\nAll {} programs: {a:.1} s ours, {b:.1} s LinuxCNC's.", names.len()).unwrap();
    golden::check(&root().join(FREE_PAGE), &table);
    assert!(a <= b, "{a} s, LinuxCNC {b} s");
}

#[test]
fn programs_without_a_tolerance_take_no_longer_than_linuxcnc() {
    let names = names();
    check_free(&names, &free_ours(&names), &free_recorded(&names));
}

#[test]
#[ignore = "eight minutes, and needs LinuxCNC; UPDATE_EXPECT=1 writes the page: cargo test -p hal-tests --test system peer::motion::all_free -- --ignored"]
fn all_free_programs_beside_linuxcnc() {
    let names = names();
    let Some(theirs) = free_theirs(&names) else { return };
    if golden::is_update() {
        check_free(&names, &free_ours(&names), &theirs);
    }
}

/// Runs the programs of a folder through LinuxCNC; returns the samples of all, and what it said; `None` without it.
pub(super) fn run_theirs(scratch: &Scratch, programs: &[String]) -> Option<(Vec<Sample>, String)> {
    let here = foreign::installed().filter(|_| PathBuf::from("/usr/bin/linuxcnc").is_file());
    tools::LINUXCNC.or_skip(here)?;
    let mut allow = Command::new("chmod");
    assert!(allow.args(["-R", "a+rwX,a+x"]).arg(scratch.path()).status().unwrap().success());
    let mut command = foreign::peer("/usr/bin/linuxcnc", scratch.path());
    command
        .arg("machine.ini")
        .env("PROGRAMS", programs.join(" "))
        .env("PATH", "/usr/bin:/bin:/usr/sbin:/sbin");
    let out = command.output().unwrap();
    let text = String::from_utf8_lossy(&out.stdout).into_owned();
    Some((samples(&scratch.read("samples")), text))
}

/// Runs programs through LinuxCNC; `None` without it.
fn theirs(names: &[String]) -> Option<Vec<Figures>> {
    let programs: Vec<String> = names.iter().map(|n| format!("{n}.ngc")).collect();
    let scratch = Scratch::copy_of(&folder());
    let (all, text) = run_theirs(&scratch, &programs)?;
    let figures = programs.iter().zip(1_u32..).map(|(program, number)| {
        let positions: Vec<_> =
            all.iter().filter(|s| s.0 == f64::from(number)).map(|s| s.1).collect();
        assert!(!positions.is_empty(), "LinuxCNC did not run {program}: {text}");
        Figures::of(&positions, &Programmed::read(scratch.path(), program))
    });
    Some(figures.collect())
}

/// Runs all programs through ours, and asserts that each keeps every limit and the tolerance.
fn all_ours(names: &[String]) -> Vec<Figures> {
    let one = |name: &String| {
        let figures = ours(name);
        assert!(figures.keeps_all(), "{name}: {figures:?}");
        figures
    };
    names.iter().map(one).collect()
}

/// Figures of LinuxCNC, which vary from run to run.
struct Theirs {
    figures: Vec<Figures>,
    /// Number of programs in which it kept limits and tolerance.
    kept: usize,
}

impl Theirs {
    /// Reads them from the page.
    fn recorded(names: &[String]) -> Self {
        let page = std::fs::read_to_string(root().join(PAGE)).unwrap();
        let figures = |name: &String| {
            let row = page.lines().find(|l| l.starts_with(&format!("| {name} |")));
            let row = row.unwrap_or_else(|| panic!("{PAGE} has no row for {name}: write it again"));
            let cell = |n| row.split('|').nth(n).unwrap().trim().parse().unwrap();
            let (seconds, velocity) = (cell(4), cell(9));
            Figures { seconds, velocity, acceleration: cell(10), distance: cell(11) }
        };
        let (_, after) = page.rsplit_once("tolerance in ").unwrap();
        let kept = after.split(' ').next().unwrap().parse().unwrap();
        Self { figures: names.iter().map(figures).collect(), kept }
    }
}

/// Compares the page with these figures; with `UPDATE_EXPECT=1` it writes the page.
fn check_page(names: &[String], ours: &[Figures], theirs: &Theirs) {
    let mut table = String::from(HEAD);
    // The sums are those of the figures as they are shown.
    let mut total = [0.0; 2];
    for ((name, ours), theirs) in names.iter().zip(ours).zip(&theirs.figures) {
        let seconds = [ours, theirs].map(|f| (f.seconds * 1000.0).round() / 1000.0);
        total = [total[0] + seconds[0], total[1] + seconds[1]];
        let tolerance = Programmed::read(&folder(), &format!("{name}.ngc")).tolerance;
        let [a, b] = seconds;
        write!(table, "| {name} | {tolerance} | {a:.3} | {b:.3} | {:.3} ", a / b).unwrap();
        for f in [ours, theirs] {
            write!(table, "| {:.3} | {:.3} | {:.3} ", f.velocity, f.acceleration, f.distance)
                .unwrap();
        }
        table.push_str("|\n");
    }
    writeln!(
        table,
        "\nAll {} programs: {:.1} s ours, {:.1} s LinuxCNC's, which kept limits and tolerance in {} of them.",
        names.len(),
        total[0],
        total[1],
        theirs.kept
    )
    .unwrap();
    golden::check(&root().join(PAGE), &table);
}

#[test]
fn ours_keeps_limits_and_tolerance_on_the_joint_pins_and_the_page_has_its_figures() {
    let names = names();
    check_page(&names, &all_ours(&names), &Theirs::recorded(&names));
}

#[test]
#[ignore = "eight minutes, and needs LinuxCNC; UPDATE_EXPECT=1 writes the page: cargo test -p hal-tests --test system peer::motion -- --ignored"]
fn all_programs_beside_linuxcnc() {
    let names = names();
    let Some(figures) = theirs(&names) else { return };
    let kept = figures.iter().filter(|f| f.keeps_all()).count();
    // LinuxCNC's figures vary from run to run, so that only a person can compare them.
    if golden::is_update() {
        check_page(&names, &all_ours(&names), &Theirs { figures, kept });
    }
}

/// The page.
const PAGE: &str = "components/motion/motion/PEER.md";
/// Beginning of the table.
const HEAD: &str = "\
# Ferrule's motion beside LinuxCNC's

`UPDATE_EXPECT=1 cargo test -p hal-tests --test system peer::motion -- --ignored` writes this page. It runs the programs of
`tests/peer/motion` through LinuxCNC 2.9, headless, and through Ferrule, on one machine: servo period 1 ms, X and Y 120 mm/s and
1000 mm/s², Z 60 and 500, A and B 90 °/s and 900 °/s², no limit of jerk. Both sets of figures come from the joint positions of every
servo cycle alone, judged by `hal-watchman`. Each run of the tests checks the figures of Ferrule.

- A program runs with the overrides of feeds and rapid moves that its first line names, or with 1.
- Seconds: from the first cycle of motion to the last. Ratio: ours to LinuxCNC's; below 1, ours is faster.
- v, a: the worst velocity and acceleration of a joint as a part of its limit.
- d: the largest distance from the programmed path as a part of the tolerance: P of G64, 0.002 mm in G61 and G61.1, and 0.05° of the
  rotary axes, which LinuxCNC does not have.

| program | P, mm | ours, s | LinuxCNC, s | ratio | ours v | a | d | LinuxCNC v | a | d |
|---|---|---|---|---|---|---|---|---|---|---|
";

/// The page of the programs without P.
const FREE_PAGE: &str = "components/motion/motion/PEER-FREE.md";
/// Beginning of its table.
const FREE_HEAD: &str = "\
# Programs on G64 without P, beside LinuxCNC's

`UPDATE_EXPECT=1 cargo test -p hal-tests --test system peer::motion::all_free -- --ignored` writes this page: the seconds of the
programs of [`PEER.md`](PEER.md) where their G64 has no P. LinuxCNC then rounds every corner as far as its feed asks, or to a quarter
of a segment; [`CORNERS.md`](CORNERS.md) has the deviations of both.

| program | ours, s | LinuxCNC, s | ratio |
|---|---|---|---|
";
