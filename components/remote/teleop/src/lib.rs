//! Teleoperation: the line protocol by which a person sends a program to a machine and runs it there.
//!
//! Both ends are plain state machines over bytes and times: they open no connection and read no clock. `halpanel` has the
//! server, `halteleop` the client. `PROTOCOL.md` in this folder describes the protocol.
#![forbid(unsafe_code)]

mod answer;
mod client;
mod line;
mod requests;
mod server;
mod session;
mod visitors;
mod words;

pub use answer::{Answer, Reason};
pub use client::{Client, End, News};
pub use line::MAX_LINE;
pub use server::{Action, LIVENESS_MS, MAX_SESSIONS, Machine, Server};
pub use session::MAX_PROGRAM;
pub use visitors::{IDLE_MS, LOGIN_MS};
pub use words::{CODES, Code, CodeRow, REQUESTS, RequestRow, Word};
