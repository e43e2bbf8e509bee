//! The two passes of a start with `[HAL]TWOPASS`: the first collects the `loadrt` lines of all files and starts programs; then
//! each component is loaded, by one line with the arguments of all its lines; the second pass executes everything else.

use crate::{
    Command, Error, Fault, Outcome, Session, language::joined::Pass, language::syntax::Statement,
};
use hal_protocol::Request;
use std::borrow::Cow;

impl Session<'_> {
    /// Begins the first pass.
    pub(crate) fn begin_passes(&mut self) {
        self.pass = Some(Pass::default());
    }

    /// Loads the components that the first pass has collected, and begins the second one. With `tells` each line is printed.
    pub(crate) fn begin_second_pass(&mut self, tells: bool) -> Outcome {
        let Some(mut pass) = self.pass.take() else { return Outcome::Good };
        let mut outcome = Outcome::Good;
        for load in core::mem::take(&mut pass.loads) {
            let words = load.words();
            if tells {
                self.info(&format!("twopass: {} ({})", words.join(" "), load.at));
            }
            self.stand_at(&load.at.file, load.at.line);
            match self.command(&words) {
                Outcome::Good => {}
                failed => outcome = failed,
            }
            if outcome == Outcome::Ended || outcome == Outcome::Failed && !self.goes_on() {
                break;
            }
        }
        pass.is_second = true;
        self.pass = Some(pass);
        outcome
    }

    /// Returns whether the lines behind a refused one are executed.
    const fn goes_on(&self) -> bool {
        self.style.keep_going || self.dry_run.is_some()
    }

    /// Returns the number of the pass, from 0; `None` outside of a start with two passes.
    pub(crate) fn pass_number(&self) -> Option<u32> {
        self.pass.as_ref().map(|pass| u32::from(pass.is_second))
    }

    /// Returns the words of a line of a Tcl script. In a start with two passes, a module with arguments may be one word, such as
    /// the list with the one value of `[KINS]KINEMATICS`; LinuxCNC splits it there, and only there.
    pub(super) fn words_in_pass<'w>(&self, words: &'w [String]) -> Cow<'w, [String]> {
        match words {
            [load, module, rest @ ..]
                if self.pass.is_some() && load == "loadrt" && module.contains(' ') =>
            {
                let list = module.strip_prefix('{').and_then(|m| m.strip_suffix('}'));
                let parts = list.unwrap_or(module).split_whitespace().map(str::to_owned);
                let load = core::iter::once(load.clone());
                Cow::Owned(load.chain(parts).chain(rest.iter().cloned()).collect())
            }
            _ => Cow::Borrowed(words),
        }
    }

    /// Returns the command that the pass executes for a line, if it does not leave it to the other pass.
    pub(super) fn in_pass(
        &mut self,
        statement: &Statement,
        command: Result<Command, Fault>,
    ) -> Result<Option<Result<Command, Fault>>, Error> {
        let at = self.current_line();
        let reads = self.returned.is_some();
        let Some(pass) = &mut self.pass else { return Ok(Some(command)) };
        let is_second = pass.is_second;
        let runs = match &command {
            Ok(Command::Send(Request::Load { module, args }, _)) if !is_second => {
                pass.collect(module, args, &at)?;
                pass.met.insert(statement.words().to_vec());
                false
            }
            Ok(Command::Launch(_)) if !is_second => {
                pass.met.insert(statement.words().to_vec());
                true
            }
            Ok(Command::Send(Request::Load { .. }, _) | Command::Launch(_)) => {
                !pass.met.contains(statement.words())
            }
            Ok(Command::Source(_)) | Err(_) => true,
            // A Tcl script may depend on what there is.
            Ok(
                Command::Value(_)
                | Command::TypeOf(_)
                | Command::List(..)
                | Command::Show(..)
                | Command::Save(..)
                | Command::Status(_),
            ) => is_second || reads,
            Ok(_) => is_second,
        };
        Ok(runs.then_some(command))
    }
}
