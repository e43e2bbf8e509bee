//! Answers beside the states that searches know: power that is given, epochs that rise, orders that are refused, jobs of a
//! lease.
use hal_safety::{
    Answer, Epoch, Event, Facts, Mode, OrderKind, OrderSource, Parked, Reaction, Refused,
    SafetyMachine, Stop, Trouble,
    lease::{Desk, Job, OnLoss, Work},
};

/// Facts of a machine that may be switched on, and rests.
const READY: Facts = Facts {
    epoch: Epoch { stops: 1, pauses: 0 },
    estop: false,
    enable: true,
    jog_inhibit: false,
    homing_inhibit: false,
    configured: true,
    jogs: false,
    homes: false,
    path: false,
    rests_on_path: false,
    parked: Parked::No,
    claimed: false,
    target: true,
    place: true,
    rests: true,
    moving: 0,
    open_loop: 0,
    volatile: 0,
};

fn ordered(machine: &mut SafetyMachine, order: OrderKind) -> Answer {
    machine.on(Event::Order(order, OrderSource::Local, READY.epoch), &READY)
}

fn on(mode: Mode) -> SafetyMachine {
    let mut machine = SafetyMachine::OFF;
    assert_eq!(ordered(&mut machine, OrderKind::Enable).refused, None);
    assert_eq!(ordered(&mut machine, OrderKind::Mode(mode)).refused, None);
    assert_eq!(machine.mode(), mode);
    machine
}

#[test]
fn power_is_given_once() {
    let mut machine = SafetyMachine::OFF;
    assert!(ordered(&mut machine, OrderKind::Enable).powers);
    assert!(!ordered(&mut machine, OrderKind::Enable).powers, "it is on");
    assert_eq!(machine.on(Event::Off, &READY).stop, Stop::Drop);
    assert!(ordered(&mut machine, OrderKind::Enable).powers);
}

#[test]
fn every_trouble_of_a_machine_that_is_on_raises_the_epoch_once() {
    for reaction in [Reaction::Drop, Reaction::Ramp] {
        for trouble in [
            Trouble::Hard,
            Trouble::Limit(reaction),
            Trouble::Following { by: reaction, twice: false },
            Trouble::Following { by: reaction, twice: true },
        ] {
            let mut machine = on(Mode::Free);
            assert!(machine.on(Event::Trouble(trouble), &READY).raises, "{trouble:?}");
            // While it brakes, and once it is off, the same trouble is no new one.
            assert!(!machine.on(Event::Trouble(Trouble::Limit(Reaction::Ramp)), &READY).raises);
        }
    }
}

#[test]
fn steps_and_turns_need_a_path_and_the_way_forward_does_not() {
    let orders = [OrderKind::Step, OrderKind::Reverse, OrderKind::Forward];
    for mode in [Mode::Free, Mode::Teleop, Mode::Coord] {
        for order in orders {
            let refused = ordered(&mut on(mode), order).refused;
            let is_refused = mode != Mode::Coord && order != OrderKind::Forward;
            assert_eq!(refused, is_refused.then_some(Refused::NoPath), "{mode:?} {order:?}");
        }
    }
}

#[test]
fn a_job_that_was_announced_and_refused_is_none() {
    let mut desk = Desk::new(OnLoss::Hold);
    assert!(!desk.has_job() && !desk.refuse());
    desk.announced(7);
    assert_eq!((desk.has_job(), desk.job), (true, Job::Commanded(7)));
    assert!(desk.refuse());
    assert!(!desk.has_job() && !desk.refuse());
    // A job that runs is not refused any more.
    desk.announced(9);
    let work = Work { moves: true, job: true, ..Work::default() };
    assert!(!desk.follow(10, work));
    assert_eq!((desk.refuse(), desk.job), (false, Job::Runs));
}
