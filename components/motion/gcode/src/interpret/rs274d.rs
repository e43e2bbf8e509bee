//! Programs in RS274-D: a line's commands, one after the other, as blocks of the interpreter.
//!
//! G20, G21, G90 and G91 act where they stand. A word belongs to the last command before it that takes words; words
//! without one repeat the last of G00 to G03.

mod bounds;
mod table;

use super::{
    BlockError, BlockErrorAt, Interpreter, Run, Step,
    block::Block,
    codes::{GGroup, MGroup},
    read::{NoFiles, located},
};
use crate::{
    axis::{Axis, Position},
    canon::{Call, Issued, Unit},
    environment::Environment,
    error::Problem,
    text::{
        expression::Left,
        rs274d::{Item, parse, upper},
    },
};
use table::{COMMANDS, MODES, meaning};

/// The motion before the first of G00 to G03.
const NO_MOTION: u16 = 800;
/// The largest number of a command.
const LAST_CODE: f64 = 99.0;

/// A command whose words are being read.
#[derive(Default)]
struct Open {
    /// Ten times the G code; `None` repeats the last motion.
    code: Option<u16>,
    at: usize,
    words: Vec<Item>,
}

impl Open {
    fn is_empty(&self) -> bool {
        self.code.is_none() && self.words.is_empty()
    }
}

fn here(at: usize) -> impl Fn(Problem) -> BlockError {
    move |problem| BlockError { at: BlockErrorAt::Raw(at), problem }
}

/// Returns the place of a byte as blocks write it: the bytes from it to the end of the line.
fn left_of(length: usize, at: usize) -> Left {
    Left::try_from(length.saturating_sub(at)).unwrap_or(Left::MAX)
}

/// Gives a problem of a block its place on the line.
fn placed(error: BlockError, length: usize, at: usize) -> BlockError {
    let at = match error.at {
        BlockErrorAt::Left(left) => length.saturating_sub(usize::try_from(left).unwrap_or(0)),
        BlockErrorAt::Raw(byte) => byte,
        BlockErrorAt::Line => at,
    };
    BlockError { at: BlockErrorAt::Raw(at), problem: error.problem }
}

impl Interpreter {
    /// Runs a line of a program in RS274-D.
    pub(super) fn run_rs274d(
        &mut self,
        raw: &[u8],
        env: &dyn Environment,
        out: &mut Vec<Issued>,
    ) -> Result<Step, BlockError> {
        let limit = self.state.settings.limits.line_length;
        if raw.len() > limit {
            return Err(Problem::LineTooLong { limit }.into());
        }
        let line = parse(raw).map_err(|(at, problem)| here(at)(problem))?;
        let file = self.state.levels.last().map(|l| l.file.clone()).unwrap_or_default();
        let run = Run::new(&mut self.state, env, out);
        let mut program = Program { run, file, length: raw.len() };
        program.run.number = line.number;
        program.run.begin_rs274d()?;
        program.line(&line.items)?;
        Ok(if self.state.ended { Step::Ended } else { Step::Line })
    }

    /// Ends a program in RS274-D at the end of its file.
    pub(super) fn end_rs274d(&mut self, out: &mut Vec<Issued>) -> Result<Step, BlockError> {
        let mut run = Run::new(&mut self.state, &NoFiles, out);
        run.begin_rs274d()?;
        run.leave_rs274d()?;
        run.end(false)?;
        Ok(Step::Ended)
    }
}

/// The run of a line.
struct Program<'a> {
    run: Run<'a>,
    file: Box<str>,
    /// The length of the line in bytes.
    length: usize,
}

impl Program<'_> {
    fn line(&mut self, items: &[Item]) -> Result<(), BlockError> {
        let mut open = Open::default();
        for item in items {
            let at = here(item.at);
            match item.letter {
                b'g' => self.g_code(item, &mut open)?,
                b'm' if matches!(item.value, 0.0 | 1.0 | 2.0 | 30.0) => {
                    self.close(&mut open)?;
                    self.stop(item)?;
                    if self.run.state.ended {
                        return Ok(());
                    }
                }
                b'm' => {
                    let name = format!("M{:02}", item.value);
                    if item.value > LAST_CODE {
                        return Err(at(Problem::NotInDialect { what: name.into() }));
                    }
                    self.warn(&format!("{name} is ignored: RS274-D has M00, M01, M02 and M30"))
                        .map_err(at)?;
                }
                b's' => self.warn("S is ignored: RS274-D sets no spindle speed").map_err(at)?,
                b't' => self.warn("T is ignored: RS274-D changes no tool").map_err(at)?,
                letter => {
                    if open.words.iter().any(|w| w.letter == letter) {
                        return Err(at(Problem::MultipleWords { letter: char::from(letter) }));
                    }
                    if open.is_empty() {
                        open.at = item.at;
                    }
                    open.words.push(*item);
                }
            }
        }
        self.close(&mut open)
    }

    fn g_code(&mut self, item: &Item, open: &mut Open) -> Result<(), BlockError> {
        let unknown = || {
            let name = format!("G{:02}", item.value);
            let what = meaning(item.value).map_or(name.clone(), |m| format!("{name} ({m})"));
            here(item.at)(Problem::NotInDialect { what: what.into() })
        };
        if item.value > LAST_CODE {
            return Err(unknown());
        }
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "0 to 99")]
        let code = (item.value * 10.0) as u16;
        if MODES.contains(&code) {
            if !open.words.is_empty() {
                self.close(open)?;
            }
            return self.block(code, item.at, &[]);
        }
        if !COMMANDS.iter().any(|c| c.code == code) {
            return Err(unknown());
        }
        self.close(open)?;
        *open = Open { code: Some(code), at: item.at, words: Vec::new() };
        Ok(())
    }

    /// Runs the open command with its words.
    fn close(&mut self, open: &mut Open) -> Result<(), BlockError> {
        let Open { code, at, mut words } = core::mem::take(open);
        if code.is_none() && words.is_empty() {
            return Ok(());
        }
        let code = code.unwrap_or(self.run.state.modal.motion);
        self.feed(&mut words)?;
        if code == NO_MOTION {
            let Some(first) = words.first() else { return Ok(()) };
            return Err(here(first.at)(Problem::AxisWithoutCode));
        }
        let Some(command) = COMMANDS.iter().find(|c| c.code == code) else { return Ok(()) };
        if let Some(word) = words.iter().find(|w| !command.words.contains(&w.letter)) {
            return Err(here(word.at)(Problem::WordNotOfCommand {
                letter: upper(word.letter),
                command: command.name,
                words: command.shown,
            }));
        }
        match code {
            0 | 10 if words.is_empty() => {
                self.run.state.modal.motion = code;
                Ok(())
            }
            40 => self.dwell(at, &words),
            280 => self.home(at, &words),
            290 => self.back(at, &words),
            920 => self.block(code, at, &words),
            _ => {
                let words = self.rise(code, words)?;
                if code != 0 {
                    self.default_feed().map_err(here(at))?;
                }
                self.block(code, at, &words)
            }
        }
    }

    /// Sets the feed that a command states, which stays in force whatever the command is.
    fn feed(&mut self, words: &mut Vec<Item>) -> Result<(), BlockError> {
        let Some(index) = words.iter().position(|w| w.letter == b'f') else { return Ok(()) };
        let word = words.remove(index);
        let at = here(word.at);
        if word.value == 0.0 {
            return Err(at(Problem::FeedZero));
        }
        let mut block = Block::default();
        block.set(b'f', Some(word.value));
        self.run.feed_rate(&mut block).map(drop).map_err(at)
    }

    /// Sets the machine's feed for a program that states none.
    fn default_feed(&mut self) -> Result<(), Problem> {
        if self.run.state.modal.feed != 0.0 {
            return Ok(());
        }
        let unit = self.run.state.frame.unit;
        let feed = self.run.state.settings.default_feed / unit.millimetres();
        let shown = match unit {
            Unit::Inch => "in",
            Unit::Millimetre => "mm",
        };
        self.warn(&format!("no feed is programmed: moves run at {feed:.4} {shown}/min"))?;
        self.run.state.modal.feed = feed;
        self.run.emit(Call::SetFeedRate(feed))
    }

    /// Replaces K of an arc, the rise from its start, by the Z of its end.
    fn rise(&self, code: u16, mut words: Vec<Item>) -> Result<Vec<Item>, BlockError> {
        let Some(index) = words.iter().position(|w| w.letter == b'k').filter(|_| code >= 20) else {
            return Ok(words);
        };
        let k = words.remove(index);
        let absolute = self.run.state.modal.absolute;
        let start = if absolute { self.run.programmed().z } else { 0.0 };
        match words.iter().find(|w| w.letter == b'z') {
            None => words.push(Item { letter: b'z', value: start + k.value, at: k.at }),
            Some(z) if k.value == 0.0 || (z.value - start - k.value).abs() < 1e-6 => {}
            Some(_) => return Err(here(k.at)(Problem::ArcRise)),
        }
        Ok(words)
    }

    fn dwell(&mut self, at: usize, words: &[Item]) -> Result<(), BlockError> {
        let value = |letter| words.iter().find(|w| w.letter == letter);
        let (word, seconds) = match (value(b'x'), value(b'p')) {
            (Some(_), Some(p)) => return Err(here(p.at)(Problem::DwellBoth)),
            (None, None) => return Err(here(at)(Problem::DwellTimeOrX)),
            (Some(x), None) => (x, x.value),
            (None, Some(p)) => (p, p.value / 1000.0),
        };
        if seconds < 0.0 {
            return Err(here(word.at)(Problem::NegativeWord { letter: upper(word.letter) }));
        }
        self.run.emit(Call::Dwell(seconds)).map_err(here(at))
    }

    /// Runs G28: through a point, which it remembers, to the origin of the program.
    fn home(&mut self, at: usize, words: &[Item]) -> Result<(), BlockError> {
        if !words.is_empty() {
            let via = self.traverse(at, words)?;
            self.run.state.rs274d.via = Some(self.run.state.frame.machine_mm(via));
        }
        let mut home = self.run.state.position;
        for axis in [Axis::X, Axis::Y, Axis::Z] {
            home[axis] = 0.0;
        }
        self.run.emit(Call::StraightTraverse(home)).map_err(here(at))?;
        self.run.state.position = home;
        Ok(())
    }

    /// Runs G29: through the point of the last G28 to a point.
    fn back(&mut self, at: usize, words: &[Item]) -> Result<(), BlockError> {
        if words.is_empty() {
            return Err(here(at)(Problem::AxesMissing));
        }
        let Some(via) = self.run.state.rs274d.via else {
            return Err(here(at)(Problem::NoPointToReturn));
        };
        let frame = &self.run.state.frame;
        let via = frame.program(via.scaled(1.0 / frame.unit.millimetres()));
        self.run.emit(Call::StraightTraverse(via)).map_err(here(at))?;
        self.run.state.position = via;
        self.traverse(at, words).map(drop)
    }

    /// Moves to the end that the words state, at rapid feed.
    fn traverse(&mut self, at: usize, words: &[Item]) -> Result<Position, BlockError> {
        let block = self.words(None, at, words)?;
        self.run.check_axes(&block).map_err(here(at))?;
        let end = self.run.target(&block).map_err(here(at))?;
        self.run.emit(Call::StraightTraverse(end)).map_err(here(at))?;
        self.run.state.position = end;
        Ok(end)
    }

    /// Pauses or ends the program.
    fn stop(&mut self, item: &Item) -> Result<(), BlockError> {
        let at = here(item.at);
        let mut block = Block::default();
        block.add(b'm', 0, item.value, &[]).map_err(&at)?;
        if matches!(block.m(MGroup::Stop), Some(2 | 30)) {
            self.run.leave_rs274d().map_err(&at)?;
        }
        self.run.stop(&mut block).map(drop).map_err(at)
    }

    /// Returns a block of these words.
    fn words(&self, code: Option<u16>, at: usize, words: &[Item]) -> Result<Block, BlockError> {
        let mut block = Block::default();
        if let Some(code) = code {
            let left = left_of(self.length, at);
            block.add(b'g', left, f64::from(code) / 10.0, &[]).map_err(here(at))?;
        }
        for word in words {
            let left = left_of(self.length, word.at);
            block.add(word.letter, left, word.value, &[]).map_err(here(word.at))?;
        }
        Ok(block)
    }

    /// Runs a block that is the same in LinuxCNC's language.
    fn block(&mut self, code: u16, at: usize, words: &[Item]) -> Result<(), BlockError> {
        let mut block = self.words(Some(code), at, words)?;
        let asked = self.run.prepare(&mut block).and_then(|()| self.run.execute(&mut block, 0));
        let focus = self.run.focus.take().or_else(|| block.g_place(GGroup::Motion));
        let asked = asked.map_err(|p| placed(located(p, &block, focus), self.length, at))?;
        debug_assert!(asked.is_none(), "no block of RS274-D asks the machine");
        Ok(())
    }

    /// Tells the operator something once in a program.
    fn warn(&mut self, text: &str) -> Result<(), Problem> {
        if !self.run.state.rs274d.warned.insert(text.into()) {
            return Ok(());
        }
        let text = format!("{}:{}: warning: {text}", self.file, self.run.line);
        self.run.emit(Call::Message(text.into()))
    }
}
