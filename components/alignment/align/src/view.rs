//! Pictures for people who watch: the camera at the machine's present position, with the marks in it.

use crate::{
    bench::Bench,
    eye::Station,
    job::{MarkJob, NO_CAMERA, Pictures, draw},
    lock,
    report::{pair, six},
};
use hal_align::{Transform, Vector};
use hal_marks::{Camera, Picture, Search, Table, choose, read_picture, search};
use serde_json::{Map, Value as Json, json};
use std::{
    path::PathBuf,
    sync::{Arc, Mutex, PoisonError},
};

/// Time between two pictures, in nanoseconds.
const EVERY_NS: i64 = 100_000_000;

/// File for pictures.
#[derive(Clone, Debug)]
struct Watch {
    file: PathBuf,
    /// Machine time at which the pictures end, in nanoseconds.
    until: i64,
}

/// The file for which somebody has asked.
#[derive(Clone, Debug, Default)]
pub(crate) struct Watched(Arc<Mutex<Option<Watch>>>);

impl Watched {
    /// Asks for pictures.
    pub(crate) fn watch(&self, file: PathBuf, now: i64, seconds: f64) {
        #[expect(clippy::cast_possible_truncation, reason = "at most a minute")]
        let until = now.saturating_add((seconds * 1e9) as i64);
        *self.0.lock().unwrap_or_else(PoisonError::into_inner) = Some(Watch { file, until });
    }

    fn get(&self) -> Option<Watch> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).clone()
    }
}

/// Pictures so far.
pub(crate) struct View {
    watched: Watched,
    /// Machine time before which no picture comes.
    next: i64,
    number: u64,
}

/// Fields of the JSON object before a picture.
type Head = Map<String, Json>;

/// Origin of a picture, as it was when it was asked for.
enum Origin {
    None(&'static str),
    Table(Box<Table>),
    File(PathBuf),
}

impl View {
    pub(crate) const fn new(watched: Watched) -> Self {
        Self { watched, next: 0, number: 0 }
    }

    /// Returns whether somebody waits for a picture now; the next one is due after a while.
    pub(crate) fn take_turn(&mut self, now: i64) -> bool {
        let is_due = self.next <= now && self.watched.get().is_some_and(|watch| now < watch.until);
        if is_due {
            self.next = now.saturating_add(EVERY_NS);
        }
        is_due
    }

    /// Takes a picture, and writes it. The bench is free meanwhile.
    pub(crate) fn show(&mut self, bench: &Arc<Mutex<Bench>>, station: &Station) {
        let Some(watch) = self.watched.get() else { return };
        let (origin, camera, wanted) = {
            let bench = lock(bench);
            (origin(&bench.job), bench.job.camera, bench.job.wanted())
        };
        self.number += 1;
        let mut head = Head::new();
        head.insert("number".to_owned(), self.number.into());
        head.insert("at".to_owned(), pair(station.at()));
        let bytes = match take(&origin, station, self.number) {
            Ok((bytes, picture)) => {
                let is_png = bytes.starts_with(b"\x89PNG");
                let kind = if is_png { "image/png" } else { "image/jpeg" };
                head.insert("kind".to_owned(), kind.into());
                describe(&mut head, &picture, &camera, &wanted, station.at());
                bytes
            }
            Err(why) => {
                head.insert("problem".to_owned(), why.into());
                Vec::new()
            }
        };
        let mut text = Json::Object(head).to_string().into_bytes();
        text.push(b'\n');
        text.extend(bytes);
        // Who watches asks again; a folder that has gone needs no picture.
        drop(hal_output::write(&watch.file, &text));
    }
}

fn origin(job: &MarkJob) -> Origin {
    match &job.pictures {
        Pictures::None => Origin::None(NO_CAMERA),
        Pictures::Table(table) => Origin::Table(table.clone()),
        Pictures::Files(source) => {
            source.latest().map_or(Origin::None("no picture has come yet"), Origin::File)
        }
    }
}

/// Takes a picture; returns its bytes too.
fn take(origin: &Origin, station: &Station, number: u64) -> Result<(Vec<u8>, Picture), String> {
    match origin {
        Origin::None(why) => Err((*why).to_owned()),
        Origin::Table(table) => {
            // The noise is none of a look: what is measured does not depend on who watches.
            let picture = draw(table, station, !number);
            let picture = picture.ok_or_else(|| "the camera takes no picture".to_owned())?;
            Ok((picture.png(), picture))
        }
        Origin::File(path) => read_picture(path).map_err(|e| e.to_string()),
    }
}

/// Describes a picture.
fn describe(head: &mut Head, picture: &Picture, camera: &Camera, wanted: &Search, at: Vector) {
    let size = (picture.width(), picture.height());
    let seen = search(picture, wanted);
    let chosen = choose(&seen, Camera::middle(size));
    let marks = seen.marks.iter().map(|mark| {
        json!({
            "kind": mark.kind.name(), "x": mark.centre.x, "y": mark.centre.y, "angle": mark.angle,
            "uncertainty": mark.uncertainty, "size": wanted.kind.side(mark.area),
            "is_chosen": chosen.as_ref().is_ok_and(|c| c.centre == mark.centre),
        })
    });
    let marks = marks.collect::<Vec<_>>();
    let origin = camera.machine(at, size, Vector::ZERO);
    let inverse = Transform { linear: camera.linear, shift: origin }.inverse();
    let fields = [
        ("marks", marks.into()),
        ("problem", chosen.err().map(|why| why.to_string()).into()),
        ("width", size.0.into()),
        ("height", size.1.into()),
        ("to_picture", inverse.as_ref().map(six).into()),
    ];
    head.extend(fields.map(|(name, value): (&str, Json)| (name.to_owned(), value)));
}
