//! Lines that load `iocontrol`, either as the program `io` of LinuxCNC, or again after a start from
//! an INI file; and the line that loads `motmod`, after which such a start loads `halui`.

use crate::{Command, Error, Session};
use hal_protocol::{At, Code, Finding, Request};

/// The name of the component, and its other names.
const NAMES: [&str; 3] = ["iocontrol", "io", "iov2"];

impl Session<'_> {
    /// Marks the following lines as those of a machine started from an INI file, which has
    /// `iocontrol` loaded.
    pub(crate) const fn begin_machine(&mut self) {
        self.is_machine = true;
    }

    /// Turns `loadusr io` into `loadrt iocontrol`, the component that replaces the program. Returns
    /// `None` if the machine has loaded it already; it keeps its arguments and its interlock.
    pub(crate) fn with_own_io(&mut self, command: Command) -> Result<Option<Command>, Error> {
        let (module, args) = match &command {
            Command::Launch(launch) => {
                let base = launch.program.rsplit('/').next().unwrap_or_default();
                match NAMES.iter().find(|name| **name == base) {
                    Some(_) => (NAMES[0], Vec::new()),
                    None => return Ok(Some(command)),
                }
            }
            Command::Ask(Request::Load { module, args }, _) => {
                match NAMES.iter().find(|name| **name == module.as_str()) {
                    Some(name) => (*name, args.clone()),
                    None => return Ok(Some(command)),
                }
            }
            _ => return Ok(Some(command)),
        };
        if self.is_machine && self.component_of(NAMES[0])?.is_some() {
            self.say_that_it_is_there(module, &args);
            return Ok(None);
        }
        let note = Some(format!("Realtime module '{module}' loaded"));
        Ok(Some(Command::Ask(Request::Load { module: module.to_owned(), args }, note)))
    }

    /// Returns whether a command loads `motmod`, for which `halui` waits.
    pub(crate) fn awaits_operator(&self, command: &Command) -> bool {
        let Command::Ask(Request::Load { module, .. }, _) = command else { return false };
        self.operator.is_some() && module == "motmod"
    }

    /// Loads `halui`, on the line of the INI file that names it.
    pub(crate) fn load_operator(&mut self) -> Result<(), Error> {
        let Some((at, args)) = self.operator.take() else { return Ok(()) };
        let back = self.standing();
        self.stand_at(&at.file, at.line);
        let loaded = self.ask(Request::Load { module: "halui".to_owned(), args });
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
        let text = format!("{module} is loaded already, by the start from the INI file{arguments}");
        let at = self.standing();
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

    /// Returns the place of the line that is being executed.
    pub(crate) fn standing(&self) -> At {
        let (file, line) = self.place();
        At::new(file, line)
    }
}
