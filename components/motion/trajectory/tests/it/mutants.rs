//! Known mistakes of planners, put back into this one: for each of them there is a test that fails.
#![expect(clippy::print_stdout, clippy::unwrap_used, reason = "tests")]

use std::{
    collections::BTreeSet,
    fs,
    path::{Path, PathBuf},
    process::Command,
};

/// A mistake: a text of a source, the text in its place, and the test that then fails.
struct Mutant {
    mistake: &'static str,
    file: &'static str,
    right: &'static str,
    wrong: &'static str,
    /// Room of the tests, or [`LIB`] for those inside the crate, and how the name of the test in it begins.
    fails: [&'static str; 2],
}

const BY_NAME: [&str; 2] = ["limits", "programs_by_name"];
const PAST: [&str; 2] = ["limits", "cases_of_the_past"];
const BOUNDS: [&str; 2] = ["times", "times_are_near"];

const LIB: &str = "lib";

const MUTANTS: [Mutant; 34] = [
    Mutant {
        mistake: "a search takes the end of its bracket that has not passed the test",
        file: "follower/event.rs",
        right: "        self.recheck = RECHECK;\n        low\n",
        wrong: "        self.recheck = RECHECK;\n        high\n",
        fails: BY_NAME,
    },
    Mutant {
        mistake: "rounding of the travel is lost",
        file: "follower/output.rs",
        right: "let more = travel - self.carry;",
        wrong: "let more = travel;",
        fails: PAST,
    },
    Mutant {
        mistake: "a cruise is lost",
        file: "speed.rs",
        right: "let mut speed = feed.min(self.top);",
        wrong: "let mut speed = 0.8 * feed.min(self.top);",
        fails: BOUNDS,
    },
    Mutant {
        mistake: "a cell may be entered above its own limit",
        file: "track.rs",
        right: "(1.0 + l * self.fade)).min(self.speed * self.speed)",
        wrong: "(1.0 + l * self.fade)).min(1e12)",
        fails: BY_NAME,
    },
    Mutant {
        mistake: "a blend is 7 % beyond its deviation bound",
        file: "blend.rs",
        right: "let ratio = deviation(&blend, a, b, t);",
        wrong: "let ratio = 0.93 * deviation(&blend, a, b, t);",
        fails: BY_NAME,
    },
    Mutant {
        mistake: "a blend between lines is 7 % beyond its tolerance",
        file: "blend.rs",
        right: "(1.0 - 1e-9) * 16.0 / 3.0 / worst",
        wrong: "1.07 * 16.0 / 3.0 / worst",
        fails: BY_NAME,
    },
    Mutant {
        mistake: "a blend is as long as its tolerance permits",
        file: "plan/rounding.rs",
        right: "let chosen = self.shortest(a, b, &longest, &tolerances);",
        wrong: "let chosen = longest;",
        fails: ["rounding", "a_corner_is_rounded"],
    },
    Mutant {
        mistake: "without a tolerance a limit of jerk makes blends as long as it likes",
        file: "plan/rounding.rs",
        right: "if t.is_bounded() { *longest } else { self.free(a, b, longest) }",
        wrong: "*longest",
        fails: ["rounding", "free_corners"],
    },
    Mutant {
        mistake: "lines are joined as far from them as the tolerance permits",
        file: "plan/rounding.rs",
        right: "let (mut tolerances, lines_carry) = self.joining(join.lines(), &most);",
        wrong: "let (mut tolerances, lines_carry) = (most, false);",
        fails: ["rounding", "dense_lines"],
    },
    Mutant {
        mistake: "the acceleration of the path does not count in curves",
        file: "speed.rs",
        right: "speed = (1.0 / share).sqrt();",
        wrong: "speed += 0.0;",
        fails: ["rounding", "a_limit_of_the_path"],
    },
    Mutant {
        mistake: "tolerance 0 is no tolerance",
        file: "plan.rs",
        right: "Mode::Blend(_) | Mode::Exact | Mode::ExactStop => self.machine.exact_tolerance,",
        wrong: "Mode::Blend(_) | Mode::Exact | Mode::ExactStop => 1e6,",
        fails: BY_NAME,
    },
    Mutant {
        mistake: "a tangent joint of line and arc counts as smooth under a limit of jerk",
        file: "blend.rs",
        right: "&& (!jerk || bend.dot_all(&bend).sqrt() < 1e-11 * size)",
        wrong: "&& (!jerk || size > 0.0)",
        fails: BY_NAME,
    },
    Mutant {
        mistake: "limits reach as far as the highest speed of the plan, not of their cell",
        file: "erosion.rs",
        right: "self.allowed.speed * time * (1.0 + 1e-9) + 1e-8",
        wrong: "500.0 * time",
        fails: ["times", "small_arcs"],
    },
    Mutant {
        mistake: "limits do not reach beyond their cell",
        file: "erosion.rs",
        right: "self.allowed.speed * time * (1.0 + 1e-9) + 1e-8",
        wrong: "0.0 * time",
        fails: BY_NAME,
    },
    Mutant {
        mistake: "an arc is one cell",
        file: "plan.rs",
        right: "const ARC_CELL: f64 = 0.25;",
        wrong: "const ARC_CELL: f64 = 7.0;",
        fails: ["times", "a_feed_is_reached"],
    },
    Mutant {
        mistake: "the feed of an arc is compared with the norm of the axes' largest speeds",
        file: "plan/cells.rs",
        right: "[Some((a, bounds.speed)), next]",
        wrong: "[Some((a, bounds.first.dot_all(&bounds.first).sqrt())), next]",
        fails: ["times", "a_feed_is_reached"],
    },
    Mutant {
        mistake: "an override above 1 is not planned for",
        file: "plan/cells.rs",
        right: "self.law.allowed(&bounds, joints.as_ref(), feed * self.machine.max_override, shares)",
        wrong: "self.law.allowed(&bounds, joints.as_ref(), feed, shares)",
        fails: ["times", "an_override_above_1"],
    },
    Mutant {
        mistake: "a filter that is not flat takes a new length",
        file: "follower.rs",
        right: "if self.samples == 1 { still } else { rests.is_ok_and(|f| f >= self.samples) }",
        wrong: "self.flat < u32::MAX || still || rests.is_err()",
        fails: BY_NAME,
    },
    Mutant {
        mistake: "without a filter, motion leaves an exact stop in the period in which it arrives",
        file: "follower.rs",
        right: "if self.samples == 1 { still }",
        wrong: "if self.samples == 1 { still || self.flat < u32::MAX }",
        fails: ["invariants", "without_a_limit_of_jerk_every_corner_is_a_sample"],
    },
    Mutant {
        mistake: "a cell has the acceleration of a straight one",
        file: "plan/cells.rs",
        right: "rest: raw.allowed.rest,\n                fade: raw.allowed.fade,",
        wrong: "rest: 1700.0,\n                fade: 0.0,",
        fails: BY_NAME,
    },
    Mutant {
        mistake: "a limit of speed a rounding below the planned speed is a lower one",
        file: "follower/event.rs",
        right: "v > cap * (1.0 + 4e-13)",
        wrong: "v > cap",
        fails: [LIB, "a_limit_within_rounding"],
    },
    Mutant {
        mistake: "joined lines are 25 % beyond their tolerance",
        file: "join.rs",
        right: "self.deviation(&spline, tolerances) <= 1.0 - 1e-9",
        wrong: "0.8 * self.deviation(&spline, tolerances) <= 1.0 - 1e-9",
        fails: BY_NAME,
    },
    Mutant {
        mistake: "the deviation of a blend is judged at its middle alone",
        file: "blend.rs",
        right: "    first.max(second).max(miss(blend, b, t))\n",
        wrong: "    miss(blend, b, t).max(0.0 * first.max(second))\n",
        fails: BY_NAME,
    },
    Mutant {
        mistake: "a double knot of a cubic is smooth",
        file: "plan/spline.rs",
        right: "next - first + 2 <= self.degree",
        wrong: "next - first + 1 <= self.degree",
        fails: ["splines", "random_splines"],
    },
    Mutant {
        mistake: "the follower passes any number of cells in a period",
        file: "plan/cells.rs",
        right: "raw.allowed.speed.min(window.add(raw.length) / machine.period)",
        wrong: "raw.allowed.speed.min(1e9 * window.add(raw.length) / machine.period)",
        fails: ["invariants", "specks"],
    },
    Mutant {
        mistake: "reverse motion stops where forward motion does, not before it",
        file: "follower.rs",
        right: "if if self.back { next.stop } else { cell.stop } {",
        wrong: "if cell.stop {",
        fails: PAST,
    },
    Mutant {
        mistake: "a jog accelerates and brakes without a pause for its filter",
        file: "axis.rs",
        right: "pause = (count + 2.0) * period * (1.0 + 1e-9);",
        wrong: "pause = 0.0;",
        fails: ["axis", "limits_hold"],
    },
    Mutant {
        mistake: "a blend between a rapid move and a feed has the feed's override alone",
        file: "track.rs",
        right: "times(self.feed, scales.feed).min(times(self.rapid, scales.rapid))",
        wrong: "if self.feed < f64::INFINITY { self.feed * scales.feed } else { times(self.rapid, scales.rapid) }",
        fails: ["rapids", "a_blend_between"],
    },
    Mutant {
        mistake: "the override of a rapid move is a share of its programmed speed, not of the fastest",
        file: "plan/cells.rs",
        right: "rapid = rapid.min(self.law.fastest(&bounds, joints.as_ref()));",
        wrong: "rapid = rapid.min(f64::MAX);",
        fails: ["rapids", "each_override"],
    },
    Mutant {
        mistake: "the follower does not look at the overrides ahead",
        file: "follower.rs",
        right: "cell.scaled(scales).min(ahead).min(cell.topped(&self.tops))",
        wrong: "cell.scaled(scales).min(ahead.max(1e9)).min(cell.topped(&self.tops))",
        fails: ["rapids", "an_override_of_0"],
    },
    Mutant {
        mistake: "a line is straight for joints that follow no axis",
        file: "pursuer/limits.rs",
        right: "is_known && matches!(curve, Curve::Line { .. })",
        wrong: "matches!(curve, Curve::Line { .. })",
        fails: ["pursuit", "lines_that_joints_bend"],
    },
    Mutant {
        mistake: "the highest speeds are those of the path coordinate",
        file: "track.rs",
        right: "let feed = tops.feed / self.lead as f64;",
        wrong: "let feed = tops.feed;",
        fails: ["tops", "a_highest_speed_is_that"],
    },
    Mutant {
        mistake: "the follower does not look at the highest speeds ahead",
        file: "follower/ahead.rs",
        right: "cap = cap.min(next.topped(&self.tops));",
        wrong: "cap = cap.min(f64::MAX);",
        fails: ["tops", "a_motion_is_slow_enough"],
    },
    Mutant {
        mistake: "the follower looks no farther than four cells for an override of 0",
        file: "follower/ahead.rs",
        right: "for _ in 0..SEARCHED {",
        wrong: "for _ in SEARCHED..SEARCHED {",
        fails: ["rapids", "an_override_of_0_stops_before_its_moves_behind_short_cells"],
    },
];

fn crates() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("..")
}

/// Returns a source with the mistake in it. The right text is there exactly once.
fn mutated(mutant: &Mutant) -> String {
    let text = fs::read_to_string(crates().join("trajectory/src").join(mutant.file)).unwrap();
    let count = text.matches(mutant.right).count();
    assert_eq!(count, 1, "{}: '{}' in {}", mutant.mistake, mutant.right, mutant.file);
    text.replace(mutant.right, mutant.wrong)
}

fn copy(from: &Path, to: &Path) {
    fs::create_dir_all(to).unwrap();
    for entry in fs::read_dir(from).unwrap() {
        let path = entry.unwrap().path();
        let to = to.join(path.file_name().unwrap());
        if path.is_dir() {
            copy(&path, &to);
        } else {
            fs::copy(&path, &to).unwrap();
        }
    }
}

#[test]
fn each_mistake_still_has_its_place() {
    for mutant in &MUTANTS {
        assert_ne!(mutated(mutant), "");
    }
}

#[test]
#[ignore = "copies and builds the crate for each mistake; every run has `each_mistake_still_has_its_place`: cargo test -p hal-trajectory --release --test it mutants -- --ignored --nocapture"]
fn each_mistake_fails_its_test() {
    let root = std::env::temp_dir().join(format!("hal-trajectory-mutants-{}", std::process::id()));
    let motion = ["trajectory", "corpus", "watchman"].map(|m| format!("components/motion/{m}"));
    let members = [motion.as_slice(), &["hal/golden".to_owned()]].concat();
    for member in &members {
        copy(&crates().join("../..").join(member), &root.join(member));
    }
    let manifest = fs::read_to_string(crates().join("../../Cargo.toml")).unwrap();
    let of_others = ["exclude = ", "default-members = "];
    let lines = manifest.lines().filter(|l| !of_others.iter().any(|o| l.starts_with(o))).map(|l| {
        if l.starts_with("members = ") { format!("members = {members:?}") } else { l.to_owned() }
    });
    fs::write(root.join("Cargo.toml"), lines.collect::<Vec<_>>().join("\n")).unwrap();
    fs::copy(crates().join("../../Cargo.lock"), root.join("Cargo.lock")).unwrap();
    let cargo = |words: &[&str]| {
        let mut command = Command::new(env!("CARGO"));
        command.args(["test", "-q", "--offline", "--release", "-p", "hal-trajectory"]);
        command.args(words).current_dir(&root).env("CARGO_TARGET_DIR", root.join("target"));
        command.env("CARGO_PROFILE_RELEASE_LTO", "off");
        command.env("CARGO_PROFILE_RELEASE_CODEGEN_UNITS", "16");
        command.output().unwrap()
    };
    let run = |[room, test]: [&str; 2]| {
        let inside = room == LIB;
        let words: &[&str] = if inside { &["--lib"] } else { &["--test", "it"] };
        let test = if inside { test.to_owned() } else { format!("{room}::{test}") };
        let built = cargo(&[words, &["--no-run"]].concat());
        assert!(built.status.success(), "{}", String::from_utf8_lossy(&built.stderr));
        let done = cargo(&[words, &[test.as_str()]].concat());
        (done.status.success(), String::from_utf8_lossy(&done.stdout).into_owned())
    };
    // Without a mistake, every test is there and passes.
    let tests: BTreeSet<_> = MUTANTS.iter().map(|m| m.fails).collect();
    for test in tests {
        let (passes, said) = run(test);
        assert!(passes && !said.contains(" 0 passed"), "{test:?} without a mistake: {said}");
        println!("no mistake: {}::{}: passes", test[0], test[1]);
    }
    let mut missed = Vec::new();
    for mutant in &MUTANTS {
        let path = root.join("components/motion/trajectory/src").join(mutant.file);
        let right = fs::read_to_string(&path).unwrap();
        fs::write(&path, mutated(mutant)).unwrap();
        let [program, test] = mutant.fails;
        let caught = !run(mutant.fails).0;
        println!(
            "{}: {program}::{test}: {}",
            mutant.mistake,
            if caught { "fails" } else { "passes" }
        );
        if !caught {
            missed.push(mutant.mistake);
        }
        fs::write(&path, right).unwrap();
    }
    fs::remove_dir_all(&root).unwrap();
    assert!(missed.is_empty(), "no test sees: {missed:?}");
}
