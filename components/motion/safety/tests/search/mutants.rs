//! Planted faults: each must break an invariant.

use crate::{
    CONFIGS, DEPTH,
    model::{self, Model, Parts},
    remote::Remote,
    search,
};
use hal_safety::{
    Answer, Event, Facts, Jog, OrderKind, OrderSource, Power, Reaction, SafetyMachine, Stop,
    Trouble,
    lease::Jog as RemoteJog,
    plant::{Act, Config, Decide, Given, Plant, Way},
};

/// A fault: what it is, the invariant that must notice it, the parts with it, and whether a remote operator takes part.
struct Mutant {
    fault: &'static str,
    noticed_as: &'static str,
    parts: Parts,
    has_remote: bool,
}

const RIGHT: Parts =
    Parts { decide: SafetyMachine::on, spoil: |_, _, _| (), spoil_remote: |_, _| () };

const fn decides(fault: &'static str, noticed_as: &'static str, decide: Decide) -> Mutant {
    Mutant { fault, noticed_as, parts: Parts { decide, ..RIGHT }, has_remote: false }
}

const fn spoils(
    fault: &'static str,
    noticed_as: &'static str,
    spoil: fn(&Plant, Act, &mut Plant),
) -> Mutant {
    Mutant { fault, noticed_as, parts: Parts { spoil, ..RIGHT }, has_remote: false }
}

const fn remote(
    fault: &'static str,
    noticed_as: &'static str,
    spoil_remote: fn(&Remote, &mut Remote),
) -> Mutant {
    let parts = Parts { spoil_remote, ..RIGHT };
    Mutant { fault, noticed_as, parts, has_remote: true }
}

/// Returns a machine that is on, in the mode of another one.
fn on(like: &SafetyMachine) -> SafetyMachine {
    let mut machine = *like;
    machine.on(Event::Off, &Facts::default());
    let facts = Facts { enable: true, configured: true, ..Facts::default() };
    machine.on(Event::Order(OrderKind::Enable, OrderSource::Local, facts.epoch), &facts);
    machine
}

/// Facts of a machine that may be switched on, and rests.
pub(crate) const IDLE: Facts = Facts {
    epoch: hal_safety::Epoch { stops: 1, pauses: 0 },
    estop: false,
    enable: true,
    jog_inhibit: false,
    homing_inhibit: false,
    configured: true,
    jogs: false,
    homes: false,
    path: false,
    rests_on_path: false,
    parked: hal_safety::Parked::No,
    claimed: false,
    target: true,
    place: true,
    rests: true,
    moving: 0,
    open_loop: 0,
    volatile: 0,
};

const MUTANTS: &[Mutant] = &[
    decides("enable does not look at the e-stop", "an enable order is taken", |m, e, f| match e {
        Event::Order(OrderKind::Enable, ..) => m.on(e, &Facts { estop: false, ..*f }),
        _ => m.on(e, f),
    }),
    decides("enable does not look at the enable input", "an enable order is taken", |m, e, f| {
        match e {
            Event::Order(OrderKind::Enable, ..) => m.on(e, &Facts { enable: true, ..*f }),
            _ => m.on(e, f),
        }
    }),
    decides("an e-stop does not cut the power", "on without", |m, e, f| match e {
        Event::Trouble(Trouble::Hard) => Answer::default(),
        _ => m.on(e, f),
    }),
    decides("an e-stop ends by a ramp", "on without", |m, e, f| match e {
        Event::Trouble(Trouble::Hard) => m.on(Event::Trouble(Trouble::Limit(Reaction::Ramp)), f),
        _ => m.on(e, f),
    }),
    decides("a fault in a ramp waits for its end", "power after what cuts it", |m, e, f| match e {
        Event::Trouble(_) if m.power() == Power::Stops && !f.estop && f.enable => Answer::default(),
        _ => m.on(e, f),
    }),
    decides("twice a following error is no more than one", "on without", |m, e, f| match e {
        Event::Trouble(Trouble::Following { by, .. }) => {
            m.on(Event::Trouble(Trouble::Following { by, twice: false }), f)
        }
        _ => m.on(e, f),
    }),
    decides("a ramp does not switch off", "on without", |m, e, f| match e {
        Event::Cycle => Answer::default(),
        _ => m.on(e, f),
    }),
    decides("a jog begins in a ramp", "goes on after a soft fault", |m, e, f| match e {
        Event::Order(OrderKind::Jog(_), ..) if m.power() == Power::Stops => on(m).on(e, &IDLE),
        _ => m.on(e, f),
    }),
    decides("a soft fault stops nothing", "on without", |m, e, f| match e {
        Event::Trouble(Trouble::Limit(Reaction::Ramp)) => Answer::default(),
        _ => m.on(e, f),
    }),
    decides("a jog of a machine that is off", "moves without power", |m, e, f| match e {
        Event::Order(OrderKind::Jog(_), ..) if m.power() == Power::Off => on(m).on(e, f),
        _ => m.on(e, f),
    }),
    decides("epochs are not compared", "an order from before a stop is taken", |m, e, f| match e {
        Event::Order(order, source, _) => m.on(Event::Order(order, source, f.epoch), f),
        _ => m.on(e, f),
    }),
    decides("pauses are not compared", "an order from before a stop is taken", |m, e, f| match e {
        Event::Order(order @ (OrderKind::Jog(_) | OrderKind::Resume), source, given) => {
            let given = hal_safety::Epoch { pauses: f.epoch.pauses, ..given };
            m.on(Event::Order(order, source, given), f)
        }
        _ => m.on(e, f),
    }),
    decides("a move from before a pause moves", "a paused path moves", |m, e, f| Answer {
        rests_late: false,
        ..m.on(e, f)
    }),
    decides("an abort leaves the path", "moves without an order", |m, e, f| {
        let answer = m.on(e, f);
        let stop = if answer.stop == Stop::Abort { Stop::Jogs } else { answer.stop };
        Answer { stop, ..answer }
    }),
    decides("a pause leaves homing", "goes on after a stop", |m, e, f| match e {
        Event::Pause if f.homes => Answer::default(),
        _ => m.on(e, f),
    }),
    decides("a pause leaves the path", "goes on after a stop", |m, e, f| match e {
        Event::Pause => m.on(Event::JogStop { at_once: false }, f),
        _ => m.on(e, f),
    }),
    decides("off brakes", "on without", |m, e, f| match e {
        Event::Off => m.on(Event::Abort, f),
        _ => m.on(e, f),
    }),
    decides("a gap is not noticed", "on without", |m, e, f| match e {
        Event::Gap => Answer::default(),
        _ => m.on(e, f),
    }),
    decides("a gap leaves a joint homed", "the home of a joint", |m, e, f| match e {
        Event::Gap => m.on(e, &Facts { open_loop: 0, ..*f }),
        _ => m.on(e, f),
    }),
    decides("a volatile home stays", "the home of a joint", |m, e, f| {
        m.on(e, &Facts { volatile: 0, ..*f })
    }),
    decides("a jog does not look at who moves", "two sources move", |m, e, f| match e {
        Event::Order(order @ OrderKind::Jog(_), _, given) => {
            let mover = m.source(false);
            m.on(Event::Order(order, mover, given), &Facts { claimed: false, ..*f })
        }
        _ => m.on(e, f),
    }),
    decides("a local jog takes a remote one over", "two sources move", |m, e, f| match e {
        Event::Order(OrderKind::Jog(Jog::Joint), OrderSource::Local, given) => {
            let order = OrderKind::Jog(Jog::Joint);
            let answer = m.on(e, f);
            if answer.stop == Stop::None {
                answer
            } else {
                m.on(Event::Order(order, OrderSource::Remote, given), f)
            }
        }
        _ => m.on(e, f),
    }),
    decides("the mode changes in motion", "the mode changes in motion", |m, e, f| match e {
        Event::Order(OrderKind::Mode(_), ..) => m.on(e, &Facts { epoch: f.epoch, ..IDLE }),
        _ => m.on(e, f),
    }),
    decides("the end of an e-stop switches on", "on without", |m, e, f| match e {
        Event::Cycle if m.power() == Power::Off && !f.estop => {
            m.on(Event::Order(OrderKind::Enable, OrderSource::Local, f.epoch), f)
        }
        _ => m.on(e, f),
    }),
    spoils("a new move drops the pause", "a paused path moves", |_, act, to| {
        if matches!(act, Act::Order(OrderKind::Move, _, Given::Now)) {
            to.paused = false;
        }
    }),
    spoils(
        "the path waits while the machine is off",
        "a path outlives the power",
        |from, act, to| {
            if act == Act::Off && from.way != Way::None {
                to.way = Way::Waits;
            }
        },
    ),
    spoils("an abort keeps the moves that wait", "an abort leaves a path", |from, act, to| {
        if act == Act::Abort && from.way == Way::Waits {
            to.way = Way::Waits;
        }
    }),
    spoils("a spindle turns again by itself", "a feed runs on a spindle", |_, act, to| {
        if act == Act::Hold(false) && to.spindle_lost {
            (to.spindle_lost, to.paused) = (false, false);
        }
    }),
    Mutant {
        fault: "a path whose spindle is stopped is not paused",
        noticed_as: "a feed runs on a spindle",
        parts: Parts {
            decide: |m, e, f| match e {
                Event::SpindleStopped => Answer::default(),
                _ => m.on(e, f),
            },
            spoil: |_, act, to| to.spindle_lost &= act != Act::Settle,
            ..RIGHT
        },
        has_remote: false,
    },
    remote("a hold ends with the lease", "a held program moves", |was, to| {
        if was.words.number != 0 && to.words.number == 0 {
            to.words.hold = false;
        }
    }),
    remote("a beat ends a hold", "a held program moves", |_, to| {
        to.words.hold &= !to.words.permit;
    }),
    remote("a lease that is taken ends a hold", "a held program moves", |was, to| {
        if was.words.number == 0 && to.words.number != 0 {
            to.words.hold = false;
        }
    }),
    remote("a lease lasts without beats", "a lease without beats", |was, to| {
        to.words.number = was.words.number.max(to.words.number);
    }),
    remote("a jog is forgotten while it lasts", "a held jog without beats", |_, to| {
        to.words.jog = RemoteJog::None;
    }),
    remote("a held jog lasts as long as its lease", "a held jog without beats", |_, to| {
        if to.words.jog == RemoteJog::Held {
            to.words.jog = RemoteJog::Step;
        }
    }),
    Mutant {
        fault: "jog-stop is not obeyed",
        noticed_as: "a held jog without beats",
        parts: Parts {
            decide: |m, e, f| match e {
                Event::JogStop { .. } => Answer::default(),
                _ => m.on(e, f),
            },
            ..RIGHT
        },
        has_remote: true,
    },
];

#[test]
fn each_planted_fault_is_noticed() {
    let mut missed = Vec::new();
    for Mutant { fault, noticed_as, parts, has_remote } in MUTANTS {
        let moves = if *has_remote { model::with_remote() } else { model::alone() };
        let find =
            |config: &Config| search(Model::new(*config, *has_remote), &moves, parts, DEPTH).err();
        let found = CONFIGS.iter().find_map(find).unwrap_or_default();
        let first = found.lines().next().unwrap_or("nothing notices it");
        println!("{fault}: {first}");
        if !first.contains(noticed_as) {
            missed.push(format!("{fault}: not '{noticed_as}', but {first}"));
        }
    }
    assert!(missed.is_empty(), "{missed:#?}");
}
