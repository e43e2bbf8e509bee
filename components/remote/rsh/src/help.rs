//! Replies to `help`, from the table of subcommands.

use crate::rows::{Needs, ROWS, Stops};

const COMMANDS: &str = "Commands:\r\n  hello <password> <client> <version>\r\n  get <subcommand> [arguments]\r\n  \
set <subcommand> [arguments]\r\n  shutdown\r\n  quit\r\n  help [command]\r\n\r\n";

/// Returns the help for a command, or the list of commands.
pub(crate) fn text(command: Option<&str>) -> String {
    let Some(command) = command else { return COMMANDS.to_owned() };
    match command.to_ascii_uppercase().as_str() {
        "HELLO" => "hello <password> <client> <version>\r\n  Begins a session; set needs it.\r\n"
            .to_owned(),
        "GET" => list("get <subcommand>", |text| {
            for row in ROWS.iter().filter(|row| row.get.is_some()) {
                line(text, row.name, "");
            }
        }),
        "SET" => list("set <subcommand>", |text| {
            for (needs, head) in
                [(Needs::Hello, "After hello:"), (Needs::Control, "With control (set enable):")]
            {
                text.push_str(&format!("{head}\r\n"));
                let rows = ROWS.iter().filter(|row| row.set.is_some_and(|(n, _)| n == needs));
                rows.for_each(|row| line(text, row.name, row.args));
            }
            let stops = ROWS.iter().filter_map(|row| match row.stops {
                Stops::Never => None,
                Stops::Always => Some(row.name.to_ascii_lowercase()),
                Stops::With(word) => Some(format!("{} {word}", row.name.to_ascii_lowercase())),
            });
            let stops = stops.collect::<Vec<_>>().join(", ");
            text.push_str(&format!("Without control too: {stops}\r\n"));
        }),
        "QUIT" => "quit\r\n  Ends the connection.\r\n".to_owned(),
        "SHUTDOWN" => "shutdown\r\n  Ends the machine; needs control.\r\n".to_owned(),
        "HELP" => "help [command]\r\n".to_owned(),
        other => format!("{other} is not a valid command.\r\n"),
    }
}

fn list(head: &str, body: impl FnOnce(&mut String)) -> String {
    let mut text = format!("{head}\r\n");
    body(&mut text);
    text.push_str("\r\n");
    text
}

fn line(text: &mut String, name: &str, args: &str) {
    let space = if args.is_empty() { "" } else { " " };
    text.push_str(&format!("  {}{space}{args}\r\n", name.to_ascii_lowercase()));
}
