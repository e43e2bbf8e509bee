//! Times of jobs, which depend on the computer: they are printed, not judged.
//!
//! ```text
//! cargo test -p hal-tests --release --test system machines::speed -- --ignored --nocapture
//! ```
#![expect(
    clippy::unwrap_used,
    clippy::indexing_slicing,
    clippy::print_stdout,
    reason = "a benchmark prints"
)]

use hal_tests::{programs::root, scratch::Scratch};
use std::{
    fmt::Write as _,
    fs::File,
    io::{BufWriter, Write as _},
};

/// The mill's motion in a servo thread alone: motors that are where they shall be.
const SERVO: &str = "\
loadrt trivkins coordinates=XYZ
loadrt motmod servo_period_nsec=[EMCMOT]SERVO_PERIOD num_joints=[KINS]JOINTS
addf motion-command-handler servo-thread
addf motion-controller servo-thread
net x joint.0.motor-pos-cmd => joint.0.motor-pos-fb
net y joint.1.motor-pos-cmd => joint.1.motor-pos-fb
net z joint.2.motor-pos-cmd => joint.2.motor-pos-fb
net estop iocontrol.0.user-enable-out => iocontrol.0.emc-enable-in
";

/// Returns the mill without its base thread, and with a task.
fn mill() -> Scratch {
    let scratch = Scratch::copy_of(&root().join("configs/mill"));
    let ini = scratch.read("mill.ini").replace("mill.hal", "servo.hal");
    let mut ini: String =
        ini.lines().filter(|l| !l.starts_with("BASE_PERIOD")).map(|l| format!("{l}\n")).collect();
    ini.push_str("\n[TASK]\nTASK = milltask\n");
    scratch.write("mill.ini", ini);
    scratch.write("servo.hal", SERVO);
    scratch
}

/// Returns processor time of the programs that have ended, in seconds.
fn used() -> f64 {
    let stat = std::fs::read_to_string("/proc/self/stat").unwrap();
    let fields: Vec<&str> = stat.rsplit(')').next().unwrap().split_whitespace().collect();
    // Fields 16 and 17 of proc(5), in hundredths of a second.
    fields[13..15].iter().map(|f| f.parse::<f64>().unwrap()).sum::<f64>() / 100.0
}

fn now() -> f64 {
    let t = rustix::time::clock_gettime(rustix::time::ClockId::Monotonic);
    t.tv_sec as f64 + t.tv_nsec as f64 * 1e-9
}

/// Runs and prints machine time, processor time and elapsed time.
fn timed(what: &str, scratch: &Scratch, words: &[&str]) -> String {
    let (before, began) = (used(), now());
    let output = scratch.halrun(words);
    assert_eq!(output.status, Some(0), "{}", output.stderr);
    println!("{what}: {:.1} s of the processor, {:.1} s elapsed", used() - before, now() - began);
    output.stderr
}

/// Writes rows of lines of a millimetre over the mill's table.
fn wavy(lines: u32) -> String {
    let mut text = "G21 G90 G64 P0.05 F1000\nG0 Z1\n".to_owned();
    for n in 0..lines {
        let (row, column) = (n / 290, f64::from(n % 290));
        let x = if row % 2 == 0 { column } else { 290.0 - column };
        let y = f64::from(row % 190) + 0.5 * (x / 5.0).sin() + 0.5;
        writeln!(text, "G1 X{x} Y{y:.4} Z{:.4}", 0.3 * (x / 7.0).cos() - 1.0).unwrap();
    }
    text + "M2\n"
}

#[test]
#[ignore = "prints times, which depend on the computer: cargo test -p hal-tests --release --test system machines::speed -- --ignored --nocapture"]
fn an_hour_of_the_mill_and_a_minute_of_the_printer() {
    let scratch = mill();
    scratch.write("hour.ngc", wavy(60_000));
    // The first start builds the programs, which is no time of theirs.
    assert_eq!(scratch.halrun(&["--version"]).status, Some(0));
    let said = timed(
        "an hour of the mill, 60,000 lines",
        &scratch,
        &["--virtual", "--run", "hour.ngc", "mill.ini"],
    );
    let time = said.split("ended after ").nth(1).and_then(|t| t.split(' ').next()).unwrap();
    assert!(time.parse::<f64>().unwrap() >= 3600.0, "{said}");
    timed("an hour of the mill at rest", &scratch, &["--virtual", "--for", "3600s", "mill.ini"]);
    let printer = Scratch::copy_of(&root().join("configs/printer"));
    timed(
        "a minute of the printer, with its base thread",
        &printer,
        &["--virtual", "--for", "60s", "printer.ini"],
    );
}

#[test]
#[ignore = "prints times, which depend on the computer: cargo test -p hal-tests --release --test system machines::speed -- --ignored --nocapture"]
fn from_the_command_to_the_first_motion_of_a_large_file() {
    let scratch = mill();
    let mut file = BufWriter::new(File::create(scratch.path().join("large.ngc")).unwrap());
    let body = wavy(60_000);
    let (lines, mut bytes) = (body.strip_suffix("M2\n").unwrap(), 0);
    while bytes < 100_000_000 {
        file.write_all(lines.as_bytes()).unwrap();
        bytes += lines.len();
    }
    file.write_all(b"M2\n").unwrap();
    file.flush().unwrap();
    let mut halrun = scratch.command(&[], "halrun");
    let running = scratch.start(halrun.args(["--headless", "mill.ini"]));
    let good = |words: &[&str]| {
        let output = scratch.halcmd(words);
        (output.status == Some(0)).then_some(output.stdout)
    };
    hal_tests::scratch::until("the machine is up", || {
        good(&["task.estop-reset", "--wait"]).is_some()
    });
    for words in [
        &["task.on", "--wait"][..],
        &["task.home", "joint=all", "--wait"],
        &["task.mode", "mode=auto", "--wait"],
    ] {
        assert!(good(words).is_some(), "{words:?}: {}", running.said().1);
    }
    let place = || good(&["getp", "joint.2.motor-pos-cmd"]).unwrap();
    let before = place();
    let began = now();
    assert!(good(&["task.open", "file=large.ngc", "--wait"]).is_some());
    let opened = now();
    assert!(good(&["task.run"]).is_some());
    let ran = now();
    while place() == before {
        std::thread::yield_now();
    }
    println!(
        "a file of {} MB: open {:.3} s, run {:.3} s, first motion {:.3} s after the begin of run",
        bytes / 1_000_000,
        opened - began,
        ran - opened,
        now() - opened
    );
    assert!(good(&["task.abort", "--wait"]).is_some());
    running.signal(rustix::process::Signal::TERM);
    running.wait();
}
