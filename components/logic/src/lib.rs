//! Gates.
#![forbid(unsafe_code)]

mod and2;

hal_component::export!(and2::And2);
