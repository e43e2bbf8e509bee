//! Start of a machine from its INI file.

use super::{
    data::{data, without_search},
    environment::variables,
    folders::Folders,
    refused::operator_entry,
    settings,
};
use crate::{
    Bytes, Error, Outcome, Session,
    ini::{Entry, Ini},
    io::{homing_module, operator_args},
    session::tcl::tclsh::TclFile,
};
use hal_protocol::{At, Code, Kind, Reply, Request};
use std::{collections::BTreeSet, path::Path};

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
    let homed = machine.settle(false);
    machine.configure(&homed);
    machine.load_task(path);
    for entry in ini.all("HAL", "HALCMD") {
        machine.then(|session| session.line_at(&entry.file, entry.line, &entry.value));
    }
    machine.ask("HAL", Request::Start);
    let shown = postgui.then(|| ini.all("HAL", "POSTGUI_HALFILE"));
    for entry in shown.into_iter().flatten() {
        machine.postgui(entry);
    }
    machine.settle(true);
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
    machine.configure(&BTreeSet::new());
    machine.load_task(path);
}

/// Says that the files of `SHUTDOWN` are not executed: no display of this start ends.
pub(super) fn warn_of_shutdown(session: &mut Session<'_>, ini: &Ini) {
    if let Some(entry) = ini.all("HAL", "SHUTDOWN").find(|entry| !entry.value.is_empty()) {
        session.stand_at(&entry.file, entry.line);
        session.warn_at(
            "[HAL]SHUTDOWN is executed when the display ends, and this start has none: outputs end with their \
             drivers' safe levels",
        );
    }
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

    /// Executes a file of `POSTGUI_HALFILE`.
    fn postgui(&mut self, entry: &Entry) {
        self.session.is_postgui = true;
        self.file(entry, false);
        self.session.is_postgui = false;
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

    /// Gives the stand-ins their values. Returns the joints that are homed where they stand.
    fn settle(&mut self, last: bool) -> BTreeSet<u32> {
        let mut homed = BTreeSet::new();
        let place = self.ini.section("HAL").next();
        self.then(|session| {
            if let Some(entry) = place {
                session.stand_at(&entry.file, entry.line);
            }
            match session.settle_stand_ins(last) {
                Ok(joints) => {
                    homed = joints;
                    Outcome::Good
                }
                Err(error) => session.outcome_of(Err(error)),
            }
        });
        homed
    }

    /// Configures motion with the machine's data, if motion is loaded. Joints that are homed where they stand search no switch.
    fn configure(&mut self, homed: &BTreeSet<u32>) {
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
            for (entry, mut args) in data(ini, &command, &here) {
                if let Some(joint) = without_search(&mut args, homed) {
                    session.stand_at(&entry.file, entry.line);
                    session.warn_at(&format!(
                        "joint {joint} is homed where it stands: nobody writes joint.{joint}.home-sw-in"
                    ));
                }
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
