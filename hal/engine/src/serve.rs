//! Clients of the instance: the socket, requests, and the turns of the control thread while it waits.
//!
//! `server.rs` listens, `client.rs` is one connection, `session.rs` the requests of a client, `request.rs` all others,
//! `pins.rs` the pages with the values of their pins,
//! `polls.rs` the waits of clients, `hold.rs` how long one has held the clock, `control.rs` one turn of the control thread.

pub(crate) mod client;
pub(crate) mod clients;
pub(crate) mod control;
pub(crate) mod dispatch;
pub(crate) mod hold;
pub(crate) mod own_rings;
pub(crate) mod pins;
pub(crate) mod polls;
pub(crate) mod request;
pub(crate) mod server;
pub(crate) mod session;
pub(crate) mod status;
pub(crate) mod turn;
