//! Every message is produced by a case: LinuxCNC's messages (`tests/hal/reference.txt`), and those in the sources.
//! `tests/hal/MESSAGES.md` lists the case for each message; `UPDATE_EXPECT=1` writes it.
#![expect(clippy::unwrap_used, reason = "tests")]

use hal_tests::{case::cases, golden, programs::root};
use std::{collections::BTreeMap, fmt::Write, fs};

/// Messages that no script produces, and the tests that produce them instead.
const ELSEWHERE: &[(&str, &str)] = &[
    ("* '*' leads to '*', which *: it is not changed from afar", GUARDED),
    ("this is done at the machine, and not from afar", GUARDED),
    ("* is not supported", "halcmd/src/programs/halrun/refused.rs"),
    ("Ferrule's package for Tcl is not in '*'", TCL),
    ("Tcl files need tclsh, which is not installed", TCL),
    ("a signal ended tclsh", "tests/tcl/errors/expected"),
    ("loadrt *: '*' cannot be joined with '*' of *", "tests/tcl/refused/expected"),
    ("the file ended itself with status *", "tests/tcl/errors/expected"),
    ("this machine has no task, which runs programs", REFUSALS),
    ("Use 'help <command>' for more details about each command", "halcmd/src/manual/help.rs"),
    ("Waiting for component '*' to become ready.", "halcmd/src/session.rs"),
    ("*: built for major version * of the plugin contract, this engine has *", FAULTS),
    ("*: built for minor version * of the plugin contract, this engine has only *", FAULTS),
    ("*: built with panic=abort: a panic in it would end the machine's process", FAULTS),
    (
        "*: part of Ferrule *, and this instance runs *: restart the machine, which then uses *",
        PLUGIN_FILES,
    ),
    ("*: not a plugin: *", FAULTS),
    ("*: not a plugin: it is *, not a regular file", PLUGIN_FILES),
    ("*: not opened as root: * belongs to user *", PLUGIN_FILES),
    ("*: not opened as root: other users can change * (mode *)", PLUGIN_FILES),
    ("*: not opened: the instance is ending", PLUGIN_FILES),
    ("*: opened in a process of its own first, it *", PLUGIN_FILES),
    ("function '*' has failed: threads stay stopped", "tests/tests/system/faults/running.rs"),
    ("instance '*' is already running", REFUSALS),
    ("* belongs to user *, not to user *", FALSE_ENGINE),
    ("* can be written by other users (mode *)", FALSE_ENGINE),
    ("* is a symbolic link, which leads anywhere", FALSE_ENGINE),
    ("* is not a folder", FALSE_ENGINE),
    ("* is not a socket", FALSE_ENGINE),
    ("*: there is no such folder", FALSE_ENGINE),
    ("remove it, or *", FALSE_ENGINE),
    ("run 'chmod go-w *', or *", FALSE_ENGINE),
    ("the engine at * runs as user *, not as user *", FALSE_ENGINE),
    ("no command with ticket * is known", REFUSALS),
    ("stream '*' is in use by another program", "tests/tests/system/engine/rings.rs"),
    (
        "this change takes * stores at once; at most 256 are made while threads run",
        "tests/tests/system/faults/edits.rs",
    ),
    ("this client has not joined as a component", "tests/tests/system/faults/clients.rs"),
    ("thread '*' is stuck in its cycle, in function '*'", "tests/tests/system/faults/edits.rs"),
    (
        "no thread has begun a cycle: this computer gives them no time; try again when it is less busy",
        "a computer that runs no thread for ten seconds",
    ),
    (
        "*: there are * components already, and an instance has no more",
        "tests/tests/system/language/bad_files.rs",
    ),
    ("signal '*' is a port and cannot have I/O pin(s)", REFUSALS),
    ("signal '*' is a port and can only have one input pin", REFUSALS),
    ("there is no thread to sample in", SAMPLES),
    ("no pin to sample is named", SAMPLES),
    ("* channels at once; at most * are possible", SAMPLES),
    ("not enough memory for * samples of this kind: at most * fit", SAMPLES),
    ("this client has no sample *", SAMPLES),
    ("samples go to programs: ask for them on the socket", SAMPLES),
    ("worker '*' of component '*' does not return", WORKERS),
    ("worker '*' has failed: threads stay stopped", WORKERS),
    ("pages go to programs: ask for them on the socket", WORKERS),
    ("insufficient memory", "the machine's memory is used up"),
    ("* * loaded already, by component '*'", "two components offer the same service"),
    ("the engine's answer does not match the request", "never, or it is a defect"),
];
const TCL: &str = "tests/tests/system/language/tcl.rs";
const WORKERS: &str = "hal/engine/tests/it/workers.rs";
const SAMPLES: &str = "tests/tests/system/engine/samples.rs";
const GUARDED: &str = "tests/tests/system/panel/guarded.rs";
const FAULTS: &str = "tests/tests/system/faults/libraries.rs";
const PLUGIN_FILES: &str = "tests/tests/system/faults/plugin_files.rs";
const FALSE_ENGINE: &str = "tests/tests/system/faults/false_engine.rs";
const REFUSALS: &str = "tests/tests/system/language/refusals.rs";

/// Commands of LinuxCNC's scripts.
const COMMANDS: &str = "loadrt unloadrt loadusr waitusr unloadusr unload newsig delsig sets gets \
    stype setp getp ptype net linkps linksp unlinkp addf initf delf start stop show list save \
    status alias unalias lock unlock print echo unecho debug source help quit exit \
    setexact_for_test_suite_only";

/// Files that define sentences.
const SOURCES: &[&str] = &[
    "halcmd/src/error.rs",
    "hal/ini/src/error.rs",
    "hal/engine/src/error/text.rs",
    "hal/engine/src/error/hint.rs",
    "hal/engine/src/error/watch.rs",
    "hal/protocol/src/folder.rs",
    "hal/engine/src/error/plugin.rs",
];

/// Returns the output of every case, by name.
fn printed() -> BTreeMap<String, Vec<String>> {
    cases()
        .into_iter()
        .map(|case| {
            let text =
                fs::read_to_string(root().join("tests/hal").join(&case.name).join("expected"));
            (case.name, text.unwrap().lines().map(str::to_owned).collect())
        })
        .collect()
}

/// Returns whether a line contains this message; `*` matches anything.
fn says(line: &str, message: &str) -> bool {
    let mut parts = message.split('*');
    let first = parts.next().unwrap_or_default();
    line.match_indices(first).any(|(at, _)| {
        let mut rest = line.get(at + first.len()..).unwrap_or_default();
        parts.clone().all(|part| match rest.find(part) {
            Some(at) => {
                rest = rest.get(at + part.len()..).unwrap_or_default();
                true
            }
            None => false,
        })
    })
}

fn reference() -> Vec<(String, String)> {
    let text = fs::read_to_string(root().join("tests/hal/reference.txt")).unwrap();
    let rows = text.lines().filter(|l| !l.starts_with('#'));
    rows.map(|l| l.split_at(12)).map(|(s, m)| (s.trim().to_owned(), m.to_owned())).collect()
}

/// Returns the sentences in a file: the texts between its `Display` and its tests.
fn sentences(path: &str) -> Vec<String> {
    let text = fs::read_to_string(root().join(path)).unwrap();
    let text = text.split("#[cfg(test)]").next().unwrap();
    let text = text.split_once("fmt::Display for").map_or(text, |(_, after)| after);
    let mut found = Vec::new();
    for (at, _) in text.match_indices("write").chain(text.match_indices("format!(")) {
        let call: String = text.get(at..).unwrap().chars().take(400).collect();
        let Some(quoted) = call.split_once('"').map(|(_, rest)| rest) else { continue };
        let end = (1..quoted.len()).find(|n| {
            quoted.get(*n..).is_some_and(|rest| rest.starts_with('"'))
                && !quoted.get(..*n).is_some_and(|before| before.ends_with('\\'))
        });
        // Excludes a `write` that begins another word, or one without a text.
        let near = call.find('"').is_some_and(|q| {
            call.get(..q).is_some_and(|before| {
                !before.contains(';') && !before.contains("=>") && before.contains('(')
            })
        });
        if let (true, Some(text)) = (near, end.and_then(|end| quoted.get(..end))) {
            found.push(pattern(text));
        }
    }
    found.sort();
    found.dedup();
    found
}

/// Converts a text of the sources to a pattern: placeholders become `*`.
fn pattern(text: &str) -> String {
    let mut out = String::new();
    let mut rest = text.replace("\\n", " ");
    while let Some((before, after)) = rest.split_once('\\') {
        // A string literal that continues in the next line.
        let next = after.trim_start_matches('\n').trim_start();
        rest = format!("{before}{next}");
    }
    let mut rest = rest.as_str();
    while let Some((before, after)) = rest.split_once('{') {
        out.push_str(before);
        out.push('*');
        rest = after.split_once('}').map_or("", |(_, after)| after);
    }
    out + rest
}

#[test]
fn every_message_is_shown_by_a_case() {
    let printed = printed();
    let path = root().join("tests/hal/MESSAGES.md");
    let old = fs::read_to_string(&path).unwrap_or_default();
    let mut messages = reference();
    for source in SOURCES {
        let subject = source.split('/').next().unwrap().to_owned();
        let sentences = sentences(source);
        assert!(!sentences.is_empty(), "{source} has no sentences: where have they gone?");
        for sentence in sentences {
            // A pattern with hardly any text of its own would match anything.
            if sentence.chars().filter(|c| c.is_alphabetic()).count() > 3 {
                messages.push((subject.clone(), sentence));
            }
        }
    }
    let mut table = String::from(
        "# Messages\n\nWhich case shows which message; `*` stands for what varies. Written and \
         checked by `tests/tests/system/language/messages.rs`.\n\n| about | message | shown by |\n|---|---|---|\n",
    );
    let mut missing: Vec<String> = ELSEWHERE
        .iter()
        .filter(|(m, _)| messages.iter().all(|(_, message)| message != m))
        .map(|(m, _)| format!("ELSEWHERE has a message that no file defines: {m}"))
        .collect();
    for (about, message) in messages {
        let shows = |case: &str| {
            printed.get(case).is_some_and(|lines| lines.iter().any(|line| says(line, &message)))
        };
        let row = |by: &str| format!("| {about} | `` {message} `` | {by} |");
        // Keeps the listed case even if other cases show the message as well.
        let kept = printed.keys().find(|case| old.contains(&row(case)) && shows(case));
        let elsewhere = ELSEWHERE.iter().find(|(m, _)| *m == message);
        if let Some((_, by)) = elsewhere.filter(|(_, by)| root().join(by).is_file()) {
            let text = fs::read_to_string(root().join(by)).unwrap();
            let part = message.split('*').find(|part| part.len() > 7).unwrap();
            assert!(text.contains(part.trim()), "{by} does not show '{message}'");
        }
        match (kept.or_else(|| printed.keys().find(|case| shows(case))), elsewhere) {
            (Some(case), None) => writeln!(table, "{}", row(case)).unwrap(),
            (None, Some((_, by))) => writeln!(table, "{}", row(by)).unwrap(),
            (Some(case), Some(_)) => missing.push(format!("{message}: {case} shows it after all")),
            (None, None) => missing.push(format!("{about}: {message}")),
        }
    }
    assert!(missing.is_empty(), "no case shows:\n{}", missing.join("\n"));
    golden::check(&path, &table);
}

#[test]
fn every_command_stands_in_a_case() {
    let mut used = String::new();
    for case in cases() {
        let folder = root().join("tests/hal").join(case.name);
        for entry in fs::read_dir(folder).unwrap() {
            let path = entry.unwrap().path();
            if path.extension().is_some_and(|e| e == "hal" || e == "ini") {
                used.push('\n');
                used.push_str(&fs::read_to_string(path).unwrap_or_default());
            }
        }
    }
    let words: Vec<&str> = used
        .lines()
        .filter_map(|line| line.trim_start_matches("HALCMD = ").split_whitespace().next())
        .collect();
    let missing: Vec<&str> = COMMANDS.split_whitespace().filter(|n| !words.contains(n)).collect();
    assert!(missing.is_empty(), "in no case: {missing:?}");
}

#[test]
fn messages_have_places_that_vary() {
    assert!(says("f:1: pin 'a' not found", "pin '*' not found"));
    assert!(!says("f:1: pin 'a' is found", "pin '*' not found"));
    assert_eq!(pattern("x {a} \\\n      y {b:?}"), "x * y *");
}
