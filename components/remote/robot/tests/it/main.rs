//! The tests of this crate's surface, in one program: linking many costs more than running them.

mod console;
mod controller;
mod convert;
mod hostile;
mod plugin;
mod programs;
mod run;
mod sim;
mod terminal;
