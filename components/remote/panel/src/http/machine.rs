//! The machine's files: tools, offsets, and the paths of programs.

use super::sent;
use crate::{
    error::{Code, Error},
    folders::whole,
    geometry,
    pool::Work,
    server::Panel,
    session::Session,
};
use axum::{
    Json,
    extract::{Path, RawQuery, State},
    http::{HeaderName, HeaderValue, header},
    response::{IntoResponse as _, Response},
};
use hal_gcode::{axis::Axis, parameters::number};
use hal_job::{Files, Machine, world::text_of};
use serde_json::{Value as Json_, json};
use std::sync::Arc;
use tokio::task::block_in_place;

/// Names of the coordinate systems.
const SYSTEMS: [&str; 9] = ["G54", "G55", "G56", "G57", "G58", "G59", "G59.1", "G59.2", "G59.3"];
/// Largest cutter-location file that is shown, in bytes.
const MAX_CUTTER: u64 = 16 << 20;
/// Header with the reason why a program was not read to its end.
const ERROR: HeaderName = HeaderName::from_static("x-ferrule-error");
/// Header with the frame of the part: X Y Z, roll, pitch and yaw.
const FRAME: HeaderName = HeaderName::from_static("x-ferrule-frame");
/// Header with the cutters that a cutter-location file names.
const CUTTERS: HeaderName = HeaderName::from_static("x-ferrule-cutters");

impl Panel {
    /// Reads the files of the machine.
    fn files(&self) -> Result<Machine, Error> {
        let files = Files { ini: self.options.ini_file.as_deref(), ..Files::default() };
        block_in_place(|| Machine::read(&files)).map_err(|e| Error::new(Code::Disk, e))
    }
}

/// Lists the tool table.
pub(crate) async fn tools(State(panel): State<Arc<Panel>>, _: Session) -> Result<Response, Error> {
    let machine = panel.files()?;
    let tools = machine.tools.tools.iter().map(|tool| {
        json!({
            "number": tool.number,
            "pocket": tool.pocket,
            "offset": Axis::ALL.map(|axis| tool.offset[axis]),
            "diameter": tool.diameter,
            "front": tool.front,
            "back": tool.back,
            "orientation": tool.orientation,
            "comment": tool.remark,
        })
    });
    Ok(Json(tools.collect::<Vec<_>>()).into_response())
}

/// Lists the coordinate systems: those of the parameter file, and the one in force as the task has it.
pub(crate) async fn offsets(
    State(panel): State<Arc<Panel>>,
    _: Session,
) -> Result<Response, Error> {
    let machine = panel.files()?;
    let nine = |first: i32| -> Vec<f64> {
        (first..).take(9).map(|index| machine.numbered.get(index)).collect()
    };
    let now = panel.machine.borrow().clone();
    let task = |name: &str| now.task.as_ref().and_then(|task| task.get(name)).cloned();
    let current = task("system").and_then(|system| system.as_u64());
    let systems = (1_u64..).zip(SYSTEMS).zip((0..).step_by(20)).map(|((n, name), step)| {
        let stored = (
            json!(nine(number::G54 + step)),
            json!(machine.numbered.get(number::G54_ROTATION + step)),
        );
        let (offset, rotation): (Json_, Json_) = match (task("g5x_offset"), task("rotation")) {
            (Some(offset), Some(rotation)) if current == Some(n) => (offset, rotation),
            _ => stored,
        };
        json!({ "name": name, "offset": offset, "rotation": rotation })
    });
    let g92 = task("g92_offset").unwrap_or_else(|| json!(nine(number::G92)));
    Ok(Json(json!({ "systems": systems.collect::<Vec<_>>(), "g92": g92 })).into_response())
}

/// Returns the geometry of a program.
pub(crate) async fn path(
    State(panel): State<Arc<Panel>>,
    session: Session,
    Path(name): Path<String>,
    RawQuery(query): RawQuery,
) -> Result<Response, Error> {
    let (path, file) = panel.shown_program(&name)?;
    let wishes = wishes(query.as_deref().unwrap_or_default())?;
    let (cell, ini) = (panel.options.cell.clone(), panel.options.ini_file.clone());
    let is_inch = panel.is_inch;
    let read = move |work: &mut Work| {
        let refused = |why: String| Error::new(Code::Refused, why);
        if geometry::is_cutter(&name) {
            check_size(&file)?;
            let text = whole(file, MAX_CUTTER).map_err(|e| refused(hal_output::reason(&e)))?;
            let read = || geometry::Cut::read(cell.as_deref(), &path, &text, is_inch);
            let cut = work.apart(read)?.map_err(refused)?;
            work.look(cut.geometry.memory())?;
            return Ok((cut.geometry.bytes(), None, Some((cut.frame, cut.cutters))));
        }
        let text = text_of(file).map_err(|e| refused(hal_output::reason(&e)))?;
        let mut look = |bytes| work.look(bytes);
        let geometry = geometry::read(ini.as_deref(), &path, text, wishes, &mut look);
        let geometry = geometry.map_err(refused)?;
        Ok((geometry.bytes(), geometry.error, None))
    };
    let ((bytes, error, cut), mut seat) = panel.pool.run(session.seated(), read).await?;
    seat.take(bytes.capacity())?;
    let mut response = sent::body(bytes, seat).into_response();
    let kind = HeaderValue::from_static("application/octet-stream");
    response.headers_mut().insert(header::CONTENT_TYPE, kind);
    let mut add = |name: HeaderName, text: &str| {
        if let Ok(value) = HeaderValue::from_str(&encoded(text)) {
            response.headers_mut().insert(name, value);
        }
    };
    if let Some((line, text)) = error {
        add(ERROR, &format!("{line} {text}"));
    }
    if let Some((frame, cutters)) = cut {
        add(FRAME, &json!(frame).to_string());
        add(CUTTERS, &json!(cutters).to_string());
    }
    Ok(response)
}

/// Reads a query: `tolerance=NUMBER` and `planned`, in any order.
fn wishes(query: &str) -> Result<geometry::Wishes, Error> {
    let mut wishes = geometry::Wishes::default();
    for word in query.split('&').filter(|word| !word.is_empty()) {
        let number = word.strip_prefix("tolerance=").and_then(|t| t.parse::<f64>().ok());
        match (word, number.filter(|t| t.is_finite() && *t >= 0.0)) {
            ("planned", _) => wishes.is_planned = true,
            (_, Some(tolerance)) => wishes.tolerance = tolerance,
            (_, None) => {
                let text = format!("'{word}' is neither tolerance=NUMBER nor planned");
                return Err(Error::new(Code::Malformed, text));
            }
        }
    }
    Ok(wishes)
}

/// Refuses a cutter-location file that is too large for a picture: an arm's path along it is planned in one piece.
fn check_size(file: &std::fs::File) -> Result<(), Error> {
    let bytes = file.metadata().map_or(0, |about| about.len());
    if bytes <= MAX_CUTTER {
        return Ok(());
    }
    let text =
        format!("a cutter-location file has {bytes} bytes; those up to {MAX_CUTTER} are shown");
    Err(Error::new(Code::TooLarge, text))
}

/// Returns a text with percent signs for everything that a header might not hold.
pub(super) fn encoded(text: &str) -> String {
    let plain = |byte: u8| byte.is_ascii_alphanumeric() || b"-_.".contains(&byte);
    text.bytes()
        .map(|byte| if plain(byte) { char::from(byte).to_string() } else { format!("%{byte:02X}") })
        .collect()
}
