//! `halgcode apt`: a cutter-location file, judged for a robot arm and written for its controllers.

mod cell;
mod path;
mod report;
mod write;

pub use path::{ArmPath, ArmStep, Cutter, path, path_of};

use super::views::Views;
use crate::{
    Stdio, Terminal,
    programs::{
        options::{Opt, mixed, plain, usage},
        picture,
    },
    terminal::print_error,
};
use hal_arm::{Refused, apt::Part, targets};
use std::{
    path::{Path, PathBuf},
    process::ExitCode,
};

/// Words that the command takes.
pub(super) const ARGUMENTS: &str = "-i INI [options] FILE";
/// Description.
pub(super) const HELP: &str =
    "a cutter-location file for a robot arm: place, reach, configurations, points";

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Id {
    Ini,
    All,
    Points,
    Joints,
    Script,
    Output,
    Help,
}

const OPTIONS: &[Opt<Id>] = &[
    Opt {
        long: Some("ini"),
        help: "the cell: its sections [ARM] and [PART]",
        ..Opt::short_with(Id::Ini, 'i', "INI")
    },
    Opt {
        long: Some("all"),
        help: "the verdict of each configuration on every point",
        ..Opt::flag(Id::All, 'a')
    },
    Opt {
        long: Some("points"),
        help: "write the points: X Y Z of the tip and its angles about Z, Y, Z",
        ..Opt::short_with(Id::Points, 'p', "FILE")
    },
    Opt {
        long: Some("joints"),
        help: "write the six joints of each point",
        ..Opt::short_with(Id::Joints, 'j', "FILE")
    },
    Opt {
        long: Some("script"),
        help: "write a script of moves for motion, where each joint is an axis",
        ..Opt::short_with(Id::Script, 's', "FILE")
    },
    Opt {
        long: Some("output"),
        help: "a picture of the path and the arm, FILE.svg or FILE.png",
        ..Opt::short_with(Id::Output, 'o', "FILE")
    },
    Opt { long: Some("help"), help: "print this", ..Opt::flag(Id::Help, 'h') },
];

/// Returns the options for completion.
pub(super) fn completable() -> Vec<Opt<()>> {
    plain(OPTIONS)
}

/// Runs `apt` with these words. The status is 1 if the file is wrong or the arm cannot run it; nothing is written then.
pub(super) fn main(words: &[String]) -> Result<ExitCode, String> {
    let (given, rest) = mixed("halgcode", OPTIONS, words).map_err(|e| e.to_string())?;
    let path = |wanted| {
        let found = given.iter().rev().find(|(id, _)| *id == wanted)?;
        found.1.as_deref().map(PathBuf::from)
    };
    let is_given = |wanted| given.iter().any(|(id, _)| *id == wanted);
    if is_given(Id::Help) {
        Stdio.out(&super::help::usage_of("apt", ARGUMENTS, HELP, &usage(OPTIONS)))?;
        return Ok(ExitCode::SUCCESS);
    }
    let ([file], Some(ini)) = (rest.as_slice(), path(Id::Ini)) else {
        return Err("which file? halgcode apt -i INI [options] FILE".into());
    };
    let picture = path(Id::Output).map(|p| picture::Kind::of(&p).map(|kind| (p, kind)));
    let picture = picture.transpose()?;
    let Some(part) = read(file)? else { return Ok(ExitCode::FAILURE) };
    let cell = match cell::read(&ini) {
        Ok(cell) => cell,
        Err(text) => {
            print_error(&format!("{text}\n"));
            return Ok(ExitCode::FAILURE);
        }
    };
    let targets = targets(&part.points, &cell.frame, cell.approach, cell.feed);
    Stdio.out(&report::part(file, &part, &cell))?;
    if is_given(Id::All) {
        Stdio.out(&report::verdicts(&cell, &targets))?;
    }
    let plan = match cell.cell.plan(&targets) {
        Ok(plan) => plan,
        Err(refused) => {
            print_error(&report::refused(file, &refused, &targets));
            if matches!(refused, Refused::Changes(_)) {
                print_error(
                    "JUMP = retract in [ARM] lets the arm change where the tool is away from the part\n",
                );
            }
            return Ok(ExitCode::FAILURE);
        }
    };
    Stdio.out(&report::plan(&cell, &plan, &targets))?;
    let save = |path: Option<PathBuf>, text: &dyn Fn() -> Vec<u8>| -> Result<(), String> {
        let Some(path) = path else { return Ok(()) };
        let written = hal_output::write(&path, &text());
        written.map_err(|e| format!("{}: {}", path.display(), hal_output::reason(&e)))
    };
    save(path(Id::Points), &|| write::points(&plan).into_bytes())?;
    save(path(Id::Joints), &|| write::joints(&plan).into_bytes())?;
    save(path(Id::Script), &|| write::script(file, &plan, &targets).into_bytes())?;
    if let Some((path, kind)) = picture {
        let title = if part.name.is_empty() { file.clone() } else { part.name.clone() };
        let moves = write::drawing(&cell, &plan, &targets);
        let views = Views::new(moves, Vec::new(), None, title, (1400, 1050));
        let views = views.ok_or_else(|| format!("{file}: there is no move to draw"))?;
        let bytes = kind.bytes(&views)?;
        save(Some(path), &|| bytes.clone())?;
    }
    Ok(ExitCode::SUCCESS)
}

/// Reads the file. Returns `None` after an error of its text.
fn read(file: &str) -> Result<Option<Part>, String> {
    let text = hal_ini::file::whole(Path::new(file));
    let text = text.map_err(|e| format!("{file}: {}", hal_output::reason(&e)))?;
    match Part::parse(&text) {
        Ok(part) => Ok(Some(part)),
        Err(error) => {
            print_error(&format!("{file}:{error}\n"));
            let mut lines = text.split(|b| *b == b'\n');
            let line =
                usize::try_from(error.line).ok().and_then(|n| lines.nth(n.saturating_sub(1)));
            if let Some(line) = line.filter(|l| l.len() < 200) {
                let line = String::from_utf8_lossy(line);
                let before = usize::try_from(error.column.saturating_sub(1)).unwrap_or(0).min(200);
                print_error(&format!("    {}\n    {}^\n", line.trim_end(), " ".repeat(before)));
            }
            Ok(None)
        }
    }
}
