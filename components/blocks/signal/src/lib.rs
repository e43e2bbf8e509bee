//! Signal generators and constant sources.
#![forbid(unsafe_code)]

mod siggen;
mod supply;

hal_component::export!(siggen::Siggen, supply::Supply);
