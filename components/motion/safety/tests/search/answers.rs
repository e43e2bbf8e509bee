//! Answers beside the states that searches know: power that is given, epochs that rise, orders that are refused, jobs of a
//! lease.
use crate::mutants::IDLE;
use hal_safety::{
    Answer, Event, Facts, Mode, OrderKind, OrderSource, Reaction, Refused, SafetyMachine, Stop,
    Trouble,
    lease::{Desk, Job, OnLoss, Work},
};

fn ordered(machine: &mut SafetyMachine, order: OrderKind) -> Answer {
    machine.on(Event::Order(order, OrderSource::Local, IDLE.epoch), &IDLE)
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
    assert_eq!(machine.on(Event::Off, &IDLE).stop, Stop::Drop);
    assert!(ordered(&mut machine, OrderKind::Enable).powers);
}

#[test]
fn a_machine_that_is_off_has_nothing_to_drop_but_volatile_homes() {
    let facts = Facts { volatile: 0b101, ..IDLE };
    let answer = { SafetyMachine::OFF }.on(Event::Off, &facts);
    assert_eq!((answer.stop, answer.unhome), (Stop::None, 0b101));
    let answer = on(Mode::Free).on(Event::Off, &facts);
    assert_eq!((answer.stop, answer.unhome), (Stop::Drop, 0b101));
}

#[test]
fn a_probe_that_closes_ends_homing_or_jogs() {
    for (homes, jogs, stop) in [
        (false, false, Stop::None),
        (false, true, Stop::Jogs),
        (true, false, Stop::Homing),
        (true, true, Stop::Homing),
    ] {
        let facts = Facts { homes, jogs, ..IDLE };
        assert_eq!(on(Mode::Free).on(Event::Probe, &facts).stop, stop, "{homes} {jogs}");
    }
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
            assert!(machine.on(Event::Trouble(trouble), &IDLE).raises, "{trouble:?}");
            // While it brakes, and once it is off, the same trouble is no new one.
            assert!(!machine.on(Event::Trouble(Trouble::Limit(Reaction::Ramp)), &IDLE).raises);
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
