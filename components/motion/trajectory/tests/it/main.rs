//! The tests of this crate's surface, in one program: linking many costs more than running them.

mod axis;
mod door;
mod invariants;
mod judge;
mod limits;
mod mutants;
mod pursuit;
mod rapids;
mod rounding;
mod share;
mod splines;
mod times;
mod tops;
