//! The files around a program: the machine that it is for, and the world that it reads.
//!
//! | module | subject |
//! |---|---|
//! | [`machine`] | the machine: INI file, tool table, parameter file |
//! | [`world`] | the interpreter's environment: programs, subroutines, tools, values |
//! | [`run`] | a program without its machine, from its begin to its end |
//!
//! `halgcode` and the task use it, so that a program that was checked runs with the same facts.
#![forbid(unsafe_code)]

pub mod machine;
pub mod run;
pub mod world;

pub use machine::{Files, Machine};
pub use world::World;
