//! Cutter-location files: the path of each statement, and the place of each error.
#![expect(clippy::panic, reason = "tests")]

use crate::random;

use hal_arm::apt::{Motion, Part, Problem};
use random::Random;

const PLATE: &str = "\
$$ CATIA style
PARTNO PLATE
UNITS/MM
FROM / 0,0,100
RAPID
GOTO / 20,20,100
TLAXIS/0,0,1
FEDRAT/600,MMPM
GOTO / 20.0, 20.0, 0.0, 0.0, 0.0, 1.0                                   PT    2
GOTO / 180.0, 20.0, 0.0
INDIRV/ 0,1,0
TLON,GOFWD/ (CIRCLE/ 150.0, 20.0, 0.0,$
30.0),ON,(LINE/ 150.0,20.0,0.0,150.0,50.0,0.0)
FINI
";

fn part(text: &str) -> Part {
    Part::parse(text.as_bytes()).unwrap_or_else(|e| panic!("{text}: {e}"))
}

fn places(part: &Part) -> Vec<[f64; 3]> {
    part.points.iter().map(|p| [p.place.x, p.place.y, p.place.z]).collect()
}

#[test]
fn the_plate() {
    let part = part(PLATE);
    assert_eq!(part.name, "PLATE");
    assert_eq!(part.warnings, []);
    let all = places(&part);
    assert_eq!(all.len(), 4 + 31);
    let straight = [[0., 0., 100.], [20., 20., 100.], [20., 20., 0.], [180., 20., 0.]];
    assert_eq!(all[..4], straight);
    assert_eq!(all[34], [150.0, 50.0, 0.0]);
    for p in &all[4..] {
        assert!(((p[0] - 150.0).hypot(p[1] - 20.0) - 30.0).abs() < 1e-9, "{p:?}");
    }
    let motions: Vec<Motion> = part.points[..3].iter().map(|p| p.motion).collect();
    assert_eq!(motions, [Motion::Start, Motion::Rapid, Motion::Feed(Some(10.0))]);
    assert_eq!(part.points[3].line, 10);
}

#[test]
fn statements_do_what_they_say() {
    let end = |text: &str| {
        let part = part(&format!("FROM/0,0,0\n{text}\nFINI\n"));
        let last = *part.points.last().unwrap();
        ([last.place.x, last.place.y, last.place.z], last.motion, part.points.len())
    };
    let feed = |f: f64| Motion::Feed(Some(f));
    for (text, place, motion) in [
        ("goto/1,2,3", [1., 2., 3.], Motion::Feed(None)),
        ("GO TO / 1 , 2 , 3", [1., 2., 3.], Motion::Feed(None)),
        ("UNITS/INCHES\nFEDRAT/6\nGOTO/1,0,0", [25.4, 0., 0.], feed(2.54)),
        ("FEDRAT/MMPM,120\nGOTO/1,0,0", [1., 0., 0.], feed(2.0)),
        ("FEDRAT/IPM,6\nGOTO/1,0,0", [1., 0., 0.], feed(2.54)),
        ("SPINDL/600,RPM,CLW\nFEDRAT/.1,MMPR\nGOTO/1,0,0", [1., 0., 0.], feed(1.0)),
        ("TLAXIS/0,3,4\nGODLTA/10", [0., 6., 8.], Motion::Feed(None)),
        ("GOTO/1,1,1\nGODLTA/1,2,3", [2., 3., 4.], Motion::Feed(None)),
        ("RAPID\nGOTO/1,0,0\nGOTO/2,0,0", [2., 0., 0.], Motion::Feed(None)),
        ("RAPID\nGODLTA/1.5E1,0,0", [15., 0., 0.], Motion::Rapid),
        ("GOTO/1,0,0 $$ GOTO/9,9,9", [1., 0., 0.], Motion::Feed(None)),
        ("GOTO/$\n1,$\n2,3", [1., 2., 3.], Motion::Feed(None)),
    ] {
        let (at, with, _) = end(text);
        assert!(at.iter().zip(place).all(|(a, b)| (a - b).abs() < 1e-12), "{text}: {at:?}");
        match (with, motion) {
            (Motion::Feed(Some(a)), Motion::Feed(Some(b))) => assert!((a - b).abs() < 1e-12),
            (a, b) => assert_eq!(a, b, "{text}"),
        }
    }
    let part =
        part("PPRINT a note\nFROM/0,0,0\nLOADTL/3\nFOO/1\nFOO/2\nGOTO/0,0,1,0,1,0\nEND\ngarbage");
    let events: Vec<_> = part.events.iter().map(|e| (e.line, e.after, e.text.as_str())).collect();
    assert_eq!(events, [(1, 0, "PPRINT a note"), (3, 1, "LOADTL/3")]);
    assert_eq!(part.warnings, [(4, "FOO has no effect".to_owned())]);
    assert_eq!(part.points[1].axis.y, 1.0);
    assert_eq!(part.centre().unwrap().z, 0.5);
}

#[test]
fn arcs_stay_on_their_circle() {
    let radius = |text: &str, count: usize, to: [f64; 3]| {
        let part = part(&format!("FROM/5,0,0\n{text}\nFINI\n"));
        let all = places(&part);
        assert_eq!(all.len(), 1 + count, "{text}");
        assert_eq!(*all.last().unwrap(), to, "{text}");
        for (n, pair) in all.windows(2).enumerate() {
            let out = pair[1][0].hypot(pair[1][1]);
            assert!((out - 5.0).abs() < 1e-9, "{text}: {n} {pair:?}");
            let middle = [(pair[0][0] + pair[1][0]) / 2.0, (pair[0][1] + pair[1][1]) / 2.0];
            assert!(5.0 - middle[0].hypot(middle[1]) <= 0.01 + 1e-9, "{text}: {n}");
        }
        all
    };
    let quarter = radius("CIRCLE/0,0,0,5\nGOTO/0,5,0", 13, [0., 5., 0.]);
    assert!(quarter[6][0] > 0.0 && quarter[6][1] > 0.0);
    let rest = radius("CIRCLE/0,0,0,0,0,-1,5\nGOTO/0,5,0", 38, [0., 5., 0.]);
    assert!(rest[6][1] < 0.0);
    radius("CIRCLE/0,0,0,5\nGOTO/5,0,0", 50, [5., 0., 0.]);
    let helix = radius("CIRCLE/0,0,0,5\nGOTO/0,5,-13", 13, [0., 5., -13.]);
    assert!((helix[3][2] + 3.0).abs() < 1e-9, "{:?}", helix[3]);
    let back = "INDIRV/0,-1,0\nTLON,GOFWD/(CYLNDR/0,0,0,0,0,1,5),ON,2,INTOF,(POINT/0,5,0)";
    assert!(radius(back, 38, [0., 5., 0.])[6][1] < 0.0);
}

#[test]
fn errors_name_line_and_column() {
    for (text, expected) in [
        ("GOTO/1,2", "1:1: GOTO takes three or six numbers"),
        ("  GOTO/1,2,x3y%", "1:12: 'X3Y%' is not a number"),
        ("GOTO/1,2,", "1:9: '' is not a number"),
        ("GOTO/1,2,nan", "1:10: 'NAN' is not a number"),
        ("GOTO/1,2,1e99", "1:10: 1E99 is too large"),
        ("GOTO/1,2,3,4,5", "1:1: GOTO takes three or six numbers"),
        ("GOTO/1,2,3,0,0,0", "1:1: the vector has no length"),
        ("FROM/0,0,0\nMULTAX/OFF\nGOTO/1,2,3,0,0,1", "3:1: a tool axis after MULTAX/OFF"),
        ("P1=POINT/1,2,3", "1:1: geometry names are not supported: P1"),
        ("\nCYCLE/DRILL,5", "2:1: CYCLE is not supported, and the path depends on it"),
        ("MACRO/A", "1:1: MACRO is not supported, and the path depends on it"),
        ("GODLTA/1,2,3", "1:1: there is no position to move from: FROM is missing"),
        ("FEDRAT/0", "1:1: a feed must be at least 0.001 mm a minute"),
        ("FEDRAT/1E-300", "1:1: a feed must be at least 0.001 mm a minute"),
        (
            "FROM/0,0,0\nSPINDL/1E-300\nFEDRAT/1,MMPR\nGOTO/1,2,3",
            "4:1: a feed must be at least 0.001 mm a minute",
        ),
        ("FEDRAT/5,FPM", "1:10: the unit 'FPM' is not supported"),
        (
            "FROM/0,0,0\nFEDRAT/1,MMPR\nGOTO/1,0,0",
            "3:1: a feed per revolution needs SPINDL before it",
        ),
        ("UNITS/CM", "1:1: the unit 'CM' is not supported"),
        (
            "FROM/0,0,0\nCIRCLE/5,0,0,3\nGOTO/10,0,0",
            "3:1: an end of the arc is 2.000 off its circle",
        ),
        // Near enough to so small a circle, but there is no direction from its centre.
        (
            "FROM/0,0,0\nCIRCLE/0,0,0,0.04\nGOTO/0.04,0,0",
            "3:1: an end of the arc is 0.040 off its circle",
        ),
        ("FROM/0,0,0\nCIRCLE/5,0,0,5\nRAPID", "2:1: GOTO must follow CIRCLE"),
        (
            "FROM/5,0,0\nTLON,GOFWD/(CIRCLE/0,0,0,5),ON,(POINT/0,5,0)",
            "2:1: INDIRV does not tell the direction of the arc",
        ),
        ("FROM/5,0,0\nTLON,GOFWD/(CIRCLE/0,0,0,5", "2:12: the brackets do not match"),
        ("FROM/0,0,0\nGOTO/1,0,0", "2:1: the file ends without FINI: a part of it may be missing"),
        ("FROM/0,$", "1:1: the file ends within a statement that goes on"),
        ("GOTO/1,2,\u{e9}", "1:10: no statement has the character 0xc3"),
        ("5/1", "1:1: a statement begins with a word"),
    ] {
        let text = if text.contains("FINI") { text.to_owned() } else { format!("{text}\n") };
        let text = text.strip_suffix("$\n").map_or(text.clone(), |t| format!("{t}$\n"));
        let error = Part::parse(text.as_bytes()).unwrap_err();
        assert_eq!(error.to_string(), expected, "{text}");
    }
    let long = format!("GOTO/{}1", "0".repeat(1000));
    assert_eq!(Part::parse(long.as_bytes()).unwrap_err().problem, Problem::LongLine);
    let many = format!("GOTO/{}", "$\n".repeat(200));
    assert_eq!(Part::parse(many.as_bytes()).unwrap_err().problem, Problem::LongStatement);
    let large = vec![b' '; hal_arm::apt::MAX_BYTES + 1];
    assert_eq!(Part::parse(&large).unwrap_err().problem, Problem::TooLarge);
    let points = "GOTO/1,2,3\n".repeat(hal_arm::apt::MAX_POINTS + 1);
    assert_eq!(Part::parse(points.as_bytes()).unwrap_err().problem, Problem::TooManyPoints);
    let huge = "FROM/1E7,0,0\nCIRCLE/0,0,0,1E7\nGOTO/-1E7,0,0\nFINI\n".repeat(20);
    assert!(Part::parse(huge.as_bytes()).is_ok(), "one arc of 70,000 chords");
}

/// Statements with arguments by chance: each file is read or refused at one of its lines, and soon.
#[test]
fn statements_by_chance_are_refused_or_read() {
    const WORDS: &[&str] = &[
        "FROM/",
        "GOTO/",
        "GODLTA/",
        "RAPID",
        "FEDRAT/",
        "SPINDL/",
        "TLAXIS/",
        "MULTAX/",
        "UNITS/",
        "CIRCLE/",
        "INDIRV/",
        "TLON,GOFWD/",
        "PARTNO ",
        "PPRINT ",
        "CUTTER/",
        "LOOPST",
        "X=",
    ];
    const PARTS: &[&str] = &[
        "0", "1", "-1", "1E7", "-1E7", "1E-300", "1E400", "NAN", "INF", "+-", ".", "E", "5D2", ",",
        ",", ",", "/", "(", ")", "(CIRCLE/", "ON", "OFF", "MM", "INCHES", "MMPR", "MMPM", "$",
        "$\n", "$$", "\r", "\t", "\0", "\x1b[2J", "\u{e9}", "\u{feff}",
    ];
    let (mut read, mut points) = (0, 0);
    for seed in 1..4000_u64 {
        let mut random = Random(seed);
        let mut draw = |n: usize| {
            let at = random.between(0.0, n as f64);
            (1..n).take_while(|k| *k as f64 <= at).count()
        };
        let mut text = String::from("FROM/0,0,0\n");
        for _ in 0..draw(6) {
            text.push_str(WORDS[draw(WORDS.len())]);
            let is_right = draw(3) > 0;
            for n in 0..draw(8) {
                let number = ["0", "1", "2.5", "-3", "1E7", "1E-300"][draw(6)];
                let comma = if n > 0 { "," } else { "" };
                if is_right {
                    text.push_str(&format!("{comma}{number}"));
                } else {
                    text.push_str(PARTS[draw(PARTS.len())]);
                }
            }
            text.push('\n');
        }
        text.push_str("FINI\n");
        let lines = u32::try_from(text.split('\n').count()).unwrap_or(0);
        match Part::parse(text.as_bytes()) {
            Ok(part) => {
                (read, points) = (read + 1, points + part.points.len());
                for p in &part.points {
                    let is_slow =
                        matches!(p.motion, Motion::Feed(Some(f)) if !(1e-5..1e7).contains(&f));
                    assert!(!is_slow && p.place.iter().all(|x| x.is_finite()), "{text}: {p:?}");
                    assert!((p.axis.norm() - 1.0).abs() < 1e-9, "{text}: {p:?}");
                }
            }
            Err(error) => assert!((1..=lines).contains(&error.line), "{text}: {error}"),
        }
    }
    assert!(read > 500 && points > 1000, "{read} files with {points} points");
}

#[test]
fn cut_and_damaged_files_are_refused_or_read() {
    // Every beginning of a file is refused, as FINI is missing.
    let whole = PLATE.trim_end();
    for end in 0..whole.len() {
        if !whole.is_char_boundary(end) {
            continue;
        }
        assert!(Part::parse(&whole.as_bytes()[..end]).is_err(), "{end}");
    }
    // Any byte in any place: an error that names a line of the file, or a part whose numbers are finite.
    let lines = u32::try_from(PLATE.lines().count()).unwrap();
    for at in 0..PLATE.len() {
        for byte in [0, b'\n', b'$', b'/', b',', b'(', b'9', b'-', b'E', b'A', 0xff] {
            let mut bytes = PLATE.as_bytes().to_vec();
            bytes[at] = byte;
            match Part::parse(&bytes) {
                Ok(part) => {
                    assert!(part.points.iter().all(|p| p.place.iter().all(|x| x.is_finite())));
                }
                Err(error) => assert!((1..=lines + 2).contains(&error.line), "{error}"),
            }
        }
    }
}
