//! The files around a program: the machine that it is for, and the world that it reads.
//!
//! | module | subject |
//! |---|---|
//! | [`machine`] | the machine: INI file, tool table, parameter file |
//! | [`places`], [`user_programs`] | the folders of programs, uploads and output; the programs M100 to M199 |
//! | [`number`] | numbers of an INI file, and their errors |
//! | [`travel`] | the travel of the axes, and places beyond it |
//! | [`way`] | the way of the tool in machine coordinates |
//! | [`world`] | the interpreter's environment: programs, subroutines, tools, values |
//! | [`run`] | a program without its machine, from its begin to its end |
//! | [`journal`] | the record of a job, for a start after a loss of power |
//! | [`dry_run`], [`refusal`] | a program as far as a line, and why it cannot begin there |
//! | [`simulation`] | a program without its machine, line by line |
//! | [`check`], [`estimate`] | the check of a whole program before it runs, and the time that it takes |
//! | [`clock`] | the time that a program takes on its machine, and the path that motion plans |
//! | [`threads`] | threads, taps and feeds per turn that the axes cannot follow |
//! | [`effects`] | outputs, user codes and open files of the lines before it |
//! | [`spindle`] | the record of the tool in the spindle |
//!
//! `halgcode` and the task use it, so that a program that was checked runs with the same facts.
#![forbid(unsafe_code)]

pub mod check;
pub mod clock;
pub mod dry_run;
pub mod effects;
pub mod estimate;
pub mod journal;
pub mod machine;
pub mod number;
pub mod places;
pub mod program_error;
pub mod refusal;
pub mod run;
pub mod simulation;
pub mod spindle;
pub mod threads;
pub mod travel;
pub mod user_programs;
pub mod way;
pub mod world;

pub use machine::{Files, Machine};
pub use world::World;
