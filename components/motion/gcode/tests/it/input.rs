//! Bad input: whatever the bytes, an error or an end within the limits, and never a panic.

use std::sync::Arc;

use hal_gcode::{Interpreter, Numbered, Step, error::Problem, state::Limits};

use crate::support::{World, answer, settings};

struct Random(u64);

impl Random {
    fn below(&mut self, n: usize) -> usize {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
        usize::try_from(self.0 >> 33).unwrap() % n
    }
}

const LIMITS: Limits = Limits {
    turns: 100,
    levels: 10,
    open: 100,
    quiet_lines: 300,
    lines: 2000,
    line_length: 4096,
    calls: 20_000,
};

/// Runs a text to its end; returns its error.
fn outcome(text: &[u8], world: &World) -> Option<hal_gcode::Error> {
    let mut it =
        Interpreter::new(hal_gcode::Settings { limits: LIMITS, ..settings() }, Numbered::default());
    it.load("fuzz.ngc", Arc::new(text.to_vec()));
    let mut out = Vec::new();
    let mut asked = None;
    for _ in 0..10_000 {
        out.clear();
        let step = match asked.take() {
            None => it.next(world, &mut out),
            Some(request) => {
                let reply = answer(&request, &it);
                it.answer(&reply, world, &mut out)
            }
        };
        assert!(out.iter().all(|i| !i.call.to_string().contains("NaN")), "a NaN in a call");
        match step {
            Ok(Step::Line) => {}
            Ok(Step::Ask(request)) => asked = Some(request),
            Ok(Step::Ended) => return None,
            Err(error) => {
                assert!(!error.to_string().is_empty());
                return Some(error);
            }
        }
    }
    unreachable!("the limits did not hold");
}

const TOKENS: [&str; 90] = [
    "g0",
    "g1",
    "g2",
    "g3",
    "g4",
    "g5",
    "g5.1",
    "g5.2",
    "g5.3",
    "g10",
    "g17",
    "g18",
    "g19",
    "g20",
    "g21",
    "g28",
    "g28.1",
    "g33",
    "g38.2",
    "g40",
    "g41.1",
    "g42.1",
    "g41",
    "g43",
    "g43.1",
    "g49",
    "g52",
    "g53",
    "g54",
    "g55",
    "g61",
    "g64",
    "g73",
    "g76",
    "g80",
    "g81",
    "g83",
    "g84",
    "g87",
    "g90",
    "g91",
    "g92",
    "g92.1",
    "g93",
    "g94",
    "g98",
    "m3",
    "m5",
    "m6",
    "m66",
    "m70",
    "m72",
    "m98",
    "m99",
    "t1",
    "f100",
    "s100",
    "x1",
    "x-5",
    "y2",
    "y1e",
    "z-3",
    "z5",
    "a1",
    "i1",
    "j-2",
    "k1",
    "r2",
    "r-3",
    "p1",
    "q0.5",
    "l2",
    "d2",
    "h1",
    "e1",
    "#1=[#1+1]",
    "#<a>=3",
    "x#1",
    "[1/0]",
    "x[2**3]",
    "\n",
    "\n",
    "\n",
    "\n",
    "o1 while [#1 lt 9]\n",
    "\no1 endwhile\n",
    "\no2 if [1]\n",
    "\no2 endif\n",
    "(msg,#1)",
    "y999999999999999999",
];

#[test]
fn random_bytes_and_token_soup_end_in_order() {
    let world = World::new();
    let mut random = Random(7);
    let programs: Vec<&Vec<u8>> = world.files.values().collect();
    let (mut errors, mut ends) = (0, 0);
    for case in 0..7500 {
        let mut text = Vec::new();
        match case % 3 {
            0 => {
                for _ in 0..random.below(200) {
                    text.push(u8::try_from(random.below(256)).unwrap());
                }
            }
            1 => {
                for _ in 0..random.below(120) {
                    text.extend(TOKENS[random.below(TOKENS.len())].bytes());
                    text.push(b' ');
                }
                text.extend(b"\nm2\n");
            }
            _ => {
                text.extend(programs[random.below(programs.len())]);
                for _ in 0..=random.below(4) {
                    if text.is_empty() {
                        break;
                    }
                    let at = random.below(text.len());
                    match random.below(3) {
                        0 => text[at] = u8::try_from(random.below(128)).unwrap(),
                        1 => drop(text.remove(at)),
                        _ => text.truncate(at + 1),
                    }
                }
            }
        }
        match outcome(&text, &world) {
            Some(_) => errors += 1,
            None => ends += 1,
        }
    }
    assert!(errors > 1000 && ends > 100, "{errors} errors and {ends} ends: the cases say little");
}

#[test]
fn each_bound_has_its_error() {
    let world = World::new();
    let deep = |open: &str, n: usize| format!("g0 x{}1\nm2\n", open.repeat(n)).into_bytes();
    let problem = |text: &[u8]| outcome(text, &world).map(|e| e.problem);
    assert!(matches!(problem(&deep("[", 4000)), Some(Problem::NestedTooDeep { .. })));
    assert!(matches!(problem(&deep("#", 4000)), Some(Problem::NestedTooDeep { .. })));
    assert!(matches!(problem(&deep("-", 4000)), Some(Problem::NestedTooDeep { .. })));
    let sum = format!("#1=[1{}]\nm2\n", "+1".repeat(512));
    assert_eq!(problem(sum.as_bytes()), None);
    let sum = format!("#1=[1{}]\nm2\n", "+1".repeat(513));
    assert!(matches!(problem(sum.as_bytes()), Some(Problem::TooManyOperators { .. })));
    let long = format!("g0 x{}\n", "1".repeat(1_000_000));
    assert!(matches!(problem(long.as_bytes()), Some(Problem::LineTooLong { .. })));
    let longest = format!("g0 x{}1\nm2\n", "0".repeat(4091));
    assert_eq!(problem(longest.as_bytes()), None);
    let longer = format!("g0 x{}1\nm2\n", "0".repeat(4092));
    assert_eq!(problem(longer.as_bytes()), Some(Problem::LineTooLong { limit: 4096 }));
    assert!(matches!(
        problem(b"o1 while [1]\no1 endwhile\nm2\n"),
        Some(Problem::RunAway { limit: 300 })
    ));
    assert!(matches!(
        problem(b"o1 while [1]\ng0 x1\no1 endwhile\nm2\n"),
        Some(Problem::LinesSpent { limit: 2000 })
    ));
    assert!(matches!(
        problem(b"o<a> sub\no<a> call\no<a> endsub\no<a> call\n"),
        Some(Problem::TooManyLevels)
    ));
    assert!(matches!(
        problem(b"f1 g81 z-1 r1 l999999999\nm2\n"),
        Some(Problem::OutputTooLarge { .. })
    ));
    assert!(matches!(
        problem(b"f1 g83 z-1000 r1 q0.000001\nm2\n"),
        Some(Problem::OutputTooLarge { .. })
    ));
    assert!(matches!(
        problem(b"o1 do\n#1=[#1+1]\no1 do\no1 while [0]\n"),
        Some(Problem::NoProgramEnd)
    ));
    assert!(matches!(problem(b"g0 x1\ng1 y"), Some(Problem::NoNumber)));
    assert!(matches!(problem(b""), Some(Problem::NoProgramEnd)));
    assert!(matches!(problem(b"\xff\xfeg\x000\x000"), Some(Problem::BadCharacter { .. })));
    assert!(problem(b"g0 x1\r\nm2\r\n").is_none());
    assert!(
        problem(
            b"g0 x99999999999999999999999999999999
g91 g1 f1 x1
m2"
        )
        .is_none()
    );
}

#[test]
fn errors_show_the_word() {
    let world = World::new();
    let at = |text: &str| outcome(text.as_bytes(), &world).unwrap().to_string();
    assert!(at("G0 X1 Y[1/0]\n").starts_with("fuzz.ngc:1:10: Attempt to divide by zero"));
    assert!(at("\n  N5 G0 X1 (c) ?\n").starts_with("fuzz.ngc:2:16: Bad character '?' used"));
    assert!(at("G0 X1 X2\n").starts_with("fuzz.ngc:1:7: Multiple x words on one line"));
    assert!(at("G0 X1 Q2\n").starts_with("fuzz.ngc:1:7: Q word with no"));
    assert!(at("M3 S1 G33 X1 K1 G1\n").starts_with("fuzz.ngc:1:17: Two g codes used"));
    assert!(at("F10 G2 X1\n").starts_with("fuzz.ngc:1:5: R i j k words all missing"));
}

#[test]
fn each_bound_is_reached_before_it_refuses() {
    let world = World::new();
    let problem = |text: String| outcome(text.as_bytes(), &world).map(|e| e.problem);
    let lines = |n: usize| format!("{}m2\n", "g0 x1\n".repeat(n));
    assert_eq!(problem(lines(1999)), None);
    assert_eq!(problem(lines(2000)), Some(Problem::LinesSpent { limit: 2000 }));
    let quiet = |n: usize| format!("{}g0 x1\nm2\n", "#1=1\n".repeat(n));
    assert_eq!(problem(quiet(300)), None);
    assert_eq!(problem(quiet(301)), Some(Problem::RunAway { limit: 300 }));
    let open = |n: usize| {
        let ifs: String = (0..n).map(|i| format!("o{i} if [1]\n")).collect();
        format!("{ifs}m2\n")
    };
    assert_eq!(problem(open(100)), None);
    assert_eq!(problem(open(101)), Some(Problem::LoopsTooDeep { limit: 100 }));
}

#[test]
fn other_encodings_are_told_apart() {
    let world = World::new();
    let error = |text: &[u8]| outcome(text, &world).map(|e| e.to_string());
    // Bytes of Latin-1 and UTF-8 in comments and messages.
    assert_eq!(error(b"(f\xfcr \xd8 6)\ng0 x1 (msg, \xb5m)\n; \xe4\nm2\n"), None);
    assert_eq!(error("(für Ø 6 µm)\ng0 x1\nm2\n".as_bytes()), None);
    // A mark of UTF-8 or UTF-16 at the begin, and such a byte in a word.
    let bad = |text: &[u8], place: &str| {
        let error = error(text).unwrap();
        assert!(error.starts_with(&format!("{place}: Bad character")), "{error}");
    };
    bad(b"\xef\xbb\xbfg0 x1\nm2\n", "fuzz.ngc:1:1");
    bad(b"\xff\xfeg\x000\x00\n", "fuzz.ngc:1:1");
    bad(b"g0 x1\ng0 \xd81\nm2\n", "fuzz.ngc:2:4");
}

/// Returns a text with numbers that G-code has no exponents for.
fn spelled(text: &str) -> String {
    let pairs = [
        ("1e300", "[10**300]"),
        ("1e-300", "[10**-300]"),
        ("1e12", "1000000000000"),
        ("1e10", "10000000000"),
        ("1e9", "1000000000"),
        ("1e-3", "0.001"),
        ("1e-6", "0.000001"),
        ("1e-9", "0.000000001"),
        ("2e-9", "0.000000002"),
        ("5e-10", "0.0000000005"),
    ];
    pairs.iter().fold(text.to_owned(), |text, (from, to)| text.replace(from, to))
}

/// Returns what is wrong with an error that should be in a line of a program and say this.
fn wrong_error(error: Option<String>, line: u32, part: &str, case: &str) -> Option<String> {
    let error = error.unwrap_or_default();
    let is_there = error.starts_with(&format!("fuzz.ngc:{line}:")) && error.contains(part);
    (!is_there).then(|| format!("{case}: {error:?}, not {part:?} in line {line}"))
}

/// Returns the error of a program with a profile and a cycle along it.
fn of_profile(profile: &str, cycle: &str, world: &World) -> Option<String> {
    let text = format!("g18 g21 g8 f100\no100 sub\n{profile}o100 endsub\ng0 x30 z2\n{cycle}\nm2\n");
    outcome(spelled(&text).as_bytes(), world).map(|e| e.to_string())
}

#[test]
fn bad_profiles_are_refused_by_their_line() {
    let world = World::new();
    let good = "g0 x10 z0\ng1 z-5\nx20\n";
    assert_eq!(of_profile(good, "g71 q100", &world), None);
    let cases = [
        ("", "g71 q100", 5, "the profile has no motion"),
        ("g0 x10 z0\n", "g71 q100", 6, "the profile has no motion"),
        ("g0 x10 z0\ng1 x10 z0\n", "g70 q100", 7, "the profile has no motion"),
        ("g0 x1e300 z0\ng1 z-5\n", "g71 q100", 3, "X of the cycle or its profile"),
        ("g0 x10 z0\ng1 z-1e300\n", "g72 q100", 4, "Z of the cycle or its profile"),
        ("g0 x10 z0\ng1 z[-1e300*1e300]\n", "g71 q100", 4, ""),
        ("g0 x10 z0\ng2 x12 z-5 i1e300 k1e300\n", "g71 q100", 4, ""),
        ("g0 x10 z0\ng2 x10 z-1e-9 i0 k-5e-10\n", "g71 q100", 4, "Zero-radius arc"),
        ("g0 x10 z0\ng2 z-2e-9 r1e-9\n", "g71 q100", 4, "the radius of the arc"),
        ("g0 x10 z0\ng2 x10 z0 i5 k0\n", "g71 q100", 4, "the profile is not monotonic"),
        ("g0 x10 z0\ng1 z-5\nx15 z-9\nx20 z-4\nx22 z-9\n", "g71 q100", 6, "the profile"),
        ("g0 x10 z0\ng1 x20 z-10\nz-3\n", "g71 q100", 5, "the profile"),
        ("g0 x10 z0\no101 while [1]\no101 endwhile\n", "g71 q100", 5, ""),
        ("g0 x10 z0\no101 repeat [5000]\ng1 w-1\no101 endrepeat\n", "g71 q100", 6, ""),
        ("g0 x10 z0\ng1 z-5\no100 call\n", "g71 q100", 5, ""),
        ("g0 x10 z0\ng1 z#<none>\n", "g71 q100", 4, ""),
        (good, "g71 q100 d1e300", 8, "D of the cycle or its profile"),
        (good, "g70 q100 e-1e12", 8, "E of the cycle or its profile"),
        (good, "g71 q100 i1e300", 8, "I of the cycle or its profile"),
        (good, "g71 q100 i-1", 8, "G71 and G72 need an I above 0"),
        (good, "g71 q100 i1e-300", 8, "the cycle has more than 100000 levels"),
        (good, "g71 q100 r-1", 8, "Negative R"),
        (good, "g71 q100 x1e300", 8, "X of the cycle or its profile"),
        (good, "g70 q100 p1e9", 8, ""),
    ];
    let wrong = cases.into_iter().filter_map(|(profile, cycle, line, part)| {
        let error = of_profile(profile, cycle, &world);
        wrong_error(error, line, part, &format!("{profile}{cycle}"))
    });
    assert_eq!(wrong.collect::<Vec<_>>(), Vec::<String>::new());
}

/// Values at the edges of what a program can say.
const EDGES: [&str; 16] = [
    "0", "-0", "1", "-1", "5", "-7.5", "1e-9", "-1e-9", "1e-6", "0.001", "1e9", "-1e9", "1e10",
    "1e300", "-1e300", "1e-300",
];

#[test]
fn random_profiles_and_contours_of_edge_values_end_in_order() {
    let world = World::new();
    let mut random = Random(11);
    let (mut errors, mut ends) = (0, 0);
    for case in 0..4000 {
        let edge = |random: &mut Random| {
            // Most values are ordinary, so that a bad one comes late.
            if random.below(4) > 0 {
                format!("{}", random.below(200) as f64 / 8.0 - 12.0)
            } else {
                EDGES[random.below(EDGES.len())].to_owned()
            }
        };
        let mut text = String::new();
        for _ in 0..1 + random.below(6) {
            let code = ["g0", "g1", "g1", "g2", "g3"][random.below(5)];
            let (x, z) = (edge(&mut random), edge(&mut random));
            text.push_str(&format!("{code} x{x} z{z}"));
            match (code, random.below(2)) {
                ("g2" | "g3", 0) => text.push_str(&format!(" r{}", edge(&mut random))),
                ("g2" | "g3", _) => {
                    let (i, k) = (edge(&mut random), edge(&mut random));
                    text.push_str(&format!(" i{i} k{k}"));
                }
                _ => {}
            }
            text.push('\n');
        }
        let value = edge(&mut random);
        let error = if case % 2 == 0 {
            let cycle = ["g70", "g71", "g71.1", "g71.2", "g72", "g72.1", "g72.2"][random.below(7)];
            let word = ["d", "e", "i", "r", "x", "z"][random.below(6)];
            of_profile(&text, &format!("{cycle} q100 {word}{value}"), &world)
        } else {
            let side = ["g41.1", "g42.1"][random.below(2)];
            let text = format!("g18 g21 g8 f100\n{side} d{value}\n{text}g40\nm2\n");
            outcome(spelled(&text).as_bytes(), &world).map(|e| e.to_string())
        };
        match error {
            Some(_) => errors += 1,
            None => ends += 1,
        }
    }
    assert!(errors > 1000 && ends > 100, "{errors} errors and {ends} ends: the cases say little");
}

#[test]
fn bad_contours_are_refused_by_their_line() {
    let world = World::new();
    let cases = [
        ("g41.1 d1e300\n", 2, "a compensated move or the tool's radius is out of range"),
        ("g41.1 d[1e300*1e300]\n", 2, ""),
        ("g41.1 d1\ng1 x1e300\n", 3, "a compensated move or the tool's radius"),
        ("g41.1 d1\ng1 x10\ng2 x20 r1e300\n", 4, "the radius of the arc is out of range"),
        ("g41.1 d1\ng1 x10\ng2 x[10+2e-9] r1e-9\n", 4, "the radius of the arc"),
        ("g41.1 d1\ng1 x10\ng3 x10.4 i0.2\n", 4, "Tool radius not less than arc radius"),
        // A wedge of a fifth of a degree, and its other side.
        ("g41.1 d1\ng1 x10\nx0 y0.03\n", 4, "Straight feed in concave corner"),
        ("g42.1 d1\ng1 x10\nx0 y-0.03\n", 4, "Straight feed in concave corner"),
        // The next side is too short for the tool.
        ("g41.1 d2\ng1 x10\ny0.5\nx0\n", 4, "Straight feed in concave corner"),
    ];
    let wrong = cases.into_iter().filter_map(|(contour, line, part)| {
        let text = format!("g17 g21 f100\n{contour}g40\nm2\n");
        let error = outcome(spelled(&text).as_bytes(), &world).map(|e| e.to_string());
        wrong_error(error, line, part, contour)
    });
    assert_eq!(wrong.collect::<Vec<_>>(), Vec::<String>::new());
}

#[test]
fn a_tool_without_radius_is_on_the_programmed_lines() {
    let world = World::new();
    let contour = "g1 x10\ny10\nx9\ny0\nx20 y1e-3\nx5 y0\ng3 x-5 y0 i-5\ng2 x-5 y0 i2\ng0 x0 y-8\ng1 z-1\nm0\nx1\n";
    let calls = |before: &str| {
        let text = format!("g17 g21 f100\n{before}\n{contour}g40\ng1 x-9\nm2\n");
        let mut it = Interpreter::new(settings(), Numbered::default());
        it.load("wear.ngc", Arc::new(spelled(&text).into_bytes()));
        let (calls, error) = crate::support::run_with(&mut it, &world, |_| {});
        assert_eq!(error.map(|e| e.to_string()), None);
        let is_told = |c: &hal_gcode::Call| matches!(c, hal_gcode::Call::Comment(_));
        calls.into_iter().map(|c| c.call).filter(|c| !is_told(c)).collect::<Vec<_>>()
    };
    let plain = calls("");
    for side in ["g41", "g42", "g41 d0", "g41.1 d0", "g42.1 d0", "g42.1 d-0", "g41.1 d1e-9"] {
        assert_eq!(calls(side), plain, "{side}");
    }
}
