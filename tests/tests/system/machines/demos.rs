//! The machines of `configs`: each loads, does its task, saves, and is restored from the saved file.
#![expect(clippy::unwrap_used, clippy::panic, reason = "tests")]

use hal_tests::{golden, programs::root, scratch::Scratch};
use std::{
    fmt::Write,
    fs,
    path::{Path, PathBuf},
};

/// A folder of `configs`: `NAME.hal`, or `NAME.ini` with its scripts, is the machine; `demo.hal` or `demo.ini`
/// demonstrates it.
pub(super) struct Demo {
    pub(super) name: String,
    pub(super) folder: PathBuf,
}

/// Returns every machine; if `CASE` is set, only those whose names begin with it.
pub(super) fn machines() -> Vec<Demo> {
    let wanted = std::env::var("CASE").unwrap_or_default();
    let mut all: Vec<Demo> = fs::read_dir(root().join("configs"))
        .unwrap()
        .map(|e| e.unwrap().path())
        .filter(|p| p.is_dir())
        .map(|folder| Demo {
            name: folder.file_name().unwrap().to_string_lossy().into_owned(),
            folder,
        })
        .filter(|m| m.name.starts_with(&wanted))
        .collect();
    all.sort_by(|a, b| a.name.cmp(&b.name));
    assert!(all.len() >= 11 || !wanted.is_empty(), "only {} machines", all.len());
    all
}

impl Demo {
    fn has(&self, file: &str) -> bool {
        self.folder.join(file).is_file()
    }

    /// Returns the first of these files that exists.
    fn one_of(&self, files: [String; 2]) -> String {
        files
            .into_iter()
            .find(|f| self.has(f))
            .unwrap_or_else(|| panic!("{}: no script", self.name))
    }

    fn script(&self) -> String {
        self.one_of([format!("{}.ini", self.name), format!("{}.hal", self.name)])
    }

    pub(super) fn demo(&self) -> String {
        self.one_of(["demo.ini".to_owned(), "demo.hal".to_owned()])
    }

    /// Returns the purpose that the first line of its script states.
    pub(super) fn purpose(&self) -> String {
        let text = fs::read_to_string(self.folder.join(self.script())).unwrap();
        let line = text.lines().next().unwrap_or_default();
        let line = line.strip_prefix("# ").unwrap_or_else(|| panic!("{}: no purpose", self.name));
        assert!(line.ends_with('.'), "{}: a sentence: {line}", self.name);
        line.to_owned()
    }

    /// Returns what `halscope plot` gets for the picture of its demonstration, from the line `# Picture: …`: options with a value
    /// each, and channels.
    pub(super) fn picture(&self) -> Vec<String> {
        let text = fs::read_to_string(self.folder.join("demo.hal")).unwrap();
        let line = text.lines().find_map(|l| l.strip_prefix("# Picture: "));
        let line = line.unwrap_or_else(|| panic!("{}: no line '# Picture:'", self.name));
        line.split_whitespace().map(str::to_owned).collect()
    }

    /// Returns the channels that the picture shows.
    pub(super) fn channels(&self) -> Vec<String> {
        let mut words = self.picture();
        let options = words.iter().step_by(2).take_while(|word| word.starts_with("--")).count();
        words.split_off(2 * options)
    }

    /// Returns the path of its expected output.
    fn expected(&self, what: &str) -> PathBuf {
        root().join("tests/machines").join(format!("{}.{what}", self.name))
    }

    /// Runs one of its scripts to its end; returns standard output and standard error.
    fn run(&self, scratch: &Scratch, script: &str) -> String {
        self.run_with(scratch, &[], script)
    }

    /// Runs one of its scripts with further options.
    pub(super) fn run_with(&self, scratch: &Scratch, options: &[&str], script: &str) -> String {
        let mut words = vec!["--virtual"];
        words.extend(options);
        if script.ends_with(".hal") {
            words.push("-f");
        }
        words.push(script);
        let output = scratch.halrun(&words);
        assert_eq!(output.status, Some(0), "{}: {}{}", self.name, output.stdout, output.stderr);
        assert!(scratch.left().is_empty(), "{}: {:?}", self.name, scratch.left());
        let mut text = output.stdout;
        if !output.stderr.is_empty() {
            write!(text, "--- stderr\n{}", output.stderr).unwrap();
        }
        text
    }

    /// Returns the machine as saved after its load.
    fn saved(&self) -> String {
        let scratch = Scratch::copy_of(&self.folder);
        let script = self.script();
        if script.ends_with(".ini") {
            let whole = format!("#INCLUDE {script}\n[HAL]\nPOSTGUI_HALFILE = save.hal\n");
            scratch.write("save.ini", whole);
            scratch.write("save.hal", "save all saved\nshutdown\n");
            self.run(&scratch, "save.ini");
        } else {
            scratch.write("save.hal", format!("source {script}\nsave all saved\nshutdown\n"));
            self.run(&scratch, "save.hal");
        }
        scratch.read("saved")
    }

    /// Returns the machine as saved after a start from the saved text. That text contains neither programs nor the
    /// effects of an INI file: these are started as the machine does.
    fn saved_again(&self, saved: &str) -> String {
        let scratch = Scratch::copy_of(&self.folder);
        let script = self.script();
        let ini = scratch.read(&script);
        if script.ends_with(".ini") {
            let own = |l: &&str| l.starts_with("loadusr ");
            let texts: Vec<String> = self.scripts().iter().map(|name| scratch.read(name)).collect();
            let programs: Vec<&str> = texts.iter().flat_map(|t| t.lines().filter(own)).collect();
            let kind = if ini.contains("[AXIS_0]") { "[AXIS_0]\nTYPE = LINEAR\n" } else { "" };
            scratch.write("programs.hal", programs.join("\n"));
            scratch.write("saved.hal", saved.replace("loadrt iocontrol interlock=1\n", ""));
            scratch.write("save.hal", "save all again\nshutdown\n");
            // The task reads the machine's INI file again.
            scratch.write("save.ini", &ini);
            let files = ["programs.hal", "saved.hal", "save.hal"];
            let files: String = files.iter().map(|f| format!("HALFILE = {f}\n")).collect();
            scratch.write("again.ini", format!("{kind}[HAL]\n{files}"));
            self.run(&scratch, "again.ini");
        } else {
            scratch.write("saved", saved);
            scratch.write("again.hal", "source saved\nsave all again\nshutdown\n");
            self.run(&scratch, "again.hal");
        }
        scratch.read("again")
    }

    /// Returns its own HAL files.
    fn scripts(&self) -> Vec<String> {
        let names = fs::read_dir(&self.folder).unwrap().map(|e| e.unwrap().file_name());
        let mut names: Vec<String> = names.map(|n| n.to_string_lossy().into_owned()).collect();
        names.retain(|n| n.ends_with(".hal") && n != "demo.hal");
        names.sort();
        names
    }
}

/// Compares with a golden file, and adds the difference to `wrong`.
fn compare(path: &Path, got: &str, wrong: &mut String) {
    if let Err(difference) = golden::compare(path, got) {
        writeln!(wrong, "{difference}").unwrap();
    }
}

#[test]
fn each_does_what_it_is_there_for() {
    let mut wrong = String::new();
    for m in machines() {
        let scratch = Scratch::copy_of(&m.folder);
        let said = m.run(&scratch, &m.demo());
        compare(&m.expected("demo"), &said, &mut wrong);
    }
    assert!(wrong.is_empty(), "{wrong}");
}

#[test]
fn each_comes_back_from_what_it_saved() {
    let mut wrong = String::new();
    for m in machines() {
        let saved = m.saved();
        compare(&m.expected("saved"), &saved, &mut wrong);
        let again = m.saved_again(&saved);
        assert_eq!(again, saved, "{}: saved again", m.name);
    }
    assert!(wrong.is_empty(), "{wrong}");
}

#[test]
fn each_runs_for_two_seconds_without_a_word() {
    for m in machines() {
        let scratch = Scratch::copy_of(&m.folder);
        let output = scratch.halrun(&["--virtual", "--for", "2s", &m.script()]);
        let said = (output.stdout.as_str(), output.stderr.as_str(), output.status);
        assert_eq!(said, ("", "", Some(0)), "{}", m.name);
    }
}

#[test]
fn two_conveyors_are_two_instances_or_one() {
    let two = machines().into_iter().find(|m| m.name == "two");
    let Some(two) = two else { return };
    let scratch = Scratch::copy_of(&two.folder);
    let mut apart = String::new();
    for (side, other) in [("left", "right"), ("right", "left")] {
        let text = scratch.read(&format!("{side}.hal"));
        assert!(!text.contains(other), "{side}.hal says {other}");
        scratch.write("run.hal", format!("source {side}.hal\nrun 7s\ngets {side}-position\n"));
        let output = scratch.halrun(&["--virtual", "--instance", side, "-f", "run.hal"]);
        assert_eq!((output.stderr.as_str(), output.status), ("", Some(0)), "{side}");
        apart.push_str(&output.stdout);
    }
    scratch.write("run.hal", "source two.hal\nrun 7s\ngets left-position\ngets right-position\n");
    let output = scratch.halrun(&["--virtual", "-f", "run.hal"]);
    assert_eq!((output.stdout, output.status), (apart, Some(0)));
}

#[test]
fn the_table_of_machines_is_true() {
    if std::env::var_os("CASE").is_some() {
        return;
    }
    let mut new = String::from("\n\n| machine | what it is | its demonstration |\n|---|---|---|\n");
    for m in machines() {
        let name = &m.name;
        let picture = format!("{name}/demo.png");
        assert!(root().join("configs").join(&picture).is_file(), "{name} has no picture");
        let shown = format!(
            "<a href=\"{picture}\"><img src=\"{picture}\" width=\"240\" alt=\"{name}\"></a>"
        );
        writeln!(new, "| [`{name}`]({name}) | {} | {shown} |", m.purpose()).unwrap();
    }
    new.push('\n');
    let page = root().join("configs/README.md");
    golden::check_part(&page, "<!-- table:begin -->", "<!-- table:end -->", &new);
}
