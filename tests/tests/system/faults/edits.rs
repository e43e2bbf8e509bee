//! Changes to a machine while its threads run on the real clock, and threads that block them.

use hal_engine::ClockKind;
use hal_protocol::{Kind, Link, Reply, Request};
use hal_tests::machine::{
    Machine, bit, count, cycles, request, says, status, thread, wait, without_fifo,
};

/// Returns the state that a refusal must not change; values aside.
fn wiring(m: &mut Machine) -> Vec<String> {
    let mut text = Vec::new();
    for kind in [Kind::Components, Kind::Signals, Kind::Functs, Kind::Pins, Kind::Threads] {
        match m.call(Request::List { kind, patterns: Vec::new(), ty: None }) {
            Ok(Reply::Items(list)) => {
                text.extend(list.into_iter().map(|i| format!("{} {:?}", i.name, i.signal)));
            }
            Ok(Reply::Signals(list)) => {
                text.extend(list.into_iter().map(|s| format!("{} {:?}", s.name, s.pins)));
            }
            Ok(Reply::Threads(list)) => {
                text.extend(list.into_iter().map(|t| format!("{} {:?}", t.name, t.functs)));
            }
            Ok(Reply::Functs(list)) => {
                text.extend(list.into_iter().map(|f| format!("{} {}", f.name, f.users)));
            }
            other => text.push(format!("{other:?}")),
        }
    }
    text
}

#[test]
fn a_change_to_running_threads_is_whole() {
    let mut m = Machine::new(ClockKind::Real);
    // Witnesses 2 and 3 are in no thread: they hold the values of the signals.
    m.script(
        "loadrt threads name1=fast period1=200000 name2=slow period2=2000000
         loadrt witness count=4
         loadrt or2
         addf witness.0 fast
         addf witness.1 slow
         setp witness.0.ns 20000
         # The slow one is inside most of the time: the fast one finds a boundary all the same.
         setp witness.1.ns 1200000
         setp witness.2.a 7
         setp witness.3.a 9
         net seven witness.2.a
         net nine witness.3.a
         start",
    );
    cycles(&mut m, "slow", 2);
    let pins = "witness.0.a witness.0.b witness.1.a witness.1.b";
    for round in 0..60 {
        let (name, holder) = if round % 2 == 0 { ("seven", 2) } else { ("nine", 3) };
        m.script(&format!("net {name} {pins}\naddf or2.0 fast 1"));
        cycles(&mut m, "slow", 1);
        m.script(&format!("delsig {name}\nnet {name} witness.{holder}.a\ndelf or2.0 fast"));
    }
    for witness in ["witness.0", "witness.1"] {
        assert_eq!(count(&mut m, &format!("{witness}.torn")), 0, "{witness}");
        assert_eq!(count(&mut m, &format!("{witness}.changes")), 60, "{witness} saw every change");
    }
    assert_eq!(thread(&mut m, "fast").functs, ["witness.0"]);
}

#[test]
fn components_come_and_go_while_threads_run() {
    let mut m = Machine::new(ClockKind::Real);
    m.script(
        "loadrt threads name1=fast period1=200000 name2=slow period2=1000000
         loadrt witness count=2
         addf witness.0 fast
         addf witness.1 slow
         start",
    );
    for _ in 0..40 {
        m.script(
            "loadrt boom count=2
             loadrt and2
             net line boom.0.line boom.1.line
             net gate and2.0.in0
             addf boom.0 fast 1
             addf and2.0 slow 1
             addf boom.1 slow -1
             alias pin and2.0.out gate-out",
        );
        wait(&mut m, "the new ones run", |m| {
            count(m, "boom.0.cycles") > 2 && count(m, "boom.1.cycles") > 2
        });
        assert_eq!(thread(&mut m, "slow").functs, ["and2.0", "witness.1", "boom.1"]);
        m.script("unloadrt boom\nunloadrt and2\ndelsig line\ndelsig gate");
        assert_eq!(thread(&mut m, "fast").functs, ["witness.0"]);
        // Threads are created and removed as well; their functions are then free for others.
        m.script(
            "loadrt doomed
             addf doomed.copy doomed-thread
             loadrt or2
             addf or2.0 doomed-thread
             unloadrt doomed
             addf or2.0 slow
             unloadrt or2",
        );
    }
    let s = status(&mut m);
    assert!(s.running && s.fault.is_none());
    assert_eq!((s.signals.active, s.aliases.active), (0, 0));
}

#[test]
fn more_than_256_stores_at_once_are_refused_while_threads_run() {
    let mut m = Machine::new(ClockKind::Real);
    m.script("loadrt threads\nloadrt and2 count=300\naddf and2.0 thread1\nstart");
    let net = |n: usize| {
        let pins: Vec<String> = (0..n).map(|i| format!("and2.{i}.in0")).collect();
        format!("net many {}", pins.join(" "))
    };
    let refused = |n| {
        format!(
            "this change takes {n} stores at once; at most 256 are made while threads run; do it in parts, or 'stop' before and 'start' after"
        )
    };
    let empty = wiring(&mut m);
    assert_eq!(says(&mut m, &net(256)), refused(257), "one for each pin, and the signal's value");
    assert_eq!(wiring(&mut m), empty);
    assert_eq!(says(&mut m, &net(255)), "ok");
    let full = wiring(&mut m);
    assert_eq!(says(&mut m, "delsig many"), refused(510), "each pin keeps the signal's value");
    assert_eq!(says(&mut m, "unloadrt and2"), refused(510));
    assert_eq!(wiring(&mut m), full);
    assert!(status(&mut m).running, "it runs on");
    m.script("stop\nunloadrt and2\nstart");
    assert_eq!(status(&mut m).pins.active, 2);
}

#[test]
fn a_stuck_thread_is_named_and_nothing_changes_until_it_comes_back() {
    let mut m = Machine::new(ClockKind::Real);
    m.script(
        "loadrt threads name1=fast period1=1000000 name2=slow period2=4000000
         loadrt stuck
         loadrt and2 count=2
         addf and2.0 fast
         addf stuck.0 slow
         start",
    );
    cycles(&mut m, "slow", 1);
    m.script("setp stuck.0.hold 1");
    wait(&mut m, "it is stuck", |m| bit(m, "stuck.0.inside"));
    let stuck = "thread 'slow' is stuck in its cycle, in function 'stuck.0'";
    let before = wiring(&mut m);
    for line in [
        "unloadrt stuck",
        "net x and2.0.out and2.1.in0",
        "addf and2.1 fast",
        "unloadrt threads",
        "unloadrt threads",
    ] {
        assert_eq!(says(&mut m, line), stuck, "{line}");
        assert_eq!(wiring(&mut m), before, "{line}");
    }
    // Requests that need no boundary work.
    m.script("setp and2.1.in0 1\nnewsig y bit\ndelsig y\nloadrt or2\nunloadrt or2");
    assert!(bit(&mut m, "and2.1.in0"));
    m.script("setp stuck.0.hold 0");
    wait(&mut m, "it comes back", |m| !bit(m, "stuck.0.inside"));
    cycles(&mut m, "slow", 2);
    cycles(&mut m, "fast", 2);
    m.script("net x and2.0.out and2.1.in0\nunloadrt stuck\nunloadrt threads\nunloadrt all");
    assert_eq!(status(&mut m).pins.active, 0);
}

#[test]
fn threads_that_are_stopped_and_stuck_are_named_too() {
    let mut m = Machine::new(ClockKind::Real);
    m.script(
        "loadrt threads name1=fast period1=1000000
         loadrt stuck
         loadrt and2
         addf stuck.0 fast
         start
         setp stuck.0.hold 1",
    );
    wait(&mut m, "it is stuck", |m| bit(m, "stuck.0.inside"));
    let stuck = "thread 'fast' is stuck in its cycle, in function 'stuck.0'";
    for line in ["stop", "net x and2.0.out", "unloadrt threads", "unloadrt stuck", "stop"] {
        assert_eq!(says(&mut m, line), stuck, "{line}");
    }
    m.script("setp stuck.0.hold 0");
    wait(&mut m, "it comes back", |m| !bit(m, "stuck.0.inside"));
    let n = count(&mut m, "stuck.0.cycles");
    m.script("stop\nidle 20");
    assert_eq!(count(&mut m, "stuck.0.cycles"), n, "it is stopped");
    m.script("start");
    wait(&mut m, "it runs again", |m| count(m, "stuck.0.cycles") > n);
    m.script("unloadrt all");
}

#[test]
fn an_engine_ends_although_a_thread_is_stuck() {
    for unload_first in [false, true] {
        let mut m = Machine::new(ClockKind::Real);
        m.script(
            "loadrt threads name1=fast period1=1000000
             loadrt stuck
             loadrt boom
             addf stuck.0 fast
             addf boom.0 fast
             start",
        );
        wait(&mut m, "it runs", |m| count(m, "boom.0.cycles") > 0);
        m.script("setp stuck.0.hold 1");
        wait(&mut m, "it is stuck", |m| bit(m, "stuck.0.inside"));
        if unload_first {
            let stuck = "thread 'fast' is stuck in its cycle, in function 'stuck.0'";
            assert_eq!(says(&mut m, "unloadrt threads"), stuck);
        }
        // The memory that the thread still uses is kept: nothing here may crash, now or later.
        m.end();
        let mut other = Machine::new(ClockKind::Real);
        other.script("loadrt threads\nloadrt boom\naddf boom.0 thread1\nstart");
        wait(&mut other, "another engine runs", |m| count(m, "boom.0.cycles") > 5);
    }
}

#[test]
fn each_lock_refuses_its_own_and_changes_nothing() {
    let mut m = Machine::new(ClockKind::Real);
    m.script(
        "loadrt threads
         loadrt and2 count=2
         net x and2.0.out and2.1.in0
         addf and2.0 thread1
         start",
    );
    let of = |what: &str| match what {
        "loading of programs" => format!("HAL is locked, {what} is not permitted"),
        "signal_delete" | "link" | "unlink" | "pin_alias" => {
            format!("{what} called while HAL locked")
        }
        _ => format!("{what} called while HAL is locked"),
    };
    let load = [("loadrt or2", "loading of programs")];
    let config = [
        ("newsig y bit", "signal_new"),
        ("delsig x", "signal_delete"),
        ("net x and2.1.in1", "link"),
        ("linkps and2.1.in1 x", "link"),
        ("unlinkp and2.1.in0", "unlink"),
        ("addf and2.1 thread1", "add_funct_to_thread"),
        ("delf and2.0 thread1", "del_funct_from_thread"),
        ("alias pin and2.0.out z", "pin_alias"),
    ];
    let run = [("start", "start_threads"), ("stop", "stop_threads")];
    let before = wiring(&mut m);
    for (level, refused) in [
        ("load", &load[..]),
        ("config", &config),
        ("run", &run),
        ("tune", &[load[0], config[0], config[7]]),
        ("all", &[load[0], config[1], run[0], run[1]]),
    ] {
        m.script(&format!("lock {level}"));
        for (line, what) in refused {
            assert_eq!(says(&mut m, line), of(what), "{level}: {line}");
            assert_eq!(wiring(&mut m), before, "{level}: {line}");
        }
        assert!(status(&mut m).running);
    }
    // Values are not configuration: LinuxCNC also permits setting them.
    m.script("lock all\nsetp and2.1.in1 1");
    m.script("lock none\nnewsig y bit\ndelsig y\nstop\nstart");
    for line in ["lock load", "stop", "start", "newsig y bit", "lock run", "delsig y"] {
        assert!(m.call(request(line)).is_ok(), "{line}");
    }
}

#[test]
fn all_of_this_on_one_thread_of_the_system() {
    without_fifo(module_path!(), "all_of_this_on_one_thread_of_the_system");
}
