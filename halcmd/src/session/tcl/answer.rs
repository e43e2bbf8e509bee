//! Answers to the requests of a Tcl script.

use crate::{
    Error, Fault, Session,
    ini::Ini,
    language::{lex::Line, rows::rows, syntax::Statement},
};
use hal_protocol::At;
use std::path::{Path, PathBuf};

/// First text of an answer to a request that was executed.
const OK: &str = "ok";
/// First text of an answer to a request that failed. Its text and the number of the fault follow.
const ERROR: &str = "error";
/// First text of an answer that only a running machine could give.
const UNKNOWN: &str = "unknown";

/// Commands that read a value.
const READS: [&str; 4] = ["getp", "gets", "ptype", "stype"];
/// Failure code for a name that does not exist.
const ENOENT: i32 = -2;

/// A Tcl script whose requests are answered.
#[derive(Debug, Default)]
pub(crate) struct Script {
    /// Folder whose files are shown relative to another one, and that one.
    folder: (PathBuf, PathBuf),
    /// The latest fault with its number, line and place. The script reports it unless it catches the error.
    fault: Option<(u32, Fault, Line, At)>,
    faults: u32,
    /// True if an error that the script did not catch has been reported.
    pub(crate) failed: bool,
}

impl Script {
    /// Makes a script. Its files below the folder `here` are shown in messages as below `named`.
    pub(crate) fn new(here: &Path, named: &Path) -> Self {
        Self { folder: (here.to_owned(), named.to_owned()), ..Self::default() }
    }

    fn place(&self, file: &str, line: &str) -> At {
        let (here, named) = &self.folder;
        let shown = Path::new(file).strip_prefix(here).map(|rest| named.join(rest));
        let shown = shown.unwrap_or_else(|_| file.into());
        At::new(&shown.display().to_string(), line.parse().unwrap_or(0))
    }
}

impl Session<'_> {
    /// Executes a request of a Tcl script and returns the answer.
    pub(crate) fn answer(&mut self, script: &mut Script, request: &[String]) -> Vec<String> {
        let words: Vec<&str> = request.iter().map(String::as_str).collect();
        match words.as_slice() {
            ["do", file, line, ..] => {
                let at = script.place(file, line);
                self.answer_line(script, at, request.get(3..).unwrap_or_default())
            }
            ["commands"] => {
                let names = rows().map(|row| row.name.to_owned());
                std::iter::once(OK.to_owned()).chain(names).collect()
            }
            ["ini"] => self.ini.map_or_else(|| vec![OK.to_owned()], entries),
            ["ini", path] => match Ini::open(&self.found_at(path)) {
                Ok(ini) => entries(&ini),
                Err(error) => error_text(script, Error::from(error).whole()),
            },
            ["failed", file, line, number, text] => {
                let at = script.place(file, line);
                self.report_uncaught(script, at, number, text);
                vec![OK.to_owned()]
            }
            ["outside", file, line, what] => {
                let at = script.place(file, line);
                self.stop_following(&at, what);
                vec![OK.to_owned()]
            }
            _ => error_text(script, "this is no request".to_owned()),
        }
    }

    fn answer_line(&mut self, script: &mut Script, at: At, words: &[String]) -> Vec<String> {
        let split = self.words_in_pass(words);
        let words: &[String] = &split;
        let (statement, line) = Statement::of_words(words);
        let line = Line { number: at.line, ..line };
        self.stand_at(&at.file, at.line);
        self.returned = Some(String::new());
        let result = self.execute_statement(&statement, true);
        let mut out = self.returned.take().unwrap_or_default();
        if out.ends_with('\n') {
            out.pop();
        }
        let Err(fault) = result else { return vec![OK.to_owned(), out] };
        if self.is_beyond(words, &fault) {
            self.stop_following(&at, &words.join(" "));
            return vec![
                UNKNOWN.to_owned(),
                format!("only the machine knows: {}", words.join(" ")),
            ];
        }
        let mut lines = fault.error.before();
        match &*fault.error {
            Error::AlreadyReported => lines.push(format!("{} failed", words.join(" "))),
            error => lines.push(error.to_string()),
        }
        lines.extend(fault.after.iter().cloned());
        script.faults = script.faults.wrapping_add(1);
        let number = script.faults;
        script.fault = Some((number, fault, line, at));
        vec![ERROR.to_owned(), lines.join("\n"), number.to_string()]
    }

    /// Reports an error that the script did not catch: that of a HAL command as in a `.hal` file, another one with the
    /// place that Tcl states.
    fn report_uncaught(&mut self, script: &mut Script, at: At, number: &str, text: &str) {
        script.failed = true;
        match script.fault.take() {
            Some((n, fault, line, at)) if n.to_string() == number => {
                self.stand_at(&at.file, at.line);
                self.error(&fault, Some(&line));
            }
            _ => {
                self.stand_at(&at.file, at.line);
                self.report(&Error::Tcl { text: text.into() });
            }
        }
    }

    /// Returns whether a refused line may succeed on the running machine, as it needs a name that a dry run cannot know.
    fn is_beyond(&mut self, words: &[String], fault: &Fault) -> bool {
        let missing = matches!(&*fault.error, Error::Engine(failure) if failure.code == ENOENT);
        let reads = words.first().is_some_and(|w| READS.contains(&w.as_str()));
        let name = words.get(1).filter(|_| missing && reads && self.is_dry_run());
        name.is_some_and(|name| self.is_covered(name))
    }
}

fn error_text(script: &mut Script, text: String) -> Vec<String> {
    script.fault = None;
    vec![ERROR.to_owned(), text, "0".to_owned()]
}

/// Returns the answer with the entries of an INI file: section, name and value of each.
fn entries(ini: &Ini) -> Vec<String> {
    let each = ini.entries().flat_map(|e| [e.section.clone(), e.name.clone(), e.value.clone()]);
    std::iter::once(OK.to_owned()).chain(each).collect()
}
