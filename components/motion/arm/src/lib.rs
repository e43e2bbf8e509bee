//! Robot arms of six joints, without HAL: the closed form of their kinematics, frames from touched points,
//! cutter-location files, and joints along their paths.
#![forbid(unsafe_code)]

pub mod apt;
mod arm;
mod fit;
mod frame;
mod path;
mod plan;
pub mod rotation;
mod states;

pub use arm::{Arm, CONFIGURATIONS, Joints, Miss, Way};
pub use fit::{Fit, MAX_PAIRS, Misfit, fit};
pub use frame::Frame;
pub use path::{Kind, MAX_SAMPLES, Sample, Target, backed, samples, targets};
pub use plan::{Cell, Change, Failure, JUMP, Plan, Refused, Step};
