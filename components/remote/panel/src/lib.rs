//! The panel: serves a machine to browsers and programs over HTTP and a WebSocket (`API.md`).
#![forbid(unsafe_code)]

mod accounts;
mod audit;
mod commands;
mod engine;
mod epoch;
mod error;
mod folders;
mod geometry;
mod heart;
mod holds;
mod http;
mod info;
mod lease;
mod limits;
mod options;
mod page;
mod pool;
mod private;
mod scope;
mod security;
mod server;
mod session;
mod socket;
mod status;
mod stops;
mod teleop;
mod tls;
mod values;

pub use options::Options;
pub use server::run;
