//! Alignment: what the component align knows, live pictures of its camera, and programs that are rewritten to the part.

use super::{
    machine::encoded,
    pictures::{LOOK, View},
    programs::{MAX_BYTES, disk},
};
use crate::{
    error::{Code, Error},
    folders::{refused as unopened, whole},
    server::Panel,
    session::{Role, Session},
};
use axum::{
    Json,
    extract::{Path, RawQuery, State},
    http::{HeaderName, HeaderValue, StatusCode, header},
    response::{IntoResponse as _, Response},
};
use hal_align::{
    Matrix, Transform, Vector,
    rewrite::{Arcs, Refusal, Rules, rewrite as rewritten},
};
use serde_json::{Value, json};
use std::{io::Write as _, path::PathBuf, sync::Arc, time::Duration};
use tokio::{
    task::block_in_place,
    time::{Instant, sleep},
};

/// Header with what is in a picture.
const VIEW: HeaderName = HeaderName::from_static("x-ferrule-view");
/// Longest wait for a new picture.
const WAIT: Duration = Duration::from_secs(5);
/// Begin of the name of a rewritten program.
const ALIGNED: &str = "aligned-";
/// Largest number of refused lines that are reported.
const MAX_REPORTED: usize = 5;

impl Panel {
    /// Returns the file into which the component writes pictures.
    pub(crate) fn view_file(&self) -> PathBuf {
        self.place.folder().join(format!("panel-{}.view", self.place.name()))
    }
}

/// Returns marks, fit and camera.
pub(crate) async fn state(State(panel): State<Arc<Panel>>, _: Session) -> Result<Response, Error> {
    let json = panel.pictures.known(&panel.engine).await?;
    Ok(([(header::CONTENT_TYPE, "application/json")], json.to_string()).into_response())
}

/// Returns the next picture of the camera that is not the one of `after`.
pub(crate) async fn picture(
    State(panel): State<Arc<Panel>>,
    _: Session,
    RawQuery(query): RawQuery,
) -> Result<Response, Error> {
    let after = match query.as_deref() {
        None | Some("") => None,
        Some(query) => {
            let number = query.strip_prefix("after=").and_then(|t| t.parse::<u64>().ok());
            Some(number.ok_or_else(|| {
                Error::new(Code::Malformed, format!("'{query}' is not after=NUMBER"))
            })?)
        }
    };
    let file = panel.view_file();
    let begun = Instant::now();
    loop {
        let view = panel.pictures.newest(&panel.wiring, &file).await?;
        if let Some(view) = view.filter(|view| after.is_none() || view.number != after) {
            return Ok(answer(&view));
        }
        if begun.elapsed() >= WAIT {
            return Ok(StatusCode::NO_CONTENT.into_response());
        }
        sleep(LOOK).await;
    }
}

/// Answers with a picture, or without content where the camera has none: the header then has the problem.
fn answer(View { head, bytes, .. }: &View) -> Response {
    let kind = match head.get("kind").and_then(Value::as_str) {
        Some("image/png") => Some("image/png"),
        Some("image/jpeg") => Some("image/jpeg"),
        _ => None,
    };
    let mut response = match kind {
        Some(_) => bytes.clone().into_response(),
        None => StatusCode::NO_CONTENT.into_response(),
    };
    if let Some(kind) = kind {
        response.headers_mut().insert(header::CONTENT_TYPE, HeaderValue::from_static(kind));
    }
    if let Ok(value) = HeaderValue::from_str(&encoded(&head.to_string())) {
        response.headers_mut().insert(VIEW, value);
    }
    response
}

/// Rewrites a program to the place of the part, and stores it beside the first.
pub(crate) async fn rewrite(
    State(panel): State<Arc<Panel>>,
    session: Session,
    Path(name): Path<String>,
    Json(asked): Json<Value>,
) -> Result<Response, Error> {
    session.needs(Role::Operator)?;
    let arcs = match asked.get("arcs").and_then(Value::as_str) {
        None | Some("lines") => Arcs::Lines,
        Some("refuse") => Arcs::Refuse,
        Some(other) => {
            return Err(Error::new(Code::Malformed, format!("arcs is {other}: lines or refuse")));
        }
    };
    let source = panel.folders.program(&name)?;
    let target = panel.folders.upload(&format!("uploads/{ALIGNED}{}", source.plain()))?;
    let new = target.name();
    let transform = place(&panel.pictures.known(&panel.engine).await?)?;
    panel.check_idle(&target.path())?;
    let rules = Rules { arcs, header: Some(name), inches: panel.is_inch, ..Rules::default() };
    let done = block_in_place(|| {
        let text = whole(source.open()?, MAX_BYTES).map_err(|e| disk(&e))?;
        let done = rewritten(&text, &transform, &rules).map_err(|all| refused(&all))?;
        let mut file = target.create()?;
        file.write_all(&done.text).map_err(|e| disk(&e))?;
        file.finish().map_err(unopened)?;
        Ok::<_, Error>(done)
    })?;
    panel.audit.note(&session.user, 0, &json!({ "align": new }), Ok(()));
    Ok(Json(json!({
        "name": new, "bytes": done.text.len(), "changed": done.changed, "arcs": done.arcs,
        "chords": done.chords, "feed_is_uneven": done.feed_is_uneven,
    }))
    .into_response())
}

/// Returns the place of the part, from the answer of the component.
fn place(answer: &str) -> Result<Transform, Error> {
    let answer: Value = serde_json::from_str(answer).unwrap_or_default();
    let is_solved = answer.get("fit").is_some_and(Value::is_object);
    let numbers = answer.get("place").and_then(Value::as_array).filter(|_| is_solved);
    let numbers: Vec<f64> = numbers.into_iter().flatten().filter_map(Value::as_f64).collect();
    let [m11, m12, m21, m22, x, y] = numbers.as_slice() else {
        return Err(Error::new(Code::Conflict, "the marks do not give the place of the part yet"));
    };
    Ok(Transform { linear: Matrix::new(*m11, *m12, *m21, *m22), shift: Vector::new(*x, *y) })
}

/// Names the lines that cannot be rewritten.
fn refused(all: &[Refusal]) -> Error {
    let reported = all.iter().take(MAX_REPORTED).map(|r| format!("line {}: {}", r.line, r.reason));
    let mut text = reported.collect::<Vec<_>>().join("; ");
    if all.len() > MAX_REPORTED {
        text.push_str(&format!("; and {} more", all.len() - MAX_REPORTED));
    }
    Error::new(Code::Refused, text)
}

#[cfg(test)]
mod tests {
    //! Places that are known, and those that are not; programs of machines with either unit of length.

    use super::{Arc, Code, Json, Panel, Path, State, json, place, rewrite};
    use crate::{
        engine::Engine,
        folders::Folders,
        lease::tests::{run, session},
    };
    use hal_protocol::{Answer, Reply, Request};
    use std::fs;

    #[test]
    fn only_a_place_that_is_solved_counts() {
        let solved = r#"{"fit": {"rms": 0}, "place": [1.2, 0, 0, 1.1, 100, 50]}"#;
        let found = place(solved).unwrap();
        assert_eq!((found.linear.m11, found.shift.y), (1.2, 50.0));
        for none in [
            "",
            "{}",
            r#"{"fit": null, "place": [1, 0, 0, 1, 0, 0]}"#,
            r#"{"fit": {}, "place": [1, 0, 0, 1, null, 0]}"#,
            r#"{"fit": {}, "place": [1, 0, 0, 1, 0, 0, 0]}"#,
        ] {
            assert_eq!(place(none).unwrap_err().code, Code::Conflict, "{none}");
        }
    }

    #[test]
    fn a_program_without_a_unit_is_in_the_unit_of_the_machine() {
        for (is_inch, text, wanted) in [
            (false, "G90 G0 X1 Y2\nM2\n", "G0 X26.4000 Y52.8000"),
            (true, "G90 G0 X1 Y2\nM2\n", "G0 X2.00000 Y4.00000"),
            (true, "G21 G90 G0 X1 Y2\nM2\n", "G0 X26.4000 Y52.8000"),
            (false, "G20 G90 G0 X1 Y2\nM2\n", "G0 X2.00000 Y4.00000"),
        ] {
            let engine = Engine::that(|request| {
                let Request::Command { .. } = request else { return Ok(Reply::Done) };
                let known = json!({ "fit": {}, "place": [1, 0, 0, 1, 25.4, 50.8] });
                let lines = vec![known.to_string()];
                Ok(Reply::Answer(Answer { lines, ticket: None, awaited: false }))
            });
            let mut panel = Panel::that(engine, &format!("align-{is_inch}-{}", text.len()));
            let folder = panel.place.folder().to_owned();
            panel.is_inch = is_inch;
            panel.folders = Folders::of(folder.clone());
            fs::write(folder.join("a.ngc"), text).unwrap();
            let (name, asked) = (Path("a.ngc".to_owned()), Json(json!({})));
            let panel = State(Arc::new(panel));
            run(async { tokio::spawn(rewrite(panel, session("ana"), name, asked)).await.unwrap() })
                .unwrap();
            let done = fs::read_to_string(folder.join("uploads/aligned-a.ngc")).unwrap();
            fs::remove_dir_all(&folder).unwrap();
            assert!(done.contains(wanted), "inch {is_inch}, {text}: {done}");
        }
    }
}
