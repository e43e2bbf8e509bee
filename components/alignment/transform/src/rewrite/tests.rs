//! Goldens, every row of the table of the reference, refusals, random programs.

use super::*;
use crate::{Matrix, Parts};

fn similar(turn: f64, scale: f64, x: f64, y: f64) -> Transform {
    let shift = Vector::new(x, y);
    Transform::from_parts(&Parts { turn, scale_x: scale, scale_y: scale, shear: 0.0, shift })
}

fn stretched() -> Transform {
    Transform { linear: Matrix::new(1.2, 0.0, 0.0, 1.1), shift: Vector::ZERO }
}

fn turned_about(turn: f64, x: f64, y: f64) -> Transform {
    let linear = Matrix::rotation(turn.to_radians());
    let at = Vector::new(x, y);
    Transform { linear, shift: at - linear * at }
}

fn run(text: &str, transform: &Transform, options: &Rules) -> Result<String, String> {
    match rewrite(text.as_bytes(), transform, options) {
        Ok(done) => Ok(String::from_utf8(done.text).unwrap()),
        Err(refusals) => {
            let say = |r: &Refusal| format!("{}:{}: {}", r.line, r.column, r.reason);
            Err(refusals.iter().map(say).collect::<Vec<_>>().join("\n"))
        }
    }
}

fn done(text: &str, transform: &Transform) -> String {
    run(text, transform, &Rules::default()).unwrap()
}

fn refused(text: &str, transform: &Transform) -> String {
    run(text, transform, &Rules::default()).unwrap_err()
}

#[test]
fn the_sample_of_the_reference() {
    let text = "%\nN0001 G17 G21 G40 G90\nN0002 T1 M06\nN0003 S10000 M3 G4 P5 (delay 58 segs)\n\
        N0004 G0 X0.5000 Y0.5000 Z0.5000\nN0005 G1 Z-1.0000 F2000.\nN0006 X9.5000 F1500.\n\
        N0007 Y9.5000\nN0008 X0.5000\nN0009 Y0.5000\nN0010 G0 Z0.5000\nN0011 M30\n%\n";
    let wanted = "%\nN0001 G17 G21 G40 G90\nN0002 T1 M06\nN0003 S10000 M3 G4 P5 (delay 58 segs)\n\
        N0004 G0 X0.5000 Y0.5000 Z0.5000\nN0005 G1 Z-1.0000 F2000.\nN0006 X9.3633 Y2.0628 F1500.\n\
        N0007 X7.8004 Y10.9261\nN0008 X-1.0628 Y9.3633\nN0009 X0.5000 Y0.5000\nN0010 G0 Z0.5000\n\
        N0011 M30\n%\n";
    assert_eq!(done(text, &turned_about(10.0, 0.5, 0.5)), wanted);
}

#[test]
fn arcs_of_the_reference() {
    let similar = similar(30.0, 1.5, 10.0, 20.0);
    assert_eq!(
        done("G0 X0 Y0\nG2 X10 Y0 I5 J0\n", &similar),
        "G0 X10.0000 Y20.0000\nG2 X22.9904 Y27.5000 I6.4952 J3.7500\n"
    );
    assert_eq!(
        done("G0 X0 Y0\nG2 X10 Y0 R5\n", &similar),
        "G0 X10.0000 Y20.0000\nG2 X22.9904 Y27.5000 R7.5000\n"
    );
    let circle = rewrite(b"G0 X10 Y0\nG3 I-10\n", &stretched(), &Rules::default()).unwrap();
    assert_eq!((circle.arcs, circle.chords), (1, 109));
    assert_eq!(circle.text.iter().filter(|b| **b == b'\n').count(), 110);
}

#[test]
fn blocks_without_coordinates_keep_every_byte() {
    let text = "%\r\n O100 \r\n(X1 Y2)\t; I J R\r\n n5 g0\tz 1 . 5 a3 b-4 c+5 f 100 m3 s1e\r\n";
    assert!(refused(text, &stretched()).contains("4:"), "a bad number is refused");
    let text = "%\r\n(X1 Y2)\t; I J R\r\n n5 g0\tz 1 . 5 a3 b-4 c+5 f 100 m3 s1\r\n\r\n#5=[1+2]\r\nM19 R90\r\ng64 p.1\r\n%\r\nwhatever (";
    assert_eq!(done(text, &similar(33.0, 1.3, 4.0, 5.0)), text);
}

#[test]
fn every_row_of_the_table() {
    let t = similar(90.0, 2.0, 100.0, 0.0);
    let even = |text: &str, wanted: &str| assert_eq!(done(text, &t), wanted, "{text}");
    // Distance modes, a missing coordinate, blanks and letters as the line has them.
    even("g1 x1\ty2 f5\nY3\n", "g1 x96.0000\ty2.0000 f5\nX94.0000 Y2.0000\n");
    even("G1X1Y2F5\nY3F6\n", "G1X96.0000Y2.0000F5\nX94.0000 Y2.0000F6\n");
    even("G91 G1 X1\n", "G91 G1 X0.0000 Y2.0000\n");
    even("G1 X 1 Y 2 ( X9 )\n", "G1 X 96.0000 Y 2.0000 ( X9 )\n");
    // Arcs: incremental and absolute centres, a full circle, a helix, a radius with its sign.
    even(
        "G0 X1 Y0\nG2 X0 Y1 I-1 Z5\n",
        "G0 X100.0000 Y2.0000\nG2 X98.0000 Y0.0000 I0.0000 J-2.0000 Z5\n",
    );
    even("G90.1\nG0 X1 Y0\nG3 I0 J0\n", "G90.1\nG0 X100.0000 Y2.0000\nG3 I100.0000 J0.0000\n");
    even("G0 X1 Y0\nG3 X0 Y1 R-1\n", "G0 X100.0000 Y2.0000\nG3 X98.0000 Y0.0000 R-2.0000\n");
    // Cycles: R is a height; incremental repetitions take the linear part.
    even("G98 G81 X1 Y2 Z-3 R4\nX5\n", "G98 G81 X96.0000 Y2.0000 Z-3 R4\nX96.0000 Y10.0000\n");
    even("G91 G81 X1 Y0 Z-3 R4 L3\n", "G91 G81 X0.0000 Y2.0000 Z-3 R4 L3\n");
    // Inches: the transform stays in millimetres.
    assert_eq!(
        done("G20 G0 X1 Y0\n", &similar(0.0, 1.0, 25.4, 2.54)),
        "G20 G0 X2.00000 Y0.10000\n"
    );
    // Machine coordinates, and the unknown position behind them.
    even(
        "G0 X1 Y1\nG53 G0 X5 Y5\nG0 X2 Y2\n",
        "G0 X98.0000 Y2.0000\nG53 G0 X5 Y5\nG0 X96.0000 Y4.0000\n",
    );
    assert!(
        refused("G0 X1 Y1\nG53 G0 X5\nG0 X2\n", &t).starts_with("3:0: the turned block needs Y")
    );
    // Returns.
    even("G28 X1 Y1 Z5\n", "G28 X98.0000 Y2.0000 Z5\n");
    even("G91 G28 X0 Z0\n", "G91 G28 X0 Z0\n");
    assert!(refused("G28 X1\n", &t).contains("G28 with one of X and Y"));
    assert!(refused("G28 X1 Y1\nG0 X1\n", &t).starts_with("2:"));
    // A shift alone writes no word that was not there.
    assert_eq!(done("G1 X1\n", &similar(0.0, 1.0, 5.0, 6.0)), "G1 X6.0000\n");
    // Never -0.
    assert_eq!(done("G0 X-0.00001 Y0\n", &similar(0.0, 1.0, 0.0, 0.0)), "G0 X0.0000 Y0.0000\n");
}

#[test]
fn mirrored_parts_exchange_left_and_right() {
    let back = Transform { linear: Matrix::new(-1.0, 0.0, 0.0, 1.0), shift: Vector::ZERO };
    assert_eq!(
        done("G42 D1 G1 X1 Y0 F9\nG02 X3 Y0 I1\nX5 Y0 I1\nG41.1 D3\n", &back),
        "G41 D1 G1 X-1.0000 Y0.0000 F9\nG03 X-3.0000 Y0.0000 I-1.0000\nX-5.0000 Y0.0000 I-1.0000\nG42.1 D3\n"
    );
}

#[test]
fn arcs_under_unequal_scales_become_lines_or_are_refused() {
    let options = Rules { tolerance: 0.5, ..Rules::default() };
    assert_eq!(
        run(
            "G0 X10 Y0 Z1\nN7 G3 X-10 I-10 Z3 F50 (c)\nX10 I10 Z1\nG1 X0\n",
            &stretched(),
            &options
        )
        .unwrap(),
        "G0 X12.0000 Y0.0000 Z1\n\
         N7 G1 X10.3923 Y5.5000 Z1.3333 F50 (c)\nX6.0000 Y9.5263 Z1.6667\nX0.0000 Y11.0000 Z2.0000\n\
         X-6.0000 Y9.5263 Z2.3333\nX-10.3923 Y5.5000 Z2.6667\nX-12.0000 Y0.0000 Z3.0000\n\
         X-10.3923 Y-5.5000 Z2.6667\nX-6.0000 Y-9.5263 Z2.3333\nX0.0000 Y-11.0000 Z2.0000\n\
         X6.0000 Y-9.5263 Z1.6667\nX10.3923 Y-5.5000 Z1.3333\nX12.0000 Y0.0000 Z1.0000\nG1 X0.0000\n"
    );
    // A small arc is within the tolerance; it needs its own code again behind lines.
    assert_eq!(
        run(
            "G0 X10 Y0\nG3 X-10 Y0 R10\nX-11 Y0 I-0.5\n",
            &stretched(),
            &Rules { tolerance: 2.0, ..options.clone() }
        )
        .unwrap(),
        "G0 X12.0000 Y0.0000\nG1 X6.0000 Y9.5263\nX-6.0000 Y9.5263\nX-12.0000 Y0.0000\nG3 X-13.2000 Y0.0000 I-0.6000\n"
    );
    let none = Rules { arcs: Arcs::Refuse, ..options };
    let text = run("G0 X10 Y0\n\nG3 I-10\nG1 X1\n", &stretched(), &none).unwrap_err();
    assert!(
        text.starts_with("3:0: the aligned part has unequal scales") && text.lines().count() == 1
    );
    // Other planes keep their arcs under a shift alone.
    let shift = similar(0.0, 1.0, 5.0, 6.0);
    assert_eq!(
        done("G18\nG0 X0 Y0 Z0\nG2 X10 I5\n", &shift),
        "G18\nG0 X5.0000 Y6.0000 Z0\nG2 X15.0000 I5\n"
    );
    let lines = done("G18\nG0 X0 Y0 Z0\nG2 X10 I5\n", &similar(90.0, 1.0, 0.0, 0.0));
    assert!(
        lines.contains("\nG1 X0.0000 Y0.") && lines.ends_with("X0.0000 Y10.0000 Z0.0000\n"),
        "{lines}"
    );
}

#[test]
fn what_cannot_be_kept_is_refused_by_line() {
    let t = similar(10.0, 1.0, 0.0, 0.0);
    for (text, wanted) in [
        ("G1 X1", "1:0: the turned block needs Y too"),
        ("G92 X1 Y1", "1:1: G92 has coordinates of its own"),
        ("G52 X1", "1:1: G52 has coordinates of its own"),
        ("G10 L2 P1 X0", "1:1: G10 has coordinates of its own"),
        ("G10 L2 P1 R5", "1:1: G10 has coordinates of its own"),
        ("G54\nG55", "2:1: a second coordinate system"),
        ("G68 X1 Y1 R5", "1:1: G68 has coordinates of its own"),
        ("G0 @5 ^3", "1:4: polar coordinates"),
        ("G0 X#1 Y2", "1:4: the value of X is an expression"),
        ("G0 X[1+2] Y2", "1:4: the value of X is an expression"),
        ("G5 X1 Y1 I0 J1 P0 Q1", "1:0: G5 has coordinates of its own"),
        ("G76 X1 P1", "1:0: G76 has coordinates of its own"),
        ("G7", "1:1: G7 has coordinates of its own"),
        ("G0 X1 Y1 U3", "1:10: U belongs to a second pair"),
        ("G18 G81 X1 Y1 Z1 R1", "1:0: a cycle can be aligned in the plane G17 only"),
        ("G80 X1 Y1", "1:5: X has no meaning"),
        ("G1 X1 Y1 I5", "1:10: I has no meaning"),
        ("X1 Y1 I5 J5", "1:7: an arc or a straight line"),
        ("G0 X0 Y0\nG2 X5 Y0", "2:0: an arc needs its end, and its centre"),
        ("/G91", "1:0: block delete (/) may leave out this mode"),
        ("o<else> call", "1:0: this subroutine is not in this file"),
        ("M98 P5", "1:1: this subroutine is not in this file"),
        ("M70\nG91\nM72\nG1 X1 Y1", "3:1: M72 restores modes"),
        ("M73", "1:1: M73 restores modes"),
        ("G1 X", "1:"),
        ("G1 (X", "1:4: Unclosed comment"),
        (
            "o1 if [1]\nG0 X1 Y1\nG91\nX1\no1 endif",
            "1:0: a program with O-words must keep one plane",
        ),
        // Modes that change where nothing is rewritten, and reach what is.
        (
            "G21 G90\no1 if [#1 EQ 1]\nG91\no1 endif\nG1 X10 Y10 F100\nM2",
            "2:0: a program with O-words must keep one plane",
        ),
        (
            "G90\no1 if [#1 EQ 1]\nG20\no1 endif\nG1 X10 Y10 F100\nM2",
            "2:0: a program with O-words must keep one plane",
        ),
        (
            "G90 G0 X1 Y1\no<down> sub\nG91 G1 Z-1\no<down> endsub\no<down> call\nG1 X5 Y5\nM2",
            "2:0: a program with O-words must keep one plane",
        ),
        (
            "o<a> sub\nG1 X1 Y2\no<a> endsub\nG20\no<a> call\nM2",
            "1:0: a program with O-words must keep one plane",
        ),
    ] {
        let said = refused(&format!("{text}\n"), &t);
        assert!(said.starts_with(wanted), "{text}: {said}");
    }
    let stop = "G0 X10 Y0\nG3 I-10 M30\n";
    assert!(
        refused(stop, &stretched())
            .starts_with("2:0: this arc must become lines, and its block ends")
    );
    let inverse = "G21\no1 if [#1]\nG0 X10 Y0\nG3 I-10 F2\no1 endif\nG93\n";
    assert!(
        refused(inverse, &stretched()).contains("2:0: this arc must become lines, and its feed")
    );
    let inverse = "G93 G0 X10 Y0\nG3 I-10 F2\n";
    assert!(refused(inverse, &stretched()).contains("inverse time"));
    let singular = Transform { linear: Matrix::new(1.0, 2.0, 2.0, 4.0), shift: Vector::ZERO };
    assert_eq!(refused("G0 X1 Y1\n", &singular), "0:0: the transform has no inverse");
    // A refused block does not hide the next one.
    assert_eq!(refused("G5.1 X1 Y1 I1\nG0 X1 Y1\nX2\nG5.1 X1 Y1 I1\n", &t).lines().count(), 2);
}

#[test]
fn a_start_and_parameters_can_be_given() {
    let t = similar(90.0, 1.0, 0.0, 0.0);
    let start = Rules { start: Some(Vector::new(3.0, 4.0)), ..Rules::default() };
    assert_eq!(run("G1 X1\n", &t, &start).unwrap(), "G1 X-4.0000 Y1.0000\n");
    let expand = Rules { expand: true, ..Rules::default() };
    assert_eq!(
        run("#1=2 #<w>=[3*2]\nG1 X#1 Y[#<w>+0.5]\n", &t, &expand).unwrap(),
        "#1=2 #<w>=[3*2]\nG1 X-6.5000 Y2.0000\n"
    );
    // A parameter that flow control may have changed is not known.
    let text = "#1=2\no1 while [#1 LT 9]\n#1=[#1+1]\no1 endwhile\nG1 X#1 Y0\n";
    assert!(run(text, &t, &expand).unwrap_err().starts_with("5:4: the value of X"));
}

/// The machine sets the parameters from 5061 on; what the program wrote into them says nothing.
#[test]
fn parameters_of_the_machine_are_not_known() {
    let t = similar(0.0, 1.0, 100.0, 50.0);
    let expand = Rules { expand: true, ..Rules::default() };
    for n in [5061, 5070, 5161, 5221, 5399, 5400, 5420, 5601] {
        let text = format!("#{n}=3\nG38.2 Z-5 F50\nG1 X#{n} Y1\n");
        assert!(run(&text, &t, &expand).unwrap_err().starts_with("3:4: the value of X"), "{n}");
    }
    let own = "#5000=3\nG38.2 Z-5 F50\nG1 X#5000 Y1\n";
    assert!(run(own, &t, &expand).unwrap().ends_with("G1 X103.0000 Y51.0000\n"));
}

#[test]
fn the_unit_before_g20_and_g21_is_that_of_the_machine() {
    let t = similar(0.0, 1.0, 25.4, 2.54);
    let inches = Rules { inches: true, ..Rules::default() };
    assert_eq!(run("G0 X1 Y0\n", &t, &inches).unwrap(), "G0 X2.00000 Y0.10000\n");
    for (text, is_assumed) in [
        ("G0 X1 Y1\nG21\n", true),
        ("G21 G0 X1 Y1\n", false),
        ("G0 Z5\nG20\nG0 X1 Y1\n", false),
        ("G0 Z5\n", false),
    ] {
        let done = rewrite(text.as_bytes(), &t, &Rules::default()).unwrap();
        assert_eq!(done.unit_is_assumed, is_assumed, "{text}");
    }
}

#[test]
fn flow_control_stays_where_it_can_be_followed() {
    let t = similar(90.0, 1.0, 0.0, 0.0);
    assert_eq!(
        done("o<a> sub\nG1 X1 Y2\no<a> endsub\no<a> call\nG1 X3 Y4\nM2\n", &t),
        "o<a> sub\nG1 X-2.0000 Y1.0000\no<a> endsub\no<a> call\nG1 X-4.0000 Y3.0000\nM2\n"
    );
    let pecks = "G90\no1 repeat [3]\nG1 X1 Y2\nG91\nZ-1\nG90\nX3 Y4\no1 endrepeat\nM2\n";
    assert!(done(pecks, &t).contains("\nG91\nZ-1\nG90\n"));
    let preamble = "O100\nG20 G90\nG18\nG17\no1 if [#1]\nG1 X1 Y2\no1 endif\nG90 G1 X3 Y4\nM2\n";
    assert!(done(preamble, &t).contains("\nG90 G1 X-4.00000 Y3.00000\n"));
    assert!(refused("o1 repeat [5]\nG1 X1\no1 endrepeat\n", &t).starts_with("2:"));
}

#[test]
fn a_header_names_transform_and_source() {
    let options = Rules { header: Some("a(b).ngc".to_owned()), ..Rules::default() };
    let text = run("\n%\nG0 X1 Y1\n", &similar(0.0, 1.0, 1.0, 2.0), &options).unwrap();
    let crc = crc32(b"\n%\nG0 X1 Y1\n");
    assert_eq!(
        text,
        format!(
            "\n%\n(aligned: turn 0.00000 deg, scale X 1.000000, scale Y 1.000000, squareness 0.0000 deg, shift X 1.0000 Y 2.0000 mm; source a_b_.ngc, CRC-32 {crc:08x})\nG0 X2.0000 Y3.0000\n"
        )
    );
    assert_eq!(crc32(b"123456789"), 0xcbf4_3926);
}

/// Numbers that repeat.
struct Random(u64);

impl Random {
    fn next(&mut self, below: u64) -> u64 {
        self.0 =
            self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 33) % below
    }
}

#[test]
fn bytes_of_any_kind_never_panic_and_other_blocks_never_change() {
    let mut random = Random(7);
    let pieces: &[&str] = &[
        "G0",
        "G1",
        "G2",
        "G3",
        "G90",
        "G91",
        "G90.1",
        "G91.1",
        "G20",
        "G21",
        "G81",
        "G80",
        "X1",
        "Y2.5",
        "X-3",
        "Y",
        "I1",
        "J-2",
        "R5",
        "Z1",
        "F100",
        "M3",
        "M30",
        "(c)",
        "; e",
        "#1=2",
        "X#1",
        "[",
        "]",
        " ",
        "\t",
        "/",
        "%",
        "o1",
        "o1 sub",
        "o1 endsub",
        "G53",
        "G28",
        "G54",
        "é",
        "\u{0}",
        "N5",
        "P2",
        "L3",
        "G41",
        "-",
        ".",
    ];
    let transforms = [similar(30.0, 1.0, 5.0, 5.0), stretched()];
    let mut rewritten = 0;
    for round in 0..20_000 {
        let mut text = String::new();
        for _ in 0..random.next(6) + 1 {
            for _ in 0..random.next(7) {
                text.push_str(pieces[usize::try_from(random.next(pieces.len() as u64)).unwrap()]);
                if random.next(2) == 0 {
                    text.push(' ');
                }
            }
            text.push_str(if random.next(2) == 0 { "\n" } else { "\r\n" });
        }
        let options = Rules { expand: round % 2 == 0, ..Rules::default() };
        let Ok(out) = rewrite(text.as_bytes(), &transforms[round % 2], &options) else { continue };
        rewritten += out.changed;
        let out = String::from_utf8(out.text).unwrap();
        for line in text.lines().filter(|l| !l.contains(['X', 'Y', 'I', 'J', 'R'])) {
            assert!(out.lines().any(|o| o == line), "{line:?} is missing:\n{text}\n{out}");
        }
    }
    assert!(rewritten > 250, "{rewritten} blocks");
}
