//! Ferrule beside LinuxCNC: traces, modules, `.comp` files, messages.

mod comp;
mod compat;
mod conformance;
mod corners;
mod halshow;
mod homing;
mod interpreter;
mod kinematics;
mod known;
mod language;
mod mesa;
mod modules;
mod motion;
mod nc_files;
mod outside;
mod programs;
pub(crate) mod python;
mod remaps;
mod rsh;
mod traces;
