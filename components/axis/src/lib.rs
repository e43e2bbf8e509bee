//! Axes: joints coupled, jogged, offset and tried out.
#![forbid(unsafe_code)]

mod corexy_by_hal;
mod differential;
mod gantry;

hal_component::export!(corexy_by_hal::CorexyByHal, differential::Differential, gantry::Gantry,);
