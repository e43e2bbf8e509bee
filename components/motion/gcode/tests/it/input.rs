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
    for case in 0..6000 {
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
