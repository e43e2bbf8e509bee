//! The machine that aligns itself: from the marks in pictures to the cut, beside the printed outline.
#![expect(clippy::indexing_slicing, clippy::unwrap_used, reason = "tests")]

use hal_tests::{programs::root, scratch::Scratch, vcd::Vcd};

type Point = [f64; 2];

/// Place of a plate on the simulated table: turn, scales of X and Y, squareness, shift.
#[derive(Clone, Copy)]
struct Plate {
    turn: f64,
    scales: Point,
    shear: f64,
    shift: Point,
}

/// The plate of the demonstration.
const STRETCHED: Plate = Plate { turn: 10.0, scales: [1.2, 1.1], shear: 0.5, shift: [100.0, 50.0] };
/// A plate as it comes from a printer, somewhere on the table.
const USUAL: Plate = Plate { turn: 7.0, scales: [1.002, 0.998], shear: 0.1, shift: [13.0, -8.0] };

impl Plate {
    /// Returns the place of a point of the drawing on the table.
    fn printed(self, [x, y]: Point) -> Point {
        let (s, c) = self.turn.to_radians().sin_cos();
        let [sx, sy] = self.scales;
        let upright = [sx * x + sy * self.shear.to_radians().tan() * y, sy * y];
        [
            c * upright[0] - s * upright[1] + self.shift[0],
            s * upright[0] + c * upright[1] + self.shift[1],
        ]
    }
}

/// Returns points of the printed outline and of the hole, at most 0.015 mm apart.
fn outline(plate: Plate) -> Vec<Point> {
    let line = |from: Point, to: Point| {
        (0..=8000).map(move |n| {
            let part = f64::from(n) / 8000.0;
            [from[0] + (to[0] - from[0]) * part, from[1] + (to[1] - from[1]) * part]
        })
    };
    let arc = |middle: Point, radius: f64, from: f64, to: f64| {
        (0..=12_000).map(move |n| {
            let angle = (from + (to - from) * f64::from(n) / 12_000.0).to_radians();
            [middle[0] + radius * angle.cos(), middle[1] + radius * angle.sin()]
        })
    };
    let edge = line([30.0, 30.0], [120.0, 30.0])
        .chain(arc([120.0, 60.0], 30.0, -90.0, 90.0))
        .chain(line([120.0, 90.0], [30.0, 90.0]))
        .chain(line([30.0, 90.0], [30.0, 30.0]));
    let hole = arc([55.0, 60.0], 15.0, 360.0, 0.0);
    edge.chain(hole).map(|p| plate.printed(p)).collect()
}

fn distance(a: Point, b: Point) -> f64 {
    (a[0] - b[0]).hypot(a[1] - b[1])
}

/// Returns the positions of the tool in the material, cycle by cycle.
fn cut(vcd: &Vcd) -> Vec<Point> {
    let ends = ["x", "y", "z"].map(|name| vcd.of(name));
    let times = ends.iter().flat_map(|changes| changes.iter().map(|c| c.0));
    let mut times: Vec<i64> = times.collect();
    times.sort_unstable();
    times.dedup();
    let mut next = [0; 3];
    let mut at = [0.0; 3];
    let mut out = Vec::new();
    for time in times {
        for n in 0..3 {
            while let Some((t, value)) = ends[n].get(next[n]).filter(|c| c.0 <= time) {
                debug_assert!(*t <= time);
                (at[n], next[n]) = (*value, next[n] + 1);
            }
        }
        if at[2] < -0.999 {
            out.push([at[0], at[1]]);
        }
    }
    out
}

/// Returns the largest distance of a point of `these` from the nearest of `those`, which are sorted into squares.
fn farthest(these: &[Point], those: &[Point]) -> f64 {
    use std::collections::BTreeMap;
    #[expect(clippy::cast_possible_truncation, reason = "millimetres of a machine")]
    let square = |p: Point| (p[0].floor() as i32, p[1].floor() as i32);
    let mut squares: BTreeMap<(i32, i32), Vec<Point>> = BTreeMap::new();
    for p in those {
        squares.entry(square(*p)).or_default().push(*p);
    }
    let nearest = |p: Point| {
        let (x, y) = square(p);
        let near = (-1..=1).flat_map(|dx| (-1..=1).map(move |dy| (x + dx, y + dy)));
        let near = near.filter_map(|key| squares.get(&key)).flatten();
        near.map(|q| distance(p, *q)).fold(f64::INFINITY, f64::min)
    };
    these.iter().map(|p| nearest(*p)).fold(0.0, f64::max)
}

/// Runs the machine with a plate; returns its output, where the tool cut, and the marks that were found.
fn run(plate: Plate) -> (String, Vec<Point>, String) {
    let scratch = Scratch::copy_of(&root().join("configs/fiducial"));
    place(&scratch, plate);
    let output = scratch.halrun(&["--virtual", "--record", "demo.vcd", "demo.ini"]);
    assert_eq!(output.status, Some(0), "{}{}", output.stdout, output.stderr);
    let vcd = Vcd::parse(&scratch.read("demo.vcd"));
    (output.stdout, cut(&vcd), scratch.read("found.ini"))
}

/// Puts a plate on the simulated table, and tells the job roughly where its marks are.
fn place(scratch: &Scratch, plate: Plate) {
    let table = scratch.read("table.conf");
    let Plate { turn, scales: [sx, sy], shear, shift: [x, y] } = plate;
    let part = format!("PART = {turn} {sx} {sy} {shear} {x} {y}");
    let lines = table.lines().map(|l| if l.starts_with("PART") { part.as_str() } else { l });
    scratch.write("table.conf", lines.collect::<Vec<_>>().join("\n"));
    let job = scratch.read("plate.conf");
    let lines = job.lines().map(|l| match l.strip_prefix("MARK = ") {
        None => match l.strip_prefix("SIZE = ") {
            None => l.to_owned(),
            Some(_) => format!("SIZE = {}", 4.0 * (sx * sy).sqrt()),
        },
        Some(numbers) => {
            let at: Vec<f64> = numbers.split(' ').take(2).map(|n| n.parse().unwrap()).collect();
            let [x, y] = plate.printed([at[0], at[1]]);
            format!("MARK = {} {} {:.0} {:.0}", at[0], at[1], x, y)
        }
    });
    scratch.write("plate.conf", lines.collect::<Vec<_>>().join("\n"));
}

/// Checks a run: its cut lies within `bar` of the print, each mark within `mark` of its true place, and a second run has the
/// same bytes.
fn check(plate: Plate, bar: f64, mark: f64) -> String {
    let (said, cut, found) = run(plate);
    let outline = outline(plate);
    let (beside, missing) = (farthest(&cut, &outline), farthest(&outline, &cut));
    assert!(cut.len() > 10_000, "{}", cut.len());
    assert!(beside < bar && missing < bar, "{beside} {missing}");
    let marks = found.lines().filter_map(|l| l.strip_prefix("MARK = "));
    let off = marks.map(|numbers| {
        let n: Vec<f64> = numbers.split(' ').map(|n| n.parse().unwrap()).collect();
        distance([n[2], n[3]], plate.printed([n[0], n[1]]))
    });
    let off: Vec<f64> = off.collect();
    assert!(off.len() == 4 && off.iter().all(|by| *by < mark), "{off:?}");
    assert_eq!(run(plate), (said.clone(), cut, found), "the same bytes again");
    said
}

#[test]
fn a_turned_stretched_and_sheared_plate_is_cut_along_its_print() {
    let said = check(STRETCHED, 0.05, 0.005);
    assert!(said.contains("affine: turn "), "{said}");
}

/// Marks 180 mm apart, and 206 mm across, on a plate as it is printed: the whole loop is within 0.005 mm and 0.005 degrees, the cut within 0.03 mm.
#[test]
fn the_whole_loop_is_within_its_bars() {
    let said = check(USUAL, 0.03, 0.005);
    // affine: turn 7.00 deg, scale X 1.002, scale Y 0.998, squareness 0.1 deg, shift X 13 Y -8 mm
    let line = said.lines().find(|l| l.starts_with("affine: ")).unwrap();
    let numbers: Vec<f64> = line.split([' ', ',']).filter_map(|w| w.parse().ok()).collect();
    let [turn, sx, sy, shear, x, y, ..] = numbers[..] else { panic!("{line}") };
    let Plate { turn: true_turn, scales, shear: true_shear, shift } = USUAL;
    assert!((turn - true_turn).abs() < 0.005 && (shear - true_shear).abs() < 0.005, "{line}");
    // Far from the origin a scale counts 200 mm.
    let far = |got: f64, wanted: f64| (got - wanted).abs() * 200.0;
    assert!(far(sx, scales[0]) < 0.005 && far(sy, scales[1]) < 0.005, "{line}");
    assert!((x - shift[0]).abs() < 0.005 && (y - shift[1]).abs() < 0.005, "{line}");
}
