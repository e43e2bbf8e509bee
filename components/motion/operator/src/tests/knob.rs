//! Knobs and spindles.

use super::*;

#[test]
fn knobs_and_spindles() {
    let mut rig = Rig::on();
    for (knob, shown) in [
        ("feed-override", "feed-override.value"),
        ("rapid-override", "rapid-override.value"),
        ("spindle.0.override", "spindle.0.override.value"),
    ] {
        let pin = |name: &str| format!("{knob}.{name}");
        assert_eq!(rig.float(shown), 1.0);
        rig.press(&pin("decrease"));
        assert!((rig.float(shown) - 0.9).abs() < 1e-12, "{knob}");
        rig.set(&pin("counts"), -3_i32);
        rig.cycles(30);
        assert!((rig.float(shown) - 0.6).abs() < 1e-12, "{knob}");
        rig.set(&pin("count-enable"), false);
        rig.set(&pin("counts"), 10_i32);
        rig.cycles(30);
        rig.set(&pin("count-enable"), true);
        rig.cycles(30);
        assert!((rig.float(shown) - 0.6).abs() < 1e-12, "{knob} takes counts while disabled");
        rig.set(&pin("direct-value"), true);
        rig.set(&pin("counts"), 4_i32);
        rig.cycles(30);
        assert!((rig.float(shown) - 0.4).abs() < 1e-12, "{knob}");
        rig.set(&pin("counts"), -40_i32);
        rig.cycles(30);
        assert_eq!(rig.float(shown), 0.0, "{knob}");
        rig.press(&pin("reset"));
        assert_eq!(rig.float(shown), 1.0, "{knob}");
    }
    // Not above 1, and apart from the feed's.
    rig.press("rapid-override.decrease");
    rig.press("rapid-override.increase");
    rig.press("rapid-override.increase");
    assert_eq!(rig.float("rapid-override.value"), 1.0);
    rig.press("rapid-override.decrease");
    assert_eq!((rig.float("feed-override.value"), rig.float("rapid-override.value")), (1.0, 0.9));
    rig.press("rapid-override.reset");
    rig.set("max-velocity.scale", 5.0);
    rig.press("max-velocity.decrease");
    assert_eq!(rig.float("max-velocity.value"), 75.0);
    assert_eq!(rig.0.get::<f64>("ini.traj_max_velocity"), 80.0);
    rig.press("max-velocity.increase");
    rig.press("max-velocity.increase");
    assert_eq!(rig.float("max-velocity.value"), 80.0, "not above the machine's");

    rig.press("spindle.0.forward");
    assert!(!rig.is("spindle.0.is-on"));
    assert_eq!(rig.0.said().len(), 1, "no speed yet");
    rig.0.command("motion.spindle", &["speed=250"]).unwrap();
    rig.cycles(20);
    assert!(rig.is("spindle.0.is-on") && rig.is("spindle.0.runs-forward"));
    rig.press("spindle.0.increase");
    assert_eq!(rig.0.get::<f64>("spindle.0.speed-out"), 350.0);
    rig.press("spindle.0.stop");
    assert!(!rig.is("spindle.0.is-on") && rig.is("spindle.0.brake-is-on"));
    rig.press("spindle.0.brake-off");
    assert!(!rig.is("spindle.0.brake-is-on"));
    rig.press("spindle.0.reverse");
    assert!(rig.is("spindle.0.runs-backward"));
    assert_eq!(rig.0.get::<f64>("spindle.0.speed-out"), -350.0);
    rig.press("abort");
    assert!(!rig.is("spindle.0.is-on"));
}
