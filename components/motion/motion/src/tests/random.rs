//! Random machines: orderly ones, which must keep every limit, and ones that receive invalid input.

use super::{LIMITS, Rig};
use hal_bench::Random;

pub(super) fn orderly(random: &mut Random) -> String {
    let joint = random.pick(&[0, 1, 2]);
    let axis = random.pick(&["x", "y", "z"]);
    let speed = random.between(0.1, 200.0);
    let (_, _, min, max) = LIMITS[joint];
    let to = random.between(min * 1.2, max * 1.2);
    let way = random.between(-30.0, 30.0);
    let inside = random.between(min, max);
    match random.below(16) {
        0 => format!("motion.jog joint={joint} velocity={}", random.pick(&[speed, -speed])),
        1 => format!("motion.jog joint={joint} velocity={speed} position={to}"),
        2 | 3 => format!("motion.jog joint={joint} velocity={speed} distance={way}"),
        4 => format!("motion.jog axis={axis} velocity={}", random.pick(&[speed, -speed])),
        5 => format!("motion.jog axis={axis} velocity={speed} distance={way}"),
        6 => format!("motion.jog-stop joint={joint}"),
        7 => "motion.jog-stop".to_owned(),
        8 => "motion.abort".to_owned(),
        9 => format!("motion.feed override={}", random.pick(&[0.0, 0.3, 1.0, 5.0])),
        _ => format!(
            "motion.move {}={inside} {}={way} velocity={speed}",
            ["x", "y", "z"][joint],
            ["y", "z", "x"][joint]
        ),
    }
}

#[test]
fn orderly_machines_keep_their_limits() {
    let mut random = Random::new(1);
    let mut went = [0.0_f64; 3];
    for kinematics in [&[][..], &["kinstype=b"]].repeat(20) {
        let mut rig = Rig::homed(kinematics);
        for n in 0..3 {
            rig.bench.set(&format!("joint.{n}.jog-scale"), 0.05);
            rig.bench.set(&format!("joint.{n}.jog-enable"), true);
        }
        for _ in 0..60 {
            rig.say(&orderly(&mut random));
            rig.bench.set("motion.feed-hold", random.below(8) == 0);
            rig.bench.set("motion.jog-stop", random.below(8) == 0);
            let fraction = random.between(0.0, 1.2);
            for _ in 0..random.pick(&[1, 7, 50, 300]) {
                rig.bench.set("joint.0.jog-accel-fraction", fraction);
                if random.below(16) == 0 {
                    let counts: i32 = rig.bench.get("joint.0.jog-counts");
                    rig.bench.set("joint.0.jog-counts", counts + random.pick(&[-9, 2, 7]));
                }
                rig.cycle();
                for (n, (place, (.., min, max))) in rig.places().iter().zip(LIMITS).enumerate() {
                    assert!(min - 1e-5 <= *place && *place <= max + 1e-5, "joint {n} at {place}");
                    went[n] = went[n].max(place.abs());
                }
                assert!(rig.is("motion.motion-enabled"), "{:?}", rig.bench.said());
            }
        }
        rig.bench.set("motion.feed-hold", false);
        rig.say("motion.feed override=1");
        rig.done("motion.abort");
        assert!(rig.is("motion.in-position"));
        rig.done("motion.move x=0 y=0 z=0 velocity=90");
        assert_eq!(rig.places(), [0.0; 3]);
    }
    assert!(went[0] > 100.0 && went[1] > 100.0 && went[2] > 20.0, "{went:?}");
}

#[test]
fn nonsense_is_survived() {
    const FLOATS: [f64; 9] = [
        f64::NAN,
        f64::INFINITY,
        f64::NEG_INFINITY,
        f64::MAX,
        f64::MIN_POSITIVE,
        -1e6,
        0.0,
        -0.0,
        0.1,
    ];
    const SPEEDS: [f64; 6] = [0.0, -20.0, 5.0, 1e300, -1e-300, f64::NAN];
    let mut random = Random::new(3);
    for _ in 0..20 {
        let mut rig = Rig::on(random.pick(&[&[][..], &["kinstype=b"], &["coordinates=xyyz"]]));
        rig.strict = false;
        drop(rig.try_say("motion.configure axis=x offset-av-ratio=0.5"));
        let inputs: Vec<String> = rig.bench.names();
        let inputs: Vec<Vec<&str>> = inputs
            .iter()
            .map(|l| l.split(' ').collect())
            .filter(|l: &Vec<&str>| l[2] != "OUT" && l[2] != "RO")
            .collect();
        for _ in 0..600 {
            let pin = &inputs[random.index(inputs.len())];
            match pin[1] {
                "float" => rig.bench.set(pin[0], random.pick(&FLOATS)),
                "bit" => rig.bench.set(pin[0], random.below(4) == 0),
                _ => rig.bench.set(pin[0], random.pick(&[i32::MIN, -1, 0, 1, i32::MAX])),
            }
            let text = match random.below(9) {
                0 => "motion.enable".to_owned(),
                1 => "motion.home joint=all".to_owned(),
                2 => "motion.override-limits".to_owned(),
                3 => format!(
                    "motion.configure joint=0 min-limit={} max-limit={}",
                    random.pick(&FLOATS),
                    random.pick(&FLOATS)
                ),
                4 => format!(
                    "motion.configure joint=1 max-velocity={} max-acceleration={}",
                    random.pick(&FLOATS),
                    random.pick(&FLOATS)
                ),
                5 => format!("motion.move x={} velocity={}", random.pick(&FLOATS), 1e300),
                6 => format!(
                    "motion.configure joint={} home-search-vel={} home-latch-vel={} home={} \
                     home-offset={} home-use-index={} home-sequence={} home-absolute-encoder={}",
                    random.below(3),
                    random.pick(&SPEEDS),
                    random.pick(&SPEEDS),
                    random.pick(&SPEEDS),
                    random.pick(&SPEEDS),
                    random.below(2),
                    random.pick(&[-1, 0, 1]),
                    random.below(3),
                ),
                _ => orderly(&mut random),
            };
            // Refused or not, nothing fails.
            drop(rig.try_say(&text));
            rig.stuck = [0; 3].map(|_: i32| random.below(4) == 0);
            rig.cycles(3);
            let on = rig.is("motion.motion-enabled");
            for n in 0..3 {
                assert_eq!(rig.is(&format!("joint.{n}.amp-enable-out")), on);
                let fb = rig.joint(n, "motor-pos-fb");
                assert!(!on || fb.is_finite(), "on with a feedback of {fb}");
                assert!(!rig.joint(n, "motor-pos-cmd").is_nan());
            }
            assert!(!on || rig.is("motion.enable"));
        }
    }
}
