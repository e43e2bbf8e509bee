//! Realtime. Results of kinematics.

use crate::abi::{Kinematics as Table, Status};

/// Kind of a solution.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Solved {
    /// A regular solution.
    Regular,
    /// A solution at a singularity: other joint positions are equally valid, or joints would need
    /// unbounded speed to continue. The solution is the one nearest to the guess.
    Singular,
}

/// Reason why there is no solution.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Unsolved {
    /// The input is not finite, or there are too few joints.
    NoNumber,
    /// The dimensions of the machine are invalid.
    Geometry,
    /// The pose cannot be reached, or no pose has these joint positions.
    Unreachable,
    /// The solution is beyond the limits of a joint of the arm.
    Limits,
    /// The pose is at a singularity where the solution is not determined.
    Undetermined,
    /// An iterative search did not converge.
    NotFound,
}

/// Result of kinematics. Outputs are unchanged if there is no solution.
pub type Solution = Result<Solved, Unsolved>;

impl Unsolved {
    /// Returns the reason in the user's words.
    #[must_use]
    pub const fn text(self) -> &'static str {
        match self {
            Self::NoNumber => "a position is NaN",
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

/// List of solutions for a pose, stored one after the other in the caller's array.
#[derive(Debug)]
pub struct Ways<'a> {
    into: &'a mut [f64],
    joints: usize,
    count: usize,
}

impl<'a> Ways<'a> {
    /// Returns an empty list. `into` holds as many solutions of `joints` numbers as fit.
    #[must_use]
    pub const fn new(into: &'a mut [f64], joints: usize) -> Self {
        Self { into, joints: if joints == 0 { 1 } else { joints }, count: 0 }
    }

    /// Adds a solution. A solution that does not fit is only counted.
    pub fn push(&mut self, joints: &[f64]) {
        if let Some(place) = self.into.chunks_exact_mut(self.joints).nth(self.count) {
            for (to, from) in place.iter_mut().zip(joints) {
                *to = *from;
            }
        }
        self.count += 1;
    }

    /// Returns the number of solutions, including those that did not fit.
    #[must_use]
    pub const fn count(&self) -> usize {
        self.count
    }

    /// Returns the solutions that fit.
    pub fn iter(&self) -> impl Iterator<Item = &[f64]> {
        self.into.chunks_exact(self.joints).take(self.count)
    }
}
