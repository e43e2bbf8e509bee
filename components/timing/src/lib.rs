//! Edges, delays, pulses and counts.
#![forbid(unsafe_code)]

mod charge_pump;
mod debounce;
mod edge;
mod oneshot;
mod timedelay;
mod updown;

hal_component::export!(
    charge_pump::ChargePump,
    debounce::Debounce,
    edge::Edge,
    oneshot::Oneshot,
    timedelay::Timedelay,
    updown::Updown,
);
