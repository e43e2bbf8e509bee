//! Command line.

use clap::{Args, Parser, Subcommand};
use std::{net::SocketAddr, path::PathBuf};

/// A machine, its panel, and the computer below them.
#[derive(Debug, Parser)]
#[command(name = "ferrule", version)]
pub(crate) struct Ferrule {
    #[command(subcommand)]
    pub(crate) task: Task,
}

/// Commands.
#[derive(Debug, Subcommand)]
pub(crate) enum Task {
    /// Start a machine with its panel, and say where the panel is.
    Start(Start),
    /// Cut a part on a simulated machine, say what each axis did, and then serve the machine to a browser.
    Demo(Demo),
    /// Write the files of a new machine from questions, or from a file of answers (halsetup).
    #[command(disable_help_flag = true)]
    New {
        /// Words for halsetup: `ferrule new --help` lists them.
        #[arg(trailing_var_arg = true, allow_hyphen_values = true)]
        words: Vec<String>,
    },
    /// Say how the running machine is (halcmd status).
    #[command(disable_help_flag = true)]
    Status {
        /// Words for `halcmd status`.
        #[arg(trailing_var_arg = true, allow_hyphen_values = true)]
        words: Vec<String>,
    },
    /// End the running machine (halrun -U).
    Stop {
        /// Name of the instance.
        #[arg(long)]
        instance: Option<String>,
    },
    /// Try a machine of LinuxCNC without its hardware: what it is made of, whether it runs, and what comes next.
    Try(Try),
    /// Check the wiring of a new machine at its first power-on, step by step, at a tenth of its speed.
    Commission(Commission),
    /// Look at what this computer needs for real time and hardware, and say what to mend and how.
    Doctor(Doctor),
    /// Open the manual, or print its sections with these words.
    Docs(Docs),
    /// Pack what a report of a fault needs into an archive, without private details.
    Report(Report),
    /// List earlier states of the machine's files, compare one with the file, and restore it.
    Restore(Restore),
}

/// Options of `ferrule start`.
#[derive(Debug, Args)]
pub(crate) struct Start {
    /// INI file of the machine, or a HAL file.
    pub(crate) machine: PathBuf,
    /// Run on the virtual clock at the speed of a clock: nothing of the world is touched.
    #[arg(long = "virtual")]
    pub(crate) is_virtual: bool,
    /// Run in real time with simulated hardware.
    #[arg(long, conflicts_with = "is_virtual")]
    pub(crate) simulate: bool,
    /// Put pins in place of these components and programs, or of all that are missing.
    #[arg(long, value_name = "NAMES")]
    pub(crate) stub: Option<String>,
    /// Name of the instance.
    #[arg(long)]
    pub(crate) instance: Option<String>,
    /// Role of who opens the address: viewer, operator or integrator.
    #[arg(long)]
    pub(crate) role: Option<String>,
    /// Address and port of the panel [default: 127.0.0.1:7776, or a free port].
    #[arg(long)]
    pub(crate) listen: Option<SocketAddr>,
    /// File with the accounts of who signs in with a password, for a network address.
    #[arg(long)]
    pub(crate) accounts: Option<PathBuf>,
    /// File with the certificate and its key in PEM, for a network address; made where there is none.
    #[arg(long)]
    pub(crate) certificate: Option<PathBuf>,
    /// Further name under which browsers reach the panel.
    #[arg(long)]
    pub(crate) name: Vec<String>,
    /// Folder of programs; without it, that of the INI file.
    #[arg(long)]
    pub(crate) programs: Option<PathBuf>,
    /// Do not open a browser.
    #[arg(long)]
    pub(crate) no_browser: bool,
}

/// Options of `ferrule demo`.
#[derive(Debug, Args)]
pub(crate) struct Demo {
    /// Folder for the machine, the recording and the picture; it is made where there is none.
    #[arg(long, default_value = "ferrule-demo")]
    pub(crate) folder: PathBuf,
    /// End behind the cut, on a terminal too.
    #[arg(long)]
    pub(crate) cut_only: bool,
    /// Do not open a browser.
    #[arg(long)]
    pub(crate) no_browser: bool,
}

/// Options of `ferrule try`.
#[derive(Debug, Args)]
pub(crate) struct Try {
    /// INI file of the machine.
    pub(crate) machine: PathBuf,
}

/// Options of `ferrule commission`.
#[derive(Debug, Args)]
pub(crate) struct Commission {
    /// INI file of the machine.
    pub(crate) machine: PathBuf,
    /// Run on the virtual clock, which stands while a question is open.
    #[arg(long = "virtual")]
    pub(crate) is_virtual: bool,
    /// Run in real time with simulated hardware.
    #[arg(long, conflicts_with = "is_virtual")]
    pub(crate) simulate: bool,
    /// Name of the instance.
    #[arg(long)]
    pub(crate) instance: Option<String>,
    /// Forget the results so far, and begin with the first step.
    #[arg(long)]
    pub(crate) again: bool,
}

/// Options of `ferrule doctor`.
#[derive(Debug, Args)]
pub(crate) struct Doctor {
    /// Fix what can be fixed, each after a question.
    #[arg(long)]
    pub(crate) fix: bool,
    /// Look at the system below this folder.
    #[arg(long, default_value = "/", hide = true)]
    pub(crate) root: PathBuf,
}

/// Options of `ferrule docs`.
#[derive(Debug, Args)]
pub(crate) struct Docs {
    /// Words that a section must have: it is printed.
    pub(crate) subject: Vec<String>,
    /// Write the pages into this folder.
    #[arg(short, long, value_name = "FOLDER", conflicts_with = "subject")]
    pub(crate) output: Option<PathBuf>,
    /// Do not open a browser.
    #[arg(long)]
    pub(crate) no_browser: bool,
}

/// Options of `ferrule report`.
#[derive(Debug, Args)]
pub(crate) struct Report {
    /// Folder or INI file of the machine: its text files go into the archive.
    pub(crate) machine: Option<PathBuf>,
    /// The archive.
    #[arg(short, long, default_value = "ferrule-report.tar.gz")]
    pub(crate) output: PathBuf,
    /// Name of the instance.
    #[arg(long)]
    pub(crate) instance: Option<String>,
    /// Write it without a question.
    #[arg(long)]
    pub(crate) yes: bool,
}

/// Options of `ferrule restore`.
#[derive(Debug, Args)]
pub(crate) struct Restore {
    /// INI file of the machine.
    pub(crate) machine: PathBuf,
    /// The file, as the list names it.
    pub(crate) file: Option<PathBuf>,
    /// Number of the state, as the list names it.
    #[arg(requires = "file")]
    pub(crate) number: Option<u32>,
    /// Show the difference, and write nothing.
    #[arg(long, requires = "number")]
    pub(crate) compare: bool,
    /// Restore it without a question.
    #[arg(long, conflicts_with = "compare")]
    pub(crate) yes: bool,
    /// Name of the instance, which must not run.
    #[arg(long)]
    pub(crate) instance: Option<String>,
}
