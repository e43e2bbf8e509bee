//! Guards: they stop what commands stop (`stop_line.rs`), switch the machine off (`switch_off.rs`, `interlock.rs`,
//! `gap.rs`) and keep the causes (`stops.rs`), keep joints within their velocity (`pace.rs`, `step.rs`, `jump.rs`,
//! `last_jump.rs`) and axes where the kinematics have a solution (`world.rs`), and judge every motor command (`watch.rs`,
//! `watchman.rs`).

pub(crate) mod gap;
pub(crate) mod interlock;
pub(crate) mod jump;
pub(crate) mod last_jump;
pub(crate) mod pace;
pub(crate) mod step;
pub(crate) mod stop_line;
pub(crate) mod stops;
pub(crate) mod switch_off;
pub(crate) mod watch;
pub(crate) mod watchman;
pub(crate) mod world;
