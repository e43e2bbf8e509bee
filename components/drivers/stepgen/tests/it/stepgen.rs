//! Tests of `stepgen`.

use hal_bench::Bench;
use rig::Rig;
use stepgen::Stepgen;

use crate::rig;

#[test]
fn items_by_type_and_control() {
    let rig = Rig::new(&["step_type=0,1,2,9", "ctrl_type=p,v,p,v"]);
    let expected = "\
        0.counts s32 OUT|0.dir bit OUT|0.dirhold u32 RW|0.dirsetup u32 RW|0.enable bit IN|\
        0.frequency float RO|0.maxaccel float RW|0.maxvel float RW|0.position-cmd float IN|\
        0.position-fb float OUT|0.position-scale float RW|0.rawcounts s32 RO|0.step bit OUT|\
        0.steplen u32 RW|0.stepspace u32 RW|\
        1.counts s32 OUT|1.dirdelay u32 RW|1.down bit OUT|1.enable bit IN|1.frequency float RO|\
        1.maxaccel float RW|1.maxvel float RW|1.position-fb float OUT|1.position-scale float RW|\
        1.rawcounts s32 RO|1.steplen u32 RW|1.stepspace u32 RW|1.up bit OUT|1.velocity-cmd float IN|\
        2.counts s32 OUT|2.dirdelay u32 RW|2.enable bit IN|2.frequency float RO|\
        2.maxaccel float RW|2.maxvel float RW|2.phase-A bit OUT|2.phase-B bit OUT|\
        2.position-cmd float IN|2.position-fb float OUT|2.position-scale float RW|\
        2.rawcounts s32 RO|2.steplen u32 RW|\
        3.counts s32 OUT|3.dirdelay u32 RW|3.enable bit IN|3.frequency float RO|\
        3.maxaccel float RW|3.maxvel float RW|3.phase-A bit OUT|3.phase-B bit OUT|\
        3.phase-C bit OUT|3.phase-D bit OUT|3.position-fb float OUT|3.position-scale float RW|\
        3.rawcounts s32 RO|3.steplen u32 RW|3.velocity-cmd float IN";
    let names: Vec<String> =
        rig.bench.names().iter().map(|n| n.strip_prefix("stepgen.").unwrap().to_owned()).collect();
    assert_eq!(names, expected.split('|').collect::<Vec<_>>());
    let functs = ["stepgen.capture-position", "stepgen.make-pulses", "stepgen.update-freq"];
    assert_eq!(rig.bench.functs(), functs);
    for name in ["0.steplen", "0.stepspace", "0.dirhold", "0.dirsetup", "1.dirdelay"] {
        assert_eq!(rig.get::<u32>(name), 1, "{name}");
    }
    assert_eq!(rig.get::<f64>("0.position-scale"), 1.0);
}

#[test]
fn refused_arguments() {
    for (args, why) in [
        (&["step_type=-1"][..], "STEPGEN: ERROR: no channels configured"),
        (&["step_type=99"], "`99' out of range for parameter `step_type=99'"),
        (&["step_type=0,2,16"], "`16' out of range for parameter `step_type=0,2,16'"),
        (&["step_type=0,-2"], "`-2' out of range for parameter `step_type=0,-2'"),
        (
            &["step_type=0,0,0", "ctrl_type=p,v,x"],
            "STEPGEN: ERROR: bad control type 'x' for axis 2 (must be 'p' or 'v')",
        ),
        (
            &["step_type=0", "user_step_type=1,32"],
            "`32' out of range for parameter `user_step_type=1,32'",
        ),
        (
            &["step_type=15", "user_step_type=1,-7"],
            "`-7' out of range for parameter `user_step_type=1,-7'",
        ),
    ] {
        assert_eq!(Bench::new().load::<Stepgen>(args).unwrap_err(), why, "{args:?}");
    }
    assert!(Bench::new().load::<Stepgen>(&[]).is_err());
}

#[test]
fn control_words_count_by_their_first_letter() {
    let rig = Rig::new(&["step_type=0,0,0,0,0", "ctrl_type=,Position,velocity,V"]);
    let names = rig.bench.names().join(" ");
    for (n, pin) in [
        (0, "position-cmd"),
        (1, "position-cmd"),
        (2, "velocity-cmd"),
        (3, "velocity-cmd"),
        (4, "position-cmd"),
    ] {
        assert!(names.contains(&format!("stepgen.{n}.{pin} ")), "{n}");
    }
}

/// Bits of the phases over one cycle, from the first state.
const CYCLES: [(usize, usize, &[u8]); 14] = [
    (2, 2, &[1, 3, 2, 0]),
    (3, 3, &[1, 2, 4]),
    (4, 3, &[1, 3, 2, 6, 4, 5]),
    (5, 4, &[1, 2, 4, 8]),
    (6, 4, &[3, 6, 12, 9]),
    (7, 4, &[1, 7, 14, 8]),
    (8, 4, &[5, 6, 10, 9]),
    (9, 4, &[1, 3, 2, 6, 4, 12, 8, 9]),
    (10, 4, &[1, 5, 7, 6, 14, 10, 8, 9]),
    (11, 5, &[1, 2, 4, 8, 16]),
    (12, 5, &[3, 6, 12, 24, 17]),
    (13, 5, &[1, 3, 2, 6, 4, 12, 8, 24, 16, 17]),
    (14, 5, &[3, 7, 6, 14, 12, 28, 24, 25, 17, 19]),
    (15, 3, &[1, 5, 4, 6, 0, 2]),
];

#[test]
fn phases_run_through_their_cycle_both_ways() {
    for (kind, phases, cycle) in CYCLES {
        let mut rig = Rig::new(&[
            &format!("step_type={kind}"),
            "ctrl_type=v",
            "user_step_type=1,5,4,6,0,2,-1,31",
        ]);
        let names = rig.bench.names().join(" ");
        assert_eq!(names.matches("phase-").count(), phases, "type {kind}");
        rig.enable(0, true);
        rig.tick();
        let state = |rig: &Rig| {
            let on =
                |n: usize| rig.get::<bool>(&format!("0.phase-{}", ["A", "B", "C", "D", "E"][n]));
            (0..phases).fold(0, |bits, n| bits | u8::from(on(n)) << n)
        };
        assert_eq!(state(&rig), cycle[0], "type {kind} before the first step");
        for speed in [2000.0, -2000.0] {
            rig.float("0.velocity-cmd", speed);
            rig.run(25);
            let mut at = rig.get::<i32>("0.rawcounts");
            for _ in 0..300 {
                rig.tick();
                let now = rig.get::<i32>("0.rawcounts");
                assert!(now == at || (now > at) == (speed > 0.0) && now.abs_diff(at) == 1);
                at = now;
                let place = usize::try_from(now.rem_euclid(i32::try_from(cycle.len()).unwrap()));
                assert_eq!(state(&rig), cycle[place.unwrap()], "type {kind} at {now}");
            }
        }
        assert!(rig.get::<i32>("0.rawcounts") < 10, "it went there and back");
    }
}

#[test]
fn pulses_of_step_and_direction() {
    let mut rig = Rig::new(&["step_type=0", "ctrl_type=v"]);
    rig.enable(0, true);
    rig.float("0.velocity-cmd", 2500.0);
    rig.run(20);
    let line = rig.trace("0.step", 24);
    assert!("#...".repeat(7).contains(&line), "every fourth period: {line}");
    assert!(!rig.trace("0.dir", 20).contains('#'));
    rig.float("0.velocity-cmd", -2500.0);
    rig.run(20);
    assert!(!rig.trace("0.dir", 20).contains('.'));
}

#[test]
fn up_and_down_pulse_on_their_own_pins() {
    let mut rig = Rig::new(&["step_type=1", "ctrl_type=v"]);
    rig.enable(0, true);
    rig.float("0.velocity-cmd", 1000.0);
    rig.run(1);
    let up = rig.trace("0.up", 40);
    assert_eq!((up.matches('#').count(), up.contains("##")), (4, false));
    assert!(!rig.trace("0.down", 20).contains('#'));
    rig.float("0.velocity-cmd", -1000.0);
    rig.run(20);
    assert!(!rig.trace("0.up", 20).contains('#'));
    assert_eq!(rig.trace("0.down", 40).matches('#').count(), 4);
}

/// Parameters as set, and after rounding with a base period of 100 µs.
#[test]
fn times_become_whole_periods() {
    for (kind, set, rounded) in [
        (0, [1, 1, 1, 1], [100_000, 100_000, 100_000, 100_000]),
        (0, [0, 0, 0, 0], [100_000, 0, 100_000, 0]),
        (0, [100_000, 100_001, 0, 5], [100_000, 200_000, 0, 100_000]),
        (0, [1, 0, 31_732, 31_732], [100_000, 0, 100_000, 100_000]),
        (0, [250_000, 0, 400_000, 0], [300_000, 0, 400_000, 0]),
        (0, [u32::MAX, 0, u32::MAX, 0], [4_294_900_000, 0, 4_294_900_000, 0]),
        (1, [0, 7, 0, 0], [100_000, 100_000, 100_000, 0]),
        (2, [0, 0, 0, 0], [100_000, 0, 0, 0]),
        (9, [1, 0, 150_000, 0], [100_000, 0, 200_000, 0]),
    ] {
        let mut rig = Rig::new(&[&format!("step_type={kind}")]);
        let names: &[&str] = match kind {
            0 => &["0.steplen", "0.stepspace", "0.dirhold", "0.dirsetup"],
            1 => &["0.steplen", "0.stepspace", "0.dirdelay"],
            _ => &["0.steplen", "", "0.dirdelay"],
        };
        for (name, ns) in names.iter().zip(set).filter(|(name, _)| !name.is_empty()) {
            rig.ns(name, ns);
        }
        rig.tick();
        for (name, ns) in names.iter().zip(rounded).filter(|(name, _)| !name.is_empty()) {
            assert_eq!(rig.get::<u32>(name), ns, "type {kind} {set:?} {name}");
        }
    }
}

#[test]
fn times_are_rounded_again_when_the_period_changes() {
    let mut rig = Rig::new(&["step_type=0"]);
    rig.bench.run("stepgen.update-freq", 1_000_000);
    assert_eq!(rig.get::<u32>("0.steplen"), 1, "the period is not known yet");
    rig.base_ns = 30_000;
    rig.tick();
    assert_eq!(rig.get::<u32>("0.steplen"), 30_000);
    rig.base_ns = 50_000;
    rig.run(10);
    assert_eq!(rig.get::<u32>("0.steplen"), 50_000);
}

/// A pulse lasts `steplen`, and at the maximum rate the gap is `stepspace`.
#[test]
fn fastest_pulses() {
    for (len, space, shape) in [
        (1, 1, "#.#.#.#.#.#."),
        (1, 0, "############"),
        (150_000, 1, "##.##.##.##."),
        (100_000, 300_000, "#...#...#..."),
        (300_000, 100_000, "###.###.###."),
    ] {
        let mut rig = Rig::new(&["step_type=0", "ctrl_type=v"]);
        rig.ns("0.steplen", len);
        rig.ns("0.stepspace", space);
        rig.enable(0, true);
        rig.float("0.velocity-cmd", 1e9);
        rig.run(40);
        let line = rig.trace("0.step", 40);
        let begin = line.find(".#").map_or(0, |at| at + 1);
        assert_eq!(&line[begin..begin + 12], shape, "{len} {space}");
        assert_eq!(rig.get::<u32>("0.steplen") % 100_000, 0);
    }
}

/// At a reversal, the direction changes `dirhold` after the last pulse, and the next pulse comes `dirsetup` after that;
/// the position waits meanwhile.
#[test]
fn reversals_wait() {
    for (hold, setup) in [(1, 1), (300_000, 1), (1, 300_000), (250_000, 450_000), (31_732, 31_732)]
    {
        let mut rig = Rig::new(&["step_type=0", "ctrl_type=v"]);
        rig.ns("0.dirhold", hold);
        rig.ns("0.dirsetup", setup);
        rig.enable(0, true);
        rig.float("0.velocity-cmd", 4900.0);
        rig.run(101);
        rig.float("0.velocity-cmd", -4900.0);
        let (mut step, mut dir) = (String::new(), String::new());
        for _ in 0..40 {
            rig.tick();
            step.push(if rig.get("0.step") { '#' } else { '.' });
            dir.push(if rig.get("0.dir") { '#' } else { '.' });
        }
        let periods = |ns: u32| usize::try_from(ns.div_ceil(100_000)).unwrap();
        let turned = dir.find('#').unwrap();
        let last = step[..turned].rfind('#').unwrap();
        let next = turned + step[turned..].find('#').unwrap();
        assert!(turned - (last + 1) >= periods(hold), "{hold} {setup}\n{step}\n{dir}");
        assert!(next - turned >= periods(setup), "{hold} {setup}\n{step}\n{dir}");
    }
}

#[test]
fn phases_wait_for_dirdelay() {
    let mut rig = Rig::new(&["step_type=2", "ctrl_type=v"]);
    rig.ns("0.dirdelay", 700_000);
    rig.enable(0, true);
    rig.float("0.velocity-cmd", 9000.0);
    rig.run(60);
    rig.float("0.velocity-cmd", -9000.0);
    let mut counts = Vec::new();
    for _ in 0..40 {
        rig.tick();
        counts.push(rig.get::<i32>("0.rawcounts"));
    }
    let top = *counts.iter().max().unwrap();
    let dwell = counts.iter().filter(|c| **c == top).count();
    assert!((8..=10).contains(&dwell), "steplen and dirdelay: {counts:?}");
}

#[test]
fn speed_mode_ramps_and_reports() {
    let mut rig = Rig::new(&["step_type=2", "ctrl_type=v"]);
    rig.float("0.position-scale", 10.0);
    rig.float("0.maxaccel", 1000.0);
    rig.float("0.velocity-cmd", 50.0);
    rig.enable(0, true);
    rig.run(11);
    // 1000 units/s² are 10 steps/s more per millisecond.
    assert_eq!(rig.get::<f64>("0.frequency"), 20.0);
    rig.run(480);
    assert_eq!(rig.get::<f64>("0.frequency"), 500.0);
    rig.run(10);
    let before: f64 = rig.get("0.position-fb");
    rig.run(1000);
    let moved = rig.get::<f64>("0.position-fb") - before;
    assert!((moved - 5.0).abs() < 1e-4, "{moved}");
    assert_eq!(rig.get::<i32>("0.counts"), rig.get::<i32>("0.rawcounts"));
    rig.float("0.maxvel", 20.0);
    rig.run(500);
    assert_eq!(rig.get::<f64>("0.frequency"), 200.0);
    rig.float("0.velocity-cmd", -1e300);
    rig.run(500);
    assert_eq!(rig.get::<f64>("0.frequency"), -200.0);
}

#[test]
fn position_mode_arrives_within_its_limits() {
    for (scale, speed, accel, to) in
        [(4.0, 90.0, 1350.0, 35.0), (-285.7, 10.0, 35.0, 3.0), (100.0, 0.0, 500.0, -2.0)]
    {
        let mut rig = Rig::new(&["step_type=0"]);
        rig.float("0.position-scale", scale);
        rig.float("0.maxvel", speed);
        rig.float("0.maxaccel", accel);
        rig.ns("0.stepspace", 0);
        rig.enable(0, true);
        rig.run(1);
        rig.float("0.position-cmd", to);
        let (mut last, mut far) = (0.0, 0.0_f64);
        for _ in 0..1500 {
            rig.run(10);
            let now = rig.get::<f64>("0.frequency") / scale;
            assert!(speed == 0.0 || now.abs() <= speed * (1.0 + 1e-12), "{now}");
            assert!((now - last).abs() <= accel * 1e-3 * (1.0 + 1e-9), "{last} to {now}");
            last = now;
            far = far.max(rig.get::<f64>("0.position-fb") / to);
        }
        let at: f64 = rig.get("0.position-fb");
        assert!((at - to).abs() < 0.01 / scale.abs(), "{at} instead of {to}");
        assert!(far < 1.0 + 1.0 / (to * scale).abs(), "overshoot to {far}");
        assert_eq!(f64::from(rig.get::<i32>("0.counts")), libm::round(to * scale));
    }
}

#[test]
fn position_mode_follows_a_moving_command() {
    let mut rig = Rig::new(&["step_type=0"]);
    rig.float("0.position-scale", 200.0);
    rig.float("0.maxaccel", 800.0);
    rig.enable(0, true);
    let mut off = 0.0_f64;
    for ms in 0..3000 {
        let t = f64::from(ms) * 1e-3;
        let to = 2.0 * (1.0 - libm::cos(5.0 * t));
        rig.float("0.position-cmd", to);
        rig.run(10);
        // The position read is one servo period old.
        off = off.max((rig.get::<f64>("0.position-fb") - to).abs());
    }
    assert!(off < 10.0 * 2.5e-3, "it lags at most two and a half periods at 10 units/s: {off}");
}

/// Returns an axis of the printer, at 100 µs and 1 ms.
fn printer(scale: f64, accel: f64) -> Rig {
    let rig = Rig::new(&["step_type=0"]);
    rig.float("0.position-scale", scale);
    rig.float("0.maxaccel", accel);
    rig.ns("0.stepspace", 0);
    rig.ns("0.dirhold", 31_732);
    rig.ns("0.dirsetup", 31_732);
    rig.enable(0, true);
    rig
}

#[test]
fn the_printers_x_makes_200_and_360_steps_a_second() {
    for (speed, hz) in [(50.0, 200), (-50.0, -200), (90.0, 360), (-90.0, -360)] {
        let mut rig = printer(4.0, 1500.0);
        let mut half = [0; 2];
        for ms in 0..2000 {
            rig.float("0.position-cmd", speed * 1e-3 * f64::from(ms));
            rig.run(10);
            half[usize::from(ms >= 1000)] = rig.get::<i32>("0.rawcounts");
        }
        assert_eq!(half[1] - half[0], hz, "X at {speed} mm/s");
        assert_eq!(rig.get::<bool>("0.dir"), speed < 0.0, "low to the right, high to the left");
    }
}

#[test]
fn the_printers_z_makes_a_step_every_350_us() {
    let mut rig = printer(285.714285714, 40.0);
    let (mut at, mut high, mut edges) = (0.0, false, Vec::new());
    for ms in 0..2000 {
        at += if ms < 400 { 0.01 * f64::from(ms) / 400.0 } else { 0.01 };
        rig.float("0.position-cmd", at);
        for tick in 0..10 {
            rig.tick();
            let step = rig.get::<bool>("0.step");
            if step && !high && ms >= 1000 {
                edges.push(ms * 10 + tick);
            }
            high = step;
        }
    }
    let gaps: Vec<i32> = edges.windows(2).map(|w| w[1] - w[0]).collect();
    assert!(gaps.iter().all(|g| *g == 3 || *g == 4), "300 or 400 µs");
    let mean = f64::from(edges[edges.len() - 1] - edges[0]) / gaps.len() as f64;
    assert!((mean - 3.5).abs() < 0.001, "350 µs in the mean, not {mean}");
}

#[test]
fn there_and_back_costs_no_step() {
    let mut rig = Rig::new(&["step_type=0"]);
    rig.float("0.position-scale", 285.714285714);
    rig.float("0.maxaccel", 40.0);
    rig.enable(0, true);
    for target in [5.0, -3.0, 0.0] {
        rig.float("0.position-cmd", target);
        rig.run(30_000);
    }
    assert_eq!((rig.get::<i32>("0.counts"), rig.get::<i32>("0.rawcounts")), (0, 0));
}

#[test]
fn switched_off_it_stands_still_at_once() {
    let mut rig = Rig::new(&["step_type=2,2", "ctrl_type=v,p"]);
    rig.float("0.maxaccel", 1000.0);
    rig.float("0.velocity-cmd", 1000.0);
    rig.float("1.position-cmd", 50.0);
    rig.enable(0, true);
    rig.enable(1, true);
    rig.run(5000);
    rig.enable(0, false);
    rig.enable(1, false);
    let at: (i32, i32) = (rig.get("0.rawcounts"), rig.get("1.rawcounts"));
    assert!(at.0 > 100 && at.1 == 50, "{at:?}");
    rig.float("1.position-cmd", 80.0);
    rig.run(1000);
    assert_eq!(at, (rig.get("0.rawcounts"), rig.get("1.rawcounts")));
    assert_eq!(rig.get::<f64>("0.frequency"), 0.0);
    // It starts from rest again, and position mode then moves to the command.
    rig.enable(0, true);
    rig.enable(1, true);
    rig.run(10);
    assert_eq!(rig.get::<f64>("0.frequency"), 1.0);
    rig.run(5000);
    assert_eq!(rig.get::<i32>("1.rawcounts"), 80);
}

#[test]
fn a_speed_that_cannot_be_is_said_once() {
    let mut rig = Rig::new(&["step_type=0,0"]);
    rig.enable(1, true);
    rig.float("1.position-scale", -4.0);
    rig.float("1.maxvel", 30_864.197_25);
    rig.run(20);
    assert_eq!(
        rig.bench.said(),
        [
            "STEPGEN: Channel 1: The requested maximum velocity of 123456 steps/sec is too high.",
            "STEPGEN: The maximum possible frequency is 5000 steps/second",
        ]
    );
    assert_eq!(rig.get::<f64>("1.maxvel"), 1250.0);
    rig.float("1.maxvel", 1e9);
    rig.run(20);
    assert_eq!(rig.get::<f64>("1.maxvel"), 1250.0);
    assert!(rig.bench.said().is_empty());
    rig.float("1.maxaccel", 1e12);
    rig.run(20);
    assert_eq!(rig.get::<f64>("1.maxaccel"), 1_250_000.0);
}

/// Invalid values are corrected, and their effects do not last.
#[test]
fn nonsense_does_no_harm() {
    let odd = [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, 1e308, -1e308, 5e-324, 0.0, -0.0];
    for mode in ["p", "v"] {
        for name in ["cmd", "position-scale", "maxvel", "maxaccel"] {
            for x in odd {
                let mut rig = Rig::new(&["step_type=2", &format!("ctrl_type={mode}")]);
                let command = if mode == "p" { "0.position-cmd" } else { "0.velocity-cmd" };
                let name = if name == "cmd" { command.to_owned() } else { format!("0.{name}") };
                rig.float(command, 100.0);
                rig.enable(0, true);
                rig.run(20);
                rig.float(&name, x);
                rig.run(200);
                assert!(rig.get::<f64>("0.frequency").is_finite(), "{mode} {name} {x}");
                assert!(!rig.get::<f64>("0.position-fb").is_nan(), "{mode} {name} {x}");
                rig.float("0.position-scale", 1.0);
                rig.float("0.maxvel", 0.0);
                rig.float("0.maxaccel", 0.0);
                let goal = if mode == "p" { rig.get::<f64>("0.position-fb") + 7.0 } else { 0.0 };
                rig.float(command, goal);
                rig.run(400);
                assert!(rig.get::<f64>("0.frequency").abs() < 0.1, "{mode} {name} {x}");
                let at: f64 = rig.get("0.position-fb");
                assert!(mode == "v" || (at - goal).abs() < 0.01, "{name} {x}: {at} not {goal}");
            }
        }
    }
}

#[test]
fn a_period_of_nothing_does_nothing() {
    let mut rig = Rig::new(&["step_type=0"]);
    rig.enable(0, true);
    rig.float("0.position-cmd", 1.0);
    rig.bench.run("stepgen.make-pulses", 0);
    rig.bench.run("stepgen.update-freq", 0);
    rig.run(200);
    assert_eq!(rig.get::<i32>("0.rawcounts"), 1);
}

#[test]
fn a_command_that_is_no_number_changes_nothing() {
    let mut rig = Rig::new(&["step_type=2,2", "ctrl_type=p,v"]);
    rig.enable(0, true);
    rig.enable(1, true);
    rig.float("0.position-cmd", 20.0);
    rig.run(500);
    rig.float("0.position-cmd", f64::NAN);
    rig.float("1.velocity-cmd", f64::NAN);
    rig.run(500);
    assert_eq!((rig.get::<i32>("0.counts"), rig.get::<i32>("1.counts")), (20, 0));
}

#[test]
fn parameters_are_put_right() {
    let mut rig = Rig::new(&["step_type=0"]);
    rig.enable(0, true);
    for (name, set, is) in [
        ("0.position-scale", 0.0, 1.0),
        ("0.position-scale", -1e-21, 1.0),
        ("0.position-scale", f64::NAN, 1.0),
        ("0.position-scale", -1e-19, -1e-19),
        ("0.position-scale", 3.0, 3.0),
        ("0.maxvel", -1.0, 0.0),
        ("0.maxvel", f64::NAN, 0.0),
        ("0.maxvel", 7.0, 7.0),
        ("0.maxaccel", -1.0, 0.0),
        ("0.maxaccel", f64::NAN, 0.0),
    ] {
        rig.float(name, set);
        rig.run(10);
        assert_eq!(rig.get::<f64>(name), is, "{name} {set}");
    }
}

#[test]
fn functions_say_what_they_touch() {
    let rig = Rig::new(&["step_type=0"]);
    let touches = |f: &str| rig.bench.touches(&format!("stepgen.{f}")).join(" ");
    let pulses = touches("make-pulses");
    for what in ["stepgen.0.enable r", "stepgen.0.step w", "stepgen.0.dir w", "# r", "# w"] {
        assert!(pulses.contains(what), "{what} in {pulses}");
    }
    let freq = touches("update-freq");
    for what in ["stepgen.0.position-cmd r", "stepgen.0.frequency w", "# r", "# w"] {
        assert!(freq.contains(what), "{what} in {freq}");
    }
    let capture = touches("capture-position");
    for what in ["stepgen.0.position-fb w", "stepgen.0.counts w", "# r"] {
        assert!(capture.contains(what), "{what} in {capture}");
    }
}
