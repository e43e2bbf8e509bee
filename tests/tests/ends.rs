//! How an instance ends: what becomes of its outputs, recordings, socket and status.
#![expect(clippy::unwrap_used, reason = "tests")]

use hal_tests::scratch::{Scratch, until};
use hal_trace::Format;
use rustix::process::Signal;

/// A recording that a test may find cut off: its times in nanoseconds; it must be whole.
fn whole(scratch: &Scratch, name: &str) -> Vec<i64> {
    let path = scratch.path().join(name);
    let reading = Format::of(&path).unwrap().read(&std::fs::read(&path).unwrap());
    assert!(reading.flaw.is_none(), "{name}: {:?}", reading.flaw);
    reading.trace.times().iter().collect()
}

#[test]
fn a_slow_recording_is_in_its_file_while_the_machine_runs() {
    let scratch = Scratch::new("recording");
    // One change in 100 ms: it would take minutes to fill a buffer.
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
    running.signal(Signal::KILL);
    running.wait();
    let times = whole(&scratch, "out.vcd");
    assert!(times.windows(2).all(|t| t[1] - t[0] >= 100_000_000), "{times:?}");
}
