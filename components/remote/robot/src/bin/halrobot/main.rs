//! The program halrobot: runs a G-code program on a robot arm behind its controller's line protocol, or opens a terminal to
//! a controller.
#![forbid(unsafe_code)]

mod device;
mod run;
mod terminal;

use clap::{Parser, Subcommand};
use robot::{Zero, parse_zero};
use std::{io::Write as _, path::PathBuf, process::ExitCode};

/// Runs a G-code program on a robot arm. While it runs, the words pause, resume and stop on standard input are obeyed.
#[derive(Parser)]
#[command(
    name = "halrobot",
    version,
    args_conflicts_with_subcommands = true,
    subcommand_negates_reqs = true
)]
struct Options {
    #[command(subcommand)]
    command: Option<Action>,
    #[command(flatten)]
    run: RunOptions,
}

#[derive(Subcommand)]
enum Action {
    /// Opens a terminal to a controller: typed lines are sent, and its answers shown.
    Terminal(terminal::TerminalOptions),
}

/// Options of a run.
#[derive(clap::Args)]
struct RunOptions {
    /// G-code program.
    #[arg(required = true)]
    file: Option<PathBuf>,
    /// Address and port of the robot.
    #[arg(long, default_value = "127.0.0.1:55000")]
    to: String,
    /// Highest cutting speed, in mm/s.
    #[arg(long, default_value_t = 5.0)]
    speed: f64,
    /// Length of the tool beyond the flange, in mm.
    #[arg(long, default_value_t = 0.0)]
    tool: f64,
    /// Line to begin with, as the message of a stopped run names it.
    #[arg(long, default_value_t = 0)]
    from: usize,
    /// File for the lines to the robot, with the program's lines beside them.
    #[arg(long)]
    lines: Option<PathBuf>,
    /// Convert for this part zero, and run nothing.
    #[arg(long, value_name = "X,Y,Z", value_parser = parse_zero, allow_hyphen_values = true)]
    zero: Option<Zero>,
    /// Time for the answer to a line behind the end of its move, in seconds. A robot that hears nothing for 60 s ends the connection.
    #[arg(long, default_value_t = 20.0)]
    timeout: f64,
}

fn main() -> ExitCode {
    hal_output::program(|_| {
        let options = Options::parse();
        let done = match (&options.command, options.run.zero) {
            (Some(Action::Terminal(options)), _) => terminal::talk(options),
            (None, Some(zero)) => run::only_convert(&options.run, zero),
            (None, None) => run::run(&options.run),
        };
        done.map_or_else(|text| say(&text), |()| ExitCode::SUCCESS)
    })
}

/// Prints a message; whether anybody reads it makes no difference.
fn say(text: &str) -> ExitCode {
    drop(writeln!(std::io::stderr(), "halrobot: {text}"));
    ExitCode::FAILURE
}

fn print(text: &str) -> Result<(), String> {
    hal_output::print(text).map_err(|e| e.to_string())
}
