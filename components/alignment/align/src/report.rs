//! State of the alignment as lines, and as JSON for programs.

use crate::bench::Bench;
use hal_align::{Matrix, Transform, Vector};
use serde_json::{Value as Json, json};

impl Bench {
    /// Returns the state as lines.
    pub(crate) fn status(&self) -> Vec<String> {
        let mut out = Vec::new();
        for (n, (file, measured)) in (1..).zip(self.job.marks.iter().zip(&self.measured)) {
            let place = measured.map_or("not measured".to_owned(), |m| {
                let m = m.place;
                let residual = self.fit.as_ref().map(|f| m - f.transform.apply(*file));
                let residual = residual
                    .map_or(String::new(), |r| format!(", residual X {:.4} Y {:.4} mm", r.x, r.y));
                format!("found at {m}{residual}")
            });
            out.push(format!("mark {n}: X {} Y {}, {place}", file.x, file.y));
        }
        if !self.touched.is_empty() {
            out.push(format!("touched marks: {}", self.touched.len()));
        }
        if let Some(fit) = &self.fit {
            out.push(format!(
                "{}: {}, rms {:.4} mm",
                fit.model.name(),
                fit.transform.parts(),
                fit.rms
            ));
            out.extend(fit.transform.warnings().iter().map(|w| format!("warning: {w}")));
        }
        if !self.sights.is_empty() {
            out.push(format!("sights for the calibration: {}", self.sights.len()));
        }
        if !self.problem.is_empty() {
            out.push(self.problem.clone());
        }
        out
    }

    /// Returns the state as JSON.
    pub(crate) fn json(&mut self) -> Json {
        let found = self.marks();
        let guess = self.guess(&found);
        let place_of = |file: &Vector| self.fit.as_ref().map(|f| f.transform.apply(*file));
        let off = |file: &Vector, at: Vector| place_of(file).map(|place| pair(at - place));
        let marks = self.job.marks.iter().zip(&self.measured).enumerate();
        let marks = marks.map(|(n, (file, measured))| {
            let expected = self.expected(n, found.len(), &guess);
            json!({
                "file": pair(*file),
                "expected": expected.map(pair),
                "aim": expected.map(|e| pair(e - self.job.camera.offset)),
                "machine": measured.map(|m| pair(m.place)),
                "uncertainty": measured.map(|m| m.uncertainty),
                "residual": measured.and_then(|m| off(file, m.place)),
            })
        });
        let touched = self.touched.iter().map(|m| {
            let (file, machine) = (pair(m.file), pair(m.machine));
            json!({ "file": file, "machine": machine, "residual": off(&m.file, m.machine) })
        });
        let fit = self.fit.as_ref().map(|fit| {
            let parts = fit.transform.parts();
            let warnings: Vec<_> =
                fit.transform.warnings().iter().map(ToString::to_string).collect();
            json!({
                "model": fit.model.name(), "rms": fit.rms, "warnings": warnings,
                "theta": parts.turn, "sx": parts.scale_x, "sy": parts.scale_y, "shear": parts.shear,
                "tx": parts.shift.x, "ty": parts.shift.y,
            })
        });
        let live = self.live.as_ref().map(|live| {
            let parts = live.parts();
            json!({ "theta": parts.turn, "x": parts.shift.x, "y": parts.shift.y })
        });
        let place = self.fit.as_ref().map_or(guess, |fit| fit.transform);
        let source = self.job.source;
        let m = self.job.camera.linear;
        json!({
            "marks": marks.collect::<Vec<_>>(),
            "touched": touched.collect::<Vec<_>>(),
            "kind": self.job.kind.name(), "size": self.job.size,
            "model": self.job.options.model.name(), "tolerance": self.job.options.tolerance,
            "place": six(&place), "fit": fit, "live": live,
            "camera": { "source": source, "matrix": four(&m), "offset": pair(self.job.camera.offset) },
            "sights": self.sights.len(), "problem": self.problem,
        })
    }
}

/// Returns X and Y.
pub(crate) fn pair(v: Vector) -> Json {
    json!([v.x, v.y])
}

/// Returns the four numbers of a matrix, row by row.
fn four(m: &Matrix) -> Json {
    json!([m.m11, m.m12, m.m21, m.m22])
}

/// Returns the matrix of a transform, row by row, and its shift.
pub(crate) fn six(t: &Transform) -> Json {
    let m = t.linear;
    json!([m.m11, m.m12, m.m21, m.m22, t.shift.x, t.shift.y])
}
