//! Realtime. The relation of a path to the spindle that it follows.

use crate::{commands::refusal::Refusal, spindle::Spindle};
use hal_trajectory::Aim;
use libm::{copysign, fabs};

/// Change of a spindle's turns in a period, against the period before, that no spindle makes.
const JUMP: f64 = 0.25;

const JUMPED: Refusal =
    Refusal::new("the turns of the spindle jumped: its encoder has lost the place of its index");
pub(super) const NO_PLACE: Refusal = Refusal::new("the pin revs of the spindle is not a number");

#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) enum Stage {
    /// Waits for the planner, for the spindle's speed, and for the end of a hold.
    #[default]
    Ready,
    /// Waits for the index, since this number of turns.
    Index(f64),
    /// Follows the spindle.
    In,
    /// Tap: follows the reversed spindle out of the hole.
    Out,
    /// Tap: follows until the spindle no longer goes back.
    Above,
    /// Tap: brakes.
    Over,
}

/// Relation of the path to the spindle that it follows.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Tracker {
    pub(super) stage: Stage,
    pub(super) spindle: usize,
    /// Turns of the spindle in the last cycle, and the sign of its turns along the path.
    pub(super) revs: f64,
    pub(super) sign: f64,
    /// Place that belongs to the spindle, and the place along the path.
    pub(super) target: f64,
    pub(super) place: f64,
    /// Velocity that belongs to the spindle, and its turns per second along the path.
    pub(super) turn: f64,
    turns: f64,
    /// Way after which the axes must have caught up with the spindle.
    pub(super) lead_in: f64,
    /// True once they have, or must have.
    pub(super) is_judged: bool,
    /// Tap: commanded speed of the spindle at the start, and the depth.
    pub(super) speed: f64,
    pub(super) depth: f64,
    /// Tap: reason for which it ends outside the hole.
    pub(super) aborted: Option<Refusal>,
}

impl Tracker {
    pub(super) fn error(&self) -> f64 {
        if self.is_judged { self.target - self.place } else { 0.0 }
    }

    /// Begins at the index of the spindle.
    pub(super) fn begin(&mut self, spindle: &Spindle, pitch: f64, depth: f64, lead_in: f64) {
        let inputs = spindle.inputs;
        let way = if spindle.speed() == 0.0 { inputs.speed } else { spindle.speed() };
        self.sign = copysign(1.0, way);
        self.revs = inputs.revs;
        self.target = pitch * self.sign * inputs.revs;
        let turns = self.sign * inputs.speed;
        self.turns = if turns.is_finite() { turns } else { 0.0 };
        self.turn = pitch * self.turns;
        (self.place, self.lead_in, self.is_judged) = (0.0, lead_in, false);
        (self.speed, self.depth) = (spindle.speed(), depth);
        self.stage = Stage::In;
    }

    /// Follows the turns of the spindle since the last cycle.
    pub(super) fn turn(&mut self, revs: f64, pitch: f64, dt: f64) -> Result<(), Refusal> {
        let by = self.sign * (revs - self.revs);
        if !by.is_finite() {
            return Err(NO_PLACE);
        }
        // Turns and not the way: the next move of a thread may have another pitch.
        if fabs(by - self.turns * dt) > JUMP {
            return Err(JUMPED);
        }
        self.revs = revs;
        self.target += pitch * by;
        self.turns = by / dt;
        self.turn = pitch * self.turns;
        Ok(())
    }

    /// Returns the place that belongs to the spindle.
    pub(super) fn aim(&self) -> Aim {
        Aim { distance: self.target - self.place, speed: self.turn }
    }

    /// Turns the spindle round at the bottom and above the start of a tap.
    pub(super) fn tap(&mut self, spindle: &mut Spindle, back: f64, rests: bool) {
        match self.stage {
            Stage::In if self.depth <= self.place || self.aborted.is_some() => {
                spindle.turn_round(-self.speed * back);
                self.stage = Stage::Out;
            }
            Stage::Out if self.place <= 0.0 => {
                if self.aborted.is_some() {
                    spindle.stop("aborted");
                } else {
                    spindle.turn_round(self.speed);
                }
                self.stage = Stage::Above;
            }
            // At rest above the start, a limit ends the way.
            Stage::Above if 0.0 <= self.turn || rests => self.stage = Stage::Over,
            _ => {}
        }
    }
}
