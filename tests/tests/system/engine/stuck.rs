//! A thread that is stuck in a function: outputs go to their safe levels while it is stuck, and nothing restarts by
//! itself; a thread that is only late does not count as stuck.

use hal_engine::{ClockKind, Engine, Options, RealtimeOptions};
use hal_protocol::{Failure, FaultInfo, Place};
use hal_tests::{
    machine::{Machine, bit, count, cycles, options, says, status, wait, without_fifo},
    scratch::until,
    tools::report,
};
use std::sync::{
    Arc,
    atomic::{AtomicBool, Ordering::Relaxed},
};

/// The shortest time that can be configured: threads that are not stuck must still not be reported.
const SHORTEST: RealtimeOptions =
    RealtimeOptions { cpu: None, idle_us: Some(0), stuck_ns: Some(1_000_000), max_gap_ns: None };

/// Drivers in two threads; the second thread runs its driver after the function that may get stuck.
const DRIVERS: &str = "
    loadrt threads name1=fast period1=1000000 name2=slow period2=5000000
    loadrt boom count=3
    loadrt stuck
    addf boom.0 fast
    addf boom.1 slow
    addf stuck.0 slow
    addf boom.2 slow
    start";

fn running(m: &mut Machine) {
    wait(m, "the drivers run", |m| (0..3).all(|i| count(m, &format!("boom.{i}.cycles")) > 1));
    assert!((0..3).all(|i| bit(m, &format!("boom.{i}.line"))));
}

fn lines(m: &mut Machine) -> Vec<bool> {
    (0..3).map(|i| bit(m, &format!("boom.{i}.line"))).collect()
}

#[test]
fn outputs_are_safe_while_the_thread_is_still_stuck_and_nothing_begins_again() {
    let mut m = Machine::realtime(RealtimeOptions::default());
    m.script(DRIVERS);
    running(&mut m);
    // Two periods of the slowest thread.
    assert_eq!(status(&mut m).realtime.unwrap().stuck_ns, 10_000_000);
    assert_eq!(status(&mut m).fault, None);
    m.script("setp stuck.0.hold 1");
    until("outputs are at their safe levels", || lines(&mut m) == [false; 3]);
    assert!(bit(&mut m, "stuck.0.inside"));
    // Once by the watching thread, once by the control side.
    until("both have driven them", || count(&mut m, "boom.2.stops") >= 2);

    m.script("idle 1");
    let fault = FaultInfo {
        component: "stuck".into(),
        funct: "stuck.0".into(),
        thread: "slow".into(),
        cause: "it did not come back within 10 ms".into(),
    };
    let s = status(&mut m);
    assert_eq!(s.fault.as_ref(), Some(&fault));
    assert_eq!(s.stuck, Some(FaultInfo { cause: "it does not come back".into(), ..fault }));
    assert!(!s.running && bit(&mut m, "stuck.0.inside"));
    assert_eq!(
        m.said(),
        ["function 'stuck.0' of component 'stuck' failed in thread 'slow': it did not come back \
          within 10 ms; all threads are stopped and outputs are at their safe levels"]
    );
    assert_eq!(lines(&mut m), [false; 3]);

    // The function returns: its cycle ends there, and outputs are driven once more.
    let stops = count(&mut m, "boom.2.stops");
    let before = [0, 1, 2].map(|i| count(&mut m, &format!("boom.{i}.cycles")));
    m.script("setp stuck.0.hold 0");
    wait(&mut m, "it has come back", |m| status(m).stuck.is_none());
    wait(&mut m, "outputs are driven again", |m| count(m, "boom.2.stops") > stops);
    m.script("idle 30");
    assert_eq!(count(&mut m, "stuck.0.cycles"), count(&mut m, "boom.1.cycles"));
    assert_eq!([0, 1, 2].map(|i| count(&mut m, &format!("boom.{i}.cycles"))), before);
    assert_eq!(lines(&mut m), [false; 3]);

    // Threads can run again only after the faulty component is unloaded.
    let refused = "function 'stuck.0' has failed: threads stay stopped; 'status' says why; unload \
                   it to go on";
    assert_eq!(says(&mut m, "start"), refused);
    m.script("delf stuck.0\nstart");
    wait(&mut m, "the others run", |m| {
        lines(m) == [true; 3] && count(m, "boom.2.cycles") > before[2]
    });
    assert!(status(&mut m).running && status(&mut m).fault.is_none());
    assert!(m.engine.close_checked(), "the fault is gone, and every thread has ended");
}

/// On a computer with one processor, a function that runs in circles under `SCHED_FIFO` would keep it from everything
/// that could end the process.
#[test]
fn a_stuck_thread_loses_its_priority_until_it_comes_back() {
    let mut m = Machine::realtime(RealtimeOptions::default());
    m.script(DRIVERS);
    running(&mut m);
    let stat = format!("/proc/self/task/{}/stat", count(&mut m, "stuck.0.tid"));
    // The 41st field; the second ends with the last parenthesis. 0 is an ordinary thread.
    let policy = || {
        let text = std::fs::read_to_string(&stat).unwrap();
        text.rsplit(") ").next().unwrap().split(' ').nth(38).unwrap().to_owned()
    };
    let before = policy();
    if before == "0" {
        report("this user may not use SCHED_FIFO: the thread had no priority to lose");
    }
    m.script("setp stuck.0.hold 1");
    wait(&mut m, "it is stuck", |m| status(m).fault.is_some());
    until("it is an ordinary thread", || policy() == "0");
    assert!(bit(&mut m, "stuck.0.inside"));
    m.script("setp stuck.0.hold 0");
    until("it is what it was", || policy() == before);
    m.script("delf stuck.0\nstart");
    let cycles = count(&mut m, "boom.1.cycles");
    wait(&mut m, "the others run", |m| count(m, "boom.1.cycles") > cycles);
    assert_eq!(policy(), before);
}

#[test]
fn a_machine_that_ends_while_a_thread_is_stuck_has_failed() {
    for stuck_ns in [None, Some(3_600_000_000_000)] {
        let mut m = Machine::realtime(RealtimeOptions { stuck_ns, ..RealtimeOptions::default() });
        m.script(DRIVERS);
        running(&mut m);
        m.script("setp stuck.0.hold 1");
        wait(&mut m, "it is inside", |m| bit(m, "stuck.0.inside"));
        if stuck_ns.is_none() {
            wait(&mut m, "it is stuck", |m| status(m).fault.is_some());
        } else {
            assert_eq!(lines(&mut m), [true; 3], "its time is not over");
        }
        assert!(!m.engine.close_checked());
    }
}

#[test]
fn a_thread_that_computes_for_too_long_is_stuck_and_one_that_has_time_is_not() {
    let script = "loadrt threads name1=t period1=1000000
        loadrt busy
        loadrt boom
        addf busy.0 t
        addf boom.0 t
        start";
    // 20 ms of computing are an overrun if a second is allowed, and too long if 2 ms are allowed.
    for (stuck_ns, fails) in [(Some(1_000_000_000), false), (None, true)] {
        let mut m = Machine::realtime(RealtimeOptions { stuck_ns, ..RealtimeOptions::default() });
        m.script(script);
        cycles(&mut m, "t", 3);
        m.script("setp busy.0.ns 20000000");
        if fails {
            wait(&mut m, "it is stuck", |m| status(m).fault.is_some());
            let fault = status(&mut m).fault.unwrap();
            assert_eq!((fault.funct.as_str(), fault.thread.as_str()), ("busy.0", "t"));
            assert_eq!(fault.cause, "it did not come back within 2 ms");
            wait(&mut m, "it comes back", |m| status(m).stuck.is_none());
            assert!(!bit(&mut m, "boom.0.line"));
        } else {
            wait(&mut m, "it overruns", |m| count(m, "busy.0.spun") > 5);
            assert!(status(&mut m).running && bit(&mut m, "boom.0.line"));
        }
    }
}

#[test]
fn a_function_that_sets_hardware_up_has_a_second() {
    let mut m = Machine::realtime(SHORTEST);
    m.script(
        "loadrt threads name1=t period1=1000000
         loadrt busy count=2
         initf busy.0 t
         addf busy.1 t
         setp busy.0.ns 30000000
         start",
    );
    cycles(&mut m, "t", 5);
    assert_eq!((count(&mut m, "busy.0.spun"), status(&mut m).fault), (1, None));
}

/// A thread that waits for a processor is not stuck, whatever the load of this computer.
#[test]
fn a_thread_that_waits_for_a_processor_is_not_stuck() {
    let end = Arc::new(AtomicBool::new(false));
    let hogs: Vec<_> = (0..16)
        .map(|_| {
            let end = end.clone();
            std::thread::spawn(move || {
                while !end.load(Relaxed) {
                    std::hint::spin_loop();
                }
            })
        })
        .collect();
    let mut m = Machine::realtime(SHORTEST);
    m.script(
        "loadrt threads name1=fast period1=500000 name2=slow period2=1000000
         loadrt busy count=2
         addf busy.0 fast
         addf busy.1 slow
         setp busy.0.ns 100000
         setp busy.1.ns 200000
         start",
    );
    cycles(&mut m, "slow", 500);
    assert_eq!(status(&mut m).fault, None);
    end.store(true, Relaxed);
    hogs.into_iter().for_each(|h| h.join().unwrap());
}

#[test]
fn all_of_this_without_fifo() {
    without_fifo(module_path!(), "all_of_this_without_fifo");
}

#[test]
fn a_processor_that_is_not_there_is_refused() {
    let realtime = RealtimeOptions { cpu: Some(1023), ..RealtimeOptions::default() };
    let place = Place::at("/nonexistent", "test").unwrap();
    let options = Options { realtime, ..options(place, ClockKind::Real) };
    let Err(Failure { text, .. }) = Engine::without_socket(options) else { panic!("it ran") };
    let said = "the threads cannot run on the processor of --cpu (HAL_CPU): processor 1023 is not \
                there; there are 0";
    assert!(text.starts_with(said), "{text}");
}
