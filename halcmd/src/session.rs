//! The interpreter: executes lines over a link, one after the other.

pub(crate) mod already;
pub(crate) mod apply;
mod beside;
mod cards;
pub mod dry_run;
pub(crate) mod execute;
mod late;
pub(crate) mod messages;
pub(crate) mod natives;
mod open_command;
pub(crate) mod program;
pub(crate) mod prompt;
pub mod remote;
pub(crate) mod running;
mod sourced;
mod stand_ins;
mod start;
pub(crate) mod tcl;
pub(crate) mod trailer;
pub(crate) mod twopass;

use crate::{
    Error, Fault, Lines, Terminal,
    ini::Ini,
    language::joined::Pass,
    language::lex::{Line, Reader, without_comment},
    language::syntax::Statement,
    language::vars::{Values, mentioned},
    session::apply::Plan,
    session::dry_run::DryRunResult,
    session::trailer::Trailer,
    standin::{Asked, StandIns},
};
use hal_output::Unwritten;
use hal_protocol::{At, Code, Link, Reply, Request};
use std::{
    ffi::OsString,
    path::{Path, PathBuf},
    process::Child,
};

/// Code of a [`Failure`](hal_protocol::Failure) that only says that the instance is ending. The
/// script ends with it, without a message.
pub(crate) const INTERRUPTED: i32 = -4;
/// Name of the terminal as a file. For it, the number of failed lines is not reported.
const STDIN: &str = "<stdin>";
/// Options of a session for output and error handling.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[expect(clippy::struct_excessive_bools, reason = "each is an option of the command line")]
pub struct Style {
    /// `-k`: continues after a line that fails.
    pub keep_going: bool,
    /// `-s`: prints listings for programs.
    pub script: bool,
    /// `--json`: prints replies as they are.
    pub json: bool,
    /// `-v`: prints the effect of each command.
    pub verbose: bool,
    /// `-Q`: omits listings and the messages that precede an error.
    pub silent: bool,
    /// `-e`: prints each line before executing it.
    pub echo: bool,
    /// `--wait`: waits for each command of a component.
    pub wait: bool,
    /// True if the session reads standard input; programs that it starts do not get it.
    pub reads_input: bool,
    /// True if the session runs in the background; programs that outlive it do not keep the
    /// terminal.
    pub background: bool,
}

/// Result of a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Outcome {
    /// Every line succeeded.
    Good,
    /// A line failed.
    Failed,
    /// The instance is ending.
    Ended,
}

/// An interpreter of the HAL language.
pub struct Session<'a> {
    pub(crate) link: &'a mut dyn Link,
    pub(crate) terminal: &'a mut dyn Terminal,
    pub(crate) style: Style,
    pub(crate) instance: String,
    pub(crate) programs: Vec<Child>,
    /// Variables of the environment of programs that the session starts, beside its own.
    pub(crate) variables: Vec<(&'static str, OsString)>,
    environment: &'a dyn Fn(&str) -> Option<String>,
    pub(crate) ini: Option<&'a Ini>,
    place: (String, u32),
    depth: u32,
    /// Number of files that the present top-level file has sourced.
    sourced: u32,
    ended: bool,
    before_start: Vec<Request>,
    /// Folder for relative file names, if it is not this process's folder.
    pub(crate) folder: Option<PathBuf>,
    /// INI file of the file that is being applied; `plan` has its lines so far.
    pub(crate) own_ini: Option<Ini>,
    pub(crate) plan: Option<Plan>,
    /// Set when nothing outside may be affected.
    pub(crate) dry_run: Option<DryRunResult>,
    /// Set when the lines are those of a machine started from an INI file.
    pub(crate) is_machine: bool,
    /// Place and arguments of `halui`, which is loaded as soon as `motmod` is.
    pub(crate) operator: Option<(At, Vec<String>)>,
    /// Output of the command of a Tcl script, which gets it as the result.
    pub(crate) returned: Option<String>,
    /// Pass of a start with `[HAL]TWOPASS`.
    pub(crate) pass: Option<Pass>,
    /// `loadusr -w sleep N` sleeps on the machine's clock, which is virtual.
    pub(crate) sleeps_on_the_clock: bool,
    /// The lines are those of a file of `POSTGUI_HALFILE`.
    pub(crate) is_postgui: bool,
    /// A dry run before a start: what can be read only once is left to the start.
    pub(crate) is_first_look: bool,
    /// Request for stand-ins in a dry run.
    pub(crate) asked: Asked,
    /// Stand-ins of the machine.
    pub(crate) stand_ins: StandIns,
    /// Commands in progress whose refusals are reported when they come.
    open_commands: Vec<open_command::OpenCommand>,
}

impl core::fmt::Debug for Session<'_> {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.debug_struct("Session").field("place", &self.place).finish_non_exhaustive()
    }
}

enum Step {
    On,
    Quit,
}

impl<'a> Session<'a> {
    /// Makes an interpreter over `link`. `instance` is the name of the instance.
    pub fn new(
        link: &'a mut dyn Link,
        terminal: &'a mut dyn Terminal,
        style: Style,
        instance: &str,
    ) -> Self {
        Self {
            link,
            terminal,
            style,
            instance: instance.to_owned(),
            programs: Vec::new(),
            variables: Vec::new(),
            environment: &|name| std::env::var(name).ok(),
            ini: None,
            place: ("<commandline>".to_owned(), 0),
            depth: 0,
            sourced: 0,
            ended: false,
            before_start: Vec::new(),
            folder: None,
            own_ini: None,
            plan: None,
            dry_run: None,
            is_machine: false,
            operator: None,
            returned: None,
            pass: None,
            sleeps_on_the_clock: false,
            is_postgui: false,
            is_first_look: false,
            asked: Asked::default(),
            stand_ins: StandIns::default(),
            open_commands: Vec::new(),
        }
    }

    /// Sets the file for values of `[SECTION]NAME`.
    pub const fn set_ini(&mut self, ini: &'a Ini) {
        self.ini = Some(ini);
    }

    /// Sets the source for values of `$NAME`, in place of this process's environment.
    pub const fn set_environment(&mut self, environment: &'a dyn Fn(&str) -> Option<String>) {
        self.environment = environment;
    }

    /// Sets the folder for relative file names.
    pub fn set_folder(&mut self, folder: &Path) {
        self.folder = Some(folder.to_owned());
    }

    /// Returns the options for changing them.
    pub const fn style_mut(&mut self) -> &mut Style {
        &mut self.style
    }

    /// Returns the programs that the session started and that have not ended yet.
    #[must_use]
    pub fn into_programs(self) -> Vec<Child> {
        self.programs
    }

    /// Sends a request of the calling program.
    ///
    /// # Errors
    /// The engine refused the request.
    pub fn ask(&mut self, request: Request) -> Result<Reply, Error> {
        if matches!(request, Request::Start | Request::Run { .. }) {
            self.settle_script()?;
            self.send_pending()?;
        }
        self.call(request)
    }

    /// Executes the lines of a file or of the terminal. `name` is its name in messages.
    pub fn file(&mut self, name: &str, lines: impl Lines) -> Outcome {
        self.read(name, Reader::new(lines), false)
    }

    /// Executes a single line as if it were at this place.
    pub fn line_at(&mut self, name: &str, number: u32, text: &str) -> Outcome {
        let before = self.place.clone();
        self.stand_at(name, number);
        let line = Line::single(number, text);
        let result = self.line(&line, true).map(|_| ());
        let outcome = self.settled(result, &line);
        self.stand_at(&before.0, before.1);
        outcome
    }

    /// Executes a command given as words, without replacing variables.
    pub fn command(&mut self, words: &[String]) -> Outcome {
        let (statement, line) = Statement::of_words(words);
        let result = self.execute_statement(&statement, true).map(|_| ());
        self.settled(result, &line)
    }

    /// Sets the place for the following commands.
    pub(crate) fn stand_at(&mut self, file: &str, line: u32) {
        if self.place.0 != file {
            file.clone_into(&mut self.place.0);
        }
        self.place.1 = line;
        self.link.at(file, line);
    }

    pub(crate) fn place(&self) -> (&str, u32) {
        (&self.place.0, self.place.1)
    }

    pub(crate) fn read<L: Lines>(
        &mut self,
        name: &str,
        mut reader: Reader<L>,
        nested: bool,
    ) -> Outcome {
        let mut failed = 0;
        while let Some(line) = reader.next(self.link) {
            if self.link.is_ending() {
                self.ended = true;
                return Outcome::Ended;
            }
            self.stand_at(name, line.number);
            if line.dos {
                self.warn_as(Code::DosLines, "File contains DOS-style line endings.");
            }
            let result = self.line(&line, nested);
            self.tell_late_refusals();
            match result {
                Ok(Step::On) => {}
                Ok(Step::Quit) => break,
                Err(_) if self.ended => return Outcome::Ended,
                Err(fault) => {
                    self.error(&fault, Some(&line));
                    failed += 1;
                    if self.dry_run.is_none() && (nested || !self.style.keep_going) {
                        break;
                    }
                }
            }
        }
        let told = self.style.verbose || self.terminal.is_person();
        if failed > 0 && !nested && self.style.keep_going && name != STDIN && told {
            let lines = if failed == 1 { "line" } else { "lines" };
            self.info(&format!("{name}: {failed} {lines} failed"));
        }
        if failed == 0 { Outcome::Good } else { Outcome::Failed }
    }

    fn line(&mut self, line: &Line, nested: bool) -> Result<Step, Fault> {
        let text = line.text.as_ref().map_err(Clone::clone)?;
        if self.style.echo {
            let text = without_comment(text)?;
            let text = text.to_owned();
            self.echo_line(line.number, &text);
        }
        self.plan.iter_mut().for_each(|plan| plan.stand_on(line));
        if let Some(dry_run) = &mut self.dry_run {
            let entries: Vec<(String, String)> = mentioned(text).into_iter().collect();
            if !entries.is_empty() {
                dry_run.entries.extend(entries.iter().cloned());
                dry_run.uses.push((At::new(&self.place.0, self.place.1), entries));
            }
        }
        let values =
            Values { environment: self.environment, ini: self.own_ini.as_ref().or(self.ini) };
        self.execute_statement(&Statement::parse(text, values)?, nested)
    }

    fn execute_statement(&mut self, statement: &Statement, nested: bool) -> Result<Step, Fault> {
        if statement.words().is_empty() {
            return Ok(Step::On);
        }
        if !nested && statement.ends_input() {
            return Ok(Step::Quit);
        }
        let command = statement.command();
        let Some(command) = self.in_pass(statement, command).map_err(|e| statement.blame(e))?
        else {
            return Ok(Step::On);
        };
        if let Some(dry_run) = &mut self.dry_run {
            let at = At::new(&self.place.0, self.place.1);
            dry_run.statements.push((at, statement.words().to_vec()));
        }
        let command = command?;
        let trailer = Trailer::of(&command);
        let brings_operator = self.awaits_operator(&command);
        let done = if self.plan.is_some() {
            self.plan(statement, command)
        } else {
            match self.with_built_in(command) {
                Ok(Some(command)) if self.dry_run.is_some() => self.dry_run_command(command),
                Ok(Some(command)) => self.execute(command),
                Ok(None) => Ok(()),
                Err(error) => Err(error),
            }
        };
        let done = if brings_operator { done.and_then(|()| self.load_operator()) } else { done };
        // No reader is left for further output.
        self.ended |= done == Err(Error::Output(Unwritten::ReaderGone));
        done.map(|()| Step::On).map_err(|error| {
            let after = trailer.lines(&error);
            let quiet = trailer.is_enough();
            Fault { after, quiet, ..statement.blame(error) }
        })
    }

    /// Reports the result of a line.
    fn settled(&mut self, result: Result<(), Fault>, line: &Line) -> Outcome {
        match result {
            Ok(()) => Outcome::Good,
            Err(_) if self.ended => Outcome::Ended,
            Err(fault) => {
                self.error(&fault, Some(line));
                Outcome::Failed
            }
        }
    }

    pub(crate) fn outcome_of(&mut self, result: Result<(), Error>) -> Outcome {
        match result {
            Ok(()) => Outcome::Good,
            Err(_) if self.ended => Outcome::Ended,
            Err(error) => {
                self.report(&error);
                Outcome::Failed
            }
        }
    }

    fn call(&mut self, request: Request) -> Result<Reply, Error> {
        let module = beside::module_of(&request);
        self.link.call(request).map_err(|failure| {
            if failure.code == INTERRUPTED {
                self.ended = true;
                return Error::AlreadyReported;
            }
            let Some(module) = module else { return Error::Engine(failure) };
            let ini = self.ini.and_then(|ini| Some(&*ini.entries().next()?.file));
            let places = (&*self.place.0, ini);
            Error::Engine(beside::name_source(failure, &module, places, |path| self.found_at(path)))
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Bytes, Captured, show::samples, show::status};
    use hal_protocol::{Answer, Failure, Kind, Lock, TicketInfo, Value};

    /// A link that answers like an engine and records its requests.
    #[derive(Default)]
    struct Scripted {
        asked: Vec<String>,
        lock: u8,
        ending: bool,
    }

    impl Link for Scripted {
        fn call(&mut self, request: Request) -> Result<Reply, Failure> {
            if self.ending {
                return Err(Failure::new(INTERRUPTED, "ending"));
            }
            self.asked.push(format!("{request:?}"));
            match request {
                Request::Get { name } if name == "bad" => {
                    let mut failure = Failure::new(-2, "parameter or pin 'bad': not found");
                    failure.hint = Some("did you mean bed?".to_owned());
                    failure.word = Some("bad".to_owned());
                    Err(failure)
                }
                Request::Get { .. } => Ok(Reply::Value(Value::U32(31))),
                Request::Status => {
                    Ok(Reply::Status(Box::new(status::samples::status(Lock(self.lock)))))
                }
                Request::List { kind: Kind::Threads, .. } => Ok(samples::threads()),
                Request::List { kind: Kind::Components, .. } => Ok(samples::components()),
                Request::List { kind: Kind::Signals, .. } => Ok(samples::signals()),
                Request::List { kind: Kind::Functs, .. } => Ok(samples::functs()),
                Request::List { kind: Kind::PinAliases | Kind::ParamAliases, .. } => {
                    Ok(samples::aliases())
                }
                Request::List { kind: Kind::Params, .. } => Ok(samples::params()),
                Request::List { .. } => Ok(samples::pins()),
                Request::Component { name } => Ok(Reply::Components(match samples::components() {
                    Reply::Components(list) => {
                        list.into_iter().filter(|c| c.name == name).collect()
                    }
                    _ => Vec::new(),
                })),
                Request::Command { name, .. } => Ok(Reply::Answer(Answer {
                    lines: vec![format!("{name} says this")],
                    ticket: Some(7),
                    awaited: false,
                })),
                Request::Ticket { .. } => {
                    Ok(Reply::Ticket(TicketInfo::Failed("limit switch".to_owned())))
                }
                Request::Shutdown => {
                    self.ending = true;
                    Ok(Reply::Done)
                }
                _ => Ok(Reply::Done),
            }
        }
    }

    fn run(text: &str, style: Style) -> (Outcome, Captured, Scripted) {
        let (mut link, mut terminal) = (Scripted::default(), Captured::default());
        let ini = Ini::parse("m.ini", b"[A]\nX = 5\n").unwrap();
        let mut session = Session::new(&mut link, &mut terminal, style, "default");
        session.set_ini(&ini);
        let outcome = session.file("f.hal", Bytes::new(text.as_bytes().to_vec()));
        (outcome, terminal, link)
    }

    /// Checks the output, with `!` before it if the file failed.
    fn check(text: &str, style: Style, want: &str) {
        let (outcome, terminal, _) = run(text, style);
        let mark = if outcome == Outcome::Good { "" } else { "!" };
        // The number of polls before a program ends is not part of the test.
        let patient = |line: &&str| !line.contains("Waiting for") && !line.starts_with('.');
        let all: String = terminal.all.split_inclusive('\n').filter(patient).collect();
        assert_eq!(format!("{mark}{all}"), want, "{text}");
    }

    const KEEP: Style = Style {
        keep_going: true,
        script: false,
        json: false,
        verbose: false,
        silent: false,
        echo: false,
        wait: false,
        reads_input: false,
        background: false,
    };

    #[test]
    fn errors_carry_file_and_line() {
        let failing = "getp bad";
        let said = "f.hal:1: parameter or pin 'bad': not found\nf.hal:1: did you mean bed?\n";
        check(failing, Style::default(), &format!("!{said}"));
        check("foo\nprint x\n", Style::default(), "!f.hal:1: Unknown command 'foo'\n");
        check(
            "foo\n\nprint x\nprint a b\n",
            KEEP,
            "!f.hal:1: Unknown command 'foo'\nf.hal:3: HALCMD MSG: x\n\
             f.hal:4: print requires at most 1 arguments, 2 given\n",
        );
        check(
            "print a\\\n b\\\n c\n",
            KEEP,
            "!f.hal:3: print requires at most 1 arguments, 3 given\n",
        );
        check(
            "print \"x\nprint [B]X\nprint $\n",
            KEEP,
            "!f.hal:1: unterminated quoted string\n\
             f.hal:2: Ini variable '[B]X' not found.\nf.hal:2: did you mean [A]X?\n\
             f.hal:3: Empty variable name.\n",
        );
        check(
            "print a\r\nprint b\r\n",
            KEEP,
            "f.hal:1: Warning: File contains DOS-style line endings.\n\
             f.hal:1: HALCMD MSG: a\nf.hal:2: HALCMD MSG: b\n",
        );
        check(
            "getp bad",
            Style { silent: true, ..KEEP },
            "!f.hal:1: parameter or pin 'bad': not found\n",
        );
    }

    #[test]
    fn a_person_is_shown_where() {
        let (mut link, mut terminal) = (Scripted::default(), Captured::default());
        terminal.person = true;
        let mut session = Session::new(&mut link, &mut terminal, KEEP, "default");
        session.file("f.hal", Bytes::new(b"print x\n\ngetp \\\n bad\nfoo [A]X\n".to_vec()));
        session.command(&["getp", "bad"].map(str::to_owned));
        assert_eq!(
            terminal.all,
            "f.hal:1: HALCMD MSG: x\n\
             f.hal:4: parameter or pin 'bad': not found\n    \
                 4 |  bad\n      |  ^^^\n\
             did you mean bed?\n\
             f.hal:5: Ini variable '[A]X' not found.\n    \
                 5 | foo [A]X\n      |     ^^^^\n\
             no INI file was given: -i names one\n\
             f.hal: 2 lines failed\n\
             f.hal:5: parameter or pin 'bad': not found\n      \
                 | getp bad\n      |      ^^^\n\
             did you mean bed?\n"
        );
    }

    #[test]
    fn files_end_where_they_say() {
        check("print a\nquit\nprint b\n", KEEP, "f.hal:1: HALCMD MSG: a\n");
        check("EXIT now # really\nprint b\n", KEEP, "");
        check(
            "\"quit\"\n",
            KEEP,
            "!f.hal:1: Unknown command '\"quit\"'\nf.hal:1: did you mean quit?\n",
        );
        let (outcome, terminal, link) = run("shutdown\nprint x\nstart\nfoo\n", Style::default());
        assert_eq!(outcome, Outcome::Ended);
        assert_eq!(terminal.all, "f.hal:2: HALCMD MSG: x\n");
        assert_eq!(link.asked, ["Shutdown"]);
    }

    #[test]
    fn variables_and_quotes() {
        check(
            "print [A]X\nprint \"[A]X mm\"\nprint\n",
            KEEP,
            "f.hal:1: HALCMD MSG: 5\nf.hal:2: HALCMD MSG: \"5 mm\"\nf.hal:3: HALCMD MSG: (null)\n",
        );
        let (_, _, link) = run("setp a.b [A]X\na.b = [A](X)0\nloadrt m cfg=\"f b\" n=1", KEEP);
        assert_eq!(
            link.asked,
            [
                "Set { name: \"a.b\", value: \"5\" }",
                "Set { name: \"a.b\", value: \"50\" }",
                "Load { module: \"m\", args: [\"cfg=\\\"f b\\\"\", \"n=1\"] }",
            ]
        );
    }

    #[test]
    fn values_and_types() {
        check("getp x.u\nptype x.u\n", KEEP, "31\nu32\n");
        check("getp x.u\n", Style { json: true, ..KEEP }, "{\"value\":{\"u32\":31}}\n");
    }

    #[test]
    fn listings() {
        check("list thread\n", KEEP, "slow fast \n");
        let (_, terminal, _) = run("show\n", KEEP);
        let headers: Vec<&str> = terminal.out.lines().filter(|l| l.ends_with(':')).collect();
        assert_eq!(
            headers,
            [
                "Loaded HAL Components:",
                "Component Pins:",
                "Pin Aliases:",
                "Signals:",
                "Parameters:",
                "Parameter Aliases:",
                "Exported Functions:",
                "Realtime Threads:",
            ]
        );
        let (_, terminal, _) = run("show alias\n", KEEP);
        assert_eq!(terminal.out.matches("my-alias").count(), 2);
        check(
            "show pin\nlist pin\nsave\nstatus\nprint x\n",
            Style { silent: true, ..KEEP },
            "f.hal:5: HALCMD MSG: x\n",
        );
    }

    #[test]
    fn verbose_sessions_say_what_was_done() {
        check(
            "net s a b\naddf f t\nstart\nloadrt m\nunload not\nlock tune\n",
            Style { verbose: true, ..KEEP },
            "f.hal:1: Pin 'a' linked to signal 's'\nf.hal:1: Pin 'b' linked to signal 's'\n\
             f.hal:2: Function 'f' added to thread 't'\n\
             f.hal:3: Realtime threads started\nf.hal:4: Realtime module 'm' loaded\n\
             f.hal:5: Realtime module 'not' unloaded\nf.hal:6: Locking completed\n",
        );
        check("net s a b\nstart\n", KEEP, "");
    }

    #[test]
    fn echo_prints_lines_without_comments() {
        check(
            "echo\nprint [A]X # c\n\nunecho\nprint z\n",
            KEEP,
            "Echo on\n(2)<echo>: print [A]X \nf.hal:2: HALCMD MSG: 5\n(3)<echo>: \n\
             (4)<echo>: unecho\nEcho off\nf.hal:5: HALCMD MSG: z\n",
        );
    }

    #[test]
    fn unload_asks_what_it_is() {
        let (_, _, link) = run("unload not\nunload halcmd20\nunload all\n", KEEP);
        let asked: Vec<&str> =
            link.asked.iter().map(String::as_str).filter(|a| !a.starts_with("Component")).collect();
        assert_eq!(
            asked,
            [
                "Unload { name: \"not\" }",
                "EndProgram { name: Some(\"halcmd20\") }",
                "EndProgram { name: None }",
                "UnloadAll",
            ]
        );
        check("unload nocomp\n", KEEP, "!f.hal:1: component 'nocomp' is not loaded\n");
        check("waitusr not\n", KEEP, "!f.hal:1: 'not' is not a userspace component\n");
        check("waitusr nocomp\n", KEEP, "");
    }

    #[test]
    fn commands_of_components_are_followed_when_asked_or_refused_at_once() {
        let refused = "!motion.jog says this\nf.hal:1: motion.jog: limit switch\n";
        check("motion.jog joint=0\n", KEEP, refused);
        check("motion.jog joint=0 --wait\n", KEEP, refused);
        check("motion.jog joint=0\n", Style { wait: true, ..KEEP }, refused);
    }

    #[test]
    fn what_comes_before_start_is_sent_once() {
        let (mut link, mut terminal) = (Scripted::default(), Captured::default());
        let mut session = Session::new(&mut link, &mut terminal, KEEP, "default");
        session.before_start(Request::EndRecord);
        assert_eq!(
            session.file("f", Bytes::new(b"setp a 1\nstart\nrun 1s\n".to_vec())),
            Outcome::Good
        );
        assert_eq!(session.settle(Outcome::Good), Outcome::Good);
        let set = "Set { name: \"a\", value: \"1\" }";
        assert_eq!(link.asked, [set, "EndRecord", "Start", "Run { ns: 1000000000 }"]);
    }

    #[test]
    fn a_sourced_file_speaks_for_itself() {
        let folder = std::env::temp_dir().join(format!("ferrule-source-{}", std::process::id()));
        std::fs::create_dir_all(&folder).unwrap();
        let write = |name: &str, text: &str| {
            let path = folder.join(name);
            std::fs::write(&path, text).unwrap();
            path.display().to_string()
        };
        let a = write("a.hal", "print in\\\nfoo\nprint after\n");
        let b = write("b.hal", "print [A]X\nquit\nprint after\n");
        let own = folder.join("own.hal").display().to_string();
        write("own.hal", &format!("source {own}\n"));
        let (_, first, _) = run(&format!("source {a}\nprint next\n"), KEEP);
        let (_, second, _) = run(&format!("source {b}\n"), KEEP);
        let (_, endless, _) = run(&format!("source {own}\n"), KEEP);
        let (_, missing, _) = run("source /nowhere.hal\n", KEEP);
        std::fs::remove_dir_all(&folder).unwrap();
        assert_eq!(
            first.all,
            format!(
                "{a}:1: HALCMD MSG: in\\\n{a}:2: Unknown command 'foo'\nf.hal:2: HALCMD MSG: next\n"
            )
        );
        assert_eq!(second.all, format!("{b}:1: HALCMD MSG: 5\n{b}:2: Unknown command 'quit'\n"));
        let want =
            format!("{own}:1: '{own}' is sourced within itself, or files are nested too deeply\n");
        assert_eq!(endless.all, want);
        assert_eq!(
            missing.all,
            "f.hal:1: Could not open hal file '/nowhere.hal': No such file or directory\n"
        );
    }

    #[test]
    fn words_of_the_command_line_are_taken_as_they_are() {
        let (mut link, mut terminal) = (Scripted::default(), Captured::default());
        let mut session = Session::new(&mut link, &mut terminal, KEEP, "default");
        let words = |text: &[&str]| text.iter().map(|w| (*w).to_owned()).collect::<Vec<_>>();
        assert_eq!(session.command(&words(&["print", "$HOME [A]X"])), Outcome::Good);
        assert_eq!(session.command(&words(&["quit"])), Outcome::Failed);
        assert_eq!(
            terminal.all,
            "<commandline>:0: HALCMD MSG: $HOME [A]X\n<commandline>:0: Unknown command 'quit'\n"
        );
    }

    #[test]
    fn programs_are_waited_for() {
        check("loadusr -w true\nloadusr -w -i false\n", KEEP, "");
        check("loadusr -w false\n", KEEP, "!f.hal:1: program 'false' failed, returned 1\n");
        let killed = std::env::temp_dir().join(format!("ferrule-kill-{}", std::process::id()));
        std::fs::write(&killed, "kill -9 $$\n").unwrap();
        let path = killed.display();
        check(
            &format!("loadusr -w sh {path}\n"),
            KEEP,
            "!f.hal:1: program 'sh' did not exit normally\n",
        );
        std::fs::remove_file(&killed).unwrap();
        check("loadusr -W true\n", KEEP, "!f.hal:1: true exited without becoming ready\n");
        check(
            "loadusr -Wn foo false\n",
            KEEP,
            "!f.hal:1: waitpid failed false foo\nf.hal:1: false exited without becoming ready\n",
        );
        check("loadusr -Wn halcmd20 true\n", KEEP, "");
        let (_, said, _) = run("loadusr -Wn nobody sleep 0.2\n", KEEP);
        let patient = "Waiting for component 'nobody' to become ready.";
        assert!(said.err.contains(patient), "{}", said.err);
        let nothing = "/no/such/program";
        let said = format!("f.hal:1: execv({nothing}): No such file or directory\n");
        check(&format!("loadusr {nothing}\n"), KEEP, &said);
        check(
            &format!("loadusr -w {nothing}\n"),
            KEEP,
            &format!("!{said}f.hal:1: program '{nothing}' failed, returned 1\n"),
        );
        let (mut link, mut terminal) =
            (Scripted { lock: 1, ..Scripted::default() }, Captured::default());
        let mut session = Session::new(&mut link, &mut terminal, KEEP, "default");
        session.file("f.hal", Bytes::new(b"loadusr true\n".to_vec()));
        assert_eq!(terminal.all, "f.hal:1: HAL is locked, loading of programs is not permitted\n");
    }
}
