//! The panel: serves a machine to browsers and programs over HTTP and a WebSocket (`API.md`).
#![forbid(unsafe_code)]

mod audit;
mod commands;
mod engine;
mod error;
mod geometry;
mod heart;
mod http;
mod info;
mod lease;
mod options;
mod page;
mod prepare;
mod server;
mod session;
mod socket;
mod status;
mod values;

pub use options::Options;
pub use server::run;
