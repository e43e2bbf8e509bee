//! Homing: of one joint (`one_joint.rs`), of several in their sequence (`sequence.rs`), and of the machine (`control.rs`);
//! why it failed (`error.rs`). Homing by a module of the user: of the machine (`by_module.rs`), what passes between
//! both (`module.rs`), and its messages (`texts.rs`).

pub(crate) mod by_module;
pub(crate) mod control;
pub(crate) mod error;
pub(crate) mod module;
pub(crate) mod one_joint;
pub(crate) mod sequence;
mod texts;
