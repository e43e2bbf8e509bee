//! RS274-D: the meaning of each command, each refusal and each warning, and garbage.

use std::sync::Arc;

use hal_gcode::{
    Call, Dialect, Interpreter, Issued, Numbered, Settings, Step,
    axis::{AxisMask, Position},
    canon::{Plane, Unit},
    state::Limits,
};

use crate::support::{World, run_with};

fn settings() -> Settings {
    Settings {
        axes: AxisMask(7),
        unit: Unit::Inch,
        program_unit: Unit::Inch,
        dialect: Dialect::Rs274d,
        ..Settings::default()
    }
}

fn loaded(text: &[u8]) -> Interpreter {
    let mut it = Interpreter::new(settings(), Numbered::default());
    it.load("part.g", Arc::new(text.to_vec()));
    it
}

/// Runs a program and returns its calls without those of every begin and end, and its error.
fn told(text: &[u8]) -> String {
    let mut it = loaded(text);
    let (calls, error) = run_with(&mut it, &World::new(), |_| {});
    let mut calls = calls.iter();
    let begin: Vec<String> = calls.by_ref().take(4).map(|i| i.call.to_string()).collect();
    if !begin.is_empty() {
        let begins = ["USE_LENGTH_UNITS(CANON_UNITS_INCHES)", "SELECT_PLANE(CANON_PLANE_XY)"];
        assert!(begin.starts_with(&begins.map(str::to_owned)), "{begin:?}");
        assert!(begin.last().is_some_and(|c| c.contains("EXACT_PATH")), "{begin:?}");
    }
    let mut out: Vec<String> = calls.filter_map(shown).collect();
    out.extend(error.map(|e| format!("{}:{}: {}", e.place.line, e.place.column, e.problem)));
    out.join("\n")
}

fn shown(issued: &Issued) -> Option<String> {
    let short = |v: f64| format!("{v:.6}").trim_end_matches('0').trim_end_matches('.').to_owned();
    let point = |p: &Position| [p.x, p.y, p.z].map(short).join(" ");
    Some(match &issued.call {
        Call::StraightTraverse(end) => format!("rapid {}", point(end)),
        Call::StraightFeed(end) => format!("line {}", point(end)),
        Call::ArcFeed { plane: Plane::Xy, end, centre_first, centre_second, turns } => {
            let centre = [*centre_first, *centre_second].map(short).join(" ");
            format!("arc {} about {centre}, {turns}", point(end))
        }
        Call::SetFeedRate(feed) if *feed != 0.0 => format!("feed {}", short(*feed)),
        Call::Dwell(seconds) => format!("dwell {seconds}"),
        Call::SetG92Offset(offset) => format!("offset {}", point(offset)),
        Call::UseLengthUnits(unit) => format!("{unit:?}").to_lowercase(),
        Call::Message(text) => text.to_string(),
        Call::ProgramStop => "pause".into(),
        Call::OptionalProgramStop => "optional pause".into(),
        Call::ProgramEnd => "end".into(),
        Call::SetG5xOffset { .. }
        | Call::SelectPlane(_)
        | Call::SetPathMode(_)
        | Call::SetNaiveCamTolerance(_)
        | Call::SetXyRotation(_)
        | Call::SetFeedMode { .. }
        | Call::SetFeedRate(_)
        | Call::TurnSpindle { .. }
        | Call::SetSpindleMode { .. }
        | Call::PalletShuttle
        | Call::Comment(_) => return None,
        other => format!("unexpected: {other}"),
    })
}

#[test]
fn every_command_does_what_the_dialect_says() {
    let cases = std::fs::read_to_string(crate::support::folder("rs274d.cases")).unwrap();
    let mut out = String::new();
    for block in cases.split("\n\n") {
        let program = block.lines().next().unwrap_or_default();
        let Some(program) = program.strip_prefix("> ") else {
            out.push_str(&format!("{}\n\n", block.trim_end()));
            continue;
        };
        out.push_str(&format!("> {program}\n{}", told(program.replace('|', "\n").as_bytes())));
        out.truncate(out.trim_end().len());
        out.push_str("\n\n");
    }
    out.truncate(out.trim_end().len());
    out.push('\n');
    hal_golden::check(&crate::support::folder("rs274d.cases"), &out);
}

/// A line of MDI is in LinuxCNC's language, whatever that of programs is, and its modes do not reach a program.
#[test]
fn lines_of_mdi_stay_in_linuxcncs_language() {
    let mut it = Interpreter::new(settings(), Numbered::default());
    for line in ["g10 l2 p1 x#5221", "g21 g91 g18 g64 p0.1", "f100 g1 x25.4"] {
        it.mdi(line);
        let (_, error) = run_with(&mut it, &World::new(), |_| {});
        assert_eq!(error, None, "{line}");
    }
    it.load("part.g", Arc::new(b"G01 Y2".to_vec()));
    let (calls, error) = run_with(&mut it, &World::new(), |_| {});
    assert_eq!(error, None);
    let lines: Vec<String> = calls.iter().filter_map(shown).collect();
    let warning = "part.g:1: warning: no feed is programmed: moves run at 15.0000 in/min";
    assert_eq!(lines, ["inch", warning, "feed 15", "line 1 2 0", "millimetre", "end"]);
    it.mdi("#1=2");
    assert_eq!(run_with(&mut it, &World::new(), |_| {}).1, None);
    // Nor do those of a program reach MDI, however it ends.
    for end in ["", "\nM02", "\nG01 X900"] {
        let settings =
            Settings { unit: Unit::Millimetre, program_unit: Unit::Millimetre, ..settings() };
        let mut it = Interpreter::new(settings, Numbered::default());
        it.mdi("g64 p0.1 q0.2 g7 g90.1");
        run_with(&mut it, &World::new(), |_| {});
        let before = it.state.modal.clone();
        it.load("part.g", Arc::new(format!("G00 X1\nG92 X3{end}").into_bytes()));
        if end.contains("900") {
            let mut out = Vec::new();
            while it.next(&World::new(), &mut out) == Ok(Step::Line) && it.state.line < 2 {}
            it.leave_program();
        } else {
            run_with(&mut it, &World::new(), |_| {});
        }
        let modal = &it.state.modal;
        assert_eq!((modal.unit, modal.path), (before.unit, before.path), "{end}");
        assert_eq!(modal.naive_tolerance, before.naive_tolerance, "{end}");
        assert!(modal.ijk_absolute && modal.diameter, "{end}");
        assert_eq!((it.state.frame.g92.x, it.state.numbered.get(5211)), (0.0, 0.0), "{end}");
    }
}

/// A run goes on exactly from its state at any line, also with a point that G28 remembers.
#[test]
fn a_run_goes_on_from_its_state_as_a_value() {
    let text = b"G92 X1\nG28 X2 Y1\nS5\nG91 G1 X1 F2\nS5\nG29 Z1\nG4 P20\n";
    let mut whole = loaded(text);
    let (calls, error) = run_with(&mut whole, &World::new(), |_| {});
    assert_eq!(error, None);
    for split in 0..=7 {
        let (mut it, mut out) = (loaded(text), Vec::new());
        for _ in 0..split {
            assert_eq!(it.next(&World::new(), &mut out), Ok(Step::Line));
        }
        let saved = serde_json::to_string(&it.state).unwrap();
        let mut it = Interpreter::from_state(serde_json::from_str(&saved).unwrap());
        it.supply("part.g", Arc::new(text.to_vec()));
        out.extend(run_with(&mut it, &World::new(), |_| {}).0);
        assert_eq!(out, calls, "{split}");
    }
}

/// Random bytes end with an error and its place, or within the limits.
#[test]
fn garbage_ends_in_order() {
    const TOKENS: [&str; 48] = [
        "G00", "G01", "G02", "G03", "G04", "G20", "G21", "G28", "G29", "G90", "G91", "G92", "G41",
        "G5.1", "M00", "M01", "M02", "M30", "M06", "M98", "S1200", "T1", "N10", "N999999", "X1",
        "X-.5", "Y2", "Z.25", "I0", "J.25", "K1", "R2", "R-3", "F10", "F0", "P500", "L2", "D1",
        "# c", "(c)", "(* c *)", "(", "X1e5", "O1", "%", "/", "\n", "\n",
    ];
    let world = World::new();
    let mut seed = 7u64;
    let mut below = |n: usize| {
        seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
        usize::try_from(seed >> 33).unwrap() % n
    };
    let limits = Limits { lines: 2000, ..Limits::default() };
    let (mut errors, mut ends) = (0, 0);
    for case in 0..6000 {
        let mut text = Vec::new();
        for _ in 0..below(40) {
            match case % 3 {
                0 => text.push(u8::try_from(below(256)).unwrap()),
                1 => text.extend(TOKENS[below(TOKENS.len())].bytes()),
                _ => text.extend(TOKENS[12 + below(24)].bytes().chain(*b"\nG01 ")),
            }
        }
        let settings = Settings { limits, ..settings() };
        let mut it = Interpreter::new(settings, Numbered::default());
        it.load("fuzz.g", Arc::new(text.clone()));
        let (calls, error) = run_with(&mut it, &world, |_| {});
        assert!(calls.iter().all(|i| !i.call.to_string().contains("NaN")), "a NaN in a call");
        match error {
            Some(error) => {
                assert!(error.place.line > 0 && !error.problem.to_string().is_empty());
                errors += 1;
            }
            None => ends += 1,
        }
    }
    assert!(errors > 1000 && ends > 100, "{errors} errors, {ends} ends");
}
