//! Parsers of the commands' arguments. The table has checked the number of arguments.

use crate::{
    Command, Error,
    language::command::{Apply, Launch, SaveKind, ShowKind, StatusKind},
    language::row::{KINDS, SAVES, STATUSES},
    language::units::nanoseconds,
    programs::options::{Opt, mixed, options},
};
use core::num::{IntErrorKind, ParseIntError};
use hal_protocol::{Kind, Request, Type};
use std::path::Path;

pub(crate) fn first(words: &[String]) -> String {
    words.first().cloned().unwrap_or_default()
}

/// Replaces a leading `~` in the name of a file.
pub(crate) fn path(word: &str) -> String {
    match word.starts_with('~') {
        true => hal_ini::beside(Path::new(""), word).display().to_string(),
        false => word.to_owned(),
    }
}

const IN_C: &[Opt<&str>] = &[
    Opt { id: "c", short: None, long: Some("c"), value: None, variable: None, help: "" },
    Opt {
        id: "prefix",
        short: None,
        long: Some("prefix"),
        value: Some("P"),
        variable: None,
        help: "",
    },
];

pub(crate) fn loadrt(words: &[String]) -> Result<Command, Error> {
    let (given, rest) = options("loadrt", IN_C, words)?;
    let (module, args) = (first(&rest), rest.get(1..).unwrap_or_default().to_vec());
    let note = format!("Realtime module '{module}' loaded");
    let prefix = given.iter().find_map(|(_, value)| value.clone());
    let request = if given.is_empty() {
        Request::Load { module, args }
    } else {
        Request::LoadForeign { module, args, prefix: prefix.unwrap_or_default() }
    };
    Ok(Command::Send(request, Some(note)))
}

pub(crate) fn unloadrt(words: &[String]) -> Result<Command, Error> {
    let name = first(words);
    if name == "all" {
        return Ok(Command::Send(Request::UnloadAll, None));
    }
    let note = format!("Realtime module '{name}' unloaded");
    Ok(Command::Send(Request::Unload { name }, Some(note)))
}

pub(crate) fn unloadusr(words: &[String]) -> Result<Command, Error> {
    let name = Some(first(words)).filter(|n| n != "all");
    Ok(Command::Send(Request::EndProgram { name }, None))
}

const LAUNCH: &[Opt<char>] = &[
    Opt::flag('w', 'w'),
    Opt::flag('W', 'W'),
    Opt::flag('i', 'i'),
    Opt::short_with('n', 'n', "NAME"),
];

pub(crate) fn loadusr(words: &[String]) -> Result<Command, Error> {
    let (given, rest) = options("loadusr", LAUNCH, words)?;
    let mut launch = Launch::default();
    for (option, value) in given {
        match option {
            'w' => launch.until_end = true,
            'W' => launch.until_ready = true,
            'i' => launch.ignore_status = true,
            _ => launch.component = value,
        }
    }
    let (program, args) = rest.split_first().ok_or(Error::NoProgram)?;
    launch.program = path(program);
    launch.args = args.to_vec();
    Ok(Command::Launch(launch))
}

pub(crate) fn net(words: &[String]) -> Result<Command, Error> {
    let Some((signal, pins)) = words.split_first().filter(|(_, pins)| !pins.is_empty()) else {
        return Err(Error::NoPin);
    };
    let notes: Vec<String> =
        pins.iter().map(|pin| format!("Pin '{pin}' linked to signal '{signal}'")).collect();
    let request = Request::Net { signal: signal.clone(), pins: pins.to_vec() };
    Ok(Command::Send(request, Some(notes.join("\n"))))
}

pub(crate) fn linkps(words: &[String]) -> Result<Command, Error> {
    let [pin, signal] = words else { return Err(Error::Unexpected) };
    let note = format!("Pin '{pin}' linked to signal '{signal}'");
    Ok(Command::Send(Request::Link { pin: pin.clone(), signal: signal.clone() }, Some(note)))
}

pub(crate) fn linksp(words: &[String]) -> Result<Command, Error> {
    let [signal, pin] = words else { return Err(Error::Unexpected) };
    linkps(&[pin.clone(), signal.clone()])
}

pub(crate) fn unlinkp(words: &[String]) -> Result<Command, Error> {
    let pin = first(words);
    let note = format!("Pin '{pin}' unlinked");
    Ok(Command::Send(Request::Unlink { pin }, Some(note)))
}

pub(crate) fn newsig(words: &[String]) -> Result<Command, Error> {
    let [name, ty] = words else { return Err(Error::Unexpected) };
    let ty = Type::parse(ty).ok_or_else(|| Error::SignalType { word: ty.as_str().into() })?;
    Ok(Command::Send(Request::NewSignal { name: name.clone(), ty }, None))
}

pub(crate) fn delsig(words: &[String]) -> Result<Command, Error> {
    let name = Some(first(words)).filter(|n| n != "all");
    let note = name.as_ref().map(|n| format!("Signal '{n}' deleted'"));
    Ok(Command::Send(Request::DeleteSignal { name }, note))
}

pub(crate) fn setp(words: &[String]) -> Result<Command, Error> {
    let [name, value] = words else { return Err(Error::Unexpected) };
    Ok(Command::Send(Request::Set { name: name.clone(), value: value.clone() }, None))
}

pub(crate) fn sets(words: &[String]) -> Result<Command, Error> {
    let [name, value] = words else { return Err(Error::Unexpected) };
    Ok(Command::Send(Request::SetSignal { name: name.clone(), value: value.clone() }, None))
}

pub(crate) fn addf(words: &[String], init: bool) -> Result<Command, Error> {
    let [funct, thread, ..] = words else { return Err(Error::Unexpected) };
    // As in C's atoi, a text that is not a number is 0, which the engine refuses by name.
    let position = words.get(2).map_or(-1, |w| leading_number(w));
    let note = if init {
        format!("Init function '{funct}' registered on thread '{thread}'")
    } else {
        format!("Function '{funct}' added to thread '{thread}'")
    };
    let (funct, thread) = (funct.clone(), thread.clone());
    Ok(Command::Send(Request::AddFunct { funct, thread, position, init }, Some(note)))
}

pub(crate) fn delf(words: &[String]) -> Result<Command, Error> {
    let funct = words.first().ok_or(Error::NoFunct)?.clone();
    let thread = words.get(1).ok_or(Error::NoThread)?.clone();
    let note = format!("Function '{funct}' removed from thread '{thread}'");
    Ok(Command::Send(Request::RemoveFunct { funct, thread: Some(thread) }, Some(note)))
}

const APPLY: &[Opt<char>] =
    &[Opt { long: Some("dry-run"), ..Opt::flag('d', 'n') }, Opt::short_with('i', 'i', "INI")];

pub(crate) fn apply(words: &[String]) -> Result<Command, Error> {
    let mut apply = Apply::default();
    let (given, files) = mixed("apply", APPLY, words)?;
    for (option, value) in given {
        match option {
            'd' => apply.dry = true,
            _ => apply.ini = value.map(|v| path(&v)),
        }
    }
    let [file] = files.as_slice() else {
        return Err(Error::Exactly { command: "apply", wanted: 1, given: files.len() });
    };
    apply.file = (file != "-").then(|| path(file));
    Ok(Command::Apply(apply))
}

pub(crate) fn show(words: &[String]) -> Result<Command, Error> {
    let Some((kind, rest)) = words.split_first() else {
        return Ok(Command::Show(None, None, Vec::new()));
    };
    let kind = match kind.as_str() {
        "all" => None,
        "alias" => Some(ShowKind::Aliases),
        word => {
            let known = KINDS.iter().find(|(name, _)| *name == word);
            let all = [&[("all", Kind::Pins), ("alias", Kind::Pins)], KINDS].concat();
            Some(ShowKind::Of(known.ok_or_else(|| unknown_kind("show", word, &all))?.1))
        }
    };
    let typed = matches!(kind, Some(ShowKind::Of(Kind::Pins | Kind::Params | Kind::Signals)));
    let (ty, patterns) = match rest.split_first() {
        Some((option, rest)) if typed && option == "-t" => match rest.split_first() {
            Some((ty, rest)) => (Some(filter(ty)?), rest),
            None => return Err(Error::NeedsArgument { command: "show", option: 't' }),
        },
        Some((option, rest)) if typed && option.starts_with("-t") => {
            (Some(filter(option.strip_prefix("-t").unwrap_or_default())?), rest)
        }
        _ => (None, rest),
    };
    Ok(Command::Show(kind, ty, patterns.to_vec()))
}

pub(crate) fn list(words: &[String]) -> Result<Command, Error> {
    let (word, patterns) = words.split_first().ok_or(Error::Unexpected)?;
    let kind = KINDS.iter().find(|(name, _)| name == word);
    let kind = kind.ok_or_else(|| unknown_kind("list", word, KINDS))?.1;
    Ok(Command::List(kind, patterns.to_vec()))
}

pub(crate) fn save(words: &[String]) -> Result<Command, Error> {
    let Some(word) = words.first() else { return Ok(Command::Save(SaveKind::All, None)) };
    let kind = SAVES.iter().find(|(name, _)| name == word);
    let kind = kind.ok_or_else(|| unknown_kind("save", word, SAVES))?.1;
    Ok(Command::Save(kind, words.get(1).map(|w| path(w))))
}

pub(crate) fn status(words: &[String]) -> Result<Command, Error> {
    let Some(word) = words.first() else { return Ok(Command::Status(StatusKind::All)) };
    let kind = STATUSES.iter().find(|(name, _)| name == word);
    Ok(Command::Status(kind.ok_or_else(|| unknown_kind("status", word, STATUSES))?.1))
}

pub(crate) fn alias(words: &[String]) -> Result<Command, Error> {
    let [kind, name, alias] = words else { return Err(Error::Unexpected) };
    let param = is_param("alias", kind)?;
    let note = format!("{kind} '{name}' aliased to '{alias}'");
    let (name, alias) = (name.clone(), alias.clone());
    Ok(Command::Send(Request::Alias { param, name, alias }, Some(note)))
}

pub(crate) fn unalias(words: &[String]) -> Result<Command, Error> {
    let [kind, name] = words else { return Err(Error::Unexpected) };
    let param = is_param("unalias", kind)?;
    let note = format!("{kind} '{name}' unaliased");
    Ok(Command::Send(Request::Unalias { param, name: name.clone() }, Some(note)))
}

pub(crate) fn run(words: &[String]) -> Result<Command, Error> {
    let word = first(words);
    let ns = nanoseconds(&word).map_err(|_| Error::Time { word: word.into() })?;
    Ok(Command::Send(Request::Run { ns }, None))
}

pub(crate) fn record(words: &[String]) -> Result<Command, Error> {
    let (file, patterns) = words.split_first().ok_or(Error::Unexpected)?;
    if file == "off" && patterns.is_empty() {
        return Ok(Command::Send(Request::EndRecord, None));
    }
    let file = path(file.trim_matches('"'));
    let whole = std::path::absolute(&file).map_or(file, |p| p.display().to_string());
    Ok(Command::Send(Request::Record { path: whole, patterns: patterns.to_vec() }, None))
}

pub(crate) fn debug(words: &[String]) -> Result<Command, Error> {
    let level = u8::try_from(leading_number(&first(words))).ok().filter(|l| *l <= 5);
    Ok(Command::Send(Request::MessageLevel { level: level.ok_or(Error::Level)? }, None))
}

pub(crate) fn timing(words: &[String]) -> Result<Command, Error> {
    let on = match first(words).as_str() {
        "on" => true,
        "off" => false,
        _ => return Err(Error::Switch { word: first(words).into() }),
    };
    Ok(Command::Send(Request::Timing { thread: words.get(1).cloned(), on }, None))
}

fn filter(word: &str) -> Result<Type, Error> {
    Type::parse(word).ok_or_else(|| Error::FilterType { word: word.into() })
}

fn is_param(command: &'static str, word: &str) -> Result<bool, Error> {
    match word {
        "pin" => Ok(false),
        "param" => Ok(true),
        _ => Err(Error::AliasKind { command, word: word.into() }),
    }
}

pub(crate) fn unknown_kind<T>(command: &'static str, word: &str, kinds: &[(&str, T)]) -> Error {
    let kinds: Vec<&str> = kinds.iter().map(|(name, _)| *name).collect();
    Error::Kind { command, word: word.into(), kinds: kinds.join(", ").into() }
}

/// Returns the number at the beginning of a word, or 0. A number beyond 64 bits becomes the largest
/// or smallest one.
fn leading_number(word: &str) -> i64 {
    let end = word
        .char_indices()
        .find(|(i, c)| !(c.is_ascii_digit() || (*i == 0 && (*c == '-' || *c == '+'))))
        .map_or(word.len(), |(i, _)| i);
    let number = word.get(..end).unwrap_or_default();
    number.parse().unwrap_or_else(|e: ParseIntError| match e.kind() {
        IntErrorKind::PosOverflow => i64::MAX,
        IntErrorKind::NegOverflow => i64::MIN,
        _ => 0,
    })
}
