//! Spindles: speed, gears and orientation.
#![forbid(unsafe_code)]

mod gearchange;
mod orient;
mod spindle;
mod spindle_monitor;

hal_component::export!(
    gearchange::Gearchange,
    orient::Orient,
    spindle::Spindle,
    spindle_monitor::SpindleMonitor,
);
