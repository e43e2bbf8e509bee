//! Programs that run, compared with the `loadusr` lines of an applied file.

use crate::{Error, Session, language::command::Launch};
use hal_protocol::ComponentInfo;
use std::fs;

/// Largest number of words that an interpreter puts before the name of its script: its own name and an option.
const INTERPRETER: usize = 2;

/// Comparison of a `loadusr` line with the programs that run.
#[derive(Debug, PartialEq, Eq)]
pub(crate) enum Running {
    /// No program has the component of the line.
    No,
    /// The process runs from the same command line.
    Same(i32),
    /// The component is there, from another command line.
    Other {
        /// Name of the component.
        component: String,
        /// Command line of its program, without folders; empty if it cannot be read.
        line: String,
    },
}

impl Session<'_> {
    /// Compares a line with the programs that run, except those that other lines have taken.
    pub(crate) fn running(&mut self, launch: &Launch, taken: &[i32]) -> Result<Running, Error> {
        let programs: Vec<(ComponentInfo, i32)> = self
            .components()?
            .into_iter()
            .filter(|c| !c.realtime)
            .filter_map(|c| c.pid.map(|pid| (c, pid)))
            .filter(|(_, pid)| !taken.contains(pid))
            .collect();
        let named = |c: &ComponentInfo| launch.component.as_ref().is_none_or(|n| *n == c.name);
        if let Some((_, pid)) =
            programs.iter().find(|(c, pid)| named(c) && is_start_of(launch, &words_of(*pid)))
        {
            return Ok(Running::Same(*pid));
        }
        let component = launch.expected();
        let other = programs.into_iter().find(|(c, _)| c.name == component);
        Ok(other.map_or(Running::No, |(_, pid)| {
            let mut words = words_of(pid);
            if let Some(program) = words.first_mut() {
                *program = base(program).to_owned();
            }
            Running::Other { component, line: words.join(" ") }
        }))
    }
}

/// Returns a path without its folders.
fn base(path: &str) -> &str {
    path.rsplit('/').next().unwrap_or(path)
}

/// Returns the words of a process's command line.
fn words_of(pid: i32) -> Vec<String> {
    let line = fs::read(format!("/proc/{pid}/cmdline")).unwrap_or_default();
    let Some(line) = line.strip_suffix(b"\0") else { return Vec::new() };
    line.split(|b| *b == 0).map(|word| String::from_utf8_lossy(word).into_owned()).collect()
}

/// Returns whether the line starts a program with this command line. The folder of the program does not count, and a
/// script has its interpreter before it.
fn is_start_of(launch: &Launch, words: &[String]) -> bool {
    let Some((program, before)) =
        words.strip_suffix(launch.args.as_slice()).and_then(<[String]>::split_last)
    else {
        return false;
    };
    before.len() <= INTERPRETER && base(program) == base(&launch.program)
}

#[cfg(test)]
mod tests {
    use super::{is_start_of, words_of};
    use crate::language::command::Launch;

    #[test]
    fn a_line_starts_the_program_of_its_words() {
        let words = |text: &str| text.split(' ').map(str::to_owned).collect::<Vec<_>>();
        for (line, process, expected) in [
            ("pendant", "pendant", true),
            ("pendant", "/usr/bin/pendant", true),
            ("./pendant", "/home/me/pendant", true),
            ("pendant -a 1", "pendant -a 1", true),
            ("pendant -a 1", "pendant -a 2", false),
            ("pendant", "pendant -a", false),
            ("pendant -a", "pendant", false),
            ("pendant", "other", false),
            ("pendant.py 5", "/usr/bin/python3 ./pendant.py 5", true),
            ("pendant.py 5", "/usr/bin/python3 -u ./pendant.py 5", true),
            ("python3 pendant.py", "python3 pendant.py", true),
            ("python3 pendant.py", "python3 other.py", false),
            ("sleep", "a b c sleep", false),
        ] {
            let mut all = words(line);
            let program = all.remove(0);
            let launch = Launch { program, args: all, ..Launch::default() };
            assert_eq!(is_start_of(&launch, &words(process)), expected, "{line}: {process}");
        }
        assert!(!is_start_of(&Launch::default(), &[]), "a process without a command line");
    }

    #[test]
    fn the_words_of_a_process_are_its_own() {
        let own: Vec<String> = std::env::args().collect();
        assert_eq!(words_of(std::process::id().cast_signed()), own);
        assert!(words_of(-1).is_empty());
    }
}
