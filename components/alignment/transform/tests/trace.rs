//! Programs before and after, run by the interpreter and compared point by point.
#![expect(
    clippy::unwrap_used,
    clippy::panic,
    clippy::indexing_slicing,
    clippy::print_stdout,
    reason = "tests; figures are shown"
)]

use hal_align::{
    Matrix, Parts, Transform, Vector,
    rewrite::{Rules, rewrite},
};
use hal_gcode::{
    Answer, Call, Environment, Interpreter, Numbered, Request, Settings, Step, Text,
    axis::Position,
    canon::{Frame, Plane, Unit},
    tool::Tool,
};
use std::{fs, path::Path, sync::Arc};

/// Digits that the result leaves out, in millimetres.
const DIGITS: f64 = 4e-4;

struct World;

impl Environment for World {
    fn open(&self, _: &str) -> Option<Text> {
        None
    }

    fn tool(&self, number: i32) -> Option<Tool> {
        (number < 10).then(|| Tool { number, pocket: number, diameter: 2.0, ..Tool::default() })
    }
}

type Point = [f64; 3];

/// Move in machine coordinates.
#[derive(Clone, Debug)]
struct Move {
    line: u32,
    is_rapid: bool,
    from: Point,
    to: Point,
    /// Axes, centre and turns of an arc.
    arc: Option<([usize; 3], [f64; 2], i32)>,
}

impl Move {
    fn at(&self, part: f64) -> Point {
        let mut out = [0.0; 3];
        for (n, to) in out.iter_mut().enumerate() {
            *to = self.from[n] + (self.to[n] - self.from[n]) * part;
        }
        let Some(([a, b, _], centre, turns)) = self.arc else { return out };
        let s = Vector::new(self.from[a] - centre[0], self.from[b] - centre[1]);
        let e = Vector::new(self.to[a] - centre[0], self.to[b] - centre[1]);
        let left = turns > 0;
        let turn = s.cross(e).atan2(s.dot(e)) * if left { 1.0 } else { -1.0 };
        let turn = if turn <= 1e-9 { turn + std::f64::consts::TAU } else { turn };
        let turn = turn + f64::from(turns.abs() - 1) * std::f64::consts::TAU;
        let angle = s.y.atan2(s.x) + if left { turn } else { -turn } * part;
        let radius = s.length() + (e.length() - s.length()) * part;
        out[a] = centre[0] + radius * angle.cos();
        out[b] = centre[1] + radius * angle.sin();
        out
    }
}

impl Move {
    /// Returns whether a place of the result is on the circle of this arc.
    fn is_on(&self, transform: &Transform, to: Point) -> bool {
        let Some(([a, b, _], centre, _)) = self.arc else { return false };
        let back = mapped(&transform.inverse().unwrap(), to);
        let radius = (self.from[a] - centre[0]).hypot(self.from[b] - centre[1]);
        ((back[a] - centre[0]).hypot(back[b] - centre[1]) - radius).abs() < 0.02
    }
}

/// Runs a program from a place in X and Y. Returns `None` if it is wrong.
fn trace(text: &[u8], start: Vector) -> Option<Vec<Move>> {
    let mut it = Interpreter::new(Settings::default(), Numbered::default());
    it.synchronise(Position { x: start.x, y: start.y, ..Position::default() });
    it.load("part.ngc", Arc::new(text.to_vec()));
    let mut calls = Vec::new();
    let mut step = it.next(&World, &mut calls);
    for _ in 0..100_000 {
        step = match step.ok()? {
            Step::Line => it.next(&World, &mut calls),
            Step::Ask(Request::ToolChange { .. }) => it.answer(&Answer::Done, &World, &mut calls),
            Step::Ask(_) => return None,
            Step::Ended => return Some(moves(&calls, start)),
        };
    }
    None
}

fn moves(calls: &[hal_gcode::Issued], start: Vector) -> Vec<Move> {
    let mut frame = Frame::new(Unit::Millimetre);
    let mut from = [start.x, start.y, 0.0];
    let mut out = Vec::new();
    for issued in calls {
        let line = issued.line;
        let (end, is_rapid) = match &issued.call {
            Call::StraightTraverse(end) => (end, true),
            Call::StraightFeed(end)
            | Call::StraightProbe { end, .. }
            | Call::ArcFeed { end, .. } => (end, false),
            other => {
                frame.apply(other);
                continue;
            }
        };
        let at = frame.machine_mm(*end);
        let to = [at.x, at.y, at.z];
        let arc = match &issued.call {
            Call::ArcFeed { plane, centre_first, centre_second, turns, .. } => {
                let unit = frame.unit.millimetres();
                let axes = match plane {
                    Plane::Xz => [2, 0, 1],
                    Plane::Yz => [1, 2, 0],
                    _ => [0, 1, 2],
                };
                Some((axes, [centre_first * unit, centre_second * unit], *turns))
            }
            _ => None,
        };
        if distance(from, to) > 1e-9 || arc.is_some() {
            out.push(Move { line, is_rapid, from, to, arc });
        }
        from = to;
    }
    out
}

fn mapped(transform: &Transform, p: Point) -> Point {
    let to = transform.apply(Vector::new(p[0], p[1]));
    [to.x, to.y, p[2]]
}

fn distance(a: Point, b: Point) -> f64 {
    (0..3).map(|n| (a[n] - b[n]) * (a[n] - b[n])).sum::<f64>().sqrt()
}

/// Returns the distance of a point from a line between two points.
fn off_line(p: Point, a: Point, b: Point) -> f64 {
    let length = (0..3).map(|n| (b[n] - a[n]) * (b[n] - a[n])).sum::<f64>();
    let part = (0..3).map(|n| (p[n] - a[n]) * (b[n] - a[n])).sum::<f64>() / length.max(1e-30);
    let part = if part > 0.0 { part.min(1.0) } else { 0.0 };
    distance(p, [0, 1, 2].map(|n| a[n] + (b[n] - a[n]) * part))
}

/// Compares the moves of a program with those of the result; returns the number of moves.
fn compare(name: &str, text: &str, result: &str, transform: &Transform) -> usize {
    let Some(before) = trace(text.as_bytes(), Vector::ZERO) else { return 0 };
    let fail = |what: String| -> ! { panic!("{name}: {what}\n{text}--- after\n{result}") };
    let Some(after) = trace(result.as_bytes(), transform.shift) else {
        fail("does not run".to_owned())
    };
    let tolerance = Rules::default().tolerance;
    let mut rest = after.as_slice();
    for old in &before {
        let to = mapped(transform, old.to);
        // A half circle by its radius depends on its last digit as much in the source.
        let radius =
            if old.arc.is_some() && text.to_uppercase().contains('R') { 0.03 } else { 0.0 };
        let allowed = radius + DIGITS + if old.arc.is_some() { tolerance } else { 0.0 };
        let reaches = |m: &Move| distance(m.to, to) < DIGITS * 1.5;
        let Some((first, _)) = rest.split_first() else {
            // A move that rounding has made a standstill.
            if distance(mapped(transform, old.from), to) < DIGITS {
                continue;
            }
            fail(format!("line {}: no move to {to:?}", old.line))
        };
        let is_chords = old.arc.is_some() && first.arc.is_none();
        // Two turns come to their end twice: the lines go on while they are on the curve.
        let on_curve = rest.iter().take_while(|m| m.arc.is_none() && old.is_on(transform, m.to));
        let count = if is_chords {
            let turns = old.arc.map_or(1, |(_, _, turns)| turns.unsigned_abs()) as usize;
            on_curve.enumerate().filter(|(_, m)| reaches(m)).take(turns).last().map(|(n, _)| n + 1)
        } else {
            reaches(first).then_some(1)
        };
        let Some(count) = count else {
            if distance(mapped(transform, old.from), to) < DIGITS {
                continue;
            }
            fail(format!("line {}: {first:?} does not reach {to:?}", old.line))
        };
        let (new, behind) = rest.split_at(count);
        rest = behind;
        if new.iter().any(|m| m.is_rapid != old.is_rapid) {
            fail(format!("line {}: rapid and feed", old.line));
        }
        for k in 0..=40 {
            let wanted = mapped(transform, old.at(f64::from(k) / 40.0));
            let off = if is_chords {
                new.iter().map(|m| off_line(wanted, m.from, m.to)).fold(f64::INFINITY, f64::min)
            } else {
                distance(wanted, new[0].at(f64::from(k) / 40.0))
            };
            if off > allowed {
                fail(format!(
                    "line {}: {off:.5} mm off at {k}/40 {old:?} {} {:?}",
                    old.line,
                    new.len(),
                    new[0]
                ));
            }
        }
    }
    if !rest.is_empty() {
        fail(format!("{} moves too many", rest.len()));
    }
    before.len()
}

fn parts(turn: f64, scale_x: f64, scale_y: f64, shear: f64) -> Transform {
    Transform::from_parts(&Parts { turn, scale_x, scale_y, shear, shift: Vector::new(13.0, -8.0) })
}

/// Transforms of every kind; the first are rigid.
fn transforms() -> [Transform; 5] {
    [
        parts(0.0, 1.0, 1.0, 0.0),
        parts(30.0, 1.0, 1.0, 0.0),
        parts(-100.0, 1.5, 1.5, 0.0),
        parts(40.0, 1.1, -1.1, 0.0),
        parts(10.0, 1.2, 1.1, 0.5),
    ]
}

#[test]
fn every_program_of_the_interpreters_tests_moves_as_its_source_does() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../motion/gcode/tests/programs");
    let mut paths: Vec<_> = fs::read_dir(folder).unwrap().map(|e| e.unwrap().path()).collect();
    paths.sort();
    let (mut accepted, mut moves) = (0, 0);
    for path in paths {
        let Ok(text) = fs::read_to_string(&path) else { continue };
        let upper = text.to_uppercase();
        let name = path.file_name().unwrap().to_string_lossy().into_owned();
        // Machine coordinates do not turn with the part.
        if ["G53", "G28", "G30"].iter().any(|code| upper.contains(code)) {
            continue;
        }
        // Their radii differ by the very tolerance, and the digits of a result add to it.
        if name.starts_with("arc-radii-") {
            continue;
        }
        // Compensation by the tool's radius keeps its size: only rigid transforms keep the whole path.
        let compensated = ["G41", "G42"].iter().any(|code| upper.contains(code));
        for (n, transform) in transforms().iter().enumerate() {
            if compensated && n > 1 {
                continue;
            }
            let options = Rules { start: Some(Vector::ZERO), expand: true, ..Rules::default() };
            let Ok(out) = rewrite(text.as_bytes(), transform, &options) else { continue };
            accepted += 1;
            let name = format!("{name} by {n}");
            moves += compare(&name, &text, &String::from_utf8_lossy(&out.text), transform);
        }
    }
    println!("{accepted} results, {moves} moves");
    assert!(accepted > 600 && moves > 1200, "{accepted} results, {moves} moves");
}

/// Numbers that repeat.
struct Random(u64);

impl Random {
    fn below(&mut self, n: u64) -> u64 {
        self.0 =
            self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 33) % n
    }

    fn length(&mut self) -> f64 {
        self.below(200_000) as f64 / 1000.0 - 100.0
    }
}

/// Returns a random program of lines, arcs, cycles, both units and both distance modes.
fn program(random: &mut Random) -> String {
    let mut text = String::from("G21 G90 G94 F1000\nG0 X1 Y2 Z3\n");
    let mut incremental = false;
    for _ in 0..30 {
        let (x, y) = (random.length(), random.length());
        match random.below(10) {
            0 => {
                incremental = !incremental;
                text.push_str(if incremental { "G91\n" } else { "G90\n" });
            }
            1 => text.push_str(if random.below(2) == 0 { "G20\n" } else { "G21\n" }),
            2 => text.push_str(&format!("G1 X{x:.3}\n")),
            3 => text.push_str(&format!("G0Y{y:.3}\n")),
            4 => text.push_str(&format!("G3 I{x:.3} J{y:.3}\n")),
            5 => text.push_str(&format!("G2 I{x:.3} J{y:.3} P2\n")),
            6 => text.push_str(&format!("G98 G81 X{x:.3} Y{y:.3} Z-1 R2\nG80\n")),
            7 if incremental => {
                // A quarter about a centre.
                text.push_str(&format!("G3 X{:.3} Y{:.3} I{x:.3} J{y:.3}\n", x + y, y - x));
            }
            8 => {
                let r = x.hypot(y).max(1.0) * 4.0;
                if incremental {
                    text.push_str(&format!("G2 X{x:.3} Y{y:.3} R{r:.3}\n"));
                }
            }
            _ => text.push_str(&format!("G1 X{x:.3} Y{y:.3}\n")),
        }
    }
    text.push_str("M2\n");
    text
}

#[test]
fn random_programs_move_as_their_sources_do() {
    let mut random = Random(3);
    let mut moves = 0;
    for round in 0..150 {
        let text = program(&mut random);
        for (n, transform) in transforms().iter().enumerate() {
            let out = rewrite(text.as_bytes(), transform, &Rules::default());
            let out = out.unwrap_or_else(|e| panic!("{}\n{text}", e[0].reason));
            let name = format!("program {round} by {n}");
            moves += compare(&name, &text, &String::from_utf8_lossy(&out.text), transform);
        }
    }
    println!("{moves} moves");
    assert!(moves > 10_000, "{moves} moves");
}

#[test]
fn there_and_back_is_the_same_within_one_unit_of_the_last_digit() {
    let mut random = Random(11);
    let mut points = 0;
    for _ in 0..50 {
        let mut text = String::from("G90\n");
        for n in 0..60 {
            match n % 20 {
                5 => text.push_str("G91\n"),
                15 => text.push_str("G90\n"),
                _ => {}
            }
            text.push_str(&format!("G1 X{:.4} Y{:.4} F100\n", random.length(), random.length()));
        }
        text.push_str("M2\n");
        let rigid = Transform { linear: Matrix::rotation(0.3), shift: Vector::new(5.0, 6.0) };
        for transform in [rigid, parts(77.0, 1.0, 1.0, 0.0), parts(10.0, 1.002, 0.998, 0.1)] {
            let there = rewrite(text.as_bytes(), &transform, &Rules::default()).unwrap();
            let inverse = transform.inverse().unwrap();
            let back = rewrite(&there.text, &inverse, &Rules::default()).unwrap();
            let before = trace(text.as_bytes(), Vector::ZERO).unwrap();
            let after = trace(&back.text, Vector::ZERO).unwrap();
            assert_eq!(before.len(), after.len());
            for (a, b) in before.iter().zip(&after) {
                for n in 0..2 {
                    let off = (a.to[n] - b.to[n]).abs();
                    assert!(off < 1.01e-4, "line {}: {off}", a.line);
                }
                points += 1;
            }
        }
    }
    println!("{points} points");
    assert_eq!(points, 9000);
}
