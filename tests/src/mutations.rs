//! Mutations: clean machines with one realistic mistake each, and what `check` finds of it.

mod hal;
mod ini;
mod joints;
mod judge;
mod values;
mod wiring;

pub use judge::{Counts, Verdict, judge, table};

use crate::{programs::root, scratch::Scratch};
use std::{
    collections::BTreeMap,
    fs,
    path::{Path, PathBuf},
};

/// A machine without errors and warnings.
#[derive(Clone, Debug)]
pub struct CleanMachine {
    /// Folder of its files.
    pub folder: PathBuf,
    /// The file that is checked: an INI file or a script.
    pub main: String,
    /// The files that mistakes are made in, with their lines.
    pub files: Vec<(String, Vec<String>)>,
}

/// A machine with one mistake.
#[derive(Clone, Debug)]
pub struct Mutant {
    /// Kind of the mistake.
    pub kind: &'static str,
    /// File with the mistake.
    pub file: String,
    /// Line of the mistake, from 1.
    pub line: usize,
    /// Further lines that may be named, such as the other one of a pair.
    pub also: Vec<usize>,
    /// The file's lines, changed.
    pub lines: Vec<String>,
    /// Words of which the finding must name one if the line itself is gone.
    pub names: Vec<String>,
    /// Words of which the remedy must contain one.
    pub cures: Vec<String>,
}

impl Mutant {
    /// Returns the mutant that replaces one line.
    fn replace(kind: &'static str, source: (&str, &[String]), index: usize, line: &str) -> Self {
        let mut lines = source.1.to_vec();
        line.clone_into(&mut lines[index]);
        Self {
            kind,
            file: source.0.to_owned(),
            line: index + 1,
            also: Vec::new(),
            lines,
            names: Vec::new(),
            cures: Vec::new(),
        }
    }

    /// Sets the words of which the remedy must contain one.
    fn cured<S: Into<String>>(mut self, words: impl IntoIterator<Item = S>) -> Self {
        self.cures.extend(words.into_iter().map(Into::into));
        self
    }

    /// Sets the words that stand for the line.
    fn named<S: Into<String>>(mut self, words: impl IntoIterator<Item = S>) -> Self {
        self.names.extend(words.into_iter().map(Into::into));
        self
    }

    /// Adds a line that may be named.
    fn also(mut self, index: usize) -> Self {
        self.also.push(index + 1);
        self
    }
}

impl CleanMachine {
    /// Reads a machine. Mistakes are made in the checked file, and in the HAL files of an INI file.
    pub fn read(path: &Path) -> Self {
        let folder = path.parent().unwrap().to_owned();
        let main = path.file_name().unwrap().to_string_lossy().into_owned();
        let mut names = vec![main.clone()];
        if main.ends_with(".ini") {
            let text = String::from_utf8_lossy(&fs::read(path).unwrap()).into_owned();
            let named = text.lines().filter_map(|l| {
                let (key, value) = l.split_once('=')?;
                (key.trim() == "HALFILE").then(|| value.trim().to_owned())
            });
            names.extend(named.filter(|n| folder.join(n).is_file() && n.ends_with(".hal")));
        }
        let lines = |name: &String| {
            let bytes = fs::read(folder.join(name)).unwrap();
            String::from_utf8_lossy(&bytes).lines().map(str::to_owned).collect()
        };
        let files = names.iter().map(|name| (name.clone(), lines(name))).collect();
        Self { folder, main, files }
    }

    /// Returns the mutants of the machine: of each kind at most `most`, spread over its lines.
    pub fn mutants(&self, most: usize) -> Vec<Mutant> {
        let mut all = Vec::new();
        for (name, lines) in &self.files {
            if name.ends_with(".ini") {
                all.extend(ini::mutants(name, lines));
            } else {
                all.extend(hal::mutants(name, lines));
            }
        }
        let mut of: BTreeMap<&str, usize> = BTreeMap::new();
        for mutant in &all {
            *of.entry(mutant.kind).or_default() += 1;
        }
        let mut seen: BTreeMap<&str, usize> = BTreeMap::new();
        all.retain(|m| {
            let (n, all) = (seen.entry(m.kind).or_default(), of[m.kind]);
            *n += 1;
            // The n-th of all is kept if it begins another of `most` equal parts.
            (*n * most) / all.max(most) != ((*n - 1) * most) / all.max(most)
        });
        all
    }

    /// Returns a copy of the machine in a folder of its own.
    pub fn copy(&self) -> Scratch {
        Scratch::copy_of(&self.folder)
    }
}

/// Returns the INI files of `configs/`, and the scripts of machines without one. Demonstrations are left out: each
/// sources its machine, relative to the folder in which it runs.
///
/// # Panics
/// There is no machine.
pub fn machines() -> Vec<PathBuf> {
    let mut machines = Vec::new();
    for folder in fs::read_dir(root().join("configs")).unwrap() {
        let folder = folder.unwrap().path();
        if !folder.is_dir() {
            continue;
        }
        let inis = files_of(&folder, "ini");
        let scripts = files_of(&folder, "hal").into_iter().filter(|f| !f.ends_with("demo.hal"));
        machines.extend(if inis.is_empty() { scripts.collect() } else { inis });
    }
    assert!(!machines.is_empty());
    machines.sort();
    machines
}

/// Returns the files of a folder with this extension.
pub fn files_of(folder: &Path, extension: &str) -> Vec<PathBuf> {
    let files = fs::read_dir(folder).unwrap().map(|file| file.unwrap().path());
    files.filter(|f| f.extension().is_some_and(|e| e == extension)).collect()
}
