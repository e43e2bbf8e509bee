//! Axes: joint transforms, jogging, offsets and test moves.
#![forbid(unsafe_code)]

mod anglejog;
mod axistest;
mod corexy_by_hal;
mod differential;
mod eoffset_per_angle;
mod follower;
mod gantry;
mod moveoff;
mod planner;
mod simple_tp;
mod steptest;
mod trips;
mod waypoints;

pub use steptest::Steptest;

hal_component::export!(
    anglejog::Anglejog,
    axistest::Axistest,
    corexy_by_hal::CorexyByHal,
    differential::Differential,
    eoffset_per_angle::EoffsetPerAngle,
    gantry::Gantry,
    moveoff::Moveoff,
    simple_tp::SimpleTp,
    Steptest,
);
