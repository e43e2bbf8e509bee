//! Jogs and homing of joints, and jogs of axes.

use super::*;

#[test]
fn joints_jog_home_and_show_their_state() {
    let mut rig = Rig::on();
    rig.set("joint.jog-speed", 20.0);
    // Held.
    rig.set("joint.1.plus", true);
    rig.cycles(500);
    let speed: f64 = rig.0.get("joint.1.vel-cmd");
    assert!((speed - 20.0).abs() < 1e-6, "{speed}");
    rig.set("joint.jog-speed", 10.0);
    rig.cycles(200);
    assert!(
        (rig.0.get::<f64>("joint.1.vel-cmd") - 10.0).abs() < 1e-6,
        "the new speed counts at once"
    );
    rig.set("joint.1.minus", true);
    rig.rest();
    rig.set("joint.1.plus", false);
    rig.set("joint.1.minus", false);
    rig.rest();
    // By increments.
    let before = rig.at(0);
    rig.set("joint.0.increment", 1.5);
    rig.press("joint.0.increment-plus");
    rig.rest();
    assert!((rig.at(0) - before - 1.5).abs() < 1e-5);
    rig.press("joint.0.increment-minus");
    rig.rest();
    assert!((rig.at(0) - before).abs() < 1e-5);
    // By a joystick, beyond its deadband.
    rig.set("joint.2.analog", -0.2);
    rig.cycles(100);
    assert_eq!(rig.at(2), 0.0);
    rig.set("joint.2.analog", -0.5);
    rig.cycles(300);
    assert!((rig.0.get::<f64>("joint.2.vel-cmd") + 5.0).abs() < 1e-6);
    rig.set("joint.2.analog", f64::NAN);
    rig.rest();
    // The selected one.
    rig.press("joint.2.select");
    assert!(rig.is("joint.2.is-selected") && !rig.is("joint.0.is-selected"));
    assert_eq!(rig.0.get::<u32>("halui.joint.selected"), 2);
    let before = rig.at(2);
    rig.set("joint.selected.plus", true);
    rig.cycles(100);
    assert!(rig.at(2) > before);
    rig.press("joint.0.select");
    rig.set("joint.selected.plus", false);
    rig.rest();
    // Homing.
    rig.press("joint.0.home");
    rig.rest();
    assert!(rig.is("joint.0.is-homed") && !rig.is("joint.1.is-homed"));
    assert!(rig.is("joint.selected.is-homed"));
    rig.press("home-all");
    rig.rest();
    assert!(rig.is("joint.1.is-homed") && rig.is("joint.2.is-homed"));
    rig.press("joint.1.unhome");
    assert!(!rig.is("joint.1.is-homed"));
    // Limits.
    rig.set("joint.jog-speed", 100.0);
    rig.set("joint.0.plus", true);
    rig.cycles(1500);
    assert!(rig.is("joint.0.on-soft-max-limit") && !rig.is("joint.0.on-soft-min-limit"));
    rig.set("joint.0.plus", false);
    rig.0.set("joint.2.neg-lim-sw-in", true);
    rig.cycles(20);
    assert!(rig.is("joint.2.on-hard-min-limit") && !rig.is("machine.is-on"));
}

#[test]
fn axes_jog_and_show_positions() {
    let mut rig = Rig::on();
    rig.press("home-all");
    rig.rest();
    rig.press("mode.teleop");
    assert!(rig.is("mode.is-teleop") && !rig.is("mode.is-joint") && rig.is("mode.is-manual"));
    rig.set("axis.jog-speed", 20.0);
    rig.set("axis.y.increment", 3.0);
    rig.press("axis.y.increment-plus");
    rig.rest();
    for pin in ["axis.y.pos-commanded", "axis.y.pos-feedback", "axis.y.pos-relative"] {
        assert!((rig.float(pin) - 3.0).abs() < 1e-5, "{pin}");
    }
    rig.press("axis.z.select");
    assert_eq!(rig.0.get::<u32>("halui.axis.selected"), 2);
    rig.set("axis.selected.minus", true);
    rig.cycles(200);
    rig.set("axis.selected.minus", false);
    rig.rest();
    assert!(rig.float("axis.z.pos-commanded") < -1.0);
    rig.press("mode.joint");
    assert!(rig.is("mode.is-joint"));
    // An axis that the machine has not.
    rig.set("axis.a.plus", true);
    rig.cycles(20);
    assert_eq!(rig.0.said().len(), 1);
}
