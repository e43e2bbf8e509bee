//! A G-code interpreter as a library: lines in, typed canonical calls out.
//!
//! | module | subject |
//! |---|---|
//! | [`text`] | one line: cleaning, words, expressions, comments, O-words |
//! | [`program`] | files, calls, loops, saved modal state |
//! | [`parameters`] | numbered, named and system parameters, parameter files |
//! | [`state`] | everything that a run depends on, as a value |
//! | [`interpret`] | a block: its groups, checks and order |
//! | [`motion`] | moves, arcs, compensation, cycles, splines, probing, threads |
//! | [`canon`] | canonical calls and the frame from program to machine |
//! | [`ticks`] | T-mode: a program as single steps of X, Y and Z |
//! | [`tool`] | tools and tool tables |
//! | [`dialect`] | the languages of programs: LinuxCNC's, RS274-D |
//! | [`environment`] | the world's facts |
//! | [`question`] | the questions to the machine and its answers |
//! | [`remap`] | codes that run a subroutine, as an INI file asks |
//! | [`function`], [`view`] | functions of another language, and the state that they see |
//! | [`error`] | the problems with their places |
//! | [`foreign`] | programs of other controls: which one, and what to change |
//!
//! The caller loads a text and calls [`Interpreter::next`] until it ends. A step that needs an answer from the machine
//! (a probe, an input, a tool change) returns [`Step::Ask`]; the caller runs the calls so far and then calls
//! [`Interpreter::answer`]. The library reads no file and no device by itself: see [`Environment`].
//!
//! [`State`] can be cloned, compared, saved and loaded at every step; a run goes on from it exactly. Transcendental
//! functions come from `libm`, so results have the same bits on every machine.
#![forbid(unsafe_code)]

pub mod axis;
pub mod canon;
pub mod dialect;
pub mod environment;
pub mod error;
pub mod foreign;
pub mod function;
pub mod interpret;
pub mod motion;
pub mod parameters;
pub mod program;
pub mod question;
pub mod remap;
pub mod state;
pub mod text;
pub mod ticks;
pub mod tool;
pub mod view;

pub use canon::{Call, Issued};
pub use dialect::Dialect;
pub use environment::{Environment, Source, Text};
pub use error::Error;
pub use interpret::{Interpreter, Step};
pub use parameters::Numbered;
pub use question::{Answer, Request};
pub use state::{Settings, State};
