//! Controllers of loops, spindles, tool carousels and torches.
#![forbid(unsafe_code)]

mod pid;
mod tune;

hal_component::export!(pid::Pid);
