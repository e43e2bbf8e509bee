//! The pictures of `configs`: each demonstration; direction and step of the printer's X at two speeds, to the right and to the
//! left; the steps of its axes in the finish of a part. `UPDATE_EXPECT=1` redraws them.
#![expect(clippy::unwrap_used, reason = "tests")]

use super::demos::machines;
use hal_tests::{golden, programs::root, scratch::Scratch};
use hal_trace::{Trace, load, measure::measure};
use std::{fmt::Write, fs, path::Path};

const PRINTER: &str = "configs/printer";
const TITLE: &str = "X of the printer at 50 mm/s and 80 mm/s, to the right and to the left";

/// Drives the printer as `configs/printer/scope.hal` does.
fn recorded() -> Scratch {
    let scratch = Scratch::copy_of(&root().join(PRINTER));
    let output = scratch.halrun(&["--virtual", "scope.ini"]);
    assert_eq!((output.stderr.as_str(), output.status), ("", Some(0)));
    scratch
}

fn trace(scratch: &Scratch) -> Trace {
    let (reading, flaw) = load(&scratch.path().join("scope.vcd")).unwrap();
    assert_eq!(flaw, None);
    reading.trace
}

/// Returns the changes of a channel: time and new level.
fn changes(trace: &Trace, name: &str) -> Vec<(i64, bool)> {
    let channel = &trace.channels().get(trace.find(name).unwrap()).unwrap();
    let change = |c: hal_trace::Change| {
        let is_high = c.value == Some(hal_protocol::Value::Bit(true));
        (trace.times().get(c.sample).unwrap(), is_high)
    };
    channel.changes().map(change).collect()
}

#[test]
fn steps_have_the_frequency_of_their_speed_and_the_direction_of_their_way() {
    let trace = trace(&recorded());
    let (step, dir) = (trace.find("xstep").unwrap(), changes(&trace, "xdir"));
    // Right is low, left is high; the initial level counts as a change.
    let levels: Vec<bool> = dir.iter().map(|(_, level)| *level).collect();
    assert_eq!(levels, [false, true, false, true]);
    let mut ends: Vec<i64> = dir.iter().skip(1).map(|(at, _)| *at).collect();
    ends.push(trace.times().last().unwrap());
    for (((begin, _), end), hertz) in dir.iter().zip(ends).zip([200.0, 320.0, 320.0, 200.0]) {
        // Far from acceleration and deceleration.
        let middle = begin + (end - begin) / 2;
        let m = measure(&trace, step, middle - 40_000_000, middle + 40_000_000);
        let found = m.frequency.unwrap();
        // Edges are aligned to base periods of 100 µs: over 80 ms that is an eighth of a percent.
        assert!((found / hertz - 1.0).abs() < 0.002, "{found} Hz, not {hertz}, around {middle}");
        assert!(m.rises > 10);
    }
    // No step coincides with an edge of the direction, nor lies within its set-up time.
    for (at, _) in dir.iter().skip(1) {
        let near = changes(&trace, "xstep").into_iter().filter(|(s, _)| (s - at).abs() < 100_000);
        assert_eq!(near.count(), 0, "a step beside the turn at {at}");
    }
}

#[test]
fn the_picture_is_as_it_was_drawn() {
    let scratch = recorded();
    for name in ["scope.svg", "scope.png"] {
        let words = ["--size", "1200x260", "--title", TITLE, "scope.vcd", "xdir", "xstep"];
        check_drawing(&scratch, PRINTER, name, &words);
    }
}

/// A row along X over the round back, five steps of Y to the next row, and the row back.
#[test]
fn the_picture_of_the_part_is_as_it_was_drawn() {
    let scratch = Scratch::copy_of(&root().join(PRINTER));
    let output = scratch.halrun(&["--virtual", "--run", "pedal.ngc", "pedal.ini"]);
    assert_eq!(output.status, Some(0), "{}", output.stderr);
    let title = "The pedal's finish: steps of X, Y and Z";
    let words = ["--size", "1200x420", "--from", "80s", "--to", "86s", "--title", title];
    check_drawing(
        &scratch,
        PRINTER,
        "pedal.svg",
        &[&words[..], &["pedal.vcd", "xstep", "ystep", "zstep"]].concat(),
    );
}

#[test]
fn each_demonstration_is_drawn() {
    for machine in machines() {
        let scratch = Scratch::copy_of(&machine.folder);
        machine.run_with(&scratch, &["--record", "demo.vcd"], &machine.demo());
        let picture = machine.picture();
        let mut words = vec!["--title", &machine.name, "demo.vcd"];
        words.extend(picture.iter().map(String::as_str));
        check_drawing(&scratch, &format!("configs/{}", machine.name), "demo.png", &words);
    }
}

#[test]
fn the_page_shows_each_demonstration() {
    if std::env::var_os("CASE").is_some() {
        return;
    }
    let mut new = String::from("\n");
    for machine in machines() {
        let (name, channels) = (&machine.name, machine.channels().join(", "));
        write!(
            new,
            "\n**{name}.** {}\n\n![{name}: {channels}]({name}/demo.png)\n",
            machine.purpose()
        )
        .unwrap();
    }
    new.push('\n');
    let page = root().join("configs/README.md");
    golden::check_part(&page, "<!-- pictures:begin -->", "<!-- pictures:end -->", &new);
}

/// Draws and compares with the picture in a folder of the project.
fn check_drawing(scratch: &Scratch, folder: &str, name: &str, words: &[&str]) {
    let mut halscope = scratch.command(&[], "halscope");
    halscope.args(["plot", "--output", name]).args(words);
    let output = scratch.run(&mut halscope);
    assert_eq!((output.stderr.as_str(), output.status), ("", Some(0)), "{name}");
    let drawn = fs::read(scratch.path().join(name)).unwrap();
    let kept = root().join(folder).join(name);
    if golden::is_update() {
        fs::write(&kept, &drawn).unwrap();
    }
    assert!(same(&drawn, &kept), "{} is drawn in another way", kept.display());
}

fn same(drawn: &[u8], kept: &Path) -> bool {
    fs::read(kept).is_ok_and(|kept| kept == drawn)
}
