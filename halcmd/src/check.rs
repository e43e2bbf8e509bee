//! `halcmd check`: reports errors and oddities of a machine before it moves.

pub(crate) mod examine;
pub(crate) mod plausible;

mod advice;
mod allow;
mod arrows;
mod collect;
mod converter;
mod coordinates;
mod entries;
mod joints;
mod parts;
mod refused;
mod render;
mod repeated;
mod sarif;
mod sections;
mod texts;
mod tools;
mod unused;

pub use allow::Allowed;

pub use collect::{Checked, check, live};
pub use texts::Texts;

use crate::{
    Error, Terminal,
    programs::halrun::folders::plugin_path,
    programs::options::{Opt, mixed, usage},
    programs::profile::Profile,
};
use hal_protocol::{Finding, Level, Link, Reply};
use render::Shown;

/// The options of `halcmd check`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Id {
    Ini,
    Json,
    Sarif,
    Level,
    All,
    Parts,
    Help,
}

const OPTIONS: &[Opt<Id>] = &[
    Opt { help: "take [SECTION]NAME from this INI file", ..Opt::short_with(Id::Ini, 'i', "FILE") },
    long("json", Id::Json, None, "print the findings as JSON"),
    long("sarif", Id::Sarif, None, "print them as SARIF 2.1.0, for editors and CI"),
    long("level", Id::Level, Some("LEVEL"), "print only from this level: note, warning or error"),
    long("all", Id::All, None, "print also the notes that ask for nothing"),
    long(
        "parts",
        Id::Parts,
        None,
        "print what the machine is made of, and what of it is not there",
    ),
    Opt { long: Some("help"), help: "print this", ..Opt::flag(Id::Help, 'h') },
];

const fn long(
    name: &'static str,
    id: Id,
    value: Option<&'static str>,
    help: &'static str,
) -> Opt<Id> {
    Opt { id, short: None, long: Some(name), value, variable: None, help }
}

/// Options that the user gave before the word `check`.
#[derive(Clone, Debug, Default)]
pub struct Before {
    /// `-i`.
    pub ini: Option<String>,
    /// `--json`.
    pub json: bool,
}

/// Runs `halcmd check WORDS…`. Without files it checks the running instance. Returns the status of
/// the worst finding: 0 none or notes, 1 warnings, 2 errors.
///
/// # Errors
/// An option is invalid, or there is no instance.
pub fn main(
    words: &[String],
    before: Before,
    link: &mut dyn Link,
    terminal: &mut dyn Terminal,
) -> Result<u8, Error> {
    let (given, files) = mixed("halcmd check", OPTIONS, words)?;
    let has = |wanted| given.iter().any(|(id, _)| *id == wanted);
    let value = |wanted| given.iter().rev().find(|(id, _)| *id == wanted)?.1.clone();
    if has(Id::Help) {
        terminal.out(&help())?;
        return Ok(0);
    }
    if has(Id::Parts) {
        let profile = Profile::of_environment()?;
        let ini = value(Id::Ini).or(before.ini);
        let plugins = plugin_path(&|name| profile.system(name));
        terminal.out(&parts::text(&files, ini.as_deref(), plugins)?)?;
        return Ok(0);
    }
    let from = value(Id::Level).map(|word| level(&word)).transpose()?.unwrap_or(Level::Note);
    let ini = value(Id::Ini).or(before.ini);
    let checked = if files.is_empty() {
        live(link)?
    } else {
        check(&files, ini.as_deref(), {
            let profile = Profile::of_environment()?;
            plugin_path(&|name| profile.system(name))
        })
    };
    let shown: Vec<Finding> =
        checked.findings.iter().filter(|f| f.level >= from).cloned().collect();
    let text = if has(Id::Sarif) {
        sarif::write(&shown)?
    } else if has(Id::Json) || before.json {
        let reply = Reply::Findings(shown);
        format!("{}\n", serde_json::to_string(&reply).map_err(|_| Error::Unexpected)?)
    } else {
        // Notes that ask for nothing would hide those that do.
        let (asking, idle): (Vec<Finding>, Vec<Finding>) =
            shown.into_iter().partition(|f| has(Id::All) || !asks_nothing(f));
        let mut text = render::write(&asking, &checked.texts, Shown::for_terminal());
        if !idle.is_empty() {
            let notes = if idle.len() == 1 { "note asks" } else { "notes ask" };
            text.push_str(&format!("{} {notes} for nothing: --all shows more\n", idle.len()));
        }
        text
    };
    terminal.out(&text)?;
    Ok(status(&checked.findings))
}

/// Returns whether a finding is a note whose remedy is to do nothing.
fn asks_nothing(finding: &Finding) -> bool {
    finding.level == Level::Note && finding.remedy.starts_with("nothing,")
}

/// Returns all findings as text, with the lines that they are about.
pub(crate) fn text(checked: &Checked) -> String {
    render::write(&checked.findings, &checked.texts, Shown::for_terminal())
}

/// Returns the status of the worst finding.
#[must_use]
pub fn status(findings: &[Finding]) -> u8 {
    match findings.iter().map(|f| f.level).max() {
        None | Some(Level::Note) => 0,
        Some(Level::Warning) => 1,
        Some(Level::Error) => 2,
    }
}

fn level(word: &str) -> Result<Level, Error> {
    let all = [Level::Note, Level::Warning, Level::Error];
    all.into_iter().find(|l| l.name() == word).ok_or_else(|| Error::OptionValue {
        program: "halcmd check",
        option: "--level".into(),
        value: word.into(),
        why: "it is note, warning or error".into(),
    })
}

fn help() -> String {
    format!(
        "\nUsage:   halcmd check [options] FILE.hal...\n         \
         halcmd check [options] MACHINE.ini\n         halcmd check [options]\n\n\
         Says everything that is wrong or odd with scripts, with a machine, or with the instance\n\
         that runs. Nothing is opened and nothing moves. The status is that of the worst finding:\n\
         0 none or notes, 1 warnings, 2 errors. 'halcmd explain CODE' tells more. A comment\n\
         '# check: allow CODE why' on a line, or above it, allows a note or warning there.\n\n\
         options:\n{}",
        usage(OPTIONS)
    )
}
