//! Correction of backlash and of screw errors.

use super::*;
use std::path::PathBuf;

/// A file that is removed at the end of the test.
struct File(PathBuf);

impl File {
    fn new(name: &str, text: &str) -> Self {
        let path = std::env::temp_dir().join(format!("motion-{}-{name}", std::process::id()));
        std::fs::write(&path, text).unwrap();
        Self(path)
    }

    fn name(&self) -> String {
        self.0.display().to_string()
    }
}

impl Drop for File {
    fn drop(&mut self) {
        drop(std::fs::remove_file(&self.0));
    }
}

/// Nominal and measured positions: 0.1 short at 10 in positive direction, and 0.3 in negative direction.
const MEASURED: &str = "0 0 0.2\n10 9.9 10.3\n20 20 20.2\n";

#[test]
fn screw_errors_count_once_the_joint_is_homed_and_replace_the_backlash() {
    let file = File::new("screw", MEASURED);
    let mut rig = Rig::on(&[]);
    rig.say(&format!("motion.configure joint=0 backlash=0.5 comp-file={}", file.name()));
    rig.done("motion.jog joint=0 velocity=50 position=10");
    near(rig.joint(0, "motor-pos-cmd"), 10.0);
    rig.done("motion.jog joint=0 velocity=50 position=0");
    rig.done("motion.home joint=all");
    // Every cycle keeps velocity and acceleration of the joint, correction included.
    for (to, by) in [(10.0, 0.1), (5.0, -0.25), (10.0, 0.1), (15.0, 0.05), (30.0, 0.0), (0.0, -0.2)]
    {
        rig.done(&format!("motion.jog joint=0 velocity=90 position={to}"));
        rig.cycles(100);
        near(rig.joint(0, "backlash-corr"), by);
        near(rig.joint(0, "backlash-filt"), by);
        near(rig.joint(0, "motor-pos-cmd"), to + by);
        near(rig.joint(0, "pos-fb"), to);
    }
    rig.done("motion.move x=10 velocity=90");
    rig.cycles(100);
    near(rig.joint(0, "motor-pos-cmd"), 10.1);
    // Without its file, the joint has its backlash again.
    for (config, motor) in [("comp-file=", 10.25), ("backlash=0", 10.0)] {
        rig.say(&format!("motion.configure joint=0 {config}"));
        rig.cycles(200);
        near(rig.joint(0, "motor-pos-cmd"), motor);
    }
}

#[test]
fn corrections_in_the_file() {
    let file = File::new("trim", "0 0.1 -0.1\n100 0.3 -0.3\n");
    let mut rig = Rig::homed(&[]);
    let name = file.name();
    rig.say(&format!("motion.configure joint=1 comp-file={name} comp-file-type=1"));
    for (to, motor) in [(50.0, 50.2), (25.0, 24.85)] {
        rig.done(&format!("motion.move y={to} velocity=90"));
        rig.cycles(100);
        near(rig.joint(1, "motor-pos-cmd"), motor);
    }
}

/// Moves have what the correction leaves, and both together the whole.
#[test]
fn the_share_of_the_correction() {
    let mut rig = Rig::homed(&[]);
    for (config, fastest) in [
        ("backlash=0", 90.0),
        ("backlash=0.2", 81.0),
        ("comp-av-ratio=0.5", 45.0),
        ("comp-av-ratio=0.3 backlash=0", 90.0),
    ] {
        rig.say(&format!("motion.configure joint=0 {config}"));
        rig.cycles(200);
        for text in [
            "motion.jog joint=0 velocity=500 position=150",
            "motion.jog axis=x velocity=500 position=0",
            "motion.move x=150 velocity=500",
            "motion.move x=0 velocity=500",
        ] {
            rig.say(text);
            let mut most = 0.0_f64;
            rig.cycle();
            while !rig.is("motion.in-position") {
                rig.cycle();
                most = most.max(rig.joint(0, "vel-cmd").abs());
            }
            assert!((most - fastest).abs() < 1e-6 * fastest, "{config}, {text}: {most}");
        }
    }
}

#[test]
fn files_that_are_refused() {
    let bad = File::new("bad", "0 0 0\n1 two 3\n");
    let rig = Rig::off(&[]);
    let name = bad.name();
    for (config, why) in [
        (
            format!("comp-file={name}"),
            format!(
                "comp-file '{name}', line 2: expected three numbers: nominal, forward, reverse"
            ),
        ),
        (
            "comp-file=/none/such".to_owned(),
            "comp-file '/none/such': No such file or directory".to_owned(),
        ),
        ("comp-file-type=2".to_owned(), "comp-file-type is 2, must be 0 or 1".to_owned()),
        (
            "comp-av-ratio=0".to_owned(),
            "comp-av-ratio is 0, must be above 0, and at most 0.9".to_owned(),
        ),
        (
            "comp-av-ratio=1".to_owned(),
            "comp-av-ratio is 1, must be above 0, and at most 0.9".to_owned(),
        ),
    ] {
        assert_eq!(rig.try_say(&format!("motion.configure joint=0 {config}")), Err(why));
    }
    let why = "comp-file= does not belong to axis=";
    assert_eq!(rig.try_say("motion.configure axis=x comp-file=a"), Err(why.to_owned()));
}

/// Equal tables share a place; there is room for 64 different ones.
#[test]
fn only_so_many_different_files() {
    let rig = Rig::off(&[]);
    let load = |n: usize| {
        let file = File::new(&format!("many-{n}"), &format!("0 {n} {n}\n"));
        let config = format!("comp-file={} comp-file-type=1", file.name());
        rig.try_say(&format!("motion.configure joint=0 {config}")).map(drop)
    };
    for n in 0..64 {
        assert_eq!(load(n), Ok(()), "{n}");
    }
    let why = "more than 64 different files of screw errors";
    assert_eq!(load(64), Err(why.to_owned()));
    assert_eq!(load(63), Ok(()));
}

/// Rounding at the end of a motion does not turn the correction round; a motion back of a hundred-thousandth does.
#[test]
fn rounding_is_no_reversal() {
    let mut rig = Rig::homed(&[]);
    rig.say("motion.configure joint=0 backlash=0.2");
    for (to, corrected) in [
        (25.0, 0.1),
        (24.999_999_9, 0.1),
        (25.000_000_1, 0.1),
        (24.999_98, -0.1),
        (24.999_980_1, -0.1),
        (25.0, 0.1),
    ] {
        rig.done(&format!("motion.move x={to} velocity=90"));
        rig.cycles(200);
        near(rig.joint(0, "backlash-filt"), corrected);
    }
    // Moved by hand while off: the direction stays.
    rig.done("motion.disable");
    rig.strict = false;
    rig.stuck[0] = true;
    rig.bench.set("joint.0.motor-pos-fb", 20.0);
    rig.cycles(5);
    rig.stuck[0] = false;
    rig.done("motion.enable");
    rig.cycles(50);
    assert_eq!(rig.joint(0, "backlash-corr"), 0.1);
}
