//! Waveforms that are kept in files beside their test.

use super::{
    failure::Failure,
    outcome::{Complaint, Outcome, Picture},
};
use crate::ini::plain;
use hal_trace::draw;
use std::{
    fs,
    path::{Path, PathBuf},
};

/// Maximum number of differences reported for one waveform.
const TOLD: usize = 12;

/// Returns the file in which a test keeps a waveform: `TEST.NAME.wave`.
pub(super) fn path(test: &Path, name: &str) -> PathBuf {
    test.with_extension(format!("{name}.wave"))
}

/// Compares the waveforms with their files.
pub(super) fn differences(pictures: &mut [Picture]) -> Vec<Complaint> {
    pictures.iter_mut().filter_map(difference).collect()
}

fn difference(picture: &mut Picture) -> Option<Complaint> {
    let shown = picture.path.display();
    let drawn = |complaint: Complaint, text: &str| {
        text.lines().fold(complaint, |c, line| c.with(format!("  {line}")))
    };
    let kept = match fs::read_to_string(&picture.path) {
        Ok(kept) => kept,
        Err(error) if error.kind() == std::io::ErrorKind::NotFound => {
            let text = format!("the snapshot '{}' is not kept yet", picture.name);
            let how = format!("'haltest --accept' writes {shown}:");
            return Some(drawn(Complaint::new(&picture.spot, text).with(how), &picture.drawing));
        }
        Err(error) => {
            let text = format!("{shown} cannot be read: {}", plain(&error));
            return Some(Complaint::new(&picture.spot, text));
        }
    };
    if kept == picture.drawing {
        picture.same = true;
        return None;
    }
    let text = format!("the snapshot '{}' is not what {shown} has", picture.name);
    let mut complaint = Complaint::new(&picture.spot, text);
    let told = draw::differences(&kept, &picture.drawing);
    for line in told.iter().take(TOLD) {
        complaint = complaint.with(line.clone());
    }
    if told.len() > TOLD {
        complaint = complaint.with(format!("and {} more", told.len() - TOLD));
    }
    let complaint = drawn(complaint.with("expected:"), &kept);
    Some(drawn(complaint.with("found:"), &picture.drawing))
}

/// Writes the waveforms of a test that has no other failure. Returns the files that were written.
pub(super) fn accept(outcome: &mut Outcome) -> Result<Vec<PathBuf>, Failure> {
    if !outcome.is_acceptable() {
        return Ok(Vec::new());
    }
    let mut written = Vec::new();
    for picture in outcome.pictures.iter_mut().filter(|p| !p.same) {
        hal_output::write(&picture.path, picture.drawing.as_bytes())
            .map_err(|e| Failure::file(&picture.path, &e))?;
        picture.same = true;
        written.push(picture.path.clone());
    }
    outcome.complaints.clear();
    Ok(written)
}
