//! Torches and lasers: height, power.
#![forbid(unsafe_code)]

mod height;
mod ohmic;
mod thc;
mod thcud;

hal_component::export!(ohmic::Ohmic, thc::Thc, thcud::Thcud);
