//! The result of `order` agrees with what the machine does. `UPDATE_EXPECT=1` writes the expected output.
#![expect(clippy::unwrap_used, clippy::panic, reason = "tests")]

use hal_protocol::{DelayInfo, OrderInfo, Reply};
use hal_tests::{golden, programs::root, scratch::Scratch, vcd::Vcd};

fn folder() -> Scratch {
    Scratch::copy_of(&root().join("tests/order"))
}

/// Returns the output of halcmd.
fn halcmd(scratch: &Scratch, words: &[&str]) -> String {
    let output = scratch.halcmd(words);
    assert_eq!((output.stderr.as_str(), output.status), ("", Some(0)), "{words:?}");
    output.stdout
}

fn expect(name: &str, text: &str) {
    golden::check(&root().join("tests/order").join(name), text);
}

/// Runs these scripts one after the other and records their signals.
fn waves(scratch: &Scratch, files: &[&str]) -> Vcd {
    let lines: String = files.iter().map(|f| format!("source {f}\n")).collect();
    scratch.write("run.hal", format!("{lines}record waves\nstart\n"));
    let output = scratch.halrun(&["--virtual", "--for", "300ms", "-f", "run.hal"]);
    assert_eq!((output.stderr.as_str(), output.status), ("", Some(0)));
    Vcd::parse(&scratch.read("waves"))
}

/// Returns the delay between two signals, for each change.
fn delays(vcd: &Vcd, from: &str, to: &str) -> Vec<i64> {
    let edges = |name: &str| -> Vec<i64> {
        // The first change comes from the first cycle, before which nothing was computed.
        vcd.of(name).iter().map(|(t, _)| *t).filter(|t| *t > 20_000_000).collect()
    };
    let pairs = edges(from).into_iter().zip(edges(to));
    pairs.map(|(a, b)| b - a).collect()
}

/// Returns the `order` reply itself.
fn info(scratch: &Scratch, file: &str) -> OrderInfo {
    let json = halcmd(scratch, &["--json", "order", file]);
    let Reply::Order(info) = serde_json::from_str(&json).unwrap() else { panic!("{json}") };
    *info
}

/// Checks that the measured delay of a signal stays between the stated minimum and maximum.
fn is_as_said(vcd: &Vcd, from: &str, to: &str, said: DelayInfo) {
    let delays = delays(vcd, from, to);
    let found = (*delays.iter().min().unwrap(), *delays.iter().max().unwrap());
    let said = (said.least.cast_signed(), said.most.cast_signed());
    assert_eq!(found, said, "{from} to {to}: {delays:?}");
}

#[test]
fn the_better_order_takes_the_delay_away() {
    let scratch = folder();
    expect("chain.expected", &halcmd(&scratch, &["order", "chain.hal"]));
    let script = halcmd(&scratch, &["order", "--script", "chain.hal"]);
    expect("chain.script", &script);
    scratch.write("better.hal", &script);
    let before = waves(&scratch, &["chain.hal"]);
    let after = waves(&scratch, &["chain.hal", "better.hal"]);

    let lost = delays(&before, "in", "out");
    assert!(lost.len() > 8 && lost.iter().all(|d| *d == 4_000_000), "{lost:?}");
    let lost = delays(&after, "in", "out");
    assert!(lost.len() > 8 && lost.iter().all(|d| *d == 0), "{lost:?}");
    let paths = info(&scratch, "chain.hal").paths;
    assert_eq!((paths.len(), paths[0].slowest.is_some()), (1, false));
    is_as_said(&before, "in", "out", paths[0].quickest.delay);
    is_as_said(&after, "in", "out", paths[0].quickest.better);

    let lines = ["in", "a", "b", "c", "out"];
    let mut text = String::from("# Microseconds.\n");
    for (title, vcd) in [("as added", &before), ("better", &after)] {
        let rise = vcd.rises("in")[2];
        text.push_str(&format!("\n{title}\n"));
        text.push_str(&vcd.drawing(&lines, rise - 1_000_000, rise + 40_000_000));
    }
    expect("chain.waves", &text);
    // The better order leaves nothing to report.
    scratch.write("both.hal", scratch.read("chain.hal") + &script);
    let text = halcmd(&scratch, &["order", "both.hal"]);
    assert!(text.contains("Nothing is read a cycle late"), "{text}");
    assert!(text.contains("siggen.0.update to last: no delay"), "{text}");
}

#[test]
fn values_cross_threads_in_the_time_that_is_said() {
    let scratch = folder();
    expect("threads.expected", &halcmd(&scratch, &["order", "threads.hal"]));
    let waves = waves(&scratch, &["threads.hal"]);
    let info = info(&scratch, "threads.hal");
    is_as_said(&waves, "in", "back", info.paths[0].quickest.delay);
    let [there, back] = info.crossings.as_slice() else { panic!("{:?}", info.crossings) };
    assert_eq!((there.by[0].as_str(), back.by[0].as_str()), ("there", "in"));
    // Changes from the slow thread do not start at every moment.
    let delays = delays(&waves, "there", "back");
    let said = there.delay.least.cast_signed()..=there.delay.most.cast_signed();
    assert!(delays.len() > 8 && delays.iter().all(|d| said.contains(d)), "{delays:?}");
    is_as_said(&waves, "in", "there", back.delay);
}

#[test]
fn the_printer_reads_well() {
    let scratch = Scratch::copy_of(&root().join("configs/printer"));
    expect("printer.expected", &halcmd(&scratch, &["order", "printer.ini"]));
    let script = halcmd(&scratch, &["order", "--script", "printer.ini"]);
    assert_eq!(script, "# No other order is better.\n");
}

#[test]
fn the_running_machine_has_its_order_as_well() {
    let scratch = folder();
    let script = scratch.read("chain.hal");
    scratch.write("asked.hal", format!("{script}order\norder --script\n"));
    let output = scratch.halrun(&["--virtual", "-f", "asked.hal"]);
    let asked = halcmd(&scratch, &["order", "chain.hal"]).replace("chain.hal", "asked.hal");
    let lines = halcmd(&scratch, &["order", "--script", "chain.hal"]);
    assert_eq!(output.stdout, asked + &lines);
}

#[test]
fn what_is_wrong_with_the_files_is_said() {
    let scratch = folder();
    scratch.write("bad.hal", "loadrt threads\nlodrt siggen\naddf nothing thread1\n");
    let output = scratch.halcmd(&["order", "bad.hal"]);
    assert_eq!(output.status, Some(1));
    assert_eq!(output.stdout, "No thread runs a function.\n");
    assert!(output.stderr.contains("bad.hal:2: "), "{}", output.stderr);
    assert!(output.stderr.contains("bad.hal:3: "), "{}", output.stderr);
    let output = scratch.halcmd(&["order", "missing.hal"]);
    assert_eq!((output.status, output.stdout.as_str()), (Some(1), ""));
    assert!(output.stderr.contains("missing.hal"), "{}", output.stderr);
}
