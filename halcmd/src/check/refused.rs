//! Findings for refused lines.

use crate::{
    Error,
    ini::{Entry, Ini, placed},
    programs::halrun::data::argument,
    session::dry_run::Notice,
};
use hal_protocol::{At, Code, Finding};

/// Converts the error of a refused line to a finding.
pub(super) fn finding(mut at: At, error: &Error) -> Finding {
    let mut text = error.to_string();
    let remedy = match error {
        Error::UnterminatedQuote => "close it with another \", or take the \" out".to_owned(),
        _ => error.hint().unwrap_or_default(),
    };
    if let (Error::NotYet { .. }, Some((place, rest))) = (error, placed(&text)) {
        (at, text) = (place, rest.to_owned());
    }
    let code = match code(error) {
        // Entries of an INI file become arguments of motion's commands.
        Code::Refused | Code::BadArgument if at.file.ends_with(".ini") => Code::MotionRefuses,
        code => code,
    };
    let (word, kind) = match error {
        Error::Engine(failure) => (failure.word.clone(), failure.kind),
        _ => (None, None),
    };
    let subject = word.unwrap_or_else(|| quoted(&text).to_owned());
    let finding = Finding::new(code, &subject, text).at(Some(at)).remedy(remedy);
    Finding { kind, ..finding }
}

/// Moves a finding about a refused command of motion to the INI entry that the message names. The
/// finding had the line at which the section begins.
pub(super) fn at_entry(mut finding: Finding, ini: &Ini) -> Finding {
    let is_here =
        |e: &&Entry| finding.at.as_ref().is_some_and(|at| at.file == e.file && at.line == e.line);
    let Some(section) = ini.entries().find(is_here).map(|e| e.section.clone()) else {
        return finding;
    };
    let named = |e: &&Entry| {
        let arg = argument(e);
        finding.text.split(|c: char| c.is_whitespace() || c == '=' || c == '`').any(|w| w == arg)
    };
    let entry = ini.section(&section).find(named);
    if let Some(e) = entry {
        finding.subject = format!("[{}]{}", e.section, e.name);
        finding.at = Some(At::new(&e.file, e.line));
    }
    finding
}

/// Converts a warning about a line to a finding.
pub(super) fn notice(notice: &Notice) -> Finding {
    let text = notice.text.strip_prefix("Warning: ").unwrap_or(&notice.text);
    let remedy = match notice.code {
        Code::NoPostgui => "make the file, or take the entry out",
        Code::IniIgnored => "correct the line, or make it a comment with # at its beginning",
        Code::DosLines => "save the file with lines that end in a line feed alone",
        _ => "",
    };
    let finding = Finding::new(notice.code, quoted(text), text.to_owned());
    finding.at(Some(notice.at.clone())).remedy(remedy)
}

/// Returns the place that an error contains.
pub(super) fn place(error: &Error) -> Option<At> {
    match error {
        Error::Ini(hal_ini::Error::Syntax { path, line, .. }) => Some(At::new(path, *line)),
        Error::Ini(hal_ini::Error::File { path, .. })
        | Error::NoFile { path, .. }
        | Error::NoCommandFile { path, .. } => Some(At::new(path, 0)),
        _ => None,
    }
}

fn code(error: &Error) -> Code {
    match error {
        Error::Engine(failure) => failure.finding.unwrap_or(Code::Refused),
        Error::UnterminatedQuote
        | Error::TooManyTokens
        | Error::CarriageReturn
        | Error::LineTooLong
        | Error::EmptyVariable
        | Error::MissingParenthesis
        | Error::MissingBracket
        | Error::VariableTooLong => Code::Unreadable,
        Error::UnknownCommand { .. } => Code::UnknownCommand,
        Error::NoEnvironment { .. } => Code::NoEnvironment,
        Error::NoIniVariable { .. } => Code::NoIniEntry,
        Error::NoFile { .. }
        | Error::NoCommandFile { .. }
        | Error::TooDeep { .. }
        | Error::TooManySourced { .. } => Code::NoFile,
        Error::Ini(_) => Code::IniUnreadable,
        Error::IniNotFound { .. } => Code::NoHalfile,
        Error::NotYet { .. } => Code::NotSupported,
        Error::NotLoaded { .. } => Code::NoSuchName,
        Error::Exactly { .. }
        | Error::AtLeast { .. }
        | Error::AtMost { .. }
        | Error::SignalType { .. }
        | Error::FilterType { .. }
        | Error::NoPin
        | Error::AliasKind { .. }
        | Error::NoFunct
        | Error::NoThread
        | Error::Level
        | Error::Switch { .. }
        | Error::Kind { .. }
        | Error::Time { .. }
        | Error::BadOption { .. }
        | Error::NeedsArgument { .. }
        | Error::NoProgram => Code::WrongWords,
        _ => Code::Refused,
    }
}

/// Returns the first word in quotes.
fn quoted(text: &str) -> &str {
    let mut parts = text.split(['\'', '`']);
    parts.nth(1).unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use super::at_entry;
    use crate::ini::Ini;
    use hal_protocol::{At, Code, Finding};

    #[test]
    fn a_refused_argument_is_at_its_entry() {
        let text = "[TRAJ]\nLINEAR_UNITS = mm\nMAX_LINEAR_VELOCITY = 0\n[JOINT_0]\nHOME = 1\nMAX_VELOCITY = 0\n";
        let ini = Ini::parse("a.ini", text.as_bytes()).unwrap();
        for (line, words, expected, at) in [
            (2, "max-velocity is 0, must be above 0", "[TRAJ]MAX_LINEAR_VELOCITY", 3),
            (5, "max-velocity is 0, must be above 0", "[JOINT_0]MAX_VELOCITY", 6),
            (5, "the joint is not there", "", 5),
        ] {
            let finding = Finding::new(Code::MotionRefuses, "", words.to_owned());
            let finding = at_entry(finding.at(Some(At::new("a.ini", line))), &ini);
            let found = (finding.subject.as_str(), finding.at.unwrap().line);
            assert_eq!(found, (expected, at), "{words}");
        }
    }
}
