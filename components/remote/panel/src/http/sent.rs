//! Answers that keep their seat in the pool until they have been sent.

use crate::pool::Seat;
use axum::body::{Body, Bytes, HttpBody};
use core::{
    convert::Infallible,
    pin::Pin,
    task::{Context, Poll},
};
use hyper::body::{Frame, SizeHint};

/// Longest part of an answer that is passed on at once.
const PART: usize = 256 << 10;

struct Sent {
    rest: Bytes,
    _seat: Seat,
}

/// Returns the body of an answer.
pub(super) fn body(bytes: Vec<u8>, seat: Seat) -> Body {
    Body::new(Sent { rest: bytes.into(), _seat: seat })
}

impl HttpBody for Sent {
    type Data = Bytes;
    type Error = Infallible;

    fn poll_frame(
        mut self: Pin<&mut Self>,
        _: &mut Context<'_>,
    ) -> Poll<Option<Result<Frame<Bytes>, Infallible>>> {
        let part = self.rest.len().min(PART);
        let part = (part > 0).then(|| Ok(Frame::data(self.rest.split_to(part))));
        Poll::Ready(part)
    }

    fn is_end_stream(&self) -> bool {
        self.rest.is_empty()
    }

    fn size_hint(&self) -> SizeHint {
        SizeHint::with_exact(self.rest.len() as u64)
    }
}
