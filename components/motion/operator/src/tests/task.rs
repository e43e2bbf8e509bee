//! Buttons and lamps of the task.

use super::*;

#[test]
fn the_task_has_its_buttons_and_lamps() {
    let mut rig = Rig::on();
    rig.press("mdi-command-00");
    assert_eq!(rig.0.said().len(), 1, "there is no task yet");
    let operator: OperatorRef = rig.0.find();
    let motion: MotionRef = rig.0.find();
    let mut view = OperatorView { mode: 2, program: 1, ..OperatorView::IDLE };
    view.zero[0] = 1.0;
    view.zero[1] = 2.0;
    view.rotation = 90.0;
    view.tool_diameter = 6.0;
    view.optional_stop = 1;
    use OperatorRequest as R;
    for (pin, request) in [
        ("mode.auto", R::Mode(1)),
        ("mode.mdi", R::Mode(2)),
        ("mode.manual", R::Mode(0)),
        ("program.run", R::Run),
        ("program.resume", R::Resume),
        ("program.step", R::Step),
        ("program.optional-stop.on", R::OptionalStop(true)),
        ("program.optional-stop.off", R::OptionalStop(false)),
        ("program.block-delete.on", R::BlockDelete(true)),
        ("program.block-delete.off", R::BlockDelete(false)),
        ("mdi-command-01", R::Mdi("(MSG,a) G0 X0".to_owned())),
    ] {
        operator.show(&view);
        let given = motion.epoch();
        rig.press(pin);
        assert_eq!(operator.take(), Some((request, Some(given))), "{pin}");
        assert_eq!(operator.take(), None, "{pin}");
    }
    // Stops are motion's: the task sees them.
    for (pin, stops, pauses) in [
        ("program.pause", 0, 1),
        ("program.stop", 1, 0),
        ("abort", 1, 0),
        ("machine.off", 1, 0),
        ("estop.activate", 1, 0),
    ] {
        operator.show(&view);
        let before = motion.epoch();
        rig.press(pin);
        let now = motion.epoch();
        assert_eq!(
            (now.stops - before.stops, now.pauses - before.pauses),
            (stops, pauses),
            "{pin}"
        );
        assert_eq!(operator.take(), None, "{pin}");
    }
    assert!(rig.is("mode.is-mdi") && rig.is("program.is-running"));
    assert!(rig.is("program.optional-stop.is-on") && !rig.is("program.is-idle"));
    assert_eq!(rig.float("tool.diameter"), 6.0);
    // Machine 0, 0 in coordinates whose zero is at 1, 2 and whose x goes along the machine's y.
    assert!((rig.float("axis.x.pos-relative") + 2.0).abs() < 1e-12);
    assert!((rig.float("axis.y.pos-relative") - 1.0).abs() < 1e-12);
    // A task that is silent for a second is gone.
    rig.cycles(1100);
    assert!(rig.is("program.is-idle") && rig.is("mode.is-manual"));
    rig.press("program.run");
    assert_eq!((operator.take(), rig.0.said().len()), (None, 1));
}

#[test]
fn a_task_keeps_a_machine_in_estop_off() {
    let mut rig = Rig::new();
    let operator: OperatorRef = rig.0.find();
    operator.show(&OperatorView::IDLE);
    rig.press("machine.on");
    assert!(!rig.is("machine.is-on"));
    assert_eq!(rig.0.said(), ["the machine is in e-stop: estop.reset comes first"]);
    rig.press("estop.reset");
    operator.show(&OperatorView::IDLE);
    rig.press("machine.on");
    assert!(rig.is("machine.is-on"), "{:?}", rig.0.said());
}
