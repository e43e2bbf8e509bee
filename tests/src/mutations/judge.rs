//! Verdict on the findings of `check` about a mutant.

use super::{CleanMachine, Mutant};
use crate::programs::programs;
use hal_protocol::{Finding, Level};
use std::{collections::BTreeMap, fmt::Write, path::PathBuf};

/// Verdict on one mutant.
#[derive(Clone, Debug)]
pub struct Verdict {
    /// Kind of the mistake.
    pub kind: &'static str,
    /// The mistake: file, line, and text of the changed line.
    pub what: String,
    /// Level of the worst new finding.
    pub level: Option<Level>,
    /// True if a new error or warning names the place.
    pub place: bool,
    /// True if a new error or warning names the remedy.
    pub remedy: bool,
}

/// Counts of one kind of mistake.
#[derive(Clone, Copy, Debug, Default)]
pub struct Counts {
    /// Number of mutants.
    pub all: usize,
    /// Numbers of mutants by the worst new finding: error, warning, note, nothing.
    pub levels: [usize; 4],
    /// Errors and warnings with the right place.
    pub place: usize,
    /// Errors and warnings with the right remedy.
    pub remedy: usize,
}

impl Counts {
    /// Returns the number of mutants that are caught as errors or warnings.
    pub const fn caught(&self) -> usize {
        self.levels[0] + self.levels[1]
    }

    fn add(&mut self, v: &Verdict) {
        self.all += 1;
        self.levels[match v.level {
            Some(Level::Error) => 0,
            Some(Level::Warning) => 1,
            Some(Level::Note) => 2,
            None => 3,
        }] += 1;
        self.place += usize::from(v.place);
        self.remedy += usize::from(v.remedy);
    }
}

/// Checks every mutant of a machine, in this process.
///
/// # Panics
/// The machine itself has errors or warnings.
pub fn judge(machine: &CleanMachine, most: usize) -> Vec<Verdict> {
    let scratch = machine.copy();
    let path = scratch.path().join(&machine.main).display().to_string();
    let folder = format!("{}/", scratch.path().display());
    let check = || {
        let plugins: Vec<PathBuf> = vec![programs().to_owned()];
        let mut found = halcmd::check::check(core::slice::from_ref(&path), None, plugins).findings;
        for f in &mut found {
            for at in f.at.iter_mut().chain(f.related.iter_mut().map(|r| &mut r.at)) {
                at.file = at.file.replace(&folder, "");
            }
        }
        found
    };
    let clean = check();
    let bad = clean.iter().find(|f| f.level > Level::Note);
    assert!(bad.is_none(), "{path}: {bad:?}");
    let known = |f: &Finding| {
        clean.iter().any(|c| c.code == f.code && c.subject == f.subject && c.level == f.level)
    };
    machine
        .mutants(most)
        .iter()
        .map(|mutant| {
            scratch.write(&mutant.file, mutant.lines.join("\n") + "\n");
            let found: Vec<Finding> = check().into_iter().filter(|f| !known(f)).collect();
            let (_, lines) = machine.files.iter().find(|(n, _)| *n == mutant.file).unwrap();
            scratch.write(&mutant.file, lines.join("\n") + "\n");
            verdict(machine, mutant, lines, &found)
        })
        .collect()
}

fn verdict(
    machine: &CleanMachine,
    mutant: &Mutant,
    lines: &[String],
    found: &[Finding],
) -> Verdict {
    let bad: Vec<&Finding> = found.iter().filter(|f| f.level > Level::Note).collect();
    let here = |f: &&&Finding| {
        let mut at = f.at.iter().chain(f.related.iter().map(|r| &r.at));
        at.any(|at| {
            let line = at.line as usize;
            at.file == mutant.file && (line == mutant.line || mutant.also.contains(&line))
        }) || mutant.names.iter().any(|n| {
            f.text.contains(n.as_str()) || f.remedy.contains(n.as_str()) || f.subject == *n
        })
    };
    let cured = |f: &&&Finding| {
        mutant.cures.iter().any(|c| f.remedy.contains(c.as_str()) || f.text.contains(c.as_str()))
    };
    let (was, is) = (lines.get(mutant.line - 1), mutant.lines.get(mutant.line - 1));
    let folder = machine.folder.file_name().unwrap().to_string_lossy();
    Verdict {
        kind: mutant.kind,
        what: format!(
            "{folder}/{}:{}: {} -> {}",
            mutant.file,
            mutant.line,
            was.map_or("", |l| l.trim()),
            is.map_or("", |l| l.trim())
        ),
        level: found.iter().map(|f| f.level).max(),
        place: bad.iter().any(|f| here(&f)),
        remedy: bad.iter().any(|f| cured(&f)),
    }
}

/// Returns the table by kind, and the numbers of all kinds together.
pub fn table(verdicts: &[Verdict]) -> (String, Counts) {
    let mut kinds: BTreeMap<&str, Counts> = BTreeMap::new();
    let mut total = Counts::default();
    for v in verdicts {
        kinds.entry(v.kind).or_default().add(v);
        total.add(v);
    }
    let mut text = String::from(
        "| mistake | machines with it | error | warning | note | nothing | place right | remedy right |\n\
         |---|--:|--:|--:|--:|--:|--:|--:|\n",
    );
    for (kind, c) in kinds.iter().map(|(k, c)| (*k, c)).chain([("**all**", &total)]) {
        let [error, warning, note, nothing] = c.levels;
        writeln!(
            text,
            "| {kind} | {} | {error} | {warning} | {note} | {nothing} | {} | {} |",
            c.all, c.place, c.remedy
        )
        .unwrap();
    }
    (text, total)
}
