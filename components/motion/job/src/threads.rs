//! Moves that follow a spindle: whether the axes can, at the programmed speeds. It uses the plan of the motion controller.

use crate::{machine::Machine, number::number, way::Kind, way::distance};
use hal_gcode::{
    Call, Issued, State,
    axis::{Axis, Position},
    state::{FeedMode, modal::MAX_SPINDLES},
};
use hal_trajectory::Limits;

/// A move that the axes cannot make, or a thread of several.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Finding {
    /// The line of the first move.
    pub line: u32,
    /// The error, and what would be right.
    pub text: String,
}

/// Motion codes of tapping cycles: G74 and G84, times ten.
const TAPPING: [u16; 2] = [740, 840];

/// Speed of a spindle as the program has set it.
#[derive(Clone, Copy, Debug, Default)]
struct Speed {
    per_minute: f64,
    /// True if it is the speed at the surface, so that the turns depend on the place.
    is_of_surface: bool,
}

/// Moves that are one thread.
#[derive(Clone, Copy, Debug)]
struct Thread {
    line: u32,
    length: f64,
    /// Speed along the path, and the turns per minute.
    speed: f64,
    turns: f64,
    limits: Limits,
}

/// Follows the moves of a program that depend on a spindle.
#[derive(Clone, Debug)]
pub struct Threads {
    speeds: [Speed; MAX_SPINDLES],
    /// Pitch in units of the program, or the feed per turn if true, and the spindle.
    bound: Option<(f64, bool, u8)>,
    /// Spindle of feeds per turn.
    per_turn: Option<u8>,
    feed: f64,
    thread: Option<Thread>,
    /// Line of the last finding.
    last: Option<u32>,
}

impl Threads {
    /// Begins in the state of a program.
    pub fn new(state: &State) -> Self {
        let modal = &state.modal;
        let mut speeds = [Speed::default(); MAX_SPINDLES];
        for (slot, spindle) in speeds.iter_mut().zip(&modal.spindles) {
            *slot = Speed { per_minute: spindle.speed, is_of_surface: spindle.css };
        }
        let is_per_turn = modal.feed_mode == FeedMode::PerRevolution;
        Self {
            speeds,
            bound: None,
            per_turn: is_per_turn.then_some(modal.feed_spindle),
            feed: modal.feed,
            thread: None,
            last: None,
        }
    }

    /// Takes a call into account, with the state behind its line, the place before it, and the points of its moves.
    pub fn call(
        &mut self,
        machine: &Machine,
        issued: &Issued,
        state: &State,
        from: Position,
        points: &[(Kind, Position)],
    ) -> Option<Finding> {
        let unit = state.frame.unit.millimetres();
        let mut finding = None;
        match issued.call {
            Call::SetFeedRate(feed) => self.feed = feed,
            Call::SetFeedMode { spindle, per_revolution } => {
                self.per_turn = per_revolution.then_some(spindle);
            }
            Call::StartSpeedFeedSync { pitch, velocity_mode, spindle } => {
                self.bound = Some((pitch, velocity_mode, spindle));
            }
            Call::StopSpeedFeedSync => self.bound = None,
            Call::SetSpindleSpeed { spindle, speed } => {
                finding = self.end(machine);
                if let Some(slot) = self.speeds.get_mut(usize::from(spindle)) {
                    slot.per_minute = speed;
                }
            }
            Call::SetSpindleMode { spindle, css_max } => {
                finding = self.end(machine);
                if let Some(slot) = self.speeds.get_mut(usize::from(spindle)) {
                    slot.is_of_surface = css_max != 0.0;
                }
            }
            Call::TurnSpindle { .. }
            | Call::Dwell(_)
            | Call::ProgramStop
            | Call::ProgramEnd
            | Call::Finish => finding = self.end(machine),
            _ => {}
        }
        if points.is_empty() {
            return self.told(finding);
        }
        let found = match (self.bound, &issued.call) {
            (Some((pitch, false, spindle)), Call::RigidTap { retract_scale, .. }) => {
                let before = self.end(machine);
                before.or_else(|| {
                    let depth = points.first().map_or(from, |(_, at)| *at);
                    self.tap(
                        machine,
                        issued.line,
                        (pitch * unit, spindle),
                        *retract_scale,
                        from,
                        depth,
                    )
                })
            }
            (Some((pitch, false, spindle)), call) if !matches!(call, Call::StraightTraverse(_)) => {
                self.cut(machine, issued.line, (pitch * unit, spindle), from, points)
            }
            _ => {
                let before = self.end(machine);
                let is_tapping = TAPPING.contains(&state.modal.motion);
                before.or_else(|| match is_tapping && self.per_turn.is_none() {
                    true => self.tapping(machine, issued.line, unit, from, points),
                    false => self.feed(machine, issued.line, unit, from, points),
                })
            }
        };
        self.told(finding.or(found))
    }

    /// Ends the program.
    pub fn finish(&mut self, machine: &Machine) -> Option<Finding> {
        let finding = self.end(machine);
        self.told(finding)
    }

    /// Returns a finding unless its line has one already.
    fn told(&mut self, finding: Option<Finding>) -> Option<Finding> {
        let finding = finding.filter(|f| self.last != Some(f.line))?;
        self.last = Some(finding.line);
        Some(finding)
    }

    /// Returns the turns per minute of a spindle, if the program knows them.
    fn turns(&self, machine: &Machine, spindle: u8) -> Option<f64> {
        let speed = self.speeds.get(usize::from(spindle)).filter(|s| !s.is_of_surface)?;
        let turns = speed.per_minute.abs();
        let most = machine.ini.as_ref().and_then(|ini| {
            number(ini, &format!("SPINDLE_{spindle}"), "MAX_FORWARD_VELOCITY").ok().flatten()
        });
        Some(most.filter(|m| *m > 0.0 && *m < turns).unwrap_or(turns))
    }

    /// Takes the moves of a thread into account.
    fn cut(
        &mut self,
        machine: &Machine,
        line: u32,
        (pitch, spindle): (f64, u8),
        from: Position,
        points: &[(Kind, Position)],
    ) -> Option<Finding> {
        let turns = self.turns(machine, spindle)?;
        let speed = pitch.abs() * turns / 60.0;
        let mut at = from;
        for (_, to) in points {
            let limits = limits(machine, at, *to);
            if speed >= limits.velocity {
                self.thread = None;
                return Some(too_fast(machine, line, ("a pitch", pitch, turns), &limits));
            }
            let begun = Thread { line, length: 0.0, speed, turns, limits };
            self.thread.get_or_insert(begun).length += distance(at, *to);
            at = *to;
        }
        None
    }

    /// Returns what is wrong with the thread that ends here: its moves are no longer than lead-in and run-out.
    fn end(&mut self, machine: &Machine) -> Option<Finding> {
        let Thread { line, length, speed, turns, limits } = self.thread.take()?;
        let period = machine.period;
        let (lead_in, run_out) = (limits.lead_in(speed, period), limits.run_out(speed, period));
        if lead_in + run_out < length {
            return None;
        }
        let [length, lead_in, run_out] = [length, lead_in, run_out].map(|l| shown(machine, l));
        let text = format!(
            "the thread is {length} long, and at {} turns/min it needs a lead-in of {lead_in} and a run-out of {run_out}: \
             begin it farther from the cut, or turn slower",
            rounded(turns)
        );
        Some(Finding { line, text })
    }

    /// Returns what is wrong with a rigid tap.
    fn tap(
        &self,
        machine: &Machine,
        line: u32,
        (pitch, spindle): (f64, u8),
        back: f64,
        from: Position,
        depth: Position,
    ) -> Option<Finding> {
        let turns = self.turns(machine, spindle)?;
        let (limits, length) = (limits(machine, from, depth), distance(from, depth));
        let fastest = turns * back.max(1.0);
        if pitch.abs() * fastest / 60.0 >= limits.velocity {
            return Some(too_fast(machine, line, ("a pitch", pitch, fastest), &limits));
        }
        let lead_in = limits.lead_in(pitch.abs() * turns / 60.0, machine.period);
        if lead_in < length {
            return None;
        }
        let [length, lead_in] = [length, lead_in].map(|l| shown(machine, l));
        let text = format!(
            "the tap is {length} long, and at {} turns/min it needs a lead-in of {lead_in}: begin it farther from the hole, \
             or turn slower",
            rounded(turns)
        );
        Some(Finding { line, text })
    }

    /// Returns what is wrong with the moves of a tapping cycle at a feed per minute, which keeps the pitch by its time alone.
    fn tapping(
        &self,
        machine: &Machine,
        line: u32,
        unit: f64,
        from: Position,
        points: &[(Kind, Position)],
    ) -> Option<Finding> {
        let mut at = from;
        for (kind, to) in points {
            let top = limits(machine, at, *to).velocity;
            let speed = self.feed * unit / 60.0;
            if *kind == Kind::Feed && speed > top {
                let [speed, top] = [speed, top].map(|l| shown(machine, l));
                let text = format!(
                    "the tap needs its feed of {speed}/s, and the axes allow {top}/s: lower feed and speed alike"
                );
                return Some(Finding { line, text });
            }
            at = *to;
        }
        None
    }

    /// Returns what is wrong with moves at a feed per turn.
    fn feed(
        &self,
        machine: &Machine,
        line: u32,
        unit: f64,
        from: Position,
        points: &[(Kind, Position)],
    ) -> Option<Finding> {
        let (feed, spindle) = match (self.bound, self.per_turn) {
            (Some((feed, true, spindle)), _) => (feed * unit, spindle),
            (_, Some(spindle)) => (self.feed * unit, spindle),
            _ => return None,
        };
        let turns = self.turns(machine, spindle)?;
        let mut at = from;
        for (kind, to) in points {
            let limits = limits(machine, at, *to);
            if *kind == Kind::Feed && feed * turns / 60.0 > limits.velocity {
                return Some(too_fast(machine, line, ("a feed per turn", feed, turns), &limits));
            }
            at = *to;
        }
        None
    }
}

/// Returns the limits along a straight move, in millimetres.
fn limits(machine: &Machine, from: Position, to: Position) -> Limits {
    let length = distance(from, to);
    let of_path = |name: &str| {
        let value = machine.ini.as_ref().and_then(|ini| number(ini, "TRAJ", name).ok().flatten());
        let value = value.filter(|v| *v > 0.0).map(|v| v * machine.settings.unit.millimetres());
        value.unwrap_or(f64::INFINITY)
    };
    let mut all =
        [machine.top_speed.0, of_path("MAX_LINEAR_ACCELERATION"), of_path("MAX_LINEAR_JERK")];
    for (axis, rates) in Axis::ALL.into_iter().zip(machine.rates) {
        let part = (to[axis] - from[axis]).abs() / length;
        for (limit, rate) in all.iter_mut().zip(rates) {
            if let Some(rate) = rate.filter(|_| part > 0.0) {
                *limit = limit.min(rate / part);
            }
        }
    }
    let [velocity, acceleration, jerk] = all;
    Limits { velocity, acceleration, jerk }
}

fn too_fast(
    machine: &Machine,
    line: u32,
    (what, travel, turns): (&str, f64, f64),
    limits: &Limits,
) -> Finding {
    let [each, needed, top] =
        [travel, travel.abs() * turns / 60.0, limits.velocity].map(|l| shown(machine, l));
    let turns = rounded(turns);
    let text = format!(
        "{what} of {each} at {turns} turns/min needs {needed}/s along the path, and the axes allow {top}/s"
    );
    Finding { line, text }
}

/// Returns a length of millimetres as the machine's operator reads it.
fn shown(machine: &Machine, length: f64) -> String {
    let unit = machine.settings.unit;
    format!("{} {}", rounded(length / unit.millimetres()), unit.symbol())
}

/// Returns a number without the digits that nobody needs.
fn rounded(value: f64) -> f64 {
    (value * 1e4).round() / 1e4
}
