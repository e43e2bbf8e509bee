//! The machine's wiring as a picture.

use super::lists::patterns;
use crate::{
    error::{Code, Error},
    server::Panel,
    session::Session,
};
use axum::{
    extract::{RawQuery, State},
    http::{HeaderValue, header},
    response::{IntoResponse as _, Response},
};
use halcmd::{
    Error as Refusal,
    graph::{Drawing, Format, Wanted, text},
};
use std::sync::Arc;
use tokio::{runtime::Handle, task::block_in_place};

/// Draws what matches the patterns of the query, or all.
pub(crate) async fn svg(
    State(panel): State<Arc<Panel>>,
    _: Session,
    RawQuery(query): RawQuery,
) -> Result<Response, Error> {
    let patterns = patterns(query.as_deref().unwrap_or_default())?;
    let wanted = Wanted { patterns, ..Wanted::default() };
    let reading = panel.reading.lock().await;
    let drawn = block_in_place(|| {
        let mut refusal = None;
        let drawing = Drawing::of(panel.place.name(), &wanted, &mut |request| {
            let reply = Handle::current().block_on(panel.engine.call(request));
            reply.map_err(|e| {
                refusal = Some(e);
                Refusal::AlreadyReported
            })
        });
        match (drawing, refusal) {
            (Ok(drawing), _) => Ok(text(&drawing, Format::Svg)),
            (Err(_), Some(refusal)) => Err(refusal),
            (Err(e), None) => Err(Error::new(Code::Refused, e.to_string())),
        }
    });
    drop(reading);
    let mut response = drawn?.into_response();
    let kind = HeaderValue::from_static("image/svg+xml");
    response.headers_mut().insert(header::CONTENT_TYPE, kind);
    Ok(response)
}
