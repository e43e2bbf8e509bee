//! Edges, delays, pulses, counters and watchdogs.
#![forbid(unsafe_code)]

mod charge_pump;
mod dbounce;
mod debounce;
mod edge;
mod histobins;
mod iec;
mod latencybins;
mod multiclick;
mod oneshot;
mod reset;
mod threadtest;
mod time;
mod timedelay;
mod timedelta;
mod updown;
mod watchdog;

hal_component::export!(
    charge_pump::ChargePump,
    dbounce::Dbounce,
    debounce::Debounce,
    edge::Edge,
    histobins::Histobins,
    iec::Tof,
    iec::Ton,
    iec::Tp,
    latencybins::Latencybins,
    multiclick::Multiclick,
    oneshot::Oneshot,
    reset::Reset,
    threadtest::Threadtest,
    time::Time,
    timedelay::Timedelay,
    timedelta::Timedelta,
    updown::Updown,
    watchdog::Watchdog,
);
