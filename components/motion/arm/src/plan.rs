//! Joints along a path: the configurations with the fewest changes, and what is wrong where there are none.

use crate::{
    arm::{Arm, CONFIGURATIONS, Joints, Miss},
    frame::Frame,
    path::{Kind, Sample, Target, backed, between, samples},
    states::{State, Work, list, travel},
};
use std::fmt;

/// Largest change of a joint between samples, in degrees.
pub const JUMP: f64 = 30.0;

/// Cell of a machine: the arm, its tool, and how paths are run.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Cell {
    /// Arm.
    pub arm: Arm,
    /// Highest speed of each joint, in degrees per second.
    pub speed: Joints,
    /// Tip relative to the flange.
    pub tool: Frame,
    /// Joints where the arm is now.
    pub present: Joints,
    /// Distance that the tool goes back along itself to change its configuration; `None` if it may not.
    pub back_off: Option<f64>,
}

/// Step of the arm, in a straight line of the joints from the step before.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Step {
    /// Kind; a change of configuration consists of three steps or more.
    pub kind: Kind,
    /// Index of the target that the motion leads to.
    pub target: usize,
    /// True at the target, and at the ends of a change.
    pub is_target: bool,
    /// Tip relative to the arm's base.
    pub tip: Frame,
    /// Joints.
    pub joints: Joints,
    /// Configuration, 0 to 7.
    pub configuration: usize,
    /// Duration from the step before, in seconds; 0 for the first.
    pub seconds: f64,
    /// True if a joint's speed makes the motion slower than the feed.
    pub is_slowed: bool,
}

/// Plan of a path.
#[derive(Clone, PartialEq, Debug, Default)]
pub struct Plan {
    /// Steps in their order.
    pub steps: Vec<Step>,
    /// Changes of configuration.
    pub changes: Vec<Change>,
}

/// Change of configuration along a path.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Change {
    /// Index of the target that the motion leads to.
    pub target: usize,
    /// True at the target, false before it.
    pub is_target: bool,
    /// Configuration before.
    pub from: usize,
    /// Configuration after.
    pub to: usize,
    /// Joint that turns by the most, from 0.
    pub joint: usize,
    /// Angle that it turns by, in degrees.
    pub by: f64,
}

/// First place where a configuration fails.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Failure {
    /// Index of the target that the motion leads to.
    pub target: usize,
    /// True at the target, false before it.
    pub is_target: bool,
    /// Reason.
    pub why: Miss,
}

/// Reason why there is no plan.
#[derive(Clone, PartialEq, Debug)]
pub enum Refused {
    /// There are no targets.
    Empty,
    /// The path has more samples than can be examined.
    TooLong,
    /// No configuration reaches a sample: the first failure of each configuration.
    Unreached(Vec<Failure>),
    /// Every sample is reached, but only with changes of configuration that are not allowed.
    Changes(Vec<Change>),
    /// The path cannot go on from a target without a change for which there is no room.
    NoRoom {
        /// Index of the target that the motion leads to.
        target: usize,
    },
}

impl fmt::Display for Miss {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Reach { by } => write!(f, "out of reach by {by:.2}"),
            Self::Limit { joint, angle, limit } => {
                let sign = if angle > limit { '>' } else { '<' };
                write!(f, "J{} {angle:.2} {sign} {limit}", joint + 1)
            }
        }
    }
}

impl Cell {
    /// Returns the flange for a tip.
    #[must_use]
    pub fn flange(&self, tip: &Frame) -> Frame {
        tip.then(&self.tool.inverse())
    }

    /// Returns what each configuration says to a tip: the least distance of a joint to its limit with the joint, or the
    /// reason why it does not reach the tip.
    pub fn judge(&self, tip: &Frame) -> [Result<(usize, f64), Miss>; CONFIGURATIONS] {
        core::array::from_fn(|configuration| {
            let way = self.arm.solve(&self.flange(tip), configuration, &self.present)?;
            Ok(self.arm.margin(&way.joints))
        })
    }

    /// Returns the first failure of each configuration.
    fn failures(&self, samples: &[Sample]) -> Vec<Failure> {
        let mut out = Vec::new();
        for configuration in 0..CONFIGURATIONS {
            let failed = samples.iter().find_map(|s| {
                let why =
                    self.arm.solve(&self.flange(&s.tip), configuration, &self.present).err()?;
                Some(Failure { target: s.target, is_target: s.is_target, why })
            });
            out.extend(failed);
        }
        out
    }

    /// Plans the joints along targets.
    ///
    /// # Errors
    /// The path cannot be run; the error tells every place that matters.
    pub fn plan(&self, targets: &[Target]) -> Result<Plan, Refused> {
        let samples = samples(targets);
        let samples =
            samples.ok_or(if targets.is_empty() { Refused::Empty } else { Refused::TooLong })?;
        let mut layers: Vec<Vec<State>> = Vec::new();
        for sample in &samples {
            let flange = self.flange(&sample.tip);
            let before = layers.last().map_or(&[][..], Vec::as_slice);
            let mut states = list(&self.arm, &flange, before, &self.present);
            if states.is_empty() {
                return Err(Refused::Unreached(self.failures(&samples)));
            }
            let joined = match layers.last() {
                None => {
                    for s in &mut states {
                        s.work = Some(Work::start(travel(&self.present, &s.joints, &self.speed)));
                    }
                    true
                }
                Some(before) => crate::states::join(before, &mut states, &self.speed, JUMP),
            };
            if !joined {
                return Err(Refused::NoRoom { target: sample.target });
            }
            let by = self.back_off.unwrap_or(0.0);
            let away = self.flange(&backed(&sample.tip, by));
            crate::states::change(&mut states, &self.speed, |s| {
                self.arm.solve(&away, s.configuration, &s.joints).is_ok()
            });
            layers.push(states);
        }
        self.trace(targets, &samples, &layers)
    }

    /// Follows the best states from the end to the start, and times the steps.
    fn trace(
        &self,
        targets: &[Target],
        samples: &[Sample],
        layers: &[Vec<State>],
    ) -> Result<Plan, Refused> {
        let mut chosen: Vec<(&Sample, State, Option<State>)> = Vec::new();
        let mut at: Option<usize> = None;
        for (sample, states) in samples.iter().zip(layers).rev() {
            let index = at.or_else(|| crate::states::best(states));
            let index = index.ok_or(Refused::NoRoom { target: sample.target })?;
            let mut state = states.get(index).copied().ok_or(Refused::Empty)?;
            let mut after = None;
            if let Some(origin) = state.changed_from {
                after = Some(state);
                state = states.get(origin).copied().ok_or(Refused::Empty)?;
            }
            at = state.before;
            chosen.push((sample, state, after));
        }
        chosen.reverse();
        let mut plan = Plan::default();
        for (sample, state, after) in &chosen {
            let target = targets.get(sample.target).ok_or(Refused::Empty)?;
            let sample = &Sample { is_target: sample.is_target || after.is_some(), ..**sample };
            self.push(&mut plan, target.kind, sample, state, target.feed);
            if let Some(after) = after {
                let change = changed(sample, state, after);
                plan.changes.push(change);
                if let Some(by) = self.back_off {
                    self.turn_over(&mut plan, sample, (state, after), by)?;
                }
            }
        }
        if self.back_off.is_none() && !plan.changes.is_empty() {
            return Err(Refused::Changes(plan.changes));
        }
        Ok(plan)
    }

    fn push(&self, plan: &mut Plan, kind: Kind, sample: &Sample, state: &State, feed: f64) {
        let (seconds, is_slowed) = match plan.steps.last() {
            None => (0.0, false),
            Some(last) => {
                let (cut, turn) =
                    (sample.length / feed, travel(&last.joints, &state.joints, &self.speed));
                (f64::max(cut, turn), turn > cut && feed.is_finite())
            }
        };
        plan.steps.push(Step {
            kind,
            target: sample.target,
            is_target: sample.is_target,
            tip: sample.tip,
            joints: state.joints,
            configuration: state.configuration,
            seconds,
            is_slowed,
        });
    }

    /// Adds the way back along the tool, the change of the joints there, and the way in again.
    fn turn_over(
        &self,
        plan: &mut Plan,
        sample: &Sample,
        (old, new): (&State, &State),
        by: f64,
    ) -> Result<(), Refused> {
        let no_room = || Refused::NoRoom { target: sample.target };
        let away = between(&sample.tip, &backed(&sample.tip, by), 100_000).ok_or_else(no_room)?;
        let out = self.walk(&away, old).ok_or_else(no_room)?;
        let mut back = self.walk(&away, new).ok_or_else(no_room)?;
        let mut tips: Vec<(Frame, f64)> = away.clone();
        tips.reverse();
        back.reverse();
        let last = out.len();
        for (n, ((tip, length), state)) in away.iter().zip(&out).enumerate() {
            let step = Sample { tip: *tip, length: *length, is_target: n + 1 == last, ..*sample };
            self.push(plan, Kind::Change, &step, state, f64::INFINITY);
        }
        for (n, ((tip, length), state)) in tips.iter().zip(&back).enumerate() {
            let step = Sample { tip: *tip, length: *length, is_target: n == 0, ..*sample };
            self.push(plan, Kind::Change, &step, state, f64::INFINITY);
        }
        let step = Sample { is_target: true, ..*sample };
        self.push(plan, Kind::Change, &step, new, f64::INFINITY);
        Ok(())
    }

    /// Returns the states along tips from one on, without a change of configuration.
    fn walk(&self, tips: &[(Frame, f64)], from: &State) -> Option<Vec<State>> {
        let mut out: Vec<State> = Vec::new();
        let mut last = *from;
        for (tip, _) in tips {
            let way = self.arm.solve(&self.flange(tip), last.configuration, &last.joints).ok()?;
            let jumps = way.joints.iter().zip(&last.joints).any(|(a, b)| (a - b).abs() > JUMP);
            if jumps {
                return None;
            }
            last.joints = way.joints;
            out.push(last);
        }
        Some(out)
    }
}

fn changed(sample: &Sample, from: &State, to: &State) -> Change {
    let mut most = (0, 0.0_f64);
    for (joint, (a, b)) in from.joints.iter().zip(&to.joints).enumerate() {
        if (b - a).abs() > most.1.abs() {
            most = (joint, b - a);
        }
    }
    Change {
        target: sample.target,
        is_target: sample.is_target,
        from: from.configuration,
        to: to.configuration,
        joint: most.0,
        by: most.1,
    }
}
