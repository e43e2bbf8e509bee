//! Threads that a script requests.
#![forbid(unsafe_code)]

mod threads;

hal_component::export!(threads::Threads);
