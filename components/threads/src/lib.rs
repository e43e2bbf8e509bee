//! Threads that a script asks for.
#![forbid(unsafe_code)]

mod threads;

hal_component::export!(threads::Threads);
