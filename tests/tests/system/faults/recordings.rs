//! Recordings that cannot be written are reported at once, with a status other than 0. An existing
//! file stays as it was, and the new one ends at a whole record.
#![expect(clippy::unwrap_used, clippy::panic, reason = "tests")]

use hal_tests::{
    plugins::plugins,
    scratch::{Output, Running, Scratch, until},
};
use hal_trace::{Format, Trace};
use rustix::process::Signal;
use std::{
    fs::File,
    io::Read,
    os::unix::fs::symlink,
    path::Path,
    process::{Command, Stdio},
};

const MACHINE: &str = "loadrt threads name1=t period1=1000000
loadrt siggen
net x siggen.0.sawtooth
addf siggen.0.update t
start
";

/// An earlier, intact recording.
const OLD: &str =
    "$timescale 1 ns $end\n$var wire 1 ! old $end\n$enddefinitions $end\n#0\n0!\n#5\n1!\n";

/// Returns a command for halrun that limits files to `blocks` blocks of 512 bytes.
fn limited(scratch: &Scratch, blocks: &str, words: &[&str]) -> Command {
    let limit = format!("ulimit -f {blocks}; exec \"$0\" \"$@\"");
    let mut command = scratch.command(&["sh", "-c", &limit], "halrun");
    command.args(words);
    command
}

/// Returns the same recording, complete.
fn unlimited(scratch: &Scratch, run: &str) -> String {
    let words = ["--virtual", "--for", run, "--record", "all.vcd", "m.hal"];
    assert_eq!(scratch.halrun(&words).status, Some(0));
    scratch.read("all.vcd")
}

/// Returns the single line about the recording, with file names relative to this folder.
fn line(scratch: &Scratch, stderr: &str) -> String {
    let mut lines = stderr.lines().filter(|l| l.contains("out.vcd"));
    let first = lines.next();
    assert!(first.is_some() && lines.next().is_none(), "{stderr}");
    plain(scratch, first.unwrap())
}

fn plain(scratch: &Scratch, text: &str) -> String {
    text.replace(&format!("{}/", scratch.path().display()), "")
}

fn whole(bytes: &[u8]) -> Trace {
    Format::of(Path::new("a.vcd")).unwrap().read(bytes).whole().unwrap()
}

/// Returns the end of the message for a file with this content, without the time of the refusal.
fn kept(text: &str) -> String {
    let last = whole(text.as_bytes()).times().iter().last().unwrap();
    let seconds = format!("{:.9}", last as f64 / 1e9);
    let seconds = seconds.trim_end_matches('0').trim_end_matches('.');
    format!("{} bytes are kept, up to {seconds} s", text.len())
}

/// Splits a message into the part about the kept data and the rest with the time of the refusal.
fn parts(line: &str) -> (&str, &str) {
    let (rest, kept) = line.split_once("; ").unwrap();
    (kept, rest)
}

fn start(scratch: &Scratch, blocks: &str, words: &[&str]) -> Running {
    scratch.start(&mut limited(scratch, blocks, words))
}

#[test]
fn a_disk_that_is_full_at_the_start_leaves_the_old_file() {
    let scratch = Scratch::new("full");
    scratch.write("m.hal", MACHINE);
    scratch.write("out.vcd", OLD);
    let words = ["--virtual", "--for", "100ms", "--record", "out.vcd", "m.hal"];
    // Output goes to a pipe, because a file would be limited as well.
    let output = limited(&scratch, "0", &words).output().unwrap();
    assert_eq!(scratch.read("out.vcd"), OLD);
    assert_eq!(
        line(&scratch, &String::from_utf8(output.stderr).unwrap()),
        "out.vcd: File too large: the recording stopped at 0 s; nothing of it is kept"
    );
    assert_eq!(output.status.code(), Some(1));
    let files: Vec<String> =
        scratch.files().into_keys().filter(|n| !n.starts_with(".run")).collect();
    assert_eq!(files, ["m.hal", "out.vcd"], "nothing is left beside them");
}

#[test]
fn a_disk_that_fills_leaves_what_was_recorded() {
    let scratch = Scratch::new("fills");
    scratch.write("m.hal", MACHINE);
    let all = unlimited(&scratch, "20s");
    scratch.write("out.vcd", OLD);
    let words = ["--virtual", "--for", "20s", "--record", "out.vcd", "m.hal"];
    let output = scratch.run(&mut limited(&scratch, "300", &words));
    let out = scratch.read("out.vcd");
    // The file is a prefix of the complete recording.
    assert!(
        all.len() > 300 * 512 && out.len() > 300 * 512 - 10_000 && out.len() <= 300 * 512,
        "{}",
        out.len()
    );
    assert!(
        all.starts_with(&out) && all[out.len()..].starts_with('#'),
        "it ends at a whole record"
    );
    let said = line(&scratch, &output.stderr);
    let (about, rest) = parts(&said);
    assert_eq!(about, kept(&out));
    assert!(rest.starts_with("out.vcd: File too large: the recording stopped at "), "{rest}");
    assert_eq!(output.status, Some(1));
}

/// Starts an instance whose recording has met a full disk.
fn stopped(scratch: &Scratch, before: &[&str]) -> Running {
    scratch.write("m.hal", format!("{MACHINE}run 10ms\nprint ready\n"));
    let words = [before, &["--virtual", "--hold", "--record", "out.vcd", "m.hal"]].concat();
    let running = start(scratch, "300", &words);
    until("it is up", || running.said().1.contains("ready"));
    assert_eq!(scratch.halcmd(&["run", "20s"]).status, Some(0), "the machine goes on");
    running
}

#[test]
fn it_is_reported_once_and_at_once_and_status_has_it() {
    let scratch = Scratch::new("status");
    let running = stopped(&scratch, &[]);
    // The message comes at once, before anything ends.
    let said = line(&scratch, &running.said().1);
    let (about, rest) = parts(&said);
    let out = scratch.read("out.vcd");
    assert_eq!(about, kept(&out));
    let at = rest.split(" at ").nth(1).unwrap();
    let status = scratch.halcmd(&["status", "instance"]).stdout;
    let shown = status.lines().find(|l| l.contains("recording:")).unwrap();
    assert_eq!(plain(&scratch, shown.trim_start()), format!("recording:  {said}"));
    let json: serde_json::Value =
        serde_json::from_str(&scratch.halcmd(&["--json", "status"]).stdout).unwrap();
    let found = &find(&json, "recording_stopped").unwrap();
    assert_eq!(found["file"], scratch.path().join("out.vcd").display().to_string());
    assert_eq!(found["reason"], "File too large");
    assert_eq!(found["bytes"], out.len());
    let time = found["time"].as_f64().unwrap() / 1e9;
    assert_eq!(format!("{time} s"), at);
    assert_eq!(found["kept_to"], whole(out.as_bytes()).times().iter().last().unwrap());
    assert!(find(&json, "recording").unwrap().is_null(), "nothing is being recorded");
    // Time advances without a second message.
    scratch.halcmd(&["run", "20s"]);
    assert_eq!(line(&scratch, &running.said().1), said);
    // The client that ends the recording gets the error too. Another recording may begin, and the
    // status stays.
    let off = scratch.halcmd(&["record", "off"]);
    assert_eq!(off.status, Some(1));
    assert!(plain(&scratch, &off.stderr).contains(&said), "{}", off.stderr);
    assert!(!scratch.halcmd(&["status", "instance"]).stdout.contains("recording:"));
    assert_eq!(scratch.halcmd(&["record", "other.vcd", "x"]).status, Some(0));
    assert_eq!(scratch.halcmd(&["run", "5ms"]).status, Some(0));
    assert_eq!(scratch.halcmd(&["record", "off"]).status, Some(0));
    assert!(
        whole(&std::fs::read(scratch.path().join("other.vcd")).unwrap()).times().iter().count() > 4
    );
    running.signal(Signal::TERM);
    assert_eq!(running.wait().status, Some(1));
}

/// Returns the value of a key anywhere in a JSON document.
fn find<'v>(json: &'v serde_json::Value, name: &str) -> Option<&'v serde_json::Value> {
    json.get(name).or_else(|| {
        let parts: Box<dyn Iterator<Item = &serde_json::Value>> = match json {
            serde_json::Value::Array(list) => Box::new(list.iter()),
            serde_json::Value::Object(map) => Box::new(map.values()),
            _ => return None,
        };
        parts.into_iter().find_map(|v| find(v, name))
    })
}

#[test]
fn another_recording_takes_the_place_of_one_that_has_stopped() {
    let scratch = Scratch::new("again");
    let running = stopped(&scratch, &[]);
    assert_eq!(scratch.halcmd(&["record", "other.vcd", "x"]).status, Some(0));
    scratch.halcmd(&["run", "5ms"]);
    let status = scratch.halcmd(&["status", "instance"]).stdout;
    let shown: Vec<_> = status.lines().filter(|l| l.contains("recording:")).collect();
    assert!(shown.len() == 1 && shown[0].ends_with("other.vcd"), "{status}");
    running.signal(Signal::TERM);
    let output = running.wait();
    line(&scratch, &output.stderr);
    assert_eq!(output.status, Some(1));
}

#[test]
fn it_is_the_status_of_every_end() {
    type End = fn(&Scratch, Running) -> Output;
    let ends: [(&str, End); 4] = [
        ("shutdown", |s, r| {
            s.halcmd(&["shutdown"]);
            r.wait()
        }),
        ("SIGINT", |_, r| {
            r.signal(Signal::INT);
            r.wait()
        }),
        ("halrun -U", |s, r| {
            let stopped = s.halrun(&["-U"]);
            assert_eq!(stopped.status, Some(1));
            let said = plain(s, &stopped.stderr);
            let wanted =
                "halrun: instance 'default': out.vcd: File too large: the recording stopped";
            assert!(said.starts_with(wanted), "{said}");
            r.wait()
        }),
        ("SIGHUP", |_, r| {
            r.signal(Signal::HUP);
            r.wait()
        }),
    ];
    for (name, end) in ends {
        let scratch = Scratch::new("ends");
        let running = stopped(&scratch, &[]);
        let output = end(&scratch, running);
        assert_eq!(output.status, Some(1), "{name}");
        line(&scratch, &output.stderr);
    }
}

#[test]
fn a_session_that_is_typed_ends_with_it() {
    for typed in ["quit\n", "getp nothing\n"] {
        let scratch = Scratch::new("typed");
        let text = format!("{MACHINE}record out.vcd\nrun 20s\n{typed}");
        scratch.write("typed", text);
        let mut command = limited(&scratch, "300", &["--virtual"]);
        let file = File::open(scratch.path().join("typed")).unwrap();
        let output = scratch.run(command.stdin(Stdio::from(file)));
        assert_eq!(output.status, Some(1), "{typed}: {}", output.stderr);
    }
}

/// The last write is the one that fails.
#[test]
fn what_the_end_cannot_write_is_reported_at_the_end() {
    let scratch = Scratch::new("last");
    // Less than the write buffer, but more than the limit.
    scratch.write("m.hal", format!("{MACHINE}record out.vcd\nrun 1s\nrecord off\n"));
    let output = scratch.run(&mut limited(&scratch, "16", &["--virtual", "-f", "m.hal"]));
    let text = scratch.read("out.vcd");
    let said = output.stderr.lines().rfind(|l| l.contains("out.vcd: File too large")).unwrap();
    assert_eq!(parts(said).0, kept(&text));
    assert!(said.starts_with("m.hal:8: "), "{said}");
    assert_eq!(output.status, Some(1));
}

#[test]
fn a_device_that_is_full_is_told_of() {
    let scratch = Scratch::new("device");
    scratch.write("m.hal", MACHINE);
    symlink("/dev/full", scratch.path().join("out.vcd")).unwrap();
    let output = scratch.halrun(&["--virtual", "--for", "1ms", "--record", "out.vcd", "m.hal"]);
    let said =
        "out.vcd: No space left on device: the recording stopped at 0 s; nothing of it is kept";
    assert_eq!((line(&scratch, &output.stderr).as_str(), output.status), (said, Some(1)));
}

/// A machine that records more than a pipe takes which nobody reads: 500 changes in each cycle, and
/// `quits` runs three times in a slower thread.
fn losing(scratch: &Scratch, how: &str) -> (Running, File) {
    let mut lines = format!(
        "loadrt threads name1=t period1=1000000 name2=late period2=500000000
loadrt not count=500
loadrt quits how={how}
"
    );
    for n in 0..500 {
        lines += &format!("net x{n} not.{n}.out => not.{n}.in\naddf not.{n} t\n");
    }
    scratch.write("m.hal", lines + "addf quits.0 late\nstart\n");
    assert_eq!(scratch.run(scratch.command(&[], "mkfifo").arg("out.vcd")).status, Some(0));
    let mut halrun = scratch.command(&[], "halrun");
    halrun.env("HAL_RTMOD_DIR", plugins());
    let running = scratch.start(halrun.args(["--simulate", "--record", "out.vcd", "m.hal"]));
    let pipe = File::open(scratch.path().join("out.vcd")).unwrap();
    (running, pipe)
}

/// The number of lost changes in the one line about them, which is this one otherwise.
fn lost(scratch: &Scratch, stderr: &str, line: &str) -> u64 {
    let mut lines = stderr.lines().filter(|l| l.contains("lost for want of room"));
    let first = plain(scratch, lines.next().unwrap_or_else(|| panic!("{stderr}")));
    assert!(lines.next().is_none(), "{stderr}");
    let (before, after) = line.split_once("N").unwrap();
    let count = first.strip_prefix(before).and_then(|rest| rest.strip_suffix(after));
    count.and_then(|n| n.parse().ok()).unwrap_or_else(|| panic!("{first}"))
}

#[test]
fn lost_changes_are_reported_however_the_process_ends() {
    let from_crash = "the recording: N changes were lost for want of room";
    let from_watcher = "halrun: out.vcd: N changes were lost for want of room";
    for (how, signal, line) in [
        ("segv", None, from_crash),
        ("exit", None, from_crash),
        ("nothing", Some(Signal::QUIT), from_crash),
        ("nothing", Some(Signal::KILL), from_watcher),
    ] {
        let scratch = Scratch::new("lost");
        let (mut running, pipe) = losing(&scratch, how);
        until("it has run", || running.said().1.contains("third run"));
        signal.into_iter().for_each(|signal| running.signal(signal));
        running.ended().unwrap();
        until("that is said", || running.said().1.contains("for want of room"));
        assert!(lost(&scratch, &running.said().1, line) > 0);
        drop(pipe);
    }
}

#[test]
fn a_recording_with_gaps_is_a_failure_of_the_run() {
    let scratch = Scratch::new("gaps");
    let (running, mut pipe) = losing(&scratch, "nothing");
    until("it has run", || running.said().1.contains("third run"));
    // The reader comes late: nothing is refused, but there are gaps.
    let reader = std::thread::spawn(move || {
        let mut all = Vec::new();
        pipe.read_to_end(&mut all).map(|_| all)
    });
    let stopped = scratch.halrun(&["-U"]);
    let line = "halrun: instance 'default': out.vcd: N changes were lost for want of room";
    assert!(lost(&scratch, &stopped.stderr, line) > 0);
    assert_eq!(stopped.status, Some(1), "{}", stopped.stderr);
    let output = running.wait();
    let line = "out.vcd: N changes were lost for want of room";
    assert!(lost(&scratch, &output.stderr, line) > 0);
    assert_eq!(output.status, Some(1), "{}", output.stderr);
    assert!(whole(&reader.join().unwrap().unwrap()).times().iter().count() > 100);
}

#[test]
fn a_recording_that_never_ran_has_its_one_instant() {
    let scratch = Scratch::new("never");
    scratch.write("m.hal", MACHINE.replace("start\n", ""));
    scratch.write("out.vcd", OLD);
    let output = scratch.halrun(&["--virtual", "-f", "--record", "out.vcd", "m.hal"]);
    assert_eq!(output.status, Some(0), "{}", output.stderr);
    let trace = whole(scratch.read("out.vcd").as_bytes());
    assert!(trace.find("x").is_some() && trace.times().iter().count() == 1);
}

#[test]
fn a_recording_that_waits_for_the_start_has_taken_nothing_yet() {
    let scratch = Scratch::new("waits");
    scratch
        .write("m.hal", format!("{}record out.vcd\nprint ready\n", MACHINE.replace("start\n", "")));
    scratch.write("out.vcd", OLD);
    let running =
        scratch.start(scratch.command(&[], "halrun").args(["--virtual", "--hold", "m.hal"]));
    until("it is up", || running.said().1.contains("ready"));
    running.signal(Signal::KILL);
    running.wait();
    assert_eq!(scratch.read("out.vcd"), OLD);
    assert!(scratch.files().keys().all(|n| !n.ends_with(".part")));
}

#[test]
fn the_file_of_an_event_that_cannot_be_written_is_the_status_too() {
    let scratch = Scratch::new("event");
    scratch.write("flight-1.vcd", OLD);
    let lines = format!("{MACHINE}flight on file=flight.vcd when=x > 0.5\nrun 2s\n");
    scratch.write("m.hal", lines);
    let output = scratch.run(&mut limited(&scratch, "8", &["--virtual", "-f", "m.hal"]));
    let said = "flight recorder: x > 0.5; ";
    let first = output.stderr.lines().find(|l| l.starts_with(said)).unwrap();
    assert!(first.contains("flight-1.vcd: File too large"), "{first}");
    assert_eq!((output.status, scratch.read("flight-1.vcd").as_str()), (Some(1), OLD));
}

#[test]
fn a_test_whose_recording_cannot_be_written_fails() {
    let scratch = Scratch::new("haltest");
    scratch.write("m.hal", MACHINE);
    let test = "machine = \"m.hal\"\n\n[[step]]\nrun = \"60s\"\n\n\
                [[expect]]\nvalue = \"x\"\nleast = -2\nmost = 2\n";
    std::fs::create_dir(scratch.path().join("t")).unwrap();
    scratch.write("a.toml", test);
    let good = scratch.run(scratch.command(&[], "haltest").arg("a.toml"));
    assert_eq!(good.status, Some(0), "{}{}", good.stdout, good.stderr);
    let limit = "ulimit -f 300; exec \"$0\" \"$@\"";
    let output = scratch.run(scratch.command(&["sh", "-c", limit], "haltest").arg("a.toml"));
    assert_eq!(output.status, Some(1), "{}{}", output.stdout, output.stderr);
    let all = output.stdout + &output.stderr;
    assert!(all.contains(".haltest.vcd: File too large: the recording stopped at "), "{all}");
}
