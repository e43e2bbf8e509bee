//! Homing: of one joint (`one_joint.rs`), and of several in their sequence (`sequence.rs`).

pub(crate) mod one_joint;
pub(crate) mod sequence;
