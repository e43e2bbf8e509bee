//! What stands in for hardware that is not there.
#![forbid(unsafe_code)]

mod sim_home_switch;
mod sim_spindle;
mod sphereprobe;
mod supply;

hal_component::export!(
    sim_home_switch::SimHomeSwitch,
    sim_spindle::SimSpindle,
    sphereprobe::Sphereprobe,
    supply::Supply,
);
