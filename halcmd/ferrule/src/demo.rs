//! `ferrule demo`: the printer's machine cuts a pedal in virtual time.

mod cut;

use crate::{
    beside,
    failure::Failure,
    options::Demo,
    start::{start, virtual_of},
};
use rustix::time::{ClockId, clock_gettime};
use std::{
    fs,
    path::Path,
    process::{Command, ExitCode, Stdio},
};

/// The files of the machine, which are those of `configs/printer`, and what the demonstration adds.
const FILES: [(&str, &[u8]); 9] = [
    ("printer.ini", include_bytes!("../../../configs/printer/printer.ini")),
    ("printer.hal", include_bytes!("../../../configs/printer/printer.hal")),
    ("custom.hal", include_bytes!("../../../configs/printer/custom.hal")),
    ("custom_postgui.hal", include_bytes!("../../../configs/printer/custom_postgui.hal")),
    ("tool.tbl", include_bytes!("../../../configs/printer/tool.tbl")),
    ("programs/pedal.ngc", include_bytes!("../../../configs/printer/pedal.ngc")),
    ("demo.ini", include_bytes!("demo/demo.ini")),
    ("demo.hal", include_bytes!("demo/demo.hal")),
    ("cut.ini", include_bytes!("demo/cut.ini")),
];
/// Folder of programs.
const PROGRAMS: &str = "programs";
/// The part.
const PART: &str = "programs/pedal.ngc";
/// The wiring of the recording.
const RECORD: (&str, &[u8]) = ("record.hal", include_bytes!("demo/record.hal"));

/// Cuts the part, and then serves the machine to a browser if a person is there.
pub(crate) fn demo(given: &Demo) -> Result<ExitCode, Failure> {
    let folder = &given.folder;
    write_files(folder)?;
    hal_output::print(
        "A simulated printer with a spindle cuts a pedal, with two tools, in virtual time.\n\n",
    )?;
    let began = now();
    let words = ["--virtual", "--run", PART, "cut.ini"];
    run("halrun", Command::new(beside::find("halrun")?).args(words).current_dir(folder))?;
    let seconds = now() - began;
    let words = ["plot", "-i", "demo.ini", "-o", "pedal.png", PART];
    run("halgcode", Command::new(beside::find("halgcode")?).args(words).current_dir(folder))?;
    let recording = folder.join("pedal.vcd");
    let (trace, flaw) = hal_trace::load(&recording).map_err(|e| unread(&recording, &e))?;
    if let Some(flaw) = flaw {
        return Err(unread(&recording, &flaw));
    }
    let trace = trace.whole().map_err(|(_, flaw)| unread(&recording, &flaw))?;
    hal_output::print(&format!(
        "{}\nThat took {:.1} s of the machine's time, and {seconds:.1} s here.\n\n\
         {}  every step of the motors: halscope view shows it\n\
         {}  the path of the tools\n",
        cut::table(&trace)?,
        cut::duration(&trace),
        recording.display(),
        folder.join("pedal.png").display(),
    ))?;
    let is_person =
        rustix::termios::isatty(std::io::stdout()) && rustix::termios::isatty(std::io::stdin());
    if given.cut_only || !is_person {
        let machine = folder.join("demo.ini");
        hal_output::print(&format!(
            "\n'ferrule start --virtual {} --programs {}' serves this machine to a browser.\n",
            machine.display(),
            folder.join(PROGRAMS).display()
        ))?;
        return Ok(ExitCode::SUCCESS);
    }
    hal_output::print(
        "\nNow the same machine, at the speed of a clock: take control, hold Reset e-stop, hold On, home it, open pedal.ngc, hold Run.\n",
    )?;
    start(&virtual_of(folder.join("demo.ini"), folder.join(PROGRAMS), given.no_browser))
}

/// Returns the time of the system's steady clock, in seconds.
fn now() -> f64 {
    let now = clock_gettime(ClockId::Monotonic);
    now.tv_sec as f64 + now.tv_nsec as f64 * 1e-9
}

/// Writes the files of the machine. One that a person has changed stays as it is, and so does a folder of something else.
fn write_files(folder: &Path) -> Result<(), Failure> {
    let is_ours = folder.join("demo.ini").is_file();
    let all = FILES.iter().chain([&RECORD]);
    if let Some((name, _)) = all.clone().find(|(name, _)| !is_ours && folder.join(name).exists()) {
        return Err(Failure::Other { path: folder.join(name) });
    }
    let programs = folder.join(PROGRAMS);
    fs::create_dir_all(&programs).map_err(|e| Failure::file(&programs, &e))?;
    for (name, text) in all {
        let path = folder.join(name);
        if !path.exists() {
            hal_output::write(&path, text).map_err(|e| Failure::file(&path, &e))?;
        }
    }
    Ok(())
}

/// Runs a program to its end. What it says of its work stays its own; what goes wrong is shown.
fn run(name: &'static str, command: &mut Command) -> Result<(), Failure> {
    let done = command.stdin(Stdio::null()).output();
    let done =
        done.map_err(|e| Failure::NotStarted { name, why: hal_output::reason(&e).into() })?;
    if done.status.success() {
        return Ok(());
    }
    let said = String::from_utf8_lossy(&done.stderr).trim_end().to_owned();
    Err(Failure::Ended { name, status: format!("{}:\n{said}", done.status).into() })
}

fn unread(path: &Path, why: &dyn core::fmt::Display) -> Failure {
    Failure::File { path: path.into(), why: why.to_string().into() }
}
