//! Axes: joints coupled, jogged, offset and tried out.
#![forbid(unsafe_code)]

mod axistest;
mod corexy_by_hal;
mod differential;
mod gantry;
mod simple_tp;

hal_component::export!(
    axistest::Axistest,
    corexy_by_hal::CorexyByHal,
    differential::Differential,
    gantry::Gantry,
    simple_tp::SimpleTp,
);
