//! Sensor chips that are read bit by bit.
#![forbid(unsafe_code)]

mod max31855;
mod type_k;

hal_component::export!(max31855::Max31855);
