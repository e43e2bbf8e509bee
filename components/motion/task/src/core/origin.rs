//! The lines that steps come from, and the state to which an abort returns.

use crate::{convert::Action, outside::Order};
use hal_gcode::{Numbered, axis::Axis, canon::Frame, parameters::Change, state::Modal};
use std::{
    collections::{BTreeSet, VecDeque},
    sync::Arc,
};

/// The modal state behind a line, to which an abort returns.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Tag {
    pub(super) file: Box<str>,
    pub(super) modal: Modal,
    pub(super) frame: Frame,
}

impl Tag {
    /// Adds what a step of an entry changes. The unit is that of the frame in machine units.
    pub(super) fn note(&mut self, action: &Action, unit: f64) {
        match action {
            Action::FeedOverride(on) => self.modal.feed_override = *on,
            Action::SpeedOverride { spindle, on } => {
                if let Some(spindle) = self.modal.spindles.get_mut(usize::from(*spindle)) {
                    spindle.speed_override = *on;
                }
            }
            Action::Rest(Order::AdaptiveFeed(on)) => self.modal.adaptive_feed = *on,
            Action::Rest(Order::FeedHold(on)) => self.modal.feed_hold = *on,
            Action::Path(Order::ToolOffset(offset)) => {
                for (axis, value) in Axis::ALL.into_iter().zip(offset) {
                    let k = if axis.is_rotary() { 1.0 } else { unit };
                    self.frame.tool[axis] = value / k;
                }
                self.modal.tool_offset = offset.iter().any(|value| *value != 0.0);
            }
            _ => {}
        }
    }
}

/// The line that a step comes from.
#[derive(Clone, Debug)]
pub(super) struct Origin {
    pub(super) line: u32,
    /// Number of the line in the order of execution.
    pub(super) serial: u64,
    /// Number of lines that the program ran before it.
    pub(super) number: u64,
    pub(super) tag: Arc<Tag>,
}

/// Numbered parameters before the lines that were read and are not executed yet.
#[derive(Clone, Debug, Default)]
pub(super) struct Undo {
    /// Serial number of a line, and a change of its, the oldest first.
    changes: VecDeque<(u64, Change)>,
    /// Parameters changed since the last line with steps. An abort returns to a line with steps, so
    /// only their first change counts.
    recent: BTreeSet<i32>,
}

impl Undo {
    /// Adds the changes of a line, which has steps or none.
    pub(super) fn add(&mut self, serial: u64, changes: Vec<Change>, has_steps: bool) {
        for change in changes {
            if self.recent.insert(change.0) {
                self.changes.push_back((serial, change));
            }
        }
        if has_steps {
            self.recent.clear();
        }
    }

    /// Forgets the changes of executed lines, up to this one.
    pub(super) fn executed(&mut self, serial: u64) {
        while self.changes.pop_front_if(|(of, _)| *of <= serial).is_some() {}
    }

    /// Forgets all changes.
    pub(super) fn clear(&mut self) {
        self.changes.clear();
        self.recent.clear();
    }

    /// Takes back the changes of the lines behind this one.
    pub(super) fn restore(&mut self, serial: u64, numbered: &mut Numbered) {
        while let Some((_, (index, before))) = self.changes.pop_back_if(|(of, _)| *of > serial) {
            numbered.put(index, before);
        }
        self.clear();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_loop_without_steps_keeps_one_change_of_each_parameter() {
        let mut numbered = Numbered::default();
        numbered.record_changes();
        let mut undo = Undo::default();
        numbered.put(1, 5.0);
        undo.add(1, numbered.take_changes(), true);
        for serial in 2..1000_u32 {
            numbered.put(1, f64::from(serial));
            undo.add(serial.into(), numbered.take_changes(), false);
        }
        assert_eq!(undo.changes.len(), 2);
        undo.executed(1);
        undo.restore(1, &mut numbered);
        assert_eq!(numbered.get(1), 5.0);
    }
}
