//! The dialogue without a device.

use robot::{Console, ConsoleOptions, ConsoleRequest, LogKind};

fn options(is_queued: bool) -> ConsoleOptions {
    ConsoleOptions { line_end: "\r\n", answers: Vec::new(), begin: None, timeout: 10.0, is_queued }
}

fn log(console: &mut Console) -> String {
    let mark = |kind| match kind {
        LogKind::Sent => '>',
        LogKind::Received => '<',
        LogKind::Error => '!',
        LogKind::Note => '#',
    };
    console.log().iter().map(|entry| format!("{} {}|", mark(entry.kind), entry.text)).collect()
}

#[test]
fn a_person_sends_at_once_and_lines_of_a_file_wait() {
    let mut console = Console::new(options(false), 0.0);
    assert_eq!(console.enter("one", 0.0), None);
    assert_eq!(console.enter("two", 0.0), None);
    assert_eq!(console.output(), b"one\r\ntwo\r\n");
    assert_eq!(console.next(), None, "a person waits for nothing");
    let request = console.enter(":send a b.txt", 1.0);
    assert_eq!(request, Some(ConsoleRequest::Read("a b.txt".to_owned())));
    console.receive(b"ok\n", 1.0);
    assert_eq!(log(&mut console), "> one|> two|< ok|");
    console.send_file("a b.txt", "1\r\n \n2\n", 1.0);
    assert_eq!(console.output(), b"1\r\n");
    console.enter("three", 1.0);
    assert_eq!(console.next(), Some(11.0));
    console.receive(b"1\r\nmot", 2.0);
    assert_eq!((console.output(), console.next()), (Vec::new(), Some(2.05)), "sent back");
    console.poll(2.05);
    assert_eq!(console.output(), b"2\r\n", "a prompt without an end");
    assert_eq!(console.enter(":stop", 3.0), None);
    assert_eq!(
        log(&mut console),
        "> 1|! a b.txt|".replace("a b.txt", "a file is being sent: :stop ends it")
            + "< 1|< mot|> 2|! a b.txt: stopped behind line 2|"
    );
    assert_eq!(console.enter(":quit", 3.0), Some(ConsoleRequest::Quit));
}

#[test]
fn lines_that_nobody_watches_wait_and_end_by_name() {
    let mut console = Console::new(options(true), 0.0);
    for line in ["a", "b", "c"] {
        console.enter(line, 0.0);
    }
    assert_eq!(console.output(), b"a\r\n");
    console.receive(b"done\r\n", 1.0);
    assert_eq!(console.turn(1.0), None);
    assert_eq!(console.output(), b"b\r\n");
    assert!(!console.is_idle() && !console.has_failed());
    console.poll(11.0);
    assert!(console.is_idle() && console.has_failed());
    assert_eq!(log(&mut console), "> a|< done|> b|! no answer to b within 10 s|");
    // A controller that leaves.
    let mut console = Console::new(options(true), 0.0);
    console.send_file("f", "a\nb\n", 0.0);
    console.receive(b"half", 0.1);
    console.closed("it has gone");
    assert_eq!(log(&mut console), "> a|< half|! f: line 1: it has gone|");
}

#[test]
fn a_begin_is_awaited_and_its_absence_named() {
    let begin = Some("ready".to_owned());
    let mut console = Console::new(ConsoleOptions { begin, ..options(true) }, 0.0);
    console.enter("a", 0.0);
    console.receive(b"booting\n", 1.0);
    assert!(console.output().is_empty());
    assert_eq!(console.next(), Some(10.0));
    let mut late =
        Console::new(ConsoleOptions { begin: Some("ready".to_owned()), ..options(false) }, 0.0);
    late.poll(10.0);
    assert_eq!(log(&mut late), "! no answer to ready within 10 s|");
    // What is typed later is refused by name, and waits for nothing.
    assert!(late.is_mute() && !console.is_mute());
    assert_eq!(late.enter("b", 11.0), None);
    assert!(late.is_idle() && late.output().is_empty());
    assert_eq!(log(&mut late), "! b: not sent, the controller has not begun|");
    assert_eq!(late.enter(":quit", 11.0), Some(ConsoleRequest::Quit));
    late.receive(b"ready\n", 12.0);
    assert_eq!(late.enter("b", 12.0), None);
    assert!(!late.is_mute() && late.output() == b"b\r\n");
    console.receive(b"now ready\n", 2.0);
    assert_eq!(console.turn(2.0), None);
    assert_eq!(console.output(), b"a\r\n");
}

#[test]
fn garbage_of_any_length_is_survived() {
    let mut console = Console::new(options(true), 0.0);
    console.enter(&"x".repeat(5000), 0.0);
    console.send_file("f", &"y".repeat(5000), 0.0);
    console.receive(&vec![0xff; 100_000], 0.0);
    console.receive(b"\r\n\0\x1b\r\n", 0.0);
    let log = log(&mut console);
    assert!(
        log.starts_with(
            "! the line has 5000 bytes, at most 4096 are sent|! f: line 1 is too long|"
        )
    );
    assert!(log.ends_with("in a line|< \u{fffd}\u{fffd}|"), "{log}");
    assert!(console.output().is_empty() && console.is_idle());
}
