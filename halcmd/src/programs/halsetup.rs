//! The program halsetup: writes a machine's INI and HAL files from questions in the terminal or from a TOML file of
//! answers, and keeps them if they are clean.

/// Appends a line. Writing to a string cannot fail.
macro_rules! put {
    ($to:expr, $($words:tt)*) => {{
        let _: std::fmt::Result = writeln!($to, $($words)*);
    }};
}

mod answers;
mod boards;
mod clean;
mod dialog;
mod given;
mod lines;
mod make;
mod proof;
mod questions;
mod rules;
mod search;
mod sheet;
mod tables;
mod timing;
mod trial;
mod whole;
mod wiring;
mod write;

use crate::{
    Stdio, Terminal,
    programs::options::{Opt, mixed, plain, program_usage},
    terminal::ended,
};
use answers::Answers;
use dialog::{Dialog, Ending};
use sheet::{Sheet, Wrong};
use std::{
    fs,
    io::{self, BufRead as _, IsTerminal as _, Read as _},
    path::{Path, PathBuf},
    process::ExitCode,
};

/// Longest file of answers, in bytes.
const MAX_ANSWERS: u64 = 1 << 20;

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Flag {
    Output,
    Test,
    Amplitude,
    VelocityStep,
    AccelerationStep,
    Simulate,
    Virtual,
    Help,
}

const OPTIONS: &[Opt<Flag>] = &[
    Opt {
        help: "where the machine's folder is made, a new folder too; here if none is given",
        long: Some("output"),
        ..Opt::short_with(Flag::Output, 'o', "FOLDER")
    },
    with(Flag::Test, "test", "AXIS", "search the velocity and acceleration that an axis bears"),
    with(Flag::Amplitude, "amplitude", "LENGTH", "test: way to each side (0.45 of the travel)"),
    with(Flag::VelocityStep, "velocity-step", "V", "test: increment (a tenth of the velocity)"),
    with(
        Flag::AccelerationStep,
        "acceleration-step",
        "A",
        "test: increment (a tenth of the answer)",
    ),
    with(Flag::Simulate, "simulate", "V,A", "test: a simulated motor that stalls from V and A on"),
    Opt {
        value: None,
        ..with(Flag::Virtual, "virtual", "", "test: on the virtual clock, a person judges")
    },
    Opt { help: "print this", long: Some("help"), ..Opt::flag(Flag::Help, 'h') },
];

const fn with(id: Flag, name: &'static str, value: &'static str, help: &'static str) -> Opt<Flag> {
    Opt { id, short: None, long: Some(name), value: Some(value), variable: None, help }
}

/// Returns the options for completion.
pub(crate) fn completable() -> Vec<Opt<()>> {
    plain(OPTIONS)
}

/// Runs the program with these command line arguments.
#[must_use]
pub fn main(words: &[String]) -> ExitCode {
    ended(run(words).map_err(|text| format!("halsetup: {text}")))
}

fn run(words: &[String]) -> Result<(), String> {
    let (given, files) = mixed("halsetup", OPTIONS, words).map_err(|e| e.to_string())?;
    if given.iter().any(|(id, _)| *id == Flag::Help) {
        let about = "Usage: halsetup [options] [ANSWERS]\n\n\
                     Writes a machine's INI and HAL files into a new folder with its name. Without a file of answers\n\
                     it asks in the terminal; 'back', 'save' and '?' are understood at each question, and the answers are\n\
                     always kept: a file that is not answered to the end is gone on with.\n\n\
                     With --test it makes no files: it runs an axis of the answers back and forth, harder each time, and\n\
                     asks whether the axis stands on its mark again. The machine moves: keep a hand on the e-stop.\n\noptions:\n";
        Stdio.out(&format!("{about}{}", program_usage(OPTIONS)))?;
        return Ok(());
    }
    let output = given.iter().rev().find(|(id, _)| *id == Flag::Output);
    let folder = PathBuf::from(
        output.and_then(|(_, value)| value.clone()).unwrap_or_else(|| ".".to_owned()),
    );
    let file = match files.as_slice() {
        [] => None,
        [file] => Some(file.as_str()),
        _ => return Err("one file of answers at most".to_owned()),
    };
    if let Some(search) = asked_search(&given)? {
        let file = file.ok_or("--test needs a file of answers: halsetup --test X NAME.setup")?;
        let text = text_of(file)?;
        let answers = given::read(&text).map_err(|list| places(file, &text, &list))?;
        Stdio.out(&trial::test(&answers, &search, &mut line)?)?;
        return Ok(());
    }
    let answered = match file {
        None => asked(&folder, Sheet::default(), None)?,
        Some(file) => from_file(&folder, file)?,
    };
    let Some(answered) = answered else { return Ok(()) };
    Stdio.out(&make::make(&Answers::of(&answered.sheet), &answered.text, &folder)?)?;
    // The machine's folder has the answers now.
    match answered.kept {
        Some((kept, true)) => drop(fs::remove_file(kept)),
        Some((kept, false)) => {
            hal_output::write(&kept, answered.text.as_bytes())
                .map_err(|e| format!("{}: {}", kept.display(), hal_output::reason(&e)))?;
        }
        None => {}
    }
    Ok(())
}

/// Answers to every question.
struct Answered {
    sheet: Sheet,
    /// Text for the machine's folder.
    text: String,
    /// File that keeps the answers meanwhile, and whether the conversation made it.
    kept: Option<(PathBuf, bool)>,
}

/// Returns the answers of a file. Where some are missing, a person gives them.
fn from_file(folder: &Path, file: &str) -> Result<Option<Answered>, String> {
    let text = text_of(file)?;
    let given = given::given(&text).map_err(|list| places(file, &text, &list))?;
    let is_person = io::stdin().is_terminal();
    let goes_on = given.is_unfinished || given.only_lacks && is_person && !given.wrong.is_empty();
    if !goes_on {
        return match given.wrong.as_slice() {
            [] => Ok(Some(Answered { sheet: given.sheet, text, kept: None })),
            list => Err(places(file, &text, list)),
        };
    }
    if !given.only_lacks {
        Stdio.out(&format!("{}\n", places(file, &text, &given.wrong)))?;
    }
    let mut sheet = given.sheet;
    for key in given.assumed {
        sheet.remove(&key);
    }
    let file = Path::new(file);
    asked(folder, sheet, Some(file))
}

/// Asks a person what the sheet does not answer yet. The answers so far are always in a file: nothing that happens loses
/// them. Returns nothing if the person goes on later.
fn asked(folder: &Path, mut sheet: Sheet, file: Option<&Path>) -> Result<Option<Answered>, String> {
    let is_own = file.is_none();
    let place = |sheet: &Sheet| match file {
        Some(file) => file.to_owned(),
        None => folder.join(format!("{}.setup", sheet.get("name").unwrap_or("machine"))),
    };
    let mut kept = None::<PathBuf>;
    let mut keep = |sheet: &Sheet| {
        let to = place(sheet);
        if kept.as_ref().is_some_and(|before| *before != to) {
            drop(kept.take().map(fs::remove_file));
        }
        if sheet.get("name").is_none() {
            return Ok(());
        }
        if is_own {
            fs::create_dir_all(folder)
                .map_err(|e| format!("{}: {}", to.display(), hal_output::reason(&e)))?;
        }
        let is_first = kept.replace(to.clone()).is_none();
        hal_output::write(&to, sheet.text(false).as_bytes())
            .map_err(|e| format!("{}: {}", to.display(), hal_output::reason(&e)))?;
        if is_first {
            Stdio.out(&format!(
                "(each answer is kept: 'halsetup {}' goes on with them)\n",
                to.display()
            ))?;
        }
        Ok(())
    };
    let mut taken = |name: &str| {
        let there = [folder.join(name), folder.join(format!("{name}.setup"))];
        let there = there.iter().find(|path| is_own && path.exists())?;
        Some(if there.extension().is_some_and(|e| e == "setup") {
            format!(
                "{0}: is there already; another name, or 'halsetup {0}' to go on with it",
                there.display()
            )
        } else {
            format!("{}: is there already; another name", there.display())
        })
    };
    let mut dialog = Dialog { ask: &mut line, keep: &mut keep, taken: &mut taken };
    let end = dialog.questions(&mut sheet)?;
    let to = place(&sheet);
    let goes_on = format!("'halsetup {}' goes on with it", to.display());
    match (end, sheet.get("name").is_some()) {
        (Ending::Answered, _) => {
            let text = sheet.text(true);
            Ok(Some(Answered { sheet, text, kept: Some((to, is_own)) }))
        }
        (Ending::Saved, true) => {
            Stdio.out(&format!("{}: has the answers so far; {goes_on}\n", to.display()))?;
            Ok(None)
        }
        (Ending::Ended, true) => Err(format!(
            "the questions were not answered to the end; {} has the answers so far: {goes_on}",
            to.display()
        )),
        (_, false) => Err("no question was answered; nothing was written".to_owned()),
    }
}

/// Returns the search that the options ask for.
fn asked_search(given: &[(Flag, Option<String>)]) -> Result<Option<trial::Search>, String> {
    let value = |flag| given.iter().rev().find(|(id, _)| *id == flag).map(|(_, v)| v.clone());
    let text = |flag| value(flag).flatten();
    let number = |flag, name: &str| match text(flag) {
        None => Ok(None),
        Some(text) => trial::positive(&text)
            .map(Some)
            .ok_or_else(|| format!("--{name} '{text}': a number above 0")),
    };
    let search = trial::Search {
        axis: text(Flag::Test).unwrap_or_default(),
        amplitude: number(Flag::Amplitude, "amplitude")?,
        velocity_step: number(Flag::VelocityStep, "velocity-step")?,
        acceleration_step: number(Flag::AccelerationStep, "acceleration-step")?,
        stall: match text(Flag::Simulate) {
            None => None,
            Some(text) => Some(trial::pair(&text).ok_or_else(|| {
                format!("--simulate '{text}': VELOCITY,ACCELERATION, two numbers above 0")
            })?),
        },
        is_virtual: value(Flag::Virtual).is_some(),
    };
    if value(Flag::Test).is_some() {
        return Ok(Some(search));
    }
    if search == trial::Search::default() {
        return Ok(None);
    }
    Err("--amplitude, the increments, --simulate and --virtual are for --test".to_owned())
}

fn text_of(file: &str) -> Result<String, String> {
    let bytes = hal_ini::file::contents(Path::new(file), MAX_ANSWERS)
        .map_err(|e| format!("{file}: {}", hal_output::reason(&e)))?
        .ok_or_else(|| format!("{file}: answers have at most {MAX_ANSWERS} bytes"))?;
    String::from_utf8(bytes).map_err(|_| format!("{file}: answers are text in UTF-8"))
}

/// Asks a person for a line; `None` at the end of the input.
fn line(prompt: &str) -> Result<Option<String>, String> {
    Stdio.out(prompt)?;
    let mut line = String::new();
    match io::stdin().lock().take(4096).read_line(&mut line) {
        Ok(0) => Ok(None),
        Ok(_) => Ok(Some(line)),
        Err(e) => Err(hal_output::reason(&e)),
    }
}

/// Returns all that is wrong, each with its line.
fn places(file: &str, text: &str, list: &[Wrong]) -> String {
    let line = |at: usize| text.get(..at).map_or(1, |before| before.matches('\n').count() + 1);
    let each: Vec<String> =
        list.iter().map(|w| format!("{file}:{}: {}", line(w.at), w.text)).collect();
    each.join("\nhalsetup: ")
}
