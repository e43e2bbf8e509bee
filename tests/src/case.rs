//! Test cases as data: a folder with a script and its expected result.

use crate::{
    golden,
    programs::{programs, root},
    scratch::Scratch,
};
use std::{
    collections::BTreeMap,
    fmt::Write,
    fs,
    path::{Path, PathBuf},
};

/// A folder of `tests/hal` or `tests/tcl`.
///
/// - `test.hal`: the script.
/// - `expected`: exit status, standard output, standard error, and the files that the run wrote. `<pid>` stands for any
///   decimal number, `<hex>` for any hexadecimal one, `<dir>` for the folder in which the case runs.
/// - `args`: arguments of halrun; `--virtual -f test.hal` by default.
/// - Every other file is copied beside the script for the run.
#[derive(Clone, Debug)]
pub struct Case {
    /// Name of the folder.
    pub name: String,
    folder: PathBuf,
}

/// Surroundings in which a case runs.
#[derive(Clone, Debug, Default)]
pub struct Around<'a> {
    /// Command, with its arguments, that runs halrun.
    pub before: Vec<&'a str>,
    /// Environment variables to set.
    pub environment: Vec<(&'a str, &'a str)>,
}

/// Returns every case of `tests/hal`; if `CASE` is set, only those whose names begin with it.
pub fn cases() -> Vec<Case> {
    cases_in("tests/hal")
}

/// Returns every case of a folder; if `CASE` is set, only those whose names begin with it.
pub fn cases_in(folder: &str) -> Vec<Case> {
    let wanted = std::env::var("CASE").unwrap_or_default();
    let mut cases: Vec<Case> = fs::read_dir(root().join(folder))
        .unwrap()
        .map(|e| e.unwrap().path())
        .filter(|p| p.join("test.hal").is_file())
        .map(|folder| Case {
            name: folder.file_name().unwrap().to_string_lossy().into_owned(),
            folder,
        })
        .filter(|c| c.name.starts_with(&wanted))
        .collect();
    cases.sort_by(|a, b| a.name.cmp(&b.name));
    cases
}

impl Case {
    /// Runs the case and returns its result in the format of `expected`.
    pub fn run(&self, around: &Around<'_>) -> String {
        let scratch = Scratch::copy_of(&self.folder);
        let given = scratch.files();
        let args = given.get("args").map_or("--virtual -f test.hal".into(), |args| {
            String::from_utf8_lossy(args).trim().to_owned()
        });
        let mut command = scratch.command(&around.before, "halrun");
        command.args(args.split_whitespace()).envs(around.environment.iter().copied());
        let output = scratch.run(&mut command);
        let mut text = output.status.map_or("killed\n".into(), |s| format!("status {s}\n"));
        let mut files = vec![
            ("stdout".to_owned(), output.stdout.into_bytes()),
            ("stderr".to_owned(), output.stderr.into_bytes()),
        ];
        // A journal has the times of files.
        let is_new = |(name, bytes): &(String, Vec<u8>)| {
            given.get(name) != Some(bytes) && !name.ends_with(".journal")
        };
        files.extend(scratch.files().into_iter().filter(is_new));
        for left in scratch.left() {
            files.push((format!("left behind: {left}"), Vec::new()));
        }
        for (name, bytes) in files.iter().filter(|(_, bytes)| !bytes.is_empty()) {
            let body = String::from_utf8_lossy(bytes);
            let end = if body.ends_with('\n') { "" } else { "\\\n" };
            write!(text, "--- {name}\n{body}{end}").unwrap();
        }
        let places = [(programs(), "<bin>"), (scratch.path(), "<dir>")];
        places.iter().fold(text, |t, (p, word)| t.replace(&p.display().to_string(), word))
    }

    /// Runs the case and compares. With `UPDATE_EXPECT=1`, the result is written to `expected` instead.
    ///
    /// # Errors
    /// The result differs: the case, and the first difference.
    pub fn check(&self) -> Result<(), String> {
        let got = self.run(&Around::default());
        let compared = self.compare(&got);
        if compared.is_err() && golden::is_update() {
            fs::write(self.path(), merged(&self.expected(), &got)).unwrap();
            return Ok(());
        }
        compared
    }

    /// Runs the case in other surroundings and compares.
    ///
    /// # Errors
    /// The result differs.
    pub fn check_in(&self, around: &Around<'_>) -> Result<(), String> {
        self.compare(&self.run(around))
    }

    fn compare(&self, got: &str) -> Result<(), String> {
        let expected = self.expected();
        if matches(&expected, got) {
            return Ok(());
        }
        Err(format!("{}:\n{}", short(&self.path()), difference(&expected, got)))
    }

    fn expected(&self) -> String {
        fs::read_to_string(self.path()).unwrap_or_default()
    }

    fn path(&self) -> PathBuf {
        self.folder.join("expected")
    }
}

/// Runs a function for every case, several at once, and panics with the list of all failures.
pub fn for_each(cases: &[Case], run: impl Fn(&Case) -> Result<(), String> + Sync) {
    let lanes = 4;
    let wrong: BTreeMap<&str, String> = std::thread::scope(|scope| {
        let lanes: Vec<_> = (0..lanes)
            .map(|lane| {
                let own: Vec<&Case> = cases.iter().skip(lane).step_by(lanes).collect();
                let run = &run;
                scope.spawn(move || {
                    let wrong = own.into_iter().filter_map(|c| Some((&*c.name, run(c).err()?)));
                    wrong.collect::<Vec<_>>()
                })
            })
            .collect();
        lanes.into_iter().flat_map(|lane| lane.join().unwrap()).collect()
    });
    let texts: Vec<String> = wrong.into_values().collect();
    assert!(texts.is_empty(), "{} of {} cases:\n{}", texts.len(), cases.len(), texts.join("\n"));
}

/// Returns whether two texts are equal, apart from the placeholders of `expected`.
fn matches(expected: &str, got: &str) -> bool {
    expected.lines().count() == got.lines().count()
        && expected.ends_with('\n') == got.ends_with('\n')
        && expected.lines().zip(got.lines()).all(|(e, g)| line_matches(e, g))
}

fn line_matches(expected: &str, got: &str) -> bool {
    let open = [("<pid>", 10), ("<hex>", 16)];
    let next = open.iter().filter_map(|(w, radix)| Some((expected.find(w)?, w, radix))).min();
    let Some((at, word, radix)) = next else { return expected == got };
    let (before, after) = (expected.get(..at), expected.get(at + word.len()..));
    let Some(rest) = before.and_then(|b| got.strip_prefix(b)) else { return false };
    let digits = rest.find(|c: char| !c.is_digit(*radix)).unwrap_or(rest.len());
    digits > 0 && line_matches(after.unwrap_or_default(), rest.get(digits..).unwrap_or_default())
}

/// Returns the new text with the placeholders of `expected` kept where they still match.
fn merged(expected: &str, got: &str) -> String {
    let old: Vec<&str> = expected.lines().filter(|l| l.contains('<')).collect();
    got.lines().fold(String::new(), |mut text, line| {
        text.push_str(old.iter().find(|o| line_matches(o, line)).unwrap_or(&line));
        text.push('\n');
        text
    })
}

/// Returns the first lines that differ, placeholders aside, with some context.
fn difference(expected: &str, got: &str) -> String {
    golden::differing(expected, got, line_matches)
}

fn short(path: &Path) -> String {
    path.strip_prefix(root()).unwrap_or(path).display().to_string()
}

#[cfg(test)]
mod tests {
    use super::{line_matches, matches, merged};

    #[test]
    fn open_places() {
        for (expected, got, same) in [
            ("a", "a", true),
            ("a", "ab", false),
            ("x <pid> y", "x 123 y", true),
            ("x <pid> y", "x  y", false),
            ("x <pid> y", "x 12a y", false),
            ("<hex> <pid>", "00ff 7", true),
            ("<hex>", "", false),
        ] {
            assert_eq!(line_matches(expected, got), same, "{expected} {got}");
        }
        assert!(!matches("a\n", "a"));
        assert!(!matches("a\nb\n", "a\n"));
        assert_eq!(merged("old\np <pid>\n", "p 7\nnew\n"), "p <pid>\nnew\n");
    }
}
