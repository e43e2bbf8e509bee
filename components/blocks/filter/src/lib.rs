//! Filters, output buffers and holds.
#![forbid(unsafe_code)]

mod biquad;
mod feedcomp;
mod filter_kalman;
mod ilowpass;
mod output_buffer;
mod sample_hold;

hal_component::export!(
    biquad::Biquad,
    feedcomp::Feedcomp,
    filter_kalman::FilterKalman,
    ilowpass::Ilowpass,
    output_buffer::OutputBuffer,
    sample_hold::SampleHold,
);
