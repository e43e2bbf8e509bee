//! The programs haltcl and halshow: Tcl with the commands of HAL, for a running instance.

use crate::{
    Error,
    programs::halrun::folders::Folders,
    programs::options::{Opt, options, plain, usage},
    session::remote::instance_option,
    session::tcl::tclsh,
    terminal::{Stdio, Terminal, ended},
};
use std::{
    io::ErrorKind,
    os::unix::process::CommandExt,
    path::{Path, PathBuf},
    process::ExitCode,
};

/// Script of LinuxCNC's program `halshow`, which shows what there is as a tree.
const HALSHOW: &str = "/usr/lib/tcltk/linuxcnc/bin/halshow.tcl";

const HALSHOW_HELP: &str = "
Usage:   halshow [options] [WATCHLIST]

Shows components, pins, parameters, signals and functions of the running instance as a tree, in a window; a
watch list that was saved in it is opened again. The window is LinuxCNC's, from the package linuxcnc-uspace.

options:
      --fformat FORMAT    format of floats, such as %.5f
      --iformat FORMAT    format of integers, such as %08X
      --noprefs           neither read nor write the preferences
  -h, --help              print this
      --version           print the version
";

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Word {
    Ini,
    Instance,
    Help,
}

const OPTIONS: &[Opt<Word>] = &[
    Opt {
        help: "make an array of each section of this INI file",
        ..Opt::short_with(Word::Ini, 'i', "FILE")
    },
    instance_option(Word::Instance),
    Opt { long: Some("help"), help: "print this", ..Opt::flag(Word::Help, 'h') },
];

/// Returns the options for completion.
pub(crate) fn completable() -> Vec<Opt<()>> {
    plain(OPTIONS)
}

/// Runs haltcl with these command line arguments.
#[must_use]
pub fn main(words: &[String]) -> ExitCode {
    // The spelling of older scripts.
    let words: Vec<String> =
        words.iter().map(|w| if w == "-ini" { "-i".to_owned() } else { w.clone() }).collect();
    let (given, rest) = match options("haltcl", OPTIONS, &words) {
        Ok(parsed) => parsed,
        Err(error) => return ended(Err(error.whole())),
    };
    if given.iter().any(|(id, _)| *id == Word::Help) {
        return ended(Stdio.out(&help()).map_err(|unwritten| unwritten.to_string()));
    }
    let value = |wanted| given.iter().rev().find(|(id, _)| *id == wanted)?.1.clone();
    let ini = value(Word::Ini).map(|file| ["-i".to_owned(), file]);
    let args: Vec<String> = ini.into_iter().flatten().chain(rest).collect();
    ended(Err(execute("haltcl", &args, value(Word::Instance))))
}

/// Runs LinuxCNC's halshow with these command line arguments.
#[must_use]
pub fn halshow(words: &[String]) -> ExitCode {
    if words.iter().any(|word| ["-h", "-help", "--help"].contains(&&**word)) {
        return ended(Stdio.out(HALSHOW_HELP).map_err(|unwritten| unwritten.to_string()));
    }
    if std::env::var_os("DISPLAY").is_none_or(|display| display.is_empty()) {
        let text = "halshow: DISPLAY is not set: it needs a screen; in a terminal, 'halcmd show' and 'halcmd watch' show \
                    the same";
        return ended(Err(text.to_owned()));
    }
    if !Path::new(HALSHOW).is_file() {
        let text = format!("halshow: '{HALSHOW}' is missing; apt-get install linuxcnc-uspace");
        return ended(Err(text));
    }
    let args: Vec<String> = [HALSHOW.to_owned()].into_iter().chain(words.iter().cloned()).collect();
    ended(Err(execute("halshow", &args, None)))
}

/// Replaces this process by the interpreter. Returns the reason why it cannot.
fn execute(program: &str, args: &[String], instance: Option<String>) -> String {
    let folder = match tclsh::folder() {
        Ok(folder) => folder,
        Err(folder) => {
            let folder = folder.display().to_string().into();
            return format!("{program}: {}", Error::NoTclPackage { folder }.whole());
        }
    };
    let libraries: Vec<PathBuf> = Folders::of(Path::new("")).libraries;
    let mut command = tclsh::command(&folder, &libraries);
    command.args(args).envs(instance.map(|name| ("HAL_INSTANCE", name)));
    let error = command.exec();
    let text = match error.kind() {
        ErrorKind::NotFound => Error::NoTclsh.whole(),
        _ => crate::ini::plain(&error).into(),
    };
    format!("{program}: {text}")
}

fn help() -> String {
    format!(
        "\nUsage:   haltcl [options] [FILE.tcl [ARGUMENT...]]\n\n\
         Executes a Tcl file with the commands of HAL in the running instance. Without a file, commands\n\
         are taken from the terminal.\n\noptions:\n{}",
        usage(OPTIONS)
    )
}
