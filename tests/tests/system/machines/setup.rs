//! Machines written by `halsetup` from answers: `tests/setup/NAME.toml` gives the files of `tests/setup/NAME`;
//! `tests/setup/bad` has answers that make no machine, each with its message.
#![expect(clippy::unwrap_used, reason = "tests")]

use hal_tests::{
    golden,
    programs::root,
    scratch::{Output, Scratch},
};
use std::{
    collections::BTreeSet,
    fs::{self, File},
    path::{Path, PathBuf},
};

/// Returns the files of answers in a folder of `tests`, sorted.
fn answers(folder: &str) -> Vec<PathBuf> {
    let entries = fs::read_dir(root().join("tests").join(folder)).unwrap();
    let mut files: Vec<PathBuf> = entries.map(|e| e.unwrap().path()).collect();
    files.retain(|f| f.extension().is_some_and(|e| e == "toml"));
    files.sort();
    assert!(files.len() > 2, "{files:?}");
    files
}

fn halsetup(scratch: &Scratch, words: &[&str]) -> Output {
    let mut command = scratch.command(&[], "halsetup");
    scratch.run(command.args(words))
}

fn stem(path: &Path) -> String {
    path.file_stem().unwrap().to_string_lossy().into_owned()
}

/// Writes a machine from answers; returns its folder's name.
fn written(scratch: &Scratch, file: &Path) -> String {
    scratch.write("answers.toml", fs::read(file).unwrap());
    let output = halsetup(scratch, &["answers.toml"]);
    assert_eq!((output.stderr.as_str(), output.status), ("", Some(0)), "{}", file.display());
    let (period, rest) = output.stdout.split_once('\n').unwrap();
    assert!(period.starts_with("base period "), "{period}");
    let (first, _) = rest.split_once(".ini: written, and checked without a finding").unwrap();
    first.rsplit('/').next().unwrap().to_owned()
}

#[test]
fn answers_become_a_machine_that_is_clean_and_runs() {
    for file in answers("setup") {
        let scratch = Scratch::new("setup");
        let name = written(&scratch, &file);
        assert_eq!(name, stem(&file));
        for kind in ["ini", "hal"] {
            let inside = format!("{name}/{name}.{kind}");
            golden::check(&root().join("tests/setup").join(&inside), &scratch.read(&inside));
        }
        let ini = format!("{name}/{name}.ini");
        let output = scratch.halrun(&["--virtual", "--for", "1s", &ini]);
        let said = (output.stdout.as_str(), output.stderr.as_str(), output.status);
        assert_eq!(said, ("", "", Some(0)), "{name}");
    }
}

#[test]
fn answers_that_make_no_machine_are_refused_and_leave_nothing() {
    for file in answers("setup/bad") {
        let scratch = Scratch::new("setup-bad");
        scratch.write("answers.toml", fs::read(&file).unwrap());
        let output = halsetup(&scratch, &["answers.toml"]);
        assert_eq!((output.stdout.as_str(), output.status), ("", Some(1)), "{}", file.display());
        golden::check(&file.with_extension("expected"), &output.stderr);
        let left: Vec<String> = scratch.files().into_keys().collect();
        assert_eq!(left, ["answers.toml"], "{}", file.display());
    }
}

#[test]
fn a_machine_is_made_in_a_new_folder_which_bad_answers_do_not_leave() {
    let scratch = Scratch::new("setup-new");
    for (file, status) in [("bad/fast.toml", 1), ("mill.toml", 0)] {
        scratch.write("answers.toml", fs::read(root().join("tests/setup").join(file)).unwrap());
        let output = halsetup(&scratch, &["--output", "new", "answers.toml"]);
        assert_eq!(output.status, Some(status), "{output:?}");
        assert_eq!(scratch.path().join("new").exists(), status == 0, "{output:?}");
    }
    assert!(scratch.path().join("new/mill/mill.ini").is_file());
    let output = halsetup(&scratch, &["-o", "far/below", "answers.toml"]);
    assert_eq!(output.status, Some(0), "{output:?}");
    assert!(scratch.path().join("far/below/mill/mill.ini").is_file());
}

#[test]
fn a_machine_that_is_there_is_never_replaced() {
    let scratch = Scratch::new("setup-twice");
    let file = root().join("tests/setup/mill.toml");
    written(&scratch, &file);
    let before = scratch.files();
    let output = halsetup(&scratch, &["answers.toml"]);
    let text = "halsetup: ./mill: is there already; another name, or --output\n";
    assert_eq!((output.stderr.as_str(), output.status), (text, Some(1)));
    assert_eq!(scratch.files(), before);
}

/// Returns the lines of a saved machine that say what it is. The document's files name joints as axes.
fn facts(text: &str) -> BTreeSet<String> {
    let kept = |l: &&str| ["setp ", "addf ", "net "].iter().any(|word| l.starts_with(word));
    text.lines().filter(kept).map(|l| l.replace(" axis.", " joint.")).collect()
}

/// Returns what `save` prints of a machine after its start.
fn saved(scratch: &Scratch, ini: &str) -> String {
    let whole = format!("#INCLUDE {ini}\n[HAL]\nPOSTGUI_HALFILE = save.hal\n");
    scratch.write("save.ini", whole);
    scratch.write("save.hal", "save all saved\nshutdown\n");
    let output = scratch.halrun(&["--virtual", "save.ini"]);
    assert_eq!(output.status, Some(0), "{ini}: {}", output.stderr);
    scratch.read("saved")
}

/// The document's builder had no switches on the board, so its files have signals of switches that nothing drives.
#[test]
fn the_printer_of_the_document_is_what_its_answers_give() {
    let document = facts(&saved(&Scratch::copy_of(&root().join("configs/printer")), "printer.ini"));
    let scratch = Scratch::new("setup-printer");
    let name = written(&scratch, &root().join("configs/printer/printer.setup"));
    let ours =
        facts(&saved(&Scratch::copy_of(&scratch.path().join(&name)), &format!("{name}.ini")));
    let lost: Vec<&String> = document.difference(&ours).collect();
    let added: Vec<&String> = ours.difference(&document).collect();
    golden::check(
        &root().join("tests/setup/printer.difference"),
        &format!("only in the document: {lost:#?}\nonly from the answers: {added:#?}\n"),
    );
    assert!(document.intersection(&ours).count() > 40);
}

#[test]
fn questions_lead_to_the_same_machine_as_a_file() {
    let scratch = Scratch::new("setup-asked");
    let said = fs::read(root().join("tests/setup/questions.txt")).unwrap();
    scratch.write("said", said);
    let mut command = scratch.command(&[], "halsetup");
    let output = scratch.run(command.stdin(File::open(scratch.path().join("said")).unwrap()));
    assert_eq!((output.stderr.as_str(), output.status), ("", Some(0)), "{}", output.stdout);
    golden::check(&root().join("tests/setup/questions.expected"), &output.stdout);
    // The answers that it kept give the same files again.
    scratch.write("answers.toml", scratch.read("small/small.setup"));
    let again = halsetup(&scratch, &["-o", ".", "answers.toml"]);
    assert_eq!(again.status, Some(1), "the folder is there");
    fs::create_dir(scratch.path().join("again")).unwrap();
    let again = halsetup(&scratch, &["answers.toml", "-o", "again"]);
    assert_eq!(again.status, Some(0), "{}", again.stderr);
    for kind in ["ini", "hal", "setup"] {
        let file = format!("small/small.{kind}");
        assert_eq!(scratch.read(&file), scratch.read(&format!("again/{file}")), "{kind}");
    }
}

#[test]
fn no_answer_writes_nothing() {
    let scratch = Scratch::new("setup-early");
    let mut command = scratch.command(&[], "halsetup");
    let output = scratch.run(command.stdin(File::open("/dev/null").unwrap()));
    let text = "halsetup: no question was answered; nothing was written\n";
    assert_eq!((output.stderr.as_str(), output.status), (text, Some(1)));
    assert_eq!(scratch.files().len(), 0);
}
