//! Whole machines: `configs/`, the printer of the documents, `haltest`, pictures.

mod demos;
mod haltest;
mod haltest_rust;
mod picture;
mod printer;
mod viewers;
mod waveform;
