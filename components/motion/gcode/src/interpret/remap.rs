//! Remapped codes of a block: the call of their subroutine and the rest of the block after it.

use super::{
    BlockError, Interpreter, Run, Step,
    block::Block,
    codes::GGroup,
    execute::{Part, Pause},
};
use crate::{
    canon::Issued,
    environment::Environment,
    error::Problem,
    function::Hook,
    parameters::set_name,
    program::Found,
    remap::{Code, Remap},
    state::{Level, LevelKind, Pending, Remapped},
};

impl Run<'_> {
    /// Returns the remap that replaces a part of a block.
    pub(crate) fn remap_of(&mut self, part: Part, block: &Block) -> Result<Option<usize>, Problem> {
        if self.state.settings.remaps.is_empty() {
            return Ok(None);
        }
        let code = match part {
            Part::Word(letter @ (b't' | b's' | b'f')) => {
                block.has(letter).then_some(Code::Word(letter))
            }
            Part::G(GGroup::Motion) => block.motion.map(Code::G),
            Part::M(group) => block.m(group).map(Code::M),
            Part::Remark | Part::Word(_) | Part::G(_) => None,
        };
        let Some(code) = code else { return Ok(None) };
        let remaps = &self.state.settings.remaps;
        let Some(index) = remaps.iter().position(|r| r.code == code) else { return Ok(None) };
        let mut around = self.state.levels.iter_mut().rev().filter_map(|l| l.remapped.as_mut());
        let Some(around) = around.find(|r| r.index == index) else { return Ok(Some(index)) };
        // Inside of its own subroutine, a code means what it did before.
        if code.is_of_the_language() {
            around.builtin_used = true;
            return Ok(None);
        }
        Err(Problem::RemapRecursion { code: code.to_string().into() })
    }

    /// Checks what a remap asks of a block and of the state.
    fn check_remap(&self, remap: &Remap, block: &Block) -> Result<(), Problem> {
        let code: Box<str> = remap.code.to_string().into();
        let missing: String = remap
            .arguments
            .iter()
            .filter(|a| a.required && !block.has(a.letter))
            .map(|a| char::from(a.letter.to_ascii_uppercase()))
            .collect();
        if !missing.is_empty() {
            return Err(Problem::RemapMissing { code, letters: missing.into() });
        }
        let still = self.state.modal.spindles.first().is_none_or(|s| s.speed <= 0.0);
        if remap.needs_speed && still {
            return Err(Problem::RemapSpeed { code });
        }
        if remap.needs_feed && self.state.modal.feed <= 0.0 {
            return Err(Problem::RemapFeed { code });
        }
        Ok(())
    }
}

impl Interpreter {
    /// Calls the subroutine of a remapped code.
    pub(super) fn begin_remap(
        &mut self,
        index: usize,
        block: Block,
        step: u8,
        env: &dyn Environment,
        out: &mut Vec<Issued>,
    ) -> Result<Step, BlockError> {
        let Some(remap) = self.state.settings.remaps.get(index).cloned() else {
            return Ok(Step::Line);
        };
        let run = Run::new(&mut self.state, env, out);
        run.check_remap(&remap, &block)?;
        let remapped = Box::new(Remapped { index, block, step, builtin_used: false });
        self.check_levels()?;
        if let Some(name) = remap.hook(Hook::Body) {
            let arguments = self.arguments(&remap, &remapped.block);
            self.begin_function(Hook::Body, name, arguments, Some(remapped));
            return Ok(Step::Line);
        }
        let Ok((file, start)) = self.locate(Found::Sub(&remap.ngc), &remap.ngc, env) else {
            self.problem_at.clear();
            let (code, name) = (remap.code.to_string().into(), remap.ngc.clone());
            return Err(Problem::RemapFile { code, name }.into());
        };
        let mut level = Level::new(file, start, LevelKind::Sub);
        level.label.clone_from(&remap.ngc);
        level.saved = self.state.numbered.locals();
        let values: Vec<(u8, Option<f64>)> =
            remap.arguments.iter().map(|a| (a.letter, remapped.block.get(a.letter))).collect();
        let mut numbered = Vec::new();
        if remap.positional {
            // A word that is left out leaves no gap.
            numbered.extend(values.iter().filter_map(|(_, v)| *v));
        } else {
            for (letter, value) in values {
                if let Some(value) = value {
                    set_name(&mut level.locals, &char::from(letter).to_string(), value)?;
                }
            }
        }
        if remap.line_number {
            set_name(&mut level.locals, "n", f64::from(self.state.line))?;
        }
        self.state.count_arguments(&mut level, numbered.len())?;
        self.state.numbered.set_locals(&numbered);
        level.remapped = Some(remapped);
        self.state.returned = None;
        self.state.levels.push(level);
        self.begin_hook(&remap, Hook::Prolog);
        Ok(Step::Line)
    }

    /// Runs the rest of the block whose remapped code has ended.
    pub(super) fn after_remap(
        &mut self,
        remapped: &Remapped,
        env: &dyn Environment,
        out: &mut Vec<Issued>,
    ) -> Result<Step, BlockError> {
        if let Some(level) = self.state.levels.last() {
            self.state.line = level.cursor.line;
        }
        let mut block = remapped.block.clone();
        let mut run = Run::new(&mut self.state, env, out);
        run.number = block.number;
        let asked = run.execute(&mut block, remapped.step + 1)?;
        self.after(&mut block, asked, env, out)
    }

    /// Keeps a block that waits, or begins the remapped code that it came to.
    pub(super) fn pause(
        &mut self,
        block: &Block,
        pause: Pause,
        step: u8,
        env: &dyn Environment,
        out: &mut Vec<Issued>,
    ) -> Result<Step, BlockError> {
        match pause {
            Pause::Remap(index) => self.begin_remap(index, block.clone(), step, env, out),
            Pause::Profile => self.profile(block, step, env, out),
            Pause::Ask(request) => {
                let block = block.clone();
                let pending = Pending { request: request.clone(), block, step };
                self.state.pending = Some(pending);
                Ok(Step::Ask(request))
            }
        }
    }
}
