//! `halui` and `inihal` with a motion controller and an e-stop.

use crate::{halui::Halui, inihal::Inihal};
use hal_component::{
    Builder, Component, Error, OperatorRef, OperatorRequest, OperatorView, bench::Bench,
};
use motion::Motmod;
use std::cell::RefCell;
use toolchange::Iocontrol;
use trivkins::Trivkins;

const PERIOD: i64 = 1_000_000;

thread_local! {
    static FOUND: RefCell<Option<OperatorRef>> = const { RefCell::new(None) };
}

/// Stands for the task.
struct Task;

impl Component for Task {
    const NAME: &'static str = "task";
    const DOC: &'static str = "Stands for the task.";
    fn create(b: &mut Builder<'_>) -> Result<(), Error> {
        let operator = b.operator()?;
        FOUND.with(|found| *found.borrow_mut() = operator);
        Ok(())
    }
}

struct Rig(Bench);

impl Rig {
    fn new() -> Self {
        let mut bench = Bench::new();
        bench.load::<Iocontrol>(&["cycle_time=0.01"]).unwrap();
        bench.load::<Trivkins>(&["coordinates=xyz"]).unwrap();
        bench.load::<Motmod>(&["num_joints=3"]).unwrap();
        for n in 0..3 {
            let joint = format!("joint={n}");
            let args = [
                &*joint,
                "max-velocity=100",
                "max-acceleration=1000",
                "min-limit=-50",
                "max-limit=50",
                "ferror=1",
                "min-ferror=1",
            ];
            bench.command("motion.configure", &args).unwrap();
        }
        bench.command("motion.configure", &["max-velocity=80"]).unwrap();
        bench.load::<Halui>(&["coordinates=XYZ", "mdi_commands=G0 X1|(MSG,a) G0 X0"]).unwrap();
        bench.load::<Inihal>(&[]).unwrap();
        let mut rig = Self(bench);
        rig.cycles(20);
        rig
    }

    /// Returns a machine that is on.
    fn on() -> Self {
        let mut rig = Self::new();
        rig.press("machine.on");
        rig.cycles(20);
        assert!(rig.is("machine.is-on"), "{:?}", rig.0.said());
        rig
    }

    fn cycles(&mut self, n: usize) {
        for cycle in 0..n {
            self.0.pass(PERIOD);
            self.0.run("motion-command-handler", PERIOD);
            self.0.run("motion-controller", PERIOD);
            self.0.work("motmod.planner", 64).unwrap();
            for joint in 0..3 {
                let cmd: f64 = self.0.get(&format!("joint.{joint}.motor-pos-cmd"));
                self.0.set(&format!("joint.{joint}.motor-pos-fb"), cmd);
            }
            let estop: bool = self.0.get("iocontrol.0.user-enable-out");
            self.0.set("iocontrol.0.emc-enable-in", estop);
            if cycle % 10 == 9 {
                for task in ["iocontrol", "halui", "inihal"] {
                    self.0.run(task, 10 * PERIOD);
                }
            }
        }
    }

    fn set<T: hal_component::Value>(&self, pin: &str, value: T) {
        self.0.set(&format!("halui.{pin}"), value);
    }

    /// Presses a button and releases it.
    fn press(&mut self, pin: &str) {
        self.set(pin, true);
        self.cycles(20);
        self.set(pin, false);
        self.cycles(20);
    }

    fn is(&self, pin: &str) -> bool {
        self.0.get(&format!("halui.{pin}"))
    }

    fn float(&self, pin: &str) -> f64 {
        self.0.get(&format!("halui.{pin}"))
    }

    fn at(&self, joint: usize) -> f64 {
        self.0.get(&format!("joint.{joint}.pos-cmd"))
    }

    /// Stops the motion that a test has ended.
    fn rest(&mut self) {
        self.cycles(300);
        assert!(self.0.get::<bool>("motion.in-position"));
    }
}

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

#[test]
fn knobs_and_spindles() {
    let mut rig = Rig::on();
    for (knob, shown) in [
        ("feed-override", "feed-override.value"),
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

#[test]
fn the_task_has_its_buttons_and_lamps() {
    let mut rig = Rig::on();
    rig.press("mdi-command-00");
    assert_eq!(rig.0.said().len(), 1, "there is no task yet");
    rig.0.load::<Task>(&[]).unwrap();
    let operator = FOUND.with(|found| found.borrow_mut().take()).unwrap();
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
        ("program.pause", R::Pause),
        ("program.resume", R::Resume),
        ("program.step", R::Step),
        ("program.stop", R::Stop),
        ("program.optional-stop.on", R::OptionalStop(true)),
        ("program.optional-stop.off", R::OptionalStop(false)),
        ("program.block-delete.on", R::BlockDelete(true)),
        ("program.block-delete.off", R::BlockDelete(false)),
        ("mdi-command-01", R::Mdi("(MSG,a) G0 X0".to_owned())),
        ("abort", R::Stop),
    ] {
        operator.show(&view);
        rig.press(pin);
        assert_eq!(operator.take(), Some(request), "{pin}");
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
