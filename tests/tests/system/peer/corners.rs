//! Corners of every angle, feed and length, with lines and arcs, on G64 without P: how far ours and LinuxCNC miss each.
//!
//! The machine is that of `tests/peer/motion`, with 1500 mm/s² and 150 mm/s on X and Y. The joint positions of every servo
//! cycle are the only source of the figures. Ours runs in each run of the tests, with the figures of
//! `components/motion/motion/CORNERS.md`; LinuxCNC's are from that page.
#![expect(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    clippy::indexing_slicing,
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "tests"
)]

use super::motion::{JOINTS, folder, keep_all_samples, run_theirs, samples};
use hal_tests::{golden, programs::root, scratch::Scratch};
use std::fmt::Write;

/// Feeds, in mm/min, and the longest segment that each has, in mm: seconds of the real clock are dear.
const FEEDS: [(f64, f64); 5] =
    [(60.0, 2.0), (600.0, 10.0), (1500.0, 40.0), (3000.0, 100.0), (6000.0, 100.0)];
const LENGTHS: [f64; 5] = [0.5, 2.0, 10.0, 40.0, 100.0];
/// Segments before and after the corner, the angles, in degrees, and the longest segment.
const KINDS: [(&str, [Segment; 2], &[f64], f64); 4] = [
    ("line, line", [Segment::Line; 2], &[30.0, 60.0, 90.0, 120.0, 150.0, 170.0, 175.0], 100.0),
    ("line, arc", [Segment::Line, Segment::Arc], &[30.0, 90.0, 150.0, 175.0], 40.0),
    ("arc, line", [Segment::Arc, Segment::Line], &[30.0, 90.0, 150.0, 175.0], 40.0),
    ("arc, arc", [Segment::Arc; 2], &[30.0, 90.0, 150.0, 175.0], 40.0),
];

/// A segment beside a corner. An arc has a radius of its own length.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Segment {
    Line,
    Arc,
}

/// A corner at the origin.
#[derive(Clone, Copy, Debug)]
struct Corner {
    kind: usize,
    angle: f64,
    feed: f64,
    length: f64,
    /// Place of B, in tenths of a degree, that tells which corner it is.
    number: u32,
}

/// Returns all corners, in the order of the program.
fn corners() -> Vec<Corner> {
    let mut out = Vec::new();
    for (kind, (_, _, angles, most)) in KINDS.iter().enumerate() {
        for &angle in *angles {
            for (feed, longest) in FEEDS {
                for length in LENGTHS.into_iter().filter(|l| *l <= longest.min(*most)) {
                    let number = u32::try_from(out.len()).unwrap() + 1;
                    out.push(Corner { kind, angle, feed, length, number });
                }
            }
        }
    }
    out
}

fn turned([x, y]: [f64; 2], by: f64) -> [f64; 2] {
    let (sin, cos) = by.sin_cos();
    [x * cos - y * sin, x * sin + y * cos]
}

impl Corner {
    /// Returns true if LinuxCNC braked here because the next block came too late: neither feed nor length explain so small
    /// a deviation.
    fn is_late(&self, deviation: f64) -> bool {
        let feed = self.feed / 60.0;
        let cos = (0.5 * self.angle).to_radians().cos();
        let carried = (1.0 / cos - 1.0) * feed * feed / 1500.0;
        deviation < 0.0075 * self.length && deviation < 0.2 * carried
    }

    /// Returns the direction of the path before the corner: another one for each.
    fn heading(&self) -> f64 {
        (37.0 * f64::from(self.number)).to_radians()
    }

    /// Returns the start of the path and its two blocks.
    fn blocks(&self) -> ([f64; 2], [String; 2]) {
        let [first, second] = KINDS[self.kind].1;
        let (r, before) = (self.length, self.heading());
        let after = before + self.angle.to_radians();
        // Each sense of the arcs, in turn.
        let [s, t] = [self.number.is_multiple_of(2), self.number % 4 < 2]
            .map(|b| if b { 1.0 } else { -1.0 });
        let word = |sense: f64| if sense > 0.0 { "G3" } else { "G2" };
        let direction = |a: f64| [a.cos(), a.sin()];
        // The centre is at the left of the motion where the arc turns to the left.
        let side =
            |a: f64, sense: f64| turned(direction(a), sense * 90_f64.to_radians()).map(|x| x * r);
        let (start, one) = match first {
            Segment::Line => (direction(before).map(|x| -x * r), "G1 X0 Y0".to_owned()),
            Segment::Arc => {
                let c = side(before, s);
                let [x, y] = turned(c.map(|x| -x), -s);
                let start = [c[0] + x, c[1] + y];
                let [i, j] = [c[0] - start[0], c[1] - start[1]];
                (start, format!("{} X0 Y0 I{i:.9} J{j:.9}", word(s)))
            }
        };
        let two = match second {
            Segment::Line => {
                let [x, y] = direction(after).map(|x| x * r);
                format!("G1 X{x:.9} Y{y:.9}")
            }
            Segment::Arc => {
                let c = side(after, t);
                let [x, y] = turned(c.map(|x| -x), t);
                let [x, y] = [c[0] + x, c[1] + y];
                format!("{} X{x:.9} Y{y:.9} I{:.9} J{:.9}", word(t), c[0], c[1])
            }
        };
        (start, [one, two])
    }
}

/// Returns the programs, one for each kind: LinuxCNC waits five minutes for the end of one.
fn programs() -> Vec<String> {
    let mut out = vec![String::from("G21 G90 G17 G54 G64 F6000\nG0 X0 Y0 B0\n"); KINDS.len()];
    for corner in corners() {
        let ([x, y], [one, two]) = corner.blocks();
        // A dwell keeps the blocks between corners out of the path.
        write!(
            out[corner.kind],
            "G0 X{x:.9} Y{y:.9}\nG0 B{:.1}\nG4 P0.05\n{one} F{}\n{two}\nG4 P0.05\n",
            0.1 * f64::from(corner.number),
            corner.feed,
        )
        .unwrap();
    }
    out.iter().map(|text| format!("{text}M2\n")).collect()
}

/// Distance of each corner from the path between the samples, in mm.
fn missed(samples: &[[f64; JOINTS]]) -> Vec<Option<f64>> {
    let mut near: Vec<Option<f64>> = vec![None; corners().len()];
    let mut last: Option<[f64; JOINTS]> = None;
    let mut begun = 0;
    for sample in samples {
        let tenths = 10.0 * sample[4];
        let number = tenths.round() as usize;
        let corner = number.checked_sub(1).and_then(|n| corners_of().get(n));
        if let (Some(corner), Some(before)) = (corner, last)
            && (tenths - tenths.round()).abs() < 1e-6
            && (before[4] - sample[4]).abs() < 1e-9
        {
            // From the start of the path on.
            let (start, _) = corner.blocks();
            if (sample[0] - start[0]).hypot(sample[1] - start[1]) < 1e-6 {
                begun = number;
            } else if begun == number {
                let distance = to_origin([before[0], before[1]], [sample[0], sample[1]]);
                let slot = &mut near[number - 1];
                *slot = Some(slot.map_or(distance, |d| d.min(distance)));
            }
        }
        last = Some(*sample);
    }
    near
}

fn corners_of() -> &'static [Corner] {
    static ALL: std::sync::OnceLock<Vec<Corner>> = std::sync::OnceLock::new();
    ALL.get_or_init(corners)
}

/// Returns the distance of the origin from the line between two points.
fn to_origin(a: [f64; 2], b: [f64; 2]) -> f64 {
    let by = [b[0] - a[0], b[1] - a[1]];
    let square = by[0] * by[0] + by[1] * by[1];
    let share = -(a[0] * by[0] + a[1] * by[1]) / square;
    let share = if share > 0.0 { share.min(1.0) } else { 0.0 };
    (a[0] + share * by[0]).hypot(a[1] + share * by[1])
}

/// Returns the folder with the machine and the programs.
fn set_up() -> (Scratch, Vec<String>) {
    let scratch = Scratch::copy_of(&folder());
    let ini = scratch.read("machine.ini");
    let ini = ini
        .replace("MAX_VELOCITY = 120\n", "MAX_VELOCITY = 150\n")
        .replace("MAX_ACCELERATION = 1000\n", "MAX_ACCELERATION = 1500\n");
    scratch.write("machine.ini", ini);
    let mut names = Vec::new();
    for (text, n) in programs().into_iter().zip(0..) {
        let name = format!("corners-{n}.ngc");
        scratch.write(&name, text);
        names.push(name);
    }
    (scratch, names)
}

/// Runs the corners through ours, with a limit of jerk or without one.
fn ours(jerk: Option<f64>) -> Vec<f64> {
    let (scratch, names) = set_up();
    keep_all_samples(&scratch);
    let mut ini = scratch.read("machine.ini").replace(".hal\n", ".hal\nHALFILE = record.hal\n");
    if let Some(jerk) = jerk {
        ini = ini.replace(
            "MAX_ACCELERATION = 1500\n",
            &format!("MAX_ACCELERATION = 1500\nMAX_JERK = {jerk}\n"),
        );
    }
    scratch.write("ours.ini", ini);
    scratch.write("record.hal", "loadusr -Wn halsampler0 halsampler samples\n");
    let mut all = vec![None; corners().len()];
    for name in names {
        let out = scratch.halrun(&["--virtual", "--headless", "--run", &name, "ours.ini"]);
        assert_eq!(out.status, Some(0), "{name}: {}{}", out.stdout, out.stderr);
        let positions: Vec<_> =
            samples(&scratch.read("samples")).into_iter().map(|s| s.1).collect();
        for (slot, found) in all.iter_mut().zip(missed(&positions)) {
            *slot = slot.or(found);
        }
    }
    all.into_iter().map(|found| found.expect("each corner is passed")).collect()
}

/// Runs the corners through LinuxCNC; `None` without it.
fn theirs() -> Option<Vec<f64>> {
    let (scratch, names) = set_up();
    let (samples, text) = run_theirs(&scratch, &names)?;
    let mut all = vec![None; corners().len()];
    for number in 1..=names.len() {
        let positions: Vec<_> =
            samples.iter().filter(|s| s.0 == number as f64).map(|s| s.1).collect();
        for (slot, found) in all.iter_mut().zip(missed(&positions)) {
            *slot = slot.or(found);
        }
    }
    Some(
        all.into_iter()
            .map(|found| found.unwrap_or_else(|| panic!("not passed: {text}")))
            .collect(),
    )
}

/// Reads LinuxCNC's figures from the page.
fn recorded() -> Vec<f64> {
    let page = std::fs::read_to_string(root().join(PAGE)).unwrap();
    let rows = page.lines().skip_while(|l| !l.starts_with("|---"));
    let cells = rows
        .skip(1)
        .filter(|l| l.starts_with('|'))
        .map(|row| row.split('|').nth(6).unwrap().trim().parse().unwrap_or(f64::NAN));
    let all: Vec<f64> = cells.collect();
    assert_eq!(all.len(), corners().len(), "{PAGE}: write it again");
    all
}

/// Compares the page with these figures; with `UPDATE_EXPECT=1` it writes the page.
fn check_page(ours: &[f64], jerk: &[f64], theirs: &[f64]) {
    let mut table = String::from(HEAD);
    for (((corner, ours), jerk), theirs) in corners().iter().zip(ours).zip(jerk).zip(theirs) {
        let name = KINDS[corner.kind].0;
        let Corner { angle, feed, length, .. } = corner;
        let theirs = if corner.is_late(*theirs) || theirs.is_nan() {
            "stop".to_owned()
        } else {
            format!("{theirs:.5}")
        };
        writeln!(
            table,
            "| {name} | {angle}° | F{feed} | {length} | {ours:.5} | {theirs} | {jerk:.5} |"
        )
        .unwrap();
    }
    golden::check(&root().join(PAGE), &table);
}

/// No corner is missed by more than LinuxCNC misses it, with a limit of jerk and without one.
#[test]
fn no_corner_is_missed_by_more_than_linuxcnc_misses_it() {
    let (plain, jerk, theirs) = (ours(None), ours(Some(JERK)), recorded());
    let mut worse = Vec::new();
    for (((corner, plain), jerk), theirs) in corners().iter().zip(&plain).zip(&jerk).zip(&theirs) {
        // LinuxCNC stops at a corner where the next block came too late.
        if corner.is_late(*theirs) || theirs.is_nan() {
            continue;
        }
        for (ours, with) in [(plain, ""), (jerk, " with jerk")] {
            if theirs + ROUNDING < *ours {
                worse.push(format!("{corner:?}: {ours}{with}, LinuxCNC {theirs}"));
            }
        }
    }
    check_page(&plain, &jerk, &theirs);
    assert!(worse.is_empty(), "{}", worse.join("\n"));
}

#[test]
#[ignore = "eight minutes, and needs LinuxCNC; UPDATE_EXPECT=1 writes the page: cargo test -p hal-tests --test system peer::corners -- --ignored"]
fn all_corners_beside_linuxcnc() {
    let Some(theirs) = theirs() else { return };
    // LinuxCNC's figures vary from run to run, so that only a person can compare them.
    if golden::is_update() {
        check_page(&ours(None), &ours(Some(JERK)), &theirs);
    }
}

/// Limit of jerk of X and Y in the second set of figures, in mm/s³.
const JERK: f64 = 1e5;
/// The last place of the figures, in mm.
const ROUNDING: f64 = 1e-5;

/// The page.
const PAGE: &str = "components/motion/motion/CORNERS.md";
/// Beginning of the table.
const HEAD: &str = "\
# Corners on G64 without P, beside LinuxCNC's

`UPDATE_EXPECT=1 cargo test -p hal-tests --test system peer::corners -- --ignored` writes this page: how far, in mm, the motion
misses the corner between two segments of the same length that start and end at rest. X and Y have 150 mm/s and 1500 mm/s², the servo
period is 1 ms. An arc has a radius of its own length; the arcs turn to either side in turn. The last column is ours with a limit of
jerk of 1e5 mm/s³, which LinuxCNC 2.9 does not have. LinuxCNC stops at a corner where the next block comes too late.

| segments | angle | feed, mm/min | length, mm | ours | LinuxCNC | ours, with jerk |
|---|---|---|---|---|---|---|
";
