//! `halcmd check`: it finds each planted fault at its position, and reports nothing on correct machines.
#![expect(clippy::unwrap_used, reason = "tests")]

use hal_protocol::{Code, Level};
use hal_tests::{
    faults::{Planted, mistakes},
    foreign::{compile, component},
    golden,
    mutations::{files_of, machines},
    programs::root,
    scratch::{Output, Scratch},
    tools::{Tool, tclsh},
};
use halcmd::manual::explain;
use std::{
    fmt::Write,
    path::{Path, PathBuf},
};

/// Runs a function for each item, several at once; panics with the list of all failures.
fn all<T: Sync>(items: &[T], look: impl Fn(&T) -> Vec<String> + Sync) {
    let lanes = 4;
    let wrong: Vec<String> = std::thread::scope(|scope| {
        let lanes: Vec<_> = (0..lanes)
            .map(|lane| {
                let look = &look;
                scope.spawn(move || {
                    items.iter().skip(lane).step_by(lanes).flat_map(look).collect::<Vec<_>>()
                })
            })
            .collect();
        lanes.into_iter().flat_map(|lane| lane.join().unwrap()).collect()
    });
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn what_explain_shows_is_so() {
    let rows: Vec<_> = explain::rows().collect();
    assert_eq!(rows.len(), Code::ALL.len());
    let has_tcl = Tool::of("tclsh").or_skip(tclsh()).is_some();
    let rows: Vec<_> =
        rows.into_iter().filter(|row| has_tcl || row.code != Code::TclNotFollowed).collect();
    all(&rows, |row| mistakes(&format!("explain-{}", row.code), row.code, row.wrong, row.right));
}

/// A joint that is faster than its step generator's own limit, and one that is not.
#[test]
fn a_stepgen_slower_than_its_joint() {
    let machine = |maxvel: &str, mark: &str| {
        format!(
            "loadrt trivkins\n\
             loadrt motmod base_period_nsec=100000 servo_period_nsec=1000000 num_joints=1\n\
             loadrt stepgen step_type=0\n\
             addf stepgen.make-pulses base-thread\n\
             addf stepgen.capture-position servo-thread\n\
             addf motion-command-handler servo-thread\n\
             addf motion-controller servo-thread\n\
             addf stepgen.update-freq servo-thread\n\
             setp stepgen.0.position-scale 100\n\
             setp stepgen.0.maxaccel 1500\n\
             setp stepgen.0.maxvel {maxvel}\n\
             net xpos-cmd joint.0.motor-pos-cmd => stepgen.0.position-cmd\n\
             net xpos-fb joint.0.motor-pos-fb <= stepgen.0.position-fb\n\
             net xenable joint.0.amp-enable-out => stepgen.0.enable\n\
             net estop-loop iocontrol.0.user-enable-out => iocontrol.0.emc-enable-in\n\
             --- m.ini\n[EMCIO]\nCYCLE_TIME = 0.1\n[KINS]\nJOINTS = 1\n[TRAJ]\nLINEAR_UNITS = mm\n[HAL]\nHALFILE = m.hal\n\
             [JOINT_0]\nMAX_VELOCITY = 20\n{mark}MAX_ACCELERATION = 1000\n"
        )
    };
    let wrong = machine("19.9", "# <--\n");
    for right in ["0", "20", "25"].map(|maxvel| machine(maxvel, "")) {
        assert_eq!(mistakes("maxvel", Code::JointTooFast, &wrong, &right), [""; 0]);
    }
}

/// Compares with a golden file of `tests/check`.
fn golden(path: &str, got: &str) {
    golden::check(&root().join("tests/check").join(path), got);
}

/// Checks a machine in a home without folders of programs.
fn check_at_home(scratch: &Scratch, words: &[&str]) -> Output {
    let mut command = scratch.command(&[], "halcmd");
    scratch.run(command.arg("check").args(words).env("HOME", scratch.path()))
}

#[test]
fn annex_e_has_its_loose_ends_and_nothing_worse() {
    let scratch = Scratch::copy_of(&root().join("tests/check/annex-e"));
    let output = check_at_home(&scratch, &["-i", "impresora3D.ini", "annex-e.hal"]);
    assert_eq!((output.status, output.stderr.as_str()), (Some(0), ""));
    golden("annex-e/expected", &output.stdout);
    let of = |code: Code| {
        let mark = format!("[{code}]: ");
        let lines = output.stdout.lines().filter(|l| l.contains(&mark));
        let subject = |l: &str| l.split('\'').nth(1).unwrap_or_default().to_owned();
        lines.map(subject).collect::<Vec<_>>().join(" ")
    };
    assert_eq!(of(Code::NoReader), "spindle-cmd spindle-cw spindle-ccw ystep ydir zstep zdir");
    assert_eq!(of(Code::NoWriter), "min-x max-x min-y max-y");
    assert_eq!(of(Code::Unfed), "viagpio.pin-07-out viagpio.pin-08-out");
    assert_eq!(of(Code::DoubleStep), "viagpio.pin-06-out");
}

#[test]
fn a_card_has_one_note_about_its_free_outputs() {
    let scratch = Scratch::copy_of(&root().join("tests/check/card"));
    for (file, expected) in [("card.hal", "card/expected"), ("one.hal", "card/expected-one")] {
        let output = check_at_home(&scratch, &["--all", file]);
        assert_eq!((output.status, output.stderr.as_str()), (Some(0), ""));
        golden(expected, &output.stdout);
    }
}

#[test]
fn the_annex_as_printed_is_wrong_where_its_lines_are_broken() {
    let scratch = Scratch::copy_of(&root().join("tests/check/annex-e"));
    let output = check_at_home(&scratch, &["-i", "impresora3D.ini", "printed.hal"]);
    assert_eq!(output.status, Some(2));
    golden("annex-e/expected-printed", &output.stdout);
}

/// Checks each file of a folder of `tests/check`, whose first lines describe it. Returns the errors and warnings of all of
/// them, with their remedies if asked.
fn checked(folder: &str, with_remedies: bool) -> String {
    let folder = root().join("tests/check").join(folder);
    let files = std::fs::read_dir(&folder).unwrap().map(|file| file.unwrap().path());
    let mut files: Vec<_> = files.filter(|f| f.extension().is_some_and(|e| e == "hal")).collect();
    files.sort();
    let mut got = String::new();
    for file in files {
        let text = std::fs::read_to_string(&file).unwrap();
        let name = file.file_stem().unwrap().to_string_lossy();
        let (_, found) = Planted::parse(&text).check(&format!("check-{name}"));
        let shows = text.lines().next().unwrap_or_default().trim_start_matches("# ");
        writeln!(got, "{name}: {shows}").unwrap();
        for f in found.iter().filter(|f| f.level > Level::Note) {
            let at = f.at.as_ref().map_or(0, |at| at.line);
            writeln!(got, "    {}: {at}: {}", f.code, f.text).unwrap();
            if with_remedies {
                writeln!(got, "        do: {}", f.remedy).unwrap();
            }
        }
    }
    got
}

#[test]
fn the_wiring_of_an_estop() {
    let scratch = Scratch::new("estop");
    if compile(scratch.path(), "some", &component("", "", ""), &[]).is_none() {
        return;
    }
    golden("estop/expected", &checked("estop", false));
}

#[test]
fn remedies_name_what_ends_the_fault() {
    golden("remedies/expected", &checked("remedies", true));
}

#[test]
fn the_machines_of_the_project_have_no_warning() {
    let machines = machines();
    all(&machines, |machine| {
        let scratch = Scratch::new("clean");
        let output = scratch.halcmd(&["check", &machine.display().to_string()]);
        let clean = output.status == Some(0);
        let name = machine.display();
        if clean { Vec::new() } else { vec![format!("{name}:\n{}", output.stdout)] }
    });
}

/// Function that a machine runs although nothing uses its pins.
const WITHOUT_USE: &str = "addf viagpio.read base-thread";

/// Returns the text of a machine's file, and of the files that it includes.
fn entries_of(machine: &Path) -> String {
    let text = std::fs::read_to_string(machine).unwrap();
    let included = text.lines().filter_map(|l| l.strip_prefix("#INCLUDE "));
    let included: String = included.map(|name| entries_of(&machine.with_file_name(name))).collect();
    text + &included
}

/// Each machine, once for each of its `addf` lines, without that line: an error or a warning.
#[test]
fn every_function_is_missed_when_it_is_not_added() {
    let mut without: Vec<(PathBuf, String, usize)> = Vec::new();
    for machine in machines() {
        let folder = machine.parent().unwrap();
        let is_ini = machine.extension().is_some_and(|e| e == "ini");
        let scripts = if is_ini { files_of(folder, "hal") } else { vec![machine.clone()] };
        let entries = entries_of(&machine);
        for script in scripts.iter().filter(|f| !f.ends_with("demo.hal")) {
            let text = std::fs::read_to_string(script).unwrap();
            let name = script.file_name().unwrap().to_string_lossy().into_owned();
            if is_ini && !entries.contains(&format!(" {name}\n")) {
                continue;
            }
            let lines = text.lines().enumerate();
            let added = lines.filter(|(_, l)| l.starts_with("addf ") && *l != WITHOUT_USE);
            without.extend(added.map(|(n, _)| (machine.clone(), name.clone(), n)));
        }
    }
    assert!(without.len() > 120, "only {} lines", without.len());
    all(&without, |(machine, script, line)| {
        let scratch = Scratch::copy_of(machine.parent().unwrap());
        let text = scratch.read(script);
        let without = |(n, l): (usize, &str)| if n == *line { String::new() } else { l.to_owned() };
        let kept: Vec<String> = text.lines().enumerate().map(without).collect();
        scratch.write(script, kept.join("\n"));
        let machine = machine.file_name().unwrap().to_str().unwrap();
        let output = scratch.halcmd(&["check", "--level", "warning", machine]);
        let missed = output.status.is_some_and(|s| s > 0);
        if missed {
            return Vec::new();
        }
        let gone = text.lines().nth(*line).unwrap_or_default();
        vec![format!("{machine} without '{gone}' in {script}: nothing to report")]
    });
}

#[test]
fn programs_read_what_comes_of_it() {
    let scratch = Scratch::new("sarif");
    scratch.write("m.hal", "loadrt or2\nnet x or2.0.in0\nnet x or2.0.ou\n");
    let output = scratch.halcmd(&["check", "--sarif", "m.hal"]);
    let log: serde_json::Value = serde_json::from_str(&output.stdout).unwrap();
    let results = log["runs"][0]["results"].as_array().unwrap();
    let shown: Vec<String> = results
        .iter()
        .map(|r| {
            let line = &r["locations"][0]["physicalLocation"]["region"]["startLine"];
            format!("{line} {}", r["ruleId"].as_str().unwrap_or_default())
        })
        .collect();
    assert_eq!(shown, ["1 H501", "2 H307", "3 H202"]);
    for (words, status) in [
        (&["check", "m.hal"][..], Some(2)),
        (&["check", "--level", "error", "m.hal"], Some(2)),
        (&["check", "--level", "high", "m.hal"], Some(255)),
        (&["check", "none.hal"], Some(2)),
        (&["explain", "H307", "h202"], Some(0)),
        (&["explain", "H000"], Some(255)),
    ] {
        assert_eq!(scratch.halcmd(words).status, status, "{words:?}");
    }
}
