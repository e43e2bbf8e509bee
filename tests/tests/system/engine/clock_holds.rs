//! No client holds the virtual clock: each request that could is refused, bounded, or abandoned with a message, and a
//! client that asks for time gets it.
#![expect(clippy::unwrap_used, reason = "tests")]

use hal_engine::ClockKind;
use hal_protocol::{Client, Link, Request, SampleSpec};
use hal_tests::{
    machine::{Served, count, cycles, script, status, thread},
    raw::Raw,
    scratch::Scratch,
};
use std::process::Command;

/// A thread with a stream that is read in every cycle; the clock moves only on request.
const MACHINE: &str = "
    loadrt threads
    loadrt feed
    addf feed.0 thread1
    start";

fn served(scratch: &Scratch) -> Served {
    Served::on(ClockKind::Virtual, scratch, "holds", MACHINE)
}

/// Returns the answer to another client that requests 10 ms of machine time: empty if it has to wait.
fn ten_ms(served: &Served) -> String {
    let before = status(&mut served.client()).time;
    let said = Raw::connect(served).ask("{\"run\":{\"ns\":10000000}}");
    let after = status(&mut served.client()).time;
    if after - before == 10_000_000 { said } else { format!("{said} {before} {after}") }
}

/// Number of records that a test writes at once: fewer than the stream holds.
const RECORDS: u64 = 3;
const DONE: &str = "{\"ok\":\"done\"}";

/// Returns the part of a refusal between `text":"` and the next quote.
fn refused(answer: &str) -> &str {
    let text = answer.split_once("{\"error\":").and_then(|(_, e)| e.split_once("\"text\":\""));
    text.and_then(|(_, t)| t.split('"').next()).unwrap_or(answer)
}

#[test]
fn a_poll_that_could_hold_the_clock_is_refused() {
    let scratch = Scratch::new("polls");
    let served = served(&scratch);
    let poll = "{\"poll\":{\"writes\":[]}}";
    let not_joined = "this client has not joined as a component";
    let mut raw = Raw::connect(&served);
    // From a client that has not joined, before and after it gives its name.
    assert_eq!(refused(&raw.ask(poll)), not_joined);
    assert_eq!(ten_ms(&served), DONE);
    raw.ask("{\"hello\":{\"protocol\":1,\"name\":\"\",\"pid\":7}}");
    assert_eq!(refused(&raw.ask(poll)), not_joined);
    assert_eq!(ten_ms(&served), DONE);

    // Periods that are too short or too long, at the edges of the legal range.
    for (ns, usable) in [
        (1, false),
        (999, false),
        (1_000, true),
        (1_000_000_000_000, true),
        (1_000_000_000_001, false),
        (i64::MAX.unsigned_abs() - 1, false),
        (i64::MAX.unsigned_abs(), false),
        (i64::MAX.unsigned_abs() + 1, false),
        (u64::MAX, false),
    ] {
        let join = format!("{{\"join\":{{\"name\":\"panel\",\"poll_ns\":{ns}}}}}");
        let mut raw = Raw::connect(&served);
        let answer = raw.ask(&join);
        if usable {
            assert_eq!(answer, DONE);
            assert_eq!(raw.ask("\"ready\""), DONE);
            drop(raw);
            let mut look = served.client();
            hal_tests::machine::wait(&mut look, "it goes", |c| {
                let info = c.call(Request::Component { name: "panel".into() }).unwrap();
                format!("{info:?}") == "Components([])"
            });
        } else {
            let want = format!(
                "a program cannot poll every {ns} ns; expected 1000 to 1000000000000 ns, or 0 for \
                 one that never polls"
            );
            assert_eq!(refused(&answer), want);
            // This client has not joined, so it cannot poll.
            assert_eq!(refused(&raw.ask(poll)), not_joined);
        }
        assert_eq!(ten_ms(&served), DONE, "{ns}");
    }

    // A client that joins again without a period no longer owes polls: they are forgotten with its pins.
    let mut raw = Raw::connect(&served);
    assert_eq!(raw.ask("{\"join\":{\"name\":\"a\",\"poll_ns\":1000000}}"), DONE);
    assert_eq!(raw.ask("\"ready\""), DONE);
    assert_eq!(raw.ask("{\"join\":{\"name\":\"b\",\"poll_ns\":0}}"), DONE);
    let said = raw.ask(poll);
    let want = "this program has joined without a period for its polls (poll_ns is 0)";
    assert_eq!(refused(&said), want);
    assert_eq!(ten_ms(&served), DONE);
    // A refused request to join changes nothing.
    assert!(raw.ask("{\"join\":{\"name\":\"c\",\"poll_ns\":1}}").contains("cannot poll"));
    let there =
        format!("{:?}", served.client().call(Request::Component { name: "b".into() }).unwrap());
    assert!(there.contains("\"b\""), "{there}");
    assert_eq!(served.end(), [""; 0]);
}

#[test]
fn the_clock_ends_before_its_sums_do() {
    let scratch = Scratch::new("sums");
    let served = served(&scratch);
    script(&mut served.client(), "stop");
    let run = |ns: u64| Raw::connect(&served).ask(&format!("{{\"run\":{{\"ns\":{ns}}}}}"));
    let end = i64::MAX.unsigned_abs() / 2;
    for ns in [u64::MAX, i64::MAX.unsigned_abs(), end + 1] {
        let said = run(ns);
        assert_eq!(refused(&said), format!("time '{ns} ns': value out of range"));
        assert!(said.contains("the virtual clock ends after 146 years"), "{said}");
    }
    assert_eq!(status(&mut served.client()).time, 0);
    // At the very end of time, a program still joins and polls, and threads have their next cycles.
    assert_eq!(run(end), DONE);
    assert_eq!(status(&mut served.client()).time, end);
    let mut raw = Raw::connect(&served);
    assert_eq!(raw.ask("{\"join\":{\"name\":\"late\",\"poll_ns\":1000000000000}}"), DONE);
    assert_eq!(raw.ask("\"ready\""), DONE);
    script(&mut served.client(), "start");
    assert!(refused(&run(1)).contains("value out of range"));
    assert_eq!(run(0), DONE);
    assert_eq!(thread(&mut served.client(), "thread1").cycles, 0);
    served.end();
}

#[test]
fn a_program_is_waited_for_at_its_start_once() {
    let scratch = Scratch::new("starts");
    let served = served(&scratch);
    let mut child = Command::new("sleep").arg("1000").spawn().unwrap();
    let adopt = format!("{{\"adopt\":{{\"pid\":{},\"program\":\"x\"}}}}", child.id());
    let mut raw = Raw::connect(&served);
    let begun = now_ns();
    assert_eq!(raw.ask(&adopt), DONE);
    // The client's second of patience passes while the clock waits.
    assert_eq!(ten_ms(&served), DONE);
    let waited = now_ns() - begun;
    assert!(waited >= 1_000_000_000, "{waited} ns");
    // The clock does not wait again for a client that is adopted again: otherwise this would take 50 seconds.
    for _ in 0..50 {
        assert_eq!(raw.ask(&adopt), DONE);
        assert_eq!(ten_ms(&served), DONE);
    }
    child.kill().unwrap();
    child.wait().unwrap();
    served.end();
}

/// Returns the time of the system's clock that never jumps, in nanoseconds.
fn now_ns() -> i64 {
    let t = rustix::time::clock_gettime(rustix::time::ClockId::Monotonic);
    t.tv_sec * 1_000_000_000 + t.tv_nsec
}

/// The clock stops at each poll that is due, however late the program comes.
#[test]
fn a_program_polls_once_in_each_of_its_periods() {
    let scratch = Scratch::new("periods");
    let served = served(&scratch);
    let mut raw = Raw::connect(&served);
    assert_eq!(raw.ask("{\"join\":{\"name\":\"panel\",\"poll_ns\":2000000}}"), DONE);
    assert_eq!(raw.ask("\"ready\""), DONE);
    let mut runs = Raw::connect(&served);
    runs.send("{\"request\":{\"run\":{\"ns\":10000000}}}\n");
    for ms in [2, 4, 6, 8, 10] {
        let answer = raw.ask("{\"poll\":{\"writes\":[]}}");
        assert!(answer.contains(&format!("\"time\":{ms}000000")), "{ms} ms: {answer}");
    }
    assert_eq!(runs.answer().trim_end(), DONE);
    assert_eq!(status(&mut served.client()).time, 10_000_000);
    assert_eq!(served.end(), [""; 0]);
}

/// Returns whether this process runs with the short timeout; if not, runs the test again in a process that does.
fn is_impatient(test: &str) -> bool {
    let variable = "HAL_PATIENCE_MS";
    if std::env::var_os(variable).is_some() {
        return true;
    }
    let mut again = Command::new(std::env::current_exe().unwrap());
    again.args(["--exact", &hal_tests::programs::own_test(module_path!(), test)]);
    hal_tests::programs::passes(again.env(variable, "200"));
    false
}

#[test]
fn a_program_that_does_not_poll_is_given_up_until_it_does() {
    if !is_impatient("a_program_that_does_not_poll_is_given_up_until_it_does") {
        return;
    }
    let scratch = Scratch::new("late");
    let served = served(&scratch);
    let mut raw = Raw::connect(&served);
    assert!(raw.ask("{\"hello\":{\"protocol\":1,\"name\":\"\",\"pid\":7}}").contains("ok"));
    assert_eq!(raw.ask("{\"join\":{\"name\":\"panel\",\"poll_ns\":2000000}}"), DONE);
    assert_eq!(raw.ask("\"ready\""), DONE);
    // The clock stops at the due poll, then continues without it.
    assert_eq!(ten_ms(&served), DONE);
    assert_eq!(ten_ms(&served), DONE);
    // The client polls: the next poll is due 2 ms later, and the clock waits for it there.
    raw.send("{\"request\":{\"poll\":{\"writes\":[]}}}\n");
    let mut runs = Raw::connect(&served);
    runs.send("{\"request\":{\"run\":{\"ns\":10000000}}}\n");
    let answer = raw.answer();
    assert!(answer.contains("\"time\":22000000"), "{answer}");
    assert_eq!(runs.answer().trim_end(), DONE);
    assert_eq!(status(&mut served.client()).time, 30_000_000);
    let said = "program 'panel' (process 7) has not polled for 0.2 s: the virtual clock waits for \
                it again when it polls";
    assert_eq!(served.end(), [said; 2]);
}

#[test]
fn a_reader_that_time_waits_for_and_that_does_not_read_is_given_up() {
    if !is_impatient("a_reader_that_time_waits_for_and_that_does_not_read_is_given_up") {
        return;
    }
    let scratch = Scratch::new("unread");
    let served = served(&scratch);
    let mut reader: Client = served.client();
    let names = vec!["feed.0.empty".to_owned()];
    let spec = SampleSpec { names, wait: true, depth: 4, ..SampleSpec::default() };
    let mut samples = reader.sample(spec).unwrap();
    // As long as the client reads, however slowly, nothing is lost.
    let mut runs = Raw::connect(&served);
    runs.send("{\"request\":{\"run\":{\"ns\":20000000}}}\n");
    let mut record = Vec::new();
    for n in 0..16 {
        let stamp = loop {
            if let Some(stamp) = samples.take(&mut record) {
                break stamp;
            }
            std::thread::yield_now();
        };
        assert_eq!((stamp.number, stamp.lost), (n, 0));
        // Longer in total than the timeout.
        reader.call(Request::Idle { ms: 30, flow: false }).unwrap();
    }
    assert_eq!(runs.answer().trim_end(), DONE);
    assert_eq!(ten_ms(&served), DONE);
    let state = reader.sample_state(samples.info().id).unwrap();
    assert_eq!((state.samples, state.lost), (30, 10), "20 in the first run, 10 in the second");
    let said = "sample 1 has not been read for 0.2 s: the virtual clock waits for its reader no \
                longer, and samples without room are lost";
    assert_eq!(served.end(), [said]);
}

/// While a script waits, a stream that its writer leaves empty holds the clock, but only up to the timeout.
#[test]
fn a_writer_that_does_not_write_is_given_up_until_it_does() {
    if !is_impatient("a_writer_that_does_not_write_is_given_up_until_it_does") {
        return;
    }
    let scratch = Scratch::new("unwritten");
    let place = scratch.place("holds");
    let mut options = hal_tests::machine::options(place.clone(), ClockKind::Virtual);
    options.hold = false;
    let mut engine = hal_engine::Engine::new(options).unwrap();
    engine.add_static(&threads::HAL_LIBRARY);
    script(&mut engine, MACHINE);
    let client = std::thread::spawn(move || {
        let mut client = Client::connect(&place, "").unwrap();
        let mut stream = client.attach("feed.0", None).unwrap();
        // The clock moves although nothing is written.
        cycles(&mut client, "thread1", 3);
        // Several, so that the clock finds some of them before they are taken.
        for _ in 0..RECORDS {
            assert!(stream.put(&[hal_protocol::Value::U32(1), hal_protocol::Value::U32(10)]));
        }
        hal_tests::machine::wait(&mut client, "they come", |c| count(c, "feed.0.taken") == RECORDS);
        // The clock has waited again, and again not for ever.
        cycles(&mut client, "thread1", 3);
        client.call(Request::Shutdown).unwrap();
    });
    // Waits like a script that waits for a program.
    while !engine.is_ending() {
        engine.call(Request::Idle { ms: 10, flow: true }).unwrap();
    }
    client.join().unwrap();
    let said = engine.take_messages();
    let want = "stream 'feed.0' has been empty for 0.2 s: the virtual clock waits for its writer \
                again when it has written";
    assert_eq!(said, [want; 2]);
    engine.close();
}
