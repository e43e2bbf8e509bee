//! The pursuer: every limit on chains of lines and blends, after places of any speed, and its lead-in against its closed form.

use hal_corpus::Rng;
use hal_trajectory::{
    Aim, JOINTS, Joints, Kinematics, Limits, Machine, Mode, Move, Planner, Pose, Pursuer, Pursuit,
    Shape, Trivial,
};
use hal_watchman::{Limits as WatchLimits, Watchman};

const H: f64 = 1e-3;

/// Returns limits of random size.
fn limits(rng: &mut Rng) -> Limits {
    Limits {
        velocity: rng.log(5.0, 300.0),
        acceleration: rng.log(50.0, 5000.0),
        jerk: rng.pick(&[f64::INFINITY, 3e5, 1e5, 5e4, 1e4], 1e5),
    }
}

#[test]
fn chains_keep_every_limit_after_any_place() {
    let (mut reached, mut worst) = (0, 0.0_f64);
    for seed in 0..150 {
        let mut rng = Rng::new(seed);
        let limits = limits(&mut rng);
        let machine = Machine::uniform(limits);
        let mut planner = Planner::new(machine, Trivial, Pose::ZERO).unwrap();
        let mut end = [0.0; 3];
        let mut length = 0.0;
        let count = rng.pick(&[1, 2, 5, 12], 2);
        for line in 1..=count {
            let from = end;
            let turn = rng.between(0.0, 1.2);
            end[0] += rng.between(2.0, 15.0);
            end[1] += turn * rng.between(-5.0, 5.0);
            let by = [0, 1, 2].map(|n: usize| end.get(n).unwrap() - from.get(n).unwrap());
            length += by.iter().map(|d| d * d).sum::<f64>().sqrt();
            let shape = Shape::Line { end: Pose::from_xyz(end) };
            let mode = if rng.chance(0.2) { Mode::ExactStop } else { Mode::Blend(0.1) };
            planner.push(&Move { shape, feed: f64::INFINITY, rapid: false, mode, line }).unwrap();
        }
        planner.finish();
        let jerks = Some([limits.jerk; 9]).filter(|_| rng.chance(0.7));
        let mut pursuer = Pursuer::new(H, Pose::ZERO, jerks, f64::INFINITY);
        let watched = WatchLimits {
            velocity: limits.velocity,
            acceleration: limits.acceleration,
            jerk: limits.jerk,
        };
        let mut watch = Watchman::new([watched; 3], H, 200.0);
        watch.rest_at(&[0.0; 3]);
        // A thread that is faster than one of its corners allows loses its spindle there in any case.
        let slowest = planner.track().cells().map(|cell| cell.speed).fold(f64::INFINITY, f64::min);
        let most = if count == 1 { 1.2 * limits.velocity } else { 0.9 * slowest };
        let (mut place, mut at, mut speed) = (0.0, 0.0, 0.5 * most);
        let (is_both, is_calm) = (count == 1 && rng.chance(0.5), rng.chance(0.3));
        let mut rests = false;
        for n in 0..400_000 {
            if !is_calm && n < 8_000 && rng.chance(0.01) {
                speed = rng.between(-0.3, 1.0) * most;
                rests = rng.chance(0.1);
            }
            if n == 8_000 {
                (speed, rests) = (0.5 * most, false);
            }
            place += speed * H;
            let aim = Aim { distance: place - at, speed };
            let goal = match (rests, is_both && n < 8_000) {
                (true, _) => Pursuit::Rest,
                (false, true) => Pursuit::Both(aim),
                (false, false) => Pursuit::Forward(aim),
            };
            let step = pursuer.step(planner.track(), goal);
            at += step.travel;
            let [x, y, z, ..] = step.pose.0;
            let is_kept = watch.step(&[x, y, z], step.line);
            assert!(is_kept, "seed {seed}, period {n}, {limits:?}: {:?}", watch.report());
            if pursuer.is_done(planner.track()) && n > 8_000 {
                let off = (step.pose - Pose::from_xyz(end)).0;
                assert!(off.iter().all(|d| d.abs() < 1e-9), "seed {seed}: {off:?}");
                assert!(at <= length + 1e-6);
                reached += 1;
                break;
            }
        }
        worst = worst.max(watch.report().jerk.ratio);
    }
    assert!(reached == 150, "{reached} of 150 came to the end");
    assert!(worst > 0.99, "{worst}");
}

/// A place is caught within the lead-in, and the end needs no more than the run-out.
#[test]
fn lead_in_and_run_out_are_those_of_the_closed_form() {
    for seed in 0..400 {
        let mut rng = Rng::new(seed);
        let limits = limits(&mut rng);
        let speed = limits.velocity * rng.between(0.05, 0.95);
        let (lead_in, run_out) = (limits.lead_in(speed, H), limits.run_out(speed, H));
        let length = 1.5 * lead_in + run_out + 10.0;
        let mut planner = Planner::new(Machine::uniform(limits), Trivial, Pose::ZERO).unwrap();
        let shape = Shape::Line { end: Pose::from_xyz([length, 0.0, 0.0]) };
        let mode = Mode::ExactStop;
        planner.push(&Move { shape, feed: f64::INFINITY, rapid: false, mode, line: 1 }).unwrap();
        planner.finish();
        let mut pursuer = Pursuer::new(H, Pose::ZERO, Some([limits.jerk; 9]), f64::INFINITY);
        let (mut place, mut at) = (0.0, 0.0);
        let mut caught = None;
        let mut lost = None;
        while lost.is_none() {
            place += speed * H;
            let aim = Aim { distance: place - at, speed };
            at += pursuer.step(planner.track(), Pursuit::Forward(aim)).travel;
            if (place - at).abs() > 1e-3 * speed * H {
                if caught.is_some() && place > lead_in {
                    lost = Some(place);
                } else {
                    caught = None;
                }
            } else {
                caught.get_or_insert(place);
            }
        }
        let (caught, lost) = (caught.expect("caught"), lost.expect("lost"));
        assert!(caught <= lead_in, "{seed} {limits:?} {speed}: {caught} of {lead_in}");
        let excess = lead_in - caught;
        assert!(excess <= 0.35 * lead_in + 12.0 * speed * H, "{seed}: {caught} of {lead_in}");
        let needed = length - lost;
        assert!(needed <= run_out, "{seed} {limits:?} {speed}: {needed} of {run_out}");
    }
}

/// A linear delta: three towers at radius 120 with rods of 150. Joints follow no axis, and lines are curves for them.
#[derive(Clone)]
struct Delta;

impl Kinematics for Delta {
    fn inverse(&self, pose: &Pose) -> Result<Joints, usize> {
        let [x, y, z, ..] = pose.0;
        let mut joints = [0.0; JOINTS];
        let towers = [(0.0, 120.0), (-103.923, -60.0), (103.923, -60.0)];
        for (n, (joint, (at_x, at_y))) in joints.iter_mut().zip(towers).enumerate() {
            let rest = 150.0 * 150.0 - (x - at_x).powi(2) - (y - at_y).powi(2);
            if rest < 1.0 {
                return Err(n);
            }
            *joint = z + rest.sqrt();
        }
        Ok(joints)
    }

    fn axes_of_joints(&self) -> Option<[Option<usize>; JOINTS]> {
        None
    }
}

/// A line is straight only for joints that follow the axes: others keep their limits along it too.
#[test]
fn lines_that_joints_bend_keep_the_limits_of_the_joints() {
    let mut worst = 0.0_f64;
    for seed in 0..40 {
        let mut rng = Rng::new(seed);
        let limits = limits(&mut rng);
        let mut machine = Machine::uniform(Limits::NONE);
        machine.joints.iter_mut().take(3).for_each(|joint| *joint = limits);
        let place = |x: f64, y: f64| Pose::from_xyz([x, y, 0.0]);
        let [from, end] =
            [place(-20.0, rng.between(-15.0, 15.0)), place(20.0, rng.between(-15.0, 15.0))];
        let mut planner = Planner::new(machine, Delta, from).unwrap();
        let (shape, mode) = (Shape::Line { end }, Mode::ExactStop);
        planner.push(&Move { shape, feed: f64::INFINITY, rapid: false, mode, line: 1 }).unwrap();
        planner.finish();
        let mut pursuer = Pursuer::new(H, from, None, f64::INFINITY);
        let Limits { velocity, acceleration, jerk } = limits;
        let mut watch = Watchman::new([WatchLimits { velocity, acceleration, jerk }; 3], H, 200.0);
        let joints = |pose: &Pose| -> [f64; 3] {
            Delta.inverse(pose).unwrap().first_chunk().copied().unwrap()
        };
        watch.rest_at(&joints(&from));
        let slowest = planner.track().cells().map(|cell| cell.speed).fold(f64::INFINITY, f64::min);
        let (mut target, mut at, mut speed) = (0.0, 0.0, 0.5 * slowest);
        for n in 0..200_000 {
            if n < 8_000 && rng.chance(0.02) {
                speed = rng.between(-0.3, 1.2) * slowest;
            }
            if n == 8_000 {
                speed = 0.5 * slowest;
            }
            target += speed * H;
            let aim = Aim { distance: target - at, speed };
            let step = pursuer.step(planner.track(), Pursuit::Forward(aim));
            at += step.travel;
            let is_kept = watch.step(&joints(&step.pose), step.line);
            assert!(is_kept, "seed {seed}, period {n}, {limits:?}: {:?}", watch.report());
            if pursuer.is_done(planner.track()) && n > 8_000 {
                break;
            }
        }
        assert!(pursuer.is_done(planner.track()), "seed {seed}");
        worst = worst.max(watch.report().acceleration.ratio);
    }
    assert!(worst > 0.5, "{worst}");
}
