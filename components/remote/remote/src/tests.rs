//! The lease and the dead man, with a motion controller in virtual time.

mod alone;
mod cuts;
mod histories;
mod job;
mod jogs;
mod rig;
mod vanish;
