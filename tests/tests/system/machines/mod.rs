//! Whole machines: `configs/`, the printer of the documents, `haltest`, pictures.

mod demos;
mod haltest;
mod haltest_rust;
mod job;
mod meanwhile;
mod picture;
mod printer;
mod samples;
mod setup;
mod speed;
mod trials;
mod viewers;
mod waveform;
