//! Command line options: by the rules of POSIX, where the first other word ends them, or mixed with other words.

use crate::language::hint::nearest;
use crate::{Error, Stdio, Terminal, terminal::print_error};
use std::process::ExitCode;

/// An option.
#[derive(Clone, Copy, Debug)]
pub struct Opt<T: 'static> {
    /// Identifier for the program.
    pub id: T,
    /// Letter of `-x`.
    pub short: Option<char>,
    /// Name of `--name`.
    pub long: Option<&'static str>,
    /// Name of its argument, if it takes one.
    pub value: Option<&'static str>,
    /// Environment variable with the same effect.
    pub variable: Option<&'static str>,
    /// Description.
    pub help: &'static str,
}

impl<T: Copy> Opt<T> {
    /// Makes an option `-x` without an argument.
    #[must_use]
    pub const fn flag(id: T, short: char) -> Self {
        Self { id, short: Some(short), long: None, value: None, variable: None, help: "" }
    }

    /// Makes an option `-x VALUE`.
    #[must_use]
    pub const fn short_with(id: T, short: char, value: &'static str) -> Self {
        Self { id, short: Some(short), long: None, value: Some(value), variable: None, help: "" }
    }
}

/// Copies a table without the identifiers.
#[must_use]
pub fn plain<T: Copy>(table: &[Opt<T>]) -> Vec<Opt<()>> {
    let plain = |o: &Opt<T>| Opt {
        id: (),
        short: o.short,
        long: o.long,
        value: o.value,
        variable: o.variable,
        help: o.help,
    };
    table.iter().map(plain).collect()
}

/// A command of a program, for completion.
#[derive(Clone, Debug)]
pub struct Subcommand {
    /// Name.
    pub name: &'static str,
    /// Description.
    pub help: &'static str,
    /// Options.
    pub options: Vec<Opt<()>>,
    /// True if its other words are pins, signals or parameters of the instance.
    pub takes_items: bool,
}

/// Options with their values, in order, and the words that follow.
pub type ParsedOptions<T> = (Vec<(T, Option<String>)>, Vec<String>);

/// Takes the options off the front of `words`: `-a -bc -nVALUE --long --long=VALUE --`.
///
/// # Errors
/// An option is not in the table, or lacks its value.
pub fn options<T: Copy>(
    program: &'static str,
    table: &[Opt<T>],
    words: &[String],
) -> Result<ParsedOptions<T>, Error> {
    let mut given = Vec::new();
    let (rest, _) = front(program, table, words, &mut given)?;
    Ok((given, rest.to_vec()))
}

/// Parses options before, between and after other words. No word after `--` is an option.
///
/// # Errors
/// An option is not in the table, or lacks its value.
pub fn mixed<T: Copy>(
    program: &'static str,
    table: &[Opt<T>],
    words: &[String],
) -> Result<ParsedOptions<T>, Error> {
    let (mut given, mut others) = (Vec::new(), Vec::new());
    let mut rest = words;
    loop {
        let (words, is_ended) = front(program, table, rest, &mut given)?;
        if is_ended {
            others.extend_from_slice(words);
            return Ok((given, others));
        }
        let Some((word, after)) = words.split_first() else { return Ok((given, others)) };
        others.push(word.clone());
        rest = after;
    }
}

/// Adds the values of environment variables for options that were not given. Any value except the
/// empty one and 0 sets a flag.
pub fn from_environment<T: Copy + PartialEq>(
    table: &[Opt<T>],
    environment: &dyn Fn(&str) -> Option<String>,
    given: &mut Vec<(T, Option<String>)>,
) {
    for option in table {
        let value = option.variable.and_then(environment).filter(|v| !v.is_empty());
        if let Some(value) = value
            && !given.iter().any(|(id, _)| *id == option.id)
        {
            if option.value.is_some() {
                given.push((option.id, Some(value)));
            } else if value != "0" {
                given.push((option.id, None));
            }
        }
    }
}

/// Description of `--version`.
pub(crate) const VERSION_HELP: &str = "print the version";

/// Runs a program, or prints its version if the only word is `--version`.
#[must_use]
pub fn versioned(program: &str, words: &[String], main: fn(&[String]) -> ExitCode) -> ExitCode {
    if words != ["--version"] {
        return main(words);
    }
    match Stdio.out(&format!("{program} {}\n", env!("CARGO_PKG_VERSION"))) {
        Ok(()) => ExitCode::SUCCESS,
        Err(unwritten) => {
            print_error(&format!("{program}: {unwritten}\n"));
            ExitCode::FAILURE
        }
    }
}

/// Lists the options for a usage text.
#[must_use]
pub fn usage<T>(table: &[Opt<T>]) -> String {
    let mut text = String::new();
    for option in table {
        let short = option.short.map_or_else(|| "   ".to_owned(), |c| format!("-{c}"));
        let comma = if option.short.is_some() && option.long.is_some() { ", " } else { "" };
        let long = option.long.map(|l| format!("--{l}")).unwrap_or_default();
        let value = option.value.map(|v| format!(" {v}")).unwrap_or_default();
        let variable = option.variable.map(|v| format!(" ({v})")).unwrap_or_default();
        let left = format!("{short}{comma}{long}{value}");
        text.push_str(&format!("  {left:<22} {}{variable}\n", option.help));
    }
    text
}

/// Lists the options of a program, whose version [`versioned`] prints, for a usage text.
#[must_use]
pub fn program_usage<T>(table: &[Opt<T>]) -> String {
    format!("{}     {:<17} {VERSION_HELP}\n", usage(table), "--version")
}

/// Takes the options off the front of `words`. Returns the other words, and whether `--` ended the options.
fn front<'w, T: Copy>(
    program: &'static str,
    table: &[Opt<T>],
    words: &'w [String],
    given: &mut Vec<(T, Option<String>)>,
) -> Result<(&'w [String], bool), Error> {
    let mut words = words.iter();
    loop {
        let rest = words.as_slice();
        let Some(word) = words.next() else { return Ok((rest, false)) };
        if word == "--" {
            return Ok((words.as_slice(), true));
        }
        if let Some(long) = word.strip_prefix("--") {
            given.push(long_option(program, table, long, &mut words)?);
        } else if word.len() > 1 && word.starts_with('-') {
            let letters = word.get(1..).unwrap_or_default();
            letters_of(program, table, letters, &mut words, given)?;
        } else {
            return Ok((rest, false));
        }
    }
}

fn long_option<T: Copy>(
    program: &'static str,
    table: &[Opt<T>],
    text: &str,
    words: &mut core::slice::Iter<'_, String>,
) -> Result<(T, Option<String>), Error> {
    let (name, inline) =
        text.split_once('=').map_or((text, None), |(n, v)| (n, Some(v.to_owned())));
    let option = table.iter().find(|o| o.long == Some(name)).ok_or_else(|| {
        let near = nearest(name, table.iter().filter_map(|o| o.long));
        Error::LongOption { program, option: name.into(), near }
    })?;
    match (option.value, inline) {
        (None, None) => Ok((option.id, None)),
        (None, Some(_)) => Err(Error::LongTakesNone { program, option: name.into() }),
        (Some(_), Some(value)) => Ok((option.id, Some(value))),
        (Some(_), None) => words
            .next()
            .map(|value| (option.id, Some(value.clone())))
            .ok_or_else(|| Error::LongNeedsArgument { program, option: name.into() }),
    }
}

fn letters_of<T: Copy>(
    command: &'static str,
    table: &[Opt<T>],
    letters: &str,
    words: &mut core::slice::Iter<'_, String>,
    given: &mut Vec<(T, Option<String>)>,
) -> Result<(), Error> {
    let mut letters = letters.chars();
    while let Some(letter) = letters.next() {
        let option = table
            .iter()
            .find(|o| o.short == Some(letter))
            .ok_or(Error::BadOption { command, option: letter })?;
        if option.value.is_none() {
            given.push((option.id, None));
            continue;
        }
        let inline = Some(letters.as_str()).filter(|rest| !rest.is_empty());
        let value = inline.map(str::to_owned).or_else(|| words.next().cloned());
        let value = value.ok_or(Error::NeedsArgument { command, option: letter })?;
        given.push((option.id, Some(value)));
        return Ok(());
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    const TABLE: &[Opt<char>] = &[
        Opt::flag('k', 'k'),
        Opt::flag('f', 'f'),
        Opt::short_with('i', 'i', "FILE"),
        Opt {
            id: 'F',
            short: None,
            long: Some("for"),
            value: Some("TIME"),
            variable: Some("HAL_FOR"),
            help: "stop after TIME",
        },
        Opt {
            id: 'h',
            short: None,
            long: Some("hold"),
            value: None,
            variable: Some("HAL_HOLD"),
            help: "start stopped",
        },
    ];

    fn shown(words: &str) -> String {
        let words: Vec<String> = words.split(' ').map(str::to_owned).collect();
        said(options("prog", TABLE, &words))
    }

    fn said(parsed: Result<ParsedOptions<char>, Error>) -> String {
        match parsed {
            Err(e) => format!("! {e}"),
            Ok((given, rest)) => {
                let mut text = String::new();
                for (id, value) in given {
                    text.push(id);
                    text.push_str(&value.map(|v| format!("={v}")).unwrap_or_default());
                    text.push(' ');
                }
                text + "| " + &rest.join(" ")
            }
        }
    }

    #[test]
    fn options_end_at_the_first_word() {
        for (words, want) in [
            ("-k show -k", "k | show -k"),
            ("-kf file", "k f | file"),
            ("-i x y", "i=x | y"),
            ("-kix y", "k i=x | y"),
            ("--for 2s a", "F=2s | a"),
            ("--for=2s a", "F=2s | a"),
            ("-- -k", "| -k"),
            ("- x", "| - x"),
            ("-z", "! prog: invalid option -- 'z'"),
            ("-i", "! prog: option requires an argument -- 'i'"),
            ("--nope", "! prog: unrecognized option '--nope'"),
            ("--for", "! prog: option '--for' requires an argument"),
            ("--hold=1", "! prog: option '--hold' doesn't allow an argument"),
        ] {
            assert_eq!(shown(words), want, "{words}");
        }
    }

    #[test]
    fn mixed_options_follow_other_words() {
        for (words, want) in [
            ("x.vcd -k a --for 2s b", "k F=2s | x.vcd a b"),
            ("-k x -- -k y", "k | x -k y"),
            ("-i -- x -k", "i=-- k | x"),
            ("x -z", "! prog: invalid option -- 'z'"),
        ] {
            let words: Vec<String> = words.split(' ').map(str::to_owned).collect();
            assert_eq!(said(mixed("prog", TABLE, &words)), want, "{words:?}");
        }
    }

    #[test]
    fn the_environment_says_what_the_line_does_not() {
        let environment = |name: &str| match name {
            "HAL_FOR" => Some("5s".to_owned()),
            "HAL_HOLD" => Some("0".to_owned()),
            _ => None,
        };
        let mut given = vec![];
        from_environment(TABLE, &environment, &mut given);
        assert_eq!(given, [('F', Some("5s".to_owned()))]);
        let mut given = vec![('F', Some("1s".to_owned()))];
        from_environment(TABLE, &environment, &mut given);
        assert_eq!(given, [('F', Some("1s".to_owned()))]);
    }

    #[test]
    fn usage_has_a_line_for_each() {
        let usage = usage(TABLE);
        assert!(usage.contains("     --for TIME          stop after TIME (HAL_FOR)\n"), "{usage}");
    }
}
