//! Lists of known differences with LinuxCNC: a name and its reason to a line.
#![expect(clippy::panic, clippy::print_stdout, reason = "tests; the figures of a comparison")]

use hal_tests::programs::root;
use std::{collections::BTreeMap, fs};

/// The differences of a file in `tests/peer`, and what is wrong with it so far.
pub(super) struct Known {
    file: &'static str,
    reasons: BTreeMap<String, String>,
    equal: usize,
    different: usize,
    wrong: Vec<String>,
}

impl Known {
    /// Reads a file of lines `NAME: REASON`.
    pub(super) fn read(file: &'static str) -> Self {
        let path = root().join("tests/peer").join(file);
        let text = fs::read_to_string(&path).unwrap_or_else(|e| panic!("{}: {e}", path.display()));
        let lines = text.lines().filter(|l| !l.is_empty() && !l.starts_with('#'));
        let mut reasons = BTreeMap::new();
        for line in lines {
            let Some((name, reason)) = line.split_once(": ").filter(|(_, r)| !r.trim().is_empty())
            else {
                panic!("{file}: '{line}' has no reason");
            };
            let twice = reasons.insert(name.to_owned(), reason.to_owned());
            assert!(twice.is_none(), "{file}: {name} twice");
        }
        Self { file, reasons, equal: 0, different: 0, wrong: Vec::new() }
    }

    /// Notes whether a program is equal, or how it differs.
    pub(super) fn judge(&mut self, name: &str, difference: Option<String>) {
        match (difference, self.reasons.remove(name)) {
            (None, None) => self.equal += 1,
            (Some(_), Some(_)) => self.different += 1,
            (None, Some(_)) => self.wrong.push(format!("{name}: listed as different, but equal")),
            (Some(how), None) => {
                self.wrong.push(format!("{name}: differs without a reason\n{how}"));
            }
        }
    }

    /// Tells the figures.
    ///
    /// # Panics
    /// A difference is not listed, or a line is not needed.
    pub(super) fn report(mut self) {
        let unknown = self.reasons.keys().map(|name| format!("{name}: listed, but not there"));
        self.wrong.extend(unknown);
        let Self { file, equal, different, wrong, .. } = self;
        println!("{file}: {equal} equal, {different} different for a reason");
        assert!(wrong.is_empty(), "{file}: {} wrong\n{}", wrong.len(), wrong.join("\n"));
    }
}
