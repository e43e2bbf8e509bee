//! The output of `help`, from the table of commands.

use crate::{
    Error,
    language::rows::{GROUPS, rows},
    language::table::{Row, find, line, near},
    manual::wrap::{sentence, wrapped},
};

use serde_json::{Value, json};

/// Returns the output of `help`, for all commands or for the named one.
///
/// # Errors
/// There is no command of this name.
pub fn help(about: Option<&str>) -> Result<String, Error> {
    let Some(name) = about else { return Ok(overview()) };
    let row = find(name).ok_or_else(|| Error::NoHelp { word: name.into(), near: near(name) })?;
    Ok(if name == "help" { format!("{}\n", row.help) } else { explained(row) })
}

/// Returns the output of `help` for programs, as an object.
pub(crate) fn object(about: Option<&str>) -> Value {
    let brief = |title: &str, row: &Row| {
        json!({
            "group": title, "name": row.name, "usage": row.usage, "summary": row.summary,
        })
    };
    let Some(name) = about else {
        let all = GROUPS.iter().flat_map(|(title, rows)| rows.iter().map(|r| brief(title, r)));
        return json!({ "help": all.collect::<Vec<_>>() });
    };
    let errors = |row: &Row| -> Vec<Value> {
        let each = row.errors.iter();
        each.map(|(text, remedy)| json!({ "text": text, "remedy": remedy })).collect()
    };
    let row = find(name).map(|row| {
        json!({
            "name": row.name, "usage": row.usage, "summary": row.summary, "help": row.help,
            "examples": row.examples, "related": row.related, "errors": errors(row),
        })
    });
    json!({ "help": row })
}

/// Lists the commands in groups, one line each.
fn overview() -> String {
    let mut text = String::from(
        "Use 'help <command>' for more details about each command\nAvailable commands:\n",
    );
    // A long name for test suites is ignored here, because it would make the column too wide.
    let width = rows().map(|row| row.name.len()).filter(|n| *n <= 20).max().unwrap_or(0);
    for (title, rows) in GROUPS {
        text.push_str(&format!("\n{title}\n"));
        for row in *rows {
            text.push_str(&format!("  {:<width$}  {}\n", row.name, row.summary));
        }
    }
    text.push_str(
        "\nCommands of components\n  COMPONENT.VERB NAME=VALUE...  'commands' lists them\n",
    );
    text
}

/// Returns everything that the table says about a command.
fn explained(row: &Row) -> String {
    let mut text = format!("{}\n{}\n", line(row), sentence(row.summary));
    if !row.help.is_empty() {
        text.push_str(&wrapped(row.help, 0));
    }
    if !row.examples.is_empty() {
        text.push_str(if row.examples.len() == 1 { "\nExample:\n" } else { "\nExamples:\n" });
        row.examples.iter().for_each(|example| text.push_str(&format!("  {example}\n")));
    }
    if !row.errors.is_empty() {
        text.push_str("\nWhen it says:\n");
        for (message, remedy) in row.errors {
            text.push_str(&format!("  ...{message}...\n{}", wrapped(&sentence(remedy), 6)));
        }
    }
    if !row.related.is_empty() {
        text.push_str(&format!("\nSee also: {}\n", row.related.join(", ")));
    }
    text
}

#[cfg(test)]
mod tests {
    use super::{help, rows};
    use crate::{language::table::find, manual::wrap::WIDTH};

    #[test]
    fn every_command_is_listed_and_explained() {
        let all = help(None).unwrap();
        assert!(all.starts_with("Use 'help <command>' for more details about each command\n"));
        for row in rows() {
            let listed = all.lines().any(|l| {
                l.strip_prefix("  ").is_some_and(|l| {
                    l.split_whitespace().next() == Some(row.name) && l.ends_with(row.summary)
                })
            });
            assert!(listed, "{}", row.name);
            let text = help(Some(row.name)).unwrap();
            assert!(text.ends_with('\n') && text.len() > 10, "{}", row.name);
            assert!(text.lines().skip(1).all(|l| l.chars().count() <= WIDTH), "{text}");
            assert!(!row.help.is_empty(), "{}: what else is there to know?", row.name);
            for other in row.related {
                assert!(find(other).is_some(), "{}: related to {other}?", row.name);
            }
        }
    }

    #[test]
    fn a_command_is_explained() {
        let net = help(Some("net")).unwrap();
        assert!(net.starts_with("net SIGNAL PIN...\nJoin pins by a signal.\n"), "{net}");
        for part in [
            "\nExample:\n  net x-step stepgen.0.step => parport.0.pin-02-out\n",
            "\n  ...was already linked...\n      'unlinkp PIN' frees it.\n",
            "\nSee also: linkps, unlinkp, newsig, delsig, show\n",
        ] {
            assert!(net.contains(part), "{net}");
        }
        assert_eq!(
            help(Some("help")).unwrap(),
            "If you need help to use 'help', then I can't help you.\n"
        );
        let error = help(Some("bogus")).unwrap_err().whole();
        assert_eq!(error, "No help for unknown command 'bogus'");
    }

    /// Every example parses, and the table describes the arguments of every command.
    #[test]
    fn examples_are_right() {
        for row in rows() {
            for example in row.examples {
                let words = crate::language::lex::words(example).unwrap();
                let command = crate::language::table::parse_command(&words);
                assert!(command.is_ok(), "{example}: {}", command.unwrap_err());
            }
            assert_eq!(row.args.1 > 0, !row.words.is_empty(), "{}: words", row.name);
        }
    }
}
