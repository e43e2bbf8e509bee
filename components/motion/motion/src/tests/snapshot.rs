//! The snapshot `motion.status`.

use super::{PERIOD, Rig};
use hal_component::MotionStatus;

fn status(rig: &Rig) -> MotionStatus {
    rig.bench.snapshot("motion.status")
}

/// The snapshot says the same as the pins, in every cycle of a job.
#[test]
fn the_snapshot_of_each_cycle_agrees_with_the_pins() {
    let mut rig = Rig::homed(&[]);
    rig.say("motion.move x=3 y=-2 velocity=20");
    let (mut last, mut fastest) = (status(&rig), 0.0_f64);
    for n in 0..600 {
        if n == 400 {
            rig.say("motion.jog joint=2 velocity=5");
        }
        rig.cycle();
        let s = status(&rig);
        assert_eq!((s.cycle, s.time_ns), (last.cycle + 1, last.time_ns + PERIOD));
        assert_eq!(s.enabled, rig.is("motion.motion-enabled"));
        assert_eq!(s.mode == 2, rig.is("motion.coord-mode"));
        assert_eq!(s.mode == 1, rig.is("motion.teleop-mode"));
        assert_eq!(s.in_position, rig.is("motion.in-position"));
        assert_eq!(s.all_homed, rig.is("motion.is-all-homed"));
        assert_eq!(s.jogging, rig.is("motion.jog-is-active"));
        assert_eq!(s.velocity, rig.float("motion.current-vel"));
        assert_eq!(s.distance_to_go, rig.float("motion.distance-to-go"));
        assert_eq!(s.joints, 3);
        for joint in 0..3 {
            assert_eq!(s.joint_position[joint], rig.joint(joint, "pos-cmd"));
            assert_eq!(s.joint_feedback[joint], rig.joint(joint, "pos-fb"));
            assert_eq!(s.joint_velocity[joint], rig.joint(joint, "vel-cmd"));
            assert!(s.joint_homed[joint] && s.joint_active[joint] && !s.joint_error[joint]);
        }
        assert_eq!(s.joint_position[3..], [0.0; 13]);
        fastest = fastest.max(s.velocity);
        last = s;
    }
    assert!(fastest > 10.0, "it moved: {fastest}");
    rig.bench.set("joint.1.pos-lim-sw-in", true);
    rig.cycle();
    let s = status(&rig);
    assert_eq!((s.enabled, s.joint_at_max[1], s.joint_error[1]), (false, true, true));
}
