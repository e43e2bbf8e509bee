//! Requests and replies as lines on the socket.

use crate::{At, Failure, Reply, Request};
use serde::{Deserialize, Serialize};

/// A request as a line on the socket.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct WireRequest {
    /// The request.
    pub request: Request,
    /// Script position of the request.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub at: Option<At>,
}

/// A reply as a line on the socket.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum WireReply {
    /// The request succeeded.
    Ok(Reply),
    /// The request failed.
    Error(Failure),
}
