//! Flow control: loops, conditions, subroutines and program parts.

use super::{Found, scan::o_word};
use crate::{
    environment::Environment,
    error::Problem,
    function::Hook,
    interpret::{BlockError, BlockErrorAt, Interpreter},
    parameters::system::Reader,
    state::{Cursor, Level, LevelKind, Open, OpenKind},
    text::{
        evaluate::{evaluate, integer},
        expression::Expr,
        oword::{self, Action, Label, OWord},
    },
};

const NO_PARTS: &str = "DISABLE_FANUC_STYLE_SUB set in INI file, but found bare O-word";

impl Interpreter {
    /// Runs an O-word.
    pub(crate) fn flow(
        &mut self,
        word: &OWord,
        at: Cursor,
        env: &dyn Environment,
    ) -> Result<(), BlockError> {
        let label = self.label(&word.label, env)?;
        match &word.action {
            Action::Bare if self.state.settings.no_fanuc_subs => {
                Err(Problem::FanucSubs { what: NO_PARTS }.into())
            }
            Action::Bare => Ok(()),
            Action::Sub => self.skip_definition(&label, env),
            Action::Endsub(value) => self.leave(&label, "endsub", value.as_ref(), env),
            Action::Return(value) => self.leave(&label, "return", value.as_ref(), env),
            Action::Call(arguments) => self.call(&label, arguments, env),
            Action::Do => {
                let start = self.cursor();
                self.open(label, OpenKind::Do(start))
            }
            Action::While(condition) => self.run_while(label, condition, at, env),
            Action::Repeat(count) => {
                let passes = integer(libm::round(self.value(count, env)?))?;
                match u32::try_from(passes) {
                    Ok(passes) if passes > 0 => {
                        let start = self.cursor();
                        self.open(label, OpenKind::Repeat(start, passes))
                    }
                    _ => self.seek(&label, &["endrepeat"], env).map(|_| ()),
                }
            }
            Action::Endwhile => {
                let open = self.close(&label, "endwhile", |k| matches!(k, OpenKind::While(_)))?;
                if let OpenKind::While(start) = open.kind {
                    self.jump(start);
                }
                Ok(())
            }
            Action::Endrepeat => self.end_repeat(&label),
            Action::If(condition) => {
                if self.value(condition, env)? != 0.0 {
                    self.open(label, OpenKind::If)
                } else {
                    self.next_branch(label, env)
                }
            }
            Action::Elseif(_) => self.end_branch(&label, "elseif", env),
            Action::Else => self.end_branch(&label, "else", env),
            Action::Endif => self.close(&label, "endif", |k| matches!(k, OpenKind::If)).map(|_| ()),
            Action::Break => self.leave_loop(&label, "break", env),
            Action::Continue => self.leave_loop(&label, "continue", env),
        }
    }

    fn label(&self, label: &Label, env: &dyn Environment) -> Result<Box<str>, BlockError> {
        match label {
            Label::Name(name) => Ok(name.clone()),
            Label::Computed(expr) => Ok(integer(self.value(expr, env)?)?.to_string().into()),
        }
    }

    fn value(&self, expr: &Expr, env: &dyn Environment) -> Result<f64, BlockError> {
        let reader = Reader { state: &self.state, environment: env };
        evaluate(expr, 0, &reader)
            .map_err(|(at, problem)| BlockError { at: BlockErrorAt::Left(at), problem })
    }

    pub(super) fn level(&mut self) -> Result<&mut Level, BlockError> {
        self.state.levels.last_mut().ok_or_else(|| Problem::NoProgramEnd.into())
    }

    fn cursor(&self) -> Cursor {
        self.state.levels.last().map_or(Cursor::default(), |l| l.cursor)
    }

    fn jump(&mut self, to: Cursor) {
        if let Some(level) = self.state.levels.last_mut() {
            level.cursor = to;
            level.pass = level.pass.wrapping_add(1);
        }
    }

    fn open(&mut self, label: Box<str>, kind: OpenKind) -> Result<(), BlockError> {
        let limit = self.state.settings.limits.open;
        let level = self.level()?;
        if level.open.len() >= usize::try_from(limit).unwrap_or(usize::MAX) {
            return Err(Problem::LoopsTooDeep { limit }.into());
        }
        level.open.push(Open { label, kind });
        Ok(())
    }

    /// Takes the innermost open loop or condition if it has this label and kind.
    fn close(
        &mut self,
        label: &str,
        word: &'static str,
        fits: impl Fn(&OpenKind) -> bool,
    ) -> Result<Open, BlockError> {
        let level = self.level()?;
        let last = level.open.pop_if(|o| &*o.label == label && fits(&o.kind));
        last.ok_or_else(|| Problem::NotInLoop { label: label.into(), word }.into())
    }

    fn run_while(
        &mut self,
        label: Box<str>,
        condition: &Expr,
        at: Cursor,
        env: &dyn Environment,
    ) -> Result<(), BlockError> {
        let truth = self.value(condition, env)? != 0.0;
        let level = self.level()?;
        let closes = level.open.last().and_then(|o| match o.kind {
            OpenKind::Do(start) if o.label == label => Some(start),
            _ => None,
        });
        if let Some(start) = closes {
            if truth {
                self.jump(start);
            } else {
                level.open.pop();
            }
            return Ok(());
        }
        if truth {
            return self.open(label, OpenKind::While(at));
        }
        self.seek(&label, &["endwhile"], env).map(|_| ())
    }

    fn end_repeat(&mut self, label: &str) -> Result<(), BlockError> {
        let open = self.close(label, "endrepeat", |k| matches!(k, OpenKind::Repeat(..)))?;
        if let OpenKind::Repeat(start, left) = open.kind
            && left > 1
        {
            self.jump(start);
            return self.open(open.label, OpenKind::Repeat(start, left - 1));
        }
        Ok(())
    }

    /// Looks for the branch of a condition that applies after one that does not.
    fn next_branch(&mut self, label: Box<str>, env: &dyn Environment) -> Result<(), BlockError> {
        loop {
            let (word, rest, _) = self.seek(&label, &["elseif", "else", "endif"], env)?;
            match word {
                "endif" => return Ok(()),
                "else" => return self.open(label, OpenKind::If),
                _ => {
                    let (_, action) = oword::action(&rest).map_err(|e| match e {
                        nom::Err::Error(f) | nom::Err::Failure(f) => f.problem,
                        nom::Err::Incomplete(_) => Problem::NoNumber,
                    })?;
                    if let Action::Elseif(condition) = action
                        && self.value(&condition, env)? != 0.0
                    {
                        return self.open(label, OpenKind::If);
                    }
                }
            }
        }
    }

    fn end_branch(
        &mut self,
        label: &str,
        word: &'static str,
        env: &dyn Environment,
    ) -> Result<(), BlockError> {
        self.close(label, word, |k| matches!(k, OpenKind::If))?;
        self.seek(label, &["endif"], env).map(|_| ())
    }

    fn leave_loop(
        &mut self,
        label: &str,
        word: &'static str,
        env: &dyn Environment,
    ) -> Result<(), BlockError> {
        let level = self.level()?;
        let inner = level.open.iter().rposition(|o| &*o.label == label && o.kind != OpenKind::If);
        let Some(inner) = inner else {
            return Err(Problem::NotInLoop { label: label.into(), word }.into());
        };
        level.open.truncate(inner + 1);
        let kind = level.open.last().map(|o| o.kind.clone());
        let (end, at_end) = match kind {
            Some(OpenKind::While(start)) => {
                level.open.pop();
                if word == "continue" {
                    self.jump(start);
                    return Ok(());
                }
                ("endwhile", false)
            }
            Some(OpenKind::Do(_)) => ("while", word == "continue"),
            _ => ("endrepeat", word == "continue"),
        };
        let (.., before) = self.seek(label, &[end], env)?;
        if at_end {
            self.level()?.cursor = before;
        } else if end != "endwhile" {
            self.level()?.open.pop();
        }
        Ok(())
    }

    /// Moves behind the next of these keywords with this label. Returns it, the rest of its line and the place before.
    fn seek(
        &mut self,
        label: &str,
        words: &[&'static str],
        env: &dyn Environment,
    ) -> Result<(&'static str, Vec<u8>, Cursor), BlockError> {
        let from = self.cursor();
        let file = self.level()?.file.clone();
        let (mut raw, mut cleaned) = (Vec::new(), Vec::new());
        let mut cursor = from;
        while let Some(next) = self.read(&file, cursor, env, &mut raw)? {
            if raw.trim_ascii() == b"%" && self.is_closing_percent(&file, next) {
                break;
            }
            if let Some((found, rest)) = o_word(&raw, &mut cleaned)
                && let Some(word) = oword::keyword(rest)
                && let Some(word) = words.iter().find(|w| **w == word)
                && self.label(&found, env).is_ok_and(|l| &*l == label)
            {
                let rest = rest.to_vec();
                self.level()?.cursor = next;
                self.state.line = next.line;
                return Ok((word, rest, cursor));
            }
            cursor = next;
        }
        Err(Problem::EndMissing { label: label.into(), line: from.line }.into())
    }

    fn skip_definition(&mut self, label: &str, env: &dyn Environment) -> Result<(), BlockError> {
        let level = self.level()?;
        let (file, cursor, in_sub) =
            (level.file.clone(), level.cursor, level.kind == LevelKind::Sub);
        if in_sub {
            return Err(Problem::SubNested.into());
        }
        let longest = self.state.settings.limits.line_length;
        let first = self.sources.find(&file, Found::Sub(label), longest, env)?;
        if first.is_some_and(|f| f != cursor) {
            return Err(Problem::LabelDuplicate { label: label.into() }.into());
        }
        self.seek(label, &["endsub"], env)?;
        // Nothing between begins another one.
        let end = self.cursor();
        let (mut raw, mut cleaned) = (Vec::new(), Vec::new());
        let mut at = cursor;
        while let Some(next) = self.read(&file, at, env, &mut raw)?
            && next.offset < end.offset
        {
            let inner = o_word(&raw, &mut cleaned);
            if inner.is_some_and(|(_, rest)| oword::keyword(rest) == Some("sub")) {
                self.state.line = next.line;
                return Err(Problem::SubNested.into());
            }
            at = next;
        }
        Ok(())
    }

    fn leave(
        &mut self,
        label: &str,
        word: &'static str,
        value: Option<&Expr>,
        env: &dyn Environment,
    ) -> Result<(), BlockError> {
        let value = value.map(|v| self.value(v, env)).transpose()?;
        // The label of the word does not matter, as in the reference: the innermost subroutine ends.
        match self.level()?.kind {
            LevelKind::Sub => {}
            LevelKind::Part(..) => return Err(Problem::PartEnded.into()),
            _ => return Err(Problem::NotInSub { label: label.into(), word }.into()),
        }
        self.state.returned = value;
        self.pop_level(env)
    }

    /// Ends the innermost level and returns to its caller.
    pub(crate) fn pop_level(&mut self, env: &dyn Environment) -> Result<(), BlockError> {
        if self.begin_epilog() {
            return Ok(());
        }
        self.end_level(env)
    }

    /// Ends the innermost level, whose epilog has ended.
    pub(crate) fn end_level(&mut self, env: &dyn Environment) -> Result<(), BlockError> {
        let Some(level) = self.state.levels.pop() else { return Ok(()) };
        self.remapped = level.remapped;
        if level.kind == LevelKind::Sub {
            self.state.numbered.set_locals(&level.saved);
        }
        if level.restores
            && let Some(saved) = &level.modal
        {
            self.restore(saved, env)?;
        }
        Ok(())
    }

    /// Ends all calls and loops in progress after an error: the line after the outermost call is next.
    pub fn leave_calls(&mut self) {
        while self.state.levels.len() > 1
            && let Some(level) = self.state.levels.pop()
        {
            if level.kind == LevelKind::Sub {
                self.state.numbered.set_locals(&level.saved);
            }
        }
        if let Some(level) = self.state.levels.last_mut() {
            level.open.clear();
        }
        self.late.clear();
        self.remapped = None;
    }

    pub(crate) fn check_levels(&self) -> Result<(), BlockError> {
        let limit = usize::try_from(self.state.settings.limits.levels).unwrap_or(usize::MAX);
        // Each call may have a function and a line of it around it.
        let is_deep = self.state.levels.len() >= limit.saturating_mul(3);
        if self.state.call_level() + 1 >= limit || is_deep {
            return Err(Problem::TooManyLevels.into());
        }
        Ok(())
    }

    fn call(
        &mut self,
        label: &str,
        arguments: &[Expr],
        env: &dyn Environment,
    ) -> Result<(), BlockError> {
        let values: Vec<f64> =
            arguments.iter().map(|a| self.value(a, env)).collect::<Result<_, _>>()?;
        self.check_levels()?;
        if env.function(label) {
            self.begin_function(Hook::Word, label, (values, Vec::new()), None);
            return Ok(());
        }
        let (file, start) = self.locate(Found::Sub(label), label, env)?;
        let mut level = Level::new(file, start, LevelKind::Sub);
        level.label = label.into();
        level.saved = self.state.numbered.locals();
        self.state.count_arguments(&mut level, values.len())?;
        self.state.numbered.set_locals(&values);
        self.state.returned = None;
        self.state.levels.push(level);
        Ok(())
    }
}
