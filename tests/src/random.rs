//! Numbers that look like chance, the same in every run.

pub use hal_component::bench::Random;
