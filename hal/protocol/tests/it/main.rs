//! The tests of this crate's surface, in one program: linking many costs more than running them.

mod pins;
mod snapshot;
