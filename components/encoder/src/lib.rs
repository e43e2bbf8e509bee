//! Counters of encoders, and simulated ones.
#![forbid(unsafe_code)]

mod capture;
mod channels;
mod count;
mod counter;
mod encoder;
mod handover;
mod sim_encoder;

hal_component::export!(counter::Counter, encoder::Encoder, sim_encoder::SimEncoder);
