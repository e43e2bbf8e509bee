//! Buttons and lamps of the machine, and what `halui` needs.

use super::*;

#[test]
fn it_needs_a_motion_controller() {
    let mut bench = Bench::new();
    for why in [bench.load::<Halui>(&[]), bench.load::<Inihal>(&[])] {
        assert!(why.unwrap_err().contains("loadrt motmod first"));
    }
    let mut bench = Bench::new();
    bench.load::<Trivkins>(&[]).unwrap();
    bench.load::<Motmod>(&["num_joints=1"]).unwrap();
    let why = bench.load::<Halui>(&["coordinates=XQ"]).unwrap_err();
    assert_eq!(why, "coordinates has q, which is none of XYZABCUVW");
    let why = bench.load::<Halui>(&["coordinates="]).unwrap_err();
    assert_eq!(why, "coordinates has 0 letters, must have 1 to 16");
    let long = format!("mdi_commands={}", "X".repeat(300));
    assert_eq!(
        bench.load::<Halui>(&[&long]).unwrap_err(),
        "a line of MDI has 300 bytes, at most 240"
    );
    let why = bench.load::<Halui>(&["mdi_commands=M3||M5"]).unwrap_err();
    assert_eq!(why, "line 1 of mdi_commands is empty, counted from 0");
}

#[test]
fn buttons_switch_the_machine() {
    let mut rig = Rig::new();
    assert!(!rig.is("machine.is-on") && rig.is("estop.is-activated"));
    rig.press("estop.reset");
    assert!(!rig.is("estop.is-activated"));
    rig.press("machine.on");
    assert!(rig.is("machine.is-on"));
    for fluid in ["flood", "mist", "lube"] {
        rig.press(&format!("{fluid}.on"));
        assert!(rig.is(&format!("{fluid}.is-on")), "{fluid}");
        rig.press(&format!("{fluid}.off"));
        assert!(!rig.is(&format!("{fluid}.is-on")), "{fluid}");
    }
    // More requests than results have room for: without a task they are taken here.
    for _ in 0..100 {
        rig.press("mist.on");
    }
    assert_eq!(rig.0.said(), [""; 0]);
    rig.press("machine.off");
    assert!(!rig.is("machine.is-on"));
    rig.press("estop.activate");
    assert!(rig.is("estop.is-activated"));
}

#[test]
fn a_button_that_is_held_from_the_start_was_not_pressed() {
    let mut bench = Bench::new();
    bench.load::<Trivkins>(&[]).unwrap();
    bench.load::<Motmod>(&["num_joints=1"]).unwrap();
    bench.command("motion.configure", &["joint=0"]).unwrap();
    bench.load::<Halui>(&[]).unwrap();
    bench.set("halui.machine.on", true);
    for _ in 0..5 {
        bench.run("motion-command-handler", PERIOD);
        bench.run("motion-controller", PERIOD);
        bench.run("halui", 10 * PERIOD);
    }
    assert!(!bench.get::<bool>("motion.motion-enabled"));
}
