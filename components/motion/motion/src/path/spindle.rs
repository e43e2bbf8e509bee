//! Realtime. Moves that follow a spindle: threads, and rigid taps with their way back.

use super::{
    Live, Path,
    drive::Pace,
    lead::Plan,
    order::Item,
    tracker::{NO_PLACE, Stage, Tracker},
};
use crate::{
    commands::command::{Follows, Sync},
    commands::refusal::Refusal,
    spindle::Spindle,
    state::State,
};
use hal_component::{MotionSource, TicketHandle};
use hal_trajectory::{Limits, Pursuit, Scales, Shape, Step, Tops};
use libm::fabs;

/// Turns of a spindle after which its index is late.
const INDEX_TURNS: f64 = 3.0;

/// Turns of a spindle for which a tap may overrun its depth and its start.
pub(crate) const OVERRUN_TURNS: f64 = 10.0;

/// Distance at which the axes count as together with the spindle, besides a period's travel.
const TOGETHER: f64 = 1e-6;

/// Largest number of moves whose lengths count as the rest of a thread; more of them are long enough.
const MOST_MOVES: usize = 16;

const NO_INDEX: Refusal = Refusal::new("the spindle turned three times without its index");
const STANDS: Refusal = Refusal::new("a tap needs a spindle that turns");
const OVERRUN: Refusal =
    Refusal::new("the spindle still turned ten turns beyond the end of the tap, or at a limit");
const BACKED: Refusal = Refusal::new(
    "the spindle turned ten turns back from the start of the tap, against its command",
);
const FAR: Refusal =
    Refusal::new("the axes are farther from their place at the spindle than its sync-error");

/// Kind of a path.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) enum Course {
    /// Moves at their own feed.
    #[default]
    Free,
    /// Moves that follow this spindle.
    Thread(usize),
    /// The tap with this number.
    Tap(u32),
}

impl Course {
    /// Returns the kind of path that a move needs.
    pub(super) fn of(id: u32, sync: Option<Sync>) -> Self {
        match sync {
            Some(Sync { follows: Follows::Place, spindle, .. }) => Self::Thread(spindle),
            Some(Sync { follows: Follows::Tap { .. }, .. }) => Self::Tap(id),
            Some(Sync { follows: Follows::Speed, .. }) | None => Self::Free,
        }
    }
}

const WAITS: Pace = Pace { goal: Pursuit::Rest, waits: true };

impl Path {
    /// Returns the spindle that the path in progress follows.
    fn bound(&self) -> Option<Sync> {
        if self.live != Live::Follows || self.stop.is_some() {
            return None;
        }
        let front = self.pending.front()?;
        let Item::Move(order) = front.item else { return None };
        let is_bound =
            self.course != Course::Free && Course::of(front.id, order.sync) == self.course;
        order.sync.filter(|_| is_bound)
    }

    /// Returns the motion of this cycle.
    fn pace(
        &mut self,
        spindle: &mut Spindle,
        sync: &Sync,
        ready: bool,
        dt: f64,
    ) -> Result<Pace, Refusal> {
        if self.sent == 0 {
            // The planner does not have the move yet.
            return Ok(WAITS);
        }
        let depth = self.tap_depth();
        let [length, steepest] = self.length_left(depth, sync.pitch);
        let Some(session) = &mut self.session else { return Ok(WAITS) };
        let is_at_end = session.is_done();
        let limits = session.limits().unwrap_or(Limits::NONE);
        let plan = Plan::new(spindle, sync, limits, length, dt);
        let t = &mut self.tracker;
        t.spindle = sync.spindle;
        let is_tap = matches!(sync.follows, Follows::Tap { .. });
        let inputs = spindle.inputs;
        match t.stage {
            Stage::Ready => {
                if ready && !is_at_end {
                    if is_tap && spindle.speed() == 0.0 {
                        return Err(STANDS);
                    }
                    plan.check_speed(steepest)?;
                    t.stage = Stage::Index(inputs.revs);
                }
                return Ok(WAITS);
            }
            Stage::Index(_) if !ready => {
                t.stage = Stage::Ready;
                return Ok(WAITS);
            }
            Stage::Index(from) if inputs.index_enable => {
                let turned = fabs(inputs.revs - from);
                return if turned <= INDEX_TURNS {
                    Ok(WAITS)
                } else {
                    Err(if turned.is_nan() { NO_PLACE } else { NO_INDEX })
                };
            }
            Stage::Index(_) if !inputs.revs.is_finite() => return Err(NO_PLACE),
            Stage::Index(_) => {
                plan.check_speed(steepest)?;
                plan.check_length()?;
                t.begin(spindle, sync.pitch, depth, plan.lead_in());
            }
            Stage::In | Stage::Out | Stage::Above | Stage::Over => {
                t.turn(inputs.revs, sync.pitch, dt)?;
            }
        }
        t.is_judged |= t.target >= t.lead_in;
        let is_in_cut = match sync.follows {
            Follows::Tap { .. } => matches!(t.stage, Stage::In | Stage::Out) && t.aborted.is_none(),
            Follows::Place | Follows::Speed => plan.is_in_cut(fabs(t.turn)),
        };
        if is_in_cut && fabs(t.error()) > spindle.config.sync_error {
            return Err(FAR);
        }
        if let Follows::Tap { back } = sync.follows {
            if is_at_end && t.turn > 0.0 {
                return Err(OVERRUN);
            }
            if t.stage == Stage::In && t.target < -OVERRUN_TURNS * sync.pitch {
                return Err(BACKED);
            }
            t.tap(spindle, back, self.last.travel == 0.0);
        }
        if t.stage == Stage::Over {
            return Ok(Pace { goal: Pursuit::Rest, waits: false });
        }
        // A thread never goes back.
        let goal = if is_tap { Pursuit::Both(t.aim()) } else { Pursuit::Forward(t.aim()) };
        Ok(Pace { goal, waits: false })
    }

    /// Returns the length that is left of a tap of this depth, or of the thread: of all its moves that wait, which is as long as
    /// needed where they are many. With it the largest pitch of these moves.
    fn length_left(&self, depth: f64, pitch: f64) -> [f64; 2] {
        if matches!(self.course, Course::Tap(_)) {
            return [depth, pitch];
        }
        let mut from = self.last.pose;
        let moves = self.pending.iter().filter_map(|pending| match &pending.item {
            Item::Move(order) => Some((pending, order)),
            Item::Output(_) => None,
        });
        let thread =
            moves.take_while(|(pending, order)| Course::of(pending.id, order.sync) == self.course);
        let (mut length, mut pitch) = (0.0, pitch);
        for (n, (pending, order)) in thread.enumerate() {
            if n == MOST_MOVES {
                length = f64::INFINITY;
                break;
            }
            let end = hal_trajectory::Pose(pending.end);
            length += (end - from).norm(hal_trajectory::Group::Xyz);
            from = end;
            pitch = order
                .sync
                .map_or(pitch, |sync| if pitch < sync.pitch { sync.pitch } else { pitch });
        }
        [length, pitch]
    }

    /// Returns the depth of the tap that is next.
    fn tap_depth(&self) -> f64 {
        let Some(front) = self.pending.front() else { return 0.0 };
        let Item::Move(order) = front.item else { return 0.0 };
        let Shape::Line { end } = order.shape else { return 0.0 };
        (end - hal_trajectory::Pose(front.end)).norm(hal_trajectory::Group::Xyz)
    }

    /// Keeps the place along the path after a cycle, and ends a tap that is over.
    pub(super) fn keep_pace(&mut self, step: &Step) {
        let t = &mut self.tracker;
        t.place += step.travel;
        t.is_judged |= fabs(t.target - t.place) <= fabs(step.travel) + TOGETHER;
        if t.stage == Stage::Over && !step.moving {
            self.end_tap();
        }
    }

    /// Ends a tap outside its hole: what is left is the way back to its start.
    fn end_tap(&mut self) {
        let Tracker { aborted, speed, .. } = self.tracker;
        if let Some(why) = aborted {
            return self.clear(why);
        }
        if let Some(front) = self.pending.front_mut()
            && let Item::Move(order) = &mut front.item
        {
            order.shape = Shape::Line { end: hal_trajectory::Pose(front.end) };
            let pitch = order.sync.take().map_or(1.0, |s| s.pitch);
            order.feed = fabs(speed) / 60.0 * pitch;
        }
        self.begin_anew();
    }

    /// Takes a tap out of its hole, and then ends the path. Returns the spindle, if there is such a tap.
    pub(crate) fn abort_tap(&mut self, why: Refusal) -> Option<usize> {
        let t = &self.tracker;
        let is_inside = !matches!(t.stage, Stage::Ready | Stage::Index(_));
        if !matches!(self.course, Course::Tap(_)) || !is_inside || t.aborted.is_some() {
            return None;
        }
        let refuse = |ticket: Option<TicketHandle>| ticket.into_iter().for_each(|t| why.fail(t));
        while self.pending.len() > 1 {
            refuse(self.pending.pop_back().and_then(|p| p.ticket));
        }
        self.tracker.aborted = Some(why);
        Some(self.tracker.spindle)
    }

    /// Returns whether a tap is on its way out to end the path.
    pub(super) const fn leaves_hole(&self) -> bool {
        self.tracker.aborted.is_some()
    }

    /// Returns whether a move follows a spindle now.
    pub(super) const fn is_bound(&self) -> bool {
        !matches!(self.tracker.stage, Stage::Ready)
    }

    /// Returns the spindle whose index the path waits for.
    pub(crate) fn awaited_index(&self) -> Option<usize> {
        matches!(self.tracker.stage, Stage::Index(_)).then_some(self.tracker.spindle)
    }

    /// Returns the spindle whose speed or place the path follows.
    pub(crate) fn followed_spindle(&self) -> Option<usize> {
        if self.is_bound() {
            Some(self.tracker.spindle)
        } else {
            self.per_turn().map(|s| s.spindle)
        }
    }

    /// Returns the spindle whose turns the path, which rests, waits for in a thread or tap.
    pub(crate) fn awaited_turns(&self) -> Option<usize> {
        let t = &self.tracker;
        let waits = match t.stage {
            Stage::Ready | Stage::Index(_) | Stage::Over => false,
            Stage::In if matches!(self.course, Course::Thread(_)) => t.turn <= 0.0,
            Stage::In | Stage::Out | Stage::Above => true,
        };
        (waits && self.stop.is_none()).then_some(t.spindle)
    }

    /// Returns whether these overrides hold the move that is next.
    pub(crate) fn is_held_by(&self, scales: &Scales) -> bool {
        self.next_move().is_some_and(|(_, order)| order.kind.scale(scales) == 0.0)
    }

    /// Returns the feed per turn of the current move, or of the first one.
    fn per_turn(&self) -> Option<Sync> {
        // Before its first cycle, a path has no line.
        let line = match self.last.line {
            0 => self.next_move()?.0,
            line => line,
        };
        self.known(line)?.sync.filter(|s| s.follows == Follows::Speed)
    }
}

impl State {
    /// Returns the motion along a path that follows a spindle.
    pub(crate) fn follow_spindle(&mut self, dt: f64) -> Option<Pace> {
        let sync = self.path.bound()?;
        let ready = self.at_speed && self.feed.net.feed > 0.0 && !self.path.is_paused();
        let is_of_owner = self.path_source() == MotionSource::Task;
        let spindle = self.spindles.get_mut(sync.spindle)?;
        let why = match self.path.pace(spindle, &sync, ready, dt) {
            Ok(pace) => return Some(pace),
            Err(why) => why,
        };
        if !is_of_owner {
            why.say(&self.say);
        }
        self.coord_error = true;
        // In its hole, a tap that is too far from its spindle still turns with it: both go out together.
        if why.text() == FAR.text() && self.path.abort_tap(why).is_some() {
            return self.path.pace(spindle, &sync, ready, dt).ok();
        }
        spindle.stop(why.text());
        self.path.abort_with(why);
        None
    }

    /// Returns the highest speeds along the path: that of the machine, and of a feed per turn with this override.
    pub(crate) fn top_speeds(&self, scale: f64) -> Tops {
        let tops = Tops { linear: self.traj.max_velocity, ..Tops::NONE };
        let Some(sync) = self.path.per_turn() else { return tops };
        let turns = self.spindles.get(sync.spindle).map_or(0.0, Spindle::turns_as_commanded);
        Tops { feed: sync.pitch * turns * scale, ..tops }
    }

    /// Passes each spindle what the path wants from it, and how far the path is from it.
    pub(crate) fn tell_spindles(&mut self) {
        let t = &self.path.tracker;
        let bound = self.path.bound().map(|s| s.spindle);
        let seeks = matches!(t.stage, Stage::Index(_));
        let error = t.error();
        for (n, spindle) in self.spindles.iter_mut().enumerate() {
            let is_bound = bound == Some(n);
            spindle.seek_index(is_bound && seeks);
            spindle.sync_error = if is_bound { error } else { 0.0 };
        }
    }
}
