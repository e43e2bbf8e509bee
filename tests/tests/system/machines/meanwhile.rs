//! Jobs while their files change or the disk is full, and the progress that a person sees.
#![expect(clippy::unwrap_used, reason = "tests")]

use hal_tests::{programs::root, scratch::Scratch, terminal::Terminal};
use std::{
    fs::{Permissions, set_permissions},
    os::unix::fs::{PermissionsExt, symlink},
};

/// Returns the printer with a program, and with `M101`, which runs this script.
fn printer(part: &str, script: &str) -> Scratch {
    let scratch = Scratch::copy_of(&root().join("configs/printer"));
    let ini: Vec<String> = scratch
        .read("printer.ini")
        .lines()
        .map(|l| if l.starts_with("PROGRAM_PREFIX") { "PROGRAM_PREFIX = ." } else { l })
        .map(|l| format!("{l}\n"))
        .collect();
    scratch.write("printer.ini", ini.concat());
    scratch.write("part.ngc", part);
    scratch.write("M101", format!("#!/bin/sh\n{script}\n"));
    set_permissions(scratch.path().join("M101"), Permissions::from_mode(0o755)).unwrap();
    scratch
}

/// Files that `M101` changes while the program runs: the program, how the job ends, and a file with its text afterwards.
#[test]
fn a_file_that_is_edited_while_its_job_runs_is_never_mixed_with_the_old_one() {
    // More than the interpreter keeps of the file.
    let far = "(a comment that only fills the file, so that its end is read behind the edit)\n";
    let long = format!("G21 G90\nG0 X1\nM101\n{}G0 X9\nM2\n", far.repeat(2000));
    let edited = "T1 P1 Z7\n";
    let edit_table = format!("printf '{}' > tool.tbl", edited.replace('\n', "\\n"));
    for (program, script, status, said, file, text) in [
        (long.as_str(), "true", 0, "part.ngc: ended after ", "part.ngc", "G0 X9\nM2\n"),
        (
            &long,
            "echo 'G0 X99' >> part.ngc",
            1,
            "it has changed since it was opened",
            "part.ngc",
            "M2\nG0 X99\n",
        ),
        (
            "G21 G90\nM101\nG10 L1 P1 Z5\nG0 X1\nM2\n",
            &edit_table,
            1,
            "tool.tbl: the tool table has changed since it was read: G10 L0 reads it again",
            "tool.tbl",
            edited,
        ),
        (
            "G21 G90\nM101\nG10 L0\nG0 X1\nM2\n",
            &edit_table,
            0,
            "part.ngc: ended after ",
            "tool.tbl",
            edited,
        ),
    ] {
        let scratch = printer(program, script);
        let output = scratch.halrun(&["--virtual", "--run", "part.ngc", "printer.ini"]);
        assert_eq!(output.status, Some(status), "{script}: {}", output.stderr);
        assert!(output.stderr.contains(said), "{script}: no {said:?} in {}", output.stderr);
        let left = scratch.read(file);
        assert!(left.ends_with(text), "{script}: {file}: {}", &left[left.len().min(200)..]);
    }
}

#[test]
fn a_disk_that_is_full_costs_the_journal_and_not_the_part() {
    let scratch = printer("G21 G90\nG0 X5\nG1 X9 F600\nM2\n", "true");
    symlink("/dev/full", scratch.path().join("printer.journal")).unwrap();
    let output = scratch.halrun(&["--virtual", "--run", "part.ngc", "printer.ini"]);
    assert_eq!(output.status, Some(0), "{}", output.stderr);
    let why = "printer.journal: No space left on device: the job goes on without a journal";
    assert!(output.stderr.contains(why), "{}", output.stderr);
    // Nothing that looks like a journal is left for the next start.
    let resumed = scratch.halrun(&["--virtual", "--resume", "--yes", "printer.ini"]);
    assert_eq!(resumed.status, Some(1));
    assert!(resumed.stderr.contains("printer.journal: No such file"), "{}", resumed.stderr);
}

/// Returns the words between two texts.
fn between<'a>(text: &'a str, before: &str, behind: &str) -> Option<&'a str> {
    Some(text.split_once(before)?.1.split_once(behind)?.0)
}

#[test]
fn a_person_sees_the_line_the_feed_and_the_time_that_is_left() {
    let scratch = printer("G21 G90 G61\nG0 X5\nG1 X35 F300\nG1 X5\nM2\n", "true");
    let terminal =
        Terminal::start(&scratch, "halrun", &["--virtual", "--run", "part.ngc", "printer.ini"]);
    let (status, _, shown) = terminal.end();
    assert_eq!(status, Some(0), "{shown}");
    let number = |text: Option<&str>| text.and_then(|t| t.parse::<f64>().ok());
    // Each replaces the one before: line, machine time, speed, and time left.
    let rows: Vec<(f64, f64, f64, Option<f64>)> = shown
        .split("\r\x1b[K")
        .filter_map(|row| {
            Some((
                number(between(row, "part.ngc: line ", ", "))?,
                number(row.split(", ").nth(1)?.strip_suffix(" s"))?,
                number(row.split(", ").nth(2)?.strip_suffix(" units/s"))?,
                number(between(row, "about ", " s left")),
            ))
        })
        .collect();
    assert!(shown.contains("\r\x1b[Kpart.ngc: ended after "), "{shown}");
    for line in [3.0, 4.0] {
        let there: Vec<_> = rows.iter().filter(|(at, ..)| *at == line).collect();
        assert!(there.len() > 40, "line {line} takes six seconds: {shown}");
        let steady = there.iter().filter(|(_, _, speed, _)| (speed - 5.0).abs() < 1e-3).count();
        assert!(steady > 40, "300 mm per minute: {shown}");
    }
    assert!(rows.windows(2).all(|w| w[0].1 <= w[1].1), "machine time falls: {shown}");
    let end = rows.last().unwrap().1;
    for (line, time, _, left) in rows.iter().filter(|(line, ..)| *line > 2.0) {
        let left = left.unwrap_or(-1.0);
        assert!((left - (end - time)).abs() < 0.6, "line {line} at {time} s: {left}: {shown}");
    }
}
