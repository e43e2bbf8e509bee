//! Planner and follower in two threads: little room, a planner that stops for seconds, and reverse motion in between.

#![expect(clippy::print_stdout, clippy::unwrap_used, reason = "tests")]

use crate::judge;

use hal_corpus::{Mode, Rng};
use hal_trajectory::{
    AXES, Error, Follower, Limits, Machine, Move, Path, Planner, Pose, Shape, Spline, Trivial,
    share,
};
use hal_watchman::{Limits as WatchLimits, Watchman};
use judge::{Case, case, convert};

fn watchman(c: &Case) -> Watchman<AXES> {
    let limits = c.machine.axes.map(|l| WatchLimits {
        velocity: l.velocity,
        acceleration: l.acceleration,
        jerk: l.jerk,
    });
    let mut watch = Watchman::new(limits, c.machine.period, c.program.size());
    watch.rest_at(&c.program.start);
    watch
}

/// Planning steps happen at random moments, with breaks of up to 5 s. Everything is a function of the seed.
#[test]
fn a_planner_that_stops_for_seconds_causes_an_ordinary_stop() {
    for seed in 0..40 {
        // Trivial kinematics, in seeds that are not a crawl.
        let c = case(seed * 77 + seed % 7, 40);
        if c.program
            .steps
            .iter()
            .any(|s| s.feed < 5.0 || matches!(s.mode, Mode::Blend(p) if p > 10.0))
        {
            continue;
        }
        let (moves, _) = convert(&c.program, &c.machine);
        let start = Pose(c.program.start);
        let mut planner = Planner::new(c.machine, c.robot, start).unwrap();
        let (mut publisher, reader) = share(48, 16);
        let mut follower = Follower::new(c.machine.period, start);
        let mut watch = watchman(&c);
        let mut rng = Rng::new(seed);
        let mut moves = moves.iter().peekable();
        let (mut pause, mut stops, mut last, mut idle) = (0, 0, true, 0);
        let (mut end, mut done) = (start, false);
        let (mut scale, mut reverse) = (1.0, false);
        for cycle in 0..400_000_u64 {
            if pause > 0 {
                pause -= 1;
            } else {
                if rng.chance(0.02) {
                    pause = rng.below(5000);
                }
                for _ in 0..rng.below(4) {
                    let Some(m) = moves.peek() else { break };
                    match m.push(&mut planner) {
                        Ok(()) => {}
                        Err(Error::Full) => break,
                        Err(e) => panic!("{e}"),
                    }
                    moves.next();
                }
                if moves.peek().is_none() && !done {
                    planner.finish();
                    done = true;
                }
                publisher.publish(&mut planner);
            }
            if cycle < 50_000 && rng.chance(0.003) {
                scale = rng.pick(&[0.0, 0.3, 1.0, 1.0, 1.5], 1.0);
                reverse = rng.chance(0.2);
            }
            if cycle >= 50_000 {
                (scale, reverse) = (1.0, false);
            }
            let step = follower.step(&reader, scale, reverse);
            assert!(watch.step(&step.pose.0, step.line), "seed {seed}: {:?}", watch.report());
            stops += usize::from(last && !step.moving);
            last = step.moving;
            idle = if step.moving { 0 } else { idle + 1 };
            end = step.pose;
            if done && idle > 6000 && cycle > 50_000 {
                break;
            }
        }
        let by = end - *planner.position();
        assert!(by.dot_all(&by).sqrt() < 1e-9, "seed {seed}: {by:?} left after {stops} stops");
        assert!(publisher.memory() < 1 << 20);
    }
}

/// A line of eight seconds, published up to its blend with the next one, which waits: at every moment the time ahead is no
/// longer than the follower then goes on without braking, and shorter by the reserve for the filter and little else.
#[test]
fn the_time_ahead_counts_a_long_line_up_to_its_braking_point() {
    // Under a limit of jerk, the blend is published once a third line is known.
    for (jerk, blend, count) in [(f64::INFINITY, 0.002, 2), (1e5, 0.1, 3), (1e4, 2.0, 3)] {
        let limits = Limits { velocity: 200.0, acceleration: 1750.0, jerk };
        let machine = Machine { max_override: 1.2, ..Machine::uniform(limits) };
        let period = machine.period;
        let mut planner = Planner::new(machine, Trivial, Pose::ZERO).unwrap();
        let (mut publisher, reader) = share(64, 16);
        // Nearly straight, so that the follower first brakes for the end of what is published.
        let ends = [[400.0, 0.0, 0.0], [800.0, 16.0, 0.0], [1200.0, 0.0, 0.0]];
        for (line, end) in (1..).zip(ends).take(count) {
            let shape = Shape::Line { end: Pose::from_xyz(end) };
            let mode = hal_trajectory::Mode::Blend(blend);
            planner.push(&Move { shape, feed: 50.0, rapid: false, mode, line }).unwrap();
        }
        publisher.publish(&mut planner);
        let mut follower = Follower::new(period, Pose::ZERO);
        let mut told = Vec::new();
        let mut highest = 0.0;
        while follower.speed() >= 0.99 * highest {
            highest = follower.speed().max(highest);
            told.push(publisher.time_ahead(follower.input(&reader), period, 1e9));
            follower.step(&reader, machine.max_override, false);
            assert!(told.len() < 20_000, "it never brakes");
        }
        let filter = (0..).map_while(|k| reader.cell(k)).map(|c| c.samples).max().unwrap();
        let reserve = 3.0 * period * f64::from(filter);
        let mut left = 0.0;
        for told in told.iter().rev() {
            left += period;
            assert!(*told <= left, "jerk {jerk}: {told} s promised, {left} s come");
            // It accelerates for less than 0.1 s beyond what the filter takes.
            assert!(*told + reserve > left - reserve - 0.1, "jerk {jerk}: {told} s of {left} s");
        }
        assert!(left > 6.0 && told[0] > 6.0, "{left} s, {} s", told[0]);
        assert!(publisher.time_ahead((0, 0.0), period, 0.5) >= 0.5, "counted as far as asked");
    }
}

/// Two threads that run as they like: the motion is inside its limits and reaches the end.
#[test]
fn two_threads_agree() {
    let c = case(7 * 22, 60);
    let (moves, _) = convert(&c.program, &c.machine);
    let mut planner = Planner::new(c.machine, c.robot, Pose::ZERO).unwrap();
    let (mut publisher, reader) = share(32, 4);
    let mut watch = watchman(&c);
    let mut follower = Follower::new(c.machine.period, Pose::ZERO);
    let target = Pose(*c.program.poses().last().unwrap());
    std::thread::scope(|scope| {
        let follow = scope.spawn(move || {
            let mut end = Pose::ZERO;
            for _ in 0..50_000_000_u64 {
                let step = follower.step(&reader, 1.0, false);
                assert!(watch.step(&step.pose.0, step.line), "{:?}", watch.report());
                end = step.pose;
                let by = end - target;
                if !step.moving && by.dot_all(&by).sqrt() < 1e-9 {
                    break;
                }
                if !step.moving {
                    std::thread::yield_now();
                }
            }
            end
        });
        for m in &moves {
            while m.push(&mut planner) == Err(Error::Full) {
                publisher.publish(&mut planner);
            }
            publisher.publish(&mut planner);
        }
        planner.finish();
        while !follow.is_finished() {
            publisher.publish(&mut planner);
            std::thread::yield_now();
        }
        let by = follow.join().unwrap() - target;
        assert!(by.dot_all(&by).sqrt() < 1e-9);
    });
}

/// A full hand-over of 16,384 cells, the planner and the follower fit in 16 MB, with the worst programs.
#[test]
fn no_program_takes_more_than_16_megabytes() {
    let mut most = 0;
    for kind in 0..5 {
        for jerk in [1e5, 1e4, f64::INFINITY] {
            let limits = Limits { velocity: 200.0, acceleration: 1750.0, jerk };
            let machine = Machine::uniform(limits);
            let mut planner = Planner::new(machine, Trivial, Pose::ZERO).unwrap();
            let (mut publisher, reader) = share(16_384, 1000);
            let mut rng = Rng::new(kind);
            let (mut refused, mut own) = (0, 0);
            for line in 0..100_000 {
                let done = match kind {
                    // Specks, splines, helices of many turns, dense code, corners.
                    0 => planner.push(&short(line, 2e-6, 1.0)),
                    1 => planner.push_spline(&waves(planner.position()), 100.0, SOFT, line),
                    2 => planner.push(&helix(line, planner.position())),
                    3 => planner.push(&short(line, 0.1, 0.1)),
                    _ => planner.push(&short(line, 0.5, rng.between(1.0, 2.0))),
                };
                publisher.publish(&mut planner);
                most = most.max(publisher.memory() + planner.memory());
                own = own.max(planner.memory());
                match done {
                    // The follower goes on a little each time that the planner waits for it.
                    Err(Error::Full) if refused < 20 => {
                        refused += 1;
                        reader.release(planner.track().oldest().saturating_sub(16_000));
                    }
                    Err(Error::Full) => break,
                    Err(e) => panic!("{kind} {line} {e:?}"),
                    Ok(()) => {}
                }
            }
            println!("kind {kind}, jerk {jerk}: hand-over {}, planner {own}", publisher.memory());
        }
    }
    // The ring of the follower has 2000 numbers.
    most += 2000 * 8;
    println!("{most} bytes");
    assert!(most <= 16_000_000, "{most}");
}

const SOFT: hal_trajectory::Mode = hal_trajectory::Mode::Blend(0.01);

/// Line number `line` of a path that turns by an angle, in all axes.
fn short(line: u32, length: f64, angle: f64) -> Move {
    let (sin, cos) = libm::sincos(angle * f64::from(line));
    let mut end = Pose([length * f64::from(line % 5); AXES]);
    end.0[0] = length / angle * sin;
    end.0[1] = length / angle * cos;
    Move { shape: Shape::Line { end }, feed: 100.0, rapid: false, mode: SOFT, line }
}

fn helix(line: u32, at: &Pose) -> Move {
    let mut end = *at;
    end.0[2] += 5.0;
    let center = [at.0[0] + 3.0, at.0[1], at.0[2]];
    let shape = Shape::Arc { end, center, normal: [0.0, 0.0, 1.0], turns: 500 };
    Move { shape, feed: 100.0, rapid: false, mode: SOFT, line }
}

fn waves(at: &Pose) -> Spline {
    let point = |k: u32| {
        let mut p = *at;
        p.0[0] += 0.3 * f64::from(k);
        p.0[1] += libm::sin(0.5 * f64::from(k));
        p
    };
    Spline::cubic(&(0..1000).map(point).collect::<Vec<_>>()).unwrap()
}
