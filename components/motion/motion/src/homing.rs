//! Homing: of one joint (`one_joint.rs`), of several in their sequence (`sequence.rs`), and of the machine (`control.rs`);
//! why it failed (`error.rs`).

pub(crate) mod control;
pub(crate) mod error;
pub(crate) mod one_joint;
pub(crate) mod sequence;
