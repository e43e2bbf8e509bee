//! Turning cycles against an oracle: what their passes remove, compared with the profile and its allowance.
//!
//! Random profiles of lines and arcs go through G70 to G72.2. No move may come nearer to the part than the allowance,
//! what is left must be what the cycle says, no pass may be deeper than its increment, and no rapid move may go
//! through material.

use std::{fmt::Write as _, sync::Arc};

use hal_gcode::{Call, Issued, axis::Position};

use crate::{
    plane::{Move, Point, Random, ahead, dot, length, sub},
    support::{World, interpreter, run_with},
};

/// The largest error that the oracle does not notice, in program units.
const HAIR: f64 = 1e-6;

/// A cycle along a profile, in a frame in which the profile goes forward and the tool is above it.
#[derive(Clone, Debug)]
struct Case {
    /// 700 to 722.
    code: u16,
    profile: Vec<Move>,
    place: Point,
    d: f64,
    e: f64,
    i: f64,
    r: f64,
    p: u32,
    /// The signs of both axes of the frame on the machine.
    signs: [f64; 2],
    diameter: bool,
    /// Ends of moves are distances, by U and W or G91.
    words: Words,
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Words {
    Absolute,
    Uw,
    Incremental,
}

/// A move of the tool in the frame.
#[derive(Clone, Copy, Debug)]
struct Pass {
    way: Move,
    rapid: bool,
}

/// Findings of the oracle.
#[derive(Clone, Debug, Default)]
struct Found {
    /// The deepest way into the part with its allowance.
    gouge: f64,
    /// The most that is left beyond what the cycle says.
    left: f64,
    /// The most by which a pass is deeper than the increment.
    deep: f64,
    /// The deepest rapid move through material.
    crash: f64,
}

impl Found {
    fn is_right(&self) -> bool {
        [self.gouge, self.left, self.deep, self.crash].iter().all(|v| *v <= HAIR)
    }
}

fn rounded(value: f64) -> f64 {
    format!("{value:.6}").parse().unwrap()
}

impl Case {
    fn facing(&self) -> bool {
        self.code >= 720 || (self.code == 700 && self.p.is_multiple_of(2))
    }

    /// Returns X and Z of a place.
    fn machine(&self, at: Point) -> Point {
        let [along, level] = [self.signs[0] * at[0], self.signs[1] * at[1]];
        if self.facing() { [along, level] } else { [level, along] }
    }

    fn frame(&self, p: &Position) -> Point {
        let (along, level) = if self.facing() { (p.x, p.z) } else { (p.z, p.x) };
        [self.signs[0] * along, self.signs[1] * level]
    }

    /// Tells whether arcs turn the other way on the machine, in the plane of Z and X.
    fn mirrors(&self) -> bool {
        (self.signs[0] * self.signs[1] < 0.0) != self.facing()
    }

    fn text(&self) -> String {
        let mut out = String::from("g21 g18 f100\n");
        let scale = if self.diameter { 2.0 } else { 1.0 };
        out.push_str(if self.diameter { "g7\n" } else { "g8\n" });
        out.push_str("o100 sub\n");
        let [x, z] = self.machine(self.profile[0].from);
        writeln!(out, "g0 x{:.6} z{z:.6}", x * scale).unwrap();
        for piece in &self.profile {
            let ([x0, z0], [x, z]) = (self.machine(piece.from), self.machine(piece.to));
            let ends = match self.words {
                Words::Absolute => format!("x{:.6} z{z:.6}", x * scale),
                Words::Uw => format!("u{:.6} w{:.6}", (x - x0) * scale, z - z0),
                Words::Incremental => format!("x{:.6} z{:.6}", (x - x0) * scale, z - z0),
            };
            match piece.arc {
                None => writeln!(out, "g1 {ends}").unwrap(),
                Some((centre, left)) => {
                    let [cx, cz] = self.machine(centre);
                    let code = if left == self.mirrors() { "g2" } else { "g3" };
                    writeln!(out, "{code} {ends} i{:.12} k{:.12}", cx - x0, cz - z0).unwrap();
                }
            }
        }
        out.push_str("o100 endsub\n");
        let [x, z] = self.machine(self.place);
        let word = match self.code % 10 {
            0 => format!("g{}", self.code / 10),
            n => format!("g{}.{n}", self.code / 10),
        };
        writeln!(out, "g0 x{:.6} z{z:.6}", x * scale).unwrap();
        if self.words == Words::Incremental {
            // The begin of the profile is absolute only in G90.
            let [x0, z0] = self.machine(self.profile[0].from);
            let from = format!("g0 x{:.6} z{:.6}\n", (x0 - x) * scale, z0 - z);
            let at = out.find("g0").unwrap();
            let end = at + out[at..].find('\n').unwrap() + 1;
            out.replace_range(at..end, &from);
            out.push_str("g91\n");
        }
        let (d, e, i, r) = (self.d, self.e, self.i, self.r);
        if self.code == 700 {
            writeln!(out, "{word} q100 d{d:.6} e{e:.6} p{}", self.p).unwrap();
        } else {
            writeln!(out, "{word} q100 d{d:.6} i{i:.6} r{r:.6}").unwrap();
        }
        out.push_str("m2\n");
        out
    }

    /// Returns the moves of the cycle, or its error.
    fn run(&self, world: &World) -> Result<Vec<Pass>, String> {
        let mut interpreter = interpreter();
        let text = self.text();
        let line = u32::try_from(text.lines().count() - 1).unwrap();
        interpreter.load("turning.ngc", Arc::new(text.into_bytes()));
        let (calls, error) = run_with(&mut interpreter, world, |_| {});
        if let Some(error) = error {
            return Err(error.to_string());
        }
        Ok(self.passes(&calls, line))
    }

    fn passes(&self, calls: &[Issued], line: u32) -> Vec<Pass> {
        let mut at = self.place;
        let mut out = Vec::new();
        for issued in calls.iter().filter(|c| c.line == line) {
            let (end, arc, rapid) = match &issued.call {
                Call::StraightTraverse(end) => (end, None, true),
                Call::StraightFeed(end) => (end, None, false),
                Call::ArcFeed { end, centre_first, centre_second, turns, .. } => {
                    let centre =
                        Position { z: *centre_first, x: *centre_second, ..Position::default() };
                    let left = (*turns > 0) != self.mirrors();
                    (end, Some((self.frame(&centre), left)), false)
                }
                _ => continue,
            };
            let to = self.frame(end);
            if length(sub(to, at)) > 0.0 {
                out.push(Pass { way: Move { from: at, to, arc }, rapid });
            }
            at = to;
        }
        out
    }

    fn distance(&self, at: Point) -> f64 {
        self.profile.iter().map(|m| m.distance(at)).fold(f64::INFINITY, f64::min)
    }

    /// Returns how far a place is inside the part with an allowance.
    fn depth(&self, at: Point, allowance: f64) -> f64 {
        let below = |m: &Move| m.levels(at[0]).into_iter().any(|level| level > at[1]);
        let distance = self.distance(at);
        if self.profile.iter().any(below) { allowance + distance } else { allowance - distance }
    }

    /// Returns the level of the part with an allowance at a place along it.
    fn edge(&self, along: f64, allowance: f64) -> f64 {
        let (first, last) = (self.profile[0].from, self.profile.last().unwrap().to);
        // Beside the profile there is only the allowance round its ends.
        let mut low = match along {
            a if a < first[0] => first[1],
            a if a > last[0] => last[1],
            _ => -1000.0,
        };
        let mut high = 1000.0;
        for _ in 0..60 {
            let middle = f64::midpoint(low, high);
            if self.depth([along, middle], allowance) > 0.0 { low = middle } else { high = middle }
        }
        high
    }

    /// Returns the level to which a cycle without pockets cuts at a place along the profile.
    fn over_pockets(&self, along: f64) -> f64 {
        let first = self.profile[0];
        let begin = first.from[0] - first.direction(0.0)[1].max(0.0) * self.d;
        let mut out = self.edge(along, self.d).max(self.edge(begin + 1e-9, self.d));
        for piece in &self.profile {
            let mut tops = vec![piece.from, piece.to];
            if let Some((centre, _)) = piece.arc {
                let top = [centre[0], centre[1] + length(sub(piece.from, centre))];
                tops.extend((piece.distance(top) < 1e-9).then_some(top));
            }
            for top in tops.into_iter().filter(|t| t[0] <= along) {
                out = out.max(top[1] + self.d);
            }
        }
        out
    }

    /// Compares what the moves remove with what the cycle says.
    fn judge(&self, passes: &[Pass], random: &mut Random) -> Found {
        let mut found = Found::default();
        let finish = self.code == 700;
        let allowance = if finish { self.e.min(self.d) } else { self.d };
        for pass in passes {
            for n in 0..=24 {
                let at = pass.way.at(f64::from(n) / 24.0);
                found.gouge = found.gouge.max(self.depth(at, allowance));
            }
        }
        let (first, last) = (self.profile[0], *self.profile.last().unwrap());
        let (rise, fall) = (first.direction(0.0)[1], last.direction(1.0)[1]);
        let widest = self.d.max(self.e);
        // The moved profile goes from beside a begin that rises to beside the end.
        let begin = first.from[0] - rise.max(0.0) * allowance;
        let end = last.to[0] - fall * if fall > 0.0 { widest } else { allowance };
        if end - begin < HAIR {
            return found;
        }
        for n in 0..40 {
            let along = begin + (end - begin) * (f64::from(n) + random.between(0.05, 0.95)) / 40.0;
            self.judge_column(passes, along, &mut found);
        }
        found
    }

    fn judge_column(&self, passes: &[Pass], along: f64, found: &mut Found) {
        let mut stock = self.place[1];
        let mut lowest = f64::INFINITY;
        for pass in passes {
            for level in pass.way.levels(along) {
                if pass.rapid {
                    found.crash = found.crash.max(stock - level);
                } else {
                    found.deep = found.deep.max(stock - level - self.i);
                    lowest = lowest.min(level);
                    stock = stock.min(level);
                }
            }
        }
        if self.code % 10 == 2 || self.code == 700 {
            // These cut what another cycle has left.
            found.deep = 0.0;
            found.crash = 0.0;
        }
        let at = [along, lowest];
        let left = match self.code {
            711 | 721 => (lowest - self.over_pockets(along)).abs() / 100.0,
            700 => -self.depth(at, self.e),
            _ => -self.depth(at, self.d),
        };
        found.left = found.left.max(left);
    }
}

/// Returns a move that goes forward: a line, a wall or an arc.
fn forward(random: &mut Random, from: Point) -> Move {
    loop {
        let dx = if random.chance(0.2) { 0.0 } else { random.between(0.2, 8.0) };
        let dy = match random.below(4) {
            0 if dx > 0.0 => 0.0,
            _ => random.between(-8.0, 8.0),
        };
        let to = [rounded(from[0] + dx), rounded(from[1] + dy)];
        if length(sub(to, from)) < 0.1 {
            continue;
        }
        let line = Move::line(from, to);
        if dx == 0.0 || random.chance(0.5) {
            return line;
        }
        // A centre on the line between both ends, such that the arc never goes back.
        let way = sub(to, from);
        let aside = if random.chance(0.3) { 0.0 } else { random.between(-2.0, 2.0) };
        let centre = [
            f64::midpoint(from[0], to[0]) - aside * way[1],
            f64::midpoint(from[1], to[1]) + aside * way[0],
        ];
        let arc = Move { from, to, arc: Some((centre, random.chance(0.5))) };
        let goes_on = |n: u32| arc.direction(f64::from(n) / 64.0)[0] >= -1e-9;
        if (0..=64).all(goes_on) && arc.sweep() < 3.2 {
            return arc;
        }
    }
}

fn profile(random: &mut Random) -> Vec<Move> {
    let mut at = [rounded(random.between(-20.0, 5.0)), rounded(random.between(20.0, 30.0))];
    let count = 1 + random.below(9);
    (0..count)
        .map(|_| {
            let out = forward(random, at);
            at = out.to;
            out
        })
        .collect()
}

fn top(profile: &[Move]) -> f64 {
    let heights = profile.iter().flat_map(|m| (0..=64).map(|n| m.at(f64::from(n) / 64.0)[1]));
    heights.fold(f64::NEG_INFINITY, f64::max)
}

fn case(random: &mut Random) -> Case {
    let codes = [700, 710, 710, 710, 711, 712, 720, 720, 721, 722];
    let profile = profile(random);
    let code = codes[random.below(codes.len())];
    let allowance = |random: &mut Random| match random.below(4) {
        0 => 0.0,
        1 => rounded(random.between(0.001, 0.1)),
        2 => rounded(random.between(0.1, 1.0)),
        _ => rounded(random.between(1.0, 4.0)),
    };
    let (d, e) = (allowance(random), allowance(random));
    let e = if code == 700 { e } else { 0.0 };
    let above = top(&profile) + d.max(e) + random.between(0.1, 5.0);
    let begin = profile[0].from[0];
    let end = profile.last().unwrap().to[0];
    let along = match random.below(4) {
        // The side of a wall alone is that of the tool.
        _ if begin == end => begin - random.between(1.0, 6.0) - d.max(e),
        0 => begin,
        1 => random.between(begin, end),
        _ => begin - random.between(0.0, 6.0),
    };
    let sign = |random: &mut Random| if random.chance(0.5) { 1.0 } else { -1.0 };
    let p = 1 + u32::try_from(random.below(4)).unwrap();
    let mut out = Case {
        code,
        profile,
        place: [rounded(along), rounded(above)],
        d,
        e,
        i: rounded(random.between(0.1, 5.0)),
        r: if random.chance(0.2) { 0.0 } else { rounded(random.between(0.0, 4.0)) },
        p,
        signs: [sign(random), sign(random)],
        diameter: random.chance(0.3),
        words: [Words::Absolute, Words::Uw, Words::Incremental][random.below(3)],
    };
    let ends = [out.profile[0].from[1], out.profile.last().unwrap().to[1]];
    if out.code == 700 && random.chance(0.4) {
        // A finishing cycle may begin below the highest place of its profile.
        let level = ends[0].max(ends[1]) + d.max(e) + random.between(0.01, 1.0);
        let along = begin - d.max(e) - random.between(0.0, 3.0);
        out.place = [rounded(along), rounded(level)];
    }
    // G70 turns along Z where it can, and faces otherwise: one of both is sure only for a profile that goes back.
    let level = |m: &Move| [m.direction(0.0)[1], m.direction(1.0)[1]];
    let turns = |s: f64| out.profile.iter().flat_map(level).all(|l| s * l >= -1e-9);
    if out.code == 700 && (turns(1.0) || turns(-1.0)) {
        out.p = 1 + 2 * (out.p / 2);
    }
    out
}

/// Judges random cycles. Returns the worst findings and the reports of those that are wrong.
fn judge_many(seed: u64, count: usize) -> (Found, Vec<String>) {
    let world = World::new();
    let mut random = Random(seed);
    let (mut worst, mut wrong) = (Found::default(), Vec::new());
    for n in 0..count {
        let case = case(&mut random);
        let passes = match case.run(&world) {
            Ok(passes) => passes,
            Err(error) => {
                wrong.push(format!("{n}: {error}\n{}", case.text()));
                continue;
            }
        };
        let found = case.judge(&passes, &mut random);
        if !found.is_right() {
            wrong.push(format!("{n}: {found:?}\n{case:?}\n{}", case.text()));
        }
        worst.gouge = worst.gouge.max(found.gouge);
        worst.left = worst.left.max(found.left);
        worst.deep = worst.deep.max(found.deep);
        worst.crash = worst.crash.max(found.crash);
    }
    (worst, wrong)
}

fn assert_right(seed: u64, count: usize) {
    let (worst, wrong) = judge_many(seed, count);
    eprintln!("{count} cycles: {worst:?}");
    let shown: Vec<&String> = wrong.iter().take(3).collect();
    assert!(wrong.is_empty(), "{} of {count} are wrong:\n{shown:#?}", wrong.len());
}

#[test]
fn cycles_remove_what_is_outside_of_profile_and_allowance() {
    assert_right(1, 200);
}

#[test]
#[ignore = "takes a minute: cargo test -p hal-gcode --test programs -- --ignored --nocapture many_cycles"]
fn many_cycles_remove_what_is_outside_of_profile_and_allowance() {
    assert_right(2, 5000);
}

/// Returns a case's program with compensation for a tool of `radius`, which comes to the place of the cycle from above.
fn compensated(case: &Case, radius: f64) -> String {
    let text = case.text();
    let mut lines: Vec<&str> = text.lines().collect();
    let scale = if case.diameter { 2.0 } else { 1.0 };
    let [x, z] = case.machine([case.place[0], case.place[1] + 10.0 * radius]);
    let code = if case.mirrors() { "g42.1" } else { "g41.1" };
    let entry = format!("g0 x{:.6} z{z:.6}\n{code} d{:.6}", x * scale, 2.0 * radius);
    let cycle = lines.len() - 2;
    let place = lines[cycle - 1].trim_start_matches("g0").to_owned();
    let finish = format!("{}{place}", lines[cycle]);
    (lines[cycle - 1], lines[cycle]) = (&entry, &finish);
    lines.join("\n") + "\n"
}

#[test]
fn a_compensated_finish_comes_no_nearer_to_the_part_than_the_tool_is_wide() {
    let world = World::new();
    let mut random = Random(5);
    let (mut run, mut refused) = (0, 0);
    for _ in 0..3000 {
        let case = case(&mut random);
        if case.code != 700 || case.words != Words::Absolute {
            continue;
        }
        let radius = rounded(random.between(0.01, 0.1));
        let text = compensated(&case, radius);
        let line = u32::try_from(text.lines().count() - 1).unwrap();
        let mut interpreter = interpreter();
        interpreter.load("turning.ngc", Arc::new(text.clone().into_bytes()));
        let (calls, error) = run_with(&mut interpreter, &world, |_| {});
        if let Some(error) = error {
            let said = error.to_string();
            let known = ["gouging", "Tool radius", "come back from the fall"];
            assert!(known.iter().any(|k| said.contains(k)), "{said}\n{text}");
            refused += 1;
            continue;
        }
        run += 1;
        let allowance = case.d.min(case.e) + radius;
        // The first move is the entry.
        for pass in case.passes(&calls, line).iter().skip(1) {
            for n in 0..=24 {
                let depth = case.depth(pass.way.at(f64::from(n) / 24.0), allowance);
                assert!(depth <= HAIR, "{depth} at {pass:?}\n{text}");
            }
        }
    }
    assert!(run > 50, "{run} run, {refused} refused");
    eprintln!("{run} run, {refused} refused");
}

/// Returns the passes with the end of one of them moved towards the part, if one of them runs along it.
fn moved_in(case: &Case, passes: &[Pass], random: &mut Random, by: f64) -> Option<Vec<Pass>> {
    let along = |pass: &&Pass| (case.distance(pass.way.to) - case.d).abs() < 1e-9;
    let candidates: Vec<usize> =
        passes.iter().enumerate().filter(|(_, p)| along(p)).map(|(n, _)| n).collect();
    let n = *candidates.get(random.below(candidates.len().max(1)))?;
    let mut out = passes.to_vec();
    let at = out[n].way.to;
    // The way to the nearest place of the profile, by its steepest descent.
    let best = (0..3600).map(|k| ahead(at, f64::from(k) * 0.1_f64.to_radians(), by));
    let to = best.min_by(|a, b| case.depth(*b, case.d).total_cmp(&case.depth(*a, case.d)))?;
    // Beside the ends of a profile there is no part.
    if case.depth(to, case.d) < by / 2.0 {
        return None;
    }
    out[n].way.to = to;
    if let Some(next) = out.get_mut(n + 1) {
        next.way.from = to;
    }
    Some(out)
}

/// Returns the passes without one that cuts across a level, if there is a wide one.
fn without_one(case: &Case, passes: &[Pass], random: &mut Random) -> Option<Vec<Pass>> {
    let begin = case.profile[0].from[0];
    let is_cut = |n: usize| {
        let way = passes[n].way;
        let flat = way.arc.is_none() && (way.to[1] - way.from[1]).abs() < 1e-9;
        let wide = way.to[0] - way.from[0].max(begin) > 3.0;
        let returns = passes.get(n + 1).is_some_and(|next| next.rapid);
        let below = way.from[1] < case.place[1] - case.i / 2.0;
        flat && wide && returns && below && !passes[n].rapid
    };
    let candidates: Vec<usize> = (0..passes.len()).filter(|n| is_cut(*n)).collect();
    let n = *candidates.get(random.below(candidates.len().max(1)))?;
    let mut out = passes.to_vec();
    out.remove(n);
    Some(out)
}

#[test]
fn the_oracle_notices_a_pass_moved_by_a_hair_and_a_pass_left_out() {
    let world = World::new();
    let mut random = Random(3);
    let (mut moved, mut left_out) = (0, 0);
    for _ in 0..300 {
        let case = case(&mut random);
        if !matches!(case.code, 710 | 720) {
            continue;
        }
        let passes = case.run(&world).unwrap();
        let found = case.judge(&passes, &mut random);
        assert!(found.is_right(), "{found:?}\n{}", case.text());
        if let Some(wrong) = moved_in(&case, &passes, &mut random, 5.0 * HAIR) {
            moved += 1;
            let found = case.judge(&wrong, &mut random);
            assert!(found.gouge > HAIR, "not noticed: {found:?}\n{}", case.text());
        }
        if let Some(wrong) = without_one(&case, &passes, &mut random) {
            left_out += 1;
            let found = case.judge(&wrong, &mut random);
            assert!(found.deep > HAIR, "not noticed: {found:?}\n{}", case.text());
        }
        // Without the last way along the profile, more is left than the cycle says.
        let cuts: Vec<Pass> = passes.iter().filter(|p| p.way.arc.is_none()).copied().collect();
        let level = |p: &Pass| (p.way.to[1] - p.way.from[1]).abs() < 1e-9;
        let cuts: Vec<Pass> = cuts.into_iter().filter(|p| p.rapid || level(p)).collect();
        let slanted = |m: &Move| m.arc.is_some() && dot(m.direction(0.5), m.direction(0.5)) > 0.5;
        if case.profile.iter().any(slanted) && case.d < 0.5 {
            let found = case.judge(&cuts, &mut random);
            assert!(!found.is_right(), "not noticed: {found:?}\n{}", case.text());
        }
    }
    assert!(moved > 100 && left_out > 50, "{moved} and {left_out} faults say little");
    eprintln!("planted: {moved} passes moved, {left_out} left out");
}
