//! Messages of a library are delivered while the library is open. Alone in its process: no other test may keep the
//! library open.

use hal_engine::ClockKind;
use hal_tests::machine::{Machine, says};

#[test]
fn what_a_library_says_is_heard_before_it_is_closed() {
    let mut m = Machine::new(ClockKind::Virtual);
    let refused = says(&mut m, "loadrt chatty fail=enough");
    assert!(refused.starts_with("chatty: enough; fail=: "), "{refused}");
    let said = m.engine.take_messages();
    assert_eq!(said, ["chatty: being created"]);
    m.script("loadrt threads\nloadrt chatty\naddf chatty thread1\nsetp chatty.times 2\nstart");
    m.script("run 1000000\ndelf chatty\nunloadrt chatty");
    let said = m.engine.take_messages();
    assert_eq!(
        said,
        [
            "chatty: being created",
            "chatty: being opened, 1 of 2.5",
            "chatty: said 1 times",
            "chatty: being stopped",
            "chatty: said 2 times (once more)",
        ]
    );
    floods(&mut m);
}

/// Returns a number in a line, before or after a text.
fn number(line: &str, before: &str, behind: &str) -> Option<u64> {
    let (_, rest) = line.split_once(before)?;
    rest.split_once(behind)?.0.parse().ok()
}

/// Returns the number of messages that the lines of `chatty` represent, and the number that they report as lost.
fn counts(lines: &[String]) -> (u64, u64) {
    let (mut told, mut lost) = (0, 0);
    for line in lines {
        if let Some(n) = number(line, "chatty: ", " messages were lost") {
            lost += n;
        } else if line.starts_with("chatty: said ") {
            told += number(line, "(the last of ", " more").unwrap_or(1);
        }
    }
    (told, lost)
}

/// Returns the lines of a component that sends this many messages in each of 3500 cycles, run in this many pieces.
fn flood(m: &mut Machine, times: u32, pieces: u32) -> Vec<String> {
    m.script("unloadrt all");
    drop(m.engine.take_messages());
    m.script(&format!(
        "loadrt threads
         loadrt chatty
         addf chatty thread1
         start
         run 1000000
         setp chatty.times {times}"
    ));
    drop(m.engine.take_messages());
    (0..pieces).for_each(|_| m.script(&format!("run {}", 3_500_000_000_u64 / u64::from(pieces))));
    m.script("setp chatty.times 0");
    m.script("unloadrt chatty");
    m.engine.take_messages()
}

fn floods(m: &mut Machine) {
    // Once in each cycle: the first message, and then one line per second with an exact count.
    let lines = flood(m, 1, 1);
    assert_eq!(
        lines,
        [
            "chatty: said 1 times",
            "chatty: said 1000 times (the last of 999 more)",
            "chatty: said 2000 times (the last of 1000 more)",
            "chatty: said 3000 times (the last of 1000 more)",
            "chatty: being stopped",
            "chatty: said 3500 times (the last of 500 more)",
        ]
    );
    // The same bytes again, however often the control side polls.
    assert_eq!(flood(m, 1, 1), lines);
    assert_eq!(flood(m, 1, 3500), lines);
    // More than the ring holds between two polls: nothing is lost while time can wait.
    let lines = flood(m, 700, 1);
    assert_eq!(counts(&lines), (700 * 3500, 0));
    assert!(lines.len() < 12, "{lines:?}");
    // More than the ring holds in one cycle: messages that did not fit are counted, and reported at most once per
    // second.
    let lines = flood(m, 5000, 7);
    let (told, lost) = counts(&lines);
    assert_eq!(told + lost, 5000 * 3500);
    assert!(lost > 0 && lines.len() < 16, "{lines:?}");
    assert_eq!(flood(m, 5000, 1), lines);
}
