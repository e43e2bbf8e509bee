//! Overrides of feeds and of rapid moves, each of its own.
#![expect(clippy::unwrap_used, clippy::indexing_slicing, reason = "tests")]

use hal_trajectory::{
    Follower, Limits, Machine, Mode, Move, Planner, Pose, Scales, Shape, Trivial,
};

const VELOCITY: f64 = 200.0;
const ACCELERATION: f64 = 1750.0;
const FEED: f64 = 50.0;

fn machine(jerk: f64) -> Machine {
    Machine::uniform(Limits { velocity: VELOCITY, acceleration: ACCELERATION, jerk })
}

/// Plans lines in X and Y: where each ends, whether it is rapid, and its feed.
fn planned(machine: &Machine, mode: Mode, lines: &[(f64, f64, bool, f64)]) -> Planner<Trivial> {
    let mut planner = Planner::new(*machine, Trivial, Pose::ZERO).unwrap();
    for (line, &(x, y, rapid, feed)) in (1..).zip(lines) {
        let shape = Shape::Line { end: Pose::from_xyz([x, y, 0.0]) };
        let feed = if rapid { f64::INFINITY } else { feed };
        planner.push(&Move { shape, feed, rapid, mode, line }).unwrap();
    }
    planner.finish();
    planner
}

/// Returns the periods of each line, and its highest speed.
fn taken(planner: &Planner<Trivial>, period: f64, scales: Scales) -> Vec<(f64, f64)> {
    let mut follower = Follower::new(period, Pose::ZERO);
    let mut out: Vec<(f64, f64)> = Vec::new();
    while !follower.is_done(planner.track()) {
        let step = follower.step(planner.track(), scales, false);
        let line = usize::try_from(step.line).unwrap();
        out.resize(out.len().max(line), (0.0, 0.0));
        let (periods, speed) = &mut out[line - 1];
        *periods += 1.0;
        *speed = speed.max(step.travel / period);
        assert!(periods < &mut 1e6, "it stands in line {line}");
    }
    out
}

/// Between exact stops, without a limit of jerk, each move takes the time of its trapezoid at its own override, and its
/// highest speed is the speed at that override.
#[test]
fn each_override_scales_its_own_moves() {
    let lines = [(100.0, 0.0, true, 0.0), (0.0, 0.0, false, FEED), (90.0, 40.0, true, 0.0)];
    let machine = machine(f64::INFINITY);
    let planner = planned(&machine, Mode::ExactStop, &lines);
    let slanted = 90.0_f64.hypot(40.0);
    // Along the slanted line, X reaches its limit; its acceleration counts the same.
    let steeper = slanted / 90.0;
    let ways = [(100.0, VELOCITY, 1.0), (100.0, FEED, 1.0), (slanted, VELOCITY * steeper, steeper)];
    for (feed, rapid) in [(1.0, 1.0), (0.5, 1.0), (1.0, 0.25), (0.5, 0.25), (0.1, 0.9), (1.0, 7.0)]
    {
        let taken = taken(&planner, machine.period, Scales { feed, rapid });
        for ((way, full, steeper), ((_, _, is_rapid, _), (periods, speed))) in
            ways.into_iter().zip(lines.iter().zip(&taken))
        {
            let speed_wanted = full * if *is_rapid { rapid.min(1.0) } else { feed };
            let seconds = way / speed_wanted + speed_wanted / (ACCELERATION * steeper);
            assert!((speed - speed_wanted).abs() < 1e-6 * full, "{feed} {rapid}: {speed}");
            let off = (periods * machine.period - seconds).abs();
            assert!(off < 3.0 * machine.period, "{feed} {rapid}: {periods} periods, {seconds} s");
        }
    }
}

/// With jerk and blends, a program of one kind takes the same at the other kind's override, to the last bit.
#[test]
fn the_other_override_changes_nothing() {
    for jerk in [f64::INFINITY, 1e5, 1e4] {
        for rapid in [false, true] {
            let machine = machine(jerk);
            let lines =
                [(60.0, 0.0, rapid, FEED), (60.0, 50.0, rapid, FEED), (1.0, 2.0, rapid, FEED)];
            let planner = planned(&machine, Mode::Blend(0.1), &lines);
            let at = |scales| taken(&planner, machine.period, scales);
            let of = |own: f64, other: f64| match rapid {
                true => Scales { feed: other, rapid: own },
                false => Scales { feed: own, rapid: other },
            };
            for own in [1.0, 0.3] {
                let same = at(of(own, own));
                assert_eq!(at(of(own, 0.0)), same);
                assert_eq!(at(of(own, f64::NAN)), same);
                assert_eq!(at(of(own, 1.0)), same);
            }
        }
    }
}

/// An override of 0 lets moves of the other kind pass, and stops before moves of its own kind, forward and backward,
/// whatever joins them: a corner, or a straight way at full speed.
#[test]
fn an_override_of_0_stops_before_its_moves() {
    for jerk in [f64::INFINITY, 1e5, 1e4] {
        for corner in [0.0, 60.0] {
            for is_first_rapid in [false, true] {
                let machine = machine(jerk);
                let lines = [
                    (60.0, 0.0, is_first_rapid, 150.0),
                    (120.0 - corner, corner, !is_first_rapid, 150.0),
                ];
                let planner = planned(&machine, Mode::Blend(0.1), &lines);
                let track = planner.track();
                let mut follower = Follower::new(machine.period, Pose::ZERO);
                let holds = |held: bool| match held {
                    true => Scales { feed: 1.0, rapid: 0.0 },
                    false => Scales { feed: 0.0, rapid: 1.0 },
                };
                let mut run = |scales: Scales, reverse: bool| {
                    for _ in 0..5_000 {
                        let step = follower.step(track, scales, reverse);
                        if !step.moving && !reverse && follower.is_done(track) {
                            break;
                        }
                    }
                    let step = follower.step(track, scales, reverse);
                    assert!(!step.moving, "{step:?}");
                    step.pose.0
                };
                let first = run(holds(!is_first_rapid), false);
                assert!((59.0..60.0).contains(&first[0]) && first[1] == 0.0, "{first:?}");
                let still = run(Scales::HOLD, false);
                assert_eq!(still, first);
                let end = run(Scales::FULL, false);
                assert!((end[0] - 120.0 + corner).abs() < 1e-9, "{end:?}");
                // Back along the second move, and not into the first.
                let back = run(holds(is_first_rapid), true);
                let into = if corner > 0.0 { back[1] } else { back[0] - 60.0 };
                assert!((0.0..1.0).contains(&into), "{back:?}");
                assert!(run(Scales::FULL, true)[0].abs() < 1e-9);
            }
        }
    }
}

/// An override of 0 also stops before its moves where many cells lie within the braking distance: behind dense code, which is
/// joined or not, and behind an arc of lines.
#[test]
fn an_override_of_0_stops_before_its_moves_behind_short_cells() {
    type Place = fn(f64) -> (f64, f64);
    let straight: Place = |x| (x, 0.0);
    let wave: Place = |x| (x, 0.5 * (x / 4.0).sin());
    let zigzag: Place = |x| (x, if (x * 100.0).round() % 2.0 == 0.0 { 0.0 } else { -0.003 });
    let circle: Place = |s| (2.0 * (s / 2.0).sin(), 2.0 - 2.0 * (s / 2.0).cos());
    for jerk in [f64::INFINITY, 1e5, 1e4] {
        for (name, place, count) in [
            ("straight", straight, 1500),
            ("wave", wave, 1500),
            ("zigzag", zigzag, 200),
            ("circle", circle, 1200),
        ] {
            let machine = machine(jerk);
            let place = |n: i32| place(f64::from(n) * 0.01);
            let feeds = (1..=count).map(|n| (place(n).0, place(n).1, false, 120.0));
            let (x, y) = place(count);
            let lines: Vec<_> = feeds.chain([(x + 100.0, y, true, 0.0)]).collect();
            let planner = planned(&machine, Mode::Blend(0.01), &lines);
            let mut follower = Follower::new(machine.period, Pose::ZERO);
            let (mut way, mut periods) = (0.0, 0);
            loop {
                let scales = Scales { feed: 1.0, rapid: 0.0 };
                let step = follower.step(planner.track(), scales, false);
                (way, periods) = (way + step.travel, periods + 1);
                if !step.moving && way > 0.0 {
                    break;
                }
                assert!(periods < 5000, "{name}, jerk {jerk}: it stands nowhere");
            }
            // The blend of the corner begins before the end of the code.
            let code = (0..count).map(|n| (place(n), place(n + 1)));
            let end: f64 = code.map(|(a, b)| (b.0 - a.0).hypot(b.1 - a.1)).sum();
            assert!(end - 0.1 < way && way < end, "{name}, jerk {jerk}: {way} of {end}");
        }
    }
}

/// A hold in the middle of a rapid move stops there, and one of feeds does not.
#[test]
fn only_its_own_override_stops_a_move() {
    let machine = machine(1e5);
    let planner = planned(&machine, Mode::Blend(0.1), &[(150.0, 0.0, true, 0.0)]);
    let track = planner.track();
    let mut follower = Follower::new(machine.period, Pose::ZERO);
    let mut run = |feed: f64, rapid: f64, cycles: u32| {
        let mut last = Pose::ZERO;
        for _ in 0..cycles {
            last = follower.step(track, Scales { feed, rapid }, false).pose;
        }
        last.0[0]
    };
    let at = run(0.0, 1.0, 300);
    assert!(at > 20.0, "{at}");
    let held = run(1.0, 0.0, 500);
    assert!(at < held && held < at + 30.0, "{at} {held}");
    assert_eq!(run(1.0, 0.0, 500), held);
    assert!((run(0.0, 1.0, 3000) - 150.0).abs() < 1e-9);
}

/// A blend between a rapid move and a feed keeps the lower of both speeds.
#[test]
fn a_blend_between_both_kinds_keeps_both_overrides() {
    let machine = machine(f64::INFINITY);
    // A wide blend of a small angle, so that only the programmed speeds limit it.
    let lines = [(60.0, 0.0, true, 0.0), (120.0, 5.0, false, FEED)];
    let planner = planned(&machine, Mode::Blend(1.0), &lines);
    let [mut both, mut all] = [0, 0];
    for cell in planner.track().cells() {
        let kinds = [cell.feed, cell.rapid].map(f64::is_finite);
        assert!(kinds[0] || kinds[1]);
        both += u32::from(kinds == [true, true]);
        all += 1;
    }
    assert!(0 < both && both < all, "{both} of {all}");
    for (feed, rapid, lower) in [(0.5, 1.0, 25.0), (1.0, 0.1, 20.0), (0.2, 0.01, 2.0)] {
        let mut follower = Follower::new(machine.period, Pose::ZERO);
        let (mut last, mut at, mut seen) = (0, Pose::ZERO, false);
        while !follower.is_done(planner.track()) {
            let step = follower.step(planner.track(), Scales { feed, rapid }, false);
            let (number, _) = follower.input(planner.track());
            let cell = planner.track().cell(number).unwrap();
            // The first period in a cell has a part in the one before.
            if number == last && cell.feed.is_finite() && cell.rapid.is_finite() {
                let way = step.pose - at;
                let speed = way.dot_all(&way).sqrt() / machine.period;
                assert!(speed <= lower * 1.01, "{feed} {rapid}: {speed} in the blend");
                seen = true;
            }
            (last, at) = (number, step.pose);
        }
        assert!(seen);
    }
}
