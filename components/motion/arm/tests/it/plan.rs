//! Paths: the place of a part, reach, configurations along a path.
#![expect(clippy::unwrap_used, clippy::indexing_slicing, reason = "tests")]

use hal_arm::{
    Arm, Cell, Frame, Joints, Kind, Misfit, Miss, Plan, Refused, Target,
    apt::Part,
    fit,
    rotation::{Vector, from_zyz, to_zyz},
    targets,
};
use std::collections::BTreeMap;

#[track_caller]
fn close(a: &[f64], b: &[f64], within: f64) {
    assert_eq!(a.len(), b.len());
    assert!(a.iter().zip(b).all(|(a, b)| (a - b).abs() <= within), "{a:?} is not {b:?}");
}

fn cell(tool: f64) -> Cell {
    Cell {
        arm: Arm::RX90,
        speed: [236.0, 200.0, 286.0, 401.0, 320.0, 580.0],
        tool: Frame { origin: Vector::new(0.0, 0.0, tool), ..Frame::identity() },
        present: [0.0, -90.0, 90.0, 0.0, 0.0, 0.0],
        back_off: None,
    }
}

fn vectors(list: &[[f64; 3]]) -> Vec<Vector> {
    list.iter().map(|p| Vector::from(*p)).collect()
}

fn first_place() -> Frame {
    let design = vectors(&[[0., 0., 0.], [200., 0., 0.], [0., 100., 0.]]);
    let touched = vectors(&[[500., -100., -100.], [673.2051, 0., -100.], [450., -13.3975, -100.]]);
    fit(&design, &touched).unwrap().frame
}

#[test]
fn touched_points_place_the_part() {
    close(
        first_place().point(&Vector::new(100., 50., 100.)).as_slice(),
        &[561.6025, -6.6987, 0.],
        1e-4,
    );
    let design = vectors(&[[10., 20., 5.], [110., 20., 5.], [50., 80., 5.]]);
    let touched = vectors(&[
        [603.3418, 122.6674, -49.8576],
        [692.1676, 153.8999, -83.54],
        [617.8068, 191.2278, -66.894],
    ]);
    let found = fit(&design, &touched).unwrap();
    close(&to_zyz(&found.frame.turn), &[30., 20., -10.], 1e-3);
    let point = found.frame.point(&Vector::new(70., 50., 25.));
    close(point.as_slice(), &[652.0286, 172.8608, -53.0549], 1e-3);
    close(found.frame.turn.column(2).as_slice(), &[0.296_198, 0.171_009, 0.939_693], 1e-5);
    assert!(found.largest() < 1e-4 && found.differences.is_empty());
}

#[test]
fn points_that_do_not_match_are_refused() {
    let design = vectors(&[[0., 0., 0.], [200., 0., 0.], [0., 100., 0.], [200., 100., 30.]]);
    let frame = Frame { origin: Vector::new(500., -80., 20.), turn: from_zyz([40., 30., -20.]) };
    let touched: Vec<Vector> = design.iter().map(|p| frame.point(p)).collect();
    let exact = fit(&design, &touched).unwrap();
    assert!((exact.frame.turn - frame.turn).amax() < 1e-12 && exact.rms() < 1e-9);
    // One point 0.8 mm off: reported, shared among the points.
    let mut off = touched.clone();
    off[1] += frame.turn.column(0) * 0.8;
    let found = fit(&design, &off).unwrap();
    assert!(found.largest() > 0.1 && found.largest() < 0.8, "{:?}", found.residuals);
    assert_eq!(
        found.differences.iter().filter(|d| d.0 == 2 || d.1 == 2).count(),
        found.differences.len()
    );
    let mut far = touched.clone();
    far[1] += frame.turn.column(0) * 8.0;
    assert!(
        matches!(fit(&design, &far), Err(Misfit::Mismatched(1, 2, by)) if (by - 8.0).abs() < 1e-9)
    );
    let line = vectors(&[[0., 0., 0.], [100., 0.5, 0.], [200., 0., 0.]]);
    let plane = vectors(&[[0., 0., 0.], [100., 0., 0.], [0., 100., 0.]]);
    assert_eq!(fit(&line, &plane), Err(Misfit::Collinear(false)));
    assert_eq!(fit(&plane, &line), Err(Misfit::Collinear(true)));
    let one = vec![Vector::zeros(); 3];
    assert_eq!(fit(&one, &one), Err(Misfit::Collinear(false)));
    assert_eq!(fit(&plane, &plane[..2]), Err(Misfit::Unequal(3, 2)));
    assert_eq!(fit(&plane[..2], &plane[..2]), Err(Misfit::Count(2)));
    let nan = vectors(&[[0., 0., f64::NAN], [100., 0., 0.], [0., 100., 0.]]);
    assert_eq!(fit(&nan, &plane), Err(Misfit::NoNumber));
    // A mirrored set of four points has the same distances, and no rotation.
    let mirrored: Vec<Vector> = design.iter().map(|p| Vector::new(p.x, p.y, -p.z)).collect();
    assert!(matches!(fit(&design, &mirrored), Err(Misfit::Residual(..))));
}

const JOB: &str =
    "FROM/0,0,100\nGOTO/20,20,0\nGOTO/180,20,0\nGODLTA/0,60,0\nGOTO/20,80,0\nGOTO/20,20,0\nFINI\n";

#[test]
fn a_job_runs_in_one_configuration() {
    let part = Part::parse(JOB.as_bytes()).unwrap();
    let targets = targets(&part.points, &first_place(), 100.0, 10.0);
    assert_eq!(targets.len(), 8);
    for t in &targets {
        close(&to_zyz(&t.tip.turn).map(|a| a.rem_euclid(360.0)), &[0., 180., 180.], 1e-6);
    }
    let plan = cell(275.0).plan(&targets).unwrap();
    assert!(plan.changes.is_empty());
    assert!(plan.steps.iter().all(|s| s.configuration == 0), "{:?}", plan.steps[0]);
    let at = |target: usize| {
        let step = plan.steps.iter().find(|s| s.target == target && s.is_target).unwrap();
        (step.tip.origin, step.joints)
    };
    let (tip, joints) = at(2);
    close(tip.as_slice(), &[507.3205, -72.6795, -100.], 1e-4);
    close(&joints, &[-8.1528, -77.217, 190.635, 0., 66.5819, 171.8472], 1e-4);
    let (tip, joints) = at(3);
    close(tip.as_slice(), &[645.8846, 7.3205, -100.], 1e-4);
    close(&joints, &[0.6494, -61.2426, 168.6333, 0., 72.6093, 180.6494], 1e-4);
    close(&[4, 5, 6].map(|n| at(n).1[5]), &[185.4981, 177.5147, 171.8472], 1e-4);
    close(at(0).0.as_slice(), at(1).0.as_slice(), 100.0 + 1e-9);
    every_step_is_near(&cell(275.0), &targets, &plan);
}

/// Asserts that each step reaches its tip, within its limits, near the step before, and at no more than the highest speed.
fn every_step_is_near(cell: &Cell, targets: &[Target], plan: &Plan) {
    for step in &plan.steps {
        let tip = cell.arm.flange(&step.joints).then(&cell.tool);
        assert!((tip.origin - step.tip.origin).amax() < 1e-6, "{step:?}");
        assert!((tip.turn - step.tip.turn).amax() < 1e-9, "{step:?}");
        assert!(cell.arm.margin(&step.joints).1 >= 0.0, "{step:?}");
    }
    let mut turned = 0;
    for pair in plan.steps.windows(2) {
        let [a, b] = pair else { continue };
        let way = a.joints.iter().zip(&b.joints).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        let length = (a.tip.origin - b.tip.origin).norm();
        if way > hal_arm::JUMP {
            assert!(b.kind == Kind::Change && length < 1e-9, "{a:?} {b:?}");
            turned += 1;
        }
        assert!(length <= 1.0 + 1e-9, "{a:?} {b:?}");
        let feed = targets[b.target].feed;
        let least = a.joints.iter().zip(&b.joints).zip(&cell.speed);
        let least = least.map(|((a, b), s)| (a - b).abs() / s).fold(0.0, f64::max);
        assert!(b.seconds >= least - 1e-12, "{b:?}");
        assert!(b.kind == Kind::Change || b.seconds >= length / feed - 1e-12, "{b:?}");
    }
    assert_eq!(turned, plan.changes.len());
}

#[test]
fn a_straight_wrist_is_crossed_without_a_jump() {
    let arm = Arm::RX90;
    let tip = |q: Joints| arm.flange(&q);
    let target =
        |q: Joints| Target { kind: Kind::Point, point: 1, line: 1, tip: tip(q), feed: 10.0 };
    let ends = [target([0., -60., 120., 0., 1., 0.]), target([0., -60., 120., 0., -1., 0.])];
    let cell = Cell { present: [0., -60., 120., 0., 0., 0.], ..cell(0.0) };
    let plan = cell.plan(&ends).unwrap();
    let (first, last) = (plan.steps.first().unwrap(), plan.steps.last().unwrap());
    assert_eq!((first.configuration, last.configuration), (0, 1));
    close(&last.joints, &[0., -60., 120., 0., -1., 0.], 1e-6);
    // In configuration 0 alone, joints 4 and 6 turn by half a turn.
    let alone = arm.solve(&tip([0., -60., 120., 0., -1., 0.]), 0, &first.joints).unwrap();
    close(&[(alone.joints[3] - first.joints[3]).abs()], &[180.0], 1e-6);
}

/// Part of 2,400 points on half a circle about the base: joint 1 reaches one end in front and the other at the back only.
fn half_circle() -> String {
    let mut text = String::from("PARTNO RING\nFEDRAT/6000,MMPM\n");
    for n in 0..2400 {
        let (s, c) = (f64::from(n) * 180.0 / 2399.0).to_radians().sin_cos();
        let z = f64::from(n % 7);
        text.push_str(&format!("GOTO/{:.6},{:.6},{z:.6}\n", 500.0 * c, 500.0 * s));
    }
    text.push_str("FINI\n");
    text
}

#[test]
fn a_part_that_needs_a_change_of_configuration() {
    let part = Part::parse(half_circle().as_bytes()).unwrap();
    assert_eq!(part.points.len(), 2400);
    let place = Frame::identity();
    let all = targets(&part.points, &place, 100.0, 10.0);
    let still = cell(100.0);
    let Err(Refused::Changes(changes)) = still.plan(&all) else { panic!("{:?}", still.plan(&all)) };
    assert_eq!(changes.len(), 1);
    let moving = Cell { back_off: Some(60.0), ..still };
    let plan = moving.plan(&all).unwrap();
    assert_eq!(plan.changes.len(), 1);
    assert!(plan.changes[0].from < 4 && plan.changes[0].to >= 4, "{:?}", plan.changes);
    every_step_is_near(&moving, &all, &plan);
    let done = plan.steps.iter().filter(|s| s.kind == Kind::Point && s.is_target);
    let mut numbers: Vec<usize> = done.map(|s| all[s.target].point).collect();
    numbers.dedup();
    assert_eq!(numbers, (1..=2400).collect::<Vec<_>>(), "every point, once");
}

#[test]
fn refusals_name_the_first_failure_of_each_configuration() {
    let text = "FROM/800,0,-300\nGOTO/800,0,-560\nGOTO/900,0,-300\nFINI\n";
    let part = Part::parse(text.as_bytes()).unwrap();
    let all = targets(&part.points, &Frame::identity(), 0.0, 10.0);
    let Err(Refused::Unreached(failures)) = cell(275.0).plan(&all) else { panic!() };
    assert_eq!(failures.len(), 8);
    let texts: Vec<String> = failures.iter().map(|f| f.why.to_string()).collect();
    assert!(failures.iter().all(|f| f.target <= 3) && texts.len() == 8, "{texts:?}");
    let verdicts = cell(275.0).judge(&all[3].tip);
    for v in verdicts {
        assert_eq!(v.unwrap_err().to_string(), "out of reach by 2.00");
    }
    assert_eq!(cell(275.0).judge(&all[2].tip)[2].unwrap_err().to_string(), "J2 37.65 > 35");
    assert!(matches!(cell(0.0).plan(&[]), Err(Refused::Empty)));
    let far = "FROM/500,0,0\nGOTO/1000000,0,0\nFINI\n";
    let part = Part::parse(far.as_bytes()).unwrap();
    let all = targets(&part.points, &Frame::identity(), 0.0, 10.0);
    assert!(matches!(cell(275.0).plan(&all), Err(Refused::TooLong)));
}

/// The verdicts for a tool that points down, beside a search of joints 2 and 3 in steps of half a degree by forward
/// kinematics alone.
#[test]
fn verdicts_are_those_of_a_search_of_all_joints() {
    let cell = cell(275.0);
    let mut tips: BTreeMap<(i64, i64), Vec<(f64, f64)>> = BTreeMap::new();
    #[expect(clippy::cast_possible_truncation, reason = "a few hundred")]
    let bucket = |x: f64, z: f64| ((x / 10.0).floor() as i64, (z / 10.0).floor() as i64);
    for second in -400..=70 {
        for third in -105..=465 {
            let (second, third) = (f64::from(second) / 2.0, f64::from(third) / 2.0);
            let bend = libm::remainder(180.0 - second - third, 360.0);
            let straight = (-105.0..=120.0).contains(&bend);
            let flipped = (-105.0..=120.0).contains(&-bend);
            if straight || flipped {
                let joints = [0.0, second, third, 0.0, bend, 0.0];
                let tip = cell.arm.flange(&joints).then(&cell.tool);
                assert!(tip.turn.column(2).z < -1.0 + 1e-9);
                let (x, z) = (tip.origin.x, tip.origin.z);
                tips.entry(bucket(x, z)).or_default().push((x, z));
            }
        }
    }
    let (mut inside, mut outside) = (0, 0);
    for x in -50..=50 {
        for z in -50..=50 {
            let (x, z) = (20.0 * f64::from(x) + 3.0, 20.0 * f64::from(z) + 1.0);
            let turn = from_zyz([0.0, 180.0, 180.0]);
            let verdicts = cell.judge(&Frame { origin: Vector::new(x, 0.0, z), turn });
            let (i, j) = bucket(x, z);
            let around = (i - 1..=i + 1).flat_map(|i| (j - 1..=j + 1).map(move |j| (i, j)));
            let near = around.filter_map(|b| tips.get(&b)).flatten();
            let nearest = near.map(|t| (t.0 - x).hypot(t.1 - z)).fold(f64::INFINITY, f64::min);
            // How far a verdict is from the other one: degrees at the length of the arm.
            let margin = verdicts.iter().map(|v| match v {
                Ok((_, margin)) => *margin,
                Err(Miss::Reach { by }) => -by / 10.0,
                Err(Miss::Limit { angle, limit, .. }) => -(angle - limit).abs(),
            });
            let margin = margin.fold(f64::NEG_INFINITY, f64::max);
            if margin >= 0.0 {
                assert!(nearest < 8.0, "{x} {z}: reached by {margin}, nearest {nearest}");
                inside += 1;
            } else {
                assert!(nearest > 2.0 || margin > -1.0, "{x} {z}: {margin} {nearest}");
                outside += 1;
            }
        }
    }
    assert!(inside > 500 && outside > 500, "{inside} {outside}");
}
