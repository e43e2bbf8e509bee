//! Number of tests of each component, counted in the sources of its library.
//!
//! A test function counts if it is in the component's own file, if it names the component or its type, or if the
//! library has no other component. Rows are the rows of the recorded tables in the library's folder `traces` that load
//! it.

use crate::programs::{family, files_below};
use std::{fs, path::Path};

/// Counts for one component.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Counted {
    /// Number of test functions.
    pub tests: usize,
    /// Number of rows of recorded tables.
    pub rows: usize,
}

/// Sources of a library: its files with their names, and its tables.
#[derive(Debug)]
pub struct Sources {
    files: Vec<(String, String)>,
    tables: Vec<String>,
}

impl Sources {
    /// Reads the sources of a library of `components`.
    pub fn of(library: &str) -> Self {
        let folder = family(library);
        let text = |path: &Path| fs::read_to_string(path).unwrap();
        let stem = |path: &Path| path.file_stem().unwrap().to_string_lossy().into_owned();
        let of = |ending| files_below(&folder, ending).into_iter();
        Self {
            files: of(".rs").map(|p| (stem(&p), text(&p))).collect(),
            tables: of(".txt").map(|p| text(&p)).collect(),
        }
    }

    /// Counts the tests of a component under all its names. `is_alone`: the library has no other component.
    pub fn count(&self, names: &[&str], is_alone: bool) -> Counted {
        // No file and no type begins with a digit.
        let spelled = |n: &str| n.replace('-', "_").replace("5axis", "fiveaxis");
        let same = |file: &str| names.iter().any(|n| spelled(n) == spelled(file));
        let mut out = Counted::default();
        for (file, text) in &self.files {
            let own = is_alone || same(file);
            let counts = |test: &&str| own || names.iter().any(|name| tells_of(test, name));
            out.tests += tests(text).iter().filter(|test| counts(test)).count();
        }
        for table in &self.tables {
            let mut mine = false;
            for line in table.lines() {
                if let Some(words) = line.strip_prefix("load ") {
                    mine = words.split(' ').next().is_some_and(&same);
                }
                out.rows += usize::from(mine && !line.starts_with('#') && line.contains(" | "));
            }
        }
        out
    }
}

/// Returns the test functions of a file, each with its body, up to the closing brace at the indentation of its start.
fn tests(text: &str) -> Vec<&str> {
    const MARK: &str = "#[test]\n";
    let begins = text.match_indices(MARK).map(|(at, _)| at);
    begins
        .map(|at| {
            let line = text[..at].rfind('\n').map_or(0, |n| n + 1);
            let rest = &text[at..];
            rest.find(&format!("\n{}}}", &text[line..at])).map_or(rest, |end| &rest[..end])
        })
        .collect()
}

/// Returns whether a text contains a component's name, or that of its type, as a word.
fn tells_of(text: &str, name: &str) -> bool {
    let camel: String = name
        .split(['-', '_'])
        .flat_map(|word| {
            let mut letters = word.chars();
            letters.next().map(|c| c.to_ascii_uppercase()).into_iter().chain(letters)
        })
        .collect();
    let forms = [name.to_owned(), name.replace('_', "-"), name.replace('-', "_"), camel];
    forms.iter().any(|form| {
        text.match_indices(form.as_str()).any(|(at, _)| {
            let inside = |c: char| c.is_alphanumeric() || c == '_';
            !text[..at].ends_with(|c| inside(c) || c == '-')
                && !text[at + form.len()..].starts_with(|c| inside(c) || c == '-')
        })
    })
}

#[cfg(test)]
mod tests {
    use super::{Counted, Sources};

    #[test]
    fn what_tells_of_a_component_counts() {
        let file = "    #[test]\n    fn a() {\n        load::<SumTwo>();\n    }\n\n    #[test]\n    fn b() {\n        \
            run(\"sum-two.0\");\n    }\n\n    #[test]\n    fn c() {\n        run(\"sum-two-more.0\");\n        \
            x(sum_two_more, MySumTwo);\n    }\n";
        let table = "load sum_two\n# a | b\n1 | 2\n2 | 3\nload other\n1 | 1\n";
        let sources = Sources {
            files: vec![("lib".to_owned(), file.to_owned())],
            tables: vec![table.to_owned()],
        };
        let count = |name: &str, alone| sources.count(&[name], alone);
        assert_eq!(count("sum_two", false), Counted { tests: 2, rows: 2 });
        assert_eq!(count("sum_two_more", false), Counted { tests: 1, rows: 0 });
        assert_eq!(count("other", false), Counted { tests: 0, rows: 1 });
        assert_eq!(count("other", true), Counted { tests: 3, rows: 1 });
        assert_eq!(sources.count(&["lib", "third"], false).tests, 3);
    }
}
