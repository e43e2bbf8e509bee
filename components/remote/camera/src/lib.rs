//! Cameras over a network.
//!
//! | module | subject |
//! |---|---|
//! | `address`, `http` | addresses, and answers of HTTP/1.1 with their limits |
//! | `parts` | pictures of a stream: the parts of `multipart/x-mixed-replace` |
//! | `feed` | a thread that receives pictures, of which the newest wins |
//! | `refused` | why there is no picture |
#![forbid(unsafe_code)]

mod address;
mod feed;
mod http;
mod parts;
mod refused;

pub use address::Address;
pub use feed::{Delivery, Feed};
pub use http::{Answer, get};
pub use parts::Parts;
pub use refused::Refused;
