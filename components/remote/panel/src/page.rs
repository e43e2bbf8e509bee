//! The page's files: those in the program, or those of a folder; and the manual, below `manual/`.

use crate::{
    error::{Code, Error},
    folders::whole,
};
use axum::{
    body::Body,
    http::{HeaderMap, HeaderValue, header},
    response::{IntoResponse as _, Response},
};
use flate2::read::GzDecoder;
use hal_beneath::{Beneath, RelativeName};
use std::{io::Read as _, path::Path};
use tokio::task::block_in_place;

/// Largest file of a folder in bytes.
const MAX_BYTES: u64 = 16 << 20;

/// Names and gzipped contents of the files in the program.
const FILES: &[(&str, &[u8])] = include!(concat!(env!("OUT_DIR"), "/page.rs"));

/// Types of files, by their extension.
const TYPES: &[(&str, &str)] = &[
    ("html", "text/html; charset=utf-8"),
    ("js", "text/javascript; charset=utf-8"),
    ("mjs", "text/javascript; charset=utf-8"),
    ("css", "text/css; charset=utf-8"),
    ("json", "application/json"),
    ("webmanifest", "application/manifest+json"),
    ("svg", "image/svg+xml"),
    ("png", "image/png"),
    ("ico", "image/x-icon"),
    ("woff2", "font/woff2"),
    ("txt", "text/plain; charset=utf-8"),
    ("md", "text/plain; charset=utf-8"),
];

/// Answers a request for a file of the page.
pub(crate) async fn file(folder: Option<&Path>, path: &str, asked: &HeaderMap) -> Response {
    let name = path.trim_start_matches('/');
    let name = if name.is_empty() { "index.html" } else { name };
    let missing = || Error::new(Code::NotFound, format!("the page has no file '{name}'"));
    let kind = Path::new(name).extension().and_then(|e| e.to_str());
    let kind = kind.and_then(|e| TYPES.iter().find(|(extension, _)| *extension == e));
    let Some((_, kind)) = kind else { return missing().into_response() };
    let mut gzipped = false;
    let manual = name.strip_prefix("manual/");
    let body = if let Some(folder) = folder.filter(|_| manual.is_none()) {
        match block_in_place(|| of_folder(folder, name)) {
            Some(bytes) => Body::from(bytes),
            None => return missing().into_response(),
        }
    } else {
        let (files, name) = manual.map_or((FILES, name), |name| (hal_docs::FILES, name));
        let Some((_, bytes)) = files.iter().find(|(n, _)| *n == name) else {
            return missing().into_response();
        };
        let accepts = asked.get(header::ACCEPT_ENCODING).and_then(|v| v.to_str().ok());
        gzipped = accepts.is_some_and(|v| v.contains("gzip"));
        if gzipped {
            Body::from(*bytes)
        } else {
            let mut plain = Vec::new();
            match GzDecoder::new(*bytes).read_to_end(&mut plain) {
                Ok(_) => Body::from(plain),
                Err(_) => return missing().into_response(),
            }
        }
    };
    let mut response = Response::new(body);
    let headers = response.headers_mut();
    headers.insert(header::CONTENT_TYPE, HeaderValue::from_static(kind));
    headers.insert(header::CACHE_CONTROL, HeaderValue::from_static("no-cache"));
    headers.insert(header::VARY, HeaderValue::from_static("accept-encoding"));
    if gzipped {
        headers.insert(header::CONTENT_ENCODING, HeaderValue::from_static("gzip"));
    }
    response
}

/// Reads a file of a folder with the page.
fn of_folder(folder: &Path, name: &str) -> Option<Vec<u8>> {
    let file = Beneath::open(folder).ok()?.read(&RelativeName::parse(name).ok()?).ok()?;
    whole(file, MAX_BYTES).ok()
}
