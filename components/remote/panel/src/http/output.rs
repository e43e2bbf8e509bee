//! Files that programs have written: their list, and downloads.

use super::programs::listed;
use crate::{error::Error, server::Panel, session::Session};
use axum::{
    Json,
    body::{Body, Bytes, HttpBody},
    extract::{Path, State},
    http::header,
    response::{IntoResponse as _, Response},
};
use core::{
    pin::Pin,
    task::{Context, Poll},
};
use hyper::body::{Frame, SizeHint};
use std::{
    fs::File,
    io::{self, Read as _},
    sync::Arc,
};
use tokio::task::block_in_place;

/// Bytes that are read at once.
const PART: usize = 64 << 10;

/// Lists the files.
pub(crate) async fn list(State(panel): State<Arc<Panel>>, _: Session) -> Result<Response, Error> {
    let list = block_in_place(|| panel.folders.written())?;
    Ok(Json(list.iter().map(listed).collect::<Vec<_>>()).into_response())
}

/// Returns a file, as one to store: a browser shows nothing of what a program wrote.
pub(crate) async fn file(
    State(panel): State<Arc<Panel>>,
    _: Session,
    Path(name): Path<String>,
) -> Result<Response, Error> {
    let file = block_in_place(|| panel.folders.written_file(&name))?;
    let left = file.metadata().map_err(|e| super::programs::disk(&e))?.len();
    let headers = [
        (header::CONTENT_TYPE, "application/octet-stream"),
        (header::CONTENT_DISPOSITION, "attachment"),
    ];
    Ok((headers, Body::new(Parts { file, left })).into_response())
}

/// A file as the body of an answer, read in parts: as long as it was when the answer began.
struct Parts {
    file: File,
    left: u64,
}

impl HttpBody for Parts {
    type Data = Bytes;
    type Error = io::Error;

    fn poll_frame(
        mut self: Pin<&mut Self>,
        _: &mut Context<'_>,
    ) -> Poll<Option<Result<Frame<Bytes>, io::Error>>> {
        if self.left == 0 {
            return Poll::Ready(None);
        }
        let mut part = Vec::new();
        let most = self.left.min(PART as u64);
        let read = block_in_place(|| (&self.file).take(most).read_to_end(&mut part));
        Poll::Ready(Some(match read {
            // The file became shorter meanwhile.
            Ok(0) => Err(io::ErrorKind::UnexpectedEof.into()),
            Ok(read) => {
                self.left = self.left.saturating_sub(read as u64);
                Ok(Frame::data(part.into()))
            }
            Err(e) => Err(e),
        }))
    }

    fn size_hint(&self) -> SizeHint {
        SizeHint::with_exact(self.left)
    }
}
