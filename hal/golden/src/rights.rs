//! Tables of rights: who may make which request, and when.
//!
//! A file of rules is written by hand. It has the columns of circumstances, the requests of each kind, and for each kind what comes of
//! them; the first rule that fits counts:
//!
//! ```text
//! columns: who lease
//! kind stops = abort estop
//! stops | * | * | ok
//! ```
//!
//! The table is what came of every request in all circumstances. A request without a kind, a row without a rule, a kind that is no
//! request, a rule that no row needs and an end that is not the rule's fail the test.

use crate::check;
use std::{collections::BTreeMap, fs, path::Path};

/// Circumstances of a rule that stand for all.
const ANY: &str = "*";

#[derive(Debug)]
struct Rule {
    line: usize,
    kind: String,
    /// For each column the circumstances for which it is.
    of: Vec<Vec<String>>,
    end: String,
    is_used: bool,
}

/// A table in the making.
#[derive(Debug)]
pub struct RightsTable {
    file: String,
    columns: Vec<String>,
    /// Requests with their kinds.
    kinds: BTreeMap<String, String>,
    rules: Vec<Rule>,
    rows: Vec<(String, Vec<String>, String)>,
    wrong: Vec<String>,
}

fn words(text: &str, between: char) -> Vec<String> {
    text.split(between).map(str::trim).filter(|w| !w.is_empty()).map(str::to_owned).collect()
}

impl RightsTable {
    /// Reads the rules.
    ///
    /// # Panics
    /// The file cannot be read, or a line is no rule.
    #[must_use]
    pub fn of(path: &Path) -> Self {
        let file = path.file_name().unwrap().to_string_lossy().into_owned();
        let text = fs::read_to_string(path).unwrap_or_else(|e| panic!("{}: {e}", path.display()));
        Self::parse(file, &text)
    }

    fn parse(file: String, text: &str) -> Self {
        let mut table = Self {
            file,
            columns: Vec::new(),
            kinds: BTreeMap::new(),
            rules: Vec::new(),
            rows: Vec::new(),
            wrong: Vec::new(),
        };
        for (line, text) in (1..).zip(text.lines()) {
            table.line(line, text.trim());
        }
        table
    }

    fn line(&mut self, line: usize, text: &str) {
        if text.is_empty() || text.starts_with('#') {
            return;
        }
        if let Some(columns) = text.strip_prefix("columns:") {
            self.columns = words(columns, ' ');
        } else if let Some((kind, requests)) =
            text.strip_prefix("kind ").and_then(|rest| rest.split_once('='))
        {
            for request in words(requests, ',') {
                let before = self.kinds.insert(request.clone(), kind.trim().to_owned());
                assert_eq!(before, None, "{}:{line}: {request} has two kinds", self.file);
            }
        } else {
            let mut cells: Vec<&str> = text.split('|').map(str::trim).collect();
            assert_eq!(cells.len(), self.columns.len() + 2, "{}:{line}: no rule", self.file);
            let end = cells.pop().unwrap().to_owned();
            let kind = cells.remove(0).to_owned();
            let of = cells.into_iter().map(|cell| words(cell, ' ')).collect();
            self.rules.push(Rule { line, kind, of, end, is_used: false });
        }
    }

    /// Adds what came of a request.
    pub fn row(&mut self, request: &str, circumstances: &[&str], end: &str) {
        let row = format!("{request} [{}]", circumstances.join(", "));
        assert_eq!(circumstances.len(), self.columns.len(), "{row}");
        let Some(kind) = self.kinds.get(request).cloned() else {
            self.wrong.push(format!("{row}: {request} is in no kind of {}", self.file));
            return;
        };
        let fits = |rule: &&mut Rule| {
            let mut all = rule.of.iter().zip(circumstances);
            rule.kind == kind
                && all.all(|(of, now)| of.iter().any(|word| word == ANY || word == now))
        };
        match self.rules.iter_mut().find(fits) {
            None => self.wrong.push(format!("{row}: no rule of {} is for it", self.file)),
            Some(rule) => {
                rule.is_used = true;
                if rule.end != end {
                    let (line, wanted) = (rule.line, &rule.end);
                    let text = format!("{row}: {end}, and {}:{line} says {wanted}", self.file);
                    self.wrong.push(text);
                }
            }
        }
        let circumstances = circumstances.iter().map(|word| (*word).to_owned()).collect();
        self.rows.push((request.to_owned(), circumstances, end.to_owned()));
    }

    /// Compares the table with its rules, and with the page of all rows.
    ///
    /// # Panics
    /// They differ.
    pub fn finish(self, page: &Path) {
        let wrong = self.wrong();
        assert!(wrong.is_empty(), "{} rows differ:\n{}", wrong.len(), wrong.join("\n"));
        check(page, &self.page());
    }

    fn wrong(&self) -> Vec<String> {
        let mut wrong = self.wrong.clone();
        let has = |request: &String| self.rows.iter().any(|(row, ..)| row == request);
        let unknown = self.kinds.keys().filter(|request| !has(request));
        wrong.extend(unknown.map(|request| format!("{}: there is no {request}", self.file)));
        let idle = self.rules.iter().filter(|rule| !rule.is_used);
        wrong.extend(idle.map(|rule| format!("{}:{}: no row needs it", self.file, rule.line)));
        wrong
    }

    /// Returns all rows, with a column for each of the last circumstances.
    fn page(&self) -> String {
        let mut last: Vec<&str> = Vec::new();
        let mut lines: BTreeMap<(String, Vec<String>), BTreeMap<&str, &str>> = BTreeMap::new();
        for (request, circumstances, end) in &self.rows {
            let Some((state, others)) = circumstances.split_last() else { continue };
            if !last.contains(&&**state) {
                last.push(state);
            }
            let line = lines.entry((request.clone(), others.to_vec())).or_default();
            line.insert(state, end);
        }
        let others = self.columns.iter().take(self.columns.len().saturating_sub(1));
        let heads: Vec<&str> = ["request"]
            .into_iter()
            .chain(others.map(String::as_str))
            .chain(last.iter().copied())
            .collect();
        let mut out = format!(
            "# Rights by {}\n\n{} rows. `UPDATE_EXPECT=1` writes this page; the rules are written by hand.\n\n| {} |\n|{}\n",
            self.file,
            self.rows.len(),
            heads.join(" | "),
            "---|".repeat(heads.len()),
        );
        for ((request, others), ends) in lines {
            let mut cells = vec![format!("`{request}`")];
            cells.extend(others);
            cells.extend(last.iter().map(|state| (*ends.get(state).unwrap_or(&"")).to_owned()));
            out.push_str(&format!("| {} |\n", cells.join(" | ")));
        }
        out
    }
}

#[cfg(test)]
mod tests {
    //! Rows that differ from their rules.

    use super::RightsTable;

    const RULES: &str = "# By hand.\ncolumns: who state\nkind stops = abort, estop\nkind moves = run\n\
        stops | * | * | ok\nmoves | viewer | * | role\nmoves | * | ready | ok\nmoves | * | * | refused\n";

    fn wrong(rows: &[(&str, &str, &str, &str)]) -> Vec<String> {
        let mut table = RightsTable::parse("a.rules".to_owned(), RULES);
        for (request, who, state, end) in rows {
            table.row(request, &[who, state], end);
        }
        table.wrong()
    }

    const ROWS: [(&str, &str, &str, &str); 5] = [
        ("abort", "viewer", "ready", "ok"),
        ("estop", "viewer", "off", "ok"),
        ("run", "viewer", "ready", "role"),
        ("run", "operator", "ready", "ok"),
        ("run", "operator", "off", "refused"),
    ];

    #[test]
    fn a_table_by_its_rules_is_right_and_every_other_is_not() {
        assert_eq!(wrong(&ROWS), Vec::<String>::new());
        for (without, why) in [
            (0, "a.rules: there is no abort"),
            (2, "a.rules:6: no row needs it"),
            (4, "a.rules:8: no row needs it"),
        ] {
            let mut rows = ROWS.to_vec();
            rows.remove(without);
            assert_eq!(wrong(&rows), [why]);
        }
        for (row, why) in [
            (
                ("shutdown", "viewer", "ready", "ok"),
                "shutdown [viewer, ready]: shutdown is in no kind of a.rules",
            ),
            (
                ("abort", "viewer", "off", "role"),
                "abort [viewer, off]: role, and a.rules:5 says ok",
            ),
        ] {
            let rows: Vec<_> = ROWS.iter().copied().chain([row]).collect();
            assert_eq!(wrong(&rows), [why]);
        }
    }

    #[test]
    fn the_page_has_every_row() {
        let mut table = RightsTable::parse("a.rules".to_owned(), RULES);
        ROWS.iter().for_each(|(request, who, state, end)| table.row(request, &[who, state], end));
        let page = table.page();
        assert!(
            page.contains("5 rows.") && page.contains("| request | who | ready | off |"),
            "{page}"
        );
        assert!(page.contains("| `run` | operator | ok | refused |"), "{page}");
        assert!(page.contains("| `run` | viewer | role |  |"), "{page}");
    }
}
