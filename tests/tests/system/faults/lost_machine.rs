//! Results and messages of clients whose machine ends, is killed, crashes, or stops responding.
#![expect(clippy::unwrap_used, reason = "tests")]

use hal_tests::{
    plugins::plugins,
    scratch::{Output, Running, Scratch, until},
    terminal::Terminal,
};
use hal_trace::{Format, Trace};
use rustix::process::{Pid, Signal, kill_process};

/// Manner in which a machine is lost.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum End {
    Kill,
    Shutdown,
    Crash,
}

const ENDS: [End; 3] = [End::Kill, End::Shutdown, End::Crash];
const ENDED: &str = "the machine has ended";

/// A machine on a virtual clock that only `halcmd run` moves. `not.0.out` is true in every other
/// cycle; `quits.go` ends the process with `abort`.
fn machine(scratch: &Scratch) -> Running {
    let lines = "loadrt threads name1=t period1=1000000\nloadrt not\nloadrt sampler depth=1000 cfg=b\n\
                 loadrt streamer depth=4 cfg=b\n\
                 loadrt quits how=abort where=command\nnet n not.0.out => not.0.in sampler.0.pin.0\n\
                 addf not.0 t\naddf sampler.0 t\nstart\nprint ready\n";
    scratch.write("m.hal", lines);
    let mut halrun = scratch.command(&[], "halrun");
    halrun.env("HAL_RTMOD_DIR", plugins());
    let running = scratch.start(halrun.args(["--virtual", "--hold", "m.hal"]));
    until("the machine runs", || running.said().1.contains("ready"));
    running
}

/// Starts a program, and waits until it shares memory with the machine.
fn sampling(scratch: &Scratch, program: &str, words: &[&str]) -> Running {
    let running = scratch.start(scratch.command(&[], program).args(words));
    until("it samples", || shares_memory(running.pid()));
    running
}

fn shares_memory(pid: u32) -> bool {
    std::fs::read_to_string(format!("/proc/{pid}/maps")).unwrap().contains("memfd:hal-stream")
}

fn run(scratch: &Scratch, time: &str) {
    let output = scratch.halcmd(&["run", time]);
    assert_eq!(output.status, Some(0), "{}", output.stderr);
}

fn end(scratch: &Scratch, mut machine: Running, how: End) {
    match how {
        End::Kill => machine.signal(Signal::KILL),
        End::Shutdown => drop(scratch.halcmd(&["shutdown"])),
        End::Crash => drop(scratch.halcmd(&["quits.go"])),
    }
    machine.ended().unwrap();
}

fn read(scratch: &Scratch, name: &str) -> Trace {
    let path = scratch.path().join(name);
    let reading = Format::of(&path).unwrap().read(&std::fs::read(path).unwrap());
    assert_eq!(reading.flaw, None);
    reading.trace
}

/// Returns the status and the last line of standard error.
fn ended(output: &Output) -> (Option<i32>, &str) {
    (output.status, output.stderr.lines().last().unwrap_or(""))
}

#[test]
fn a_capture_keeps_what_was_sampled_before_the_machine_ended() {
    for how in ENDS {
        let scratch = Scratch::new("capture");
        let machine = machine(&scratch);
        let capture = |trigger: &str, before: &str, file: &str| {
            let words = ["capture", "-l", "900", "-b", before, "-t", trigger, "-o", file, "n"];
            sampling(&scratch, "halscope", &words)
        };
        let seen = capture("n rises", "0", "seen.csv");
        // Two are stopped while the machine ends: they still receive the samples in the ring.
        let late = capture("n rises", "0", "late.vcd");
        let stopped = [late, capture("n and not n", "50%", "never.fst")];
        stopped.iter().for_each(|p| p.signal(Signal::STOP));
        run(&scratch, "100ms");
        end(&scratch, machine, how);
        stopped.iter().for_each(|p| p.signal(Signal::CONT));
        let seen = seen.wait();
        let [late, never] = stopped.map(Running::wait);
        let lost = format!("halscope: {ENDED}: the capture is not whole");
        for (output, file) in [(seen, "seen.csv"), (late, "late.vcd")] {
            assert_eq!(ended(&output), (Some(3), &*lost), "{how:?}, {file}");
            // The signal is true, false, and then rises.
            assert_eq!(read(&scratch, file).len(), 98, "{how:?}, {file}");
        }
        assert_eq!(never.status, Some(2), "{how:?}: {}", never.stderr);
        assert!(never.stderr.contains(ENDED), "{how:?}: {}", never.stderr);
        assert_eq!(read(&scratch, "never.fst").len(), 100, "{how:?}");
    }
}

#[test]
fn halsampler_prints_every_record_that_the_machine_has_left() {
    for how in ENDS {
        let scratch = Scratch::new("sampler");
        let machine = machine(&scratch);
        let sampler = sampling(&scratch, "halsampler", &["-t"]);
        run(&scratch, "100ms");
        sampler.signal(Signal::STOP);
        run(&scratch, "100ms");
        end(&scratch, machine, how);
        sampler.signal(Signal::CONT);
        check_printed(&sampler.wait(), 200, ENDED);
    }
}

/// Checks that a sampler printed this number of records, from the first, and this message.
fn check_printed(output: &Output, records: usize, why: &str) {
    let want = format!("ERROR: {why}: {records} records were printed");
    assert_eq!(ended(output), (Some(1), &*want));
    let lines = (0..records).map(|n| format!("{n} {} \n", (n + 1) % 2));
    assert_eq!(output.stdout, lines.collect::<String>());
}

#[test]
fn programs_at_a_ring_end_when_its_component_is_unloaded() {
    let scratch = Scratch::new("unloaded");
    let _machine = machine(&scratch);
    // Five records for a ring of three.
    scratch.write("values", "1\n0\n1\n0\n1\n");
    let sampler = sampling(&scratch, "halsampler", &["-t"]);
    let streamer = sampling(&scratch, "halstreamer", &["values"]);
    run(&scratch, "50ms");
    for name in ["sampler", "streamer"] {
        let output = scratch.halcmd(&["unloadrt", name]);
        assert_eq!(output.status, Some(0), "{}", output.stderr);
    }
    check_printed(&sampler.wait(), 50, "the sampler has been unloaded");
    let want = (Some(1), "ERROR: the streamer has been unloaded");
    assert_eq!(ended(&streamer.wait()), want);
    // A component that is loaded again has a new ring, which is not closed.
    let output = scratch.halcmd(&["loadrt", "sampler", "depth=10", "cfg=b"]);
    assert_eq!(output.status, Some(0), "{}", output.stderr);
    scratch.halcmd(&["addf", "sampler.0", "t"]);
    let again = sampling(&scratch, "halsampler", &["-n", "2"]);
    run(&scratch, "2ms");
    assert_eq!(again.wait().stdout, "0 \n0 \n");
}

#[test]
fn a_view_gives_the_terminal_back_when_the_machine_ends() {
    for how in ENDS {
        let scratch = Scratch::new("view");
        let machine = machine(&scratch);
        let mut view = Terminal::start(&scratch, "halscope", &["view", "n"]);
        view.until("triggers");
        end(&scratch, machine, how);
        view.until("over:");
        view.keys("q");
        let (status, sane, shown) = view.end();
        assert!(sane && shown.contains(ENDED), "{how:?}: {shown:?}");
        assert_eq!(status, Some(1), "{how:?}");
    }
}

#[test]
fn a_watch_ends_when_the_machine_ends() {
    for how in ENDS {
        let scratch = Scratch::new("watch");
        let machine = machine(&scratch);
        let lines = scratch.start(scratch.command(&[], "halcmd").args(["watch", "n"]));
        until("it watches", || lines.said().0.contains(" n "));
        let mut screen = Terminal::start(&scratch, "halcmd", &["watch", "n"]);
        screen.until("FALSE");
        end(&scratch, machine, how);
        assert_eq!(lines.wait().status, Some(1), "{how:?}");
        let (status, sane, shown) = screen.end();
        assert!(sane && status == Some(1), "{how:?}: {status:?}, {shown:?}");
    }
}

#[test]
fn ctrl_c_ends_the_clients_of_a_machine_that_stands_still() {
    let scratch = Scratch::new("stopped");
    let machine = machine(&scratch);
    let seen = ["capture", "-l", "900", "-b", "0", "-t", "n rises", "-o", "seen.csv", "n"];
    let none = ["capture", "-l", "900", "-b", "50%", "-t", "n and not n", "-o", "none.csv", "n"];
    let captures = [seen, none].map(|words| sampling(&scratch, "halscope", &words));
    let sampler = sampling(&scratch, "halsampler", &["samples"]);
    let mut view = Terminal::start(&scratch, "halscope", &["view", "n"]);
    view.until("triggers");
    let watches = [["watch", "n"], ["watch", "n"], ["meter", "n"]];
    let mut watches = watches.map(|words| Terminal::start(&scratch, "halcmd", &words));
    for view in &mut watches {
        view.until("quit");
    }
    run(&scratch, "20ms");
    machine.signal(Signal::STOP);
    // A key that is pressed when the machine has stopped to answer.
    for (view, keys) in watches.iter_mut().zip(["q", "\u{3}", "q"]) {
        view.keys(keys);
    }
    for view in watches {
        let (_, sane, shown) = view.end();
        assert!(sane, "{shown:?}");
    }
    let begun = scratch.start(scratch.command(&[], "halscope").args(["capture", "n"]));
    // Each client now waits for a reply, in a system call that reads.
    for pid in captures.iter().chain([&sampler, &begun]).map(Running::pid) {
        until("it waits for an answer", || waits_for_socket(pid));
        kill_process(Pid::from_raw(pid.cast_signed()).unwrap(), Signal::INT).unwrap();
    }
    let [seen, none] = captures.map(Running::wait);
    assert_eq!(ended(&seen), (Some(3), "halscope: interrupted: the capture is not whole"));
    assert_eq!(read(&scratch, "seen.csv").len(), 18);
    assert_eq!(none.status, Some(2), "{}", none.stderr);
    assert_eq!(read(&scratch, "none.csv").len(), 20);
    assert_eq!(sampler.wait().status, Some(0));
    assert_eq!(scratch.read("samples").lines().count(), 20);
    assert_eq!(ended(&begun.wait()), (Some(1), "halscope: interrupted"));
    // The view responds to its keys, not only to a signal.
    view.keys("q");
    let (status, sane, shown) = view.end();
    assert!(sane && status == Some(0), "{status:?}, {shown:?}");
    machine.signal(Signal::CONT);
    let time = scratch.halcmd(&["getp", "not.0.out"]);
    assert_eq!(time.status, Some(0), "the machine is as it was: {}", time.stderr);
}

/// Returns whether a process is in a system call that waits for a socket or a file.
fn waits_for_socket(pid: u32) -> bool {
    let text = std::fs::read_to_string(format!("/proc/{pid}/syscall")).unwrap();
    let number = text.split(' ').next().and_then(|n| n.parse().ok());
    [libc::SYS_ppoll, libc::SYS_poll, libc::SYS_recvmsg].iter().any(|call| number == Some(*call))
}

#[test]
fn a_machine_that_ends_by_itself_leaves_every_sample() {
    let scratch = Scratch::new("samples");
    let lines = "loadrt threads name1=t period1=1000000\nloadrt sampler depth=16000 cfg=b\naddf sampler.0 t\n\
                 loadusr -Wn halsampler0 halsampler samples\nstart\n";
    scratch.write("m.hal", lines);
    let ended = scratch.halrun(&["--virtual", "--for", "10s", "m.hal"]);
    assert_eq!(ended.status, Some(0), "{}", ended.stderr);
    assert_eq!(scratch.read("samples").lines().count(), 10_000);
}
