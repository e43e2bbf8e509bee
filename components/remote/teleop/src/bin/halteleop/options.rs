//! Arguments of the program, its files, and its exit status.

use crate::Failure;
use clap::{Parser, Subcommand};
use hal_protocol::Place;
use std::{
    io::Read as _,
    net::{SocketAddr, ToSocketAddrs as _},
    path::{Path, PathBuf},
};
use teleop::MAX_PROGRAM;

/// Longest file with a secret in bytes.
const MAX_SECRET: u64 = 4096;

/// Sends a program to a machine, runs it there, and shows its progress.
///
/// The status at the end is 0 if everything was done, 1 for a file or option that cannot be used, 2 for a wrong command
/// line, 3 without a connection, 4 if the login is refused, 5 if the program is refused (an error, or beyond the limits),
/// 6 if the machine is not ready (busy, off, not adjusted, or the role), 7 if the job has failed, 8 if it was cancelled
/// from here, 9 if the server has stopped.
#[derive(Debug, Parser)]
#[command(name = "halteleop", version)]
pub(crate) struct Arguments {
    /// Address and port of the machine.
    #[arg(long, global = true, default_value = "127.0.0.1:2000")]
    pub(crate) to: String,
    /// Name of the user.
    #[arg(long, global = true, env = "USER", default_value = "halteleop")]
    pub(crate) user: String,
    /// File with the password, or with the token; - is standard input. Without it, and for a loopback address alone, the
    /// token of the panel on this computer.
    #[arg(long, global = true)]
    pub(crate) secret_file: Option<PathBuf>,
    /// Name of the instance on this computer whose token is used.
    #[arg(long, global = true)]
    pub(crate) instance: Option<String>,
    /// SHA-256 fingerprint of the machine's certificate, as halpanel prints it: the connection is encrypted.
    #[arg(long, global = true)]
    pub(crate) fingerprint: Option<String>,
    /// Prints the progress alone.
    #[arg(long, short, global = true)]
    pub(crate) quiet: bool,
    #[command(subcommand)]
    pub(crate) work: Work,
}

/// Work of the program.
#[derive(Debug, Subcommand)]
pub(crate) enum Work {
    /// Sends a program and runs it, to its end; Ctrl-C cancels it.
    Run {
        /// The program; - is standard input.
        file: PathBuf,
    },
    /// Tells how much of the machine's job is done.
    Progress,
}

/// Exit status.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
pub(crate) enum Status {
    /// A file or an option cannot be used.
    Local = 1,
    /// There is no connection, or it is lost.
    Lost = 3,
    /// The login is refused.
    Denied = 4,
    /// The program is refused.
    Program = 5,
    /// The machine is not ready.
    NotReady = 6,
    /// The job has failed.
    Failed = 7,
    /// The job was cancelled from here.
    Cancelled = 8,
    /// The server has stopped.
    Stopped = 9,
}

fn local(text: String) -> Failure {
    (Status::Local, text)
}

/// Reads a program, which must fit into the protocol.
pub(crate) fn read(path: &Path) -> Result<Vec<u8>, Failure> {
    let most = u64::try_from(MAX_PROGRAM).unwrap_or(u64::MAX);
    let bytes = contents(path, most + 1)?;
    let file = path.display();
    if bytes.len() > MAX_PROGRAM {
        return Err(local(format!("{file}: it has more than {} MiB", MAX_PROGRAM >> 20)));
    }
    for (n, line) in (1..).zip(bytes.split(|byte| *byte == b'\n')) {
        let line = line.strip_suffix(b"\r").unwrap_or(line);
        if line.len() >= teleop::MAX_LINE {
            let most = teleop::MAX_LINE - 1;
            return Err(local(format!("{file}:{n}: the line has more than {most} bytes")));
        }
        if str::from_utf8(line).is_err() {
            return Err(local(format!("{file}:{n}: the line is no UTF-8")));
        }
    }
    Ok(bytes)
}

/// Reads a file up to this number of bytes.
fn contents(path: &Path, most: u64) -> Result<Vec<u8>, Failure> {
    let why = |e: std::io::Error| local(format!("{}: {}", path.display(), hal_output::reason(&e)));
    let mut bytes = Vec::new();
    if path == Path::new("-") {
        std::io::stdin().lock().take(most).read_to_end(&mut bytes).map_err(why)?;
    } else {
        let file = std::fs::File::open(path).map_err(why)?;
        file.take(most).read_to_end(&mut bytes).map_err(why)?;
    }
    Ok(bytes)
}

impl Arguments {
    /// Returns the token or password: the first line of the file, without the address before a token.
    pub(crate) fn secret(&self) -> Result<String, Failure> {
        let path = match &self.secret_file {
            Some(path) => path.clone(),
            None => {
                // With the token, that computer could open a session here.
                if !self.address()?.ip().is_loopback() {
                    let to = &self.to;
                    return Err(local(format!(
                        "{to}: another computer does not get the token of this one: --secret-file names the file with the password"
                    )));
                }
                let place = Place::find(self.instance.as_deref()).map_err(|why| {
                    local(format!("{why}; without an instance here, --secret-file names the file with the password"))
                })?;
                place.folder().join(format!("panel-{}.url", place.name()))
            }
        };
        let text = contents(&path, MAX_SECRET)?;
        let text = String::from_utf8(text)
            .map_err(|_| local(format!("{}: it is no UTF-8", path.display())))?;
        let line = text.lines().next().unwrap_or_default().trim();
        let secret = line.split_once("#token=").map_or(line, |(_, token)| token);
        if secret.is_empty() {
            return Err(local(format!(
                "{}: its first line has no token or password",
                path.display()
            )));
        }
        Ok(secret.to_owned())
    }

    /// Returns the address of the machine.
    pub(crate) fn address(&self) -> Result<SocketAddr, Failure> {
        let why = |text: String| (Status::Lost, format!("{}: {text}", self.to));
        let mut found = self.to.to_socket_addrs().map_err(|e| why(hal_output::reason(&e)))?;
        found.next().ok_or_else(|| why("there is no such address".to_owned()))
    }

    /// Returns the bytes of the fingerprint.
    pub(crate) fn pinned(&self) -> Result<Option<Vec<u8>>, Failure> {
        let Some(text) = &self.fingerprint else { return Ok(None) };
        let digits: Vec<u8> =
            text.chars().filter(|c| *c != ':').filter_map(|c| c.to_digit(16)).map(low).collect();
        let pairs: Vec<u8> = digits.as_chunks::<2>().0.iter().map(|[a, b]| a << 4 | b).collect();
        let is_whole = text.chars().all(|c| c == ':' || c.is_ascii_hexdigit());
        if !is_whole || digits.len() != 64 {
            let text = format!(
                "--fingerprint {text}: must be the 64 digits of a SHA-256, with or without colons"
            );
            return Err(local(text));
        }
        Ok(Some(pairs))
    }
}

fn low(digit: u32) -> u8 {
    u8::try_from(digit).unwrap_or_default()
}

#[cfg(test)]
mod tests {
    //! Addresses that get the token.

    use super::{Arguments, Parser as _, Status};

    #[test]
    fn another_computer_does_not_get_the_token_of_this_one() {
        for (to, status, begin) in [
            ("192.0.2.9:2000", Status::Local, "192.0.2.9:2000: another computer does not get"),
            ("[2001:db8::1]:2000", Status::Local, "[2001:db8::1]:2000: another computer"),
            ("0.0.0.0:2000", Status::Local, "0.0.0.0:2000: another computer"),
            ("192.0.2.9", Status::Lost, "192.0.2.9: "),
        ] {
            let words = ["halteleop", "--instance", "not-there", "--to", to, "progress"];
            let (is, text) = Arguments::parse_from(words).secret().unwrap_err();
            assert!(is == status && text.starts_with(begin), "{to}: {text}");
        }
        for to in ["127.0.0.1:2000", "[::1]:2000"] {
            let words = ["halteleop", "--instance", "not-there", "--to", to, "progress"];
            let (_, text) = Arguments::parse_from(words).secret().unwrap_err();
            assert!(text.contains("panel-not-there.url: "), "{to}: {text}");
        }
    }
}
