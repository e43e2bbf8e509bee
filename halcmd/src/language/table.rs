//! The table of commands, which the parser, argument counts, help and the README's table read.

use crate::{
    Command, Error, language::hint::nearest, language::lex::is_arrow, language::parse,
    language::rows::rows,
};

pub(crate) use crate::language::row::line;
pub use crate::language::row::{KINDS, Row, SAVES, STATUSES};

/// Returns the command of this name.
#[must_use]
pub fn find(name: &str) -> Option<&'static Row> {
    rows().find(|row| row.name == name)
}

/// Parses the words of a line.
///
/// # Errors
/// There is no such command, or its arguments are wrong.
pub fn parse_command(words: &[String]) -> Result<Command, Error> {
    if let [name, equals, value] = words
        && equals == "="
    {
        return parse::setp(&[name.clone(), value.clone()]);
    }
    let Some((name, rest)) = words.split_first() else { return Err(Error::Unexpected) };
    let Some(row) = find(name) else { return component(name, rest) };
    let rest: Vec<String> = if matches!(row.name, "net" | "linkps" | "linksp") {
        rest.iter().filter(|w| !is_arrow(w)).cloned().collect()
    } else {
        rest.to_vec()
    };
    row.count(rest.len())?;
    (row.parse)(&rest)
}

/// Parses `COMPONENT.VERB NAME=VALUE…`: a first word with a dot that is not in the table.
fn component(name: &str, words: &[String]) -> Result<Command, Error> {
    if !name.contains('.') {
        return Err(Error::UnknownCommand { word: name.into(), near: near(name) });
    }
    let wait = words.iter().any(|w| w == "--wait");
    let args = words.iter().filter(|w| *w != "--wait").cloned().collect();
    Ok(Command::Component { name: name.to_owned(), args, wait })
}

/// Returns the name of a command near `word`.
#[must_use]
pub fn near(word: &str) -> Option<Box<str>> {
    nearest(word, rows().map(|row| row.name))
}

/// Returns the table for the README.
#[must_use]
pub fn markdown() -> String {
    let mut text = String::from("| command | what it does |\n|---|---|\n");
    for row in rows() {
        let usage = line(row).replace('|', "\\|");
        text.push_str(&format!("| `{usage}` | {} |\n", row.summary));
    }
    text
}

#[cfg(test)]
mod tests {
    use super::{markdown, parse_command};
    use crate::{
        ini::Ini,
        language::lex::{without_comment, words},
        language::vars::{Values, replace},
    };

    fn refusal(line: &str) -> String {
        let words: Vec<String> = line.split_whitespace().map(str::to_owned).collect();
        parse_command(&words).map_or_else(|e| e.whole(), |c| format!("{c:?}"))
    }

    #[test]
    fn arguments_are_counted() {
        for (line, want) in [
            ("setp foo", "setp requires 2 arguments, 1 given"),
            ("unlinkp", "unlinkp requires 1 arguments, 0 given"),
            ("list", "list requires at least 1 arguments, 0 given"),
            ("net", "net requires at least 1 arguments, 0 given"),
            ("net => <=", "net requires at least 1 arguments, 0 given"),
            ("net x", "'net' requires at least one pin, none given"),
            ("net x =>", "'net' requires at least one pin, none given"),
            ("linkps a", "linkps requires 2 arguments, 1 given"),
            ("linkps a <== b", "linkps requires 2 arguments, 3 given"),
            ("print a b", "print requires at most 1 arguments, 2 given"),
            ("help net foo", "help requires at most 1 arguments, 2 given"),
            ("lock a b", "lock requires at most 1 arguments, 2 given"),
            ("addf a", "addf requires at least 2 arguments, 1 given"),
            ("start now", "start requires 0 arguments, 1 given"),
            ("alias pin a", "alias requires 3 arguments, 2 given"),
            ("loadrt", "loadrt requires at least 1 arguments, 0 given"),
            ("delf", "missing function name"),
            ("delf a", "missing thread name"),
        ] {
            assert_eq!(refusal(line), want, "{line}");
        }
    }

    #[test]
    fn words_that_mean_nothing_are_named() {
        for (line, want) in [
            ("PRINT x", "Unknown command 'PRINT'; did you mean print?"),
            ("netx a b", "Unknown command 'netx'; did you mean net?"),
            ("loadtr and2", "Unknown command 'loadtr'; did you mean loadrt?"),
            ("quit", "Unknown command 'quit'"),
            (
                "newsig a foo",
                "Unknown signal type 'foo'; it is one of bit, float, s32, u32, s64, u64, port",
            ),
            (
                "show foo",
                "Unknown 'show' type 'foo'; it is one of all, alias, comp, pin, sig, signal, param, \
                 parameter, funct, function, thread, worker, snapshot",
            ),
            ("status foo", "Unknown 'status' type 'foo'; it is one of all, lock, mem, instance"),
            ("debug 9", "Debug level must be >=0 and <= 5"),
            ("run 20", "'20' is not a time; write a number and ns, us, ms or s, such as 20ms"),
            ("loadusr", "execv(): No such file or directory"),
            ("loadusr -x foo", "loadusr: invalid option -- 'x'"),
            ("alias foo a b", "alias failed; its first word is pin or param, not 'foo'"),
        ] {
            assert_eq!(refusal(line), want, "{line}");
        }
    }

    #[test]
    fn lines_become_commands() {
        for (line, want) in [
            ("a.b = 5", "Send(Set { name: \"a.b\", value: \"5\" }, None)"),
            ("setp a.b 5", "Send(Set { name: \"a.b\", value: \"5\" }, None)"),
            (
                "net s a => b <=",
                "Send(Net { signal: \"s\", pins: [\"a\", \"b\"] }, Some(\"Pin 'a' linked to signal \
                 's'\\nPin 'b' linked to signal 's'\"))",
            ),
            (
                "linksp s => p",
                "Send(Link { pin: \"p\", signal: \"s\" }, Some(\"Pin 'p' linked to signal 's'\"))",
            ),
            ("newsig a BOOL", "Send(NewSignal { name: \"a\", ty: Bit }, None)"),
            (
                "addf f t -2",
                "Send(AddFunct { funct: \"f\", thread: \"t\", position: -2, init: false }, \
                 Some(\"Function 'f' added to thread 't'\"))",
            ),
            ("delsig all", "Send(DeleteSignal { name: None }, None)"),
            ("unload all", "UnloadAll"),
            ("unloadusr all", "Send(EndProgram { name: None }, None)"),
            ("show", "Show(None, None, [])"),
            ("show pin -t bit x", "Show(Some(Of(Pins)), Some(Bit), [\"x\"])"),
            ("show sig -treal", "Show(Some(Of(Signals)), Some(Float), [])"),
            ("show comp -t", "Show(Some(Of(Components)), None, [\"-t\"])"),
            ("list pin -t bit", "List(Pins, [\"-t\", \"bit\"])"),
            ("lock tune", "Lock(Some(To(Lock(3))))"),
            ("lock nonsense", "Lock(None)"),
            ("unlock tune", "Lock(Some(Without(Lock(3))))"),
            ("run 1.5ms", "Send(Run { ns: 1500000 }, None)"),
            ("record off", "Send(EndRecord, None)"),
            (
                "motion.jog joint=0 --wait velocity=5",
                "Component { name: \"motion.jog\", args: [\"joint=0\", \"velocity=5\"], wait: true \
                 }",
            ),
        ] {
            assert_eq!(refusal(line), want, "{line}");
        }
        let launch = refusal("loadusr -Wn comp prog.py -w x");
        for part in ["until_ready: true", "Some(\"comp\")", "until_end: false", "[\"-w\", \"x\"]"] {
            assert!(launch.contains(part), "{launch}");
        }
    }

    #[test]
    fn positions_are_read_as_c_reads_them() {
        for (word, want) in [("+3", 3), ("1x", 1), ("0x1", 0), ("foo", 0), ("-1", -1)] {
            let shown = refusal(&format!("addf f t {word}"));
            assert!(shown.contains(&format!("position: {want},")), "{word}: {shown}");
        }
    }

    /// Pseudo-random lines of the language's elements. All of them parse or give an error.
    #[test]
    fn no_line_is_beyond_understanding() {
        const PIECES: &[&str] = &[
            "net",
            "setp",
            "show",
            "loadusr",
            "record",
            " ",
            "  ",
            "\t",
            "=",
            "=>",
            "<=",
            "a.b",
            "$",
            "$(",
            ")",
            "[",
            "]",
            "[A]",
            "X",
            "\"",
            "'",
            "#",
            "\\",
            "-t",
            "-1",
            "99999999999999999999",
            "ü",
            "\u{0}",
            "run",
            "1s",
            "addf",
            "x",
            "all",
            "save",
            "(",
            "delf",
        ];
        let ini = Ini::parse("m", b"[A]\nX = a \"b\n").unwrap();
        let values = Values { environment: &|_| Some("v v".to_owned()), ini: Some(&ini) };
        let mut seed = 1_u64;
        let mut understood = 0;
        for _ in 0..20_000 {
            let mut line = String::new();
            for _ in 0..seed % 12 {
                seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
                line.push_str(PIECES[usize::try_from(seed >> 33).unwrap() % PIECES.len()]);
            }
            seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695);
            let words = without_comment(&line)
                .and_then(|text| replace(text, values))
                .and_then(|text| words(&text));
            understood += usize::from(words.is_ok_and(|w| parse_command(&w).is_ok()));
            drop(Ini::parse("m", line.as_bytes()));
        }
        assert!(understood > 100, "{understood}");
    }

    #[test]
    fn the_readme_has_this_table() {
        let file = concat!(env!("CARGO_MANIFEST_DIR"), "/README.md");
        let head = "| command |";
        let table = markdown();
        let rows = table.strip_prefix(head).unwrap().trim_end();
        hal_golden::check_part(file.as_ref(), head, "\n\n", rows);
    }
}
