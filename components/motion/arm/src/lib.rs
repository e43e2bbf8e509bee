//! Robot arms of six joints, without HAL: the closed form of their kinematics, frames, and the reach of paths.
#![forbid(unsafe_code)]

mod arm;
mod frame;
pub mod rotation;

pub use arm::{Arm, CONFIGURATIONS, Joints, Miss, Way};
pub use frame::Frame;
