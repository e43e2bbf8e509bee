//! Sources of signals.
#![forbid(unsafe_code)]

mod siggen;

hal_component::export!(siggen::Siggen);
