//! T-mode: the vectors, lines and circles of the reference, arcs by chance, and what it refuses.

use core::f64::consts::TAU;
use std::sync::Arc;

use hal_gcode::{
    Call, Dialect, Interpreter, Issued, Numbered, Settings,
    axis::{AxisMask, Position},
    canon::{Frame, Plane, Unit},
    error::Problem,
    ticks::{Figures, Move, MoveKind, Resolution, Step, Ticks, arc, line},
};

use crate::support::{World, run_with};

fn steps(from: [i64; 3], to: [i64; 3], clockwise: bool) -> Vec<Step> {
    let mut out = Vec::new();
    arc(from, to, clockwise, &mut |s| out.push(s));
    out
}

fn sum(steps: &[Step]) -> [i64; 3] {
    steps.iter().fold([0; 3], |[x, y, z], s| {
        [x + i64::from(s[0]), y + i64::from(s[1]), z + i64::from(s[2])]
    })
}

#[test]
fn a_line_has_the_ticks_of_the_reference() {
    let ticks: Vec<Step> = line([5, 2, -1]).collect();
    assert_eq!(ticks, [[1, 0, 0], [1, 1, 0], [1, 0, -1], [1, 1, 0], [1, 0, 0]]);
    assert_eq!(line([0, 0, 0]).count(), 0);
    // Every direction, and every axis as the longest.
    for x in -9..=9_i64 {
        for y in -9..=9_i64 {
            for z in -9..=9_i64 {
                let ticks: Vec<Step> = line([x, y, z]).collect();
                let longest = x.abs().max(y.abs()).max(z.abs());
                assert_eq!(ticks.len(), usize::try_from(longest).unwrap());
                assert_eq!(sum(&ticks), [x, y, z]);
                let mut at = [0_i64; 3];
                for (n, step) in (1_i64..).zip(&ticks) {
                    for ((at, step), way) in at.iter_mut().zip(step).zip([x, y, z]) {
                        *at += i64::from(*step);
                        // Half a step from the line.
                        assert!((2 * (*at * longest - way * n)).abs() <= longest);
                    }
                }
            }
        }
    }
}

#[test]
fn arcs_have_the_ticks_of_the_reference() {
    let quarter = steps([10, 0, 0], [0, 10, 0], false);
    let flat: Vec<[i8; 2]> = quarter.iter().map(|s| [s[0], s[1]]).collect();
    let wanted = [
        [0, 1],
        [0, 1],
        [0, 1],
        [-1, 1],
        [0, 1],
        [-1, 1],
        [-1, 1],
        [-1, 1],
        [-1, 1],
        [-1, 0],
        [-1, 1],
        [-1, 0],
        [-1, 0],
        [-1, 0],
    ];
    assert_eq!(flat, wanted);
    assert_eq!(steps([10, 0, 0], [0, 10, 0], true).len(), 42);
    assert_eq!(steps([2, 0, 0], [2, 0, 0], false).len(), 12);
    assert_eq!(steps([1, 0, 0], [0, 1, 0], false).len(), 1);
    // The arcs of the two parts, at 4000 steps to the inch.
    assert_eq!(steps([0, -1000, 0], [0, 1000, 0], true).len(), 2828);
    assert_eq!(steps([0, -2000, 0], [0, 2000, 0], true).len(), 5656);
    assert_eq!(steps([2000, 0, 0], [0, 2000, 0], false).len(), 2828);
    assert_eq!(steps([0, -500, 0], [0, 500, 0], true).len(), 1414);
}

#[test]
fn whole_circles_stay_within_half_a_step() {
    for r in 1..400_i64 {
        for start in [[r, 0, 0], [-r, 0, 0], [0, r, 0], [0, -r, 0]] {
            for clockwise in [false, true] {
                let ticks = steps(start, start, clockwise);
                let (mut at, mut turned) = (start, 0.0);
                for step in &ticks {
                    let next = [at[0] + i64::from(step[0]), at[1] + i64::from(step[1])];
                    let cross = (at[0] * next[1] - at[1] * next[0]) as f64;
                    let dot = (at[0] * next[0] + at[1] * next[1]) as f64;
                    turned += cross.atan2(dot);
                    at = [next[0], next[1], 0];
                    let off = ((at[0] as f64).hypot(at[1] as f64) - r as f64).abs();
                    assert!(off <= 0.5, "r {r} from {start:?}: {off} at {at:?}");
                }
                assert_eq!(at, start);
                let turned = if clockwise { -turned } else { turned };
                assert!((turned - TAU).abs() < 1e-6, "r {r} turns by {turned}");
            }
        }
    }
}

/// Ticks, moves and the last place.
type Followed = (Vec<Step>, Vec<Move>, [i64; 3]);

/// Follows calls from 0.
fn follow(calls: &[Issued], resolution: Resolution) -> Result<Followed, Problem> {
    let frame = Frame::new(Unit::Inch);
    let mut ticks = Ticks::new(frame, Position::default(), resolution)?;
    let (mut steps, mut moves) = (Vec::new(), Vec::new());
    for call in calls {
        moves.extend(ticks.follow(call, &mut |s| steps.push(s))?);
    }
    Ok((steps, moves, ticks.place()))
}

fn interpreted(text: &str) -> Vec<Issued> {
    let settings = Settings {
        axes: AxisMask(7),
        unit: Unit::Inch,
        program_unit: Unit::Inch,
        dialect: Dialect::Rs274d,
        ..Settings::default()
    };
    let mut it = Interpreter::new(settings, Numbered::default());
    it.load("part.g", Arc::new(text.as_bytes().to_vec()));
    let (calls, error) = run_with(&mut it, &World::new(), |_| {});
    assert_eq!(error, None, "{text}");
    calls
}

struct Random(u64);

impl Random {
    /// Returns a number from 0 to 1.
    fn next(&mut self) -> f64 {
        self.0 =
            self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1_u64 << 53) as f64
    }

    /// Returns a coordinate of four decimals.
    fn coordinate(&mut self, most: f64) -> f64 {
        (most * (2.0 * self.next() - 1.0) * 1e4).round() / 1e4
    }
}

/// 1,000 arcs by chance, as programs: each ends on the step of the end that the interpreter says, and stays near its circle.
#[test]
fn random_arcs_end_exactly_where_the_interpreter_says() {
    let mut random = Random(5);
    let (mut worst, mut tails) = (0.0_f64, 0);
    for case in 0..1000 {
        let (x, y) = (random.coordinate(3.0), random.coordinate(3.0));
        let (i, j) = (random.coordinate(1.0), random.coordinate(1.0));
        let radius = i.hypot(j).max(1e-3);
        let angle = TAU * random.next();
        // The end on the circle, as a program with four decimals has it.
        let round = |v: f64| (v * 1e4).round() / 1e4;
        let (u, v) = (round(x + i + radius * angle.cos()), round(y + j + radius * angle.sin()));
        let code = if case % 2 == 0 { "G02" } else { "G03" };
        let z =
            if case % 5 == 0 { format!(" Z{:.4}", random.coordinate(1.0)) } else { String::new() };
        let text = format!("G00 X{x} Y{y}\n{code} X{u} Y{v} I{i} J{j}{z} F10\n");
        let calls = interpreted(&text);
        let (steps, moves, place) = follow(&calls, Resolution::default()).unwrap();
        let end = calls.iter().find_map(|c| match &c.call {
            Call::ArcFeed { end, .. } => Some(*end),
            _ => None,
        });
        let end = end.unwrap();
        #[expect(clippy::cast_possible_truncation, reason = "a few thousand")]
        let wanted = [end.x, end.y, end.z].map(|v| (v * 4000.0).round() as i64);
        assert_eq!(place, wanted, "{text}");
        assert_eq!(sum(&steps), wanted, "{text}");
        let [_, arc] = moves[..] else { panic!("{text}: {moves:?}") };
        assert_eq!(
            arc.kind,
            if case % 2 == 0 { MoveKind::Clockwise } else { MoveKind::Counterclockwise }
        );
        let from = [x, y].map(|v| (v * 4000.0).round());
        let centre = [(x + i) * 4000.0, (y + j) * 4000.0].map(f64::round);
        let r = (from[0] - centre[0]).hypot(from[1] - centre[1]);
        let mut at = from;
        let count = usize::try_from(arc.ticks).unwrap();
        for (n, step) in steps[steps.len() - count..].iter().enumerate() {
            at = [at[0] + f64::from(step[0]), at[1] + f64::from(step[1])];
            let off = ((at[0] - centre[0]).hypot(at[1] - centre[1]) - r).abs();
            worst = worst.max(off);
            // Half a step on the circle; the rounding of the end, which the last ticks reach, adds up to two steps.
            if off > 0.5 {
                assert!(off <= 2.0 && n + 4 >= count, "{text}: {off} at tick {n} of {count}");
                tails += 1;
            }
        }
    }
    assert!(worst <= 2.0 && tails < 1500, "{worst} steps off, {tails} ticks");
}

/// Ends that fall on the same step do not make a circle of a short arc, nor a point of a long one.
#[test]
fn a_short_arc_is_no_circle_and_a_long_one_no_point() {
    let ticks = |text: &str| follow(&interpreted(text), Resolution::default()).unwrap().0.len();
    assert_eq!(ticks("G00 X1\nG03 X1 Y0.0001 I-1 F10"), 4000);
    assert!(ticks("G00 X1\nG02 X1 Y0.0001 I-1 F10") > 20_000);
    assert_eq!(ticks("G00 X1\nG03 X1 Y0.0001 I-0.001 F10"), 4000);
    assert!(ticks("G00 X1\nG02 X1 Y0 I-1 F10") > 20_000);
}

#[test]
fn a_move_takes_the_time_of_its_length_and_each_tick_a_thousandth_at_least() {
    let moves = |text: &str| follow(&interpreted(text), Resolution::default()).unwrap().1;
    let [rapid, feed, short] = moves("G00 X1\nG01 X1.5 F10\nG21\nG01 X25.4 F7620\n")[..] else {
        panic!()
    };
    assert_eq!((rapid.ticks, rapid.seconds, rapid.length), (4000, 1e-3, 1.0));
    assert!((feed.seconds * feed.ticks as f64 - 3.0).abs() < 1e-12);
    // 300 inches a minute are more than a step in a millisecond.
    assert_eq!((short.ticks, short.seconds), (2000, 1e-3));
}

/// G21 and words in millimetres have the ticks of the inches.
#[test]
fn millimetres_have_the_ticks_of_inches() {
    let inch = "G00 X0.5 Y-0.75\nG02 X0.5 Y1.25 J1 F9\nG01 X8 Y.25 Z-.125\nG92 X0\nG00 X1";
    let mm = "G21 G00 X12.7 Y-19.05\nG02 X12.7 Y31.75 J25.4 F228.6\nG01 X203.2 Y6.35 Z-3.175\nG92 X0\nG00 X25.4";
    let (inch, mm) = (interpreted(inch), interpreted(mm));
    let (a, b) = (follow(&inch, Resolution::default()), follow(&mm, Resolution::default()));
    assert_eq!(a.as_ref().unwrap().0, b.as_ref().unwrap().0);
    assert_eq!(a.unwrap().2, [36_000, 1000, -500]);
}

#[test]
fn what_t_mode_has_not_is_refused_by_name() {
    let end = Position { x: 1.0, ..Position::default() };
    let turned = Position { a: 1.0, ..Position::default() };
    let arc =
        |plane, turns| Call::ArcFeed { plane, end, centre_first: 0.5, centre_second: 0.0, turns };
    let high = Position { x: 1.0, z: 1000.0, ..Position::default() };
    let helix = Call::ArcFeed {
        plane: Plane::Xy,
        end: high,
        centre_first: 0.5,
        centre_second: 0.0,
        turns: 1,
    };
    let far = Position { x: 1e9, ..Position::default() };
    for (call, wanted) in [
        (arc(Plane::Xz, 1), "T-mode has no arcs in other planes than XY"),
        (arc(Plane::Xy, 2), "T-mode has no arcs of more than one turn"),
        (Call::NurbsFeed { order: 3, points: Vec::new(), end }, "T-mode has no splines"),
        (Call::RigidTap { end, retract_scale: 1.0 }, "T-mode has no taps"),
        (Call::StraightProbe { end, away: false, must_trip: true }, "T-mode has no probes"),
        (Call::StraightFeed(turned), "T-mode has no axes but X, Y and Z"),
        (Call::StraightFeed(far), "the place is more than 2147483647 steps away"),
        (Call::StraightFeed(end.scaled(11.0)), "more than 40000 ticks"),
        (helix, "more than 40000 ticks"),
        (arc(Plane::Xy, 1), ""),
    ] {
        let issued = Issued { call, line: 1, number: None };
        let result = follow(&[issued], Resolution { limit: 40_000, ..Resolution::default() });
        let why = result.err().map(|p| p.to_string()).unwrap_or_default();
        assert_eq!(why, wanted);
    }
    let nan = follow(&[], Resolution { scale: f64::NAN, ..Resolution::default() });
    assert!(nan.is_err());
}

fn part(name: &str) -> String {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/../../../configs/maxnc");
    std::fs::read_to_string(format!("{folder}/{name}.nc")).unwrap()
}

fn figures(text: &str) -> Figures {
    let (steps, moves, _) = follow(&interpreted(text), Resolution::default()).unwrap();
    let mut out = Figures::default();
    steps.iter().for_each(|s| out.step(*s));
    moves.iter().for_each(|m| out.moved(m));
    out
}

/// The table of the two parts, cell by cell: as they are in inches, and in millimetres.
#[test]
fn the_two_parts_have_the_ticks_of_the_reference() {
    let rows = [
        (
            "scissors-a",
            114_968,
            [96_936, 18_032, 0],
            [90_000, 26_000, 17_000],
            [32_000, 6000],
            29.8629,
            119.45,
            [6, 17, 5, 1],
        ),
        (
            "scissors-b",
            109_796,
            [86_592, 23_204, 0],
            [78_000, 42_000, 13_000],
            [26_000, 10_000],
            28.8787,
            115.51,
            [7, 17, 6, 1],
        ),
        (
            "scissors-b-plunged",
            113_796,
            [90_592, 23_204, 0],
            [78_000, 42_000, 17_000],
            [26_000, 10_000],
            29.8787,
            119.51,
            [7, 18, 6, 1],
        ),
    ];
    for (name, ticks, by_axes, steps, [x, y], length, seconds, moves) in rows {
        let inches = part(name);
        for text in [inches.clone(), in_millimetres(&inches)] {
            let f = figures(&text);
            assert_eq!((f.ticks, f.by_axes, f.steps), (ticks, by_axes, steps), "{name}");
            assert_eq!((f.low, f.high), ([0, 0, -1000], [x, y, 1000]), "{name}");
            assert_eq!((f.place, f.moves), ([0; 3], moves), "{name}");
            assert!((f.length - length).abs() < 5e-5, "{name}: {}", f.length);
            assert!((f.seconds - seconds).abs() < 5e-3, "{name}: {}", f.seconds);
        }
    }
}

/// Returns a program in inches with G21 and each word of a length times 25.4.
fn in_millimetres(text: &str) -> String {
    let mut out = String::new();
    for line in text.lines() {
        let code = line.split('#').next().unwrap_or_default().replace("G20", "G21");
        let mut rest = code.as_str();
        while let Some(at) = rest.find(['X', 'Y', 'Z', 'I', 'J']) {
            out.push_str(&rest[..=at]);
            rest = &rest[at + 1..];
            let end = rest.find(char::is_alphabetic).unwrap_or(rest.len());
            let value: f64 = rest[..end].trim().parse().unwrap();
            out.push_str(&format!("{:.5} ", value * 25.4));
            rest = &rest[end..];
        }
        out.push_str(rest);
        out.push('\n');
    }
    out
}

/// As printed, both parts contradict themselves in line 7.
#[test]
fn the_printed_parts_are_refused_in_line_7() {
    for name in ["scissors-a-printed", "scissors-b-printed"] {
        let settings = Settings { dialect: Dialect::Rs274d, ..Settings::default() };
        let mut it = Interpreter::new(settings, Numbered::default());
        it.load(name, Arc::new(part(name).into_bytes()));
        let (_, error) = run_with(&mut it, &World::new(), |_| {});
        let error = error.unwrap();
        assert_eq!((error.place.line, error.place.column), (7, 1), "{error}");
        let wanted = "Radius to end of arc differs from radius to start";
        assert!(error.to_string().contains(wanted), "{error}");
    }
}
