//! Clients that send garbage, incomplete lines, or far too much, or that never read: each is answered or disconnected,
//! and the others are served meanwhile.

use hal_protocol::{Client, Kind, Link, Reply, Request};
use hal_tests::{
    machine::{Served, bit, count, cycles, says, script, status, wait, without_fifo},
    raw::Raw,
    scratch::Scratch,
};
use std::{
    io::{BufRead, Read, Write},
    net::Shutdown,
    sync::atomic::{AtomicBool, Ordering::SeqCst},
};

/// A running thread with a function.
const MACHINE: &str = "
    loadrt threads
    loadrt boom
    addf boom.0 thread1
    start";

const GET: &str = r#"{"request":{"get":{"name":"boom.0.line"}}}"#;
const LINE_IS_ON: &str = "{\"ok\":{\"value\":{\"bit\":true}}}\n";

fn serves_others(served: &Served) {
    let mut other = served.client();
    assert!(bit(&mut other, "boom.0.line"));
    cycles(&mut other, "thread1", 2);
    assert!(status(&mut other).running);
}

fn served(scratch: &Scratch) -> Served {
    let served = Served::start(scratch, "served", MACHINE);
    wait(&mut served.client(), "it runs", |c| bit(c, "boom.0.line"));
    served
}

#[test]
fn nonsense_is_answered_and_the_client_may_go_on() {
    let scratch = Scratch::new("nonsense");
    let served = served(&scratch);
    let mut raw = Raw::connect(&served);
    let deep = format!("{{\"request\":{}", "[".repeat(100_000));
    for (sent, says) in [
        ("garbage", "expected value at line 1 column 1"),
        ("", "EOF while parsing a value at line 1 column 0"),
        ("\u{0}\u{1}\u{2}", "expected value at line 1 column 1"),
        ("{}", "missing field `request` at line 1 column 2"),
        ("{\"request\":\"sing\"}", "unknown variant `sing`, expected one of "),
        ("{\"request\":{\"get\":{\"name\":7}}}", "invalid type: integer `7`, expected a string"),
        ("{\"request\":\"status\"}}", "trailing characters at line 1 column 21"),
        (&deep, "expected value at line"),
    ] {
        raw.send(format!("{sent}\n"));
        let answer = raw.answer();
        let start = format!("{{\"error\":{{\"code\":-22,\"text\":\"this is not a request: {says}");
        let cut = &answer[..answer.len().min(200)];
        let deep = sent.len() > 1000 && answer.contains("recursion limit exceeded");
        assert!(answer.starts_with(&start) || deep, "{cut}");
        raw.send(format!("{GET}\n"));
        assert_eq!(raw.answer(), LINE_IS_ON);
    }
    // Bytes of every value, in lines of every length.
    let mut x = 1_u32;
    let noise: Vec<u8> = std::iter::repeat_with(|| {
        x = x.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        x.to_le_bytes()[3]
    })
    .take(200_000)
    .collect();
    let lines = noise.iter().filter(|b| **b == b'\n').count();
    raw.send(&noise);
    raw.send("\n");
    for _ in 0..=lines {
        let mut answer = Vec::new();
        raw.answers.read_until(b'\n', &mut answer).unwrap();
        assert!(answer.starts_with(b"{\"error\":"), "{}", String::from_utf8_lossy(&answer));
    }
    raw.send(format!("{GET}\n"));
    assert_eq!(raw.answer(), LINE_IS_ON);
    serves_others(&served);
    assert_eq!(served.end(), [""; 0]);
}

#[test]
fn half_a_line_waits_for_its_other_half_and_for_nobody_else() {
    let scratch = Scratch::new("half");
    let served = served(&scratch);
    let mut raw = Raw::connect(&served);
    let (first, second) = GET.split_at(17);
    raw.send(first);
    serves_others(&served);
    raw.send(second);
    serves_others(&served);
    raw.send("\n");
    assert_eq!(raw.answer(), LINE_IS_ON);
    // An incomplete line at the end is ignored, and the lines before it are answered.
    raw.send(format!("{GET}\n{GET}\n{first}"));
    raw.socket.shutdown(Shutdown::Write).unwrap();
    let mut rest = String::new();
    raw.answers.read_to_string(&mut rest).unwrap();
    assert_eq!(rest, LINE_IS_ON.repeat(2));
    // Disconnected in the middle of a line, or of an answer.
    let mut raw = Raw::connect(&served);
    raw.send(first);
    drop(raw);
    let mut raw = Raw::connect(&served);
    raw.send("{\"request\":{\"idle\":{\"ms\":4000000000,\"flow\":false}}}\n");
    drop(raw);
    serves_others(&served);
    served.end();
}

#[test]
fn a_request_of_100_megabytes_is_refused_and_not_kept() {
    let scratch = Scratch::new("100mb");
    let served = served(&scratch);
    let mut raw = Raw::connect(&served);
    let chunk = vec![b'x'; 1 << 20];
    let mut sent = 0;
    // The engine hangs up long before the end.
    let refused = (0..100).any(|_| {
        serves_others(&served);
        let wrote = raw.socket.write_all(&chunk);
        sent += 1;
        wrote.is_err()
    });
    assert!(refused && sent < 10, "{sent} MB were taken");
    let longest = "{\"error\":{\"code\":-22,\"text\":\"a request is longer than 4194304 bytes\"";
    let answer = raw.answer();
    assert!(answer.starts_with(longest), "{answer}");
    assert_eq!(raw.answer(), "", "and hung up");
    serves_others(&served);
    // The same number of bytes in many requests is no fault.
    let mut raw = Raw::connect(&served);
    let many = format!("{GET}\n").repeat(10_000);
    raw.send(&many);
    for _ in 0..10_000 {
        assert_eq!(raw.answer(), LINE_IS_ON);
    }
    served.end();
}

#[test]
fn another_version_of_the_protocol_is_refused() {
    let scratch = Scratch::new("version");
    let served = served(&scratch);
    let mut raw = Raw::connect(&served);
    // In a single write: the engine may hang up before a second one.
    let hello = "{\"request\":{\"hello\":{\"protocol\":99,\"name\":\"later\",\"pid\":1}}}";
    raw.send(format!("{hello}\n{GET}\n"));
    let refused = "{\"error\":{\"code\":-22,\"text\":\"this engine speaks version 1 of the \
                   protocol, not 99\"";
    let answer = raw.answer();
    assert!(answer.starts_with(refused), "{answer}");
    assert_eq!(raw.answer(), "", "and hung up");
    serves_others(&served);
    served.end();
}

#[test]
fn who_does_not_read_is_not_heard_and_nobody_waits_for_it() {
    let scratch = Scratch::new("unread");
    let served = served(&scratch);
    script(&mut served.client(), "loadrt and2 count=300");
    let list = "{\"request\":{\"list\":{\"kind\":\"pins\",\"patterns\":[],\"ty\":null}}}\n";
    let mut raw = Raw::connect(&served);
    raw.send(list);
    let one = raw.answer();
    assert!(one.len() > 100_000, "the answer fills the socket: {}", one.len());

    // The client sends requests until the engine accepts no more.
    raw.socket.set_nonblocking(true).unwrap();
    let mut asked = 0;
    while raw.socket.write_all(list.as_bytes()).is_ok() {
        asked += 1;
    }
    assert!(asked > 100, "{asked}");
    for _ in 0..5 {
        serves_others(&served);
    }
    // When the client finally reads, nothing was lost (except the request that was cut).
    raw.socket.set_nonblocking(false).unwrap();
    for _ in 0..asked {
        let answer = raw.answer();
        assert!(answer.starts_with("{\"ok\":{\"items\":[") && answer.ends_with("]}}\n"));
    }
    drop(raw);
    serves_others(&served);
    served.end();
}

#[test]
fn one_that_asks_without_end_lets_others_in() {
    static ENOUGH: AtomicBool = AtomicBool::new(false);
    let scratch = Scratch::new("flood");
    let served = served(&scratch);
    let Raw { mut socket, mut answers } = Raw::connect(&served);
    let asks = std::thread::spawn(move || {
        let many = format!("{GET}\n").repeat(1000);
        while !ENOUGH.load(SeqCst) {
            socket.write_all(many.as_bytes()).unwrap();
        }
        socket.shutdown(Shutdown::Write).unwrap();
    });
    let reads = std::thread::spawn(move || answers.by_ref().lines().map_while(Result::ok).count());
    for _ in 0..10 {
        serves_others(&served);
    }
    ENOUGH.store(true, SeqCst);
    asks.join().unwrap();
    assert!(reads.join().unwrap() >= 1000);
    served.end();
}

#[test]
fn too_many_clients_are_turned_away_and_come_in_later() {
    let scratch = Scratch::new("many");
    let served = served(&scratch);
    // Until the engine has noticed that the previous client is gone.
    let let_in = || loop {
        let mut raw = Raw::connect(&served);
        let asked = raw.socket.write_all(format!("{GET}\n").as_bytes());
        if asked.is_ok() && raw.answer() == LINE_IS_ON {
            break raw;
        }
    };
    let inside: Vec<Raw> = std::iter::repeat_with(let_in).take(256).collect();
    let mut outside: Vec<Raw> = (0..50).map(|_| Raw::connect(&served)).collect();
    for raw in &mut outside {
        assert_eq!(raw.answer(), "", "turned away");
    }
    drop(inside);
    let mut again: Client = loop {
        if let Ok(client) = Client::connect(&served.place, "again") {
            break client;
        }
    };
    assert!(bit(&mut again, "boom.0.line"));
    served.end();
}

#[test]
fn a_program_that_vanishes_takes_its_pins_along() {
    let scratch = Scratch::new("vanish");
    let served = served(&scratch);
    let mut other = served.client();
    let pins = || status(&mut served.client()).pins.active;
    let before = pins();
    for round in 0..3 {
        let mut program = served.client();
        script(&mut program, "join panel");
        for i in 0..200 {
            script(
                &mut program,
                &format!("newpin panel.{i} bit {}", if i == 0 { "out" } else { "in" }),
            );
        }
        script(&mut program, "ready");
        // More than may be unlinked at once while threads run.
        for some in (0..200).collect::<Vec<_>>().chunks(100) {
            let names: Vec<String> = some.iter().map(|i| format!("panel.{i}")).collect();
            script(&mut other, &format!("net all {}", names.join(" ")));
        }
        assert_eq!(pins(), before + 200);
        assert_eq!(
            says(&mut other, "unloadrt panel"),
            "component 'panel' is not a realtime module"
        );
        if round == 1 {
            // While the clock waits for the client's poll.
            let mut raw = Raw::connect(&served);
            raw.send("{\"request\":{\"join\":{\"name\":\"second\",\"poll_ns\":1000000000000}}}\n");
            raw.send("{\"request\":{\"new-pin\":{\"name\":\"second.x\",\"ty\":\"bit\",\"direction\":\"in\"}}}\n");
            raw.send("{\"request\":{\"poll\":{\"writes\":[]}}}\n");
            assert_eq!(raw.answer() + &raw.answer(), "{\"ok\":\"done\"}\n".repeat(2));
        }
        drop(program);
        wait(&mut other, "its pins go", |c| status(c).pins.active == before);
        let list = other.call(Request::List { kind: Kind::Signals, patterns: vec![], ty: None });
        let Ok(Reply::Signals(list)) = list else { unreachable!() };
        assert!(list[0].pins.is_empty(), "{list:?}");
    }
    script(&mut other, "delsig all");
    served.end();
}

#[test]
fn a_program_that_vanishes_while_a_thread_is_stuck_goes_when_it_comes_back() {
    let scratch = Scratch::new("stuck");
    let lines = format!("{MACHINE}\nloadrt stuck\naddf stuck.0 thread1");
    let served = Served::start(&scratch, "served", &lines);
    let mut other = served.client();
    let mut program = served.client();
    script(&mut program, "join panel\nnewpin panel.x bit in\nready");
    script(&mut other, "net line panel.x\nsetp stuck.0.hold 1");
    wait(&mut other, "it is stuck", |c| bit(c, "stuck.0.inside"));
    drop(program);
    // The engine waits for a boundary in vain, and continues to serve.
    assert_eq!(count(&mut other, "boom.0.stops"), 0);
    assert!(says(&mut other, "getp panel.x") == "FALSE");
    script(&mut other, "setp stuck.0.hold 0");
    wait(&mut other, "its pin goes", |c| says(c, "getp panel.x").contains("not found"));
    served.end();
}

#[test]
fn what_a_client_says_of_itself_is_not_believed() {
    let scratch = Scratch::new("lies");
    let served = served(&scratch);
    let mut client = served.client();
    let refused = |c: &mut Client, request: Request| c.call(request).unwrap_err().to_string();
    let own = i32::try_from(std::process::id()).unwrap();
    for pid in [i32::MIN, -1, 0, 1, own] {
        let said = refused(&mut client, Request::Adopt { pid, program: "init".into() });
        assert_eq!(said, format!("{pid} is not the number of a program"));
    }
    for (line, want) in [
        ("newpin x.y bit in", "this client has not joined as a component"),
        ("ready", "this client has not joined as a component"),
        ("join boom", "duplicate component name 'boom'"),
        ("join panel", "ok"),
        ("newpin boom.0.line bit in", "duplicate pin 'boom.0.line'"),
        ("newpin x.y bit in", "ok"),
        ("newpin x.y bit in", "duplicate pin 'x.y'"),
    ] {
        assert_eq!(says(&mut client, line), want, "{line}");
    }
    for (writes, why) in [
        (vec![(9, hal_protocol::Value::Bit(true))], "this client has no such pin"),
        (vec![(0, hal_protocol::Value::Float(1.0))], "the value's type does not match its pin"),
        (vec![(0, hal_protocol::Value::Bit(true))], "a program does not write its own input"),
    ] {
        assert_eq!(refused(&mut client, Request::Poll { writes }), why);
    }
    let said = refused(&mut client, Request::Poll { writes: vec![] });
    assert_eq!(said, "this program has joined without a period for its polls (poll_ns is 0)");
    assert_eq!(
        refused(&mut client, Request::Run { ns: u64::MAX }),
        "'run' moves the virtual clock; this one is real"
    );
    serves_others(&served);
    served.end();
}

#[test]
fn all_of_this_without_fifo() {
    without_fifo(module_path!(), "all_of_this_without_fifo");
}
