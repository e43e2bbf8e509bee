//! The prompt and the views, in a real terminal. The test types each key after the output that it responds to.
#![expect(clippy::unwrap_used, reason = "tests")]

use hal_tests::{scratch::Scratch, terminal::Terminal};
use rustix::process::{Pid, Signal, kill_process};

const PROMPT: &str = "halcmd: ";

/// Starts a program and waits for its prompt.
fn prompt(scratch: &Scratch, program: &str, words: &[&str]) -> Terminal {
    let mut terminal = Terminal::start(scratch, program, words);
    terminal.until(PROMPT);
    terminal
}

/// Prints a word, as a mark that all earlier input was executed.
fn mark(terminal: &mut Terminal, word: &str) {
    terminal.keys(&format!("print {word}\r"));
    terminal.until(&format!("HALCMD MSG: {word}"));
    terminal.until(PROMPT);
}

/// Starts an instance in the background, with a thread and two components.
fn machine(scratch: &Scratch) {
    let text = "loadrt threads name1=t period1=1000000\nloadrt not\nloadrt siggen\n\
                net wave siggen.0.sine\naddf siggen.0.update t\nstart\n";
    scratch.write("m.hal", text);
    let run = scratch.halrun(&["--detach", "m.hal"]);
    assert_eq!(run.status, Some(0), "{run:?}");
}

fn signal(terminal: &Terminal, signal: Signal) {
    let pid = Pid::from_raw(i32::try_from(terminal.pid()).unwrap()).unwrap();
    kill_process(pid, signal).unwrap();
}

#[test]
fn lines_are_completed_found_again_and_given_up() {
    let scratch = Scratch::new("prompt");
    let mut t = prompt(&scratch, "halrun", &["--virtual"]);
    t.keys("loadrt threads\t");
    t.until("threads ");
    t.keys("name1=t period1=1000000\r");
    t.until(PROMPT);
    mark(&mut t, "loaded");
    t.keys("lis\t");
    t.until("list ");
    t.keys("th\t");
    t.until("thread ");
    t.keys("\r");
    t.until("\r\nt \r\n");
    t.until(PROMPT);
    // Cancelled: the line is not executed, and the next line is a new one.
    t.keys("nonsense");
    t.until("nonsense");
    t.keys("\x03");
    t.until(PROMPT);
    mark(&mut t, "next");
    t.keys("\x1b[A");
    t.until("print next");
    t.keys("\r");
    t.until("HALCMD MSG: next");
    t.until(PROMPT);
    t.keys("\x12period1");
    t.until("loadrt threads");
    t.keys("\x03");
    t.until(PROMPT);
    t.keys("print \\\r");
    t.until("halcmd+: ");
    t.keys("joined\r");
    t.until("HALCMD MSG: joined");
    t.until(PROMPT);
    t.keys("\x04");
    let (status, sane, shown) = t.end();
    assert_eq!((status, sane), (Some(0), true), "{shown:?}");
    let kept = scratch.read(".local/state/ferrule/history");
    for line in ["loadrt threads name1=t period1=1000000", "list thread", "print next"] {
        assert!(kept.contains(line), "{kept}");
    }
    assert!(!kept.contains("nonsense"), "{kept}");
}

#[test]
fn the_engine_is_served_while_somebody_types() {
    let scratch = Scratch::new("served");
    let mut t = prompt(&scratch, "halrun", &["--virtual"]);
    t.keys("print hal");
    t.until("print hal");
    let other = scratch.halcmd(&["newsig", "made-elsewhere", "bit"]);
    assert_eq!(other.status, Some(0), "{other:?}");
    t.keys("f\r");
    t.until("HALCMD MSG: half");
    t.until(PROMPT);
    t.keys("gets made\t");
    t.until("made-elsewhere ");
    t.keys("\r");
    t.until("FALSE");
    t.until(PROMPT);
    t.keys("half a li");
    t.until("half a li");
    assert_eq!(scratch.halcmd(&["shutdown"]).status, Some(0));
    let (status, sane, shown) = t.end();
    assert_eq!((status, sane), (Some(0), true), "{shown:?}");
}

#[test]
fn the_terminal_is_put_right_whatever_ends_the_program() {
    let scratch = Scratch::new("ends");
    machine(&scratch);
    for ending in [Signal::TERM, Signal::INT, Signal::HUP] {
        let mut t = prompt(&scratch, "halcmd", &["-kf"]);
        t.keys("print x");
        t.until("print x");
        signal(&t, ending);
        let (status, sane, shown) = t.end();
        assert_eq!((status, sane), (Some(1), true), "{ending:?} {shown:?}");
        let t = {
            let mut t = Terminal::start(&scratch, "halcmd", &["watch", "wave"]);
            t.until("machine");
            signal(&t, ending);
            t
        };
        let (status, sane, shown) = t.end();
        assert_eq!((status, sane), (Some(1), true), "{ending:?} {shown:?}");
    }
    let mut t = prompt(&scratch, "halcmd", &["-kf"]);
    t.keys("\x03");
    let (status, sane, shown) = t.end();
    assert_eq!((status, sane), (Some(1), true), "{shown:?}");
    let mut t = Terminal::start(&scratch, "halcmd", &["meter", "wave"]);
    t.until("machine");
    assert_eq!(scratch.halcmd(&["shutdown"]).status, Some(0));
    let (status, sane, shown) = t.end();
    assert_eq!((status, sane), (Some(1), true), "{shown:?}");
    assert!(shown.contains("the engine has closed the connection"), "{shown:?}");
}

#[test]
fn values_are_shown_on_a_screen() {
    let scratch = Scratch::new("screen");
    machine(&scratch);
    let mut t = Terminal::start(&scratch, "halcmd", &["watch", "-n", "10ms", "wave", "not.0.in"]);
    t.until("machine");
    t.until("not.0.in");
    t.until("wave");
    t.keys("q");
    let (status, sane, shown) = t.end();
    assert_eq!((status, sane), (Some(0), true), "{shown:?}");
    // The last view remains on the screen as lines.
    assert!(shown.contains(" not.0.in FALSE\r\n") && shown.contains(" wave "), "{shown:?}");
    let mut t = Terminal::start(&scratch, "halcmd", &["meter"]);
    t.until("search:");
    t.keys("not.0.in\r");
    t.until("machine");
    t.until("IN");
    t.keys("q");
    let (status, sane, shown) = t.end();
    assert_eq!((status, sane), (Some(0), true), "{shown:?}");
    assert_eq!(scratch.halcmd(&["shutdown"]).status, Some(0));
}

#[test]
fn colours_are_for_terminals_and_for_those_who_want_them() {
    let scratch = Scratch::new("colours");
    let words = ["-u", "NO_COLOR", "halcmd", "--instance", "nobody", "start"];
    let mut t = Terminal::start(&scratch, "env", &words);
    t.until("\x1b[31m<commandline>:0: no instance 'nobody' is running\x1b[0m");
    assert_eq!(t.end().0, Some(1));
    let t = Terminal::start(&scratch, "halcmd", &["--instance", "nobody", "start"]);
    let (_, _, shown) = t.end();
    assert!(shown.contains("nobody") && !shown.contains('\x1b'), "{shown:?}");
    let plain = scratch.halcmd(&["--instance", "nobody", "start"]);
    assert!(!plain.stderr.contains('\x1b'), "{plain:?}");
}
