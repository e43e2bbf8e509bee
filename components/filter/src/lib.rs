//! Filters of signals.
#![forbid(unsafe_code)]

mod biquad;
mod ilowpass;

hal_component::export!(biquad::Biquad, ilowpass::Ilowpass);
