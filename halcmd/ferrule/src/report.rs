//! `ferrule report`: what a report of a fault needs, in one archive. It is listed before it is written, and private
//! details are left out.

mod private;

use crate::{beside, doctor, failure::Failure, options::Report};
use flate2::{Compression, write::GzEncoder};
use hal_protocol::Place;
use private::Private;
use std::{
    fs,
    path::{Path, PathBuf},
    process::{Command, ExitCode, Stdio},
};

/// Endings of the text files of a machine.
const TEXTS: [&str; 9] = ["ini", "hal", "tcl", "tbl", "var", "inc", "comp", "toml", "ngc"];
/// Largest file of a machine that is taken, in bytes.
const MOST: u64 = 1 << 20;
/// Most files of a machine.
const FILES: usize = 200;
/// Bytes of a log that are taken, from its end.
const TAIL: usize = 256 << 10;

/// Collects the report, shows what is in it, and writes it if the person agrees.
pub(crate) fn report(given: &Report) -> Result<ExitCode, Failure> {
    if !given.yes && !hal_output::is_person() {
        return Err(Failure::NoTerminal {
            what: "ferrule report",
            instead: "--yes writes it without",
        });
    }
    let private = Private::of_this_user();
    let mut parts = vec![
        ("versions.txt".to_owned(), versions()),
        ("computer.txt".to_owned(), doctor::examined(Path::new("/"))),
    ];
    parts.extend(instance(given)?);
    if let Some(machine) = &given.machine {
        parts.extend(files(machine)?);
    }
    let parts: Vec<(String, String)> =
        parts.into_iter().map(|(name, text)| (name, private.without(&text))).collect();
    let mut listing = format!("{} will have:\n", given.output.display());
    for (name, text) in &parts {
        listing.push_str(&format!("{:>9} bytes  {name}\n", text.len()));
    }
    listing.push_str("Names of the user and the computer, network addresses, and entries of the INI file that are a password, a token or a key are left out. Read the files before you send them.\n");
    hal_output::print(&listing)?;
    if !given.yes && !agrees("write it?")? {
        return Ok(ExitCode::FAILURE);
    }
    let bytes = packed(&parts).map_err(|e| Failure::file(&given.output, &e))?;
    hal_output::install(&given.output, &bytes, 0o600)
        .map_err(|e| Failure::file(&given.output, &e))?;
    Ok(ExitCode::SUCCESS)
}

pub(crate) fn agrees(question: &str) -> Result<bool, Failure> {
    hal_output::print(&format!("{question} [y/N] "))?;
    let mut answer = String::new();
    // Without an answer nothing is written.
    drop(std::io::stdin().read_line(&mut answer));
    Ok(answer.trim().eq_ignore_ascii_case("y"))
}

fn versions() -> String {
    let mut text = format!("ferrule {}\n", env!("CARGO_PKG_VERSION"));
    for name in ["halrun", "halpanel"] {
        let said =
            beside::find(name).ok().and_then(|p| Command::new(p).arg("--version").output().ok());
        let said = said.map(|done| String::from_utf8_lossy(&done.stdout).trim().to_owned());
        text.push_str(
            &said.map_or_else(|| format!("{name}: not found\n"), |said| format!("{said}\n")),
        );
    }
    let system = ["/etc/os-release", "/proc/version", "/proc/cmdline"];
    for path in system {
        let told = fs::read_to_string(path).unwrap_or_default();
        text.push_str(&format!("\n{path}:\n{}\n", told.trim_end()));
    }
    text
}

/// Returns what the running instance says of itself, and the end of its log.
fn instance(given: &Report) -> Result<Vec<(String, String)>, Failure> {
    let place =
        Place::find(given.instance.as_deref()).map_err(|why| Failure::Instance(why.into()))?;
    let mut parts = Vec::new();
    let questions =
        [("status.txt", &["status"][..]), ("show.txt", &["show"]), ("saved.hal", &["save"])];
    for (name, words) in questions {
        let mut command = beside::command("halcmd")?;
        command.args(["--instance", place.name()]).args(words).stdin(Stdio::null());
        if let Ok(done) = command.output()
            && done.status.success()
        {
            parts.push((name.to_owned(), String::from_utf8_lossy(&done.stdout).into_owned()));
        }
    }
    if let Ok(log) = fs::read(place.log()) {
        let end = log.get(log.len().saturating_sub(TAIL)..).unwrap_or_default();
        parts.push(("log.txt".to_owned(), String::from_utf8_lossy(end).into_owned()));
    }
    Ok(parts)
}

/// Returns the text files of a machine: those of its folder, not those of folders below.
fn files(machine: &Path) -> Result<Vec<(String, String)>, Failure> {
    let folder = if machine.is_dir() {
        machine.to_owned()
    } else if machine.is_file() {
        machine.parent().map(Path::to_owned).unwrap_or_default()
    } else {
        return Err(Failure::NoMachine { path: machine.to_owned() });
    };
    let folder = if folder.as_os_str().is_empty() { PathBuf::from(".") } else { folder };
    let entries = fs::read_dir(&folder).map_err(|e| Failure::file(&folder, &e))?;
    let mut paths: Vec<PathBuf> = entries.filter_map(|entry| Some(entry.ok()?.path())).collect();
    paths.retain(|path| {
        let ending = path.extension().map(|e| e.to_string_lossy().to_lowercase());
        path.is_file() && ending.is_some_and(|e| TEXTS.contains(&e.as_str()))
    });
    paths.sort();
    paths.truncate(FILES);
    let mut parts = Vec::new();
    for path in paths {
        let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
        let text = match hal_ini::file::contents(&path, MOST) {
            Ok(Some(bytes)) => String::from_utf8_lossy(&bytes).into_owned(),
            Ok(None) => format!("(larger than {MOST} bytes, left out)\n"),
            Err(error) => format!("({})\n", hal_output::reason(&error)),
        };
        parts.push((format!("machine/{name}"), text));
    }
    Ok(parts)
}

/// Returns the archive: a compressed tar file, with nothing in it that says who made it, or when.
fn packed(parts: &[(String, String)]) -> std::io::Result<Vec<u8>> {
    let mut archive = tar::Builder::new(GzEncoder::new(Vec::new(), Compression::default()));
    for (name, text) in parts {
        let mut header = tar::Header::new_gnu();
        header.set_size(text.len() as u64);
        header.set_mode(0o644);
        header.set_cksum();
        archive.append_data(&mut header, format!("ferrule-report/{name}"), text.as_bytes())?;
    }
    archive.into_inner()?.finish()
}
