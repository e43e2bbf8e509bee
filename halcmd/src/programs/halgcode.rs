//! The program halgcode: G-code without a machine. `hal-job` reads the files of the machine that a program is for.
//!
//! | module | subject |
//! |---|---|
//! | `filter` | programs of `[FILTER]`, which turn other files into G-code |
//! | `canon`, `printer` | `canon`: the canonical calls, as `rs274` prints them |
//! | `check` | `check`: errors, limits, tools, extents |
//! | `foreign` | programs of other controls, which `check` names |
//! | `clock` | the time of a program on its machine, by the planner of motion |
//! | `path` | the way of the tool in machine coordinates |
//! | `plot`, `views` | `plot`: pictures of the way |
//! | `format`, `tokens`, `metric` | `format`: tidy text, line numbers, millimetres for inches |
//! | `help` | the help of a command |
//! | `language` | the option for the dialect of a program |
//! | `state` | `state`: the interpreter's state at a line |
//! | `ticks`, `ticks/` | `ticks`: a program in single steps, as figures, a table or a picture |
//! | `align` | `align`: a program in the coordinates of a part whose marks were measured |
//! | `apt`, `apt/` | `apt`: cutter-location files for a robot arm: its cell from an INI file, the report, the files written |

mod align;
pub mod apt;
mod canon;
mod check;
mod filter;
mod foreign;
mod format;
mod help;
mod language;
mod metric;
mod plot;
mod printer;
mod state;
mod ticks;
mod tokens;
mod views;

use crate::{
    Stdio, Terminal,
    programs::options::{Opt, Subcommand},
    terminal::print_error,
};
use std::process::ExitCode;

/// A command of the program.
struct Command {
    name: &'static str,
    arguments: &'static str,
    help: &'static str,
    options: fn() -> Vec<Opt<()>>,
    run: fn(&[String]) -> Result<ExitCode, String>,
}

const COMMANDS: [Command; 8] = [
    Command {
        name: "check",
        arguments: check::ARGUMENTS,
        help: check::HELP,
        options: check::completable,
        run: check::main,
    },
    Command {
        name: "canon",
        arguments: canon::ARGUMENTS,
        help: canon::HELP,
        options: canon::completable,
        run: canon::main,
    },
    Command {
        name: "plot",
        arguments: plot::ARGUMENTS,
        help: plot::HELP,
        options: plot::completable,
        run: plot::main,
    },
    Command {
        name: "format",
        arguments: format::ARGUMENTS,
        help: format::HELP,
        options: format::completable,
        run: format::main,
    },
    Command {
        name: "state",
        arguments: state::ARGUMENTS,
        help: state::HELP,
        options: state::completable,
        run: state::main,
    },
    Command {
        name: "ticks",
        arguments: ticks::ARGUMENTS,
        help: ticks::HELP,
        options: ticks::completable,
        run: ticks::main,
    },
    Command {
        name: "apt",
        arguments: apt::ARGUMENTS,
        help: apt::HELP,
        options: apt::completable,
        run: apt::main,
    },
    Command {
        name: "align",
        arguments: align::ARGUMENTS,
        help: align::HELP,
        options: align::completable,
        run: align::main,
    },
];

/// Returns the commands for completion.
pub(crate) fn subcommands() -> Vec<Subcommand> {
    let command = |c: &Command| Subcommand {
        name: c.name,
        help: c.help,
        options: (c.options)(),
        takes_items: false,
    };
    COMMANDS.iter().map(command).collect()
}

/// Runs the program with these words.
#[must_use]
pub fn main(words: &[String]) -> ExitCode {
    let Some((first, rest)) = words.split_first() else {
        print_error(&format!("halgcode: which command?\n{}", usage()));
        return ExitCode::from(2);
    };
    if matches!(first.as_str(), "-h" | "--help" | "help") {
        return match Stdio.out(&usage()) {
            Ok(()) => ExitCode::SUCCESS,
            Err(unwritten) => {
                print_error(&format!("halgcode: {unwritten}\n"));
                ExitCode::from(2)
            }
        };
    }
    let Some(command) = COMMANDS.iter().find(|c| c.name == first) else {
        print_error(&format!("halgcode: unknown command '{first}'\n{}", usage()));
        return ExitCode::from(2);
    };
    match (command.run)(rest) {
        Ok(code) => code,
        Err(text) => {
            print_error(&format!("halgcode: {text}\n"));
            ExitCode::from(2)
        }
    }
}

fn usage() -> String {
    let mut text = String::from("Usage: halgcode COMMAND [options] FILE\n\ncommands:\n");
    for c in &COMMANDS {
        text.push_str(&format!("  {:<7} {:<24} {}\n", c.name, c.arguments, c.help));
    }
    text.push_str("\nhalgcode COMMAND -h lists the options of a command, halgcode --version prints the version.\n");
    text
}
