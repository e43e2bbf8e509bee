//! Realtime. What kinematics answer.

use crate::abi::{Kinematics as Table, Status};

/// A pose, or joint positions, were found.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Solved {
    /// As everywhere.
    Regular,
    /// At a singular place: other joint positions are as good, or joints would have to move
    /// without bounds to go on. The answer is the one nearest to the guess.
    Singular,
}

/// Why there is no answer.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Unsolved {
    /// What was asked is no finite number, or too few joints came.
    NoNumber,
    /// Lengths or points of the machine make no sense.
    Geometry,
    /// The pose cannot be reached, or no pose has these joints.
    Unreachable,
    /// Beyond what a joint of the arm can do.
    Limits,
    /// At a singular place where no answer is determined.
    Undetermined,
    /// A search did not come to an end.
    NotFound,
}

/// What kinematics answer; nothing has changed when there is no answer.
pub type Solution = Result<Solved, Unsolved>;

impl Unsolved {
    /// In the user's words.
    #[must_use]
    pub const fn text(self) -> &'static str {
        match self {
            Self::NoNumber => "a position is no number",
            Self::Geometry => "the lengths of the machine make no sense",
            Self::Unreachable => "the kinematics cannot go there",
            Self::Limits => "a joint of the arm cannot go that far",
            Self::Undetermined => "the machine is at a singular place",
            Self::NotFound => "the kinematics found no answer in time",
        }
    }

    pub(crate) const fn status(self) -> Status {
        match self {
            Self::NoNumber => Status::EINVAL,
            Self::Geometry => Table::GEOMETRY,
            Self::Unreachable => Table::UNREACHABLE,
            Self::Limits => Table::BEYOND_LIMITS,
            Self::Undetermined => Table::UNDETERMINED,
            Self::NotFound => Table::NOT_FOUND,
        }
    }

    pub(crate) const fn from_status(status: Status) -> Self {
        match status {
            Table::GEOMETRY => Self::Geometry,
            Table::BEYOND_LIMITS => Self::Limits,
            Table::UNDETERMINED => Self::Undetermined,
            Table::NOT_FOUND => Self::NotFound,
            Status::EINVAL => Self::NoNumber,
            _ => Self::Unreachable,
        }
    }
}

pub(crate) const fn status(solution: Solution) -> Status {
    match solution {
        Ok(Solved::Regular) => Status::OK,
        Ok(Solved::Singular) => Table::SINGULAR,
        Err(why) => why.status(),
    }
}

pub(crate) fn solution(status: Status) -> Solution {
    if status == Table::SINGULAR {
        Ok(Solved::Singular)
    } else if status.is_ok() {
        Ok(Solved::Regular)
    } else {
        Err(Unsolved::from_status(status))
    }
}

/// The ways to reach a pose, one after the other, into an array of the caller's.
#[derive(Debug)]
pub struct Ways<'a> {
    into: &'a mut [f64],
    joints: usize,
    count: usize,
}

impl<'a> Ways<'a> {
    /// Room for as many ways of so many joints as fit.
    #[must_use]
    pub const fn new(into: &'a mut [f64], joints: usize) -> Self {
        Self { into, joints: if joints == 0 { 1 } else { joints }, count: 0 }
    }

    /// One more; what has no room is only counted.
    pub fn push(&mut self, joints: &[f64]) {
        if let Some(place) = self.into.chunks_exact_mut(self.joints).nth(self.count) {
            for (to, from) in place.iter_mut().zip(joints) {
                *to = *from;
            }
        }
        self.count += 1;
    }

    /// How many came.
    #[must_use]
    pub const fn count(&self) -> usize {
        self.count
    }

    /// Those that had room.
    pub fn iter(&self) -> impl Iterator<Item = &[f64]> {
        self.into.chunks_exact(self.joints).take(self.count)
    }
}
