//! The words of `order`, `graph` and `watch`: options among other words.

use crate::{
    Command, Error,
    graph::{Format, Wanted},
    language::command::{Subject, Watch},
    language::units::nanoseconds,
    programs::options::{Opt, mixed},
};
use std::path::Path;

const ORDER: &[Opt<char>] = &[Opt::short_with('i', 'i', "FILE"), long('s', "script", None)];

const fn long(id: char, name: &'static str, value: Option<&'static str>) -> Opt<char> {
    Opt { id, short: None, long: Some(name), value, variable: None, help: "" }
}

const GRAPH: &[Opt<char>] = &[
    Opt::short_with('i', 'i', "FILE"),
    Opt::short_with('o', 'o', "FILE"),
    long('d', "dot", None),
    long('m', "mermaid", None),
    long('s', "svg", None),
    long('a', "all", None),
    long('p', "params", None),
];

/// Parses the arguments of `graph`.
pub(crate) fn graph(words: &[String]) -> Result<Command, Error> {
    let (given, others) = mixed("graph", GRAPH, words)?;
    let has = |wanted| given.iter().any(|(id, _)| *id == wanted);
    let file = given.iter().rev().find(|(id, _)| *id == 'o').and_then(|(_, file)| file.clone());
    let said = given.iter().rev().find_map(|(id, _)| match id {
        'd' => Some(Format::Dot),
        'm' => Some(Format::Mermaid),
        's' => Some(Format::Svg),
        _ => None,
    });
    let format = match (said, &file) {
        (Some(said), _) => said,
        (None, Some(file)) => format_of(file)?,
        (None, None) => Format::default(),
    };
    // A word that is not a file of a machine is a pattern.
    let is_file = |w: &String| w.ends_with(".hal") || w.ends_with(".ini") || w.contains('/');
    let (files, patterns) = others.into_iter().partition(is_file);
    let wanted = Wanted { patterns, all: has('a'), params: has('p') };
    Ok(Command::Graph(subject(&given, files), wanted, format, file))
}

/// Returns the format that the name of a file asks for. Without an extension it is SVG.
fn format_of(file: &str) -> Result<Format, Error> {
    let has_extension = Path::new(file).extension().is_some();
    match Format::of(file) {
        None if has_extension => Err(Error::OptionValue {
            program: "graph",
            option: "-o".into(),
            value: file.into(),
            why: "a picture ends in .svg, .dot, .gv, .mmd or .mermaid".into(),
        }),
        format => Ok(format.unwrap_or_default()),
    }
}

/// Parses the arguments of `order`.
pub(crate) fn order(words: &[String]) -> Result<Command, Error> {
    let (given, files) = mixed("order", ORDER, words)?;
    let script = given.iter().any(|(id, _)| *id == 's');
    Ok(Command::Order(subject(&given, files), script))
}

fn subject(given: &[(char, Option<String>)], files: Vec<String>) -> Subject {
    let ini = given.iter().rev().find(|(id, _)| *id == 'i').and_then(|(_, ini)| ini.clone());
    match ini {
        // An INI file without other files is a machine.
        Some(ini) if files.is_empty() => Subject { files: vec![ini], ini: None },
        ini => Subject { files, ini },
    }
}

const WATCH: &[Opt<char>] = &[
    Opt::short_with('n', 'n', "TIME"),
    Opt { short: None, long: Some("count"), ..Opt::short_with('c', 'c', "N") },
];

/// Parses the arguments of `watch`.
pub(crate) fn watch(words: &[String]) -> Result<Watch, Error> {
    let mut watch = Watch { patterns: Vec::new(), every_ms: 200, count: None };
    let (given, patterns) = mixed("watch", WATCH, words)?;
    watch.patterns = patterns;
    for (option, value) in given {
        let value = value.unwrap_or_default();
        let bad = |why: &str| Error::OptionValue {
            program: "watch",
            option: if option == 'n' { "-n" } else { "--count" }.into(),
            value: value.as_str().into(),
            why: why.into(),
        };
        if option == 'n' {
            let ms = nanoseconds(&value).ok().map(|ns| ns / 1_000_000);
            let ms = ms.and_then(|ms| u32::try_from(ms).ok()).filter(|ms| *ms > 0);
            watch.every_ms = ms.ok_or_else(|| bad("it is a time from 1ms, such as 200ms"))?;
        } else {
            let n = value.parse().ok().filter(|n| *n > 0);
            watch.count = Some(n.ok_or_else(|| bad("it is a number from 1"))?);
        }
    }
    if watch.patterns.is_empty() {
        return Err(Error::AtLeast { command: "watch", wanted: 1, given: 0 });
    }
    Ok(watch)
}
