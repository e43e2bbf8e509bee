//! Drawn pictures with known truth: errors of centres and angles, and false finds, as a table in the crate's README.
//! `UPDATE_EXPECT=1` writes the table.
#![expect(clippy::unwrap_used, clippy::print_stdout, reason = "tests; figures are shown")]

use hal_align::{Matrix, Vector};
use hal_marks::{Figure, Ink, MarkKind, Search, Sheet, View, average, choose, search};
use std::{fmt::Write, path::Path};

/// Numbers that repeat.
struct Random(u64);

impl Random {
    fn between(&mut self, low: f64, high: f64) -> f64 {
        self.0 =
            self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        low + (high - low) * ((self.0 >> 11) as f64 / 9_007_199_254_740_992.0)
    }
}

/// A kind of pictures.
struct Case {
    name: &'static str,
    blur: f64,
    noise: f64,
    light: f64,
    tilt: f64,
    ink: (f64, f64),
    /// Number of pictures whose mean is taken.
    frames: u64,
    /// Largest errors of a centre in pixels and of an angle in degrees, if they are asserted.
    bar: Option<(f64, f64)>,
}

const CASES: &[Case] = &[
    Case {
        name: "no noise",
        blur: 0.0,
        noise: 0.0,
        light: 0.0,
        tilt: 0.0,
        frames: 1,
        ink: (220.0, 40.0),
        bar: Some((0.01, 0.05)),
    },
    Case {
        name: "blur 1, noise 5",
        blur: 1.0,
        noise: 5.0,
        light: 0.0,
        tilt: 0.0,
        frames: 1,
        ink: (220.0, 40.0),
        bar: Some((0.05, 0.3)),
    },
    Case {
        name: "blur 1.5, noise 8",
        blur: 1.5,
        noise: 8.0,
        light: 0.0,
        tilt: 0.0,
        frames: 1,
        ink: (220.0, 40.0),
        bar: Some((0.1, 0.6)),
    },
    Case {
        name: "contrast 100, blur 1, noise 5",
        blur: 1.0,
        noise: 5.0,
        light: 0.0,
        tilt: 0.0,
        frames: 1,
        ink: (180.0, 80.0),
        bar: Some((0.09, 0.6)),
    },
    Case {
        name: "the same, mean of 5 pictures",
        blur: 1.0,
        noise: 5.0,
        light: 0.0,
        tilt: 0.0,
        frames: 5,
        ink: (180.0, 80.0),
        bar: Some((0.05, 0.3)),
    },
    Case {
        name: "bright on dark, blur 1, noise 5",
        blur: 1.0,
        noise: 5.0,
        light: 0.0,
        tilt: 0.0,
        frames: 1,
        ink: (40.0, 220.0),
        bar: Some((0.05, 0.3)),
    },
    Case {
        name: "light falls to half, blur 1, noise 5",
        blur: 1.0,
        noise: 5.0,
        light: 0.66,
        tilt: 0.0,
        frames: 1,
        ink: (200.0, 40.0),
        bar: Some((0.1, 0.6)),
    },
    Case {
        name: "tilt: scale differs by 4 % across the picture",
        blur: 0.0,
        noise: 0.0,
        light: 0.0,
        tilt: 1.25e-4,
        frames: 1,
        ink: (220.0, 40.0),
        bar: None,
    },
];

/// Result of many pictures.
#[derive(Default)]
struct Sum {
    pictures: u32,
    found: u32,
    square: f64,
    largest: f64,
    angle: f64,
    /// Error over uncertainty, squared.
    ratio: f64,
    /// Error over the least deviation that any method has, squared.
    bound: f64,
}

/// Returns the bound of Cramér and Rao for a coordinate of the centre, as the README derives it; 0 without noise.
fn bound(case: &Case, wanted: &Search) -> f64 {
    let edge = match wanted.kind {
        MarkKind::Circle => core::f64::consts::PI * wanted.size / 2.0,
        MarkKind::Square => 2.0 * wanted.size,
    };
    // Pixels blur an edge, and rounding to whole numbers is noise.
    let (blur, noise) = ((case.blur.powi(2) + 1.0 / 12.0).sqrt(), case.noise.powi(2) + 1.0 / 12.0);
    let contrast = (case.ink.0 - case.ink.1).abs();
    let least = 2.0 * core::f64::consts::PI.sqrt() * blur * noise / (contrast * contrast * edge);
    if case.noise > 0.0 { (least / case.frames as f64).sqrt() } else { 0.0 }
}

fn picture_of(case: &Case, random: &mut Random, seed: u64) -> (View, Sheet, Search, Vector, f64) {
    let kind = if seed.is_multiple_of(2) { MarkKind::Circle } else { MarkKind::Square };
    let size = random.between(20.0, 90.0);
    let angle = if kind == MarkKind::Square { random.between(-44.0, 44.0) } else { 0.0 };
    let room = size * 0.75 + 6.0;
    let at = Vector::new(random.between(room, 320.0 - room), random.between(room, 240.0 - room));
    let outline = (seed % 4 > 1).then(|| (size * 0.2).max(5.0));
    let mut view = View::new(320, 240, Matrix::IDENTITY, Vector::new(160.0, 120.0));
    (view.blur, view.noise, view.seed) = (case.blur, case.noise, seed);
    view.light = Vector::new(case.light, 0.0);
    view.tilt = Vector::new(case.tilt, case.tilt * 0.5);
    let place = view.machine(at);
    let mark = Figure::Mark { kind, centre: place, size, angle, outline };
    let sheet = Sheet { background: case.ink.0, ink: case.ink.1, figures: vec![mark] };
    let ink = if case.ink.0 > case.ink.1 { Ink::Dark } else { Ink::Bright };
    (view, sheet, Search { kind, size, ink }, at, angle)
}

fn measure(case: &Case, pictures: u64) -> Sum {
    let mut random = Random(17);
    let mut sum = Sum::default();
    for seed in 0..pictures {
        let (view, sheet, wanted, at, angle) = picture_of(case, &mut random, seed);
        sum.pictures += 1;
        let mut marks = Vec::new();
        for frame in 0..case.frames {
            let view = View { seed: seed + 1000 * frame, ..view.clone() };
            let seen = search(&view.draw(&sheet).unwrap(), &wanted);
            match choose(&seen, at) {
                Ok(found) => marks.push(found),
                Err(_) => println!("{}: {wanted:?} at {at:?}: {:?}", case.name, seen.rejected),
            }
            assert_eq!(seen.marks.len(), 1, "{}: {seed}", case.name);
        }
        let Ok(mean) = average(&marks) else { continue };
        let found = mean.mark;
        sum.found += 1;
        let off = (found.centre - at).length();
        sum.square += off * off;
        sum.largest = sum.largest.max(off);
        let least = bound(case, &wanted);
        sum.bound += if least > 0.0 { off * off / (2.0 * least * least) } else { 0.0 };
        sum.ratio += off * off / (2.0 * found.uncertainty * found.uncertainty);
        if wanted.kind == MarkKind::Square {
            let by = found.angle - angle;
            sum.angle = sum.angle.max((by - 90.0 * (by / 90.0).round()).abs());
        }
    }
    sum
}

#[test]
fn centres_and_angles_are_within_their_bars_and_the_table_is_true() {
    let mut table = String::from(
        "\n| pictures | found | centre: mean square, largest (pixels) | angle: largest (degrees) | error / stated uncertainty | error / bound |\n|---|---|---|---|---|---|\n",
    );
    for case in CASES {
        let sum = measure(case, 65);
        let n = f64::from(sum.found);
        let rms = (sum.square / n).sqrt();
        writeln!(
            table,
            "| {} | {} of {} | {:.3}, {:.3} | {:.2} | {:.1} | {} |",
            case.name,
            sum.found,
            sum.pictures,
            rms,
            sum.largest,
            sum.angle,
            (sum.ratio / n).sqrt(),
            if sum.bound > 0.0 {
                format!("{:.2}", (sum.bound / n).sqrt())
            } else {
                "–".to_owned()
            }
        )
        .unwrap();
        // In even light the estimate is as good as any can be.
        let efficiency = (sum.bound / n).sqrt();
        assert!(case.light > 0.0 || efficiency < 1.25, "{}: {efficiency:.2}", case.name);
        assert_eq!(sum.found, sum.pictures, "{}: every mark is found", case.name);
        if let Some((centre, angle)) = case.bar {
            assert!(sum.largest <= centre, "{}: {:.4} px", case.name, sum.largest);
            assert!(sum.angle <= angle, "{}: {:.3} degrees", case.name, sum.angle);
        }
    }
    let (figures, finds) = without_marks();
    writeln!(table, "\n{figures} pictures without a mark, with {finds} false finds.").unwrap();
    assert_eq!((figures, finds), (200, 0));
    check_part("<!-- pictures:begin -->", "<!-- pictures:end -->", &table);
}

/// Returns the number of pictures with figures that are no marks, and of the marks found in them.
fn without_marks() -> (u32, u32) {
    let mut random = Random(5);
    let (mut pictures, mut finds) = (0, 0);
    for n in 0..200_u64 {
        let size = random.between(20.0, 60.0);
        let kind = if n.is_multiple_of(2) { MarkKind::Circle } else { MarkKind::Square };
        let other = if n.is_multiple_of(2) { MarkKind::Square } else { MarkKind::Circle };
        let mut place = |room: f64| {
            Vector::new(random.between(room, 320.0 - room), random.between(room, 240.0 - room))
        };
        let mark =
            |kind, centre, size| Figure::Mark { kind, centre, size, angle: 10.0, outline: None };
        let bar = |centre: Vector, x: f64, y: f64, angle: f64| Figure::Bar {
            centre,
            size: Vector::new(x, y),
            angle,
        };
        let figures = match n % 10 {
            // The other kind, and sizes beyond the tolerance.
            0 | 1 => vec![mark(other, place(50.0), size)],
            2 | 3 => vec![mark(kind, place(60.0), size * 1.4)],
            4 | 5 => vec![mark(kind, place(50.0), size * 0.75)],
            // A mark that the border cuts.
            6 => vec![mark(kind, Vector::new(1.0, 100.0), size)],
            // Text: letters T, H and E of bars.
            7 => {
                let at = place(60.0);
                let to = |x: f64, y: f64| at + Vector::new(x, y);
                vec![
                    bar(to(0.0, -12.0), 26.0, 5.0, 0.0),
                    bar(to(0.0, 0.0), 5.0, 26.0, 0.0),
                    bar(to(22.0, 0.0), 5.0, 26.0, 0.0),
                    bar(to(38.0, 0.0), 5.0, 26.0, 0.0),
                    bar(to(30.0, 0.0), 16.0, 5.0, 0.0),
                ]
            }
            // Lines, a rectangle, a cross, two marks that touch.
            8 => vec![
                bar(place(40.0), size * 1.3, size * 0.77, 20.0),
                bar(place(40.0), 300.0, 3.0, 70.0),
            ],
            _ => {
                let (at, second) = (place(60.0), place(60.0));
                vec![
                    bar(at, size, size * 0.3, 0.0),
                    bar(at, size * 0.3, size, 0.0),
                    mark(kind, second, size * 0.8),
                    mark(kind, second + Vector::new(size * 0.5, 0.0), size * 0.8),
                ]
            }
        };
        let mut view = View::new(320, 240, Matrix::IDENTITY, Vector::new(160.0, 120.0));
        (view.blur, view.noise, view.seed) = (1.0, 5.0, n);
        if n.is_multiple_of(3) {
            view.light = Vector::new(0.5, 0.2);
        }
        let picture = view.draw(&Sheet { background: 190.0, ink: 40.0, figures }).unwrap();
        let seen = search(&picture, &Search { kind, size, ink: Ink::Dark });
        pictures += 1;
        for mark in &seen.marks {
            println!("picture {n}: {mark:?}, {size}");
            finds += 1;
        }
    }
    (pictures, finds)
}

/// Compares a part of the README, or writes it.
fn check_part(begin: &str, end: &str, new: &str) {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("README.md");
    hal_golden::check_part(&path, begin, end, &format!("\n\n{}\n\n", new.trim()));
}

/// A hatched board: each stripe is as long as the picture, so that a map of each would take a multiple of the picture's area.
#[test]
fn long_stripes_are_rejected_by_their_length() {
    const SIDE: usize = 2400;
    let stripe = |at| if (at % SIDE + at / SIDE) % 16 < 5 { 40 } else { 220 };
    let picture = hal_marks::Picture::new(SIDE, SIDE, (0..SIDE * SIDE).map(stripe).collect());
    let wanted = Search { kind: MarkKind::Circle, size: 100.0, ink: Ink::Dark };
    let seen = search(&picture, &wanted);
    assert!(seen.marks.is_empty() && seen.rejected.len() > 250, "{}", seen.rejected.len());
    let long = seen.rejected.iter().filter(|(_, why)| why.to_string().contains("pixels long"));
    assert!(long.count() > 200);
}
