//! A thousand instances of any component, each of the largest size, load, run and leave nothing behind; so do all
//! components of all libraries, together in one engine.
#![expect(clippy::unwrap_used, clippy::panic, reason = "tests")]

use hal_engine::Engine;
use hal_protocol::{Kind, Link, Reply, Request, StatusInfo};
use hal_tests::{
    every,
    machine::{says, script, status},
};

/// Number of instances of each.
const COUNT: usize = 1000;

/// Memory of a pin or parameter that threads access, in bytes.
const SLOT: u64 = 16;

/// Returns the memory in use and the number of objects of each kind.
fn usage(s: &StatusInfo) -> (u64, [u32; 6]) {
    let all = [&s.components, &s.pins, &s.params, &s.signals, &s.functs, &s.threads];
    (s.memory.0, all.map(|u| u.active))
}

fn names(e: &mut Engine, kind: Kind) -> Vec<String> {
    match e.call(Request::List { kind, patterns: Vec::new(), ty: None }).unwrap() {
        Reply::Functs(list) => list.into_iter().map(|f| f.name).collect(),
        Reply::Threads(list) => list.into_iter().map(|t| t.name).collect(),
        other => panic!("{other:?}"),
    }
}

/// Runs some cycles of everything that is loaded in one thread; returns the status afterwards.
fn run(e: &mut Engine) -> StatusInfo {
    if names(e, Kind::Threads).is_empty() {
        script(e, "loadrt threads name1=all period1=1000000");
    }
    // The slowest thread comes first; the base thread of motmod has no floating point.
    let (all, thread) = (names(e, Kind::Functs), names(e, Kind::Threads).swap_remove(0));
    all.iter().for_each(|f| script(e, &format!("addf {f} {thread}")));
    script(e, "start\nrun 5000000\nstop");
    let s = status(e);
    assert!(s.fault.is_none(), "{:?}", s.fault);
    assert_eq!(s.functs.active as usize, all.len());
    let used = u64::from(s.pins.active + s.params.active) * SLOT;
    assert!(s.memory.0 < used + 1024, "{} bytes for what takes {used}", s.memory.0);
    s
}

#[test]
fn a_thousand_instances_of_any_component() {
    let mut e = every::engine();
    let before = usage(&status(&mut e));
    for offer in every::offers() {
        let name = &offer.component;
        match name.as_str() {
            "motmod" => script(&mut e, "loadrt trivkins"),
            "task" => script(&mut e, "loadrt iocontrol\nloadrt trivkins\nloadrt motmod"),
            name if every::needs_motion(name) => script(&mut e, "loadrt trivkins\nloadrt motmod"),
            _ => {}
        }
        let said = says(&mut e, &format!("loadrt {name} {}", every::large(&offer, COUNT)));
        assert_eq!(said, "ok", "{name}");
        let s = run(&mut e);
        if every::is_counted(&offer) {
            assert!(s.pins.active as usize >= COUNT, "{name}: {} pins", s.pins.active);
        }
        script(&mut e, "unloadrt all");
        assert_eq!(usage(&status(&mut e)), before, "{name} leaves something behind");
        drop(e.take_messages());
    }
}

/// Components whose names collide with those loaded before them: second spellings of one.
const TAKEN: [&str; 3] = [
    "at_pid: duplicate pin 'pid.0.enable'",
    "iocontrol: duplicate pin 'iocontrol.0.user-enable-out'",
    "iov2: duplicate pin 'iocontrol.0.user-enable-out'",
];

#[test]
fn all_components_of_all_libraries_in_one_engine() {
    let mut e = every::engine();
    let before = usage(&status(&mut e));
    let (mut refused, mut kinematics) = (Vec::new(), 0);
    let mut offers = every::offers();
    offers.sort_by_key(|o| (every::order(&o.component), o.component != "pid", o.component.clone()));
    for offer in &offers {
        let name = &offer.component;
        let said = says(&mut e, &format!("loadrt {name} {}", every::ways(name)[0]));
        if said == format!("{name}: kinematics are loaded already, by component 'trivkins'") {
            kinematics += 1;
        } else if said != "ok" {
            refused.push(said);
        }
    }
    assert_eq!(refused, TAKEN);
    assert_eq!(kinematics, offers.iter().filter(|o| o.library == "kinematics").count());
    let s = run(&mut e);
    // Each thread has a component.
    let loaded = (s.components.active - s.threads.active) as usize;
    assert_eq!(loaded, offers.len() - TAKEN.len() - kinematics);
    script(&mut e, "unloadrt all");
    assert_eq!(usage(&status(&mut e)), before);
}
