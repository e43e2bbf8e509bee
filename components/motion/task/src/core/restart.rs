//! A start in the middle of a program: the dry run, the proposal that is shown, and its confirmation.

mod shown;

use super::{
    Core, Entry, Mode, Origin, Tag, Ticket,
    entry::{self, Before, EntryStep, words},
    recover::Recovery,
};
use crate::outside::Outside;
use hal_component::StopEpoch;
use hal_gcode::{Interpreter, axis::Axis};
use hal_job::{
    dry_run::{DryRun, Found, Target},
    simulation::KnownAnswers,
    world::{self, Version},
};
pub(crate) use shown::Shown;
use std::{path::PathBuf, sync::Arc};

/// Number of lines of a dry run in one step of the worker.
const LINES: u32 = 2000;
/// Distance in machine units, from which the machine is no longer where it was.
const MOVED: f64 = 0.01;

/// A start in the middle of a program, as far as it has come.
#[derive(Default)]
pub(super) struct Restart {
    search: Option<Search>,
    proposal: Option<Proposal>,
    before: Option<Box<BeforeEntry>>,
    /// The last token.
    token: u32,
}

/// A dry run in progress.
pub(super) struct Search {
    pub(super) run: Box<DryRun>,
    pub(super) program: Opened,
    pub(super) ticket: Ticket,
    /// The journal that it follows.
    pub(super) recovery: Option<Box<Recovery>>,
}

/// The program of a dry run.
pub(super) struct Opened {
    pub(super) path: PathBuf,
    pub(super) version: Version,
}

/// The interpreter before an entry, to which the task returns if the entry breaks off.
struct BeforeEntry {
    interpreter: Interpreter,
    /// Serial number of the entry's steps.
    serial: u64,
}

/// A start that waits for its confirmation.
struct Proposal {
    token: u32,
    found: Found,
    interpreter: Box<Interpreter>,
    program: Opened,
    /// Place of the machine and tool in the spindle, which the entry begins with.
    pose: [f64; 9],
    tool: i32,
    /// The entry, or the reasons why the machine is not ready for it.
    entry: Result<Vec<EntryStep>, String>,
    /// Place of the line in machine units.
    place: [f64; 9],
    /// Remarks about the journal.
    notes: Vec<String>,
    shown: Arc<Shown>,
}

impl Core {
    /// Begins the dry run to a place in the program that is open.
    pub(super) fn run_from(
        &mut self,
        target: Target,
        ticket: Ticket,
        out: &mut impl Outside,
    ) -> Result<(), String> {
        self.needs_no_job("a dry run cannot begin")?;
        self.needs_no_search()?;
        let why = "no program is open: task.open file=… comes first";
        let path = self.program.clone().ok_or(why)?;
        let text = world::program_of(&self.world.machine, &path)?;
        let version = world::version(&path)?;
        self.take_over(out);
        let mut interpreter = Interpreter::from_state(self.interpreter.state.clone());
        interpreter.load(&Self::name_of(&path), text);
        let run = Box::new(DryRun::new(interpreter, target, self.given()));
        let program = Opened { path, version };
        self.search_for(Search { run, program, ticket, recovery: None });
        Ok(())
    }

    /// Checks that no dry run is in progress.
    pub(super) fn needs_no_search(&self) -> Result<(), String> {
        match &self.restart.search {
            Some(_) => Err("a dry run is in progress: task.abort ends it".into()),
            None => Ok(()),
        }
    }

    /// Begins a dry run.
    pub(super) fn search_for(&mut self, search: Search) {
        self.restart.proposal = None;
        self.restart.search = Some(search);
    }

    /// Returns the answers that the machine's rules give.
    pub(super) fn given(&self) -> KnownAnswers {
        let k = self.world.machine.settings.unit.millimetres();
        let change = self.rules.change_position.map(|place| {
            let mut out = place;
            for (value, axis) in out.iter_mut().zip(Axis::ALL) {
                let k = if axis.is_rotary() { 1.0 } else { k };
                *value = value.map(|v| v * k);
            }
            out
        });
        KnownAnswers { change_position: change, ..KnownAnswers::default() }
    }

    /// Goes on with the dry run; at its end there is a proposal.
    pub(super) fn advance_dry_run(&mut self, out: &mut impl Outside) {
        let Some(mut search) = self.restart.search.take() else { return };
        let ticket = search.ticket;
        // The state at its begin is no longer that of the machine.
        if self.job.is_some() {
            return out.finish(ticket, Err("another job has begun".into()));
        }
        match search.recovery.as_mut().map_or(Ok(true), |r| self.check_files(r)) {
            Ok(true) => {}
            Ok(false) => {
                self.restart.search = Some(search);
                return;
            }
            Err(why) => return out.finish(ticket, Err(why)),
        }
        match search.run.advance(&self.world, LINES) {
            Ok(None) => self.restart.search = Some(search),
            Ok(Some(found)) => {
                let result = self.propose(search, found, out);
                out.finish(ticket, result);
            }
            Err(refusal) => match self.stepped_back(search, &refusal) {
                Some(search) => self.restart.search = Some(search),
                None => out.finish(ticket, Err(refusal.to_string())),
            },
        }
    }

    fn propose(&mut self, search: Search, found: Found, out: &impl Outside) -> Result<(), String> {
        let Search { run, program, recovery, .. } = search;
        let notes = match recovery {
            Some(recovery) => {
                self.check_offsets(&recovery, &found)?;
                self.program = Some(program.path.clone());
                recovery.notes
            }
            None => Vec::new(),
        };
        let interpreter = Box::new(run.into_interpreter(&found));
        let (motion, io) = (out.motion(), out.io());
        let before = Before { state: &self.interpreter.state, io, pose: motion.pose };
        let ready = self.may_begin(Mode::Auto, "a program", out);
        let entry =
            ready.and_then(|()| entry::entry(&before, &found, &self.world.machine, &self.rules));
        let place = entry::place(&self.world.machine, &found.state, motion.pose);
        self.restart.token = self.restart.token.wrapping_add(1);
        let mut proposal = Proposal {
            token: self.restart.token,
            found,
            interpreter,
            program,
            pose: motion.pose,
            tool: io.tool,
            entry,
            place,
            notes,
            shown: Arc::default(),
        };
        proposal.shown = Arc::new(proposal.shown(&self.world.machine));
        self.restart.proposal = Some(proposal);
        Ok(())
    }

    /// Begins the start that was proposed with this token.
    pub(super) fn confirm(
        &mut self,
        token: u32,
        ticket: Ticket,
        given: StopEpoch,
        out: &mut impl Outside,
    ) -> Result<(), String> {
        self.needs_no_job("a program cannot begin")?;
        let again = "task.run-from proposes it again";
        let known = self.restart.proposal.as_ref().filter(|p| p.token == token);
        let proposal = known.ok_or_else(|| format!("token {token} is not that of a proposal"))?;
        proposal.entry.clone()?;
        self.may_begin(Mode::Auto, "a program", out)?;
        let Opened { path, version } = &proposal.program;
        if self.program.as_ref() != Some(path) || world::version(path)? != *version {
            return Err(format!("the program has changed since the proposal: {again}"));
        }
        let pose = out.motion().pose;
        if pose.iter().zip(proposal.pose).any(|(a, b)| (a - b).abs() > MOVED) {
            return Err(format!("the machine has moved since the proposal: {again}"));
        }
        if out.io().tool != proposal.tool {
            return Err(format!("the tool has changed since the proposal: {again}"));
        }
        let rest = Interpreter::from_state(proposal.interpreter.state.clone());
        let rest = self.check_rest(rest, &proposal.program.path)?;
        let Some(proposal) = self.restart.proposal.take() else { return Ok(()) };
        let Proposal { found, interpreter, program, entry, place, .. } = proposal;
        let before = core::mem::replace(&mut self.interpreter, *interpreter);
        self.interpreter.state.settings.block_delete = self.world.machine.settings.block_delete;
        self.interpreter.state.numbered.record_changes();
        self.take_stopped_spindles(given, out);
        self.begin_job(true, Some(ticket), given, false, out);
        self.begin_journal(&program.path, &found.effects.outputs, out);
        self.checking.go_on(rest);
        self.serial += 1;
        let number = found.begin.number;
        let (line, serial) = (found.begin.line, self.serial);
        let mut tag = Tag {
            file: self.tag().file.clone(),
            modal: before.state.modal.clone(),
            frame: before.state.frame,
        };
        let unit = before.state.frame.unit.to(self.world.machine.settings.unit);
        for action in entry.unwrap_or_default().into_iter().flat_map(|step| step.actions) {
            tag.note(&action, unit);
            let origin = Origin { line, serial, number, tag: Arc::new(tag.clone()) };
            self.queue.push_back(Entry { action, origin });
        }
        self.restart.before = Some(Box::new(BeforeEntry { interpreter: before, serial }));
        self.converter.restart(&self.interpreter.state, place);
        Ok(())
    }

    /// Returns the proposal for the operator.
    pub(crate) fn shown_start(&self) -> Option<Arc<Shown>> {
        self.restart.proposal.as_ref().map(|p| p.shown.clone())
    }

    /// Forgets the interpreter before the entry, unless a step of the entry is in execution or waits.
    pub(super) fn leave_entry(&mut self) {
        let Some(BeforeEntry { serial, .. }) = self.restart.before.as_deref() else { return };
        let queue = self.queue.iter().map(|entry| &entry.origin);
        let flight = self.flight.iter().map(|flight| &flight.origin);
        let current = self.current.iter().filter(|_| self.waiting.is_some());
        if !queue.chain(flight).chain(current).any(|origin| origin.serial == *serial) {
            self.restart.before = None;
        }
    }

    /// Returns to the interpreter before an entry that has broken off.
    pub(super) fn return_from_entry(&mut self) {
        if let Some(before) = self.restart.before.take() {
            self.interpreter = before.interpreter;
            // Its changes are those of lines that were read from the place.
            self.undo.clear();
            let block_delete = self.world.machine.settings.block_delete;
            self.interpreter.state.settings.block_delete = block_delete;
        }
    }

    /// Ends a dry run and forgets a proposal.
    pub(super) fn forget_dry_run(&mut self, why: &str, out: &mut impl Outside) {
        self.restart.proposal = None;
        if let Some(search) = self.restart.search.take() {
            out.finish(search.ticket, Err(why.to_owned()));
        }
    }
}

#[cfg(test)]
impl Core {
    /// Returns the state that is proposed, and the interpreter in it.
    pub(crate) fn proposed(&self) -> Option<(&Found, &Interpreter)> {
        self.restart.proposal.as_ref().map(|p| (&p.found, &*p.interpreter))
    }
}
