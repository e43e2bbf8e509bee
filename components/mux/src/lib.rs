//! Choosing between signals.
#![forbid(unsafe_code)]

mod mux2;
mod mux4;
mod mux8;

hal_component::export!(mux2::Mux2, mux4::Mux4, mux8::Mux8);
