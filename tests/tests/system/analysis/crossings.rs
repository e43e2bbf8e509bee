//! Criterion for the layout of pictures: its wires cross at most as often as Graphviz's, on every machine in `configs/`.
//!
//! Graphviz draws the same boxes from `halcmd graph --dot`. Where its pictures become better, ours are not needed.
#![expect(
    clippy::unwrap_used,
    clippy::print_stdout,
    clippy::indexing_slicing,
    reason = "tests; the figures are the result"
)]

use hal_tests::{programs::root, scratch::Scratch, tools::Tool};
use serde_json::Value;
use std::{
    collections::BTreeMap,
    fs,
    io::Write,
    path::{Path, PathBuf},
    process::{Command, Stdio},
};

type Point = (f64, f64);
/// Straight parts of the wires of each signal.
type Wires = BTreeMap<String, Vec<(Point, Point)>>;

#[test]
fn wires_cross_no_more_often_than_graphvizs() {
    let found = Command::new("dot").arg("-V").output().ok();
    if Tool::of("dot").or_skip(found).is_none() {
        return;
    }
    let (mut sum, mut sum_graphviz, mut machines) = (0, 0, 0);
    for path in machines_in(&root().join("configs")) {
        let folder = path.parent().unwrap();
        let scratch = Scratch::copy_of(folder);
        let file = path.file_name().unwrap().to_str().unwrap();
        let drawn = |format: &str| scratch.halcmd(&["graph", format, file]).stdout;
        let ours = of_svg(&drawn("--svg"));
        let graphviz = of_graphviz(&drawn("--dot"));
        // Parts that a script shares with others may draw nothing by themselves.
        if ours.len() < 5 {
            continue;
        }
        let missing: Vec<_> = graphviz.keys().filter(|k| !ours.contains_key(*k)).collect();
        assert!(missing.is_empty(), "{file}: no wire for {missing:?}");
        let (a, b) = (crossings(&ours), crossings(&graphviz));
        println!("{file:20} {:3} signals, {a:4} crossings, Graphviz {b:4}", ours.len());
        assert!(a <= b, "{file}: {a} crossings, Graphviz has {b}");
        sum += a;
        sum_graphviz += b;
        machines += 1;
    }
    println!("{machines} machines, {sum} crossings, Graphviz {sum_graphviz}");
    assert!(machines > 10, "only {machines} machines");
    assert!(sum * 3 < sum_graphviz * 2, "{sum} crossings, Graphviz {sum_graphviz}");
}

/// Returns the scripts and INI files of the machines.
fn machines_in(configs: &Path) -> Vec<PathBuf> {
    let files = |folder: &Path| -> Vec<PathBuf> {
        fs::read_dir(folder).unwrap().map(|e| e.unwrap().path()).collect()
    };
    let mut all: Vec<_> =
        files(configs).iter().filter(|p| p.is_dir()).flat_map(|p| files(p)).collect();
    all.retain(|p| p.extension().is_some_and(|e| e == "hal" || e == "ini"));
    all.sort();
    all
}

/// Reads the wires of our picture: groups with the signal's name and type, and a path of `MX YLX Y` parts.
fn of_svg(svg: &str) -> Wires {
    let mut wires = Wires::new();
    for line in svg.lines().filter(|l| l.contains("class=\"wire\"")) {
        let (_, rest) = line.split_once("<g><title>").unwrap();
        let (title, rest) = rest.split_once("</title>").unwrap();
        let (_, rest) = rest.split_once(" d=\"").unwrap();
        let (path, _) = rest.split_once('"').unwrap();
        let (name, _) = title.split_once(" (").unwrap();
        let parts = path.split('M').filter(|p| !p.is_empty()).map(|part| {
            let (from, to) = part.split_once('L').unwrap();
            (point(from, ' '), point(to, ' '))
        });
        wires.entry(name.to_owned()).or_default().extend(parts);
    }
    wires
}

/// Returns the wires as Graphviz lays them out: the splines of its edges, each cubic in eight straight parts.
fn of_graphviz(dot: &str) -> Wires {
    let mut child = Command::new("dot")
        .arg("-Tjson")
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .spawn()
        .unwrap();
    child.stdin.take().unwrap().write_all(dot.as_bytes()).unwrap();
    let output = child.wait_with_output().unwrap();
    assert!(output.status.success(), "dot refuses our graph");
    let json: Value = serde_json::from_slice(&output.stdout).unwrap();
    let mut wires = Wires::new();
    for edge in json["edges"].as_array().into_iter().flatten() {
        let name = edge["label"].as_str().unwrap().to_owned();
        // "e,X,Y" at the beginning is the arrow's tip.
        let points: Vec<Point> = edge["pos"]
            .as_str()
            .unwrap()
            .split(' ')
            .filter(|p| !p.starts_with(['e', 's']))
            .map(|p| point(p, ','))
            .collect();
        let line: Vec<Point> = points.windows(4).step_by(3).flat_map(cubic).collect();
        wires.entry(name).or_default().extend(line.windows(2).map(|w| (w[0], w[1])));
    }
    wires
}

/// Returns nine points of a cubic Bézier curve.
fn cubic(p: &[Point]) -> Vec<Point> {
    let at = |t: f64, of: fn(&Point) -> f64| {
        let u = 1.0 - t;
        u * u * u * of(&p[0])
            + 3.0 * u * u * t * of(&p[1])
            + 3.0 * u * t * t * of(&p[2])
            + t * t * t * of(&p[3])
    };
    (0..=8).map(|n| f64::from(n) / 8.0).map(|t| (at(t, |p| p.0), at(t, |p| p.1))).collect()
}

fn point(text: &str, between: char) -> Point {
    let (x, y) = text.split_once(between).unwrap();
    (x.parse().unwrap(), y.parse().unwrap())
}

/// Counts the places where wires of different signals cross.
fn crossings(wires: &Wires) -> usize {
    let all: Vec<_> = wires.values().collect();
    let pairs = all.iter().enumerate().flat_map(|(n, a)| all[n + 1..].iter().map(move |b| (a, b)));
    pairs
        .map(|(a, b)| a.iter().map(|a| b.iter().filter(|b| cross(a, b)).count()).sum::<usize>())
        .sum()
}

/// Returns whether two straight parts cross inside both.
fn cross(&(a, b): &(Point, Point), &(c, d): &(Point, Point)) -> bool {
    let side = |p: Point, q: Point, r: Point| (q.0 - p.0) * (r.1 - p.1) - (q.1 - p.1) * (r.0 - p.0);
    side(a, b, c) * side(a, b, d) < 0.0 && side(c, d, a) * side(c, d, b) < 0.0
}
