//! The machine that aligns itself: from the marks in pictures to the cut, beside the printed outline.
#![expect(clippy::indexing_slicing, reason = "tests")]

use hal_tests::{programs::root, scratch::Scratch, vcd::Vcd};

/// Largest distance of the cut from the print, in mm.
const BAR: f64 = 0.05;

type Point = [f64; 2];

/// Returns the place of a point of the drawing on the simulated table: turned by 10 degrees, scaled 1.2 and 1.1, and out
/// of square by 0.5 degrees, at (100, 50).
fn printed([x, y]: Point) -> Point {
    let (s, c) = 10_f64.to_radians().sin_cos();
    let upright = [1.2 * x + 1.1 * 0.5_f64.to_radians().tan() * y, 1.1 * y];
    [c * upright[0] - s * upright[1] + 100.0, s * upright[0] + c * upright[1] + 50.0]
}

/// Returns points of the printed outline and of the hole, at most 0.05 mm apart.
fn outline() -> Vec<Vec<Point>> {
    let line = |from: Point, to: Point| {
        (0..=2000).map(move |n| {
            let part = f64::from(n) / 2000.0;
            [from[0] + (to[0] - from[0]) * part, from[1] + (to[1] - from[1]) * part]
        })
    };
    let arc = |middle: Point, radius: f64, from: f64, to: f64| {
        (0..=4000).map(move |n| {
            let angle = (from + (to - from) * f64::from(n) / 4000.0).to_radians();
            [middle[0] + radius * angle.cos(), middle[1] + radius * angle.sin()]
        })
    };
    let edge = line([30.0, 30.0], [120.0, 30.0])
        .chain(arc([120.0, 60.0], 30.0, -90.0, 90.0))
        .chain(line([120.0, 90.0], [30.0, 90.0]))
        .chain(line([30.0, 90.0], [30.0, 30.0]));
    let hole = arc([55.0, 60.0], 15.0, 360.0, 0.0);
    vec![edge.map(printed).collect(), hole.map(printed).collect()]
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

/// Runs the machine; returns its output, and where the tool cut.
fn run() -> (String, Vec<Point>) {
    let scratch = Scratch::copy_of(&root().join("configs/fiducial"));
    let output = scratch.halrun(&["--virtual", "--record", "demo.vcd", "demo.ini"]);
    assert_eq!(output.status, Some(0), "{}{}", output.stdout, output.stderr);
    let vcd = Vcd::parse(&scratch.read("demo.vcd"));
    (output.stdout, cut(&vcd))
}

#[test]
fn a_turned_stretched_and_sheared_plate_is_cut_along_its_print() {
    let (said, cut) = run();
    assert!(said.contains("affine: turn 9.99999 deg"), "{said}");
    let outline: Vec<Point> = outline().into_iter().flatten().collect();
    // Points of both are at most 0.05 mm apart along the way, which adds less than 0.01 mm to a distance across it.
    let (beside, missing) = (farthest(&cut, &outline), farthest(&outline, &cut));
    assert!(cut.len() > 10_000, "{}", cut.len());
    assert!(beside < BAR && missing < BAR, "{beside} {missing}");
    // The same bytes again.
    assert_eq!(run(), (said, cut));
}
