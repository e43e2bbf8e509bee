//! Properties of plans that hold for every program.
#![expect(clippy::unwrap_used, reason = "tests")]

use crate::judge;

use hal_corpus::{Kind, Mode, Motion, Options, Program, Rng, Step, random};
use hal_trajectory::{
    Cell, Follower, Limits, Machine, Move, Path, Planner, Pose, Shape, Track, Trivial, share,
};
use judge::{Conduct, PLAIN, convert, run, times::line_in};

fn machine(jerk: f64) -> Machine {
    Machine::uniform(Limits { velocity: 200.0, acceleration: 1750.0, jerk })
}

fn programs() -> impl Iterator<Item = (Program, Machine)> {
    let kinds = [Kind::Lines, Kind::Arcs, Kind::Reversals, Kind::Tiny, Kind::Mixed];
    kinds.into_iter().enumerate().flat_map(|(k, kind)| {
        [(0.0, 1e5), (0.1, 1e5), (0.1, f64::INFINITY), (2.0, 1e4)].map(move |(p, jerk)| {
            let options = Options {
                count: 40,
                axes: 3,
                mode: Mode::Blend(p),
                feed: 120.0,
                stops: 0.02,
                area: 150.0,
            };
            (random(kind, 10 + k as u64, &options), machine(jerk))
        })
    })
}

fn planned(program: &Program, machine: &Machine) -> Planner<Trivial> {
    let mut planner = Planner::new(*machine, Trivial, Pose(program.start)).unwrap();
    for m in &convert(program, machine).0 {
        m.push(&mut planner).unwrap();
    }
    planner.finish();
    planner
}

/// Poses at a constant override.
fn poses(track: &Track, machine: &Machine, start: Pose, scale: f64) -> Vec<Pose> {
    let mut follower = Follower::new(machine.period, start);
    let mut out = Vec::new();
    while !follower.is_done(track) {
        let step = follower.step(track, scale, false);
        assert!(step.travel >= -1e-12, "forward motion goes back by {}", step.travel);
        out.push(step.pose);
    }
    out
}

fn cycles(program: &Program, machine: &Machine) -> f64 {
    let out = run(program, machine, &Trivial, &PLAIN);
    assert_eq!((out.violations, out.rejected, out.refused), (0, 0, 0), "{}", out.place);
    out.cycles as f64
}

/// The same program with each displacement changed.
fn mapped(program: &Program, line: impl Fn(&Motion) -> Motion, k: f64) -> Program {
    let mut out = program.clone();
    for step in &mut out.steps {
        step.motion = line(&step.motion);
        step.feed *= k;
    }
    out
}

#[test]
fn published_speeds_only_rise_and_nothing_else_changes() {
    for (program, machine) in programs() {
        let mut planner = Planner::new(machine, Trivial, Pose(program.start)).unwrap();
        let mut old: Vec<Cell> = Vec::new();
        for m in &convert(&program, &machine).0 {
            m.push(&mut planner).unwrap();
            let new: Vec<Cell> = planner.track().cells().copied().collect();
            for (k, (a, b)) in old.iter().zip(&new).enumerate() {
                assert!(b.end >= a.end, "cell {k} of {} falls", program.name);
                let last = k + 1 == old.len();
                assert_eq!(*a, Cell { end: a.end, stop: if last { a.stop } else { b.stop }, ..*b });
            }
            assert_eq!(new.last().map_or(0.0, |c| c.end), 0.0, "the path ends at rest");
            old = new;
        }
    }
}

#[test]
fn two_runs_are_the_same_bits_on_every_machine() {
    let mut hash: u64 = 0xcbf2_9ce4_8422_2325;
    for (program, machine) in programs() {
        let one = poses(planned(&program, &machine).track(), &machine, Pose::ZERO, 1.0);
        let two = poses(planned(&program, &machine).track(), &machine, Pose::ZERO, 1.0);
        assert_eq!(one, two);
        for x in one.iter().flat_map(|p| p.0) {
            hash = (hash ^ x.to_bits()).wrapping_mul(0x0100_0000_01b3);
        }
    }
    assert_eq!(hash, HASH, "0x{hash:016x}");
}

/// Hash of all poses of the programs above. It changes with the planner, never with the machine.
const HASH: u64 = 0x5faa_929e_640e_315f;

#[test]
fn mirrored_and_permuted_programs_take_the_same_time() {
    for (program, machine) in programs() {
        let time = cycles(&program, &machine);
        let mirrored = mapped(
            &program,
            |m| match *m {
                Motion::Spline(_) => m.clone(),
                Motion::Line { by: [x, y, z, ..] } => line([-x, y, z]),
                Motion::Arc { center: [x, y, z], normal: [a, b, c], angle, rise, others } => {
                    // A mirror turns the sense of the arc.
                    let (center, normal) = ([-x, y, z], [-a, b, c]);
                    Motion::Arc { center, normal, angle: -angle, rise, others }
                }
            },
            1.0,
        );
        assert_eq!(cycles(&mirrored, &machine), time, "mirror of {}", program.name);
        let turned = mapped(
            &program,
            |m| match *m {
                Motion::Spline(_) => m.clone(),
                Motion::Line { by: [x, y, z, ..] } => line([y, z, x]),
                Motion::Arc { center: [x, y, z], normal: [a, b, c], angle, rise, others } => {
                    Motion::Arc { center: [y, z, x], normal: [b, c, a], angle, rise, others }
                }
            },
            1.0,
        );
        let other = cycles(&turned, &machine);
        assert!((other - time).abs() <= 1.0, "{}: {time} and {other}", program.name);
    }
}

fn line([x, y, z]: [f64; 3]) -> Motion {
    Motion::Line { by: [x, y, z, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0] }
}

#[test]
fn time_scales_with_the_limits() {
    for (program, machine) in programs() {
        // Twice as slow in time: the same periods, each twice as long.
        let mut slow = machine;
        slow.period *= 2.0;
        for l in &mut slow.axes {
            l.velocity /= 2.0;
            l.acceleration /= 4.0;
            l.jerk /= 8.0;
        }
        let program_slow = mapped(&program, Motion::clone, 0.5);
        let (a, b) = (cycles(&program, &machine), cycles(&program_slow, &slow));
        assert!((a - b).abs() <= 1.0, "{}: {a} and {b}", program.name);
    }
}

/// Lengths, tolerances, feeds and limits of twice the size take the same time. The cells of blends have a length of their
/// own, so the times agree to half a percent.
#[test]
fn time_does_not_change_with_the_unit_of_length() {
    for (program, machine) in programs() {
        let mut large = machine;
        large.exact_tolerance *= 2.0;
        for l in &mut large.axes {
            l.velocity *= 2.0;
            l.acceleration *= 2.0;
            l.jerk *= 2.0;
        }
        let twice = |v: [f64; 3]| v.map(|x| 2.0 * x);
        let mut double = mapped(
            &program,
            |m| match *m {
                Motion::Spline(_) => m.clone(),
                Motion::Line { by } => Motion::Line { by: by.map(|x| 2.0 * x) },
                Motion::Arc { center, normal, angle, rise, others } => Motion::Arc {
                    center: twice(center),
                    normal,
                    angle,
                    rise: 2.0 * rise,
                    others: others.map(|x| 2.0 * x),
                },
            },
            2.0,
        );
        for step in &mut double.steps {
            if let Mode::Blend(p) = &mut step.mode {
                *p *= 2.0;
            }
        }
        let (a, b) = (cycles(&program, &machine), cycles(&double, &large));
        assert!((a - b).abs() <= 0.005 * a + 1.0, "{}: {a} and {b}", program.name);
    }
}

/// The plan does not depend on when the moves arrive: through the hand-over in random portions, every cell is the one that
/// the planner makes of the whole program.
#[test]
fn a_plan_in_portions_is_the_plan_of_the_whole() {
    for (seed, (program, machine)) in programs().enumerate() {
        let whole = planned(&program, &machine);
        let mut planner = Planner::new(machine, Trivial, Pose(program.start)).unwrap();
        let (mut publisher, reader) = share(8192, 4096);
        let mut rng = Rng::new(seed as u64);
        for m in &convert(&program, &machine).0 {
            m.push(&mut planner).unwrap();
            if rng.chance(0.3) {
                publisher.publish(&mut planner);
            }
        }
        planner.finish();
        publisher.publish(&mut planner);
        let mut count = 0;
        for cell in whole.track().cells() {
            let other = reader.cell(count).unwrap();
            assert_eq!(*cell, Cell { begin: cell.begin, ..other }, "{} cell {count}", program.name);
            count += 1;
        }
        assert!(count > 0 && reader.cell(count).is_none());
    }
}

#[test]
fn only_the_way_straight_back_is_a_stop() {
    for (angle, stops) in [(90.0_f64, 1), (169.0, 1), (171.0, 1), (179.9, 1), (180.0, 2)] {
        let (sin, cos) = libm::sincos(angle.to_radians());
        let mut planner = Planner::new(machine(1e5), Trivial, Pose::ZERO).unwrap();
        for [x, y] in [[10.0, 0.0], [10.0 + 10.0 * cos, 10.0 * sin]] {
            let shape = Shape::Line { end: Pose::from_xyz([x, y, 0.0]) };
            let mode = hal_trajectory::Mode::Blend(0.1);
            planner.push(&Move { shape, feed: 50.0, rapid: false, mode, line: 0 }).unwrap();
        }
        planner.finish();
        assert_eq!(planner.track().cells().filter(|c| c.stop).count(), stops, "{angle}°");
    }
}

#[test]
fn higher_limits_take_no_more_time() {
    for (program, machine) in programs() {
        let time = cycles(&program, &machine);
        for which in 0..2 {
            let mut better = machine;
            for l in &mut better.axes {
                match which {
                    0 => l.velocity *= 1.5,
                    _ => {
                        // Acceleration with jerk, so that the filter keeps its length.
                        l.acceleration *= 1.5;
                        l.jerk *= 1.5;
                    }
                }
            }
            let other = cycles(&program, &better);
            assert!(other <= time * 1.005 + 2.0, "{} {which}: {time} and {other}", program.name);
        }
    }
}

#[test]
fn a_line_in_a_thousand_pieces_takes_no_more_time() {
    for jerk in [1e5, f64::INFINITY] {
        let machine = machine(jerk);
        let [one, many] = [1, 1000].map(|pieces| cycles(&line_in(pieces), &machine));
        assert!((one - many).abs() <= 1.0, "{one} and {many}");
    }
}

#[test]
fn a_constant_override_is_as_fast_as_a_lower_feed() {
    for (program, machine) in programs() {
        let half = mapped(&program, Motion::clone, 0.5);
        // A lower feed may have a shorter filter.
        let filter = |p: &Program| planned(p, &machine).track().cells().map(|c| c.samples).max();
        if filter(&half) != filter(&program) {
            continue;
        }
        let by_override =
            poses(planned(&program, &machine).track(), &machine, Pose::ZERO, 0.5).len() as f64;
        let by_feed =
            poses(planned(&half, &machine).track(), &machine, Pose::ZERO, 1.0).len() as f64;
        assert!(by_override <= 1.03 * by_feed + 40.0, "{}: {by_override} {by_feed}", program.name);
    }
}

#[test]
fn holds_and_reversals_change_no_place_on_the_path() {
    for (program, machine) in programs() {
        let planner = planned(&program, &machine);
        let track = planner.track();
        let length: f64 = track.cells().map(|c| c.length).sum();
        let mut rng = Rng::new(3);
        let mut follower = Follower::new(machine.period, Pose::ZERO);
        let (mut sum, mut scale, mut reverse, mut cycle) = (0.0, 1.0, false, 0);
        while !follower.is_done(track) {
            cycle += 1;
            if cycle < 20_000 && rng.chance(0.01) {
                scale = rng.pick(&[0.0, 0.2, 1.0], 1.0);
                reverse = rng.chance(0.3);
            } else if cycle >= 20_000 {
                (scale, reverse) = (1.0, false);
            }
            sum += follower.step(track, scale, reverse).travel;
        }
        assert!((sum - length).abs() < 1e-9 * length.max(1.0), "{sum} of {length}");
        // Back to the start.
        let mut pose = Pose([1.0; 9]);
        let mut idle = 0;
        while idle < 3000 {
            let step = follower.step(track, 1.0, true);
            idle = if step.moving { 0 } else { idle + 1 };
            pose = step.pose;
        }
        assert!(pose.dot_all(&pose).sqrt() < 1e-9, "{}: reverse ends at {pose:?}", program.name);
    }
}

#[test]
fn exact_stops_pass_their_point_and_rest_there() {
    for jerk in [1e5, f64::INFINITY] {
        let machine = machine(jerk);
        let options = Options {
            count: 30,
            axes: 9,
            mode: Mode::ExactStop,
            feed: 200.0,
            stops: 0.0,
            area: 150.0,
        };
        let program = random(Kind::Lines, 4, &options);
        let seen = poses(planned(&program, &machine).track(), &machine, Pose::ZERO, 1.0);
        let corners = program.poses();
        for corner in &corners[1..corners.len() - 1] {
            let off = |p: &Pose| {
                let by = *p - Pose(*corner);
                by.dot_all(&by).sqrt()
            };
            let at: Vec<usize> = (0..seen.len()).filter(|k| off(&seen[*k]) < 1e-9).collect();
            // A filter dwells there. Without one, motion leaves in the next period, from a speed of 0.
            let least = if jerk.is_finite() { 3 } else { 1 };
            assert!(at.len() >= least, "{corner:?}");
            let fastest = machine.axes.map(|l| l.acceleration).iter().sum::<f64>();
            let first = off(&seen[at[at.len() - 1] + 1]);
            assert!(first <= 0.5 * fastest * machine.period * machine.period, "{first}");
        }
    }
}

/// Without a limit of jerk, too, and at any override: the limits hold as differences of the samples, each exact stop is a
/// sample at the very corner, and the speed is 0 there, because the samples beside it are no farther than an acceleration
/// from rest goes in a period.
#[test]
fn without_a_limit_of_jerk_every_corner_is_a_sample_at_rest() {
    let kinds = [Kind::Lines, Kind::Arcs, Kind::Reversals, Kind::Tiny, Kind::Mixed];
    let (mut stops, mut longer) = (0, 0);
    for (kind, n) in kinds.into_iter().flat_map(|kind| (0..6).map(move |n| (kind, n))) {
        let seed = n as u64;
        let machine = machine(f64::INFINITY);
        let mode = Mode::ExactStop;
        let options = Options { count: 40, axes: 9, mode, feed: 250.0, stops: 0.0, area: 60.0 };
        let program = random(kind, 70 + seed, &options);
        let change = [0.0, 0.002, 0.05, 0.3][n % 4];
        let out = run(&program, &machine, &Trivial, &Conduct { seed, change, ..PLAIN });
        assert_eq!((out.violations, out.rejected, out.refused), (0, 0, 0), "{}", out.place);

        let planner = planned(&program, &machine);
        let mut follower = Follower::new(machine.period, Pose(program.start));
        let mut rng = Rng::new(seed);
        let mut seen = vec![(Pose(program.start), 0, true)];
        let mut scale = 1.0;
        while !follower.is_done(planner.track()) {
            if rng.chance(change) {
                scale = rng.pick(&[0.0, 0.05, 0.4, 1.0, 1.5], 1.0);
            }
            scale = if seen.len() > 30_000 { 1.0 } else { scale };
            let step = follower.step(planner.track(), scale, false);
            seen.push((step.pose, step.line as usize, step.rests));
        }
        let corners = program.poses();
        let reached: Vec<bool> = corners.iter().map(|c| at_rest(&seen, c, &machine)).collect();
        for (before, after) in seen.iter().zip(&seen[1..]).map(|(a, b)| (a.1, b.1)) {
            for k in before..after {
                // The corner between two lines; the lines of specks may be part of the next ones.
                assert!(reached[k + 1] || after - before > 1, "{kind:?} {seed}: corner {}", k + 1);
                stops += 1;
            }
        }
        longer += usize::from(change > 0.0);
    }
    assert!(stops > 900 && longer > 10, "{stops} stops");
}

/// Returns whether a sample is at a corner, at rest as the samples beside it show.
fn at_rest(seen: &[(Pose, usize, bool)], corner: &[f64; 9], machine: &Machine) -> bool {
    let at = seen.iter().enumerate().filter(|(_, (pose, _, rests))| {
        let by = *pose - Pose(*corner);
        *rests && by.dot_all(&by).sqrt() < 1e-9
    });
    let mut beside = at.flat_map(|(k, here)| {
        [k.checked_sub(1), Some(k + 1)].into_iter().flatten().map(move |n| (n, here.0))
    });
    let reached = beside.clone().next().is_some();
    reached
        && beside.all(|(n, here)| {
            let Some((there, ..)) = seen.get(n) else { return true };
            let steps = (*there - here).0.into_iter().zip(machine.axes);
            let near = |(by, limits): (f64, Limits)| {
                by.abs()
                    <= 0.5 * limits.acceleration * machine.period.powi(2) * (1.0 + 1e-6) + 1e-12
            };
            steps.into_iter().all(near)
        })
}

/// From any state, a hold is at rest within the time that braking, the filter and the pause before it take.
#[test]
fn a_hold_stops_in_time() {
    for (program, machine) in programs() {
        let planner = planned(&program, &machine);
        let track = planner.track();
        if machine.axes.iter().any(|l| l.jerk == f64::INFINITY) {
            // The acceleration that is left at full speed may be none.
            continue;
        }
        for moment in 1..20 {
            let mut follower = Follower::new(machine.period, Pose::ZERO);
            for _ in 0..moment * 97 {
                let _ = follower.step(track, 1.0, false);
            }
            let top = |c: &Cell| c.rest - c.fade * c.speed * c.speed;
            let least = track.cells().map(top).fold(f64::INFINITY, f64::min);
            let filter = f64::from(track.cells().map(|c| c.samples).max().unwrap());
            let pause = filter + 3.0;
            let brake = follower.speed() / least / machine.period;
            let mut count = 0.0;
            while follower.step(track, 0.0, false).moving {
                count += 1.0;
            }
            assert!(count <= brake + filter + pause + 4.0, "{count} periods, {brake} of braking");
        }
    }
}

/// Lines of a hundredth of a micrometre to ten: the follower has time for every cell.
#[test]
fn specks_are_followed_inside_the_limits() {
    for length in [1e-6, 1e-5, 1e-4, 1e-3] {
        for jerk in [1e5, f64::INFINITY] {
            let mut steps = Vec::new();
            for k in 0..3000 {
                let (s, c) = libm::sincos(length * f64::from(k));
                steps.push(Step {
                    motion: line([length * c, length * s, 0.0]),
                    mode: Mode::Blend(0.01),
                    feed: 100.0,
                });
            }
            let program = Program { name: "specks", seed: 0, start: [0.0; 9], steps };
            let conduct = Conduct { change: 0.003, ..PLAIN };
            let out = run(&program, &machine(jerk), &Trivial, &conduct);
            assert_eq!((out.violations, out.rejected), (0, 0), "{length}: {}", out.place);
            assert!(out.events < 96, "{length} {jerk}: {} events", out.events);
        }
    }
}
