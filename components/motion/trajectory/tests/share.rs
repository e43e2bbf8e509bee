//! Planner and follower in two threads: little room, a planner that stops for seconds, and reverse motion in between.

mod judge;

use hal_corpus::{Mode, Rng};
use hal_trajectory::{AXES, Error, Follower, Planner, Pose, share};
use hal_watchman::{Limits, Watchman};
use judge::{Case, case, convert};

fn watchman(c: &Case) -> Watchman<AXES> {
    let limits = c.machine.axes.map(|l| Limits {
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
                    match planner.push(m) {
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
            while planner.push(m) == Err(Error::Full) {
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
