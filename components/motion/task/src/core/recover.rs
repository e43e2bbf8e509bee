//! The start at the place where a job has broken off, from its journal.

use super::{
    Core, Ticket,
    journal::{Hashing, PERIOD, changed},
    restart::{Opened, Search},
};
use crate::outside::Outside;
use hal_gcode::{Interpreter, State, axis::Axis, parameters::number};
use hal_job::{
    dry_run::{DryRun, Found, Target},
    journal::{At, Journal},
    refusal::Refusal,
    world,
};
use std::collections::{BTreeSet, VecDeque};

/// Parameters of the coordinate systems and their like.
const OFFSETS: core::ops::RangeInclusive<i32> = number::G28..=5390;
/// Largest difference of a parameter, whose file has six decimals.
const ROUNDING: f64 = 1e-6;
/// Largest number of changes that a refusal names.
const MAX_REASONS: usize = 10;

/// A search for the place of a broken job.
pub(super) struct Recovery {
    journal: Journal,
    /// Files whose checksums are compared.
    checks: VecDeque<(Hashing, u64)>,
    pub(super) notes: Vec<String>,
    /// The state before the place where the job broke off, if the start is before that place.
    left: Option<Box<State>>,
}

impl Core {
    /// Begins the search for the place where the last job broke off. The proposal makes its program the one that is open.
    pub(super) fn recover(&mut self, ticket: Ticket, out: &mut impl Outside) -> Result<(), String> {
        self.needs_no_job("a dry run cannot begin")?;
        self.needs_no_search()?;
        let journal = Journal::parse(&out.read_journal()?).map_err(|e| e.to_string())?;
        if journal.is_complete {
            return Err("the last job has ended: there is nothing to resume".into());
        }
        let begin = &journal.begin;
        let path = begin.path.clone();
        let text = world::program_of(&self.world.machine, &path)?;
        let version = world::version(&path)?;
        let is_hashed = journal.files.iter().any(|(name, _)| *name == begin.name);
        if version.0 != begin.file.0 || !is_hashed && version != begin.file {
            return Err(changed(&path));
        }
        let mut settings = self.world.machine.settings.clone();
        settings.block_delete = begin.state.settings.block_delete;
        if settings != begin.state.settings {
            return Err("the machine's INI file has changed since the job began".into());
        }
        let mut checks = VecDeque::new();
        for (name, hash) in &journal.files {
            let text = if *name == begin.name {
                Some(text.clone())
            } else {
                hal_gcode::Environment::open(&self.world, name)
            };
            let text = text.ok_or_else(|| format!("{name}: the subroutine is missing"))?;
            checks.push_back((Hashing::new(name, text), *hash));
        }
        let first = begin.state.lines_run;
        let number = journal.at.as_ref().map_or(first, |at| at.number);
        let mut notes = Vec::new();
        if let Some(At { line, pose, homed, gone, left, .. }) = &journal.at {
            let pose = super::entry::words(&self.world.machine, pose);
            let homed = if *homed { "homed" } else { "not homed" };
            let unit = self.world.machine.settings.unit.symbol();
            let is_on_move = *gone > 0.0 || *left > 0.0;
            let along =
                format!(", {gone:.3} {unit} along its move and {left:.3} {unit} before its end");
            let along = if is_on_move { along } else { String::new() };
            notes.push(format!(
                "the job broke off at line {line}, near {pose}{along}, {homed}; the journal lags by at most {PERIOD} s"
            ));
        }
        if journal.is_cut {
            notes.push("the end of the journal was lost".to_owned());
        }
        let place = journal.at.as_ref().map(|at| (&*at.file, at.line));
        let run = self.replay(&journal, number, place)?;
        let recovery = Box::new(Recovery { journal, checks, notes, left: None });
        let program = Opened { path, version };
        self.search_for(Search { run, program, ticket, recovery: Some(recovery) });
        Ok(())
    }

    /// Returns a dry run of a job with the answers that the machine has given.
    /// It counts the times of the line of a file.
    fn replay(
        &self,
        journal: &Journal,
        number: u64,
        counted: Option<(&str, u32)>,
    ) -> Result<Box<DryRun>, String> {
        let begin = &journal.begin;
        let mut interpreter = Interpreter::from_state(begin.state.clone());
        interpreter.supply(&begin.name, world::program_of(&self.world.machine, &begin.path)?);
        let mut given = self.given();
        given.answers = journal.answers.iter().cloned().collect();
        given.outputs = begin.outputs.clone();
        given.tools = Some(begin.tools.clone());
        let run = DryRun::new(interpreter, Target::Number(number), given);
        Ok(Box::new(match counted {
            Some((file, line)) => run.counting(file, line),
            None => run,
        }))
    }

    /// Compares a slice of the program's files. Returns whether all are as they were.
    ///
    /// # Errors
    /// A file has changed.
    pub(super) fn check_files(&self, recovery: &mut Recovery) -> Result<bool, String> {
        let Some((hashing, wanted)) = recovery.checks.front_mut() else { return Ok(true) };
        if let Some(hash) = hashing.advance()? {
            if hash != *wanted {
                return Err(changed(hashing.name.as_ref().as_ref()));
            }
            recovery.checks.pop_front();
        }
        Ok(false)
    }

    /// Returns the search from the line before a series, if a place is in its middle.
    pub(super) fn stepped_back(&self, mut search: Search, refusal: &Refusal) -> Option<Search> {
        let Refusal::Middle { place, of, from: Some(from), .. } = refusal else { return None };
        let mut recovery = search.recovery?;
        recovery.left = search.run.take_refused_state();
        recovery.notes.push(format!("{place} is in the middle of {of}: the start is at {from}"));
        let run =
            self.replay(&recovery.journal, from.number, Some((&from.file, from.line))).ok()?;
        Some(Search { run, recovery: Some(recovery), ..search })
    }

    /// Checks that nobody has changed offsets, other parameters of the parameter file or tools since the job broke off.
    pub(super) fn check_offsets(&self, recovery: &Recovery, found: &Found) -> Result<(), String> {
        let begin = &recovery.journal.begin;
        let now = &self.interpreter.state.numbered;
        let left = recovery.left.as_deref().unwrap_or(&found.state);
        let known = |state: &State, index| state.numbered.get(index);
        let file = self.world.machine.parameters.iter().flat_map(|(_, file)| &file.values);
        let numbers: BTreeSet<i32> = OFFSETS.chain(file.map(|(number, _)| *number)).collect();
        let is_same = |was: f64, now: f64| (was - now).abs() <= ROUNDING;
        let mut reasons: Vec<String> = numbers
            .into_iter()
            .filter(|n| {
                let was = [known(&begin.state, *n), known(left, *n)];
                !was.iter().any(|was| is_same(*was, now.get(*n)))
            })
            .map(|n| {
                format!("parameter #{n} is {} and was {} in the job", now.get(n), known(left, n))
            })
            .collect();
        let numbers = begin.tools.tools.iter().chain(&self.world.machine.tools.tools);
        let mut numbers: Vec<i32> = numbers.map(|t| t.number).collect();
        numbers.sort_unstable();
        numbers.dedup();
        for number in numbers {
            let current = self.world.machine.tools.find(number);
            let changed = left.changed_tools.get(&number);
            let was = [begin.tools.find(number), changed.or_else(|| begin.tools.find(number))];
            let is_same = was.iter().any(|was| match (was, current) {
                (Some(was), Some(now)) => {
                    let places = Axis::ALL.iter().all(|a| was.offset[*a] == now.offset[*a]);
                    places && (was.diameter, was.orientation) == (now.diameter, now.orientation)
                }
                (None, None) => true,
                _ => false,
            });
            if !is_same {
                reasons.push(format!("tool {number} of the tool table has changed"));
            }
        }
        if reasons.is_empty() {
            return Ok(());
        }
        let more = reasons.len().saturating_sub(MAX_REASONS);
        reasons.truncate(MAX_REASONS);
        if more > 0 {
            reasons.push(format!("and {more} more"));
        }
        let why = reasons.join("; ");
        Err(format!(
            "the machine is not as the job left it: {why}; task.run-from begins with it as it is"
        ))
    }
}
