//! The output of the machine, edge by edge: step and direction of the printer's X around a reversal. `UPDATE_EXPECT=1`
//! writes the expected output.
#![expect(clippy::unwrap_used, clippy::indexing_slicing, reason = "tests")]

use hal_tests::{golden, programs::root, scratch::Scratch, vcd::Vcd};

/// Lines that the drawing shows.
const LINES: [&str; 4] = ["xstep", "xdir", "viagpio.sim.reg-4d-4", "viagpio.sim.reg-4f-2"];

/// Drives X in both directions with this set-up and hold time of the direction: returns the edges around the reversal,
/// and the time from the edge of the direction to the next step.
fn reversal(dirsetup: u32, dirhold: u32) -> (String, i64) {
    let scratch = Scratch::copy_of(&root().join("tests/hal/printer"));
    // The position jumps back and forth, as from a handwheel that is turned back at once: a ramp of the motion
    // controller would leave no step near the reversal.
    scratch.write(
        "custom_postgui.hal",
        format!(
            "setp stepgen.0.dirsetup {dirsetup}\nsetp stepgen.0.dirhold {dirhold}\n\
             setp stepgen.0.maxaccel 0\nunlinkp stepgen.0.enable\nsetp stepgen.0.enable 1\n\
             unlinkp stepgen.0.position-cmd\nrecord edges x viagpio.sim.reg-4\n\
             setp stepgen.0.position-cmd 1\nrun 1ms\nsetp stepgen.0.position-cmd -1\nrun 20ms\n\
             record off\n"
        ),
    );
    let output = scratch.halrun(&["--virtual", "--for", "1ms", "impresora3D.ini"]);
    assert_eq!((output.stderr.as_str(), output.status), ("", Some(0)));
    let vcd = Vcd::parse(&scratch.read("edges"));
    let turn = vcd.rises("xdir")[0];
    let next = *vcd.rises("xstep").iter().find(|t| **t > turn).unwrap();
    (vcd.drawing(&LINES, turn - 2_000_000, turn + 4_000_000), next - turn)
}

#[test]
fn the_edges_around_a_reversal() {
    let mut text = String::from("# Microseconds; the direction changes at 2000.\n");
    let mut waits = Vec::new();
    for (dirsetup, dirhold) in [(31_732, 31_732), (531_732, 31_732), (31_732, 431_732)] {
        let (drawing, wait) = reversal(dirsetup, dirhold);
        text.push_str(&format!("\ndirsetup {dirsetup} ns, dirhold {dirhold} ns\n{drawing}"));
        waits.push(wait);
    }
    let path = root().join("tests/hal/printer/waveform.expected");
    golden::check(&path, &text);
    // Times are rounded up to base periods: a longer set-up time moves the first step after the reversal.
    assert!(waits.iter().zip([100_000, 600_000, 100_000]).all(|(w, least)| *w >= least));
    assert!(waits[1] > waits[0], "{waits:?}");
}
