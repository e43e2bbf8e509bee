//! The terminal: over TCP, over a serial line, and with a person.
#![expect(clippy::unwrap_used, clippy::indexing_slicing, reason = "tests")]

use rustix::{
    fs::{Mode, OFlags},
    pty::{OpenptFlags, grantpt, openpt, ptsname, unlockpt},
    termios::{ControlModes, tcgetattr},
};
use std::{
    fs::File,
    io::{BufRead as _, BufReader, Read as _, Write as _},
    net::{TcpListener, TcpStream},
    os::fd::OwnedFd,
    path::PathBuf,
    process::{Child, Command, Output, Stdio},
    thread::{self, JoinHandle},
};

fn halrobot(words: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_halrobot"));
    command.arg("terminal").args(words).env_remove("HOME").env_remove("XDG_STATE_HOME");
    command
}

/// Runs the terminal with these lines on standard input.
fn talk(words: &[&str], lines: impl AsRef<[u8]>) -> Output {
    let mut child = halrobot(words)
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    // A terminal that has ended reads no more.
    drop(child.stdin.take().unwrap().write_all(lines.as_ref()));
    child.wait_with_output().unwrap()
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}

/// A controller that greets, and answers each line; it returns what it was sent.
fn serve(
    greeting: &'static str,
    answer: impl Fn(usize, &str) -> String + Send + 'static,
) -> (String, JoinHandle<Vec<String>>) {
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let address = listener.local_addr().unwrap().to_string();
    let served = thread::spawn(move || {
        let mut client = listener.accept().unwrap().0;
        client.write_all(greeting.as_bytes()).unwrap();
        answer_all(&client, answer)
    });
    (address, served)
}

fn answer_all(mut client: &TcpStream, answer: impl Fn(usize, &str) -> String) -> Vec<String> {
    let mut got = Vec::new();
    for line in BufReader::new(client).split(b'\n').map_while(Result::ok) {
        let line = text(&line).trim_end_matches('\r').to_owned();
        let answer = answer(got.len(), &line);
        got.push(line);
        if client.write_all(answer.as_bytes()).is_err() {
            break;
        }
    }
    got
}

/// A file that goes again.
struct Scratch(PathBuf);

impl Scratch {
    fn new(name: &str, text: &str) -> Self {
        let path = std::env::temp_dir().join(format!("halrobot-{name}-{}", std::process::id()));
        std::fs::write(&path, text).unwrap();
        Self(path)
    }

    fn name(&self) -> String {
        self.0.display().to_string()
    }
}

impl Drop for Scratch {
    fn drop(&mut self) {
        drop(std::fs::remove_file(&self.0));
    }
}

#[test]
fn a_file_is_sent_line_by_line() {
    let (address, served) = serve("-400 0 -30\r\nEsperando inicio\r\n", |_, line| {
        if line == "EXIT" { String::new() } else { "done\r\n".to_owned() }
    });
    let file = Scratch::new("traj.txt", "JMOVE,0,0,10\n\nLMOVE,0,0,-1\nLMOVE,5,0,-1\n");
    let lines = format!("inicio\n:send {}\n::colon\n:quit\nnever\n", file.name());
    let words = ["--to", &address, "--begin", "Esperando inicio", "--timeout", "30"];
    let output = talk(&words, &lines);
    let name = file.name();
    let log = text(&output.stdout);
    let wanted = format!(
        "< -400 0 -30\n< Esperando inicio\n> inicio\n< done\n> JMOVE,0,0,10\n< done\n\
         > LMOVE,0,0,-1\n< done\n> LMOVE,5,0,-1\n< done\n# {name}: 3 lines sent\n\
         > :colon\n< done\n"
    );
    assert!(output.status.success(), "{log}{}", text(&output.stderr));
    assert_eq!(log, wanted);
    let sent = ["inicio", "JMOVE,0,0,10", "LMOVE,0,0,-1", "LMOVE,5,0,-1", ":colon"];
    assert_eq!(served.join().unwrap(), sent);
}

#[test]
fn lines_that_are_no_text_end_the_input_by_name() {
    let long = [b"A\n".as_slice(), &[b'x'; 100_000], b"\nB\n"].concat();
    for (lines, why) in [
        (b"A\nLMOVE,\xe9,1,2\nB\n".to_vec(), "line 2: the line is not UTF-8"),
        (b"A\n\xff\xfei\0".to_vec(), "line 2: the line is not UTF-8"),
        (long, "line 2: the line has more than 8192 bytes"),
    ] {
        let (address, served) = serve("", |_, _| "done\r\n".to_owned());
        let output = talk(&["--to", &address, "--timeout", "30"], lines);
        let log = text(&output.stdout);
        assert!(log.contains(&format!("! standard input, {why}\n")), "{log}");
        assert!(!output.status.success(), "{log}");
        assert_eq!(served.join().unwrap(), ["A"], "{why}");
    }
}

#[test]
fn what_a_controller_refuses_or_does_not_answer_is_named() {
    let file = Scratch::new("refused.txt", "A\nB\nC\n");
    let name = file.name();
    for (answers, timeout, wanted, sent) in [
        (
            ["done\r\n", "error range\r\n", ""],
            "300",
            "! NAME: line 2: the controller has refused it: error range\n",
            2,
        ),
        ([""; 3], "0.3", "! NAME: line 1: no answer to A within 0.3 s\n", 1),
        (["ok\r\n", "busy\r\nok\r\n", "ok\r\n"], "300", "# NAME: 3 lines sent\n", 3),
    ] {
        let (address, served) = serve("", move |n, _| answers[n].to_owned());
        let words = ["--to", &address, "--timeout", timeout, "--answer", "done", "--answer", "ok"];
        let output = talk(&words, format!(":send {name}\n"));
        let log = text(&output.stdout);
        assert!(log.ends_with(&wanted.replace("NAME", &name)), "{log}");
        assert_eq!(output.status.success(), sent == 3, "{log}");
        assert_eq!(served.join().unwrap().len(), sent, "{log}");
    }
}

#[test]
fn bad_lines_and_options_are_refused() {
    let (address, served) = serve("", |_, _| "\u{1b}[2Jdone\u{7}\r\n".to_owned());
    let output = talk(&["--to", &address], ":send\n:send nowhere.txt\n:jump\nhello\n");
    let log = text(&output.stdout);
    for wanted in [
        "! :send needs the name of a file\n",
        "! nowhere.txt: No such file or directory\n",
        "! :jump has no meaning: :help\n",
        // What a controller sends moves no cursor.
        "> hello\n< \u{fffd}[2Jdone\u{fffd}\n",
    ] {
        assert!(log.contains(wanted), "{log}");
    }
    assert!(!output.status.success());
    assert_eq!(served.join().unwrap(), ["hello"]);
    for (words, wanted) in [
        (&["--to", "127.0.0.1:1"][..], "127.0.0.1:1: Connection refused"),
        (&["--serial", "/dev/null"], "/dev/null: this is no serial line"),
        (&["--serial", "/nowhere"], "/nowhere: No such file or directory"),
        (&["--to", "127.0.0.1:1", "--timeout", "nan"], "--timeout NaN: must be a number above 0"),
        (&[], "--to"),
        (&["--to", "x", "--serial", "y"], "cannot be used with"),
    ] {
        let output = talk(words, "");
        assert!(!output.status.success(), "{words:?}");
        assert!(text(&output.stderr).contains(wanted), "{words:?}: {}", text(&output.stderr));
    }
}

/// Returns both ends of a new terminal device, and the name of the far one.
fn terminal() -> (File, OwnedFd, String) {
    let near = openpt(OpenptFlags::RDWR | OpenptFlags::NOCTTY).unwrap();
    grantpt(&near).unwrap();
    unlockpt(&near).unwrap();
    let name = ptsname(&near, Vec::new()).unwrap().into_string().unwrap();
    let flags = OFlags::RDWR | OFlags::NOCTTY;
    let far = rustix::fs::open(name.as_str(), flags, Mode::empty()).unwrap();
    (File::from(near), far, name)
}

#[test]
fn a_serial_line_with_prompts() {
    let (mut near, far, name) = terminal();
    let file = Scratch::new("points.txt", "1 2 3\n4 5 6\n");
    let mut child = halrobot(&["--serial", &name, "--baud", "19200", "--eol", "cr"])
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .spawn()
        .unwrap();
    let lines = format!("where\n:send {}\n", file.name());
    // A terminal that has ended reads no more.
    drop(child.stdin.take().unwrap().write_all(lines.as_ref()));
    for wanted in ["where\r", "1 2 3\r", "4 5 6\r"] {
        let mut got = vec![0; wanted.len()];
        near.read_exact(&mut got).unwrap();
        assert_eq!(text(&got), wanted);
        // The controller sends the line back, and then its prompt without an end.
        near.write_all(format!("{}\r\n> ", wanted.trim()).as_bytes()).unwrap();
    }
    let settings = tcgetattr(&far).unwrap();
    let modes = settings.control_modes;
    assert_eq!(settings.output_speed(), 19200);
    assert_eq!(modes & ControlModes::CSIZE, ControlModes::CS8);
    assert!(!modes.intersects(ControlModes::PARENB | ControlModes::CSTOPB | ControlModes::CRTSCTS));
    let output = child.wait_with_output().unwrap();
    let log = text(&output.stdout);
    assert!(output.status.success(), "{log}");
    let wanted = "> where\n< where\n< > \n> 1 2 3\n< 1 2 3\n< > \n> 4 5 6\n< 4 5 6\n< > \n";
    assert!(log.starts_with(wanted) && log.ends_with(": 2 lines sent\n"), "{log}");
}

/// Reads until a text has come.
fn until(near: &mut File, seen: &mut String, wanted: &str) {
    let mut buffer = [0; 1024];
    while !seen.contains(wanted) {
        let count = near.read(&mut buffer).unwrap();
        assert!(count > 0, "{wanted:?} does not come: {seen:?}");
        seen.push_str(&text(&buffer[..count]));
    }
}

fn person(words: &[&str], (name, value): (&str, &str), far: &OwnedFd) -> Child {
    let mut command = halrobot(words);
    command.env("TERM", "xterm").env_remove("NO_COLOR").env(name, value);
    command.stdin(far.try_clone().unwrap()).stdout(far.try_clone().unwrap());
    command.spawn().unwrap()
}

#[test]
fn a_person_sees_colours_and_has_a_history_that_is_kept() {
    let state = std::env::temp_dir().join(format!("halrobot-state-{}", std::process::id()));
    let (state, history) = (state.display().to_string(), state.join("ferrule/robot-history"));
    let history = history.display().to_string();
    for round in 0..2 {
        let (address, served) = serve("", |_, line| {
            if line == "bad" { "error unknown\r\n" } else { "done\r\n" }.to_owned()
        });
        let (mut near, far, _) = terminal();
        // The file of the user's state folder, and then the same one by its name.
        let mut child = if round == 0 {
            person(&["--to", &address], ("XDG_STATE_HOME", &state), &far)
        } else {
            person(&["--to", &address, "--history", &history], ("NO_COLOR", "1"), &far)
        };
        let mut seen = String::new();
        until(&mut near, &mut seen, "robot: ");
        if round == 0 {
            near.write_all(b"hello\r").unwrap();
            until(&mut near, &mut seen, "\x1b[31m< done\x1b[0m");
            near.write_all(b"bad\r").unwrap();
            until(&mut near, &mut seen, "\x1b[31m< error unknown\x1b[0m");
            near.write_all(b":jump\r").unwrap();
            until(&mut near, &mut seen, "\x1b[1;35m! :jump has no meaning: :help\x1b[0m");
        } else {
            // Four lines up, in a terminal of its own.
            near.write_all(b"\x1b[A\x1b[A\x1b[A\x1b[A\r").unwrap();
            until(&mut near, &mut seen, "< done");
            assert!(!seen.contains("\x1b[31m"), "{seen:?}");
        }
        near.write_all(b":quit\r").unwrap();
        // The line is read to its end, or the program would wait for room.
        let reader = thread::spawn(move || {
            let mut buffer = [0; 1024];
            while near.read(&mut buffer).is_ok_and(|count| count > 0) {}
        });
        assert!(child.wait().unwrap().success());
        drop(far);
        reader.join().unwrap();
        let wanted: &[&str] = if round == 0 { &["hello", "bad"] } else { &["hello"] };
        assert_eq!(served.join().unwrap(), wanted);
    }
    std::fs::remove_dir_all(state).unwrap();
}
