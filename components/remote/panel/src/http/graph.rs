//! The machine's wiring as a picture.

use super::{lists::patterns, sent};
use crate::{
    error::{Code, Error},
    pool::Work,
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
use tokio::runtime::Handle;

/// Most pins of a picture.
const MAX_PINS: usize = 20_000;

/// Draws what matches the patterns of the query, or all.
pub(crate) async fn svg(
    State(panel): State<Arc<Panel>>,
    session: Session,
    RawQuery(query): RawQuery,
) -> Result<Response, Error> {
    let patterns = patterns(query.as_deref().unwrap_or_default())?;
    let wanted = Wanted { patterns, ..Wanted::default() };
    let (engine, name) = (panel.engine.clone(), panel.place.name().to_owned());
    let draw = move |work: &mut Work| {
        let mut refusal = None;
        let drawing = Drawing::of(&name, &wanted, &mut |request| {
            let reply = work.look(0).map_err(Error::from);
            let reply = reply.and_then(|()| Handle::current().block_on(engine.call(request)));
            reply.map_err(|e| {
                refusal = Some(e);
                Refusal::AlreadyReported
            })
        });
        let drawing = match (drawing, refusal) {
            (Ok(drawing), _) => drawing,
            (Err(_), Some(refusal)) => return Err(refusal),
            (Err(e), None) => return Err(Error::new(Code::Refused, e.to_string())),
        };
        let sections = drawing.boxes.iter().flat_map(|part| &part.sections);
        let pins: usize = sections.map(|s| s.left.len() + s.right.len()).sum();
        if pins > MAX_PINS {
            let text = format!(
                "{pins} pins are too many for a picture; select at most {MAX_PINS} by a pattern"
            );
            return Err(Error::new(Code::TooLarge, text));
        }
        Ok(work.apart(|| text(&drawing, Format::Svg))?.into_bytes())
    };
    let (drawn, mut seat) = panel.pool.run(session.seated(), draw).await?;
    seat.take(drawn.capacity())?;
    let mut response = sent::body(drawn, seat).into_response();
    let kind = HeaderValue::from_static("image/svg+xml");
    response.headers_mut().insert(header::CONTENT_TYPE, kind);
    Ok(response)
}
