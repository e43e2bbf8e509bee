//! Realtime. Names of joints in messages: where each joint follows one axis, the person knows the axis.

use crate::{path::image::axes_of_joints, setup::MAX_JOINTS};
use hal_component::{KinematicsKind, KinematicsRef, Messages};

/// Name of a joint.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
enum JointName {
    /// Number of the joint.
    #[default]
    Number,
    /// The axis that it alone moves.
    Axis(usize),
    /// An axis that other joints move as well.
    OneOf(usize),
}

/// A text with the name of a joint in all its forms. A number of the joint is the first of its numbers.
#[derive(Debug)]
pub(crate) struct JointText {
    pub(crate) number: &'static str,
    pub(crate) axis: [&'static str; 9],
    pub(crate) one_of: [&'static str; 9],
}

/// Makes a [`JointText`] from what is before the name, and what is behind it.
macro_rules! joint_text {
    (@letters $before:literal, $behind:expr; $($letter:literal)*) => {
        $crate::names::JointText {
            number: concat!($before, "joint {}", $behind),
            axis: [$(concat!($before, "axis ", $letter, $behind)),*],
            one_of: [$(concat!($before, "axis ", $letter, " (joint {})", $behind)),*],
        }
    };
    ($before:literal, $behind:expr) => {
        $crate::names::joint_text!(@letters $before, $behind; "X" "Y" "Z" "A" "B" "C" "U" "V" "W")
    };
}
pub(crate) use joint_text;

/// Names of all joints.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Names([JointName; MAX_JOINTS]);

impl Names {
    /// Returns the names of the joints of these kinematics.
    pub(crate) fn of(kinematics: &KinematicsRef) -> Self {
        let has_letters = (0..9).any(|letter| kinematics.joint_of(letter).is_some());
        if kinematics.kind() != KinematicsKind::Identity && !has_letters {
            return Self::default();
        }
        let axes = axes_of_joints(kinematics);
        Self(axes.map(|axis| match axis {
            None => JointName::Number,
            Some(n) if axes.iter().filter(|other| **other == axis).count() > 1 => {
                JointName::OneOf(n)
            }
            Some(n) => JointName::Axis(n),
        }))
    }

    /// Returns the text about a joint, and whether it has the joint's number.
    pub(crate) fn text(&self, text: &JointText, joint: usize) -> (&'static str, bool) {
        let texts = match self.0.get(joint).copied().unwrap_or_default() {
            JointName::Number => None,
            JointName::Axis(n) => text.axis.get(n).map(|text| (*text, false)),
            JointName::OneOf(n) => text.one_of.get(n).map(|text| (*text, true)),
        };
        texts.unwrap_or((text.number, true))
    }

    /// Tells the operator an error of a joint, with at most three more numbers.
    pub(crate) fn error(&self, say: &Messages, text: &JointText, joint: usize, more: &[f64]) {
        let (text, numbers, count) = self.with_numbers(text, joint, more);
        say.error(text, numbers.get(..count).unwrap_or_default());
    }

    /// Returns the text about a joint, its numbers, and how many they are.
    pub(crate) fn with_numbers(
        &self,
        text: &JointText,
        joint: usize,
        more: &[f64],
    ) -> (&'static str, [f64; 4], usize) {
        let (text, has_number) = self.text(text, joint);
        let (mut numbers, mut count) = ([0.0; 4], 0);
        let first = has_number.then_some(joint as f64);
        for (place, number) in numbers.iter_mut().zip(first.iter().chain(more)) {
            *place = *number;
            count += 1;
        }
        (text, numbers, count)
    }
}
