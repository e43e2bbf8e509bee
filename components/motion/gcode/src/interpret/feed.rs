//! Feed, spindle, coolant and overrides.

use super::{
    Run,
    block::Block,
    codes::{GGroup, MGroup},
};
use crate::{
    canon::{Call, Direction},
    error::Problem,
    question::Request,
    state::FeedMode,
};

impl Run<'_> {
    pub(super) fn feed_mode(&mut self, b: &mut Block) -> Result<Option<Request>, Problem> {
        let (mode, text) = match b.g(GGroup::FeedMode) {
            Some(930) => (FeedMode::InverseTime, "feed mode set to inverse time"),
            Some(940) => (FeedMode::PerMinute, "feed mode set to units per minute"),
            Some(950) => (FeedMode::PerRevolution, "feed mode set to units per revolution"),
            _ => return Ok(None),
        };
        let spindle = self.spindle(b, "G95")?.unwrap_or(0);
        self.note(text)?;
        let per_revolution = mode == FeedMode::PerRevolution;
        self.emit(Call::SetFeedMode { spindle, per_revolution })?;
        if mode != FeedMode::InverseTime {
            self.state.modal.feed = 0.0;
            self.emit(Call::SetFeedRate(0.0))?;
        }
        self.state.modal.feed_mode = mode;
        self.state.modal.feed_spindle = spindle;
        Ok(None)
    }

    pub(super) fn feed_rate(&mut self, b: &mut Block) -> Result<Option<Request>, Problem> {
        let Some(feed) = b.get(b'f') else { return Ok(None) };
        if feed < 0.0 {
            return Err(Problem::NegativeFeed);
        }
        if self.state.modal.feed_mode != FeedMode::InverseTime {
            self.state.modal.feed = feed;
            self.emit(Call::SetFeedRate(feed))?;
        }
        Ok(None)
    }

    /// Returns the spindle that `$` names; `None` stands for all of them.
    pub(crate) fn spindle(&self, b: &Block, with: &'static str) -> Result<Option<u8>, Problem> {
        let Some(n) = b.integer(b'$')? else { return Ok(Some(0)) };
        if n == -1 {
            return Ok(None);
        }
        let count = self.state.modal.spindles.len();
        let n = u8::try_from(n).ok().filter(|n| usize::from(*n) < count);
        n.map(Some).ok_or(Problem::SpindleRange { with })
    }

    fn spindles(&self, one: Option<u8>) -> Vec<u8> {
        let count = u8::try_from(self.state.modal.spindles.len()).unwrap_or(u8::MAX);
        one.map_or_else(|| (0..count).collect(), |n| vec![n])
    }

    pub(super) fn spindle_mode(&mut self, b: &mut Block) -> Result<Option<Request>, Problem> {
        let css = match b.g(GGroup::SpindleMode) {
            Some(960) => true,
            Some(_) => false,
            None => return Ok(None),
        };
        if css && !b.has(b's') {
            return Err(Problem::G96NeedsS);
        }
        let css_max = if css { libm::fabs(b.get(b'd').unwrap_or(1e30)) } else { 0.0 };
        for spindle in self.spindles(self.spindle(b, "G96 or G97")?) {
            self.set_css(spindle, css, css_max)?;
        }
        Ok(None)
    }

    pub(crate) fn set_css(&mut self, spindle: u8, css: bool, css_max: f64) -> Result<(), Problem> {
        if let Some(s) = self.state.modal.spindles.get_mut(usize::from(spindle)) {
            (s.css, s.css_max) = (css, css_max);
        }
        self.emit(Call::SetSpindleMode { spindle, css_max })
    }

    pub(super) fn spindle_speed(&mut self, b: &mut Block) -> Result<Option<Request>, Problem> {
        let Some(speed) = b.get(b's') else { return Ok(None) };
        if speed < 0.0 {
            return Err(Problem::NegativeSpeed);
        }
        for spindle in self.spindles(self.spindle(b, "Spindle speed")?) {
            if let Some(s) = self.state.modal.spindles.get_mut(usize::from(spindle)) {
                s.speed = speed;
            }
            self.emit(Call::SetSpindleSpeed { spindle, speed })?;
        }
        Ok(None)
    }

    pub(crate) fn turn(&mut self, spindle: u8, direction: Direction) -> Result<(), Problem> {
        if let Some(s) = self.state.modal.spindles.get_mut(usize::from(spindle)) {
            s.direction = direction;
        }
        self.emit(Call::TurnSpindle { spindle, direction })
    }

    pub(super) fn turn_spindle(&mut self, b: &mut Block) -> Result<Option<Request>, Problem> {
        let direction = match b.m(MGroup::Spindle) {
            Some(3) => Direction::Clockwise,
            Some(4) => Direction::Counterclockwise,
            Some(5) => Direction::Stopped,
            Some(19) => return self.orient(b).map(|()| None),
            _ => return Ok(None),
        };
        for spindle in self.spindles(self.spindle(b, "M3, M4, M5")?) {
            self.turn(spindle, direction)?;
        }
        Ok(None)
    }

    fn orient(&mut self, b: &Block) -> Result<(), Problem> {
        let degrees = b.get(b'r').unwrap_or(0.0);
        if !(0.0..=360.0).contains(&degrees) {
            return Err(Problem::OrientRange);
        }
        let Ok(mode @ 0..=2) = b.integer(b'p')?.map_or(Ok(0), u8::try_from) else {
            return Err(Problem::OrientMode);
        };
        let degrees = degrees + self.state.settings.orient_offset;
        for spindle in self.spindles(self.spindle(b, "M19")?) {
            if b.has_any(b"rp") {
                self.emit(Call::OrientSpindle { spindle, degrees, mode })?;
            }
            if let Some(timeout) = b.get(b'q') {
                if timeout <= 0.0 {
                    return Err(Problem::OrientTimeout);
                }
                self.emit(Call::WaitSpindleOrient { spindle, timeout })?;
            }
        }
        Ok(())
    }

    pub(super) fn coolant(&mut self, b: &mut Block) -> Result<Option<Request>, Problem> {
        match b.m(MGroup::Coolant) {
            Some(7) => {
                self.state.modal.mist = true;
                self.emit(Call::Mist(true))?;
            }
            Some(8) => {
                self.state.modal.flood = true;
                self.emit(Call::Flood(true))?;
            }
            Some(_) => {
                (self.state.modal.mist, self.state.modal.flood) = (false, false);
                self.emit(Call::Mist(false))?;
                self.emit(Call::Flood(false))?;
            }
            None => {}
        }
        Ok(None)
    }

    pub(super) fn overrides(&mut self, b: &mut Block) -> Result<Option<Request>, Problem> {
        let Some(code) = b.m(MGroup::Override) else { return Ok(None) };
        let on = match code {
            48 => true,
            49 => false,
            _ => b.get(b'p').is_none_or(|p| p != 0.0),
        };
        if self.state.compensation.is_on() {
            let what = if on { "enable" } else { "disable" };
            return Err(Problem::CompOverride { what });
        }
        match code {
            48 | 49 => {
                self.set_feed_override(on)?;
                for spindle in self.spindles(None) {
                    self.set_speed_override(spindle, on)?;
                }
            }
            50 => self.set_feed_override(on)?,
            51 => {
                for spindle in self.spindles(self.spindle(b, "M51")?) {
                    self.set_speed_override(spindle, on)?;
                }
            }
            52 => self.set_adaptive_feed(on)?,
            _ => self.set_feed_hold(on)?,
        }
        Ok(None)
    }

    pub(crate) fn set_adaptive_feed(&mut self, on: bool) -> Result<(), Problem> {
        self.state.modal.adaptive_feed = on;
        self.emit(Call::AdaptiveFeed(on))
    }

    pub(crate) fn set_feed_hold(&mut self, on: bool) -> Result<(), Problem> {
        self.state.modal.feed_hold = on;
        self.emit(Call::FeedHold(on))
    }

    pub(crate) fn set_feed_override(&mut self, on: bool) -> Result<(), Problem> {
        self.state.modal.feed_override = on;
        self.emit(Call::FeedOverride(on))
    }

    pub(crate) fn set_speed_override(&mut self, spindle: u8, on: bool) -> Result<(), Problem> {
        if let Some(s) = self.state.modal.spindles.get_mut(usize::from(spindle)) {
            s.speed_override = on;
        }
        self.emit(Call::SpeedOverride { spindle, on })
    }
}
