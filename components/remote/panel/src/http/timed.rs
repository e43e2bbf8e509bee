//! Bodies of requests that come within their time, or are cut off: who has not signed in may send them, too.

use axum::{
    Error,
    body::{Body, Bytes, HttpBody},
};
use core::{
    fmt,
    future::Future as _,
    pin::Pin,
    task::{Context, Poll, ready},
};
use hyper::body::{Frame, SizeHint};
use std::{
    sync::{
        Arc,
        atomic::{AtomicBool, Ordering::Relaxed},
    },
    time::Duration,
};
use tokio::time::{Instant, Sleep, sleep};

/// Longest time of a body.
#[derive(Clone, Copy, Debug)]
pub(super) enum Limit {
    /// As a whole.
    Whole(Duration),
    /// From one part of it to the next.
    EachPart(Duration),
}

/// True once a body was cut off.
#[derive(Clone, Debug, Default)]
pub(super) struct CutOff(Arc<AtomicBool>);

impl CutOff {
    pub(super) fn has_happened(&self) -> bool {
        self.0.load(Relaxed)
    }
}

/// The reason.
#[derive(Debug)]
struct TooSlow;

impl fmt::Display for TooSlow {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("the body of the request takes too long")
    }
}

impl core::error::Error for TooSlow {}

struct Timed {
    body: Body,
    end: Pin<Box<Sleep>>,
    each: Option<Duration>,
    cut_off: CutOff,
}

/// Returns a body that ends in an error once its time is over, which can be asked for.
pub(super) fn body(body: Body, limit: Limit) -> (Body, CutOff) {
    let (time, each) = match limit {
        Limit::Whole(time) => (time, None),
        Limit::EachPart(time) => (time, Some(time)),
    };
    let cut_off = CutOff::default();
    let timed = Timed { body, end: Box::pin(sleep(time)), each, cut_off: cut_off.clone() };
    (Body::new(timed), cut_off)
}

impl HttpBody for Timed {
    type Data = Bytes;
    type Error = Error;

    fn poll_frame(
        mut self: Pin<&mut Self>,
        context: &mut Context<'_>,
    ) -> Poll<Option<Result<Frame<Bytes>, Error>>> {
        let this = &mut *self;
        if let Poll::Ready(frame) = Pin::new(&mut this.body).poll_frame(context) {
            if let Some(each) = this.each {
                this.end.as_mut().reset(Instant::now() + each);
            }
            return Poll::Ready(frame);
        }
        ready!(this.end.as_mut().poll(context));
        this.cut_off.0.store(true, Relaxed);
        Poll::Ready(Some(Err(Error::new(TooSlow))))
    }

    fn is_end_stream(&self) -> bool {
        self.body.is_end_stream()
    }

    fn size_hint(&self) -> SizeHint {
        self.body.size_hint()
    }
}
