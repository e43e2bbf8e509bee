//! A test that has been read and checked: its steps and its expectations.

use super::{
    condition::Condition,
    expectation::{self, Expectation},
    file::{self, File},
    instant::Instant,
    outcome::{Complaint, Spot},
    source::Source,
    step::{self, Step},
};
use std::path::{Path, PathBuf};
use toml::{Spanned, Value};

/// Default limit of machine time.
const LIMIT_NS: u64 = 600_000_000_000;
/// Maximum nesting of files through `begin`.
const MAX_DEPTH: u32 = 8;

/// A name and its location in the file.
#[derive(Clone, Debug)]
pub(super) struct Named {
    pub(super) spot: Spot,
    pub(super) name: String,
}

/// A name with a value.
#[derive(Clone, Debug)]
pub(super) struct Entry {
    pub(super) spot: Spot,
    pub(super) name: String,
    pub(super) value: Value,
}

/// The script or INI file of a machine.
#[derive(Clone, Debug, Default)]
pub(super) struct MachineFile {
    pub(super) spot: Spot,
    /// Path as the test gave it.
    pub(super) shown: String,
    pub(super) path: PathBuf,
}

/// A waveform that is kept in a file.
#[derive(Debug)]
pub(super) struct Snapshot {
    pub(super) spot: Spot,
    pub(super) name: String,
    pub(super) channels: Vec<Named>,
    pub(super) from: Instant,
    pub(super) to: Instant,
}

/// A machine's test.
#[derive(Debug, Default)]
pub(super) struct Test {
    pub(super) about: String,
    pub(super) machine: Option<MachineFile>,
    pub(super) arguments: Vec<String>,
    pub(super) environment: Vec<(String, String)>,
    pub(super) settings: Vec<Entry>,
    pub(super) replace: Vec<(Named, String)>,
    /// Lines of the HAL language, executed after the machine's script.
    pub(super) lines: Vec<Named>,
    pub(super) limit_ns: Option<u64>,
    pub(super) refused: Option<Named>,
    pub(super) exit: Option<(Spot, u8)>,
    pub(super) steps: Vec<Step>,
    pub(super) expectations: Vec<Expectation>,
    pub(super) snapshots: Vec<Snapshot>,
}

impl Test {
    /// Reads and checks a test.
    pub(super) fn read(path: &Path, shown: &str) -> Result<Self, Vec<Complaint>> {
        let mut test = Self::default();
        let mut reader = Reader { test: &mut test, wrong: Vec::new() };
        reader.file(path, shown, None, 0);
        let mut wrong = reader.wrong;
        if wrong.is_empty() {
            test.check(shown, &mut wrong);
        }
        if wrong.is_empty() { Ok(test) } else { Err(wrong) }
    }

    /// Returns the limit of machine time.
    pub(super) fn limit_ns(&self) -> u64 {
        self.limit_ns.unwrap_or(LIMIT_NS)
    }

    /// Returns every condition of the test.
    pub(super) fn conditions(&self) -> impl Iterator<Item = &Condition> {
        self.expectations.iter().flat_map(Expectation::conditions)
    }

    /// Returns every channel that is evaluated after the run.
    pub(super) fn channels(&self) -> impl Iterator<Item = &Named> {
        let pictured = self.snapshots.iter().flat_map(|s| &s.channels);
        pictured.chain(self.expectations.iter().flat_map(Expectation::channels))
    }

    fn check(&self, shown: &str, wrong: &mut Vec<Complaint>) {
        let top = Spot { file: shown.to_owned(), line: 1 };
        if self.machine.is_none() {
            let text = "no key 'machine': which script or INI file is tested?";
            wrong.push(Complaint::new(&top, text).with("such as machine = \"../mill.ini\""));
        }
        let nothing = self.steps.is_empty() && self.expectations.is_empty();
        if nothing && self.snapshots.is_empty() && self.refused.is_none() && self.exit.is_none() {
            let text = "this tests nothing";
            let keys = "write [[step]], [[expect]], [[snapshot]], refused or exit";
            wrong.push(Complaint::new(&top, text).with(keys));
        }
        let marks: Vec<&str> = self.steps.iter().filter_map(|s| s.mark.as_deref()).collect();
        let of_snapshots = self.snapshots.iter().flat_map(|s| [&s.from, &s.to]);
        let instants = of_snapshots.chain(self.expectations.iter().flat_map(Expectation::instants));
        wrong.extend(instants.filter_map(|m| m.unknown(&marks)));
        for (n, mark) in marks.iter().enumerate() {
            if marks.iter().take(n).any(|m| m == mark) {
                let again = self.steps.iter().filter(|s| s.mark.as_deref() == Some(mark)).nth(1);
                let spot = again.map_or(&top, |s| &s.spot);
                wrong.push(Complaint::new(spot, format!("there are two marks '{mark}'")));
            }
        }
        for (n, s) in self.snapshots.iter().enumerate() {
            if self.snapshots.iter().take(n).any(|o| o.name == s.name) {
                let text = format!("there are two snapshots '{}'", s.name);
                wrong.push(Complaint::new(&s.spot, text));
            }
        }
    }
}

struct Reader<'t> {
    test: &'t mut Test,
    wrong: Vec<Complaint>,
}

impl Reader<'_> {
    fn file(&mut self, path: &Path, shown: &str, asked: Option<&Spot>, depth: u32) {
        let text = match std::fs::read_to_string(path) {
            Ok(text) => text,
            Err(error) => {
                let why = crate::ini::plain(&error);
                let here = Spot { file: shown.to_owned(), line: 1 };
                let text = match asked {
                    Some(_) => format!("'{shown}' cannot be read: {why}"),
                    None => format!("cannot be read: {why}"),
                };
                return self.wrong.push(Complaint::new(asked.unwrap_or(&here), text));
            }
        };
        let source = Source::new(shown, &text);
        let file: File = match toml::from_str(&text) {
            Ok(file) => file,
            Err(error) => return self.wrong.push(source.misread(&error)),
        };
        if let Some(begin) = &file.begin {
            let spot = source.spot(&begin.span());
            if depth >= MAX_DEPTH {
                let text = "files begin with each other too deeply (8 at most)";
                return self.wrong.push(Complaint::new(&spot, text));
            }
            let name = begin.get_ref();
            let shown = beside(Path::new(shown), name).display().to_string();
            self.file(&beside(path, name), &shown, Some(&spot), depth + 1);
        }
        self.take(file, path, &source);
    }

    /// Adds the content of a file to the content of the file named by its `begin`.
    fn take(&mut self, file: File, path: &Path, source: &Source<'_>) {
        if let Some(about) = file.about {
            self.test.about = about.trim().to_owned();
        }
        if let Some(machine) = &file.machine {
            let spot = source.spot(&machine.span());
            let name = machine.get_ref();
            let shown = beside(Path::new(source.shown()), name).display().to_string();
            self.test.machine = Some(MachineFile { spot, shown, path: beside(path, name) });
        }
        if let Some(profile) = &file.profile {
            let (name, spot) = (profile.get_ref(), source.spot(&profile.span()));
            let profile = beside(path, name);
            if !profile.is_file() {
                let shown = beside(Path::new(source.shown()), name);
                let text = format!("the profile '{}': there is no such file", shown.display());
                self.wrong.push(Complaint::new(&spot, text));
            }
            self.test.arguments.extend(["--profile".to_owned(), profile.display().to_string()]);
        }
        self.test.arguments.extend(file.arguments.into_iter().map(Spanned::into_inner));
        self.test.environment.extend(file.environment);
        self.test.settings.extend(source.entries(file.settings));
        let replace = file.replace.into_iter().map(|(name, text)| (source.named(&name), text));
        self.test.replace.extend(replace);
        self.test.lines.extend(file.lines.map(|l| source.lines(&l)));
        if let Some(limit) = &file.limit {
            self.test.limit_ns = self.keep(source.time(limit));
        }
        if let Some(text) = &file.refused {
            self.test.refused = Some(source.named(text));
        }
        if let Some(code) = file.exit {
            self.test.exit = Some((source.spot(&code.span()), code.into_inner()));
        }
        for step in file.step {
            let made = step::checked(source, step);
            let made = self.keep(made);
            self.test.steps.extend(made);
        }
        for expect in file.expect {
            let made = expectation::checked(source, expect);
            let made = self.keep(made);
            self.test.expectations.extend(made);
        }
        for snapshot in file.snapshot {
            let made = checked(source, snapshot);
            let made = self.keep(made);
            self.test.snapshots.extend(made);
        }
    }

    fn keep<T>(&mut self, made: Result<T, Complaint>) -> Option<T> {
        made.map_err(|complaint| self.wrong.push(complaint)).ok()
    }
}

fn checked(source: &Source<'_>, snapshot: Spanned<file::Snapshot>) -> Result<Snapshot, Complaint> {
    let spot = source.spot(&snapshot.span());
    let file::Snapshot { name, channels, from, to } = snapshot.into_inner();
    let plain = |c: char| c.is_ascii_alphanumeric() || c == '-' || c == '_';
    if name.get_ref().is_empty() || !name.get_ref().chars().all(plain) {
        let text = format!("'{}' cannot be the name of a file", name.get_ref());
        return Err(Complaint::new(&source.spot(&name.span()), text)
            .with("a snapshot's name has letters, digits, '-' and '_'"));
    }
    if channels.is_empty() {
        let text = "a snapshot without channels shows nothing";
        return Err(Complaint::new(&spot, text).with("such as channels = [\"xstep\", \"xdir\"]"));
    }
    Ok(Snapshot {
        name: name.into_inner(),
        channels: channels.iter().map(|c| source.named(c)).collect(),
        from: source.instant(from.as_ref(), Instant::start(&spot))?,
        to: source.instant(to.as_ref(), Instant::end(&spot))?,
        spot,
    })
}

/// Resolves a file named in another file: relative to that file's folder, unless the name is
/// absolute.
pub(super) fn beside(path: &Path, name: &str) -> PathBuf {
    path.parent().map_or_else(|| PathBuf::from(name), |folder| folder.join(name))
}
