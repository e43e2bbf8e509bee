//! Start of a machine from its INI file.

use super::{environment::variables, folders::Folders, refused::operator_entry, settings};
use crate::{
    Bytes, Error, Outcome, Session,
    ini::{Entry, Ini},
    io::{homing_module, operator_args},
    session::tcl::tclsh::TclFile,
};
use hal_protocol::{At, Code, CommandInfo, Kind, Reply, Request};
use std::path::Path;

/// Beginning of the comment that excludes a file from the two passes, without its spaces.
const EXCLUDES: &str = "#notwopass";

/// Executes the INI file's requests in order, and the files of `POSTGUI_HALFILE` if `postgui`.
pub(crate) fn start(session: &mut Session<'_>, ini: &Ini, path: &Path, postgui: bool) -> Outcome {
    let folders = Folders::of(path);
    session.variables = variables(ini, path, &folders.here);
    // Relative file names in scripts are relative to the INI file's folder.
    if session.is_dry_run() {
        session.set_folder(&folders.named);
    } else if let Err(error) = std::env::set_current_dir(&folders.here) {
        let (path, why) = (path.display().to_string().into(), crate::ini::plain(&error));
        return failed(session, &Error::Ini(hal_ini::Error::File { path, why }));
    }
    let mut machine = MachineStart { session, ini, folders, outcome: Outcome::Good };
    machine.load();
    machine.operator();
    machine.session.begin_machine();
    machine.halfiles();
    machine.configure();
    machine.load_task(path);
    for entry in ini.all("HAL", "HALCMD") {
        machine.then(|session| session.line_at(&entry.file, entry.line, &entry.value));
    }
    machine.ask("HAL", Request::Start);
    let shown = postgui.then(|| ini.all("HAL", "POSTGUI_HALFILE"));
    for entry in shown.into_iter().flatten() {
        machine.file(entry, false);
    }
    machine.outcome
}

/// Executes a Tcl file that is no part of a machine's INI file.
pub(crate) fn tcl_script(session: &mut Session<'_>, path: &Path) -> Outcome {
    let libraries = Folders::of(path).libraries;
    let shown = path.display().to_string();
    session.tcl_file(&TclFile { shown: &shown, path, args: &[], libraries: &libraries })
}

/// Executes the part of [`start`] that comes before the HAL files.
pub(crate) fn before_files(session: &mut Session<'_>, ini: &Ini, path: &Path) {
    let mut machine =
        MachineStart { session, ini, folders: Folders::of(path), outcome: Outcome::Good };
    machine.load();
    machine.operator();
    session.begin_machine();
}

/// Executes the part of [`start`] that comes after the HAL files.
pub(crate) fn after_files(session: &mut Session<'_>, ini: &Ini, path: &Path) {
    let mut machine =
        MachineStart { session, ini, folders: Folders::of(path), outcome: Outcome::Good };
    machine.configure();
    machine.load_task(path);
}

/// Executes the files of `SHUTDOWN`.
pub(super) fn shut_down(session: &mut Session<'_>, ini: &Ini, path: &Path) {
    let mut machine =
        MachineStart { session, ini, folders: Folders::of(path), outcome: Outcome::Good };
    for entry in ini.all("HAL", "SHUTDOWN").filter(|entry| !entry.value.is_empty()) {
        machine.file(entry, true);
    }
}

struct MachineStart<'a, 's> {
    session: &'a mut Session<'s>,
    ini: &'a Ini,
    folders: Folders,
    outcome: Outcome,
}

impl MachineStart<'_, '_> {
    /// Runs a step, unless an earlier one has ended the start.
    fn then(&mut self, step: impl FnOnce(&mut Session<'_>) -> Outcome) {
        let goes_on = match self.outcome {
            Outcome::Good => true,
            Outcome::Failed => self.session.style.keep_going,
            Outcome::Ended => false,
        };
        if goes_on {
            match step(self.session) {
                Outcome::Good => {}
                other => self.outcome = other,
            }
        }
    }

    /// Loads the components that every INI start has, and the homing module that the INI file names.
    fn load(&mut self) {
        let module = "iocontrol".to_owned();
        let args = vec!["interlock=1".to_owned()];
        self.ask("EMCIO", Request::Load { module, args });
        if let Some((entry, module, args)) = homing_module(self.ini) {
            self.then(|session| {
                session.stand_at(&entry.file, entry.line);
                let result = session.ask(Request::Load { module, args });
                session.outcome_of(result.map(|_| ()))
            });
        }
    }

    /// Has `halui` loaded as soon as `motmod` is, if the INI file names it.
    fn operator(&mut self) {
        let Some(entry) = operator_entry(self.ini) else { return };
        let args = operator_args(self.ini);
        self.session.operator = Some((At::new(&entry.file, entry.line), args));
    }

    /// Sends a request; errors refer to the section's first line.
    fn ask(&mut self, section: &str, request: Request) {
        let place = self.ini.section(section).next();
        self.then(|session| {
            if let Some(entry) = place {
                session.stand_at(&entry.file, entry.line);
            }
            let result = session.ask(request);
            session.outcome_of(result.map(|_| ()))
        });
    }

    /// Executes the HAL files, in two passes if the INI file asks for them.
    fn halfiles(&mut self) {
        let options = self.ini.get("HAL", "TWOPASS").unwrap_or_default().to_ascii_lowercase();
        if options.is_empty() {
            self.ini.all("HAL", "HALFILE").for_each(|entry| self.file(entry, true));
            return;
        }
        self.session.begin_passes();
        for is_second in [false, true] {
            for entry in self.ini.all("HAL", "HALFILE") {
                if !self.is_excluded(entry) {
                    self.file(entry, true);
                } else if !is_second {
                    // Its lines load by themselves.
                    let pass = self.session.pass.take();
                    self.file(entry, true);
                    self.session.pass = pass;
                }
            }
            if !is_second {
                let tells = options.contains("verbose");
                self.then(|session| session.begin_second_pass(tells));
            }
        }
        self.session.pass = None;
    }

    /// Returns whether a comment excludes a file from the two passes.
    fn is_excluded(&self, entry: &Entry) -> bool {
        let name = entry.value.split_whitespace().next().unwrap_or_default();
        let text = self.folders.find(name).and_then(|(_, path)| hal_ini::file::whole(&path).ok());
        let text = text.unwrap_or_default();
        String::from_utf8_lossy(&text).lines().any(|line| {
            let letters = line.chars().filter(|c| !c.is_whitespace()).take(EXCLUDES.len());
            letters.collect::<String>().eq_ignore_ascii_case(EXCLUDES)
        })
    }

    fn file(&mut self, entry: &Entry, must_exist: bool) {
        let mut words = entry.value.split_whitespace();
        let Some(name) = words.next() else {
            return self.then(|session| {
                session.stand_at(&entry.file, entry.line);
                session.warn_at(&format!("Warning: {} names no file", entry.name));
                Outcome::Good
            });
        };
        let args: Vec<String> = words.map(str::to_owned).collect();
        let found = self.folders.find(name);
        let searched = self.folders.searched(name);
        let libraries = self.folders.libraries.clone();
        self.then(|session| match found {
            Some((shown, path)) if path.extension().is_some_and(|e| e == "tcl") => session
                .tcl_file(&TclFile {
                    shown: &shown,
                    path: &path,
                    args: &args,
                    libraries: &libraries,
                }),
            Some((shown, path)) => match hal_ini::file::whole(&path) {
                Ok(text) => {
                    if !must_exist
                        && settings::are_missing(&text)
                        && let Err(failure) = settings::load(session.link)
                    {
                        session.stand_at(&entry.file, entry.line);
                        return failed(session, &Error::Engine(failure));
                    }
                    session.file(&shown, Bytes::new(text))
                }
                Err(e) => {
                    let (path, why) = (shown.into(), crate::ini::plain(&e));
                    failed(session, &Error::NoFile { path, why })
                }
            },
            None if must_exist => {
                let error = Error::IniNotFound { file: name.into(), folders: searched.into() };
                session.stand_at(&entry.file, entry.line);
                failed(session, &error)
            }
            None => {
                session.stand_at(&entry.file, entry.line);
                session.warn_as(Code::NoPostgui, &format!("POSTGUI_HALFILE '{name}' is missing"));
                Outcome::Good
            }
        });
    }

    /// Loads the task, if the machine has motion and its files have not loaded it.
    fn load_task(&mut self, path: &Path) {
        if !self.has_command("motion.configure") || self.has_command("task.run") {
            return;
        }
        // The folder of the process is that of the INI file.
        let file = path.file_name().map(Path::new).unwrap_or(path);
        let args = vec![format!("ini={}", file.display())];
        self.ask("TASK", Request::Load { module: "task".to_owned(), args });
    }

    fn has_command(&mut self, name: &str) -> bool {
        let patterns = vec![name.to_owned()];
        let list = Request::List { kind: Kind::Commands, patterns, ty: None };
        matches!(self.session.ask(list), Ok(Reply::Commands(list)) if !list.is_empty())
    }

    /// Configures motion with the machine's data, if motion is loaded.
    fn configure(&mut self) {
        let (ini, here) = (self.ini, self.folders.here.clone());
        self.then(|session| {
            let patterns = vec!["motion.configure".to_owned()];
            let list = Request::List { kind: Kind::Commands, patterns, ty: None };
            let command = match session.ask(list) {
                Ok(Reply::Commands(list)) => list.into_iter().next(),
                Ok(_) => None,
                Err(error) => return session.outcome_of(Err(error)),
            };
            let Some(command) = command else { return Outcome::Good };
            for (entry, args) in data(ini, &command, &here) {
                session.stand_at(&entry.file, entry.line);
                let name = command.name.clone();
                let result = session.ask(Request::Command { name, args });
                let outcome = session.outcome_of(result.map(|_| ()));
                if outcome != Outcome::Good {
                    return outcome;
                }
            }
            Outcome::Good
        });
    }
}

fn failed(session: &mut Session<'_>, error: &Error) -> Outcome {
    session.report(error);
    Outcome::Failed
}

/// INI entries of coordinated moves, and the corresponding arguments. The first entry that exists
/// counts.
const PATH: &[(&str, &str, &str)] = &[
    ("TRAJ", "MAX_LINEAR_VELOCITY", "max-velocity"),
    ("TRAJ", "MAX_VELOCITY", "max-velocity"),
    ("TRAJ", "MAX_LINEAR_ACCELERATION", "max-acceleration"),
    ("TRAJ", "MAX_ACCELERATION", "max-acceleration"),
    ("TRAJ", "MAX_LINEAR_JERK", "max-jerk"),
    ("TRAJ", "DEFAULT_LINEAR_VELOCITY", "default-velocity"),
    ("TRAJ", "DEFAULT_VELOCITY", "default-velocity"),
    ("TRAJ", "LINEAR_UNITS", "linear-units"),
    ("DISPLAY", "MAX_FEED_OVERRIDE", "max-feed-override"),
];

/// Returns the arguments of each `motion.configure`, with the first INI entry of each: one call for
/// coordinated moves, one for each joint, and one for each axis and spindle that has limits of its
/// own. Arguments that the command does not have are left out. Names of files are relative to `here`.
fn data<'a>(ini: &'a Ini, command: &CommandInfo, here: &Path) -> Vec<(&'a Entry, Vec<String>)> {
    let mut path = Args::new(command, None, here);
    for (section, name, arg) in PATH {
        if let Some(entry) = ini.all(section, name).next() {
            path.add(arg, entry);
        }
    }
    let of = |section: &str, first: String, only: &[&str]| {
        let mut args = Args::new(command, Some(first), here);
        for entry in ini.section(section) {
            let arg = entry.name.to_ascii_lowercase().replace('_', "-");
            // The section identifies the joint or axis. Of an axis, only its limits count.
            let is_object = ["joint", "axis", "spindle"].contains(&&*arg);
            if !is_object && (only.is_empty() || only.contains(&&*arg)) {
                args.add(&arg, entry);
            }
        }
        args.done()
    };
    let mut all = vec![path.done()];
    let joints = if ini.is_old() { "AXIS" } else { "JOINT" };
    for n in 0..joint_count(ini) {
        all.push(of(&format!("{joints}_{n}"), format!("joint={n}"), &[]));
    }
    for letter in "XYZABCUVW".chars() {
        let first = format!("axis={}", letter.to_ascii_lowercase());
        all.push(of(&format!("AXIS_{letter}"), first, AXIS));
    }
    for n in 0..number(ini, &[("TRAJ", "SPINDLES")]).unwrap_or(1).min(8) {
        all.push(of(&format!("SPINDLE_{n}"), format!("spindle={n}"), SPINDLE));
    }
    all.into_iter().flatten().collect()
}

/// Arguments that are read from a spindle's section.
const SPINDLE: &[&str] = &[
    "min-forward-velocity",
    "max-forward-velocity",
    "min-reverse-velocity",
    "max-reverse-velocity",
    "sync-error",
];

/// Arguments that are read from an axis's section.
const AXIS: &[&str] =
    &["min-limit", "max-limit", "max-velocity", "max-acceleration", "max-jerk", "offset-av-ratio"];

/// Returns the number of joint sections to read: the machine's number of joints, or 100 if it is
/// not given.
fn joint_count(ini: &Ini) -> u32 {
    let entries = [("KINS", "JOINTS"), ("TRAJ", "JOINTS"), ("TRAJ", "AXES")];
    number(ini, &entries).unwrap_or(100).min(100)
}

/// Returns the number in the first of these entries that has one.
fn number(ini: &Ini, entries: &[(&str, &str)]) -> Option<u32> {
    let mut given = entries.iter().filter_map(|(section, name)| ini.get(section, name));
    given.find_map(|value| value.split_whitespace().next()?.parse().ok())
}

/// Arguments of one command, collected from INI entries.
struct Args<'a, 'c> {
    command: &'c CommandInfo,
    /// Folder of the INI file.
    here: &'c Path,
    place: Option<&'a Entry>,
    words: Vec<String>,
}

impl<'a, 'c> Args<'a, 'c> {
    fn new(command: &'c CommandInfo, first: Option<String>, here: &'c Path) -> Self {
        Self { command, here, place: None, words: first.into_iter().collect() }
    }

    /// Adds the entry's value, if the command has this argument and it is not yet set.
    fn add(&mut self, arg: &str, entry: &'a Entry) {
        let given = self.words.iter().any(|w| w.split('=').next() == Some(arg));
        let known = self.command.args.iter().any(|a| a.name == arg);
        let value = entry.value.split_whitespace().next();
        if let Some(value) = value.filter(|_| known && !given) {
            let file = (arg == "comp-file").then(|| self.here.join(value));
            self.words.push(match file {
                Some(file) => format!("{arg}={}", file.display()),
                None => format!("{arg}={value}"),
            });
        }
        self.place.get_or_insert(entry);
    }

    /// Returns the arguments, or `None` without any entry.
    fn done(self) -> Option<(&'a Entry, Vec<String>)> {
        let place = self.place?;
        (!self.words.is_empty()).then_some((place, self.words))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use hal_protocol::ArgInfo;

    fn command() -> CommandInfo {
        let arg = |name: &str| ArgInfo {
            name: name.to_owned(),
            ty: "float".to_owned(),
            doc: String::new(),
            required: false,
            default: None,
            bounds: hal_protocol::Bounds::default(),
            unit: String::new(),
        };
        let names = "joint axis min-limit max-limit max-velocity ferror home-offset \
                     default-velocity linear-units comp-file spindle max-forward-velocity \
                     min-reverse-velocity fault-stop";
        let (name, doc) = ("motion.configure".to_owned(), String::new());
        CommandInfo { name, doc, args: names.split_whitespace().map(arg).collect() }
    }

    fn check(text: &str, want: &[&str]) {
        let ini = Ini::parse("m.ini", text.as_bytes()).unwrap();
        let got: Vec<String> = data(&ini, &command(), Path::new("/m"))
            .iter()
            .map(|(entry, args)| format!("{} {}", entry.line, args.join(" ")))
            .collect();
        assert_eq!(got, want, "{text}");
    }

    #[test]
    fn data_of_both_kinds_of_ini_files() {
        check(
            "[TRAJ]\nLINEAR_UNITS = mm\nDEFAULT_VELOCITY = 9.00\nMAX_LINEAR_VELOCITY = 90.00\n\
             [AXIS_0]\nTYPE = LINEAR\nMIN_LIMIT = -50.0\nMAX_LIMIT = 200.0 # mm\nSCALE = 4\n\
             [AXIS_1]\nHOME_OFFSET = 0.0\n",
            &[
                "4 max-velocity=90.00 default-velocity=9.00 linear-units=mm",
                "6 joint=0 min-limit=-50.0 max-limit=200.0",
                "11 joint=1 home-offset=0.0",
            ],
        );
        check(
            "[AXIS_X]\nMAX_VELOCITY = 5\nMAX_LIMIT=7\n[JOINT_0]\nFERROR = 1\nFERROR = 2\nFAULT_STOP = ramp\n",
            &["5 joint=0 ferror=1 fault-stop=ramp", "2 axis=x max-velocity=5 max-limit=7"],
        );
        check(
            "[SPINDLE_0]\nMAX_FORWARD_VELOCITY = 2400\nINCREMENT = 50\n[SPINDLE_1]\n\
             MIN_REVERSE_VELOCITY = 10\n[JOINT_0]\nCOMP_FILE = x.comp\n[JOINT_1]\nCOMP_FILE = /y\n[TRAJ]\nSPINDLES = 2\n\
             [SPINDLE_2]\nMAX_FORWARD_VELOCITY = 7\n",
            &[
                "7 joint=0 comp-file=/m/x.comp",
                "9 joint=1 comp-file=/y",
                "2 spindle=0 max-forward-velocity=2400",
                "5 spindle=1 min-reverse-velocity=10",
            ],
        );
        check("[TRAJ]\nMAX_LINEAR_VELOCITY=1\nMAX_VELOCITY=2\n", &["2 max-velocity=1"]);
        check("", &[]);
    }
}
