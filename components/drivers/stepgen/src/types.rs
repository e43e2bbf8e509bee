//! Step types: the outputs of a channel, and the sequence in which they change.

use hal_component::Error;
use std::borrow::Cow;

/// Types whose outputs are phases, from number 2 on: number of phases, and their bits in each state of the cycle (bit 0
/// is phase A).
const PHASES: [(usize, &[u8]); 13] = [
    (2, &[1, 3, 2, 0]),
    (3, &[1, 2, 4]),
    (3, &[1, 3, 2, 6, 4, 5]),
    (4, &[1, 2, 4, 8]),
    (4, &[3, 6, 12, 9]),
    (4, &[1, 7, 14, 8]),
    (4, &[5, 6, 10, 9]),
    (4, &[1, 3, 2, 6, 4, 12, 8, 9]),
    (4, &[1, 5, 7, 6, 14, 10, 8, 9]),
    (5, &[1, 2, 4, 8, 16]),
    (5, &[3, 6, 12, 24, 17]),
    (5, &[1, 3, 2, 6, 4, 12, 8, 24, 16, 17]),
    (5, &[3, 7, 6, 14, 12, 28, 24, 25, 17, 19]),
];

/// Number of the type whose cycle the user defines.
const USER: i64 = 15;

/// Output form of a channel's steps.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum StepType {
    /// Step pulse and direction.
    StepDir,
    /// Pulse on a separate output for each direction.
    UpDown,
    /// Pattern that advances by one state per step.
    Phases {
        /// Number of outputs.
        phases: usize,
        /// Outputs in each state; bit 0 is phase A.
        cycle: Cow<'static, [u8]>,
    },
}

impl StepType {
    /// Parses every channel's type from `step_type=` and `user_step_type=`, whose declarations limit
    /// the numbers. A -1 ends either list.
    pub(crate) fn parse(types: &[i64], user: &[i64]) -> Result<Vec<Self>, Error> {
        let user = Self::user(user);
        let list: Vec<_> = types.iter().map_while(|t| Self::one(*t, &user)).collect();
        if list.is_empty() {
            return Err(Error::new("STEPGEN: ERROR: no channels configured"));
        }
        Ok(list)
    }

    /// Returns the type with this number. -1 is not a type.
    fn one(number: i64, user: &Self) -> Option<Self> {
        match number {
            0 => Some(Self::StepDir),
            1 => Some(Self::UpDown),
            USER => Some(user.clone()),
            _ => usize::try_from(number).ok().and_then(|n| PHASES.get(n.checked_sub(2)?)).map(
                |(phases, cycle)| Self::Phases { phases: *phases, cycle: Cow::Borrowed(cycle) },
            ),
        }
    }

    /// Returns the type that `user_step_type=` defines.
    fn user(values: &[i64]) -> Self {
        let cycle: Vec<u8> = values.iter().map_while(|v| u8::try_from(*v).ok()).collect();
        let used = cycle.iter().fold(0, |all, v| all | v);
        let phases = (0..5).filter(|bit| used >> bit != 0).count();
        Self::Phases { phases, cycle: Cow::Owned(cycle) }
    }
}

/// Kind of command of a channel.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Control {
    /// Position command.
    Position,
    /// Velocity command.
    Velocity,
}

impl Control {
    /// Parses the first letter of one word of `ctrl_type=`.
    pub(crate) fn parse(channel: usize, word: Option<&str>) -> Result<Self, Error> {
        match word.and_then(|w| w.chars().next()) {
            None | Some('p' | 'P') => Ok(Self::Position),
            Some('v' | 'V') => Ok(Self::Velocity),
            Some(_) => Err(Error::new(format!(
                "STEPGEN: ERROR: bad control type '{}' for axis {channel} (must be 'p' or 'v')",
                word.unwrap_or_default()
            ))),
        }
    }

    /// Returns name and documentation of the command pin.
    pub(crate) const fn pin(self) -> (&'static str, &'static str) {
        match self {
            Self::Position => (
                "position-cmd",
                "Commanded position, in length units; while it is not finite, the last one remains",
            ),
            Self::Velocity => (
                "velocity-cmd",
                "Commanded speed, in length units per second; not a number counts as 0",
            ),
        }
    }
}
