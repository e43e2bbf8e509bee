//! Files that take nothing: pipes that no process reads, or whose reader does not read, as a stand-in for a slow disk.
//! They hold up neither the threads nor the end of the process, and what they do not take is reported.
#![expect(clippy::unwrap_used, reason = "tests")]

use hal_protocol::{Client, Link, Request, SampleSpec};
use hal_tests::{
    plugins::plugins,
    scratch::{Running, Scratch, until},
};
use rustix::{
    event::{PollFd, PollFlags, Timespec, poll},
    process::Signal,
};
use std::{
    fs::{File, OpenOptions},
    io::Read,
    os::unix::fs::OpenOptionsExt,
};

/// A machine that changes 500 values in each cycle of a millisecond, and drives a port.
fn machine(last: &str) -> String {
    let mut lines = "loadrt threads name1=t period1=1000000\nloadrt not count=500\nloadrt siggen\n\
                     net x siggen.0.sawtooth\naddf siggen.0.update t\n\
                     loadrt hal_parport cfg=\"0x378 out\"\nloadrt last_words\n\
                     net register parport.0.sim.data last-words.0.in\n\
                     setp parport.0.pin-02-out 1\naddf parport.0.write t\naddf last-words.0 t\n"
        .to_owned();
    for n in 0..500 {
        lines += &format!("net x{n} not.{n}.out => not.{n}.in\naddf not.{n} t\n");
    }
    lines + last
}

/// Makes a pipe and opens it, so that a writer finds a reader, which reads nothing before `drain`.
fn unread(scratch: &Scratch, name: &str) -> File {
    make_pipe(scratch, name);
    let mut options = OpenOptions::new();
    options.read(true).write(true).custom_flags(libc::O_NONBLOCK);
    options.open(scratch.path().join(name)).unwrap()
}

/// Reads everything that is in a pipe.
fn drain(mut pipe: &File) {
    let mut bytes = vec![0; 1 << 16];
    while pipe.read(&mut bytes).is_ok_and(|n| n > 0) {}
}

fn make_pipe(scratch: &Scratch, name: &str) {
    assert_eq!(scratch.run(scratch.command(&[], "mkfifo").arg(name)).status, Some(0));
}

/// Waits until a pipe takes no more, and a thread of the process waits in a write.
fn until_full(running: &Running, pipe: &File) {
    let tasks = format!("/proc/{}/task", running.pid());
    let writes = || {
        let mut tasks = std::fs::read_dir(&tasks).unwrap();
        tasks.any(|task| {
            let text = std::fs::read_to_string(task.unwrap().path().join("syscall"));
            let text = text.unwrap_or_default();
            text.split(' ').next().and_then(|n| n.parse().ok()) == Some(libc::SYS_write)
        })
    };
    // The number of bytes does not say it: writes that do not fit into the rest of a page leave that rest empty.
    let is_full = || {
        let mut end = [PollFd::new(pipe, PollFlags::OUT)];
        poll(&mut end, Some(&Timespec { tv_sec: 0, tv_nsec: 0 })) == Ok(0)
    };
    until("the pipe is full", || is_full() && writes());
}

fn start(scratch: &Scratch, lines: &str, words: &[&str]) -> Running {
    scratch.write("m.hal", lines);
    let mut halrun = scratch.command(&[], "halrun");
    halrun.env("HAL_RTMOD_DIR", plugins());
    scratch.start(halrun.args(words).arg("m.hal"))
}

fn said(running: &Running, part: &str) -> bool {
    running.said().1.contains(part)
}

const SAFE: &str = "last words: it was 1 and is 0\n";

/// Waits until a command runs that does not return. Until then, the pipe is read.
fn hang(scratch: &Scratch, running: &Running, pipe: &File) -> Running {
    until("it is up", || {
        drain(pipe);
        said(running, "ready")
    });
    let client = scratch.start(scratch.command(&[], "halcmd").arg("quits.go"));
    until("the command runs", || {
        drain(pipe);
        said(running, "it does not return")
    });
    client
}

#[test]
fn an_event_whose_pipe_no_process_reads_is_reported() {
    let want =
        "flight-1.vcd: no process reads this pipe; it is in memory: 'flight save FILE.vcd last'\n";
    for clock in ["--virtual", "--simulate"] {
        let scratch = Scratch::new("unread");
        make_pipe(&scratch, "flight-1.vcd");
        let lines = machine("flight on file=flight.vcd when=x > 0.5\nstart\n");
        let running = start(&scratch, &lines, &[clock]);
        until("it is said", || said(&running, "flight recorder: "));
        // The machine goes on, and the event can be kept elsewhere.
        assert_eq!(scratch.halcmd(&["flight", "save", "kept.vcd", "last"]).status, Some(0));
        running.signal(Signal::TERM);
        let output = running.wait();
        assert!(output.stderr.contains(want), "{clock}: {}", output.stderr);
        assert!(output.stderr.contains(SAFE), "{clock}: {}", output.stderr);
        assert_eq!(output.status, Some(1), "{clock}");
        assert!(scratch.read("kept.vcd").contains("x > 0.5"));
    }
}

#[test]
fn an_event_whose_reader_does_not_read_is_reported() {
    for clock in ["--virtual", "--simulate"] {
        let scratch = Scratch::new("unread");
        let pipe = unread(&scratch, "flight-1.vcd");
        let lines = machine("flight on file=flight.vcd when=x > 0.5\nstart\n");
        let running = start(&scratch, &lines, &[clock]);
        let want = "flight-1.vcd: its reader has taken nothing for a second; it is in memory";
        until("it is said", || said(&running, want));
        running.signal(Signal::TERM);
        let output = running.wait();
        assert!(output.stderr.contains(SAFE), "{clock}: {}", output.stderr);
        assert_eq!(output.status, Some(1), "{clock}: {}", output.stderr);
        drop(pipe);
    }
}

/// The process writes the event as it ends.
#[test]
fn an_event_is_reported_if_nobody_reads_it_at_the_end() {
    let why = "flight-1.vcd: its reader has taken nothing for a second; it is lost\n";
    for signal in [Signal::TERM, Signal::QUIT, Signal::SEGV] {
        let scratch = Scratch::new("last");
        let pipe = unread(&scratch, "flight-1.vcd");
        let lines = machine(
            "flight on file=flight.vcd after=1000s when=x > 0.5\nstart\nrun 900ms\nprint ready\n",
        );
        let mut running = start(&scratch, &lines, &["--virtual", "--hold"]);
        until("it is up", || said(&running, "ready"));
        running.signal(signal);
        let status = running.ended().unwrap();
        let (_, stderr) = running.said();
        assert!(stderr.contains(why) && stderr.contains(SAFE), "{signal:?}: {stderr}");
        assert!(!status.success(), "{signal:?}");
        drop(pipe);
    }
}

/// While nothing takes the recording, a thread writes it that is neither the control side nor the guard.
#[test]
fn a_signal_is_heeded_while_the_recording_is_not_taken() {
    for signal in [Signal::TERM, Signal::INT, Signal::QUIT, Signal::SEGV] {
        // First the control side writes, then the thread that writes in its place.
        for how in ["nothing", "hang"] {
            let scratch = Scratch::new("taken");
            let pipe = unread(&scratch, "out.vcd");
            scratch
                .write("wait.sh", "until [ \"$(halcmd getp t.threadbeat)\" -gt 2 ]; do :; done\n");
            // The head of the file must not fill the pipe.
            let lines = machine(&format!(
                "loadrt quits how={how} where=command\nstart\nloadusr -w sh wait.sh\n\
                 record out.vcd x*\nprint ready\n"
            ));
            let mut running = start(&scratch, &lines, &["--simulate"]);
            let client = (how == "hang").then(|| hang(&scratch, &running, &pipe));
            until_full(&running, &pipe);
            running.signal(signal);
            let status = running.ended().unwrap();
            let stderr = running.said().1;
            assert!(stderr.contains(SAFE), "{how} {signal:?}: {stderr}");
            assert!(!status.success(), "{how} {signal:?}: {stderr}");
            let lines = [
                "the recorder is in the middle of its own work, such as a write that does not return: the \
                 recording ends at its last write",
                "the recording's file takes nothing: it ends at its last write",
            ];
            assert!(lines.iter().any(|l| stderr.contains(l)), "{how} {signal:?}: {stderr}");
            drop((pipe, client));
        }
    }
}

#[test]
fn a_signal_is_heeded_while_a_recording_holds_the_virtual_clock() {
    for signal in [Signal::TERM, Signal::INT] {
        let scratch = Scratch::new("holds");
        let pipe = unread(&scratch, "out.vcd");
        let lines = machine("start\nrun 5ms\nrecord out.vcd\n");
        let running = start(&scratch, &lines, &["--virtual"]);
        until_full(&running, &pipe);
        running.signal(signal);
        let output = running.wait();
        assert!(output.stderr.contains(SAFE), "{signal:?}: {}", output.stderr);
        assert_eq!(output.status, Some(1), "{signal:?}: {}", output.stderr);
    }
}

/// A sample is read from shared memory, without the control side, which waits for the file.
#[test]
fn threads_go_on_while_the_recording_is_not_taken() {
    let scratch = Scratch::new("goes-on");
    let pipe = unread(&scratch, "out.vcd");
    let lines = machine("flight on file=flight.vcd when=x > 0.9\nstart\nprint ready\n");
    let mut running = start(&scratch, &lines, &["--simulate"]);
    until("it is up", || said(&running, "ready"));
    let place = scratch.place("default");
    let mut client = Client::connect(&place, "").unwrap();
    let spec = SampleSpec {
        names: vec!["x".to_owned()],
        thread: Some("t".to_owned()),
        depth: 1 << 16,
        ..SampleSpec::default()
    };
    let mut samples = client.sample(spec).unwrap();
    client.call(Request::Record { path: "out.vcd".into(), patterns: vec!["x*".into()] }).unwrap();
    until_full(&running, &pipe);
    let mut record = Vec::new();
    while samples.take(&mut record).is_some() {}
    // Each of the following cycles runs while the file takes nothing.
    let mut stamps = Vec::new();
    until("a thousand cycles have run", || {
        while let Some(stamp) = samples.take(&mut record) {
            stamps.push(stamp);
        }
        stamps.len() >= 1000
    });
    assert!(stamps.windows(2).all(|s| s[0].number + 1 == s[1].number && s[1].lost == 0));
    // The reader comes: the control side answers again, and the gaps are reported.
    // The event has gaps as well: at the latest, the next one after the reader came.
    until("an event is kept", || {
        drain(&pipe);
        let kept =
            |line: &str| line.contains("; kept in ") && line.contains("lost for want of room");
        running.said().1.lines().any(kept)
    });
    running.signal(Signal::TERM);
    until("it has ended", || {
        drain(&pipe);
        !running.is_running()
    });
    let output = running.wait();
    assert!(output.stderr.contains(SAFE), "{}", output.stderr);
    assert!(output.stderr.contains("out.vcd: "), "{}", output.stderr);
    assert_eq!(output.status, Some(1), "{}", output.stderr);
}
