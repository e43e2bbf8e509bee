//! Refusals, as the API states them.

use axum::{
    Json,
    http::StatusCode,
    response::{IntoResponse, Response},
};
use hal_protocol::{Failure, NOT_FROM_AFAR, Unserved};
use serde::Serialize;

/// Kind of a refusal.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub(crate) enum Code {
    NoSession,
    WrongLogin,
    ForeignOrigin,
    Role,
    NotFound,
    Conflict,
    TooLarge,
    Malformed,
    TooMany,
    Refused,
    Disk,
    NoEngine,
    Lease,
    Remote,
    NoTask,
}

impl Code {
    const fn status(self) -> StatusCode {
        match self {
            Self::NoSession | Self::WrongLogin => StatusCode::UNAUTHORIZED,
            Self::ForeignOrigin | Self::Role | Self::Lease | Self::Remote => StatusCode::FORBIDDEN,
            Self::NotFound => StatusCode::NOT_FOUND,
            Self::Conflict => StatusCode::CONFLICT,
            Self::TooLarge => StatusCode::PAYLOAD_TOO_LARGE,
            Self::Malformed => StatusCode::BAD_REQUEST,
            Self::TooMany => StatusCode::TOO_MANY_REQUESTS,
            Self::Refused | Self::NoTask => StatusCode::UNPROCESSABLE_ENTITY,
            Self::Disk => StatusCode::INSUFFICIENT_STORAGE,
            Self::NoEngine => StatusCode::SERVICE_UNAVAILABLE,
        }
    }
}

/// A refusal.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct Error {
    pub(crate) code: Code,
    pub(crate) text: String,
    pub(crate) hint: Option<String>,
}

impl Error {
    pub(crate) fn new(code: Code, text: impl Into<String>) -> Self {
        Self { code, text: text.into(), hint: None }
    }
}

impl From<Failure> for Error {
    fn from(failure: Failure) -> Self {
        let code = if failure.code == NOT_FROM_AFAR { Code::Remote } else { Code::Refused };
        Self { code, text: failure.text, hint: failure.hint }
    }
}

impl From<Unserved> for Error {
    fn from(why: Unserved) -> Self {
        let code = if why == Unserved::Reset { Code::Refused } else { Code::NoTask };
        Self::new(code, why.to_string())
    }
}

impl IntoResponse for Error {
    fn into_response(self) -> Response {
        (self.code.status(), Json(serde_json::json!({ "error": self }))).into_response()
    }
}
