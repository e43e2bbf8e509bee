//! Closed-loop controllers.
#![forbid(unsafe_code)]

mod at_pid;
mod pid;
mod tune;

hal_component::export!(at_pid::AtPid, pid::Pid);
