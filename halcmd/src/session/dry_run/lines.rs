//! Execution of commands in a dry run: the same as otherwise, except for effects outside.

use super::{
    DryRunResult,
    unknown::{MOTION, Maker, Unknown},
};
use crate::{
    Command, Error, Session,
    ini::Ini,
    language::command::{Apply, Launch},
    language::hint::nearest,
    programs::hal_manualtoolchange,
    session::program,
    standin,
};
use hal_protocol::{At, Code, Failure, Finding, Kind, Reply, Request};

/// INI entries that start user interfaces, and further names of their components.
const INTERFACES: [(&str, &str, &[&str]); 5] = [
    ("DISPLAY", "DISPLAY", &["axisui", "gladevcp", "pyvcp", "qtvcp"]),
    ("DISPLAY", "PYVCP", &["pyvcp"]),
    ("DISPLAY", "GLADEVCP", &["gladevcp"]),
    ("DISPLAY", "EMBED_TAB_COMMAND", &[]),
    ("HAL", "HALUI", &["halui"]),
];

/// Entries that name the component of a program, in the files of mb2hal and vfdmod.
const NAMED_BY: [&str; 2] = ["HAL_MODULE_NAME", "ComponentName"];

/// Component of LinuxCNC's programs that show a machine.
const VIEW: &str = "vismach";
/// Failure code for a name that does not exist.
const ENOENT: i32 = -2;

impl Session<'_> {
    /// Begins a dry run: commands affect nothing outside, and refused lines are recorded instead of
    /// reported.
    pub(crate) fn begin_dry_run(&mut self) {
        self.dry_run = Some(DryRunResult::default());
    }

    /// Ends the dry run and returns its result.
    pub(crate) fn end_dry_run(mut self) -> DryRunResult {
        self.dry_run.take().unwrap_or_default()
    }

    /// Returns whether the session is in a dry run.
    pub(crate) const fn is_dry_run(&self) -> bool {
        self.dry_run.is_some()
    }

    fn unknown_names(&mut self) -> &mut Unknown {
        &mut self.dry_run.get_or_insert_default().unknown
    }

    pub(crate) fn dry_run_command(&mut self, command: Command) -> Result<(), Error> {
        match command {
            // A Tcl script goes on with what they return.
            other @ (Command::Value(_)
            | Command::TypeOf(_)
            | Command::Show(..)
            | Command::Save(_, None)
            | Command::List(..))
                if self.returned.is_some() =>
            {
                self.execute(other)
            }
            Command::Send(request, _) | Command::Value(request) | Command::TypeOf(request) => {
                self.try_request(request)
            }
            Command::Launch(launch) => self.expect_program(&launch),
            Command::Component { name, args, .. } => self.try_component(&name, &args),
            Command::Apply(Apply { file, .. }) => file.map_or(Ok(()), |file| self.source(&file)),
            other @ (Command::Unload(_)
            | Command::UnloadAll
            | Command::Source(_)
            | Command::Lock(_)) => self.execute(other),
            // All others show, write or wait: a dry run leaves them out.
            _ => Ok(()),
        }
    }

    fn try_request(&mut self, request: Request) -> Result<(), Error> {
        match request {
            Request::Net { signal, pins } => self.try_net(signal, pins),
            Request::Link { pin, signal } => {
                if self.is_unknown_pin(&pin) {
                    self.unknown_names().signals.insert(signal);
                    return Ok(());
                }
                let name = signal.clone();
                let done = self.ask(Request::Link { pin, signal });
                self.unless_unknown_signal(&name, done)
            }
            Request::SetSignal { ref name, .. } | Request::GetSignal { ref name } => {
                let name = name.clone();
                let done = self.ask(request);
                self.unless_unknown_signal(&name, done)
            }
            Request::Load { ref module, ref args }
            | Request::LoadForeign { ref module, ref args, .. } => {
                let (module, args) = (module.clone(), args.clone());
                self.dry_run.get_or_insert_default().loaded.insert(module.clone());
                if self.asked.replaces(&module, false) {
                    self.expect_module(&module, &args);
                    return Ok(());
                }
                let Err(error) = self.ask(request) else { return Ok(()) };
                self.expect_module(&module, &args);
                let is_absent = matches!(&error, Error::Engine(failure) if failure.finding == Some(Code::NoComponent));
                // A name that is nearly another one's is misspelt.
                let is_near = matches!(&error, Error::Engine(failure) if failure.hint.is_some());
                if is_absent && (!is_near || standin::is_known(&module)) {
                    self.dry_run.get_or_insert_default().absent.insert(module.clone());
                }
                if is_absent && self.asked.replaces(&module, true) { Ok(()) } else { Err(error) }
            }
            other => {
                let names = names_of(&other);
                match self.ask(other) {
                    Err(Error::Engine(failure))
                        if failure.code == ENOENT
                            && names.iter().any(|name| self.is_covered(name)) =>
                    {
                        Ok(())
                    }
                    result => result.map(|_| ()),
                }
            }
        }
    }

    /// Links the known pins. A signal with unknown pins is recorded.
    fn try_net(&mut self, signal: String, pins: Vec<String>) -> Result<(), Error> {
        let (unknown, known): (Vec<_>, Vec<_>) =
            pins.into_iter().partition(|pin| self.is_unknown_pin(pin));
        if !unknown.is_empty() {
            self.unknown_names().signals.insert(signal.clone());
        }
        if known.is_empty() && !unknown.is_empty() {
            return Ok(());
        }
        self.ask(Request::Net { signal, pins: known }).map(|_| ())
    }

    /// Returns whether a pin may exist on the machine but does not exist in a dry run.
    fn is_unknown_pin(&mut self, name: &str) -> bool {
        let asked = self.ask(Request::Get { name: name.to_owned() });
        let missing = matches!(asked, Err(Error::Engine(failure)) if failure.code == ENOENT);
        missing && self.is_covered(name)
    }

    /// Notes that a Tcl file does something that a dry run does not: everything may exist from here on.
    pub(in crate::session) fn stop_following(&mut self, at: &At, why: &str) {
        let Some(dry_run) = &mut self.dry_run else { return };
        let text = format!("the rest of this Tcl file is not known here: {why}");
        let finding = Finding::new(Code::TclNotFollowed, &at.file, text).at(Some(at.clone()));
        let remedy = "check the running machine to have it looked at: halcmd check";
        // The first of a file stands for what follows it.
        if dry_run.unknown.begin_anything(&at.file) {
            dry_run.found.push(finding.remedy(remedy));
        }
    }

    /// Lets everything exist from here on, because the rest of a Tcl file with an error was not executed.
    pub(in crate::session) fn doubt_what_follows(&mut self, file: &str) {
        if let Some(dry_run) = &mut self.dry_run {
            dry_run.unknown.begin_anything(file);
        }
    }

    /// Returns whether the line that runs may use a name that does not exist in a dry run.
    pub(in crate::session) fn is_covered(&mut self, name: &str) -> bool {
        let at = self.current_line();
        self.unknown_names().covers(name, &at)
    }

    /// Ignores the error for a missing signal if only unknown pins use that signal.
    fn unless_unknown_signal(
        &mut self,
        name: &str,
        done: Result<Reply, Error>,
    ) -> Result<(), Error> {
        match done {
            Err(Error::Engine(Failure { code: ENOENT, .. }))
                if self.unknown_names().signals.contains(name) =>
            {
                Ok(())
            }
            result => result.map(|_| ()),
        }
    }

    /// Handles `loadusr`. The pins of our own programs are known; those of other programs are not.
    fn expect_program(&mut self, launch: &Launch) -> Result<(), Error> {
        let at = self.current_line();
        let base = launch.name().to_owned();
        if base == hal_manualtoolchange::NAME {
            return Ok(hal_manualtoolchange::join(self.link)?);
        }
        let of_screen = self.is_postgui && launch.is_of_screen();
        let result = self.dry_run.get_or_insert_default();
        result.loaded.insert(base.clone());
        if of_screen {
            result.of_screen.insert(base.clone());
        }
        if launch.names_device() {
            result.hardware.insert(base.clone());
        }
        let is_there = program::exists(&launch.program, |path| self.found_at(path));
        if !is_there {
            self.dry_run.get_or_insert_default().absent.insert(base.clone());
        }
        if !is_there && !self.asked.replaces(&base, true) {
            let awaited = launch.until_ready || launch.until_end && !launch.ignore_status;
            let code = if awaited { Code::NoProgramAwaited } else { Code::NoProgram };
            let text = format!("program '{}' is not there", launch.program);
            let remedy = "install it, or give its path; programs beside halcmd are found first, \
                          then those in PATH";
            let finding = Finding::new(code, &launch.program, text);
            let found = finding.at(Some(at.clone())).remedy(remedy);
            self.dry_run.get_or_insert_default().found.push(found);
        }
        let unknown = self.unknown_names();
        let program = &Maker::Program(base.clone());
        unknown.expect(&launch.expected(), &at, program);
        let stem = base.split('.').next().unwrap_or_default();
        for name in [stem, stem.strip_prefix("hal_").unwrap_or(stem)] {
            unknown.expect(name, &at, program);
        }
        for name in standin::pins_of(&base) {
            unknown.expect(name, &at, program);
        }
        // LinuxCNC's views of machines, such as puma560gui, have a second component for the view itself.
        if standin::is_view(&base) {
            unknown.expect(VIEW, &at, program);
        }
        // A program often gets the name for its component as an argument.
        for word in &launch.args {
            unknown.expect(word.rsplit('=').next().unwrap_or_default(), &at, program);
        }
        // Drivers of Modbus devices get it in a file of their own.
        let named: Vec<String> = launch.args.iter().flat_map(|word| self.named_in(word)).collect();
        for name in named {
            self.unknown_names().expect(&name, &at, program);
        }
        Ok(())
    }

    /// Returns the names of components that a program's own file of settings gives, if an argument names that file.
    fn named_in(&self, word: &str) -> Vec<String> {
        let path = self.found_at(word.rsplit('=').next().unwrap_or_default());
        let is_file = path.extension().is_some_and(|e| e == "ini") && path.is_file();
        let text = is_file.then(|| hal_ini::file::whole(&path).ok()).flatten().unwrap_or_default();
        let text = String::from_utf8_lossy(&text).into_owned();
        let entries = text.lines().filter_map(|line| line.split_once('='));
        let names = entries.filter(|(name, _)| NAMED_BY.contains(&name.trim()));
        names.map(|(_, value)| value.trim().to_owned()).collect()
    }

    /// Expects the pins of the user interfaces that an INI file starts.
    pub(super) fn expect_interface(&mut self, ini: &Ini) {
        for (section, name, more) in INTERFACES {
            for entry in ini.all(section, name) {
                let at = At::new(&entry.file, entry.line);
                let program = entry.value.split_whitespace().next().unwrap_or_default();
                let name = program.to_owned();
                let is_screen = section == "DISPLAY";
                let maker = if is_screen { Maker::Screen(name) } else { Maker::Program(name) };
                let unknown = self.unknown_names();
                // Axes have pins with that name, and errors in their names should be found.
                let words = entry.value.split_whitespace().filter(|word| *word != "axis");
                // Screens of that kind start the tool change dialog themselves.
                let own = program.starts_with("qtvcp").then_some(hal_manualtoolchange::NAME);
                for word in words.chain(more.iter().copied()).chain(own) {
                    unknown.expect(word, &at, &maker);
                    // The screen qtdragon_hd has the component of the screen qtdragon.
                    if own.is_some() {
                        unknown.expect(word.split('_').next().unwrap_or_default(), &at, &maker);
                    }
                }
            }
        }
    }

    /// Expects the names of a component that could not be loaded, so that they cause no further
    /// errors.
    fn expect_module(&mut self, module: &str, args: &[String]) {
        let at = self.current_line();
        let unknown = self.unknown_names();
        let maker = Maker::Module(module.to_owned());
        let name = module.replace('_', "-");
        for word in [&name, module, name.strip_prefix("hal-").unwrap_or(&name)] {
            unknown.expect(word, &at, &maker);
        }
        for word in standin::pins_of(module) {
            unknown.expect(word, &at, &maker);
        }
        if module == "motmod" {
            MOTION.iter().for_each(|word| unknown.expect(word, &at, &maker));
        }
        for names in args.iter().filter_map(|a| a.strip_prefix("names=")) {
            names.split(',').for_each(|n| unknown.expect(n, &at, &maker));
        }
    }

    /// Checks a component's command without executing it.
    fn try_component(&mut self, name: &str, args: &[String]) -> Result<(), Error> {
        let all = Request::List { kind: Kind::Commands, patterns: Vec::new(), ty: None };
        let Reply::Commands(list) = self.ask(all)? else { return Err(Error::Unexpected) };
        let Some(command) = list.iter().find(|c| c.name == name) else {
            if self.is_covered(name) {
                return Ok(());
            }
            let near = nearest(name, list.iter().map(|c| c.name.as_str()));
            return Err(Error::UnknownCommand { word: name.into(), near });
        };
        for word in args {
            let arg = word.split('=').next().unwrap_or_default();
            if command.args.iter().all(|a| a.name != arg) {
                let near = nearest(arg, command.args.iter().map(|a| a.name.as_str()));
                let mut failure = Failure::new(-22, format!("Unknown parameter `{word}'"));
                failure.finding = Some(Code::BadCall);
                failure.hint = near.map(|n| format!("did you mean {n}?"));
                return Err(failure.into());
            }
        }
        Ok(())
    }
}

/// Returns the names that a request uses.
fn names_of(request: &Request) -> Vec<String> {
    match request {
        Request::AddFunct { funct, thread, .. } => vec![funct.clone(), thread.clone()],
        Request::Unlink { pin: name }
        | Request::Set { name, .. }
        | Request::Get { name }
        | Request::Snapshot { name }
        | Request::RemoveFunct { funct: name, .. }
        | Request::Alias { name, .. }
        | Request::Unalias { name, .. }
        | Request::Unload { name }
        | Request::Command { name, .. } => vec![name.clone()],
        _ => Vec::new(),
    }
}
