//! Options of the program, with the names and values of LinuxCNC's.

use clap::Parser;
use std::{ffi::OsString, path::PathBuf};

/// Password of hello that everybody knows.
const CONNECT: &str = "EMC";
/// Password of `set enable` that everybody knows.
const ENABLE: &str = "EMCTOO";

/// The running machine, commanded with lines of text over a connection of this computer (telnet, nc).
#[derive(Clone, Debug, Parser)]
#[command(name = "linuxcncrsh", version)]
pub(crate) struct Options {
    /// Port at 127.0.0.1; 0 takes a free one.
    #[arg(short, long, default_value_t = 5007)]
    pub(crate) port: u16,
    /// Name of the server in the reply to hello.
    #[arg(short, long, default_value = "EMCNETSVR")]
    pub(crate) name: String,
    /// Password of hello. It is sent as it is.
    #[arg(short = 'w', long, default_value = CONNECT)]
    pub(crate) connectpw: String,
    /// Password of set enable. It is sent as it is.
    #[arg(short = 'e', long, default_value = ENABLE)]
    pub(crate) enablepw: String,
    /// Number of connections at once; -1 is as many as there can be.
    #[arg(short, long, default_value_t = -1, allow_negative_numbers = true)]
    pub(crate) sessions: i64,
    /// Name of the instance.
    #[arg(long)]
    pub(crate) instance: Option<String>,
    /// INI file of the machine.
    #[arg(long, visible_alias = "ini", env = "INI_FILE_NAME")]
    pub(crate) ini_file: Option<PathBuf>,
}

impl Options {
    /// Returns the options of the command line. `-ini FILE`, also behind `--`, is how a machine's start calls every user
    /// interface.
    pub(crate) fn given() -> Self {
        let given = std::env::args_os().filter(|arg| arg != "--");
        Self::parse_from(given.map(
            |arg| {
                if arg == "-ini" { OsString::from("--ini-file") } else { arg }
            },
        ))
    }

    /// Returns whether one of the passwords is the one that everybody knows.
    pub(crate) fn has_known_passwords(&self) -> bool {
        self.connectpw == CONNECT || self.enablepw == ENABLE
    }
}
