//! Termination of an instance: effects on its outputs, recordings, socket and status.
//!
//! `tests/ends/table.md` holds the results of this test; `UPDATE_EXPECT=1` writes the file.
#![expect(
    clippy::unwrap_used,
    clippy::panic,
    clippy::print_stdout,
    reason = "tests; what is measured is shown"
)]

use hal_protocol::Value;
use hal_tests::{
    golden,
    plugins::plugins,
    programs::{programs, root},
    scratch::{Running, Scratch, until},
};
use hal_trace::{Format, Trace};
use rustix::process::Signal;
use std::{
    os::unix::process::ExitStatusExt,
    process::{Command, ExitStatus},
};

/// Cause that makes a process end.
#[derive(Clone, Copy, Debug)]
enum By {
    /// Code of a component, in its third run: what it does, and in which code.
    Component(&'static str, &'static str),
    /// A command of a component, sent by a client.
    Command(&'static str),
    /// A signal from outside.
    Signal(Signal),
    /// The first real-time signal.
    Realtime,
    /// SIGTERM, while a component does not return: what it does, and in which code.
    Stuck(&'static str, &'static str),
    /// `halcmd shutdown`.
    Shutdown,
    /// A signal from outside, after the disk was full for a while.
    Full(Signal),
}

use By::{Component, Full, Realtime, Shutdown, Stuck};

/// Rows of the table: description and cause.
const WAYS: &[(&str, By)] = &[
    ("`halcmd shutdown`", Shutdown),
    ("SIGTERM", By::Signal(Signal::TERM)),
    ("SIGINT (Ctrl-C)", By::Signal(Signal::INT)),
    ("SIGHUP", By::Signal(Signal::HUP)),
    ("SIGQUIT", By::Signal(Signal::QUIT)),
    ("SIGUSR1", By::Signal(Signal::USR1)),
    ("SIGUSR2", By::Signal(Signal::USR2)),
    ("SIGALRM", By::Signal(Signal::ALARM)),
    ("SIGVTALRM", By::Signal(Signal::VTALARM)),
    ("SIGPROF", By::Signal(Signal::PROF)),
    ("SIGXCPU", By::Signal(Signal::XCPU)),
    ("SIGSTKFLT", By::Signal(Signal::STKFLT)),
    ("SIGIO", By::Signal(Signal::IO)),
    ("SIGPWR", By::Signal(Signal::POWER)),
    ("SIGRTMIN, a real-time signal", Realtime),
    ("SIGPIPE, which does nothing; then SIGTERM", By::Signal(Signal::PIPE)),
    ("SIGXFSZ, which does nothing; then SIGTERM", By::Signal(Signal::XFSZ)),
    ("SIGSEGV from outside", By::Signal(Signal::SEGV)),
    ("SIGBUS from outside", By::Signal(Signal::BUS)),
    ("SIGFPE from outside", By::Signal(Signal::FPE)),
    ("SIGILL from outside", By::Signal(Signal::ILL)),
    ("SIGABRT from outside", By::Signal(Signal::ABORT)),
    ("SIGTRAP from outside", By::Signal(Signal::TRAP)),
    ("SIGSYS from outside", By::Signal(Signal::SYS)),
    ("SIGTERM while a function sleeps", Stuck("hang", "function")),
    ("SIGTERM while a function runs in circles", Stuck("spin", "function")),
    ("SIGTERM while a component is created", Stuck("hang", "create")),
    ("SIGTERM while a component opens its device", Stuck("spin", "open")),
    ("SIGTERM while a background task runs", Stuck("hang", "task")),
    ("SIGTERM while a command runs", Stuck("hang", "command")),
    ("SIGTERM, and a stop action does not come back", Stuck("hang", "stop")),
    ("panic in a function, then SIGTERM", Stuck("panic", "function")),
    ("segmentation fault in a function", Component("segv", "function")),
    ("the stack of a function is used up", Component("stack", "function")),
    ("bus error in a function", Component("bus", "function")),
    ("arithmetic fault in a function", Component("fpe", "function")),
    ("illegal instruction in a function", Component("ill", "function")),
    ("refused port access in a function", Component("port", "function")),
    ("SIGSEGV raised in a function", Component("raise-segv", "function")),
    ("SIGBUS raised in a function", Component("raise-bus", "function")),
    ("SIGFPE raised in a function", Component("raise-fpe", "function")),
    ("SIGILL raised in a function", Component("raise-ill", "function")),
    ("SIGABRT raised in a function", Component("raise-abrt", "function")),
    ("`exit(3)` in a function", Component("exit", "function")),
    ("`exit(0)` in a function", Component("exit-0", "function")),
    ("`_exit(4)` in a function", Component("at-once", "function")),
    ("`_Exit(4)` in a function", Component("at-once-in-c", "function")),
    ("`quick_exit(5)` in a function", Component("quick-exit", "function")),
    ("`abort()` in a function", Component("abort", "function")),
    ("`exit(3)` in a command", By::Command("exit")),
    ("`_exit(4)` in a command", By::Command("at-once")),
    ("`quick_exit(5)` in a command", By::Command("quick-exit")),
    ("`abort()` in a command", By::Command("abort")),
    ("`exit(3)` in a component's own thread", Component("exit", "thread")),
    ("`_exit(4)` in a component's own thread", Component("at-once", "thread")),
    ("`quick_exit(5)` in a component's own thread", Component("quick-exit", "thread")),
    ("`abort()` in a component's own thread", Component("abort", "thread")),
    ("segmentation fault in a component's own thread", Component("segv", "thread")),
    ("`exit(3)` in a background task", Component("exit", "task")),
    ("`exit(3)` as a component is created", Component("exit", "create")),
    ("`exit(3)` as a component opens its device", Component("exit", "open")),
    ("`exit(3)` in a stop action, at SIGTERM", Stuck("exit", "stop")),
    ("`exit(3)` as a component is freed, at SIGTERM", Stuck("exit", "drop")),
    ("system call `exit_group(6)` in a function", Component("system-call", "function")),
    ("system call `exit_group(6)` in a component's own thread", Component("system-call", "thread")),
    ("a function sends its own process SIGKILL", Component("kill", "function")),
    ("a function makes the process another program (exec)", Component("execute", "function")),
    ("SIGKILL (`kill -9`)", By::Signal(Signal::KILL)),
    ("the disk is full, then SIGTERM", Full(Signal::TERM)),
    ("the disk is full, then SIGQUIT", Full(Signal::QUIT)),
    ("the disk is full, then SIGSEGV from outside", Full(Signal::SEGV)),
    ("the disk is full, then SIGKILL", Full(Signal::KILL)),
];

/// Result of one row.
#[derive(Clone, Debug, PartialEq, Eq)]
struct End {
    outputs: &'static str,
    recording: &'static str,
    flight: &'static str,
    socket: &'static str,
    status: String,
    said: String,
}

/// Starts the machine for a cause: a port whose first line is high, and a plugin that reports at
/// the end the present and the previous value of the port's register.
fn start(scratch: &Scratch, by: By, virtually: bool) -> Running {
    let (how, at) = match by {
        Component(how, at) | Stuck(how, at) => (how, at),
        By::Command(how) => (how, "command"),
        By::Signal(_) | Realtime | Shutdown | Full(_) => ("nothing", "function"),
    };
    let load = format!("loadrt quits how={how} where={at}\n");
    // A fault during loading must happen while the others run.
    let late = ["create", "open"].contains(&at);
    let (first, last) =
        if late { (String::new(), load) } else { (load + "addf quits.0 t\n", String::new()) };
    let wait = match (virtually, late) {
        (true, _) => "run 10ms\n",
        (false, true) => "loadusr -w sh wait.sh\n",
        (false, false) => "",
    };
    scratch.write("wait.sh", "until [ \"$(halcmd getp t.threadbeat)\" -gt 2 ]; do :; done\n");
    let machine = format!(
        "loadrt threads name1=t period1=1000000
loadrt hal_parport cfg=\"0x378 out\"
loadrt last_words
net register parport.0.sim.data last-words.0.in
setp parport.0.pin-02-out 1
{first}addf parport.0.write t
addf last-words.0 t
start
{wait}{last}print ready
"
    );
    scratch.write("m.hal", machine);
    // No file may exceed 8 blocks, as on a full disk.
    let limit: &[&str] = &["sh", "-c", "ulimit -f 8; exec \"$0\" \"$@\""];
    let before = if matches!(by, Full(_)) { limit } else { &[] };
    let mut command: Command = scratch.command(before, "halrun");
    command.env_remove("HAL_STUCK_TIME");
    command.env("HAL_RTMOD_DIR", plugins());
    let clock: &[&str] = if virtually { &["--virtual", "--hold"] } else { &["--simulate"] };
    command.args(clock).args(["--record", "out.vcd", "--flight", "file=flight.vcd", "m.hal"]);
    scratch.start(&mut command)
}

/// Waits until the machine is in the state that a cause requires. The client, if there is one,
/// waits too.
fn wait_until_up(
    scratch: &Scratch,
    running: &mut Running,
    by: By,
    virtually: bool,
) -> Option<Running> {
    let said = |running: &Running, text: &str| {
        let (out, err) = running.said();
        out.contains(text) || err.contains(text)
    };
    if matches!(by, Component(..)) {
        return None;
    }
    until("it has run", || said(running, "third run") || !running.is_running());
    let inside = "it does not return";
    let (what, text) = match by {
        Stuck("panic", _) => ("it has failed", "failed in thread"),
        // The watchdog detects these.
        Stuck("hang" | "spin", "function") if !virtually => ("it is stuck", "failed in thread"),
        Stuck("hang" | "spin", "function" | "task" | "create" | "open") => ("it is inside", inside),
        _ => ("its script is done", "HALCMD MSG: ready"),
    };
    until(what, || said(running, text) || !running.is_running());
    let commanded = matches!(by, Stuck(_, "command"));
    let client = commanded.then(|| scratch.start(scratch.command(&[], "halcmd").arg("quits.go")));
    until("the command runs", || !commanded || said(running, inside));
    client
}

/// Waits until the machine runs, then ends it.
fn finish(scratch: &Scratch, running: &mut Running, by: By, virtually: bool) -> ExitStatus {
    let client = wait_until_up(scratch, running, by, virtually);
    match by {
        Component(..) => {}
        By::Command(_) => drop(scratch.halcmd(&["quits.go"])),
        By::Signal(signal) => running.signal(signal),
        Realtime => {
            let kill = format!("kill -{} {}", libc::SIGRTMIN(), running.pid());
            scratch.run(scratch.command(&["sh", "-c"], &kill).arg(""));
        }
        Stuck(..) => running.signal(Signal::TERM),
        Shutdown => drop(scratch.halcmd(&["shutdown"])),
        Full(signal) => {
            let runs = || scratch.halcmd(&["getp", "quits.runs"]).stdout;
            let more = |than: u32| runs().trim().parse::<u32>().is_ok_and(|n| n > than);
            if virtually {
                scratch.halcmd(&["run", "4s"]);
            }
            // This must be reported at once, not only when the recording ends; and the machine
            // continues.
            until("that is said", || running.said().1.contains("the recording stopped at"));
            let before = runs().trim().parse().unwrap();
            until("it runs", || virtually || more(before));
            running.signal(signal);
        }
    }
    if let By::Signal(Signal::PIPE | Signal::XFSZ) = by {
        // The machine continues.
        let answer = scratch.halcmd(&["getp", "quits.runs"]);
        assert!(answer.status == Some(0) && running.is_running(), "{by:?}");
        running.signal(Signal::TERM);
    }
    let ended = running.ended();
    drop(client);
    ended.unwrap_or_else(|| panic!("{by:?} does not end"))
}

/// Returns the result for one cause on one clock.
fn end(by: By, virtually: bool) -> End {
    let scratch = Scratch::new("ends");
    let mut running = start(&scratch, by, virtually);
    let status = finish(&scratch, &mut running, by, virtually);
    let safe = running.said().1.contains("last words: it was 1 and is 0\n");
    if !safe {
        // The watcher may report slightly later.
        until("the watcher says it", || running.said().1.contains("instance 'default' was"));
    }
    End {
        outputs: if safe { "safe" } else { "as they were" },
        recording: recording(&scratch),
        flight: if flight(&scratch) { "kept" } else { "none" },
        socket: if scratch.left().is_empty() { "gone" } else { "left" },
        status: shown(status),
        said: plain(&scratch, &running.said().1),
    }
}

/// Reads a file; `None` if it does not exist.
fn read(scratch: &Scratch, name: &str) -> Option<Result<Trace, String>> {
    let path = scratch.path().join(name);
    let bytes = std::fs::read(&path).ok()?;
    let reading = Format::of(&path).unwrap().read(&bytes);
    Some(reading.flaw.map_or(Ok(reading.trace), |flaw| Err(format!("{flaw:?}"))))
}

fn recording(scratch: &Scratch) -> &'static str {
    match read(scratch, "out.vcd") {
        None => "none",
        Some(Err(flaw)) => {
            let text = std::fs::read_to_string(scratch.path().join("out.vcd"));
            println!("the recording is cut: {flaw}\n{text:?}");
            "cut"
        }
        Some(Ok(trace)) => {
            let register = trace.channels().get(trace.find("register").unwrap()).unwrap();
            let values: Vec<_> = register.changes().filter_map(|c| c.value).collect();
            let safe = values.len() > 1 && values.last() == Some(&Value::U32(0));
            if safe { "whole, with the safe levels" } else { "whole, to its last write" }
        }
    }
}

fn flight(scratch: &Scratch) -> bool {
    let Some(kept) = read(scratch, "flight-1.vcd") else { return false };
    let text = kept.unwrap().markers().first().unwrap().text.clone();
    assert!(text.starts_with("trigger: crash: ") || text.starts_with("trigger: fault: "), "{text}");
    true
}

fn shown(status: ExitStatus) -> String {
    const NAMES: &[(i32, &str)] = &[
        (libc::SIGQUIT, "SIGQUIT"),
        (libc::SIGILL, "SIGILL"),
        (libc::SIGTRAP, "SIGTRAP"),
        (libc::SIGABRT, "SIGABRT"),
        (libc::SIGBUS, "SIGBUS"),
        (libc::SIGFPE, "SIGFPE"),
        (libc::SIGKILL, "SIGKILL"),
        (libc::SIGUSR1, "SIGUSR1"),
        (libc::SIGSEGV, "SIGSEGV"),
        (libc::SIGUSR2, "SIGUSR2"),
        (libc::SIGALRM, "SIGALRM"),
        (libc::SIGSTKFLT, "SIGSTKFLT"),
        (libc::SIGXCPU, "SIGXCPU"),
        (libc::SIGVTALRM, "SIGVTALRM"),
        (libc::SIGPROF, "SIGPROF"),
        (libc::SIGIO, "SIGIO"),
        (libc::SIGPWR, "SIGPWR"),
        (libc::SIGSYS, "SIGSYS"),
    ];
    match (status.code(), status.signal()) {
        (Some(code), _) => code.to_string(),
        (None, Some(signal)) => NAMES
            .iter()
            .find(|n| n.0 == signal)
            .map_or_else(|| "SIGRTMIN".to_owned(), |n| n.1.to_owned()),
        (None, None) => "?".to_owned(),
    }
}

/// Returns the messages without the parts that differ between runs, and without those of the test's
/// own plugins.
fn plain(scratch: &Scratch, stderr: &str) -> String {
    let own = ["last words: ", "third run", "it does not return"];
    let own = |line: &&str| !own.iter().any(|o| line.starts_with(o)) && !line.ends_with(": ready");
    let folder = format!("{}/", scratch.path().display());
    let lines = stderr.lines().filter(own).map(|line| {
        // Line numbers in source files change.
        let (line, rest) = line.split_once(" (faulty/src").unwrap_or((line, ""));
        let rest = rest.split_once(')').map_or("", |r| r.1);
        let mut before = "";
        let of_recording = line.contains(": the recording stopped at ");
        let words = line.split(' ').map(|word| {
            let number = word.trim_end_matches([':', ';', ',']);
            // The size of a write depends on the computer's speed.
            let is_amount = of_recording && number.parse::<f64>().is_ok();
            let is_process = before == "process" && number.bytes().all(|b| b.is_ascii_digit());
            let is_address = number.starts_with("0x") && number.len() > 8;
            before = word;
            if is_process || is_address || is_amount {
                word.replace(number, "N")
            } else {
                word.to_owned()
            }
        });
        (words.collect::<Vec<_>>().join(" ") + rest).replace(&folder, "")
    });
    lines.collect::<Vec<_>>().join("<br>").replace('|', "\\|")
}

const HEAD: &str = "# How an instance ends

What becomes of an instance by the way in which its process ends, as `cargo test -p hal-tests --test system faults::ends` finds it. The
machine drives a port; `safe` says that a stop action put the port's register to its safe level before the process ended.
Both clocks come to the same unless a row says which. `SIGSEGV` and others in the column *status* say that the process
ended by that signal.

- *whole, with the safe levels*: the recording can be read and goes to the very end; the last that it shows is outputs
  as they go to their safe levels.
- *whole, to its last write*: it can be read; what was seen in the last half second may be missing.

| way | clock | outputs | recording | flight recorder's file | socket | status | what is said |
|---|---|---|---|---|---|---|---|
";

#[test]
fn every_way_to_end_comes_to_what_the_table_says() {
    let mut table = HEAD.to_owned();
    let wanted = std::env::var("CASE").unwrap_or_default();
    for (way, by) in WAYS.iter().filter(|w| w.0.contains(&wanted)) {
        let ends = [true, false].map(|virtually| end(*by, virtually));
        let [first, second] = &ends;
        let rows: &[(&str, &End)] = if first == second {
            &[("both", first)]
        } else {
            &[("virtual", first), ("real", second)]
        };
        for (clock, e) in rows {
            table += &format!(
                "| {way} | {clock} | {} | {} | {} | {} | {} | {} |\n",
                e.outputs, e.recording, e.flight, e.socket, e.status, e.said
            );
        }
    }
    if wanted.is_empty() {
        golden::check(&root().join("tests/ends/table.md"), &table);
    } else {
        println!("{table}");
    }
}

/// Reads a recording, which must consist of whole records. Returns its times in nanoseconds.
fn whole(scratch: &Scratch, name: &str) -> Vec<i64> {
    read(scratch, name).unwrap().unwrap().times().iter().collect()
}

#[test]
fn a_slow_recording_is_in_its_file_while_the_machine_runs() {
    let scratch = Scratch::new("recording");
    // With one change in 100 ms, it would take minutes to fill a buffer.
    let lines = "loadrt threads name1=t period1=100000000\nloadrt not\n\
                 net blink not.0.out => not.0.in\naddf not.0 t\nstart\n";
    scratch.write("m.hal", lines);
    let mut halrun = scratch.command(&[], "halrun");
    let running = scratch.start(halrun.args(["--record", "out.vcd", "m.hal"]));
    let samples = || {
        let text = std::fs::read_to_string(scratch.path().join("out.vcd")).unwrap_or_default();
        text.lines().filter(|l| l.starts_with('#')).count()
    };
    until("its changes are in the file", || samples() > 5);
    // All changes so far reach the file while the machine runs.
    let beats = scratch.halcmd(&["getp", "t.threadbeat"]).stdout.trim().parse::<usize>().unwrap();
    until("the changes so far are in the file", || samples() > beats);
    running.signal(Signal::KILL);
    running.wait();
    until("the watcher is done", || scratch.left().is_empty());
    let trace = read(&scratch, "out.vcd").unwrap().unwrap();
    let times: Vec<i64> = trace.times().iter().collect();
    let blink = trace.channels().get(trace.find("blink").unwrap()).unwrap();
    let values: Vec<_> = blink.changes().filter_map(|c| c.value).collect();
    // There is one change at each time, and each is the opposite of the previous one, so none is
    // lost. The intervals depend on the scheduler.
    assert!(values.len() > beats && values.len() == times.len(), "{beats}: {values:?}, {times:?}");
    let alternating = (0..values.len()).map(|n| Value::Bit(n % 2 == 1));
    assert!(values.iter().copied().eq(alternating), "{values:?}");
    assert!(times.windows(2).all(|t| t[0] < t[1]), "{times:?}");
}

/// The guard writes what the control thread does not come to write.
#[test]
fn a_recording_grows_while_a_command_does_not_return() {
    let scratch = Scratch::new("busy");
    let lines = "loadrt threads name1=t period1=10000000\nloadrt not\nloadrt quits how=hang \
                 where=command\nnet blink not.0.out => not.0.in\naddf not.0 t\nstart\nprint ready\n";
    scratch.write("m.hal", lines);
    let mut halrun = scratch.command(&[], "halrun");
    halrun.env("HAL_RTMOD_DIR", plugins());
    let running = scratch.start(halrun.args(["--simulate", "--record", "out.vcd", "m.hal"]));
    until("it runs", || running.said().1.contains("ready"));
    let client = scratch.start(scratch.command(&[], "halcmd").arg("quits.go"));
    until("the command runs", || running.said().1.contains("it does not return"));
    let size = || std::fs::metadata(scratch.path().join("out.vcd")).map_or(0, |m| m.len());
    for _ in 0..2 {
        let before = size();
        until("more is in the file", || size() > before);
    }
    running.signal(Signal::KILL);
    drop(client);
    running.wait();
    until("the watcher is done", || scratch.left().is_empty());
    assert!(whole(&scratch, "out.vcd").len() > 10);
}

#[test]
fn a_recording_that_is_written_as_fast_as_possible_is_whole_after_a_kill() {
    for kill in [Signal::KILL, Signal::SEGV, Signal::TERM] {
        let scratch = Scratch::new("killed");
        let lines = "loadrt threads name1=t period1=1000000\nloadrt not\n\
                     net blink not.0.out => not.0.in\naddf not.0 t\nstart\n";
        scratch.write("m.hal", lines);
        let mut halrun = scratch.command(&[], "halrun");
        let mut running = scratch.start(halrun.args(["--virtual", "--record", "out.vcd", "m.hal"]));
        let size = || std::fs::metadata(scratch.path().join("out.vcd")).map_or(0, |m| m.len());
        until("it is being written", || size() > 1 << 20);
        running.signal(kill);
        running.ended().unwrap();
        // After SIGKILL, the watcher truncates an incomplete record, then removes the socket.
        until("the watcher is done", || scratch.left().is_empty());
        let times = whole(&scratch, "out.vcd");
        let (first, last) = (times[0], *times.last().unwrap());
        assert!(times.len() > 50_000 && last - first >= 1_000_000 * 50_000, "{kill:?}");
    }
}

#[test]
fn a_signal_is_heeded_between_two_cycles_of_a_slow_function_on_the_virtual_clock() {
    let scratch = Scratch::new("slow");
    let lines = "loadrt threads name1=t period1=1000000\nloadrt quits how=slow\n\
                 addf quits.0 t\nstart\n";
    scratch.write("m.hal", lines);
    let mut halrun = scratch.command(&[], "halrun");
    halrun.env("HAL_RTMOD_DIR", plugins());
    let running = scratch.start(halrun.args(["--virtual", "m.hal"]));
    let runs = |text: &str| text.lines().filter(|l| l.starts_with("run ")).count();
    until("it runs", || runs(&running.said().1) > 3);
    let before = runs(&running.said().1);
    running.signal(Signal::TERM);
    let output = running.wait();
    assert_eq!(output.status, Some(0), "{}", output.stderr);
    // One cycle was in progress, and one began while the signal was being delivered.
    let after = runs(&output.stderr);
    assert!(after <= before + 2, "{before} runs before the signal, {after} in all");
}

/// The instance's own code may wait for another process.
#[test]
fn a_signal_is_heeded_while_a_script_waits_for_a_pipe() {
    let scratch = Scratch::new("pipe");
    let lines = "loadrt threads name1=t period1=1000000\nloadrt hal_parport cfg=\"0x378 out\"\n\
                 loadrt last_words\nnet register parport.0.sim.data last-words.0.in\n\
                 setp parport.0.pin-02-out 1\naddf parport.0.write t\naddf last-words.0 t\n\
                 start\nrun 10ms\nprint waiting\nsource /dev/fd/3\n";
    scratch.write("m.hal", lines);
    let made = scratch.run(scratch.command(&[], "mkfifo").arg("pipe"));
    assert_eq!(made.status, Some(0), "{}", made.stderr);
    // A pipe that the shell has opened, as `halcmd -f <(…)` passes it, and that nothing fills.
    let mut shell = scratch.command(&[], "bash");
    shell.env("HAL_RTMOD_DIR", plugins()).env("HALRUN", programs().join("halrun"));
    let running =
        scratch.start(shell.args(["-c", "exec 3<>pipe; exec \"$HALRUN\" --virtual m.hal"]));
    until("it waits", || running.said().1.contains("waiting"));
    running.signal(Signal::TERM);
    let output = running.wait();
    let said = "SIGTERM, but this does not return: the control thread waits for something outside";
    assert!(output.stderr.contains(said), "{}", output.stderr);
    assert!(output.stderr.contains("last words: it was 1 and is 0\n"), "{}", output.stderr);
    assert_eq!(output.status, Some(1));
    assert!(scratch.left().is_empty());
}

/// `-i` gives a script the INI file, whose time holds for it.
#[test]
fn outputs_are_safe_after_the_time_of_the_ini_file_and_halrun_u_reports_it() {
    let scratch = Scratch::new("time");
    let lines = "loadrt threads name1=t period1=1000000\nloadrt hal_parport cfg=\"0x378 out\"\n\
                 loadrt last_words\nnet register parport.0.sim.data last-words.0.in\n\
                 setp parport.0.pin-02-out 1\naddf parport.0.write t\naddf last-words.0 t\n\
                 loadrt quits how=hang\naddf quits.0 t\nstart\n";
    scratch.write("m.hal", lines);
    scratch.write("m.ini", "[HAL]\nSTUCK_TIME = 70ms\n");
    let mut halrun = scratch.command(&[], "halrun");
    halrun.env("HAL_RTMOD_DIR", plugins()).env_remove("HAL_STUCK_TIME");
    let running = scratch.start(halrun.args(["--simulate", "-i", "m.ini", "m.hal"]));
    until("it is stuck", || running.said().1.contains("failed in thread"));
    let fault = "function 'quits.0' of component 'quits' failed in thread 't': it did not come back \
                 within 70 ms; all threads are stopped and outputs are at their safe levels";
    assert!(running.said().1.contains(fault), "{}", running.said().1);
    let stopped = scratch.halrun(&["-U"]);
    let said = "halrun: instance 'default' had a fault: function 'quits.0' of component 'quits' in \
                thread 't': it did not come back within 70 ms\n";
    assert_eq!((stopped.status, stopped.stderr.as_str()), (Some(1), said));
    let output = running.wait();
    assert!(output.stderr.contains("last words: it was 1 and is 0\n"), "{}", output.stderr);
    assert_eq!(output.status, Some(1));
}

#[test]
fn the_programs_of_an_instance_end_with_it() {
    for signal in [Signal::TERM, Signal::SEGV, Signal::KILL] {
        let scratch = Scratch::new("programs");
        scratch.write("program.sh", "echo $$ > pid.part\nmv pid.part pid\nexec sleep 1000\n");
        scratch.write(
            "m.hal",
            "loadrt threads name1=t period1=1000000\nloadusr sh program.sh\nstart\n",
        );
        let mut halrun = scratch.command(&[], "halrun");
        let running = scratch.start(halrun.args(["--simulate", "m.hal"]));
        let pid = || std::fs::read_to_string(scratch.path().join("pid")).unwrap_or_default();
        until("the program runs", || !pid().is_empty());
        running.signal(signal);
        running.wait();
        // One that has ended and whose parent has not asked has no words.
        let words = || std::fs::read(format!("/proc/{}/cmdline", pid().trim())).unwrap_or_default();
        until("the program has ended", || words().is_empty());
    }
}

/// Prints the milliseconds from a signal until outputs are at their safe levels, in each state of
/// the instance: in a row of ten for SIGTERM and for SIGINT, taken in turn.
#[test]
#[ignore = "prints times, which depend on the machine; the other tests here judge the outputs: cargo test -p hal-tests --test system faults::ends -- --ignored --nocapture"]
fn how_soon_outputs_are_safe() {
    let states = [
        ("idle", By::Signal(Signal::TERM)),
        ("a function sleeps", Stuck("hang", "function")),
        ("a function runs in circles", Stuck("spin", "function")),
        ("a component is created", Stuck("hang", "create")),
        ("a component opens its device", Stuck("spin", "open")),
        ("a background task runs", Stuck("hang", "task")),
        ("a command runs", Stuck("hang", "command")),
        ("a stop action does not return", Stuck("hang", "stop")),
    ];
    for (state, by) in states {
        for virtually in [true, false] {
            let clock = if virtually { "virtual" } else { "real" };
            let signals = [("SIGTERM", Signal::TERM), ("SIGINT", Signal::INT)];
            let mut times = [Vec::new(), Vec::new()];
            for _ in 0..10 {
                for ((_, signal), times) in signals.iter().zip(&mut times) {
                    times.push(until_safe(by, *signal, virtually));
                }
            }
            for ((name, _), times) in signals.iter().zip(&mut times) {
                times.sort_unstable();
                let (median, longest) = (times[5], times[9]);
                println!(
                    "{state}, {clock} clock, {name}: median {median} ms, longest {longest} ms"
                );
            }
        }
    }
}

fn until_safe(by: By, signal: Signal, virtually: bool) -> u128 {
    let scratch = Scratch::new("soon");
    let mut running = start(&scratch, by, virtually);
    let client = wait_until_up(&scratch, &mut running, by, virtually);
    let sent = now_ns();
    running.signal(signal);
    while !running.said().1.contains("last words: it was 1 and is 0\n") {
        std::thread::yield_now();
    }
    let passed = now_ns() - sent;
    running.ended().unwrap();
    drop(client);
    passed / 1_000_000
}

fn now_ns() -> u128 {
    let t = rustix::time::clock_gettime(rustix::time::ClockId::Monotonic);
    u128::try_from(t.tv_sec).unwrap() * 1_000_000_000 + u128::try_from(t.tv_nsec).unwrap()
}
