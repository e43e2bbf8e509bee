//! Programs: those of the machine, and those that are sent.

use super::sent;
use crate::{
    error::{Code, Error},
    folders::{refused as unopened, whole},
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
use hal_beneath::Found;
use serde_json::{Value, json};
use std::{
    fs::File,
    io::{self, ErrorKind, Write as _},
    path::PathBuf,
    sync::Arc,
};
use tokio::task::block_in_place;

/// Largest program in bytes.
pub(super) const MAX_BYTES: u64 = 256 << 20;

impl Panel {
    /// Returns the file of the program of a teleoperated job. It is none of the user's: its name begins with a dot.
    pub(crate) fn teleop_file(&self) -> PathBuf {
        self.place.folder().join(format!(".teleop-{}.ngc", self.place.name()))
    }

    /// Opens a program that is only read: one of the folders, or that of a teleoperated job. Returns its path, too.
    pub(crate) fn shown_program(&self, name: &str) -> Result<(PathBuf, File), Error> {
        let teleop = self.teleop_file();
        if teleop.file_name().is_some_and(|file| file == name) {
            let file = File::open(&teleop).map_err(|e| disk(&e))?;
            return Ok((teleop, file));
        }
        let program = self.folders.program(name)?;
        Ok((program.path(), program.open()?))
    }

    /// Refuses to change a file while a program runs: it may be one of its subroutines.
    pub(crate) fn check_idle(&self, path: &std::path::Path) -> Result<(), Error> {
        let machine = self.machine.borrow();
        let Some(task) = &machine.task else { return Ok(()) };
        let runs = task.get("interpreter").and_then(Value::as_u64) != Some(0);
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

/// Lists the programs.
pub(crate) async fn list(State(panel): State<Arc<Panel>>, _: Session) -> Result<Response, Error> {
    let list = block_in_place(|| panel.folders.programs())?;
    Ok(Json(list.iter().map(listed).collect::<Vec<_>>()).into_response())
}

/// Returns the entry of a file in a list.
pub(super) fn listed(found: &Found) -> Value {
    json!({ "name": found.name, "bytes": found.bytes, "modified": found.modified })
}

/// Returns the text of a program.
pub(crate) async fn text(
    State(panel): State<Arc<Panel>>,
    session: Session,
    Path(name): Path<String>,
) -> Result<Response, Error> {
    let mut seat = panel.pool.seat(session.seated())?;
    let text = block_in_place(|| -> Result<_, Error> {
        let (_, file) = panel.shown_program(&name)?;
        let bytes = file.metadata().map_or(0, |about| about.len());
        seat.take(usize::try_from(bytes).unwrap_or(usize::MAX))?;
        whole(file, MAX_BYTES).map_err(|e| disk(&e))
    })?;
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
    let program = panel.folders.upload(&name)?;
    let (name, path) = (program.name(), program.path());
    panel.check_idle(&path)?;
    let mut file = block_in_place(|| program.create())?;
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
    block_in_place(|| file.finish()).map_err(unopened)?;
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
    let program = panel.folders.upload(&name)?;
    let name = program.name();
    panel.check_idle(&program.path())?;
    block_in_place(|| program.remove())?;
    panel.audit.note(&session.user, 0, &json!({ "remove": name }), Ok(()));
    Ok(Json(json!({})).into_response())
}
