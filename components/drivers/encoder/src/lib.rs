//! Encoder counters, and simulated encoders.
#![forbid(unsafe_code)]

mod capture;
mod count;
mod counter;
mod encoder;
mod encoder_ratio;
mod handover;
mod sim_encoder;

hal_component::export!(
    counter::Counter,
    encoder::Encoder,
    encoder_ratio::EncoderRatio,
    sim_encoder::SimEncoder
);
