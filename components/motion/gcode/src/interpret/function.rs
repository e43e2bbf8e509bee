//! Functions of another language in a program: their begin, their steps, and the lines that they execute.

use super::{
    BlockError, Interpreter, Step,
    block::Block,
    hal::{Asking, Before},
};
use crate::{
    canon::Issued,
    environment::Environment,
    error::{Error, Problem},
    function::{Failure, Function, Hook, Next, Reply, Turn, Wanted},
    parameters::system::Reader,
    question::{Answer, Request},
    remap::Remap,
    state::{Level, LevelKind, Pending, Remapped},
    text::evaluate::Values,
};

/// Arguments of a function without and with a name.
pub(crate) type Arguments = (Vec<f64>, Vec<(Box<str>, f64)>);

impl Interpreter {
    /// Returns the words of a remapped block that go to its functions.
    pub(super) fn arguments(&self, remap: &Remap, block: &Block) -> Arguments {
        let given = |letter: u8| block.get(letter);
        if remap.positional {
            let values = remap.arguments.iter().map(|a| given(a.letter).unwrap_or(0.0));
            return (values.collect(), Vec::new());
        }
        let word = |letter: u8| Some((char::from(letter).to_string().into(), given(letter)?));
        let mut words: Vec<_> = remap.arguments.iter().filter_map(|a| word(a.letter)).collect();
        if remap.line_number {
            words.push(("n".into(), f64::from(self.state.line)));
        }
        (Vec::new(), words)
    }

    /// Begins a function as the innermost level. Its lines are those of the level that calls it.
    pub(crate) fn begin_function(
        &mut self,
        hook: Hook,
        name: &str,
        (arguments, words): Arguments,
        remapped: Option<Box<Remapped>>,
    ) {
        let state = &mut self.state;
        state.functions_called += 1;
        let serial = state.functions_called;
        let (file, cursor) =
            state.levels.last().map(|l| (l.file.clone(), l.cursor)).unwrap_or_default();
        let (name, turn) = (name.into(), Turn::Begin);
        let (changing, stated) = (None, None);
        let function =
            Function { hook, name, arguments, words, serial, turns: 0, turn, changing, stated };
        let mut level = Level::new(file, cursor, LevelKind::Function(Box::new(function)));
        level.remapped = remapped;
        if matches!(hook, Hook::Body | Hook::Word) {
            state.returned = None;
        }
        state.levels.push(level);
    }

    /// Begins a prolog or epilog of the innermost level, if its remap has one. Returns whether it has.
    pub(super) fn begin_hook(&mut self, remap: &Remap, hook: Hook) -> bool {
        let Some(name) = remap.hook(hook) else { return false };
        let block = self.state.levels.last().and_then(|l| l.remapped.as_ref());
        let arguments = block.map(|r| self.arguments(remap, &r.block)).unwrap_or_default();
        self.begin_function(hook, name, arguments, None);
        true
    }

    /// Begins the epilog of the innermost level, which ends. Returns false if there is none.
    pub(crate) fn begin_epilog(&mut self) -> bool {
        let remap = self.state.levels.last().and_then(|l| l.remapped.as_ref());
        let remap = remap.and_then(|r| self.state.settings.remaps.get(r.index).cloned());
        remap.is_some_and(|remap| self.begin_hook(&remap, Hook::Epilog))
    }

    /// Returns the function that is the innermost level.
    fn function(&mut self) -> Result<&mut Function, Problem> {
        match self.state.levels.last_mut().map(|l| &mut l.kind) {
            Some(LevelKind::Function(function)) => Ok(function),
            _ => Err(Problem::FunctionAsks),
        }
    }

    /// Goes on with the function, or the line of one, that is the innermost level.
    pub(super) fn run_function(
        &mut self,
        env: &dyn Environment,
        out: &mut Vec<Issued>,
    ) -> Result<Step, Error> {
        let result = self.run_turn(env, out);
        self.end_failed(result)
    }

    /// Ends the function that is the innermost level after its failure: a host that goes on reads the next line. Where
    /// another function executes it, that one gets the error.
    fn end_failed(&mut self, result: Result<Step, Error>) -> Result<Step, Error> {
        let levels = &mut self.state.levels;
        if result.is_err() && !levels.iter().any(executes) {
            levels.pop_if(|level| level.function().is_some());
        }
        result
    }

    fn run_turn(&mut self, env: &dyn Environment, out: &mut Vec<Issued>) -> Result<Step, Error> {
        let level = self.state.levels.last_mut();
        let turn = match level.map(|l| &mut l.kind) {
            Some(LevelKind::Text(text)) => {
                return match text.take() {
                    Some(text) => self.run_executed(&text, env, out),
                    None => {
                        self.end_executed();
                        Ok(Step::Line)
                    }
                };
            }
            Some(LevelKind::Function(function)) => {
                function.turns += 1;
                let limit = self.state.settings.limits.turns;
                if function.turns > limit {
                    let problem = Problem::FunctionTooLong { name: function.name.clone(), limit };
                    return Err(self.error(problem.into(), &[]));
                }
                function.turn.clone()
            }
            _ => return Ok(Step::Line),
        };
        if self.function().is_ok_and(|f| f.changing.is_some())
            || matches!(turn, Turn::Executing(_) | Turn::Leaving(_))
        {
            return self.go_on(env, out).map_err(|e| self.error(e, &[]));
        }
        if let Turn::Asking(wanted) = turn {
            let level = self.state.levels.last();
            let before = level.map(Before::of).unwrap_or_default();
            let known = core::mem::take(&mut self.hal);
            let asking = Asking::new(env, &known);
            let value = match &wanted {
                Wanted::Name(name) => {
                    let reader = Reader { state: &self.state, environment: &asking };
                    reader.exists(name).then(|| reader.named(name).ok()).flatten()
                }
                Wanted::Slot(number) => env.tool_slot(*number).map(f64::from),
            };
            let missing = asking.missing();
            if !missing.is_empty() {
                return Ok(self.ask_hal(before, missing, known));
            }
            self.turn(Turn::Value(value)).map_err(|p| self.error(p.into(), &[]))?;
        }
        let name = self.state.function().map(|f| f.name.clone()).unwrap_or_default();
        Ok(self.ask(Request::Function { name }))
    }

    fn turn(&mut self, turn: Turn) -> Result<(), Problem> {
        self.function()?.turn = turn;
        Ok(())
    }

    fn ask(&mut self, request: Request) -> Step {
        let pending = Pending { request: request.clone(), block: Block::default(), step: 0 };
        self.state.pending = Some(pending);
        Step::Ask(request)
    }

    /// Runs a line that a function executes.
    fn run_executed(
        &mut self,
        text: &str,
        env: &dyn Environment,
        out: &mut Vec<Issued>,
    ) -> Result<Step, Error> {
        let level = self.state.levels.last();
        let (before, at) = level.map(|l| (Before::of(l), l.cursor)).unwrap_or_default();
        let known = core::mem::take(&mut self.hal);
        let asking = Asking::new(env, &known);
        let result = self.run_text(text.as_bytes(), at, &asking, out);
        let missing = asking.missing();
        if missing.is_empty() {
            return result.map_err(|error| self.error(error, text.as_bytes()));
        }
        // The line is run again with the values.
        if let Some(LevelKind::Text(slot)) = self.state.levels.last_mut().map(|l| &mut l.kind) {
            *slot = Some(text.into());
        }
        Ok(self.ask_hal(before, missing, known))
    }

    /// Ends a line that a function has executed.
    fn end_executed(&mut self) {
        self.state.levels.pop();
        if let Some(level) = self.state.levels.last_mut()
            && let LevelKind::Function(function) = &mut level.kind
        {
            self.state.line = level.cursor.line;
            function.turn = Turn::Executed(None);
        }
    }

    /// Hands the error of a line to the function that executes it, if there is one.
    pub(super) fn tell_function(&mut self, error: Error) -> Result<Step, Error> {
        let Some(at) = self.state.levels.iter().rposition(executes) else { return Err(error) };
        let mut changing = None;
        while self.state.levels.len() > at + 1 {
            let Some(level) = self.state.levels.pop() else { break };
            match level.kind {
                LevelKind::Sub => self.state.numbered.set_locals(&level.saved),
                LevelKind::Function(inner) => {
                    changing = inner.changing.or(changing);
                    if let Some(tool) = inner.stated {
                        self.state.tool = tool;
                    }
                }
                _ => {}
            }
        }
        self.state.pending = None;
        self.remapped = None;
        if let Some(level) = self.state.levels.last_mut()
            && let LevelKind::Function(function) = &mut level.kind
            && let Turn::Executing(text) = &function.turn
        {
            let (line, message) = (self.state.line, error.problem.to_string().into());
            let failure = Failure { line, text: text.clone(), message };
            function.turn = Turn::Executed(Some(failure));
            function.changing = changing.or(function.changing);
            self.state.line = level.cursor.line;
        }
        Ok(Step::Line)
    }

    /// Takes a step of the function that is the innermost level.
    pub(super) fn take_step(
        &mut self,
        answer: &Answer,
        env: &dyn Environment,
        out: &mut Vec<Issued>,
    ) -> Result<Step, Error> {
        let result = match answer {
            Answer::Function(reply) => self.follow(reply, env, out),
            Answer::Failed(reason) => Err(self.failed(reason)),
            _ => Err(Problem::WrongAnswer.into()),
        };
        let result = result.map_err(|error| self.error(error, &[]));
        self.end_failed(result)
    }

    fn failed(&mut self, reason: &str) -> BlockError {
        let name = self.function().map(|f| f.name.clone()).unwrap_or_default();
        Problem::HookFailed { name, reason: reason.into() }.into()
    }

    fn follow(
        &mut self,
        reply: &Reply,
        env: &dyn Environment,
        out: &mut Vec<Issued>,
    ) -> Result<Step, BlockError> {
        for effect in &reply.effects {
            if let Err(problem) = self.effect(effect, env, out) {
                return Err(self.failed(&problem.to_string()));
            }
        }
        let turn = match &reply.next {
            Next::Execute(text) => Turn::Executing(text.clone()),
            Next::Finish => Turn::Finishing,
            Next::Ask(wanted) => Turn::Asking(wanted.clone()),
            Next::Done(value) => Turn::Leaving(*value),
            Next::Fail(reason) => return Err(self.failed(reason)),
        };
        self.turn(turn)?;
        self.go_on(env, out)
    }

    /// Does what the function that is the innermost level has asked for. The end of its tool change comes first, because
    /// the change may have moved the machine.
    fn go_on(&mut self, env: &dyn Environment, out: &mut Vec<Issued>) -> Result<Step, BlockError> {
        let function = self.function()?;
        if let Some(tool) = function.changing.take() {
            return Ok(self.ask(Request::ToolChange { tool }));
        }
        match function.turn.clone() {
            Turn::Executing(text) => {
                if let Some(level) = self.state.levels.last() {
                    let kind = LevelKind::Text(Some(text));
                    let level = Level::new(level.file.clone(), level.cursor, kind);
                    self.state.levels.push(level);
                }
                Ok(Step::Line)
            }
            Turn::Finishing => Ok(self.ask(Request::Finish)),
            Turn::Leaving(_) if function.stated.is_some() => {
                let tool = self.state.tool.number;
                Err(self.failed(&Problem::ToolOnlyStated { tool }.to_string()))
            }
            Turn::Leaving(value) => self.leave_function(value, env, out),
            _ => Ok(Step::Line),
        }
    }

    /// Tells the function that is the innermost level of the end of everything. Returns false if a line has asked.
    pub(super) fn finished(&mut self) -> bool {
        let Ok(function) = self.function() else { return false };
        if function.turn == Turn::Finishing {
            function.turn = Turn::Finished;
        }
        true
    }

    /// Ends the function that is the innermost level, and goes on behind it.
    fn leave_function(
        &mut self,
        value: Option<f64>,
        env: &dyn Environment,
        out: &mut Vec<Issued>,
    ) -> Result<Step, BlockError> {
        let hook = self.function()?.hook;
        let level = self.state.levels.pop();
        let remapped = match hook {
            Hook::Prolog => return Ok(Step::Line),
            Hook::Word => {
                self.state.returned = value;
                return Ok(Step::Line);
            }
            Hook::Body => level.and_then(|l| l.remapped),
            Hook::Epilog => {
                let result = self.end_level(env);
                out.append(&mut self.late);
                result?;
                self.remapped.take()
            }
        };
        remapped.map_or(Ok(Step::Line), |remapped| self.after_remap(&remapped, env, out))
    }
}

/// Returns whether a level is a function that executes a line.
fn executes(level: &Level) -> bool {
    level.function().is_some_and(|f| matches!(f.turn, Turn::Executing(_)))
}
