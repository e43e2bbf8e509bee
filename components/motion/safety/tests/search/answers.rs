//! Answers beside the states that searches know: power that is given, epochs that rise, orders that are refused, jobs of a
//! lease.
use crate::mutants::IDLE;
use hal_safety::{
    Answer, Event, Facts, Jog, Mode, OrderKind, OrderSource, Reaction, Refused, SafetyMachine,
    Shift, Stop, Trouble,
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

#[test]
fn what_was_unseen_raises_the_epoch_and_what_stops_a_spindle_rests_the_path() {
    for mut machine in [SafetyMachine::OFF, on(Mode::Free)] {
        assert!(machine.clone().on(Event::Cut, &IDLE).raises);
        // Joint 0 moved and is volatile, joint 1 moved, joint 2 moved and is measured, joint 3 rested.
        let facts = Facts { moving: 0b0111, open_loop: 0b1011, volatile: 0b0001, ..IDLE };
        let answer = machine.on(Event::Gap, &facts);
        assert_eq!((answer.raises, answer.unhome, machine.is_on()), (true, 0b0011, false));
    }
    let answer = on(Mode::Coord).on(Event::SpindleStopped, &IDLE);
    assert_eq!((answer.stop, answer.pauses), (Stop::Path, true));
}

#[test]
fn the_mode_shifts_once() {
    let mut machine = on(Mode::Free);
    assert_eq!(machine.on(Event::Back, &IDLE).shift, Shift::To(Mode::Coord));
    assert_eq!(machine.on(Event::Back, &IDLE).shift, Shift::Stay);
    assert_eq!(machine.on(Event::NoPlace, &IDLE).shift, Shift::To(Mode::Free));
    assert_eq!(machine.mode(), Mode::Free);
}

#[test]
fn a_home_is_given_up_only_by_joints_that_can_and_at_rest() {
    let order = |facts: &Facts| {
        let order = Event::Order(OrderKind::Unhome, OrderSource::Local, facts.epoch);
        on(Mode::Free).on(order, facts).refused
    };
    assert_eq!(order(&IDLE), None);
    assert_eq!(order(&Facts { target: false, ..IDLE }), Some(Refused::Target));
    assert_eq!(order(&Facts { path: true, ..IDLE }), Some(Refused::UnhomeMoves));
    assert_eq!(order(&Facts { homes: true, ..IDLE }), Some(Refused::UnhomeMoves));
}

#[test]
fn of_two_sources_only_one_moves_the_machine_and_a_local_one_ends_the_remote_one() {
    use OrderSource::{Local, Remote, Task};
    let jog = OrderKind::Jog(Jog::Joint);
    let moves = Facts { jogs: true, ..IDLE };
    // A path of the first source rests in a pause, and it jogs beside it.
    let beside = Facts { path: true, jogs: true, rests_on_path: true, ..IDLE };
    // (facts, who moves, who orders, refusal, stop)
    let rows = [
        (&moves, Local, Local, None, Stop::None),
        (&moves, Local, Remote, Some(Refused::Local), Stop::None),
        (&moves, Local, Task, Some(Refused::Local), Stop::None),
        (&moves, Remote, Remote, None, Stop::None),
        (&moves, Remote, Local, Some(Refused::Ended), Stop::Motion),
        (&moves, Remote, Task, Some(Refused::Remote), Stop::None),
        (&moves, Task, Task, None, Stop::None),
        (&moves, Task, Local, Some(Refused::Program), Stop::None),
        (&moves, Task, Remote, Some(Refused::Program), Stop::None),
        (&beside, Remote, Local, Some(Refused::Ended), Stop::Jogs),
        (&beside, Local, Remote, Some(Refused::Local), Stop::None),
    ];
    for (facts, mover, other, refused, stop) in rows {
        let mut machine = on(Mode::Free);
        let first = Facts { jogs: false, ..*facts };
        let begun = machine.on(Event::Order(jog, mover, IDLE.epoch), &first);
        assert_eq!(begun.refused, None, "{mover:?}");
        let answer = machine.on(Event::Order(jog, other, IDLE.epoch), facts);
        assert_eq!((answer.refused, answer.stop), (refused, stop), "{mover:?} {other:?}");
    }
}

#[test]
fn each_refusal_has_words_of_its_own() {
    let mut texts: Vec<_> = Refused::ALL.iter().map(|refused| refused.text()).collect();
    // The caller knows more of the e-stop, the object of the order, and its place.
    let callers = [Refused::Estop, Refused::Target, Refused::Place];
    assert!(callers.iter().all(|refused| refused.text().is_empty()));
    texts.retain(|text| !text.is_empty());
    assert!(texts.iter().all(|text| text.len() > 15), "{texts:?}");
    texts.sort_unstable();
    texts.dedup();
    assert_eq!(texts.len(), Refused::ALL.len() - callers.len());
}
