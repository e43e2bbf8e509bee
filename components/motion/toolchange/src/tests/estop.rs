//! The e-stop: immediate, and reported if the external chain does not follow.

use super::Rig;
use crate::Iocontrol;
use hal_bench::Bench;
use hal_component::{
    Builder, Component, Error, InterlockRef, Out, Period, Touch, Update,
    abi::{TicketState, component_flags},
};

const STAYS: &str = "{iocontrol.0.emc-enable-in} stays TRUE: the e-stop chain does not follow \
                     {iocontrol.0.user-enable-out}, and what hangs at the chain goes on. Lead \
                     user-enable-out to emc-enable-in, directly or through the components of the \
                     chain";
const STAYS_LOCKED: &str = "{iocontrol.0.emc-enable-in} stays TRUE: the e-stop chain does not \
                            follow {iocontrol.0.user-enable-out}. The interlock has switched \
                            motion off, and nothing else: lead user-enable-out to emc-enable-in, \
                            directly or through the components of the chain";
const UNREAD: &str = "motion has not read the interlock since: motion-controller runs in no \
                      thread, or the threads stand still, so what it last put out stays";

/// Reads the interlock as motion does.
struct Reader;

#[derive(Touch)]
struct Read {
    interlock: InterlockRef,
    released: Out<bool>,
}

impl Component for Reader {
    const NAME: &'static str = "reader";
    const DOC: &'static str = "Reads the interlock.";
    const FLAGS: u32 = component_flags::ONCE;
    fn create(b: &mut Builder<'_>) -> Result<(), Error> {
        let interlock = b.interlock()?.ok_or(Error::new("no interlock"))?;
        let released = b.item("reader.released", "TRUE out of e-stop.", false)?;
        b.function("reader", "Reads it.", Read { interlock, released })
    }
}

impl Update for Read {
    fn update(&mut self, _: Period) {
        self.released.set(self.interlock.state().is_released());
    }
}

impl Rig {
    /// A rig with the interlock and a reader of it.
    fn read() -> Self {
        let mut bench = Bench::new();
        bench.load::<Iocontrol>(&["interlock=1"]).unwrap();
        bench.load::<Reader>(&[]).unwrap();
        Self(bench)
    }

    /// Returns the state that the reader sees in a cycle of its own.
    fn is_released(&self) -> bool {
        self.0.run("reader", 1_000_000);
        self.0.get("reader.released")
    }

    /// Returns the states of the last commands.
    fn last<const N: usize>(&self) -> [TicketState; N] {
        let all = self.0.tickets();
        core::array::from_fn(|n| all[all.len() - N + n])
    }

    /// Returns the result of the last command, ten cycles after the one that received it.
    fn at_last(&self, reads: bool) -> TicketState {
        for _ in 0..11 {
            assert_eq!(self.ticket(), Some(TicketState::Pending));
            if reads {
                self.is_released();
            }
            self.cycle();
        }
        self.ticket().unwrap()
    }
}

#[test]
fn the_interlock_is_released_only_while_both_sides_are() {
    let rig = Rig::read();
    assert!(!rig.is_released());
    rig.set("emc-enable-in", true);
    assert!(!rig.is_released());
    rig.say("estop-reset");
    assert!(!rig.is_released());
    rig.cycle();
    assert!(rig.is_released());
    rig.set("emc-enable-in", false);
    assert!(!rig.is_released());
    rig.set("emc-enable-in", true);
    assert!(rig.is_released());
    // Before the task runs, and although the chain does not follow.
    rig.say("estop");
    assert!(!rig.is_released());
    assert_eq!(rig.on(), [""; 0]);
    let state = rig.0.command("iocontrol.status", &[]).unwrap();
    assert!(state[0].starts_with("machine estop=TRUE"), "{state:?}");
    rig.cycle();
    assert!(!rig.is_released());
}

#[test]
fn the_interlock_is_there_only_when_it_is_asked_for() {
    for (bench, args, there) in [
        (Bench::new(), &[][..], false),
        (Bench::new(), &["interlock=0"], false),
        (Bench::new(), &["interlock=1"], true),
        (Bench::new().with_interlock(), &[], true),
        (Bench::new().with_interlock(), &["interlock=0"], true),
    ] {
        let mut bench = bench;
        bench.load::<Iocontrol>(args).unwrap();
        assert_eq!(bench.load::<Reader>(&[]).is_ok(), there, "{args:?}");
    }
}

#[test]
fn a_chain_that_follows_at_once_is_not_waited_for() {
    let rig = Rig::enabled();
    // As through a signal that joins both pins: it follows as the command writes.
    rig.set("emc-enable-in", false);
    rig.say("estop");
    assert!(!rig.0.is_awaited());
    rig.cycle();
    assert_eq!(rig.ticket(), Some(TicketState::Done));
    assert_eq!(rig.0.said(), [""; 0]);
}

#[test]
fn a_chain_that_follows_later_is_waited_for() {
    let rig = Rig::enabled();
    rig.say("estop");
    assert!(rig.0.is_awaited());
    for _ in 0..9 {
        rig.cycle();
        assert_eq!(rig.ticket(), Some(TicketState::Pending));
    }
    rig.set("emc-enable-in", false);
    rig.cycle();
    assert_eq!(rig.ticket(), Some(TicketState::Done));
    assert_eq!(rig.0.said(), [""; 0]);
}

#[test]
fn a_chain_that_does_not_follow_is_told_aloud() {
    let rig = Rig::enabled();
    rig.say("estop");
    assert!(rig.0.is_awaited());
    assert_eq!(rig.at_last(false), TicketState::Failed(STAYS));
    assert_eq!(rig.0.said(), [STAYS]);
    // With the interlock, motion is off all the same.
    let rig = Rig::read();
    rig.set("emc-enable-in", true);
    rig.say("estop-reset");
    rig.cycle();
    assert!(rig.is_released());
    rig.say("estop");
    assert!(rig.0.is_awaited());
    assert_eq!(rig.at_last(true), TicketState::Failed(STAYS_LOCKED));
    assert_eq!(rig.0.said(), [STAYS_LOCKED]);
    // The machine stays in e-stop.
    rig.say("coolant mist=1");
    rig.cycle();
    assert_eq!(rig.ticket(), Some(TicketState::Failed("the machine is in e-stop")));
    assert!(!rig.is_released());
    // An older command is answered as well.
    rig.say("estop");
    rig.say("estop");
    assert_eq!(rig.at_last(true), TicketState::Failed(STAYS_LOCKED));
    assert_eq!(rig.last(), [TicketState::Failed(STAYS_LOCKED); 2]);
}

#[test]
fn motion_that_no_longer_reads_the_interlock_is_told_aloud() {
    let rig = Rig::read();
    // No component has read it yet: nothing moves.
    rig.say("estop");
    rig.cycle();
    assert_eq!(rig.ticket(), Some(TicketState::Done));
    rig.is_released();
    rig.cycle();
    rig.say("estop");
    assert!(!rig.0.is_awaited());
    assert_eq!(rig.at_last(false), TicketState::Failed(UNREAD));
    assert_eq!(rig.0.said(), [UNREAD]);
    // The reader is now known, and the caller waits.
    rig.say("estop");
    assert!(rig.0.is_awaited());
    rig.is_released();
    rig.cycle();
    assert_eq!(rig.ticket(), Some(TicketState::Done));
}

#[test]
fn an_estop_overtakes_what_waits() {
    let rig = Rig::enabled();
    rig.say("coolant flood=1");
    rig.cycle();
    rig.say("prepare tool=3");
    rig.say("estop-reset");
    rig.say("estop");
    assert_eq!(rig.on(), [""; 0]);
    rig.cycle();
    // The reset came before the e-stop: it does not end it.
    assert_eq!(rig.on(), [""; 0]);
    let [prepare, reset, estop] = rig.last();
    assert_eq!(prepare, TicketState::Failed("the machine is in e-stop"));
    assert_eq!(reset, TicketState::Failed("e-stop"));
    assert_eq!(estop, TicketState::Pending);
    // A reset after it does, and the task no longer monitors the e-stop.
    rig.say("estop-reset");
    rig.cycle();
    assert_eq!(rig.last::<2>()[0], TicketState::Failed("superseded by iocontrol.estop-reset"));
    assert_eq!(rig.on(), ["user-enable-out", "user-request-enable"]);
    rig.cycle();
    assert_eq!(rig.ticket(), Some(TicketState::Done));
    // An e-stop and its end between two cycles of the task are not missed.
    rig.say("coolant flood=1");
    rig.say("prepare tool=3");
    rig.cycle();
    rig.say("estop");
    rig.say("estop-reset");
    rig.cycle();
    assert_eq!(rig.last::<3>()[0], TicketState::Failed("e-stop"));
    assert_eq!(rig.on(), ["user-enable-out", "user-request-enable"]);
}

#[test]
fn an_estop_is_in_force_although_too_many_commands_wait() {
    let rig = Rig::enabled();
    (0..64).for_each(|_| rig.say("set-tool tool=1"));
    let full = rig.0.command("iocontrol.estop", &[]).unwrap_err();
    let want = "the machine is in e-stop, but too many commands wait for iocontrol to see whether \
                emc-enable-in follows";
    assert_eq!((full.as_str(), rig.on()), (want, vec![]));
    rig.cycle();
    rig.say("coolant mist=1");
    rig.cycle();
    assert_eq!(rig.ticket(), Some(TicketState::Failed("the machine is in e-stop")));
}
