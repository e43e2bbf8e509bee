//! Whole machines: `configs/`, the printer of the documents, `haltest`, pictures.

mod book;
mod commission;
mod demos;
mod fiducial;
mod front;
mod functions;
mod haltest;
mod haltest_rust;
mod home;
mod job;
mod kept;
mod maxnc;
mod meanwhile;
mod packages;
mod picture;
mod printer;
mod releases;
mod requirements;
mod samples;
mod setup;
mod speed;
mod trials;
mod viewers;
mod waits;
mod waveform;
mod wizard;
