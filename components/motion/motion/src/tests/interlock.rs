//! The e-stop of iocontrol, which no wiring can bypass.

use super::{PERIOD, Rig, near};
use hal_bench::Bench;
use hal_component::{MotionStatus, abi::TicketState};
use toolchange::Iocontrol;
use trivkins::Trivkins;

const AMPS: [&str; 3] =
    ["joint.0.amp-enable-out", "joint.1.amp-enable-out", "joint.2.amp-enable-out"];
const COMMANDED: &str = "motion stopped by e-stop: it was commanded by iocontrol.estop";
const OPEN: &str = "motion stopped by e-stop: {iocontrol.0.emc-enable-in} is FALSE";
const HARDWARE: &str =
    "motion stopped: a driver has lost its hardware, which its own message names";

impl Rig {
    /// A machine from an INI file, in e-stop; nothing is wired.
    fn machine() -> Self {
        let mut bench = Bench::new().with_interlock();
        bench.load::<Iocontrol>(&[]).unwrap();
        bench.load::<Trivkins>(&[]).unwrap();
        Self::with(bench)
    }

    /// Out of e-stop, on, and homed.
    pub(super) fn released() -> Self {
        let mut rig = Self::machine();
        rig.release();
        rig.done("motion.enable");
        rig.done("motion.home joint=all");
        rig
    }

    pub(super) fn release(&mut self) {
        self.say("iocontrol.estop-reset");
        self.task();
        self.bench.set("iocontrol.0.emc-enable-in", true);
        self.task();
        assert_eq!(self.bench.ticket(), Some(TicketState::Done));
    }

    /// Runs a cycle of iocontrol's task.
    fn task(&self) {
        self.bench.run("iocontrol", 100 * PERIOD);
    }
}

#[test]
fn an_estop_stops_everything_in_the_cycle_in_which_it_comes() {
    type Comes = fn(&Rig);
    let ways: [(Comes, &str); 3] = [
        (|rig| rig.bench.fail_hardware(true), HARDWARE),
        (|rig| assert!(rig.say("iocontrol.estop").is_empty()), COMMANDED),
        (|rig| rig.bench.set("iocontrol.0.emc-enable-in", false), OPEN),
    ];
    for (comes, cause) in ways {
        for text in [
            "motion.jog joint=0 velocity=20 position=100",
            "motion.jog axis=y velocity=20 distance=30",
            "motion.move x=100 velocity=20",
            "motion.home joint=all",
            "motion.spindle-orient angle=90",
        ] {
            let mut rig = Rig::released();
            rig.done("motion.spindle speed=600");
            if text == "motion.home joint=all" {
                rig.say("motion.configure joint=0 home-search-vel=5 home-latch-vel=1");
                rig.cycles(1);
            }
            rig.say(text);
            let waits = rig.bench.tickets().len() - 1;
            rig.cycles(50);
            assert_eq!(rig.which(&AMPS), AMPS, "{text}");
            comes(&rig);
            rig.strict = false;
            // The enable input is TRUE all the time: nothing else could have stopped it.
            assert!(rig.is("motion.enable"));
            rig.cycle();
            assert_eq!(rig.which(&AMPS), [""; 0], "{text}");
            let on = ["motion.motion-enabled", "spindle.0.on", "motion.jog-is-active"];
            assert_eq!(rig.which(&on), [""; 0], "{text}");
            assert!(rig.is("spindle.0.brake") && rig.is("motion.in-position"));
            assert_eq!(rig.bench.tickets()[waits], TicketState::Failed(cause), "{text}");
            let said = rig.bench.said();
            assert_eq!(said[0], cause, "{text}");
            // Without the hardware, joints that moved are no longer homed.
            let is_known = |text: &String| cause == HARDWARE && text.contains("no longer homed");
            assert!(said[1..].iter().all(is_known), "{text}: {said:?}");
            // The end of the e-stop starts nothing.
            let places = rig.places();
            rig.bench.set("iocontrol.0.emc-enable-in", false);
            rig.cycles(3);
            if cause == HARDWARE {
                rig.bench.fail_hardware(false);
            }
            rig.release();
            rig.cycles(100);
            assert_eq!(rig.which(&on), [""; 0], "{text}");
            assert_eq!((rig.which(&AMPS), rig.places()), (vec![], places), "{text}");
            rig.done("motion.enable");
            rig.cycles(100);
            assert_eq!((rig.which(&AMPS), rig.places()), (AMPS.to_vec(), places), "{text}");
        }
    }
}

#[test]
fn enabling_in_estop_is_refused_with_what_ends_it() {
    let mut rig = Rig::machine();
    let commanded = "can't enable motion, the machine is in e-stop: iocontrol.estop-reset ends \
                     it, and {iocontrol.0.emc-enable-in} must then be TRUE";
    let open = "can't enable motion, the machine is in e-stop: {iocontrol.0.emc-enable-in} is \
                FALSE. It ends when that is TRUE; iocontrol.estop-reset resets a latch in the \
                chain";
    // At startup, with and without the chain.
    for chain in [false, true] {
        rig.bench.set("iocontrol.0.emc-enable-in", chain);
        assert_eq!(rig.failed("motion.enable"), commanded);
    }
    rig.bench.set("iocontrol.0.emc-enable-in", false);
    rig.say("iocontrol.estop-reset");
    rig.task();
    assert_eq!(rig.failed("motion.enable"), open);
    rig.bench.set("iocontrol.0.emc-enable-in", true);
    rig.done("motion.enable");
    rig.say("iocontrol.estop");
    assert_eq!(rig.failed("motion.enable"), commanded);
    assert!(!rig.is("motion.motion-enabled"));
    let said = rig.bench.said();
    assert_eq!(said, [commanded, commanded, open, commanded, COMMANDED]);
}

#[test]
fn enabling_without_the_hardware_is_refused_with_and_without_an_estop() {
    let refused = "can't enable motion, a driver has lost its hardware: its own message names it \
                   and what to do";
    for mut rig in [Rig::released(), Rig::on(&[])] {
        rig.strict = false;
        for _ in 0..2 {
            // Two parts fail; it works again when both do.
            rig.bench.fail_hardware(true);
        }
        rig.cycles(2);
        assert_eq!(rig.failed("motion.enable"), refused);
        rig.bench.fail_hardware(false);
        assert_eq!(rig.failed("motion.enable"), refused);
        rig.bench.fail_hardware(false);
        rig.cycles(100);
        assert!(!rig.is("motion.motion-enabled"));
        rig.done("motion.enable");
    }
}

#[test]
fn the_controller_declares_what_it_reads_of_iocontrol() {
    let touches = |bench: &Bench, name: &str| {
        let all = bench.touches(name);
        all.into_iter().filter(|t| t.contains("iocontrol")).collect::<Vec<_>>()
    };
    let rig = Rig::machine();
    let reads = touches(&rig.bench, "motion-controller");
    assert_eq!(reads, ["iocontrol.0.emc-enable-in r"]);
    assert_eq!(touches(&rig.bench, "motion-command-handler"), [""; 0]);
}

/// The panel and programs read the e-stop from the record, and whether there is one.
#[test]
fn the_record_tells_an_estop_from_lost_hardware() {
    let status = |rig: &mut Rig| -> (bool, bool) {
        rig.cycle();
        let status: MotionStatus = rig.bench.snapshot("motion.status");
        (status.interlock, status.estop)
    };
    let mut rig = Rig::machine();
    assert_eq!(status(&mut rig), (true, true), "it begins in e-stop");
    rig.release();
    assert_eq!(status(&mut rig), (true, false));
    rig.bench.fail_hardware(true);
    assert_eq!(status(&mut rig), (true, false), "lost hardware is no e-stop");
    rig.bench.set("iocontrol.0.emc-enable-in", false);
    assert_eq!(status(&mut rig), (true, true));
    rig.bench.set("iocontrol.0.emc-enable-in", true);
    rig.say("iocontrol.estop");
    assert_eq!(status(&mut rig), (true, true));
    let mut rig = Rig::off(&[]);
    assert_eq!(status(&mut rig), (false, false), "a script without an interlock");
}

#[test]
fn a_machine_without_its_interlock_is_not_loaded() {
    let mut bench = Bench::new().with_interlock();
    bench.load::<Trivkins>(&[]).unwrap();
    assert_eq!(
        bench.load::<crate::Motmod>(&[]).unwrap_err(),
        "a machine from an INI file needs the e-stop of iocontrol, which is not loaded: loadrt \
         iocontrol first"
    );
}

#[test]
fn a_script_asks_for_the_interlock_or_keeps_its_own_wiring() {
    for (args, in_force) in [(&[][..], false), (&["interlock=0"], false), (&["interlock=1"], true)]
    {
        let mut bench = Bench::new();
        bench.load::<Iocontrol>(args).unwrap();
        bench.load::<Trivkins>(&[]).unwrap();
        let mut rig = Rig::with(bench);
        assert_eq!(rig.wait("motion.enable").is_err(), in_force, "{args:?}");
        rig.release();
        rig.done("motion.enable");
        rig.say("motion.jog joint=0 velocity=20");
        rig.cycles(50);
        near(rig.joint(0, "vel-cmd"), 20.0);
        rig.say("iocontrol.estop");
        rig.strict = false;
        rig.cycle();
        assert_eq!(rig.is("motion.motion-enabled"), !in_force, "{args:?}");
    }
}
