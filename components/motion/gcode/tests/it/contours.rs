//! Cutter compensation against an oracle: the distance of the tool from the programmed contour.
//!
//! Random contours of lines and arcs, with inside and outside corners of every angle, go through G41 and G42. Moves that
//! do not follow each other leave room for the tool between them. It may never come nearer to a move than its radius,
//! and it must touch each move wherever the others leave room. A contour is refused only at a corner without room.

use std::{f64::consts::PI, fmt::Write as _, sync::Arc};

use hal_gcode::{Call, Issued, axis::Position};

use crate::{
    plane::{Move, Point, Random, ahead, dot, length, sub},
    support::{World, interpreter, run_with},
};

/// The largest error that the oracle does not notice, in program units.
const HAIR: f64 = 1e-5;

/// A contour with the tool at its side.
#[derive(Clone, Debug)]
struct Case {
    moves: Vec<Move>,
    radius: f64,
    left: bool,
    /// In XZ, not in XY.
    lathe: bool,
    /// The moves that are rapid.
    rapid: Vec<bool>,
}

/// A move of the tool, with the move of the contour on whose line it is.
#[derive(Clone, Copy, Debug)]
struct Cut {
    way: Move,
    index: usize,
}

/// Findings of the oracle.
#[derive(Clone, Debug, Default)]
struct Found {
    /// Depth of the tool inside the contour.
    gouge: f64,
    /// The widest place of the contour that the tool should touch and does not.
    left: f64,
}

fn rounded(value: f64) -> f64 {
    format!("{value:.9}").parse().unwrap()
}

impl Case {
    /// The first moves of a program: it enters along the first move, from a radius before it.
    const LINES: usize = 4;

    fn words(&self, at: Point) -> String {
        // In XZ, the first axis of the plane is Z.
        if self.lathe {
            format!("z{:.9} x{:.9}", at[0], at[1])
        } else {
            format!("x{:.9} y{:.9}", at[0], at[1])
        }
    }

    fn text(&self) -> String {
        let plane = if self.lathe { "g18 g8" } else { "g17" };
        let mut out = format!("g21 {plane} f100\n");
        let first = self.moves[0];
        let direction = first.direction(0.0);
        let lead = 3.0 * self.radius + 1.0;
        let start = [first.from[0] - lead * direction[0], first.from[1] - lead * direction[1]];
        writeln!(out, "g0 {}", self.words(start)).unwrap();
        let side = if self.left { "g41.1" } else { "g42.1" };
        writeln!(out, "{side} d{:.9}", 2.0 * self.radius).unwrap();
        writeln!(out, "g1 {}", self.words(first.from)).unwrap();
        for (piece, rapid) in self.moves.iter().zip(&self.rapid) {
            let ends = self.words(piece.to);
            match piece.arc {
                None => writeln!(out, "{} {ends}", if *rapid { "g0" } else { "g1" }).unwrap(),
                Some((centre, left)) => {
                    let way = sub(centre, piece.from);
                    let code = if left { "g3" } else { "g2" };
                    let names = if self.lathe { ["k", "i"] } else { ["i", "j"] };
                    let centre = format!("{}{:.12} {}{:.12}", names[0], way[0], names[1], way[1]);
                    writeln!(out, "{code} {ends} {centre}").unwrap();
                }
            }
        }
        out.push_str("g40\nm2\n");
        out
    }

    /// Returns the moves of the tool, or the error and its move.
    fn run(&self, world: &World) -> Result<Vec<Cut>, (usize, String)> {
        let mut interpreter = interpreter();
        interpreter.load("contour.ngc", Arc::new(self.text().into_bytes()));
        let (calls, error) = run_with(&mut interpreter, world, |_| {});
        if let Some(error) = error {
            let line = usize::try_from(error.place.line).unwrap();
            return Err((line.saturating_sub(Self::LINES + 1), error.to_string()));
        }
        Ok(self.cuts(&calls))
    }

    fn cuts(&self, calls: &[Issued]) -> Vec<Cut> {
        let place = |p: &Position| if self.lathe { [p.z, p.x] } else { [p.x, p.y] };
        let mut at = [0.0, 0.0];
        let mut out = Vec::new();
        for issued in calls {
            let (end, arc) = match &issued.call {
                Call::StraightTraverse(end) | Call::StraightFeed(end) => (end, None),
                Call::ArcFeed { end, centre_first, centre_second, turns, .. } => {
                    (end, Some(([*centre_first, *centre_second], *turns > 0)))
                }
                _ => continue,
            };
            let to = place(end);
            let line = usize::try_from(issued.line).unwrap();
            if line > Self::LINES && length(sub(to, at)) > 0.0 {
                let index = line - Self::LINES - 1;
                out.push(Cut { way: Move { from: at, to, arc }, index });
            }
            at = to;
        }
        out
    }

    fn judge(&self, cuts: &[Cut]) -> Found {
        let mut found = Found::default();
        for cut in cuts {
            for n in 0..=32 {
                let at = cut.way.at(f64::from(n) / 32.0);
                found.gouge = found.gouge.max(self.radius - self.distance(at));
            }
        }
        for piece in &self.moves {
            for n in 1..32 {
                let tool = self.touching(piece, f64::from(n) / 32.0);
                // In an inside corner the neighbour keeps the tool away.
                if self.distance(tool) > self.radius - 2e-6 {
                    let ways = cuts.iter().map(|c| c.way.distance(tool));
                    found.left = found.left.max(ways.fold(f64::INFINITY, f64::min));
                }
            }
        }
        found
    }

    fn distance(&self, at: Point) -> f64 {
        self.moves.iter().map(|m| m.distance(at)).fold(f64::INFINITY, f64::min)
    }

    /// Returns the place of the tool that touches a move at a share of its way.
    fn touching(&self, piece: &Move, share: f64) -> Point {
        let (at, direction) = (piece.at(share), piece.direction(share));
        let aside = if self.left { self.radius } else { -self.radius };
        [at[0] - aside * direction[1], at[1] + aside * direction[0]]
    }

    /// Returns the shares of a move, in steps, at which the tool can touch it beside another.
    fn free(&self, piece: &Move, others: &[Move]) -> Vec<bool> {
        let is_free = |n: u32| {
            let tool = self.touching(piece, f64::from(n) / 300.0);
            others.iter().chain([piece]).all(|m| m.distance(tool) > self.radius - 1e-7)
        };
        (0..=300).map(is_free).collect()
    }

    /// Tells whether the tool has room at the corner before a move.
    fn has_room(&self, index: usize) -> bool {
        let from = index.saturating_sub(2);
        let has = |free: &[bool]| free.windows(3).any(|w| w.iter().all(|f| *f));
        let around = &self.moves[from..=index];
        (from..=index).skip(usize::from(index > 1)).all(|n| has(&self.free(&self.moves[n], around)))
    }

    /// Tells whether a move may follow: those before the last one leave room for the tool, and the last one keeps it away
    /// nowhere but at their corner.
    fn may_follow(&self, piece: &Move) -> bool {
        let Some((last, before)) = self.moves.split_last() else { return true };
        let places = |m: &Move| (0..=60).map(|n| m.at(f64::from(n) / 60.0)).collect::<Vec<_>>();
        let apart = |a: &Move, b: &Move| {
            places(a).into_iter().all(|p| b.distance(p) > 2.5 * self.radius)
                && places(b).into_iter().all(|p| a.distance(p) > 2.5 * self.radius)
        };
        let (one, two) = (last.direction(1.0), piece.direction(0.0));
        let turn = (one[0] * two[1] - one[1] * two[0]).atan2(dot(one, two));
        let outside = (turn < 0.0) == self.left;
        let back = turn.abs() > 2.9;
        if back && turn.abs() < PI - 1e-8 && (last.arc.is_some() || piece.arc.is_some()) {
            // Such ways may cross at once.
            return false;
        }
        if back && last.sweep().max(piece.sweep()) > 2.0 {
            // The other end of the arc may be in the way round the tip.
            return false;
        }
        let behind = self.free(piece, &[*last]);
        let mut before_corner = self.free(last, &[*piece]);
        before_corner.reverse();
        // Behind a free place none is blocked, and at an outside corner none at all.
        let is_single =
            |free: &[bool]| free.windows(2).all(|w| !w[0] || w[1]) && (!outside || back || free[2]);
        before.iter().all(|m| apart(m, piece))
            && is_single(&before_corner)
            && is_single(&behind)
            && !crosses(last, piece)
    }
}

/// Tells whether two moves cross elsewhere than at their corner.
fn crosses(a: &Move, b: &Move) -> bool {
    let places = |m: &Move| (0..=40).map(|n| m.at(f64::from(n) / 40.0)).collect::<Vec<_>>();
    let side = |p: Point, q: Point, r: Point| {
        (q[0] - p[0]) * (r[1] - p[1]) - (q[1] - p[1]) * (r[0] - p[0])
    };
    let (a, b) = (places(a), places(b));
    let cross = |p: &[Point], q: &[Point]| {
        side(p[0], p[1], q[0]) * side(p[0], p[1], q[1]) < 0.0
            && side(q[0], q[1], p[0]) * side(q[0], q[1], p[1]) < 0.0
    };
    a.windows(2).any(|p| b.windows(2).any(|q| cross(p, q)))
}

/// Returns a random contour: chains of moves whose directions turn by any angle.
fn case(random: &mut Random) -> Case {
    let radius = match random.below(4) {
        0 => rounded(random.between(0.01, 0.2)),
        1 => rounded(random.between(1.0, 4.0)),
        _ => rounded(random.between(0.2, 1.0)),
    };
    let mut at = [rounded(random.between(-9.0, 9.0)), rounded(random.between(-9.0, 9.0))];
    let mut angle = random.between(-PI, PI);
    let (left, lathe) = (random.chance(0.5), random.chance(0.3));
    let mut out = Case { moves: Vec::new(), radius, left, lathe, rapid: Vec::new() };
    for _ in 0..30 {
        let piece = following(random, at, angle);
        if out.moves.len() >= 8 || !out.may_follow(&piece) {
            continue;
        }
        at = piece.to;
        let direction = piece.direction(1.0);
        angle = direction[1].atan2(direction[0]) + corner(random);
        out.rapid.push(piece.arc.is_none() && random.chance(0.2));
        out.moves.push(piece);
    }
    out
}

/// Returns the turn of a corner.
fn corner(random: &mut Random) -> f64 {
    let sign = if random.chance(0.5) { 1.0 } else { -1.0 };
    match random.below(8) {
        0 => 0.0,
        1 => sign * 10.0_f64.powf(random.between(-9.0, -1.0)),
        2 => sign * (PI - 10.0_f64.powf(random.between(-9.0, -1.0))),
        3 => PI,
        4 => sign * PI / 2.0,
        _ => sign * random.between(0.0, 3.0),
    }
}

fn following(random: &mut Random, from: Point, angle: f64) -> Move {
    let size = 10.0_f64.powf(random.between(-1.5, 1.5));
    if random.chance(0.6) {
        let to = ahead(from, angle, size);
        return Move::line(from, [rounded(to[0]), rounded(to[1])]);
    }
    let left = random.chance(0.5);
    let (side, sweep) = (if left { 1.0 } else { -1.0 }, random.between(0.2, 4.0));
    let centre = ahead(from, angle + side * PI / 2.0, size);
    let end = ahead(centre, angle - side * PI / 2.0 + side * sweep, size);
    Move { from, to: [rounded(end[0]), rounded(end[1])], arc: Some((centre, left)) }
}

/// Judges random contours. Returns the worst findings, the refusals and the reports of what is wrong.
fn judge_many(seed: u64, count: usize) -> (Found, usize, Vec<String>) {
    let world = World::new();
    let mut random = Random(seed);
    let (mut worst, mut refused, mut wrong) = (Found::default(), 0, Vec::new());
    for n in 0..count {
        let mut case = case(&mut random);
        // What is before a refusal is judged too.
        let cuts = loop {
            match case.run(&world) {
                Ok(cuts) => break cuts,
                Err((index, error)) => {
                    refused += 1;
                    let is_told = error.contains("tool") && index < case.moves.len();
                    if !is_told || case.has_room(index) {
                        wrong.push(format!("{n}: move {index}: {error}\n{}", case.text()));
                    }
                    case.moves.truncate(index);
                    case.rapid.truncate(index);
                    if index == 0 {
                        break Vec::new();
                    }
                }
            }
        };
        if case.moves.is_empty() {
            continue;
        }
        let found = case.judge(&cuts);
        if found.gouge > HAIR || found.left > HAIR {
            wrong.push(format!("{n}: {found:?}\n{}", case.text()));
        }
        worst.gouge = worst.gouge.max(found.gouge);
        worst.left = worst.left.max(found.left);
    }
    (worst, refused, wrong)
}

fn assert_right(seed: u64, count: usize) {
    let (worst, refused, wrong) = judge_many(seed, count);
    eprintln!("{count} contours, {refused} refusals: {worst:?}");
    let shown = wrong.iter().take(6).map(String::as_str).collect::<Vec<_>>().join("\n");
    assert!(wrong.is_empty(), "{} of {count} are wrong:\n{shown}", wrong.len());
    assert!(refused < count, "{refused} refusals: the contours say little");
}

#[test]
fn the_tool_touches_the_contour_and_is_never_inside() {
    assert_right(1, 150);
}

#[test]
#[ignore = "takes two minutes: cargo test -p hal-gcode --test programs -- --ignored --nocapture many_contours"]
fn many_contours_are_touched_and_never_cut_into() {
    assert_right(2, 5000);
}

#[test]
fn the_oracle_notices_a_path_moved_by_a_hair_and_a_move_left_out() {
    let world = World::new();
    let mut random = Random(3);
    let (mut moved, mut left_out) = (0, 0);
    for _ in 0..200 {
        let case = case(&mut random);
        let Ok(cuts) = case.run(&world) else { continue };
        let n = random.below(cuts.len());
        let piece = case.moves[cuts[n].index];
        let at = cuts[n].way.to;
        if (piece.distance(at) - case.radius).abs() < 1e-9 {
            // Towards the contour.
            let steps = (0..360).map(|k| ahead(at, f64::from(k).to_radians(), 3.0 * HAIR));
            let to = steps.min_by(|a, b| piece.distance(*a).total_cmp(&piece.distance(*b)));
            let mut wrong = cuts.clone();
            wrong[n].way.to = to.unwrap();
            moved += 1;
            let found = case.judge(&wrong);
            assert!(found.gouge > HAIR, "not noticed: {found:?}\n{}", case.text());
        }
        let n = random.below(case.moves.len());
        let long = |c: &Cut| c.index == n && length(sub(c.way.to, c.way.from)) > 4.0 * case.radius;
        if case.moves[n].arc.is_none() && cuts.iter().any(long) {
            let wrong: Vec<Cut> = cuts.iter().filter(|c| c.index != n).copied().collect();
            left_out += 1;
            let found = case.judge(&wrong);
            assert!(found.left > HAIR, "not noticed: {found:?}\n{}", case.text());
        }
    }
    assert!(moved > 50 && left_out > 15, "{moved} and {left_out} faults say little");
    eprintln!("planted: {moved} paths moved, {left_out} moves left out");
}
