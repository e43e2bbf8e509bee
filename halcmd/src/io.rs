//! Lines that start a program of LinuxCNC whose work a component does: `io`, `halui`, `milltask`, `linuxcncsvr`, and those
//! of [`Native`]; lines that load `iocontrol` again after a start from an INI file; and the line that loads `motmod`, which such a
//! start tells of its homing module, and after which it loads `halui`.

use crate::{
    Command, Error, Session,
    ini::{Entry, Ini},
    language::command::Launch,
    session::natives::Native,
};
use hal_protocol::{At, Code, Finding, Request};

/// Component of tools and the emergency stop, a program in LinuxCNC.
const IO: &str = "iocontrol";
/// The component with the operator's pins, a program in LinuxCNC.
const OPERATOR: &str = "halui";

/// Replacement of a program of LinuxCNC.
#[derive(Clone, Copy)]
enum Instead {
    /// A component that is loaded in its place.
    Component(&'static str),
    /// Nothing is loaded, for this reason.
    Nothing(&'static str),
}

/// Programs and modules whose work is built in; those of [`Native`] have arguments of their own.
const BUILT_IN: [(&str, Instead); 6] = [
    ("iocontrol", Instead::Component(IO)),
    ("io", Instead::Component(IO)),
    ("iov2", Instead::Component(IO)),
    ("halui", Instead::Component(OPERATOR)),
    (
        "milltask",
        Instead::Nothing(
            "the task is built in, and a start from an INI file with a section TASK loads it",
        ),
    ),
    ("linuxcncsvr", Instead::Nothing("programs reach the instance without a server")),
];

/// Returns what does the work of a program or module.
fn instead_of(name: &str) -> Option<(&'static str, Instead)> {
    BUILT_IN.into_iter().find(|row| row.0 == name)
}

/// Returns the name of what does the work of a program in Ferrule: a component, or the program itself if nothing is loaded for it.
pub(crate) fn built_in(launch: &Launch) -> Option<&'static str> {
    if let Some(native) = Native::of(launch) {
        return Some(native.component());
    }
    Some(match instead_of(launch.name())? {
        (_, Instead::Component(component)) => component,
        (program, Instead::Nothing(_)) => program,
    })
}

/// Returns the command that loads a component.
fn load(module: &str, args: Vec<String>) -> Command {
    let note = Some(format!("Realtime module '{module}' loaded"));
    Command::Send(Request::Load { module: module.to_owned(), args }, note)
}

impl Session<'_> {
    /// Marks the following lines as those of a machine started from an INI file, which has
    /// `iocontrol` loaded.
    pub(crate) const fn begin_machine(&mut self) {
        self.is_machine = true;
    }

    /// Turns the start of a program of LinuxCNC into `loadrt` of the component that replaces it. Returns `None` if there is
    /// nothing to do: the machine has loaded it already, or loads it later, and it keeps its arguments and its interlock.
    pub(crate) fn with_built_in(&mut self, command: Command) -> Result<Option<Command>, Error> {
        let (module, args) = match &command {
            Command::Launch(launch) => {
                if let Some(native) = Native::of(launch).filter(|n| !self.has_stand_in(n)) {
                    return Ok(Some(load(native.component(), native.arguments(launch)?)));
                }
                match instead_of(launch.name()) {
                    Some((_, Instead::Component(OPERATOR))) => return self.with_operator(),
                    Some((_, Instead::Component(component))) => (component, Vec::new()),
                    Some((program, Instead::Nothing(why))) => {
                        self.say_that_nothing_is_started(program, why);
                        return Ok(None);
                    }
                    None => return Ok(Some(command)),
                }
            }
            Command::Send(Request::Load { module, args }, _) => match instead_of(module) {
                // The module has these names, too.
                Some((name, Instead::Component(IO))) => (name, args.clone()),
                _ => return Ok(Some(self.with_cards(self.with_homing(command)))),
            },
            _ => return Ok(Some(command)),
        };
        if self.is_machine && self.component_of(IO)?.is_some() {
            self.say_that_it_is_there(module, &args);
            return Ok(None);
        }
        Ok(Some(load(module, args)))
    }

    /// Returns whether a person wants a stand-in in the place of a program.
    fn has_stand_in(&self, native: &Native) -> bool {
        let name = native.program();
        self.asked.names().any(|asked| asked == name) || self.stand_ins.replaces(name)
    }

    /// Turns `loadusr halui` into `loadrt halui` with the arguments that the INI file has for it. Before `motmod` it waits
    /// for that, as with `[HAL]HALUI`.
    fn with_operator(&mut self) -> Result<Option<Command>, Error> {
        if self.operator.is_some() || self.component_of(OPERATOR)?.is_some() {
            self.say_that_it_is_there(OPERATOR, &[]);
            return Ok(None);
        }
        let args = self.ini.map(operator_args).unwrap_or_default();
        if self.is_machine && self.component_of("motmod")?.is_none() {
            self.operator = Some((self.current_line(), args));
            self.note("halui is loaded behind motmod");
            return Ok(None);
        }
        Ok(Some(load(OPERATOR, args)))
    }

    /// Tells `motmod` of a machine which homing module it must find.
    fn with_homing(&self, command: Command) -> Command {
        let named = self.ini.filter(|_| self.is_machine).and_then(homing_module);
        match (command, named) {
            (Command::Send(Request::Load { module, mut args }, note), Some((_, homing, _)))
                if module == "motmod" =>
            {
                let arg = format!("homemod={homing}");
                if !args.contains(&arg) {
                    args.push(arg);
                }
                Command::Send(Request::Load { module, args }, note)
            }
            (command, _) => command,
        }
    }

    /// Returns whether a command loads `motmod`, for which `halui` waits.
    pub(crate) fn awaits_operator(&self, command: &Command) -> bool {
        let Command::Send(Request::Load { module, .. }, _) = command else { return false };
        self.operator.is_some() && module == "motmod"
    }

    /// Loads `halui`, on the line of the INI file that names it.
    pub(crate) fn load_operator(&mut self) -> Result<(), Error> {
        let Some((at, args)) = self.operator.take() else { return Ok(()) };
        let back = self.current_line();
        self.stand_at(&at.file, at.line);
        let loaded = self.ask(Request::Load { module: OPERATOR.to_owned(), args });
        if loaded.is_ok() {
            self.stand_at(&back.file, back.line);
        }
        loaded.map(|_| ())
    }

    fn say_that_it_is_there(&mut self, module: &str, args: &[String]) {
        let arguments = if args.is_empty() {
            String::new()
        } else {
            format!("; without effect: {}", args.join(" "))
        };
        let text = match module {
            OPERATOR => format!("{module} is loaded once, behind motmod{arguments}"),
            _ => format!("{module} is loaded already, by the start from the INI file{arguments}"),
        };
        let at = self.current_line();
        if let Some(dry_run) = &mut self.dry_run {
            let finding = Finding::new(Code::LoadedAlready, module, text).at(Some(at));
            let remedy = "take the line out, or leave it for other programs that need it";
            dry_run.found.push(finding.remedy(remedy));
        } else if args.is_empty() {
            self.note(&text);
        } else {
            self.warn_at(&format!("Warning: {text}"));
        }
    }

    fn say_that_nothing_is_started(&mut self, program: &str, why: &str) {
        let text = format!("{program} is not started: {why}");
        let at = self.current_line();
        match &mut self.dry_run {
            Some(dry_run) => dry_run.found.push(
                Finding::new(Code::LoadedAlready, program, text)
                    .at(Some(at))
                    .remedy("take the line out, or leave it for LinuxCNC"),
            ),
            None => self.warn_at(&format!("Info: {text}")),
        }
    }

    /// Returns the place of the line that is being executed.
    pub(crate) fn current_line(&self) -> At {
        let (file, line) = self.place();
        At::new(file, line)
    }
}

/// Returns the homing module that an INI file names, with its arguments; `None` for that of `motmod` itself.
pub(crate) fn homing_module(ini: &Ini) -> Option<(&Entry, String, Vec<String>)> {
    let entry = ini.all("EMCMOT", "HOMEMOD").next()?;
    let mut words = entry.value.split_whitespace().map(str::to_owned);
    let module = words.next().filter(|module| module != "homemod")?;
    Some((entry, module, words.collect()))
}

/// Returns the arguments of `halui` that an INI file states.
pub(crate) fn operator_args(ini: &Ini) -> Vec<String> {
    let mut args = Vec::new();
    if let Some(axes) = ini.all("TRAJ", "COORDINATES").next() {
        args.push(format!("coordinates={}", axes.value.replace(char::is_whitespace, "")));
    }
    let lines: Vec<&str> = ini.all("HALUI", "MDI_COMMAND").map(|e| e.value.as_str()).collect();
    if !lines.is_empty() {
        args.push(format!("mdi_commands={}", lines.join("|")));
    }
    args
}
