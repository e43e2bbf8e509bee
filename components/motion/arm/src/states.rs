//! Joint positions that reach a sample of a path, and the work to get there.

use crate::{
    arm::{Arm, CONFIGURATIONS, Joints},
    frame::Frame,
};
use core::cmp::Ordering;
use libm::{ceil, floor};

/// Work up to a state. Less of a field counts more than any amount of the next.
#[derive(Clone, Copy, PartialEq, Debug)]
pub(crate) struct Work {
    /// Number of changes of configuration.
    changes: u32,
    /// Time from the present joints to the first ones, in seconds.
    start: f64,
    /// Time of the joints along the path at their highest speed, in seconds.
    travel: f64,
}

impl Work {
    pub(crate) const fn start(start: f64) -> Self {
        Self { changes: 0, start, travel: 0.0 }
    }

    fn order(&self, other: &Self) -> Ordering {
        let changes = self.changes.cmp(&other.changes);
        changes.then(self.start.total_cmp(&other.start)).then(self.travel.total_cmp(&other.travel))
    }
}

/// Joint positions that reach a sample.
#[derive(Clone, Copy, PartialEq, Debug)]
pub(crate) struct State {
    pub(crate) joints: Joints,
    pub(crate) configuration: usize,
    /// Work up to here; `None` if no state before leads here.
    pub(crate) work: Option<Work>,
    /// Index of the state at the sample before.
    pub(crate) before: Option<usize>,
    /// Index of the state at this sample from which the configuration changes.
    pub(crate) changed_from: Option<usize>,
}

/// Returns the time from some joints to others at their highest speeds, in seconds.
pub(crate) fn travel(from: &Joints, to: &Joints, speed: &Joints) -> f64 {
    let pairs = from.iter().zip(to).zip(speed);
    pairs.map(|((a, b), s)| (a - b).abs() / s).fold(0.0, f64::max)
}

/// Returns all states at a flange: every configuration, with every whole turn that the limits allow. Joints that a
/// singular flange leaves open stay where they are in the states before.
pub(crate) fn list(arm: &Arm, flange: &Frame, before: &[State], present: &Joints) -> Vec<State> {
    let mut out: Vec<State> = Vec::new();
    for configuration in 0..CONFIGURATIONS {
        let Ok(way) = arm.solve(flange, configuration, present) else { continue };
        let mut starts = vec![way.joints];
        if way.is_singular {
            let near =
                before.iter().filter_map(|s| arm.solve(flange, configuration, &s.joints).ok());
            starts.extend(near.map(|w| w.joints));
        }
        for joints in starts {
            for joints in turned(arm, &joints) {
                let same = |s: &State| travel(&s.joints, &joints, &[1.0; 6]) < 1e-9;
                if !out.iter().any(same) {
                    out.push(State {
                        joints,
                        configuration,
                        work: None,
                        before: None,
                        changed_from: None,
                    });
                }
            }
        }
    }
    out
}

/// Returns the joints with all whole turns that the limits allow.
fn turned(arm: &Arm, joints: &Joints) -> Vec<Joints> {
    let mut out = vec![*joints];
    for n in 0..joints.len() {
        let at = |list: &Joints| list.get(n).copied().unwrap_or(0.0);
        let (first, last) = (
            ceil((at(&arm.min) - at(joints)) / 360.0 - 1e-12),
            floor((at(&arm.max) - at(joints)) / 360.0 + 1e-12),
        );
        let mut more = Vec::new();
        let mut turns = first.max(-2.0);
        while turns <= last.min(2.0) {
            if turns != 0.0 {
                for way in &out {
                    let mut way = *way;
                    if let Some(joint) = way.get_mut(n) {
                        *joint += 360.0 * turns;
                    }
                    more.push(way);
                }
            }
            turns += 1.0;
        }
        out.extend(more);
    }
    out
}

/// Finds for each state the one before with the least work. A joint may turn by at most `most`, and neither arm nor
/// elbow changes. Returns whether any state is reached.
pub(crate) fn join(before: &[State], states: &mut [State], speed: &Joints, most: f64) -> bool {
    let mut reached = false;
    for state in states {
        for (index, from) in before.iter().enumerate() {
            let Some(work) = from.work else { continue };
            let is_near = from.configuration & 6 == state.configuration & 6
                && from.joints.iter().zip(&state.joints).all(|(a, b)| (a - b).abs() <= most);
            if !is_near {
                continue;
            }
            let step = travel(&from.joints, &state.joints, speed);
            let work = Work { travel: work.travel + step, ..work };
            if state.work.is_none_or(|least| work.order(&least) == Ordering::Less) {
                (state.work, state.before) = (Some(work), Some(index));
                reached = true;
            }
        }
    }
    reached
}

/// Lets states be reached by a change of configuration from others at the same sample, where both have room for it.
pub(crate) fn change(states: &mut [State], speed: &Joints, has_room: impl Fn(&State) -> bool) {
    let Some(least) = best(states).and_then(|n| states.get(n)).and_then(|s| s.work) else { return };
    let is_dear = |s: &State| s.work.is_none_or(|w| w.changes > least.changes + 1);
    if !states.iter().any(is_dear) {
        return;
    }
    let rooms: Vec<bool> = states.iter().map(has_room).collect();
    let origins: Vec<State> = states.to_vec();
    for (state, room) in states.iter_mut().zip(&rooms) {
        if !is_dear(state) || !room {
            continue;
        }
        for ((index, origin), room) in origins.iter().enumerate().zip(&rooms) {
            let Some(work) = origin.work.filter(|_| *room) else { continue };
            let work = Work {
                changes: work.changes + 1,
                travel: work.travel + travel(&origin.joints, &state.joints, speed),
                ..work
            };
            if state.work.is_none_or(|least| work.order(&least) == Ordering::Less) {
                (state.work, state.before) = (Some(work), None);
                state.changed_from = Some(index);
            }
        }
    }
}

/// Returns the index of the state with the least work.
pub(crate) fn best(states: &[State]) -> Option<usize> {
    let mut best: Option<(usize, Work)> = None;
    for (n, state) in states.iter().enumerate() {
        if let Some(work) = state.work
            && best.is_none_or(|(_, least)| work.order(&least) == Ordering::Less)
        {
            best = Some((n, work));
        }
    }
    best.map(|(n, _)| n)
}
