//! Records of pin values, from and to programs.
#![forbid(unsafe_code)]

mod channel;
mod sampler;
mod scope_rt;
mod streamer;

hal_component::export!(sampler::Sampler, scope_rt::ScopeRt, streamer::Streamer);
