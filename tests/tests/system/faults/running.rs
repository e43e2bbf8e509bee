//! Functions, tasks, commands and actions that fail while the machine runs: on both clocks.

use hal_engine::ClockKind;
use hal_protocol::{FaultInfo, Link};
use hal_tests::machine::{Machine, bit, count, cycles, says, status, wait};

const CLOCKS: [ClockKind; 2] = [ClockKind::Virtual, ClockKind::Real];

/// Two threads, with a driver in each.
const DRIVERS: &str = "
    loadrt threads name1=fast period1=1000000 name2=slow period2=5000000
    loadrt boom count=2
    addf boom.0 fast
    addf boom.1 slow
    start";

/// Lets time pass until a condition holds.
fn until(m: &mut Machine, clock: ClockKind, what: &str, look: impl Fn(&mut Machine) -> bool) {
    match clock {
        ClockKind::Real => wait(m, what, look),
        ClockKind::Virtual => {
            let ran = (0..100).any(|_| {
                m.script("run 1000000");
                look(m)
            });
            assert!(ran, "timed out: {what}");
        }
    }
}

fn running(m: &mut Machine, clock: ClockKind) {
    until(m, clock, "both drivers run", |m| {
        count(m, "boom.0.cycles") > 1 && count(m, "boom.1.cycles") > 1
    });
}

/// Returns the cause without the line number of the plugin's source.
fn without_line(text: &str) -> String {
    let digits = |at: usize| text[at..].chars().take_while(char::is_ascii_digit).count();
    match text.find(".rs:") {
        Some(at) => format!("{}LINE{}", &text[..at + 4], &text[at + 4 + digits(at + 4)..]),
        None => text.to_owned(),
    }
}

#[test]
fn a_function_that_panics_stops_all_threads_and_says_who_and_why() {
    // The first 256 bytes end inside a letter.
    let cut = format!("oh {}t…", "täterätä ".repeat(21));
    for clock in CLOCKS {
        for (how, cause) in [
            ("0", "told to (faulty/src/boom.rs:LINE)"),
            ("1", "told to, in cycle # (faulty/src/boom.rs:LINE)"),
            ("2", "panicked (faulty/src/boom.rs:LINE)"),
            ("3", "panicked (faulty/src/boom.rs:LINE)"),
            ("4", &cut),
        ] {
            let mut m = Machine::new(clock);
            m.script(DRIVERS);
            running(&mut m, clock);
            assert!(bit(&mut m, "boom.0.line") && bit(&mut m, "boom.1.line"));
            m.script(&format!("setp boom.0.how {how}\nsetp boom.0.go 1"));
            until(&mut m, clock, "the fault is seen", |m| status(m).fault.is_some());

            let n = count(&mut m, "boom.0.cycles");
            let s = status(&mut m);
            let fault = s.fault.unwrap();
            let cause = cause.replace('#', &n.to_string());
            assert_eq!(
                FaultInfo { cause: without_line(&fault.cause), ..fault.clone() },
                FaultInfo {
                    component: "boom".into(),
                    funct: "boom.0".into(),
                    thread: "fast".into(),
                    cause,
                },
                "{clock:?} {how}"
            );
            assert!(!s.running);
            let said = m.said();
            assert_eq!(
                said,
                [format!(
                    "function 'boom.0' of component 'boom' failed in thread 'fast': {}; all \
                     threads are stopped and outputs are at their safe levels",
                    fault.cause
                )]
            );
            for driver in ["boom.0", "boom.1"] {
                assert!(!bit(&mut m, &format!("{driver}.line")), "outputs are safe");
                assert_eq!(count(&mut m, &format!("{driver}.stops")), 1, "{driver} was stopped");
            }

            // Nothing runs any more, until the faulty component is unloaded.
            let before = count(&mut m, "boom.1.cycles");
            m.script("setp boom.0.go 0\nidle 20");
            let refused = "function 'boom.0' has failed: threads stay stopped; 'status' says why; \
                           unload it to go on";
            assert_eq!(says(&mut m, "start"), refused);
            if clock == ClockKind::Virtual {
                m.script("run 50000000");
            }
            assert_eq!(count(&mut m, "boom.0.cycles"), n);
            assert_eq!(count(&mut m, "boom.1.cycles"), before);

            m.script("unloadrt boom");
            assert!(status(&mut m).fault.is_none() && !status(&mut m).running);
            // A new component of the same name is not the faulty one.
            m.script("loadrt boom count=2\naddf boom.0 fast\naddf boom.1 slow\nstart");
            running(&mut m, clock);
            assert!(status(&mut m).running && bit(&mut m, "boom.0.line"));
        }
    }
}

#[test]
fn a_function_that_failed_may_be_taken_out_instead() {
    for clock in CLOCKS {
        let mut m = Machine::new(clock);
        m.script(DRIVERS);
        running(&mut m, clock);
        m.script("setp boom.0.go 1");
        until(&mut m, clock, "the fault is seen", |m| status(m).fault.is_some());
        m.script("delf boom.0\nstart");
        let n = count(&mut m, "boom.1.cycles");
        until(&mut m, clock, "the other runs on", |m| count(m, "boom.1.cycles") > n + 1);
        assert!(status(&mut m).fault.is_none() && status(&mut m).running);
    }
}

#[test]
fn a_fault_in_the_last_moment_of_a_run_is_seen_at_its_end() {
    let mut m = Machine::new(ClockKind::Virtual);
    m.script(DRIVERS);
    m.script("setp boom.0.go 1\nrun 1000000");
    assert_eq!(status(&mut m).fault.map(|f| f.funct).as_deref(), Some("boom.0"));
    assert_eq!(count(&mut m, "boom.0.stops"), 1);
}

#[test]
fn a_function_that_panics_in_its_first_cycle_of_all() {
    for clock in CLOCKS {
        let mut m = Machine::new(clock);
        m.script("loadrt threads\nloadrt boom\ninitf boom.0 thread1\nsetp boom.0.go 1\nstart");
        until(&mut m, clock, "the fault is seen", |m| status(m).fault.is_some());
        assert_eq!(status(&mut m).fault.unwrap().funct, "boom.0");
        assert_eq!(count(&mut m, "boom.0.cycles"), 1);
    }
}

#[test]
fn actions_and_ends_that_panic_change_nothing_else() {
    for clock in CLOCKS {
        let mut m = Machine::new(clock);
        m.script(DRIVERS);
        running(&mut m, clock);
        m.script("setp boom.0.bad-stop 1\nsetp boom.0.bad-drop 1\nsetp boom.1.go 1");
        until(&mut m, clock, "the fault is seen", |m| status(m).fault.is_some());
        let said: Vec<String> = m.said().iter().map(|s| without_line(s)).collect();
        let stop = "boom: stop action: panicked: told to panic when stopped \
                    (faulty/src/boom.rs:LINE)";
        assert_eq!(said[0], stop);
        assert!(said[1].starts_with("function 'boom.1' of component 'boom' failed"), "{said:?}");
        assert!(!bit(&mut m, "boom.1.line"), "the other's outputs are safe all the same");
        assert_eq!(says(&mut m, "unloadrt boom"), "ok");
        let said: Vec<String> = m.said().iter().map(|s| without_line(s)).collect();
        assert_eq!(said, [stop]);
        m.script("loadrt boom\naddf boom.0 fast\nstart");
        until(&mut m, clock, "it runs again", |m| count(m, "boom.0.cycles") > 0);
    }
}

#[test]
fn tasks_and_commands_that_panic_say_so_and_threads_go_on() {
    for clock in CLOCKS {
        let mut m = Machine::new(clock);
        m.script("loadrt threads\nloadrt lazy\nloadrt and2\naddf and2.0 thread1\nstart");
        until(&mut m, clock, "the task works", |m| count(m, "lazy.times") > 1);
        let said = without_line(&says(&mut m, "lazy.panic"));
        assert_eq!(said, "panicked: told to panic in a command (faulty/src/lazy.rs:LINE)");
        assert_eq!(says(&mut m, "lazy.refuse"), "not now");
        assert_eq!(says(&mut m, "lazy.sing"), "command 'lazy.sing' not found");
        let odd = "Invalid parameter `hm'; an argument is NAME=VALUE, such as count=2";
        assert_eq!(says(&mut m, "lazy.wait hm"), odd);
        m.script("setp lazy.go 1");
        let failed = ["work", "rest"].map(|what| {
            format!(
                "task 'lazy.{what}' has failed and is not run again: told to panic at {what} \
                 (faulty/src/lazy.rs:LINE)"
            )
        });
        let mut said = Vec::new();
        for _ in 0..60_000 {
            m.script(if clock == ClockKind::Real { "idle 1" } else { "run 10000000" });
            said = m.said().iter().map(|s| without_line(s)).collect();
            if !said.is_empty() {
                break;
            }
        }
        assert_eq!(said, failed, "both are due at the same time");
        let n = count(&mut m, "lazy.times");
        m.script("setp lazy.go 0");
        let beat = count(&mut m, "thread1.threadbeat");
        until(&mut m, clock, "threads go on", |m| count(m, "thread1.threadbeat") > beat + 20);
        assert_eq!(count(&mut m, "lazy.times"), n, "it is not run again");
        assert!(status(&mut m).running && status(&mut m).fault.is_none());
    }
}

#[test]
fn engines_side_by_side_keep_their_causes_apart() {
    let panics = |how: u32, cause: &'static str| {
        move || {
            for _ in 0..200 {
                let mut m = Machine::new(ClockKind::Virtual);
                m.script(&format!("{DRIVERS}\nsetp boom.0.how {how}\nsetp boom.0.go 1"));
                m.script("run 10000000");
                let fault = status(&mut m).fault.map(|f| without_line(&f.cause));
                assert_eq!(fault.as_deref(), Some(cause));
            }
        }
    };
    let other = std::thread::spawn(panics(2, "panicked (faulty/src/boom.rs:LINE)"));
    panics(0, "told to (faulty/src/boom.rs:LINE)")();
    other.join().unwrap();
}

#[test]
fn of_two_that_fail_at_once_each_cause_stays_with_its_function() {
    let mut m = Machine::new(ClockKind::Real);
    m.script(
        "loadrt threads name1=fast period1=500000 name2=slow period2=1000000
         loadrt stuck",
    );
    for round in 0..20 {
        m.script(
            "loadrt boom count=2
             addf boom.0 fast
             addf stuck.0 slow
             addf boom.1 slow
             setp boom.1.how 1
             start
             setp stuck.0.hold 1",
        );
        wait(&mut m, "the slow one is inside", |m| bit(m, "stuck.0.inside"));
        // The fast thread's function fails now, and the slow one's in the cycle that it is already in.
        m.script("setp boom.1.go 1\nsetp boom.0.go 1\nsetp stuck.0.hold 0");
        wait(&mut m, "the fault is seen", |m| status(m).fault.is_some());
        let fault = status(&mut m).fault.unwrap();
        let start = if fault.funct == "boom.0" { "told to (" } else { "told to, in cycle" };
        assert!(fault.cause.starts_with(start), "{round}: {fault:?}");
        m.script("unloadrt boom\ndelf stuck.0");
    }
}

#[test]
fn a_command_under_way_ends_when_its_component_goes() {
    let mut m = Machine::new(ClockKind::Virtual);
    m.script("loadrt threads\nloadrt lazy");
    let ticket = match m.call(hal_tests::machine::request("lazy.wait")).unwrap() {
        hal_protocol::Reply::Answer(a) => a.ticket.unwrap(),
        other => unreachable!("{other:?}"),
    };
    m.script("unloadrt lazy");
    let end = m.call(hal_protocol::Request::Ticket { id: ticket, wait: true }).unwrap();
    let why = hal_protocol::TicketInfo::Failed("its component was unloaded".into());
    assert_eq!(end, hal_protocol::Reply::Ticket(why));
}

#[test]
fn an_overrun_is_counted_with_the_guilty_function_and_stops_nothing() {
    let mut m = Machine::new(ClockKind::Real);
    m.script(
        "loadrt threads name1=fast period1=1000000
         loadrt busy count=2
         loadrt and2
         addf busy.0 fast
         addf and2.0 fast
         addf busy.1 fast
         start",
    );
    cycles(&mut m, "fast", 5);
    m.script("setp busy.1.ns 3000000\nsetp busy.0.ns 100000");
    wait(&mut m, "it overruns", |m| {
        let t = hal_tests::machine::thread(m, "fast");
        t.overruns >= 3 && t.overrun_by.as_deref() == Some("busy.1")
    });
    let t = hal_tests::machine::thread(&mut m, "fast");
    assert!(t.tmax >= 3_100_000, "{} ns", t.tmax);
    assert!(count(&mut m, "busy.1.tmax") >= 3_000_000);
    // The machine continues, and without the faulty component it overruns only as often as the system causes.
    m.script("setp busy.1.ns 0");
    cycles(&mut m, "fast", 50);
    assert!(status(&mut m).running && status(&mut m).fault.is_none());
}

#[test]
fn all_of_this_without_fifo() {
    hal_tests::machine::without_fifo(module_path!(), "all_of_this_without_fifo");
}
