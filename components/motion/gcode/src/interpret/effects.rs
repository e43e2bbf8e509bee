//! Effects of functions of another language: parameters, fields of the interpreter, canonical calls.

use super::{Interpreter, Run};
use crate::{
    axis::{Axis, Position},
    canon::{Call, Direction, Issued, Plane},
    environment::Environment,
    error::Problem,
    function::{CallWord, Effect, Function},
    parameters::{check_writable, set_name, system},
    state::{FeedMode, LevelKind},
    tool::Tool,
};

impl Interpreter {
    /// Applies an effect.
    pub(super) fn effect(
        &mut self,
        effect: &Effect,
        env: &dyn Environment,
        out: &mut Vec<Issued>,
    ) -> Result<(), Problem> {
        match effect {
            Effect::Number(index, value) => {
                check_writable(*index)?;
                self.state.numbered.put(*index, *value);
                Ok(())
            }
            Effect::Name(name, value) => {
                if system::is_system(&self.state, name) {
                    return Err(Problem::NamedReadOnly { name: name.clone() });
                }
                match self.state.scope_mut() {
                    Some(level) if !name.starts_with('_') => {
                        set_name(&mut level.locals, name, *value)
                    }
                    _ => set_name(&mut self.state.globals, name, *value),
                }
            }
            Effect::Field(name, value) => Run::new(&mut self.state, env, out).field(name, *value),
            Effect::Call(name, words) => {
                let spindles = self.state.modal.spindles.len();
                let mut run = Run::new(&mut self.state, env, out);
                run.function_call(name, &Words { name, words, spindles })
            }
        }
    }
}

/// The arguments of a canonical call.
struct Words<'a> {
    name: &'a str,
    words: &'a [CallWord],
    /// The number of spindles.
    spindles: usize,
}

impl Words<'_> {
    fn wrong(&self) -> Problem {
        Problem::CallWords { name: self.name.into() }
    }

    fn number(&self, at: usize) -> Result<f64, Problem> {
        match self.words.get(at) {
            Some(CallWord::Number(n)) if n.is_finite() => Ok(*n),
            _ => Err(self.wrong()),
        }
    }

    fn text(&self) -> Result<Box<str>, Problem> {
        match self.words.first() {
            Some(CallWord::Text(text)) => Ok(text.clone()),
            _ => Err(self.wrong()),
        }
    }

    fn integer(&self, at: usize) -> Result<i32, Problem> {
        crate::text::evaluate::integer(self.number(at)?).map_err(|_| self.wrong())
    }

    fn index(&self, at: usize) -> Result<u32, Problem> {
        u32::try_from(self.integer(at)?).map_err(|_| self.wrong())
    }

    /// Returns nine coordinates.
    fn position(&self, first: usize) -> Result<Position, Problem> {
        let mut out = Position::default();
        for (n, axis) in Axis::ALL.into_iter().enumerate() {
            out[axis] = self.number(first + n)?;
        }
        Ok(out)
    }

    /// Returns the spindle and the value of a call whose spindle may be left out.
    fn of_spindle(&self) -> Result<(u8, f64), Problem> {
        if self.words.len() < 2 {
            return Ok((0, self.number(0)?));
        }
        Ok((self.spindle(0)?, self.number(1)?))
    }

    fn spindle(&self, at: usize) -> Result<u8, Problem> {
        if self.words.len() <= at {
            return Ok(0);
        }
        let spindle = u8::try_from(self.integer(at)?).ok();
        spindle.filter(|n| usize::from(*n) < self.spindles).ok_or_else(|| self.wrong())
    }
}

/// Returns the plane of a number that functions know.
fn plane(number: i32) -> Option<Plane> {
    let all = [Plane::Xy, Plane::Yz, Plane::Xz, Plane::Uv, Plane::Vw, Plane::Uw];
    usize::try_from(number).ok()?.checked_sub(1).and_then(|n| all.get(n)).copied()
}

impl Run<'_> {
    /// Sets a field of the interpreter.
    fn field(&mut self, name: &str, value: f64) -> Result<(), Problem> {
        let fixed = || Problem::FieldFixed { name: name.into() };
        let number = crate::text::evaluate::integer(value);
        let modal = &mut self.state.modal;
        match name {
            "feed_rate" => modal.feed = value,
            "return_value" => self.state.returned = Some(value),
            "value_returned" if value == 0.0 => self.state.returned = None,
            "value_returned" => {}
            "selected_tool" => self.state.selected = Some(number?).filter(|n| *n >= 0),
            "current_tool" => {
                let new = self.tool(number?.max(0))?;
                if new.number != self.state.tool.number {
                    let old = core::mem::replace(&mut self.state.tool, new);
                    if let Some(function) = self.function() {
                        function.stated.get_or_insert(old);
                    }
                }
            }
            "motion_mode" => {
                modal.motion = u16::try_from(number?).map_err(|_| fixed())?;
            }
            "distance_mode" => modal.absolute = value == 0.0,
            "ijk_distance_mode" => modal.ijk_absolute = value == 0.0,
            "retract_mode" => modal.retract_old = value != 0.0,
            "feed_mode" => {
                modal.feed_mode = match number? {
                    0 => FeedMode::PerMinute,
                    1 => FeedMode::InverseTime,
                    2 => FeedMode::PerRevolution,
                    _ => return Err(fixed()),
                };
            }
            "plane" => modal.plane = plane(number?).ok_or_else(fixed)?,
            _ => {
                let spindle = name.strip_prefix("speed.").and_then(|n| n.parse::<usize>().ok());
                let spindle = spindle.and_then(|n| modal.spindles.get_mut(n));
                spindle.ok_or_else(fixed)?.speed = value;
            }
        }
        Ok(())
    }

    /// Makes a canonical call.
    fn function_call(&mut self, name: &str, words: &Words<'_>) -> Result<(), Problem> {
        let call = match name {
            "MESSAGE" | "CANON_ERROR" => Call::Message(words.text()?),
            "COMMENT" => Call::Comment(words.text()?),
            "LOG" => Call::Log(words.text()?),
            "LOGOPEN" => Call::LogOpen { name: words.text()?, append: false },
            "LOGAPPEND" => Call::LogOpen { name: words.text()?, append: true },
            "LOGCLOSE" => Call::LogClose,
            "DWELL" => Call::Dwell(words.number(0)?.max(0.0)),
            "STRAIGHT_TRAVERSE" | "STRAIGHT_FEED" | "STRAIGHT_PROBE" => {
                return self.function_move(name, words.position(1)?);
            }
            "ARC_FEED" => return self.function_arc(words),
            "SET_FEED_RATE" => {
                self.state.modal.feed = words.number(0)?;
                Call::SetFeedRate(self.state.modal.feed)
            }
            "SET_SPINDLE_SPEED" => {
                let (spindle, speed) = words.of_spindle()?;
                if let Some(s) = self.state.modal.spindles.get_mut(usize::from(spindle)) {
                    s.speed = speed;
                }
                Call::SetSpindleSpeed { spindle, speed }
            }
            "SET_SPINDLE_MODE" => {
                let (spindle, css_max) = words.of_spindle()?;
                if let Some(s) = self.state.modal.spindles.get_mut(usize::from(spindle)) {
                    (s.css, s.css_max) = (css_max > 0.0, css_max.max(0.0));
                }
                Call::SetSpindleMode { spindle, css_max }
            }
            "SET_FEED_MODE" => {
                let (spindle, per_revolution) = (words.spindle(0)?, words.number(1)? != 0.0);
                let modal = &mut self.state.modal;
                modal.feed_spindle = spindle;
                modal.feed_mode = match (per_revolution, modal.feed_mode) {
                    (true, _) => FeedMode::PerRevolution,
                    // The call is the same for G93 and G94.
                    (false, FeedMode::InverseTime) => FeedMode::InverseTime,
                    (false, _) => FeedMode::PerMinute,
                };
                Call::SetFeedMode { spindle, per_revolution }
            }
            "START_SPINDLE_CLOCKWISE" => return self.turn(words.spindle(0)?, Direction::Clockwise),
            "START_SPINDLE_COUNTERCLOCKWISE" => {
                return self.turn(words.spindle(0)?, Direction::Counterclockwise);
            }
            "STOP_SPINDLE_TURNING" => return self.turn(words.spindle(0)?, Direction::Stopped),
            "MIST_ON" | "MIST_OFF" => {
                self.state.modal.mist = name == "MIST_ON";
                Call::Mist(self.state.modal.mist)
            }
            "FLOOD_ON" | "FLOOD_OFF" => {
                self.state.modal.flood = name == "FLOOD_ON";
                Call::Flood(self.state.modal.flood)
            }
            "ENABLE_FEED_OVERRIDE" | "DISABLE_FEED_OVERRIDE" => {
                return self.set_feed_override(name.starts_with('E'));
            }
            "ENABLE_SPEED_OVERRIDE" | "DISABLE_SPEED_OVERRIDE" => {
                return self.set_speed_override(words.spindle(0)?, name.starts_with('E'));
            }
            "ENABLE_ADAPTIVE_FEED" | "DISABLE_ADAPTIVE_FEED" => {
                self.state.modal.adaptive_feed = name.starts_with('E');
                Call::AdaptiveFeed(self.state.modal.adaptive_feed)
            }
            "ENABLE_FEED_HOLD" | "DISABLE_FEED_HOLD" => {
                self.state.modal.feed_hold = name.starts_with('E');
                Call::FeedHold(self.state.modal.feed_hold)
            }
            "SET_MOTION_OUTPUT_BIT"
            | "CLEAR_MOTION_OUTPUT_BIT"
            | "SET_AUX_OUTPUT_BIT"
            | "CLEAR_AUX_OUTPUT_BIT" => Call::DigitalOutput {
                index: words.index(0)?,
                on: name.starts_with('S'),
                with_motion: name.contains("MOTION"),
            },
            "SET_MOTION_OUTPUT_VALUE" | "SET_AUX_OUTPUT_VALUE" => Call::AnalogOutput {
                index: words.index(0)?,
                value: words.number(1)?,
                with_motion: name.contains("MOTION"),
            },
            "SELECT_TOOL" => {
                let number = words.integer(0)?.max(0);
                self.tool(number)?;
                self.state.selected = Some(number);
                Call::SelectTool(number)
            }
            "START_CHANGE" => Call::StartChange,
            "CHANGE_TOOL" => return self.function_change(words.integer(0)?),
            "CHANGE_TOOL_NUMBER" => {
                let number = words.integer(0)?.max(0);
                self.state.tool = self.tool(number)?;
                if let Some(function) = self.function() {
                    function.stated = None;
                }
                Call::ChangeToolNumber(number)
            }
            "SELECT_PLANE" => {
                let plane = plane(words.integer(0)?).ok_or_else(|| words.wrong())?;
                self.state.modal.plane = plane;
                Call::SelectPlane(plane)
            }
            "PROGRAM_STOP" => Call::ProgramStop,
            "OPTIONAL_PROGRAM_STOP" => Call::OptionalProgramStop,
            _ => return Err(Problem::CallUnknown { name: name.into() }),
        };
        self.emit(call)
    }

    /// Makes a straight move; the interpreter's place follows.
    fn function_move(&mut self, name: &str, end: Position) -> Result<(), Problem> {
        if self.state.compensation.is_on() {
            return Err(Problem::CompMotion {
                what: "Cannot make canonical moves with cutter radius compensation on",
            });
        }
        let call = match name {
            "STRAIGHT_TRAVERSE" => Call::StraightTraverse(end),
            "STRAIGHT_FEED" => Call::StraightFeed(end),
            _ => return Err(Problem::CallUnknown { name: name.into() }),
        };
        self.emit(call)?;
        self.state.position = end;
        Ok(())
    }

    /// Makes an arc: line, end and centre in the order of the plane, turns, end across, further axes.
    fn function_arc(&mut self, words: &Words<'_>) -> Result<(), Problem> {
        if self.state.compensation.is_on() {
            return Err(Problem::CompMotion {
                what: "Cannot make canonical moves with cutter radius compensation on",
            });
        }
        let plane = self.state.modal.plane;
        let (first, second, across) = plane.axes();
        let mut end = self.state.position;
        (end[first], end[second], end[across]) =
            (words.number(1)?, words.number(2)?, words.number(6)?);
        for (n, axis) in Axis::ALL.into_iter().skip(3).enumerate() {
            if ![first, second, across].contains(&axis) {
                end[axis] = words.number(7 + n)?;
            }
        }
        let (centre_first, centre_second) = (words.number(3)?, words.number(4)?);
        let turns = words.integer(5)?;
        self.emit(Call::ArcFeed { plane, end, centre_first, centre_second, turns })?;
        self.state.position = end;
        Ok(())
    }

    /// Orders a tool change, whose end the function learns before anything else.
    fn function_change(&mut self, number: i32) -> Result<(), Problem> {
        let number = number.max(0);
        let tool: Tool = self.tool(number)?;
        self.emit(Call::ChangeTool(number))?;
        let mut old = core::mem::replace(&mut self.state.tool, tool);
        if let Some(function) = self.function() {
            function.changing = Some(number);
            old = function.stated.take().unwrap_or(old);
        }
        if self.state.settings.random_changer {
            self.swap_pockets(old);
        }
        Ok(())
    }

    /// Returns the function that is the innermost level.
    fn function(&mut self) -> Option<&mut Function> {
        match self.state.levels.last_mut().map(|l| &mut l.kind) {
            Some(LevelKind::Function(function)) => Some(function),
            _ => None,
        }
    }
}
