//! Multiplexers and demultiplexers.
#![forbid(unsafe_code)]

mod blend;
mod config;
mod demux;
mod demux_generic;
mod kind;
mod mux16;
mod mux2;
mod mux4;
mod mux8;
mod mux_generic;
mod select8;
mod selector;

hal_component::export!(
    blend::Blend,
    demux::Demux,
    demux_generic::DemuxGeneric,
    mux16::Mux16,
    mux2::Mux2,
    mux4::Mux4,
    mux8::Mux8,
    mux_generic::MuxGeneric,
    select8::Select8,
);
