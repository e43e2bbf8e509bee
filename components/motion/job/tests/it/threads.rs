//! Threads, taps and feeds per turn that the axes of a machine cannot follow are errors of a check.
#![expect(clippy::unwrap_used, reason = "tests")]

use hal_gcode::Interpreter;
use hal_job::{
    Files, Machine, World,
    check::{Check, Seen},
    simulation::KnownAnswers,
};
use std::path::Path;

/// Returns the reasons of a check of these lines.
fn reasons(lines: &str) -> Vec<String> {
    let ini = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/threads/rig.ini");
    let machine = Machine::read(&Files { ini: Some(&ini), ..Files::default() }).unwrap();
    let mut interpreter = Interpreter::new(machine.settings.clone(), machine.numbered.clone());
    let text = format!("G21 G90 G54\n{}\nM2\n", lines.replace("; ", "\n"));
    interpreter.load("p.ngc", std::sync::Arc::new(text.into_bytes()));
    let world = World::with_functions(machine, Default::default());
    let mut check = Check::new(interpreter, KnownAnswers::default());
    while check.seen() == Seen::Part {
        check.advance(&world, 100);
    }
    check.reasons().iter().map(|reason| reason.text.clone()).collect()
}

#[test]
fn what_the_axes_cannot_follow_is_an_error_of_the_check() {
    for (lines, wanted) in [
        (
            "M3 S3000; G0 Z0; G33 Z-60 K5",
            "p.ngc:4: a pitch of 5 mm at 3000 turns/min needs 250 mm/s along the path, and the axes allow 50 mm/s",
        ),
        // The INI file's highest speed counts.
        ("M3 S9000; G33 Z-60 K0.9", ""),
        (
            "M3 S2000 $1; G0 Z0; G33 Z-60 K1.5 $1",
            "p.ngc:4: a pitch of 1.5 mm at 2000 turns/min needs 50 mm/s along the path, and the axes allow 50 mm/s",
        ),
        ("M3 S1900; G33 Z-60 K1.5", ""),
        ("M3 S600; G33 Z-60 K1.5", ""),
        (
            "M3 S600; G33 Z-1 K1.5",
            "p.ngc:3: the thread is 1 mm long, and at 600 turns/min it needs a lead-in of",
        ),
        // Two moves are one thread.
        ("M3 S600; G33 Z-1 K1.5; G33 X1 Z-30 K1.5", ""),
        ("M3 S600; G33 Z-1 K1.5; G0 X1; G33 X1 Z-30 K1.5", "p.ngc:3: the thread is 1 mm long"),
        ("M3 S600; G33.1 Z-10 K1.5", ""),
        (
            "M3 S600; G33.1 Z-0.5 K1.5",
            "p.ngc:3: the tap is 0.5 mm long, and at 600 turns/min it needs a lead-in of",
        ),
        (
            "M3 S1200; G33.1 Z-10 K1.5 I2",
            "p.ngc:3: a pitch of 1.5 mm at 2400 turns/min needs 60 mm/s",
        ),
        (
            "M3 S2500; G0 X10 Z5; G76 P1.5 Z-20 I-1 J0.2 K1 R1",
            "p.ngc:4: a pitch of 1.5 mm at 2500 turns/min",
        ),
        ("M3 S600; G0 X10 Z5; G76 P1.5 Z-20 I-1 J0.2 K1 R1", ""),
        (
            "M3 S2500; G95 F1.5; G1 Z-20",
            "p.ngc:4: a feed per turn of 1.5 mm at 2500 turns/min needs 62.5 mm/s",
        ),
        ("M3 S2500; G95 F1.5; G1 X20", ""),
        ("M3 S2500; G95 F0.2; G1 Z-20", ""),
        ("M3 S200; G0 Z2; G84 Z-10 R2 F300", ""),
        (
            "M3 S2500; G0 Z2; G84 Z-10 R2 F3750",
            "p.ngc:4: the tap needs its feed of 62.5 mm/s, and the axes allow 50 mm/s",
        ),
        (
            "M4 S2500; G95 F1.5; G0 Z2; G74 Z-10 R2",
            "p.ngc:5: a feed per turn of 1.5 mm at 2500 turns/min",
        ),
        ("G20; M3 S3000; G33 Z-2 K0.2", "p.ngc:4: a pitch of 5.08 mm at 3000 turns/min"),
    ] {
        let found = reasons(lines);
        match wanted {
            "" => assert!(found.is_empty(), "{lines}: {found:?}"),
            wanted => {
                assert_eq!(found.len(), 1, "{lines}: {found:?}");
                assert!(found[0].starts_with(wanted), "{lines}: {found:?}");
            }
        }
    }
}
