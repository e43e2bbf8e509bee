//! Options of the program.

use crate::session::Role;
use clap::Parser;
use std::{net::SocketAddr, path::PathBuf};

/// A machine in the browser: serves the running instance to this computer.
#[derive(Clone, Debug, Parser)]
#[command(name = "halpanel", version)]
pub struct Options {
    /// Address and port to listen at; port 0 takes a free one.
    #[arg(long, default_value = "127.0.0.1:7776")]
    pub listen: SocketAddr,
    /// Address and port of teleoperation, which then begins at once; without it, `[REMOTE]TELEOP`.
    #[arg(long)]
    pub teleop: Option<SocketAddr>,
    /// Name of the instance.
    #[arg(long)]
    pub instance: Option<String>,
    /// INI file of the machine.
    #[arg(long, visible_alias = "ini", env = "INI_FILE_NAME")]
    pub ini_file: Option<PathBuf>,
    /// Folder of programs; without it, `[DISPLAY]PROGRAM_PREFIX`.
    #[arg(long)]
    pub programs: Option<PathBuf>,
    /// Cell of a robot arm, as `halgcode apt -i` reads it: cutter-location files (.apt, .cl) are shown in it.
    #[arg(long)]
    pub cell: Option<PathBuf>,
    /// File for the address with the one-time token; without it, `panel-INSTANCE.url` beside the instance's socket.
    #[arg(long)]
    pub address_file: Option<PathBuf>,
    /// File for the log of what has been done; without it, `panel-INSTANCE.audit` beside the instance's socket. Like the two
    /// below, it lies in a folder of mode 0700; a name alone is a file in the user's state folder.
    #[arg(long)]
    pub audit: Option<PathBuf>,
    /// File with the accounts of who signs in with a password.
    #[arg(long)]
    pub accounts: Option<PathBuf>,
    /// Adds an account NAME=ROLE to the file of --accounts, with the password on standard input, and ends.
    #[arg(long, requires = "accounts")]
    pub add_account: Option<String>,
    /// File with the certificate and its key in PEM; made where there is none. The server then speaks TLS alone.
    #[arg(long)]
    pub certificate: Option<PathBuf>,
    /// Further name under which browsers reach the server; several are possible.
    #[arg(long)]
    pub name: Vec<String>,
    /// Role of who opens the address with the token; `integrator` may also change settings and wiring.
    #[arg(long, value_enum, default_value_t = Role::Operator)]
    pub role: Role,
    /// Loads and wires what the panel needs in the machine, and ends: for a panel that another user runs.
    #[arg(long)]
    pub prepare: bool,
    /// Folder with the page, in place of the one in the program.
    #[arg(long)]
    pub page: Option<PathBuf>,
}

impl Options {
    /// Returns the options of the command line. `-ini FILE` is how a machine's start calls every user interface.
    #[must_use]
    pub fn given() -> Self {
        let given = std::env::args_os();
        Self::parse_from(given.map(|arg| if arg == "-ini" { "--ini-file".into() } else { arg }))
    }
}
