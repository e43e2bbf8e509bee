//! Simulated hardware.
#![forbid(unsafe_code)]

mod sim_axis_hardware;
mod sim_home_switch;
mod sim_matrix_kb;
mod sim_parport;
mod sim_spindle;
mod sphereprobe;
mod standin;

hal_component::export!(
    sim_axis_hardware::SimAxisHardware,
    sim_home_switch::SimHomeSwitch,
    sim_matrix_kb::SimMatrixKb,
    sim_parport::SimParport,
    sim_spindle::SimSpindle,
    sphereprobe::Sphereprobe,
    standin::Standin,
);
