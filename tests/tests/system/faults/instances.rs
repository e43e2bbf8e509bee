//! Many instances at once, and the files left by those that end or are killed.
#![expect(clippy::unwrap_used, reason = "tests")]

use hal_protocol::Client;
use hal_tests::{
    machine::{bit, cycles, script, status},
    scratch::{Running, Scratch, until},
};
use rustix::process::Signal;

const INSTANCES: usize = 64;

const MACHINE: &str = "\
# a gate in a thread
loadrt threads name1=base period1=2000000
loadrt and2
addf and2.0 base
setp and2.0.in1 1
start
";

fn start(scratch: &Scratch, name: &str) -> Running {
    scratch.start(scratch.command(&[], "halrun").args(["--instance", name, "machine.hal"]))
}

/// Returns a client as soon as the instance runs.
fn client(scratch: &Scratch, name: &str) -> Client {
    let place = scratch.place(name);
    let mut found = None;
    until(&format!("{name} runs"), || {
        found = Client::connect(&place, "").ok();
        found.as_mut().is_some_and(|c| status(c).running)
    });
    found.unwrap()
}

#[test]
fn sixty_four_instances_at_once_and_none_knows_of_another() {
    let scratch = Scratch::new("instances");
    scratch.write("machine.hal", MACHINE);
    let names: Vec<String> = (0..INSTANCES).map(|n| format!("machine-{n}")).collect();
    let mut running: Vec<Running> = names.iter().map(|n| start(&scratch, n)).collect();
    let mut clients: Vec<Client> = names.iter().map(|n| client(&scratch, n)).collect();
    for (i, (name, c)) in names.iter().zip(&mut clients).enumerate() {
        let s = status(c);
        assert_eq!(s.instance, *name);
        assert_eq!(s.pid, i32::try_from(running.get(i).unwrap().pid()).unwrap());
        if i % 2 == 0 {
            script(c, "setp and2.0.in0 1");
        }
    }
    for (i, c) in clients.iter_mut().enumerate() {
        cycles(c, "base", 2);
        assert_eq!(bit(c, "and2.0.out"), i % 2 == 0, "machine-{i}");
    }
    // A second instance of the same name is refused, without effect on the first.
    let again = start(&scratch, "machine-0").wait();
    assert_eq!(again.status, Some(1));
    let refused = "halrun: Realtime already running.  Use 'halrun -U' to stop existing realtime \
                   session.\n";
    assert_eq!(again.stderr, refused);
    assert!(bit(clients.first_mut().unwrap(), "and2.0.out"));

    // Half of them end in an orderly manner and leave nothing; the others are killed.
    drop(clients);
    let killed = running.split_off(INSTANCES / 2);
    for r in &running {
        r.signal(Signal::TERM);
    }
    for r in running {
        let ended = r.wait();
        assert_eq!((ended.status, ended.stderr.as_str()), (Some(0), ""));
    }
    for r in killed {
        r.signal(Signal::KILL);
        assert_eq!(r.wait().status, None);
    }
    // Their watchers remove their files.
    until("nothing is left of those that were killed", || scratch.left().is_empty());

    // A new start of every name works.
    let mut running: Vec<Running> = names.iter().map(|n| start(&scratch, n)).collect();
    for (name, r) in names.iter().zip(&mut running) {
        assert!(!bit(&mut client(&scratch, name), "and2.0.out"), "a new machine");
        assert!(r.is_running());
        r.signal(Signal::INT);
    }
    for r in running {
        assert_eq!(r.wait().status, Some(0));
    }
    assert_eq!(scratch.left(), [""; 0]);
}

#[test]
fn of_many_that_start_under_one_name_one_comes_up() {
    let scratch = Scratch::new("one");
    scratch.write("machine.hal", MACHINE);
    for _ in 0..3 {
        let mut all: Vec<Running> = (0..12).map(|_| start(&scratch, "one")).collect();
        let mut c = client(&scratch, "one");
        let pid = status(&mut c).pid;
        until("all others are refused", || {
            all.iter_mut().map(Running::is_running).filter(|runs| *runs).count() == 1
        });
        cycles(&mut c, "base", 2);
        assert_eq!(status(&mut c).pid, pid);
        for r in all {
            let owner = i32::try_from(r.pid()).unwrap() == pid;
            if owner {
                r.signal(Signal::KILL);
            }
            let ended = r.wait();
            let refused = ended.stderr.contains("already running");
            assert!(owner || refused, "{ended:?}");
        }
    }
}

/// A killed process holds its lock until it is gone, and its watcher holds it for a moment
/// afterwards.
#[test]
fn an_instance_starts_at_once_in_the_place_of_one_that_was_killed() {
    let scratch = Scratch::new("restarts");
    scratch.write("machine.hal", MACHINE);
    let place = scratch.place("again");
    let mut old = start(&scratch, "again");
    drop(client(&scratch, "again"));
    for n in 0..50 {
        old.signal(Signal::KILL);
        let mut new = start(&scratch, "again");
        let pid = i32::try_from(new.pid()).unwrap();
        until("the next one runs", || {
            assert!(new.is_running(), "restart {n}: {:?}", new.said());
            Client::connect(&place, "").is_ok_and(|mut c| status(&mut c).pid == pid)
        });
        old = new;
    }
}
