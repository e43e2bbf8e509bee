//! Pseudo-random numbers, the same in every run.

pub use hal_bench::Random;
