//! Edges, delays, pulses and counts.
#![forbid(unsafe_code)]

mod charge_pump;
mod debounce;
mod edge;
mod oneshot;
mod time;
mod timedelay;
mod updown;
mod watchdog;

hal_component::export!(
    charge_pump::ChargePump,
    debounce::Debounce,
    edge::Edge,
    oneshot::Oneshot,
    time::Time,
    timedelay::Timedelay,
    updown::Updown,
    watchdog::Watchdog,
);
