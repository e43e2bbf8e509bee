//! G-code as lines of the protocol: the dialects of one program, arcs, the work volume.
#![expect(clippy::unwrap_used, reason = "tests")]

use robot::{Command, Failed, Record, Volume, convert};

const ZERO: [f64; 3] = [-400.0, 0.0, -30.0];

fn lines(text: &str) -> Vec<Record> {
    convert(text.as_bytes(), &Volume::default(), &ZERO, 15.0).unwrap().0
}

fn moves(text: &str) -> Vec<Command> {
    lines(text).iter().map(|r| r.command).filter(|c| c.target().is_some()).collect()
}

const DIALECTS: [&str; 3] = [
    "G0 X42.085 Y7.07
N70 G43 Z10. H72 M09
N80 G1 Z-0.25 F800
N90 X42.179 Y7.136 Z0.
N100 X42.325 Y7.067 Z-0.25
N110 X43.153 Y7.246
N120 X43.372 Y7.43
N130 X43.339 Y7.493 Z0.
N140 X43.369 Y7.525 Z10.
N150 X43.477 Y7.548 Z-0.25
N160 X43.742 Y8.065
",
    "N40 G0 Z10
N50 G0 X42.085 Y7.07 S1500 M3
N60 G1 Z-0.25 F500
N70 G1 X42.179 Y7.136 Z0
N80 G1 X42.325 Y7.067 Z-0.25
N90 G1 X43.153 Y7.246
N100 G1 X43.372 Y7.43
N110 G1 X43.339 Y7.493 Z0
N120 G1 X43.369 Y7.525 Z10
N130 G1 X43.477 Y7.548 Z-0.25
",
    "N20G0Z10.
N30X42.085Y7.07
N40G1Z-0.25F500
N50X42.179Y7.136Z0.
N60X42.325Y7.067Z-0.25
N70X43.153Y7.246
N80X43.372Y7.43
N90X43.339Y7.493Z0.
N100X43.369Y7.525Z10.
N110X43.477Y7.548Z-0.25
",
];

#[test]
fn three_dialects_give_the_same_motion() {
    let [first, second, third] = DIALECTS.map(moves);
    assert_eq!(second, third);
    assert_eq!(first[..second.len()], second[..]);
    assert_eq!(first.len(), second.len() + 1);
    assert_eq!(second[0].to_string(), "JMOVE,42.085,7.070,10.000");
    assert_eq!(second[1].to_string(), "LMOVE,42.085,7.070,-0.250");
    assert_eq!(second.last().unwrap().to_string(), "LMOVE,43.477,7.548,-0.250");
    let speeds = lines(DIALECTS[1])
        .iter()
        .map(|r| r.command.to_string())
        .filter(|c| c.starts_with('S'))
        .collect::<Vec<_>>();
    assert_eq!(speeds, ["SPEED,8.333"], "mm/min become mm/s");
    let capped = convert(DIALECTS[1].as_bytes(), &Volume::default(), &ZERO, 5.0).unwrap();
    assert!(capped.0.iter().any(|r| r.command == Command::Speed(5.0)));
    assert_eq!(capped.1, ["line 2: the spindle is turned on and off by hand"]);
}

/// The question about the tool comes before the move, and the answer to it makes the move and ends the program.
#[test]
fn what_stands_beside_a_tool_change_is_not_lost() {
    assert_eq!(moves("F300\nT1 M6 G1 X9 M2\n"), [Command::Cut([9.0, 0.0, 10.0])]);
}

fn at(command: &Command) -> [f64; 3] {
    command.target().unwrap()
}

#[test]
fn arcs_are_moves_of_one_degree() {
    let close = |a: [f64; 3], b: [f64; 3]| a.iter().zip(b).all(|(a, b)| (a - b).abs() < 6e-4);
    for (begin, arc, count, index, place) in [
        ("X0 Y5 Z0", "G2 X5 Y0 R5", 90, 1, [0.087, 4.999, 0.]),
        ("X0 Y5 Z0", "G2 X5 Y0 R5", 90, 45, [3.536, 3.536, 0.]),
        ("X0 Y0 Z0", "G3 X10 Y0 R5", 180, 90, [5., -5., 0.]),
        ("X0 Y0 Z0", "G2 X10 Y0 R5", 180, 90, [5., 5., 0.]),
        ("X0 Y5 Z0", "G2 X5 Y0 R-5", 270, 1, [0.001, 5.087, 0.]),
        ("X5 Y0 Z0", "G2 I-5", 360, 180, [-5., 0., 0.]),
        ("X5 Y0 Z0", "G3 X0 Y5 Z-9 R5", 90, 45, [3.536, 3.536, -4.5]),
        ("X5 Y0 Z0", "G3 X0 Y5 I-5 J0", 90, 90, [0., 5., 0.]),
        ("X0 Y0 Z0", "G20 G3 X0.2 Y0 R0.1", 180, 180, [5.08, 0., 0.]),
        ("X0 Y0 Z0", "G91 G3 X10 Y0 R5", 180, 180, [10., 0., 0.]),
    ] {
        let all = moves(&format!("F300\nG1 {begin}\n{arc}\n"));
        let arc_moves = &all[1..];
        assert_eq!(arc_moves.len(), count, "{arc}");
        let found = at(&arc_moves[index - 1]);
        assert!(close(found, place), "{arc}: {found:?}");
    }
    let records = lines("F300\nG1 Z0\nG2 I5\n");
    let texts: Vec<&str> = records.iter().map(|r| r.text.as_str()).collect();
    assert_eq!(texts[..4], ["G1 Z0", "", "G2 I5", ""], "further moves of a line have no text");
}

/// The last move of an arc goes to the end that the program states, to the last digit, whatever its sweep.
#[test]
fn an_arc_ends_exactly_at_its_end() {
    for (degrees, count) in [(0.5, 1), (1.0, 1), (1.5, 2), (89.5, 90), (180.0, 180), (359.5, 360)] {
        for code in ["G2", "G3"] {
            let angle = f64::to_radians(if code == "G2" { -degrees } else { degrees });
            let short = |v: f64| format!("{v:.4}");
            let end = [short(20.0 * angle.cos()), short(20.0 * angle.sin())];
            let text =
                format!("F300\nG1 X20 Y0 Z0\n{code} X{} Y{} Z-3 I-20\nG1 Y9\n", end[0], end[1]);
            let all = moves(&text);
            // Rounding of the end to four decimals may reach the next degree.
            let arc = all.len() - 2;
            assert!(arc == count || arc == count + 1, "{code} {degrees}: {arc} moves");
            let [x, y] = end.map(|v| v.parse::<f64>().unwrap());
            let last = all.get(arc).map(at).unwrap();
            let off = last.iter().zip([x, y, -3.0]).map(|(a, b)| (a - b).abs());
            assert!(off.fold(0.0, f64::max) < 1e-9, "{code} {degrees}: {last:?}");
            assert_eq!(all.get(arc + 1).map(at).unwrap()[0], last[0], "the next line begins there");
        }
    }
}

/// Blank lines, comments, line numbers alone, and lines without coordinates make no move, and end nothing.
#[test]
fn lines_without_coordinates_make_no_move() {
    let text =
        "N10 G0 X1 Z5\n\n   \n(a comment)\nN20\nM3 S1000\nF300\nG1 X2\n\n\nM8\nN30 X3\n\nG90\n";
    let places: Vec<f64> = moves(text).iter().map(|c| at(c)[0]).collect();
    assert_eq!(places, [1.0, 2.0, 3.0]);
}

#[test]
fn every_point_is_checked_before_anything_moves() {
    let refused = |text: &str| {
        convert(text.as_bytes(), &Volume::default(), &ZERO, 5.0).unwrap_err().to_string()
    };
    assert_eq!(Volume::robot(&ZERO, [42.085, 7.07, 10.0]), [-407.07, 42.085, -20.0]);
    assert_eq!(
        refused("G0 X42 Y7\nG0 X100 Y100 Z100\n"),
        "line 2: X100.000 Y100.000 Z100.000 is outside the work volume: robot Z 70.000 > 40"
    );
    // The ends of this arc are inside, its middle is not.
    let arc = "F300\nG1 X-10 Y145 Z0\nG2 X10 Y145 R10\n";
    assert!(refused(arc).starts_with("line 3: X"), "{}", refused(arc));
    assert!(refused(arc).contains("robot X -55"), "{}", refused(arc));
    for (text, part) in [
        ("G18 F100\nG2 X2 Z10 I1 K0\n", "arcs outside G17"),
        ("F100\nG38.2 Z0\n", "a probe"),
        ("G0 A5\n", "A, B and C"),
        ("G95 F1\nG1 X1\n", "a feed per revolution"),
        ("o1 while [1]\no1 endwhile\nM2\n", "does not come to an end"),
    ] {
        assert!(refused(text).contains(part), "{text}: {}", refused(text));
    }
    let long = Volume { tool: 200.0, ..Volume::default() };
    let text = "G0 X0 Y-100 Z-60\n";
    assert!(convert(text.as_bytes(), &Volume::default(), &ZERO, 5.0).is_ok());
    let failed = [-240.0, -120.0, 0.0, 120.0, 240.0].iter().any(|x| {
        let text = format!("G0 X{x} Y140 Z60\n");
        matches!(convert(text.as_bytes(), &long, &ZERO, 5.0), Err(Failed::Outside(..)))
    });
    assert!(failed, "a long tool takes points out of reach");
}
