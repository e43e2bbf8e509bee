//! Completion for shells. The line comes in `COMP_LINE`; the words go to standard output.

use super::{Candidate, Completion};
use crate::{
    language::rows::rows,
    programs::{
        hal_manualtoolchange, halcmd, halgcode, halrun, halsampler, halscope, halsetup,
        halstreamer, haltcl, haltest, latency_test, linuxcnc,
        options::{Opt, Subcommand, VERSION_HELP},
    },
    session::remote::Remote,
};
use hal_protocol::Place;

/// Status of `halcmd -C` that says that a file name is possible as well.
pub const COMPLETE_FILES: u8 = 3;

/// Completes the end of a shell's line. `current` is the word being typed as the shell sees it
/// (some shells begin a new word after `=`); the candidates replace that word.
pub fn for_shell(line: &str, current: Option<&str>) -> Completion {
    let (words, word) = split(line);
    let Some((program, rest)) = words.split_first() else { return Completion::default() };
    let name = program.rsplit('/').next().unwrap_or(program);
    let mut found = match name {
        "halrun" => program_words(name, &halrun::options(), rest, &word),
        "halscope" => subcommand(&halscope::subcommands(), rest, &word),
        "halgcode" => subcommand(&halgcode::subcommands(), rest, &word),
        "haltest" => option_or_file(&haltest::completable(), rest, &word),
        "halsampler" => option_or_file(&halsampler::completable(), rest, &word),
        "halsetup" => option_or_file(&halsetup::completable(), rest, &word),
        "latency-test" => option_or_file(&latency_test::completable(), rest, &word),
        "halstreamer" => option_or_file(&halstreamer::completable(), rest, &word),
        "haltcl" => option_or_file(&haltcl::completable(), rest, &word),
        "linuxcnc" => option_or_file(&linuxcnc::completable(), rest, &word),
        "hal_manualtoolchange" => option_or_file(&hal_manualtoolchange::completable(), rest, &word),
        _ => program_words(name, &halcmd::completable(), rest, &word),
    };
    if rest.is_empty() && word.starts_with('-') && "--version".starts_with(&word) {
        found.candidates.push(Candidate::new("--version", VERSION_HELP));
    }
    let cut = current.and_then(|c| word.strip_suffix(c)).map_or(0, str::len);
    for candidate in &mut found.candidates {
        candidate.word = candidate.word.get(cut..).unwrap_or_default().to_owned();
    }
    found
}

/// Completes the words of a program with commands.
fn subcommand(commands: &[Subcommand], rest: &[String], word: &str) -> Completion {
    let Some((name, rest)) = rest.split_first() else {
        let all = commands.iter().map(|c| Candidate::new(c.name, c.help)).collect();
        return Completion { candidates: begun(all, word), ..Completion::default() };
    };
    let Some(command) = commands.iter().find(|c| c.name == name) else {
        return Completion::default();
    };
    let mut found = option_or_file(&command.options, rest, word);
    if found.files
        && command.takes_items
        && let Ok(place) = Place::find(None)
    {
        let mut remote = Remote::new(place, "");
        found.candidates = super::words(&["getp".to_owned()], word, &mut remote).candidates;
    }
    found
}

/// Completes an option, its value, or the name of a file.
fn option_or_file(options: &[Opt<()>], rest: &[String], word: &str) -> Completion {
    let last = rest.last().filter(|last| !last.contains('=')).and_then(|w| option(options, w));
    if let Some(option) = last.filter(|o| o.value.is_some()) {
        return value_of(option, word);
    }
    if word.starts_with('-') {
        let candidates = begun(option_words(options), word);
        return Completion { candidates, ..Completion::default() };
    }
    Completion { files: true, ..Completion::default() }
}

/// Completes a program's words: options first, then a command or a file.
fn program_words(name: &str, options: &[Opt<()>], rest: &[String], word: &str) -> Completion {
    let (mut instance, mut file, mut help) = (None, name == "halrun", false);
    let mut words = rest.iter();
    loop {
        let left = words.as_slice();
        let Some(next) = words.next() else { break };
        let Some(option) = option(options, next) else {
            // In halrun, options may also follow the file.
            if name == "halrun" {
                continue;
            }
            return command(left, word, instance, file, help);
        };
        file |= option.short == Some('f');
        help |= option.short == Some('h');
        if option.value.is_none() {
            continue;
        }
        let inline = next.split_once('=').map(|(_, value)| value);
        let Some(value) = inline.or_else(|| words.next().map(String::as_str)) else {
            return value_of(option, word);
        };
        if option.long == Some("instance") {
            instance = Some(value.to_owned());
        }
    }
    if word.starts_with('-') {
        return Completion {
            candidates: begun(option_words(options), word),
            ..Completion::default()
        };
    }
    command(&[], word, instance, file, help)
}

fn command(
    before: &[String],
    word: &str,
    instance: Option<String>,
    file: bool,
    help: bool,
) -> Completion {
    if help && before.is_empty() {
        let topics = rows().map(|row| Candidate::new(row.name, row.summary)).collect();
        return Completion { candidates: begun(topics, word), ..Completion::default() };
    }
    if file {
        return Completion { files: before.is_empty(), ..Completion::default() };
    }
    match Place::find(instance.as_deref()) {
        Ok(place) => super::words(before, word, &mut Remote::new(place, "")),
        Err(_) => Completion::default(),
    }
}

/// Returns the option of a word. Of several letters in a word, the last one counts.
fn option<'a>(options: &'a [Opt<()>], word: &str) -> Option<&'a Opt<()>> {
    match (word.strip_prefix("--"), word.strip_prefix('-')) {
        (Some(long), _) => {
            let name = long.split('=').next();
            options.iter().find(|o| o.long.is_some() && o.long == name)
        }
        (None, Some(letters)) => {
            let last = letters.chars().next_back();
            options.iter().find(|o| o.short.is_some() && o.short == last)
        }
        (None, None) => None,
    }
}

fn option_words(options: &[Opt<()>]) -> Vec<Candidate> {
    let word = |o: &Opt<()>| match (o.long, o.short) {
        (Some(long), _) => format!("--{long}"),
        (None, Some(short)) => format!("-{short}"),
        (None, None) => String::new(),
    };
    options.iter().map(|o| Candidate::new(word(o), o.help)).collect()
}

/// Completes the value of an option.
fn value_of(option: &Opt<()>, word: &str) -> Completion {
    let one_of = |words: &[&str]| {
        let all = words.iter().map(|word| Candidate::new(*word, option.help)).collect();
        Completion { candidates: begun(all, word), ..Completion::default() }
    };
    match option.value {
        _ if option.long == Some("clock") => one_of(&["real", "virtual"]),
        _ if option.long == Some("compat") => one_of(&["2.9", "2.10"]),
        Some("FILE") => Completion { files: true, ..Completion::default() },
        Some("NAME") => {
            Completion { candidates: begun(instances(), word), ..Completion::default() }
        }
        _ => Completion::default(),
    }
}

/// Returns the instances that have a socket.
fn instances() -> Vec<Candidate> {
    let Ok(place) = Place::find(None) else { return Vec::new() };
    let entries = std::fs::read_dir(place.folder()).into_iter().flatten().flatten();
    let names = entries.filter_map(|e| e.file_name().into_string().ok());
    let mut found: Vec<Candidate> = names
        .filter_map(|n| n.strip_suffix(".sock").map(|n| Candidate::new(n, "an instance")))
        .collect();
    found.sort();
    found
}

fn begun(candidates: Vec<Candidate>, word: &str) -> Vec<Candidate> {
    candidates.into_iter().filter(|c| c.word.starts_with(word)).collect()
}

/// Splits a shell's line into the words before the last and the last, which is empty after a space.
fn split(line: &str) -> (Vec<String>, String) {
    let (mut words, mut word, mut quote, mut escaped) = (Vec::new(), String::new(), None, false);
    let mut begun = false;
    for c in line.chars() {
        match quote {
            _ if escaped => {
                word.push(c);
                escaped = false;
            }
            Some(q) if c == q => quote = None,
            None if c == '\'' || c == '"' => (quote, begun) = (Some(c), true),
            Some('"') | None if c == '\\' => (escaped, begun) = (true, true),
            None if c.is_ascii_whitespace() => {
                if begun {
                    words.push(core::mem::take(&mut word));
                }
                begun = false;
            }
            _ => {
                word.push(c);
                begun = true;
            }
        }
    }
    (words, word)
}
