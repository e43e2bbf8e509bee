//! Records of pin values, from and to programs.
#![forbid(unsafe_code)]

mod channel;
mod sampler;
mod streamer;

hal_component::export!(sampler::Sampler, streamer::Streamer);
