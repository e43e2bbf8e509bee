//! Programs: files of one folder.

use super::sent;
use crate::{
    error::{Code, Error},
    server::Panel,
    session::{Role, Session},
};
use axum::{
    Json,
    body::{Body, HttpBody as _},
    extract::{Path, State},
    http::header,
    response::{IntoResponse as _, Response},
};
use core::{future::poll_fn, pin::Pin};
use hal_output::Whole;
use serde_json::json;
use std::{
    fs,
    io::{self, ErrorKind, Write as _},
    path::PathBuf,
    sync::Arc,
    time::UNIX_EPOCH,
};
use tokio::task::block_in_place;

/// Number of programs that are listed.
const MAX_LISTED: usize = 10_000;
/// Longest name of a program in bytes.
const MAX_NAME: usize = 200;
/// Largest program in bytes.
pub(super) const MAX_BYTES: u64 = 256 << 20;

impl Panel {
    /// Returns the path of a program.
    pub(crate) fn program(&self, name: &str) -> Result<PathBuf, Error> {
        let folder = self.programs.as_ref().ok_or_else(|| {
            let text = "there is no folder for programs: [DISPLAY]PROGRAM_PREFIX, or --programs";
            Error::new(Code::NotFound, text)
        })?;
        let usual = |c: char| c.is_alphanumeric() || "._- ".contains(c);
        if name.is_empty()
            || name.len() > MAX_NAME
            || name.starts_with('.')
            || !name.chars().all(usual)
        {
            let text =
                format!("'{name}' is no name of a program: letters, digits, '.', '_', '-', blanks");
            return Err(Error::new(Code::Malformed, text));
        }
        Ok(folder.join(name))
    }

    /// Returns the file of the program of a teleoperated job. It is none of the user's: its name begins with a dot.
    pub(crate) fn teleop_file(&self) -> PathBuf {
        self.place.folder().join(format!(".teleop-{}.ngc", self.place.name()))
    }

    /// Returns the path of a program that is only read: one of the folder, or that of a teleoperated job.
    pub(crate) fn shown_program(&self, name: &str) -> Result<PathBuf, Error> {
        let teleop = self.teleop_file();
        if teleop.file_name().is_some_and(|file| file == name) {
            return Ok(teleop);
        }
        self.program(name)
    }

    /// Refuses to change a file while a program runs: it may be one of its subroutines.
    pub(crate) fn check_idle(&self, path: &std::path::Path) -> Result<(), Error> {
        let machine = self.machine.borrow();
        let Some(task) = &machine.task else { return Ok(()) };
        let runs = task.get("interpreter").and_then(serde_json::Value::as_u64) != Some(0);
        if runs && path.exists() {
            let text = "a program runs, and this may be a part of it: it can be changed at its end";
            return Err(Error::new(Code::Conflict, text));
        }
        Ok(())
    }
}

pub(super) fn disk(error: &io::Error) -> Error {
    let code = if error.kind() == ErrorKind::NotFound { Code::NotFound } else { Code::Disk };
    Error::new(code, hal_output::reason(error))
}

/// Reads a file of at most this many bytes.
pub(super) fn whole(path: &std::path::Path, most: u64) -> io::Result<Vec<u8>> {
    let about = fs::metadata(path)?;
    let readable = about.is_file() && about.len() <= most;
    if readable { fs::read(path) } else { Err(ErrorKind::FileTooLarge.into()) }
}

/// Lists the programs.
pub(crate) async fn list(State(panel): State<Arc<Panel>>, _: Session) -> Result<Response, Error> {
    let Some(folder) = &panel.programs else { return Ok(Json(json!([])).into_response()) };
    let entries = block_in_place(|| -> io::Result<Vec<_>> {
        let mut list = Vec::new();
        for entry in fs::read_dir(folder)?.take(MAX_LISTED) {
            let entry = entry?;
            let name = entry.file_name().to_string_lossy().into_owned();
            let Ok(about) = fs::metadata(entry.path()) else { continue };
            if about.is_file() && panel.program(&name).is_ok() {
                let since = about.modified().ok().and_then(|t| t.duration_since(UNIX_EPOCH).ok());
                let modified = since.unwrap_or_default().as_secs_f64();
                list.push((name, about.len(), modified));
            }
        }
        list.sort_by(|a, b| a.0.cmp(&b.0));
        Ok(list)
    });
    let entries = entries.map_err(|e| disk(&e))?.into_iter();
    let entries = entries.map(
        |(name, bytes, modified)| json!({ "name": name, "bytes": bytes, "modified": modified }),
    );
    Ok(Json(entries.collect::<Vec<_>>()).into_response())
}

/// Returns the text of a program.
pub(crate) async fn text(
    State(panel): State<Arc<Panel>>,
    session: Session,
    Path(name): Path<String>,
) -> Result<Response, Error> {
    let path = panel.shown_program(&name)?;
    let mut seat = panel.pool.seat(session.seated())?;
    let bytes = fs::metadata(&path).map_or(0, |about| about.len());
    seat.take(usize::try_from(bytes).unwrap_or(usize::MAX))?;
    let text = block_in_place(|| whole(&path, MAX_BYTES)).map_err(|e| disk(&e))?;
    let kind = [(header::CONTENT_TYPE, "text/plain; charset=utf-8")];
    Ok((kind, sent::body(text, seat)).into_response())
}

/// Stores a program, as a whole or not at all.
pub(crate) async fn store(
    State(panel): State<Arc<Panel>>,
    session: Session,
    Path(name): Path<String>,
    mut body: Body,
) -> Result<Response, Error> {
    session.needs(Role::Operator)?;
    let path = panel.program(&name)?;
    panel.check_idle(&path)?;
    let mut file = block_in_place(|| Whole::create(&path)).map_err(|e| disk(&e))?;
    let mut bytes = 0_u64;
    while let Some(frame) = poll_fn(|cx| Pin::new(&mut body).poll_frame(cx)).await {
        let broken =
            |_| Error::new(Code::Malformed, "the upload has broken off: nothing of it is kept");
        let Ok(data) = frame.map_err(broken)?.into_data() else { continue };
        bytes += data.len() as u64;
        if bytes > MAX_BYTES {
            let text =
                format!("the program is longer than {MAX_BYTES} bytes: nothing of it is kept");
            return Err(Error::new(Code::TooLarge, text));
        }
        block_in_place(|| file.write_all(&data)).map_err(|e| disk(&e))?;
    }
    panel.check_idle(&path)?;
    block_in_place(|| file.finish()).map_err(|e| disk(&e))?;
    panel.audit.note(&session.user, 0, &json!({ "store": name, "bytes": bytes }), Ok(()));
    Ok(Json(json!({ "name": name, "bytes": bytes })).into_response())
}

/// Removes a program.
pub(crate) async fn remove(
    State(panel): State<Arc<Panel>>,
    session: Session,
    Path(name): Path<String>,
) -> Result<Response, Error> {
    session.needs(Role::Operator)?;
    let path = panel.program(&name)?;
    panel.check_idle(&path)?;
    block_in_place(|| fs::remove_file(&path)).map_err(|e| disk(&e))?;
    panel.audit.note(&session.user, 0, &json!({ "remove": name }), Ok(()));
    Ok(Json(json!({})).into_response())
}
