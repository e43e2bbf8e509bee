//! `ferrule try`: a machine of LinuxCNC on this computer, without its hardware: what it is made of, whether it starts, homes
//! and runs a line, and what comes next.

use crate::{beside, failure::Failure, options::Try};
use hal_ini::Ini;
use std::{
    collections::BTreeMap,
    fs,
    path::{Path, PathBuf},
    process::{Command, ExitCode, Output, Stdio},
};

/// Longest move, in units of the machine.
const MOST: f64 = 10.0;
/// Part of an axis's travel that the move takes.
const SHARE: f64 = 0.05;

/// Tries the machine, and prints one page.
pub(crate) fn trial(given: &Try) -> Result<ExitCode, Failure> {
    if !given.machine.is_file() {
        return Err(Failure::NoMachine { path: given.machine.clone() });
    }
    let ini = Ini::read(&given.machine)?;
    let parts = text(&run("halcmd", |c| c.args(["check", "--parts"]).arg(&given.machine))?.stdout);
    let has = |origin: &str| parts.lines().any(|line| line.starts_with(origin));
    let folder = std::env::temp_dir().join(format!("ferrule-try-{}", std::process::id()));
    fs::create_dir(&folder).map_err(|e| Failure::file(&folder, &e))?;
    let here = given.machine.parent().map(Path::to_path_buf).unwrap_or_default();
    let before = Kept::of(&here);
    let tried = attempt(given, &ini, &folder);
    before.restore(&here)?;
    // What is left in the folder for temporary files harms nobody.
    drop(fs::remove_dir_all(&folder));
    let tried = tried?;
    let said = text(&tried.stderr);
    let ran = tried.status.success();
    let machine = given.machine.display();
    let verdict = if ran { "starts, homes and runs a line" } else { "does not run yet" };
    let mut page = format!("{machine}: {verdict}, without its hardware\n\nWhat it is made of\n");
    page.push_str(&indented(parts.lines()));
    page.push_str("\nWhat the start said\n");
    page.push_str(&indented(said.lines().filter(|line| !line.is_empty())));
    page.push_str("\nWhat differs on the real hardware\n");
    page.push_str(&indented(DIFFERS.iter().copied()));
    let findings = run("halcmd", |c| c.args(["check", "--level", "warning"]).arg(&given.machine))?;
    let summary = text(&findings.stdout);
    let summary = summary.lines().last().unwrap_or("no finding").to_owned();
    let mut next = Vec::new();
    if !ran {
        next.push("mend what the start said last, and try again".to_owned());
    }
    if has("missing") {
        next.push(
            "what is missing: install it, or compile its source with halcompile --install"
                .to_owned(),
        );
    }
    if has("hardware") {
        next.push(
            "hardware without a driver here: LinuxCNC's own modules run with halrun --linuxcnc-modules, \
             on the real clock (apt-get install linuxcnc-uspace)"
                .to_owned(),
        );
    }
    next.push(format!("halcmd check {machine}: {summary}"));
    next.push("ferrule doctor: what this computer needs for real time".to_owned());
    next.push(format!(
        "ferrule start --virtual --stub missing {machine}: the panel, on the simulated machine"
    ));
    page.push_str("\nNext\n");
    for (n, step) in next.iter().enumerate() {
        page.push_str(&format!("  {}. {step}\n", n + 1));
    }
    hal_output::print(&page)?;
    Ok(if ran { ExitCode::SUCCESS } else { ExitCode::FAILURE })
}

/// Ends of the names of files that a machine writes while it runs: parameters, tools, journals.
const WRITTEN: [&str; 5] = ["var", "bak", "tbl", "spindle", "journal"];
/// Largest file that is kept, in bytes.
const MAX_BYTES: u64 = 4_000_000;

/// The files of a folder that a run may change.
struct Kept(BTreeMap<PathBuf, Vec<u8>>);

impl Kept {
    fn of(folder: &Path) -> Self {
        let files = written(folder).into_iter();
        Self(files.filter_map(|path| Some((path.clone(), fs::read(&path).ok()?))).collect())
    }

    /// Gives the files their contents back, and removes those that are new.
    fn restore(&self, folder: &Path) -> Result<(), Failure> {
        for path in written(folder) {
            let done = match self.0.get(&path) {
                Some(bytes) if fs::read(&path).is_ok_and(|now| now == *bytes) => Ok(()),
                Some(bytes) => hal_output::write(&path, bytes),
                None => fs::remove_file(&path),
            };
            done.map_err(|e| Failure::file(&path, &e))?;
        }
        // Folders of states that were not there are empty now; the others have something in them.
        let states = folder.join(hal_output::STATES_FOLDER);
        for path in folders(&states).into_iter().chain([states]) {
            fs::remove_dir(path).unwrap_or_default();
        }
        Ok(())
    }
}

/// Returns the files of a folder that a machine may have written, and the states that are kept of them.
fn written(folder: &Path) -> Vec<PathBuf> {
    let is_small = |path: &PathBuf| {
        fs::symlink_metadata(path).is_ok_and(|m| m.is_file() && m.len() <= MAX_BYTES)
    };
    let is_written = |path: &PathBuf| {
        let end = path.extension().map(|e| e.to_string_lossy().into_owned());
        end.is_some_and(|end| WRITTEN.contains(&end.as_str()))
    };
    let own = entries(folder).into_iter().filter(is_written);
    let states = folders(&folder.join(hal_output::STATES_FOLDER));
    let states = states.iter().flat_map(|folder| entries(folder));
    own.chain(states).filter(is_small).collect()
}

fn entries(folder: &Path) -> Vec<PathBuf> {
    let folder = if folder.as_os_str().is_empty() { Path::new(".") } else { folder };
    let entries = fs::read_dir(folder).into_iter().flatten().flatten();
    entries.map(|entry| entry.path()).collect()
}

fn folders(folder: &Path) -> Vec<PathBuf> {
    entries(folder).into_iter().filter(|path| path.is_dir()).collect()
}

/// Differences between the trial and the machine.
const DIFFERS: &[&str] = &[
    "switches, e-stop and drives are at rest here: their wiring is not tested",
    "positions follow their commands at once: no motor is lost, no following error is real",
    "joints whose switches nobody presses were homed where they stood",
    "times are those of the virtual clock: no latency, no overrun",
];

/// Runs one short move on the machine.
fn attempt(given: &Try, ini: &Ini, folder: &Path) -> Result<Output, Failure> {
    let program = folder.join("line.ngc");
    hal_output::write(&program, line(ini).as_bytes()).map_err(|e| Failure::file(&program, &e))?;
    run("halrun", |c| {
        c.args(["--virtual", "--headless", "--stub", "missing", "--instance"])
            .arg(format!("try-{}", std::process::id()))
            .arg("--run")
            .arg(&program)
            .arg(&given.machine)
    })
}

/// Returns a program with one short move of the first axis, from its home to the middle of its travel.
fn line(ini: &Ini) -> String {
    let letters = ini.joint_letters().unwrap_or_default();
    let letter = letters.chars().find(char::is_ascii_uppercase).unwrap_or('X');
    let number = |section: &str, name: &str| -> Option<f64> {
        ini.get(section, name)?.split_whitespace().next()?.parse().ok()
    };
    let joint = if ini.is_old() { "AXIS_0" } else { "JOINT_0" };
    let home = number(joint, "HOME").unwrap_or(0.0);
    let (low, high) = (number(joint, "MIN_LIMIT"), number(joint, "MAX_LIMIT"));
    let move_by = match (low, high) {
        (Some(low), Some(high)) if low < high => {
            let way = ((high - low) * SHARE).min(MOST);
            if home + way <= high { way } else { -way }
        }
        (None, _) | (_, None) => 1.0,
        _ => 0.0,
    };
    if move_by == 0.0 {
        return "G4 P0.1\nM2\n".to_owned();
    }
    format!("G91 G1 {letter}{move_by:.4} F60\nG90\nM2\n")
}

fn run(
    name: &'static str,
    words: impl FnOnce(&mut Command) -> &mut Command,
) -> Result<Output, Failure> {
    let mut command = beside::command(name)?;
    words(&mut command).stdin(Stdio::null());
    command.output().map_err(|e| Failure::NotStarted { name, why: hal_output::reason(&e).into() })
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}

fn indented<'a>(lines: impl Iterator<Item = &'a str>) -> String {
    lines.map(|line| format!("  {line}\n")).collect()
}

#[cfg(test)]
mod tests {
    use super::line;
    use hal_ini::Ini;

    #[test]
    fn the_line_stays_within_the_travel() {
        for (text, want) in [
            (
                "[TRAJ]\nCOORDINATES = X Y\n[JOINT_0]\nMIN_LIMIT = 0\nMAX_LIMIT = 100\n",
                "G91 G1 X5.0000",
            ),
            (
                "[TRAJ]\nCOORDINATES = ZX\n[JOINT_0]\nMIN_LIMIT = -50\nMAX_LIMIT = 0\n",
                "G91 G1 Z-2.5000",
            ),
            ("[JOINT_0]\nMIN_LIMIT = -1000\nMAX_LIMIT = 1000\nHOME = 995\n", "G91 G1 X-10.0000"),
            ("[JOINT_0]\nMIN_LIMIT = 0\nMAX_LIMIT = 0\n", "G4 P0.1"),
            ("[TRAJ]\n", "G91 G1 X1.0000"),
        ] {
            let ini = Ini::parse("m.ini", text.as_bytes()).unwrap_or_default();
            assert!(line(&ini).starts_with(want), "{text}: {}", line(&ini));
        }
    }
}
