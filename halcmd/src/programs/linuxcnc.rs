//! The program linuxcnc: starts a machine from its INI file as the icons of a desktop do, by halrun.

use crate::{
    ini::Ini,
    programs::options::{Opt, options, plain, usage},
    terminal::{Stdio, Terminal, ended},
};
use std::{
    ffi::OsString,
    fs,
    os::unix::process::CommandExt,
    path::{Path, PathBuf},
    process::{Command, ExitCode},
};

/// Folder of the HAL files that LinuxCNC's package has for all machines.
const LIBRARY: &str = "/usr/share/linuxcnc/hallib";
/// Folder of users' machines, in the home folder: a folder for each.
const CONFIGS: &str = "linuxcnc/configs";
/// Most machines that are listed.
const MOST: usize = 200;

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum StartOption {
    Verbose,
    Debug,
    Plain,
    KeepGoing,
    Library,
    Last,
    Planner,
    Homing,
    Help,
}

const OPTIONS: &[Opt<StartOption>] = &[
    Opt { help: "say what each command did", ..Opt::flag(StartOption::Verbose, 'v') },
    Opt { help: "also show every message of components", ..Opt::flag(StartOption::Debug, 'd') },
    Opt {
        help: "keep going after a line of a HAL file that fails",
        ..Opt::flag(StartOption::KeepGoing, 'k')
    },
    Opt {
        help: "look for HAL files in this folder first",
        ..Opt::short_with(StartOption::Library, 'H', "FOLDER")
    },
    Opt { help: "of no effect: output is not redirected", ..Opt::flag(StartOption::Plain, 'r') },
    Opt { long: Some("help"), help: "print this", ..Opt::flag(StartOption::Help, 'h') },
];

/// Options of LinuxCNC that are refused, with the reason.
const REFUSED: &[Opt<StartOption>] = &[
    Opt { help: "name the machine's INI file", ..Opt::flag(StartOption::Last, 'l') },
    Opt {
        help: "the trajectory planner is part of motmod",
        ..Opt::short_with(StartOption::Planner, 't', "MODULE")
    },
    Opt { help: "homing is part of motmod", ..Opt::short_with(StartOption::Homing, 'm', "MODULE") },
];

/// Returns the options for completion.
pub(crate) fn completable() -> Vec<Opt<()>> {
    plain(OPTIONS)
}

/// Runs the program with these command line arguments.
#[must_use]
pub fn main(words: &[String]) -> ExitCode {
    ended(run(words).map_err(|text| format!("linuxcnc: {text}")))
}

fn run(words: &[String]) -> Result<(), String> {
    let all = [OPTIONS, REFUSED].concat();
    let (given, rest) = options("linuxcnc", &all, words)
        .map_err(|error| error.whole().trim_start_matches("linuxcnc: ").to_owned())?;
    if given.iter().any(|(id, _)| *id == StartOption::Help) {
        return Ok(Stdio.out(&help())?);
    }
    if let Some(refused) = REFUSED.iter().find(|o| given.iter().any(|(id, _)| *id == o.id)) {
        let letter = refused.short.unwrap_or_default();
        return Err(format!("-{letter} is not supported; {}", refused.help));
    }
    let file = match rest.as_slice() {
        [] => return Err(listing(&machines())),
        [file] => file,
        [_, other, ..] => return Err(format!("one INI file is started, not also '{other}'")),
    };
    if !Path::new(file).is_file() {
        return Err(format!("'{file}' is no file\n{}", listing(&machines())));
    }
    let halrun = std::env::current_exe().ok().and_then(|exe| Some(exe.parent()?.join("halrun")));
    let halrun = halrun.filter(|path| path.is_file()).ok_or("halrun is not beside this program")?;
    let mut command = Command::new(halrun);
    let libraries =
        libraries(given.iter().filter(|(id, _)| *id == StartOption::Library).map(|(_, v)| v));
    command.env("HALLIB_PATH", libraries);
    for (id, option) in
        [(StartOption::Verbose, "-v"), (StartOption::Debug, "-V"), (StartOption::KeepGoing, "-k")]
    {
        if given.iter().any(|(given, _)| *given == id) {
            command.arg(option);
        }
    }
    let error = command.arg("--").arg(file).exec();
    Err(format!("halrun: {error}"))
}

/// Returns the folders with HAL files: those of the options, the user's, and LinuxCNC's if it is installed.
fn libraries<'a>(given: impl Iterator<Item = &'a Option<String>>) -> OsString {
    let mut all: Vec<PathBuf> = given.flatten().map(PathBuf::from).collect();
    // The last one is the first to be looked into, as each is put before the others.
    all.reverse();
    let own = std::env::var_os("HALLIB_PATH").unwrap_or_default();
    all.extend(std::env::split_paths(&own).filter(|path| !path.as_os_str().is_empty()));
    all.extend(Some(PathBuf::from(LIBRARY)).filter(|path| path.is_dir()));
    std::env::join_paths(all).unwrap_or(own)
}

/// Returns the INI files of machines in this folder and among those of the user.
fn machines() -> Vec<PathBuf> {
    let mut folders = vec![PathBuf::new()];
    if let Some(home) = std::env::var_os("HOME") {
        folders.extend(entries(&Path::new(&home).join(CONFIGS)).filter(|path| path.is_dir()));
    }
    let files = folders.iter().flat_map(|folder| {
        let here = if folder.as_os_str().is_empty() { Path::new(".") } else { folder };
        entries(here).map(|path| path.strip_prefix(".").map(Path::to_path_buf).unwrap_or(path))
    });
    let mut found: Vec<PathBuf> = files.filter(|path| is_machine(path)).take(MOST).collect();
    found.sort();
    found
}

fn entries(folder: &Path) -> impl Iterator<Item = PathBuf> + use<> {
    fs::read_dir(folder).into_iter().flatten().filter_map(|entry| Some(entry.ok()?.path()))
}

/// Returns whether a file is the INI file of a machine, and not a part of one.
fn is_machine(path: &Path) -> bool {
    let is_ini = path.extension().is_some_and(|e| e == "ini");
    is_ini && Ini::read(path).is_ok_and(|ini| ini.has_section("EMCIO") || ini.has_section("KINS"))
}

fn listing(machines: &[PathBuf]) -> String {
    let mut text = "give the INI file of a machine: linuxcnc machine.ini".to_owned();
    if machines.is_empty() {
        text.push_str("\nthere is none in this folder, nor in a folder of ~/linuxcnc/configs");
    } else {
        text.push_str("\nthere are:");
        machines.iter().for_each(|path| text.push_str(&format!("\n  {}", path.display())));
    }
    text
}

fn help() -> String {
    format!(
        "\nUsage:   linuxcnc [options] MACHINE.ini\n\n\
         Starts a machine by halrun, with the HAL files of LinuxCNC's package where it is installed. Without a\n\
         file, lists the machines in this folder and in ~/linuxcnc/configs.\n\noptions:\n{}",
        usage(OPTIONS)
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn wrong_words_are_named() {
        let said = |words: &[&str]| {
            run(&words.iter().map(|w| (*w).to_owned()).collect::<Vec<_>>()).unwrap_err()
        };
        assert_eq!(said(&["-l"]), "-l is not supported; name the machine's INI file");
        assert_eq!(
            said(&["-t", "mine", "m.ini"]),
            "-t is not supported; the trajectory planner is part of motmod"
        );
        assert_eq!(said(&["a.ini", "b.ini"]), "one INI file is started, not also 'b.ini'");
        assert!(said(&["nosuch.ini"]).starts_with("'nosuch.ini' is no file\ngive the INI file"));
        assert!(said(&["-x"]).starts_with("invalid option -- 'x'"));
    }

    #[test]
    fn machines_are_told_from_parts_of_them() {
        let folder = std::env::temp_dir().join(format!("ferrule-list-{}", std::process::id()));
        fs::create_dir_all(&folder).unwrap();
        let mut found = Vec::new();
        for (name, text) in [
            ("m.ini", "[EMCIO]\nCYCLE_TIME = 0.1\n"),
            ("part.ini", "[DISPLAY]\nX = 1\n"),
            ("broken.ini", "[EMCIO\n"),
            ("m.txt", "[EMCIO]\nCYCLE_TIME = 0.1\n"),
        ] {
            let path = folder.join(name);
            fs::write(&path, text).unwrap();
            found.push(is_machine(&path));
        }
        fs::remove_dir_all(&folder).unwrap();
        assert_eq!(found, [true, false, false, false]);
    }
}
