//! The panel: requests byte by byte, and Chromium without a screen, with the printer on the real clock,
//! and jobs that lose their lease on the virtual one.
#![expect(
    clippy::unwrap_used,
    clippy::indexing_slicing,
    clippy::panic,
    clippy::print_stdout,
    reason = "whatever fails here fails a test; figures are shown"
)]

mod accounts;
mod align;
mod arm;
pub(crate) mod attacks;
mod cuts;
mod display;
mod figures;
mod first_hour;
mod five_axis;
mod fixture;
mod garbage;
mod guarded;
mod guesses;
mod histories;
mod holds;
mod integrator;
mod load;
mod looks;
mod loss;
mod names;
mod openapi;
mod operator;
mod pair;
mod planned;
mod printer;
mod requests;
mod rights;
mod robot;
mod roles;
mod samples;
mod socket;
mod stock;
mod stops;
mod strangers;
mod teleop;
mod trouble;
mod viewers;
