//! Reading of a line: limits, end of the program, words to values.

use super::{
    BlockError, BlockErrorAt, Interpreter, Run, Step,
    block::Block,
    execute::Asked,
    hal::{Asking, Before},
};
use crate::{
    canon::{Call, Issued},
    environment::Environment,
    error::{Error, Problem},
    foreign,
    interpret::codes::MGroup,
    parameters::{check_writable, set_name, system},
    question::Answer,
    state::{Cursor, Level, LevelKind, Pending},
    text::{
        clean,
        evaluate::{Values, evaluate, integer},
        line::{Line, Target},
        oword::Action,
    },
};

impl Interpreter {
    /// Reads and runs one line.
    pub(super) fn run_line(
        &mut self,
        env: &dyn Environment,
        out: &mut Vec<Issued>,
    ) -> Result<Step, Error> {
        self.problem_at.clear();
        let limits = self.state.settings.limits;
        if self.state.lines_run >= limits.lines {
            return Err(self.error(Problem::LinesSpent { limit: limits.lines }.into(), &[]));
        }
        self.state.lines_run += 1;
        self.state.lines_quiet += 1;
        let Some(level) = self.state.levels.last() else {
            self.state.ended = true;
            return Ok(Step::Ended);
        };
        let (at, before) = (level.cursor, Before::of(level));
        if !level.is_of_file() {
            return self.run_function(env, out);
        }
        let longest = limits.line_length;
        let mut raw = core::mem::take(&mut self.raw);
        let result = match self.sources.line(&level.file, at, longest, env, &mut raw) {
            Err(problem) => Err(self.error(problem.into(), &[])),
            Ok(None) => self.end_of_file(out).map_err(|t| self.error(t, &[])),
            Ok(Some(next)) => {
                if let Some(level) = self.state.levels.last_mut() {
                    level.cursor = next;
                }
                self.state.line = next.line;
                if self.state.is_rs274d() {
                    let result = self.run_rs274d(&raw, env, out);
                    let result = result.map_err(|error| self.error(error, &raw));
                    self.raw = raw;
                    return result;
                }
                let known = core::mem::take(&mut self.hal);
                let asking = Asking::new(env, &known);
                let result = self.run_text(&raw, at, &asking, out);
                let missing = asking.missing();
                if missing.is_empty() {
                    result.map_err(|error| self.error(error, &raw))
                } else {
                    Ok(self.ask_hal(before, missing, known))
                }
            }
        };
        self.raw = raw;
        result
    }

    pub(super) fn run_text(
        &mut self,
        raw: &[u8],
        at: Cursor,
        env: &Asking<'_>,
        out: &mut Vec<Issued>,
    ) -> Result<Step, BlockError> {
        let limit = self.state.settings.limits.line_length;
        if raw.len() > limit {
            return Err(Problem::LineTooLong { limit }.into());
        }
        clean::clean(raw, &mut self.cleaned)
            .map_err(|(at, problem)| BlockError { at: BlockErrorAt::Raw(at), problem })?;
        if self.cleaned.is_empty() {
            return Ok(Step::Line);
        }
        if self.cleaned == b"%" {
            return self.percent(out);
        }
        let mut line = core::mem::take(&mut self.line);
        let parsed = line.parse(&self.cleaned).map_err(|fault| BlockError {
            at: BlockErrorAt::Left(crate::text::expression::left(fault.at)),
            problem: of_other_control(&self.cleaned).unwrap_or(fault.problem),
        });
        let result = parsed.and_then(|()| self.run_parsed(&line, at, env, out));
        self.line = line;
        result
    }

    fn run_parsed(
        &mut self,
        line: &Line,
        at: Cursor,
        env: &Asking<'_>,
        out: &mut Vec<Issued>,
    ) -> Result<Step, BlockError> {
        let is_left_out = line.deletable && self.state.settings.block_delete;
        if is_left_out || env.lacks(line, &self.cleaned) {
            return Ok(Step::Line);
        }
        if let Some(word) = &line.oword {
            let executed = self.state.levels.last().is_some_and(|l| !l.is_of_file());
            if executed && !matches!(word.action, Action::Call(_)) {
                return Err(Problem::ExecutedOWord.into());
            }
            let result = self.flow(word, at, env);
            out.append(&mut self.late);
            result?;
            return match self.remapped.take() {
                Some(remapped) => self.after_remap(&remapped, env, out),
                None => Ok(Step::Line),
            };
        }
        let mut block = core::mem::take(&mut self.block);
        let result = self.run_words(line, &mut block, env, out);
        self.block = block;
        result
    }

    fn run_words(
        &mut self,
        line: &Line,
        block: &mut Block,
        env: &dyn Environment,
        out: &mut Vec<Issued>,
    ) -> Result<Step, BlockError> {
        *block = Block::default();
        block.number = line.number;
        self.values(line, block, env)?;
        if let Some(remark) = &line.remark {
            block.remark = Some((remark.kind as u8, remark.text.clone()));
        }
        let mut run = Run::new(&mut self.state, env, out);
        run.number = block.number;
        let asked = run.prepare(block).and_then(|()| run.execute(block, 0));
        let focus = run.focus;
        let asked = asked.map_err(|p| located(p, block, focus))?;
        self.after(block, asked, env, out)
    }

    /// Runs the rest of a block after an answer.
    pub(super) fn resume(
        &mut self,
        pending: Pending,
        answer: &Answer,
        env: &dyn Environment,
        out: &mut Vec<Issued>,
    ) -> Result<Step, BlockError> {
        let Pending { request, block, step } = pending;
        let mut run = Run::new(&mut self.state, env, out);
        run.number = block.number;
        run.take_answer(&request, answer)?;
        if self.finished() {
            return Ok(Step::Line);
        }
        let mut run = Run::new(&mut self.state, env, out);
        run.number = block.number;
        let mut block = block;
        let asked = run.execute(&mut block, step + 1)?;
        self.after(&mut block, asked, env, out)
    }

    /// Finishes a block: keeps it if it pauses, or follows M70 to M73, M98 and M99.
    pub(crate) fn after(
        &mut self,
        block: &mut Block,
        asked: Asked,
        env: &dyn Environment,
        out: &mut Vec<Issued>,
    ) -> Result<Step, BlockError> {
        if let Some((pause, step)) = asked {
            return self.pause(block, pause, step, env, out);
        }
        match block.m(MGroup::Call) {
            Some(98) if self.state.settings.no_fanuc_subs => {
                let what = "DISABLE_FANUC_STYLE_SUB set in INI file, but found m98";
                return Err(Problem::FanucSubs { what }.into());
            }
            Some(98) => {
                let part = block.integer(b'p')?.ok_or(Problem::M98NeedsP)?;
                let repeats = block.integer(b'l')?.unwrap_or(1);
                self.call_part(part, repeats, env)?;
            }
            Some(99) if !self.end_part(env)? => {
                Run::new(&mut self.state, env, out).end(false)?;
            }
            _ => {}
        }
        out.append(&mut self.late);
        Ok(if self.state.ended { Step::Ended } else { Step::Line })
    }

    /// Evaluates the words of a line and then its assignments, which all see the old values.
    pub(crate) fn values(
        &mut self,
        line: &Line,
        block: &mut Block,
        env: &dyn Environment,
    ) -> Result<(), BlockError> {
        let reader = system::Reader { state: &self.state, environment: env };
        let lost = |(at, problem)| BlockError { at: BlockErrorAt::Left(at), problem };
        for word in &line.words {
            let value = evaluate(&word.value, word.at, &reader).map_err(lost)?;
            block
                .add(word.letter, word.at, value, &self.state.settings.remaps)
                .map_err(|problem| BlockError { at: BlockErrorAt::Left(word.at), problem })?;
        }
        if line.assignments.is_empty() {
            return Ok(());
        }
        let mut numbered: Vec<(i32, f64)> = Vec::new();
        let mut named: Vec<(&str, f64)> = Vec::new();
        for (at, target, expr) in &line.assignments {
            let here = |problem| BlockError { at: BlockErrorAt::Left(*at), problem };
            let value = evaluate(expr, *at, &reader).map_err(lost)?;
            match target {
                Target::Numbered(index) => {
                    let index =
                        integer(evaluate(index, *at, &reader).map_err(lost)?).map_err(here)?;
                    check_writable(index).map_err(here)?;
                    numbered.push((index, value));
                }
                Target::Named(name) => {
                    if self.state.is_argument_count(name) {
                        return Err(here(Problem::NamedReadOnly { name: name.clone() }));
                    }
                    if system::is_system(&self.state, name) {
                        // The reference ignores an assignment to a value of the INI file or HAL.
                        if reader.exists(name) && !name.ends_with(']') {
                            return Err(here(Problem::NamedReadOnly { name: name.clone() }));
                        }
                        continue;
                    }
                    named.push((name, value));
                }
            }
        }
        for (index, value) in numbered {
            self.state.numbered.put(index, value);
        }
        for (name, value) in named {
            let locals = self.state.scope_mut().map(|l| &mut l.locals);
            match locals {
                Some(locals) if !name.starts_with('_') => set_name(locals, name, value)?,
                _ => set_name(&mut self.state.globals, name, value)?,
            }
        }
        Ok(())
    }

    fn percent(&mut self, out: &mut Vec<Issued>) -> Result<Step, BlockError> {
        let level = self.state.levels.last();
        let Some(Level { kind: LevelKind::Main { percent: true }, cursor, .. }) = level else {
            return Err(Problem::BadCharacter { shown: "%".into() }.into());
        };
        // The first percent sign begins the program; only blank lines came before it.
        if self.state.lines_run <= u64::from(cursor.line) && !self.seen_percent(*cursor) {
            return Ok(Step::Line);
        }
        let line = self.state.line;
        out.push(Issued { call: Call::Finish, line, number: None });
        self.state.ended = true;
        Ok(Step::Ended)
    }

    /// Tells whether a line with text came before the one at which the level is.
    fn seen_percent(&mut self, at: Cursor) -> bool {
        let Some(level) = self.state.levels.last() else { return true };
        let file = level.file.clone();
        self.first_text(&file).is_none_or(|(_, next)| next != at)
    }

    /// Tells whether the first line with text of a file that is known is a percent sign.
    pub(super) fn begins_with_percent(&mut self, file: &str) -> bool {
        self.first_text(file).is_some_and(|(line, _)| line.trim_ascii() == b"%")
    }

    /// Tells whether the line of a percent sign that ends at `next` is the end of a file, which began with one.
    pub(crate) fn is_closing_percent(&mut self, file: &str, next: Cursor) -> bool {
        self.first_text(file)
            .is_some_and(|(line, first)| line.trim_ascii() == b"%" && first != next)
    }

    /// Returns the first line with text of a file that is known, and the cursor behind it.
    fn first_text(&mut self, file: &str) -> Option<(Vec<u8>, Cursor)> {
        let (mut cursor, mut raw) = (Cursor::default(), Vec::new());
        while let Ok(Some(next)) = self.read(file, cursor, &NoFiles, &mut raw) {
            if !raw.trim_ascii().is_empty() {
                return Some((raw, next));
            }
            cursor = next;
        }
        None
    }

    fn end_of_file(&mut self, out: &mut Vec<Issued>) -> Result<Step, BlockError> {
        match self.state.levels.last().map(|l| &l.kind) {
            Some(LevelKind::Mdi) => {
                self.state.ended = true;
                Run::new(&mut self.state, &NoFiles, out).flush_compensation();
                Ok(Step::Ended)
            }
            Some(LevelKind::Sub) => {
                let level = self.state.levels.last();
                let label = level.map(|l| l.label.clone()).unwrap_or_default();
                Err(Problem::EndMissing { label, line: 0 }.into())
            }
            _ if self.state.is_rs274d() => self.end_rs274d(out),
            _ => Err(Problem::NoProgramEnd.into()),
        }
    }
}

/// Returns the problem of a line that cannot be read here, and that another control understands.
fn of_other_control(line: &[u8]) -> Option<Problem> {
    Some(Problem::Foreign { said: foreign::line_advice(line)?.into() })
}

/// Gives a problem of a block its place: its word's, or that of the code in execution.
pub(super) fn located(
    problem: Problem,
    block: &Block,
    focus: Option<crate::text::expression::Left>,
) -> BlockError {
    let letter = match &problem {
        Problem::UnusedWord { letter, .. }
        | Problem::NegativeWord { letter }
        | Problem::ValueNotInteger { letter }
        | Problem::ArcWordPlane { letter, .. } => {
            u8::try_from(letter.to_ascii_lowercase()).ok().filter(|l| block.has(*l))
        }
        _ => None,
    };
    let at = match (letter, focus) {
        (Some(letter), _) => BlockErrorAt::Left(block.place(letter)),
        (None, Some(left)) => BlockErrorAt::Left(left),
        (None, None) => BlockErrorAt::Line,
    };
    BlockError { at, problem }
}

/// An environment without anything.
pub(super) struct NoFiles;

impl Environment for NoFiles {
    fn open(&self, _: &str) -> Option<crate::environment::Text> {
        None
    }

    fn tool(&self, _: i32) -> Option<crate::tool::Tool> {
        None
    }
}
