//! The pins of `inihal`.

use super::*;

#[test]
fn settings_change_live() {
    let mut rig = Rig::on();
    let get = |rig: &Rig, pin: &str| rig.0.get::<f64>(&format!("ini.{pin}"));
    assert_eq!((get(&rig, "0.max_velocity"), get(&rig, "traj_max_velocity")), (100.0, 80.0));
    assert_eq!((get(&rig, "1.min_limit"), get(&rig, "1.max_limit")), (-50.0, 50.0));
    rig.press("home-all");
    rig.rest();
    rig.set("joint.jog-speed", 60.0);
    rig.set("joint.0.plus", true);
    rig.cycles(200);
    // A velocity limit during a jog: it brakes to it.
    rig.0.set("ini.0.max_velocity", 25.0);
    rig.cycles(100);
    assert!((rig.0.get::<f64>("joint.0.vel-cmd") - 25.0).abs() < 1e-6);
    // Both limits beyond the old ones, in any order.
    rig.set("joint.0.plus", false);
    rig.rest();
    for (low, high) in [(60.0, 70.0), (-70.0, -60.0)] {
        rig.0.set("ini.1.min_limit", low);
        rig.0.set("ini.1.max_limit", high);
        rig.cycles(20);
        assert_eq!(rig.0.said(), [""; 0], "{low} to {high}");
    }
    // A value that is not possible is reported once, and the next one counts.
    rig.0.set("ini.0.max_velocity", -1.0);
    rig.cycles(100);
    let said = rig.0.said();
    assert_eq!(said, ["-1 is not possible for a pin of joint 0: the setting stays"]);
    rig.0.set("ini.x.max_limit", f64::NAN);
    rig.0.set("ini.2.home_sequence", 3000_i32);
    rig.cycles(100);
    assert_eq!(rig.0.said().len(), 2);
    rig.0.set("ini.0.max_velocity", 12.0);
    rig.0.set("ini.2.home_sequence", 3_i32);
    rig.set("joint.0.plus", true);
    rig.cycles(200);
    assert!((rig.0.get::<f64>("joint.0.vel-cmd") - 12.0).abs() < 1e-6);
    assert_eq!(rig.0.said(), [""; 0]);
}
