//! Choosing between signals.
#![forbid(unsafe_code)]

mod blend;
mod demux;
mod mux16;
mod mux2;
mod mux4;
mod mux8;
mod select8;

hal_component::export!(
    blend::Blend,
    demux::Demux,
    mux16::Mux16,
    mux2::Mux2,
    mux4::Mux4,
    mux8::Mux8,
    select8::Select8,
);
