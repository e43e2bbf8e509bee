//! E-stop and the handshakes, cycle by cycle.

mod estop;
mod explore;
mod service;

use crate::{Io, Iocontrol, Iov2};
use hal_bench::Bench;
use hal_component::abi::TicketState;

const BITS: [&str; 7] = [
    "user-enable-out",
    "user-request-enable",
    "coolant-mist",
    "coolant-flood",
    "lube",
    "tool-prepare",
    "tool-change",
];
const NUMBERS: [&str; 5] =
    ["tool-number", "tool-from-pocket", "tool-prep-number", "tool-prep-pocket", "tool-prep-index"];

struct Rig(Bench);

impl Rig {
    fn new() -> Self {
        let mut bench = Bench::new();
        bench.load::<Iocontrol>(&[]).unwrap();
        Self(bench)
    }

    /// Out of e-stop, through the usual loop.
    fn enabled() -> Self {
        let rig = Self::new();
        rig.say("estop-reset");
        rig.cycle();
        rig.set("emc-enable-in", true);
        rig.cycle();
        assert_eq!(rig.ticket(), Some(TicketState::Done));
        rig
    }

    fn say(&self, text: &str) {
        let mut words = text.split(' ');
        let name = format!("iocontrol.{}", words.next().unwrap());
        self.0.command(&name, &words.collect::<Vec<_>>()).unwrap();
    }

    fn cycle(&self) {
        self.0.run("iocontrol", 100_000_000);
    }

    fn set(&self, pin: &str, value: bool) {
        self.0.set(&format!("iocontrol.0.{pin}"), value);
    }

    fn ticket(&self) -> Option<TicketState> {
        self.0.ticket()
    }

    /// Returns the outputs that are TRUE.
    fn on(&self) -> Vec<&'static str> {
        let is = |pin: &&str| self.0.get(&format!("iocontrol.0.{pin}"));
        BITS.into_iter().filter(is).collect()
    }

    fn numbers(&self) -> [i32; 5] {
        NUMBERS.map(|pin| self.0.get(&format!("iocontrol.0.{pin}")))
    }
}

const NONE: [&str; 0] = [];

#[test]
fn pins_are_those_of_the_reference() {
    assert_eq!(
        Rig::new().0.names(),
        [
            "iocontrol.0.coolant-flood bit OUT",
            "iocontrol.0.coolant-mist bit OUT",
            "iocontrol.0.emc-enable-in bit IN",
            "iocontrol.0.lube bit OUT",
            "iocontrol.0.lube_level bit IN",
            "iocontrol.0.tool-change bit OUT",
            "iocontrol.0.tool-changed bit IN",
            "iocontrol.0.tool-from-pocket s32 OUT",
            "iocontrol.0.tool-number s32 OUT",
            "iocontrol.0.tool-prep-index s32 OUT",
            "iocontrol.0.tool-prep-number s32 OUT",
            "iocontrol.0.tool-prep-pocket s32 OUT",
            "iocontrol.0.tool-prepare bit OUT",
            "iocontrol.0.tool-prepared bit IN",
            "iocontrol.0.user-enable-out bit OUT",
            "iocontrol.0.user-request-enable bit OUT",
        ]
    );
}

#[test]
fn three_names_for_one() {
    let (mut io, mut iov2) = (Bench::new(), Bench::new());
    io.load::<Io>(&["cycle_time=0.05"]).unwrap();
    iov2.load::<Iov2>(&[]).unwrap();
    assert_eq!(io.names(), Rig::new().0.names());
    assert_eq!(iov2.names(), io.names());
    // Only one of them at a time.
    assert!(io.load::<Iocontrol>(&[]).is_err());
    for bad in ["0", "-1", "NaN", "11", "inf"] {
        let refused = Bench::new().load::<Iocontrol>(&[&format!("cycle_time={bad}")]);
        assert_eq!(
            refused.unwrap_err(),
            format!("cycle_time is {bad}, must be between 0.001 and 10")
        );
    }
}

#[test]
fn comes_up_in_estop_and_leaves_it() {
    let rig = Rig::new();
    rig.cycle();
    assert_eq!(rig.on(), NONE);
    rig.say("estop-reset");
    assert_eq!(rig.on(), NONE);
    rig.cycle();
    // One cycle long, whatever the external chain does.
    assert_eq!(rig.on(), ["user-enable-out", "user-request-enable"]);
    assert_eq!(rig.ticket(), Some(TicketState::Pending));
    rig.set("emc-enable-in", true);
    rig.cycle();
    assert_eq!(rig.on(), ["user-enable-out"]);
    assert_eq!(rig.ticket(), Some(TicketState::Done));
    // A repeated command has no effect.
    rig.say("estop-reset");
    rig.cycle();
    assert_eq!(rig.ticket(), Some(TicketState::Done));
    assert_eq!(rig.on(), ["user-enable-out"]);
    // E-stop does not wait for the task.
    rig.say("estop");
    assert_eq!(rig.on(), NONE);
    rig.set("emc-enable-in", false);
    rig.cycle();
    assert_eq!(rig.ticket(), Some(TicketState::Done));
}

#[test]
fn an_estop_outside_is_told() {
    let rig = Rig::new();
    rig.say("estop-reset");
    rig.cycle();
    rig.cycle();
    assert_eq!(rig.on(), ["user-enable-out"]);
    (0..9).for_each(|_| rig.cycle());
    assert_eq!(rig.ticket(), Some(TicketState::Pending));
    rig.cycle();
    let held = "emc-enable-in stays FALSE: something outside holds the e-stop";
    assert_eq!(rig.ticket(), Some(TicketState::Failed(held)));
    assert_eq!(rig.on(), ["user-enable-out"]);
    // When the chain closes, the machine is out of e-stop.
    rig.set("emc-enable-in", true);
    rig.cycle();
    rig.say("coolant flood=1");
    rig.cycle();
    assert_eq!(rig.ticket(), Some(TicketState::Done));
    // A new e-stop switches everything off except the enable.
    rig.say("coolant mist=1 lube=1");
    rig.say("prepare tool=2");
    rig.cycle();
    assert_eq!(
        rig.on(),
        ["user-enable-out", "coolant-mist", "coolant-flood", "lube", "tool-prepare"]
    );
    rig.set("emc-enable-in", false);
    rig.cycle();
    assert_eq!(rig.on(), ["user-enable-out"]);
    assert_eq!(rig.ticket(), Some(TicketState::Failed("e-stop")));
}

#[test]
fn a_tool_is_prepared_and_changed() {
    let rig = Rig::enabled();
    rig.say("prepare tool=7 pocket=17 index=2");
    rig.cycle();
    assert_eq!((rig.on(), rig.numbers()), (vec![BITS[0], "tool-prepare"], [0, 0, 7, 17, 2]));
    rig.cycle();
    assert_eq!(rig.ticket(), Some(TicketState::Pending));
    rig.set("tool-prepared", true);
    rig.cycle();
    assert_eq!((rig.on(), rig.numbers()), (vec![BITS[0]], [0, 0, 7, 17, 2]));
    assert_eq!(rig.ticket(), Some(TicketState::Done));
    rig.set("tool-prepared", false);
    rig.say("change");
    rig.cycle();
    assert_eq!((rig.on(), rig.numbers()), (vec![BITS[0], "tool-change"], [0, 0, 7, 17, 2]));
    rig.cycle();
    assert_eq!(rig.ticket(), Some(TicketState::Pending));
    rig.set("tool-changed", true);
    rig.cycle();
    assert_eq!((rig.on(), rig.numbers()), (vec![BITS[0]], [7, 17, 0, 0, 0]));
    assert_eq!(rig.ticket(), Some(TicketState::Done));
    rig.set("tool-changed", false);
    // The same tool again is prepared, and then nothing is changed.
    rig.say("prepare tool=7 pocket=17 index=2");
    rig.cycle();
    rig.set("tool-prepared", true);
    rig.cycle();
    rig.say("change");
    rig.cycle();
    assert_eq!((rig.on(), rig.numbers()), (vec![BITS[0]], [7, 17, 7, 17, 2]));
    assert_eq!(rig.ticket(), Some(TicketState::Done));
    // No tool at all. The answer before is still TRUE: it does not answer this request.
    rig.say("prepare tool=0 pocket=5");
    rig.cycle();
    rig.cycle();
    assert_eq!((rig.on(), rig.numbers()), (vec![BITS[0]], [7, 17, 0, 0, 0]));
    rig.set("tool-prepared", false);
    rig.cycle();
    assert_eq!(
        (rig.on(), rig.ticket()),
        (vec![BITS[0], "tool-prepare"], Some(TicketState::Pending))
    );
    rig.set("tool-prepared", true);
    rig.cycle();
    rig.say("change");
    rig.cycle();
    assert_eq!(rig.on(), [BITS[0], "tool-change"]);
    rig.set("tool-changed", true);
    rig.cycle();
    assert_eq!((rig.on(), rig.numbers()), (vec![BITS[0]], [0; 5]));
}

#[test]
fn abort_withdraws_the_request() {
    let rig = Rig::enabled();
    rig.say("prepare tool=3 pocket=13");
    rig.say("coolant flood=1");
    rig.cycle();
    assert_eq!(rig.on(), [BITS[0], "coolant-flood", "tool-prepare"]);
    rig.say("abort");
    rig.cycle();
    assert_eq!((rig.on(), rig.numbers()), (vec![BITS[0]], [0, 0, 3, 13, 13]));
    // It was never prepared.
    rig.say("change");
    rig.cycle();
    let why = "no tool is prepared: iocontrol.prepare tool=N comes first";
    assert_eq!(rig.ticket(), Some(TicketState::Failed(why)));
    rig.say("prepare tool=3");
    rig.cycle();
    rig.set("tool-prepared", true);
    rig.cycle();
    rig.say("change");
    rig.cycle();
    assert_eq!(rig.ticket(), Some(TicketState::Pending));
    rig.say("abort");
    rig.cycle();
    // Nobody knows how far the changer came.
    assert_eq!((rig.on(), rig.numbers()), (vec![BITS[0]], [-1, -1, 3, 3, 3]));
    // A prepared tool can be changed afterwards.
    rig.say("change");
    rig.cycle();
    assert_eq!(rig.on(), [BITS[0], "tool-change"]);
}

#[test]
fn an_answer_that_stays_is_no_answer() {
    let rig = Rig::enabled();
    for (pin, request) in [("tool-prepared", "prepare tool=3"), ("tool-changed", "change")] {
        rig.set(pin, true);
        rig.say(request);
        (0..11).for_each(|_| rig.cycle());
        assert_eq!((rig.on(), rig.ticket()), (vec![BITS[0]], Some(TicketState::Pending)));
        rig.cycle();
        let why = format!("{{iocontrol.0.{pin}}} stays TRUE without a request");
        let Some(TicketState::Failed(said)) = rig.ticket() else { panic!("{pin}: no failure") };
        assert!(said.starts_with(&why), "{said}");
        rig.set(pin, false);
        rig.say("prepare tool=3");
        rig.cycle();
        rig.set("tool-prepared", true);
        rig.cycle();
        rig.set("tool-prepared", false);
    }
}

#[test]
fn refusals() {
    let rig = Rig::new();
    for text in ["prepare tool=1", "change", "coolant mist=1"] {
        rig.say(text);
        rig.cycle();
        assert_eq!(rig.ticket(), Some(TicketState::Failed("the machine is in e-stop")), "{text}");
    }
    for text in ["coolant mist=0", "abort", "estop", "set-tool tool=4"] {
        rig.say(text);
        rig.cycle();
        assert_eq!(rig.ticket(), Some(TicketState::Done), "{text}");
    }
    assert_eq!((rig.on(), rig.numbers()), (vec![], [4, 4, 0, 0, 0]));
    let rig = Rig::enabled();
    rig.say("prepare tool=1");
    rig.cycle();
    for text in ["prepare tool=2", "change"] {
        rig.say(text);
        rig.cycle();
        assert_eq!(rig.ticket(), Some(TicketState::Failed("a tool is being prepared")));
    }
    rig.set("tool-prepared", true);
    rig.cycle();
    rig.say("change");
    rig.say("prepare tool=2");
    rig.cycle();
    assert_eq!(rig.ticket(), Some(TicketState::Failed("a tool is being changed")));
    for (args, why) in [
        (&["tool=-1"][..], "tool is -1, must be between 0 and 2147483647"),
        (
            &["tool=1", "pocket=5000000000"],
            "pocket is 5000000000, must be between 0 and 2147483647",
        ),
        (&[], "parameter `tool' is missing"),
    ] {
        assert_eq!(rig.0.command("iocontrol.prepare", args).unwrap_err(), why);
    }
}

#[test]
fn status() {
    let rig = Rig::enabled();
    rig.say("coolant flood=1");
    rig.say("set-tool tool=4 pocket=9");
    rig.say("prepare tool=5");
    rig.cycle();
    assert_eq!(
        rig.0.command("iocontrol.status", &[]).unwrap(),
        [
            "machine estop=FALSE mist=FALSE flood=TRUE lube=FALSE",
            "tool number=4 from-pocket=9 prepared=5 waits-for=tool-prepared",
        ]
    );
}

#[test]
fn commands_wait_while_nothing_runs() {
    let rig = Rig::new();
    (0..64).for_each(|_| rig.say("abort"));
    let full = rig.0.command("iocontrol.abort", &[]).unwrap_err();
    assert_eq!(full, "too many commands wait for iocontrol");
    assert_eq!(rig.ticket(), Some(TicketState::Failed("too many commands wait")));
    rig.cycle();
    rig.say("abort");
}
