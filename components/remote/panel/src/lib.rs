//! The panel: serves a machine to browsers and programs over HTTP and a WebSocket (`API.md`).
#![forbid(unsafe_code)]

mod engine;
mod error;
mod http;
mod info;
mod options;
mod page;
mod server;
mod session;
mod socket;
mod status;

pub use options::Options;
pub use server::run;
