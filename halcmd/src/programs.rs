//! The programs, a module for each, and what they share: options and profiles of a run.

mod alone;
pub mod common;
pub mod hal_manualtoolchange;
pub mod halcmd;
pub mod halgcode;
pub mod halrun;
pub mod halsampler;
pub mod halscope;
pub mod halsetup;
pub mod halstreamer;
pub mod haltcl;
pub mod haltest;
pub mod latency_test;
pub mod linuxcnc;
pub mod options;
mod picture;
pub mod profile;
