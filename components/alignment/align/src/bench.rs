//! Marks measured so far, the fit, looks and calibrations.

use crate::{
    eye::Station,
    job::{MarkJob, NO_CAMERA, Pictures, draw},
    pins::Results,
};
use hal_align::{Alignment, Conditions, Fit, Mark, Matrix, Misfit, Model, Transform, Vector, fit};
use hal_marks::{
    Calibration, Camera, FoundMark, Mean, Search, Sight, Unfound, average, calibrate, choose,
    search,
};
use std::{fmt, path::Path};

/// Largest number of sights of a calibration.
const MAX_SIGHTS: usize = 100;

/// Reasons why an action failed: number, and text for tickets.
macro_rules! failures {
    ($($name:ident = $number:literal, $text:literal;)*) => {
        /// Reason why an action failed.
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        pub(crate) enum Failure { $($name = $number,)* }

        impl Failure {
            /// Returns its text.
            pub(crate) const fn text(self) -> &'static str {
                match self { $(Self::$name => $text,)* }
            }

            /// Returns the text of a number, if it is that of a failure.
            pub(crate) const fn text_of(number: i32) -> Option<&'static str> {
                match number { $($number => Some($text),)* _ => None }
            }
        }
    };
}

failures! {
    NoMark = 1, "there is no such mark in the picture: see align.status";
    Ambiguous = 2, "two marks are about as near: move closer to the one that is meant";
    Scatter = 3, "the pictures differ: the camera or the part moves, or the picture is poor";
    NoPicture = 4, "there is no picture: see align.status";
    Moved = 5, "the machine moved during the look";
    NoSuchMark = 6, "the job has no mark of this number";
    NoPlace = 7, "the marks give no place: see align.status";
    NoCamera = 8, "the camera cannot be calibrated: see align.status";
}

/// State of the alignment.
#[derive(Default)]
pub(crate) struct Bench {
    pub(crate) job: MarkJob,
    /// Measured place of each mark of the job.
    pub(crate) measured: Vec<Option<Measured>>,
    /// Marks that were touched by the tool.
    pub(crate) touched: Vec<Mark>,
    pub(crate) fit: Option<Fit>,
    pub(crate) live: Option<Transform>,
    pub(crate) sights: Vec<Sight>,
    /// Number of pictures that were drawn, as a seed of their noise.
    drawn: u64,
    /// Place of the part by the marks so far, since it was first needed.
    guessed: Option<Transform>,
    /// Text of the last failure.
    pub(crate) problem: String,
}

/// A mark of the job that was found.
#[derive(Clone, Copy)]
pub(crate) struct Measured {
    /// Place on the machine, in millimetres.
    pub(crate) place: Vector,
    /// Standard deviation of the place, in millimetres.
    pub(crate) uncertainty: f64,
}

/// Camera as the worker needs it for a picture while the bench is free.
pub(crate) struct LentCamera {
    pictures: Pictures,
    wanted: Search,
    number: u64,
}

/// Picture that was searched, and its size.
type Searched = ((usize, usize), Result<FoundMark, Unfound>);

impl LentCamera {
    /// Takes the next picture and searches it, which may last. The error is a text.
    pub(crate) fn search(&mut self, station: &Station) -> Result<Option<Searched>, String> {
        let picture = match &mut self.pictures {
            Pictures::None => return Err(NO_CAMERA.to_owned()),
            Pictures::Table(table) => draw(table, station, self.number),
            Pictures::Files(source) => source.take().map_err(|problem| problem.to_string())?,
        };
        Ok(picture.map(|picture| {
            let size = (picture.width(), picture.height());
            (size, choose(&search(&picture, &self.wanted), Camera::middle(size)))
        }))
    }
}

/// Look in progress.
#[derive(Default)]
pub(crate) struct Look {
    found: Vec<FoundMark>,
    size: (usize, usize),
}

impl Bench {
    /// Reads a job.
    pub(crate) fn open(&mut self, path: &Path) -> Result<(), String> {
        let job = MarkJob::read(path)?;
        *self = Self { measured: vec![None; job.marks.len()], job, ..Self::default() };
        Ok(())
    }

    fn fail<T>(&mut self, failure: Failure, why: impl fmt::Display) -> Result<T, Failure> {
        self.problem = why.to_string();
        Err(failure)
    }

    /// Returns the longest wait for a picture, in seconds.
    pub(crate) const fn timeout(&self) -> f64 {
        self.job.timeout
    }

    /// Begins a look, at a mark of this number if it is given.
    pub(crate) fn begin(&mut self, mark: Option<u32>) -> Result<(), Failure> {
        if let Pictures::Files(source) = &mut self.job.pictures {
            source.skip();
        }
        mark.map_or(Ok(()), |mark| self.index(mark).map(|_| ()))
    }

    /// Returns the index of a mark.
    fn index(&mut self, mark: u32) -> Result<usize, Failure> {
        let index = usize::try_from(mark).ok().and_then(|n| n.checked_sub(1));
        let count = self.measured.len();
        match index.filter(|n| *n < count) {
            Some(index) => Ok(index),
            None if count == 0 => self.fail(Failure::NoSuchMark, "there is no job with marks"),
            None => {
                let text = format!("mark {mark}: the job has the marks 1 to {count}");
                self.fail(Failure::NoSuchMark, text)
            }
        }
    }

    /// Skips pictures that may still show what was there before a look, which began so many seconds ago. Returns true if
    /// that may be so.
    pub(crate) fn skip_early(&mut self, seconds: f64) -> bool {
        match &mut self.job.pictures {
            Pictures::Files(source) if source.is_live() && seconds < self.job.delay => {
                source.skip();
                true
            }
            _ => false,
        }
    }

    /// Lends the camera to the worker, until it is given back.
    pub(crate) fn lend(&mut self) -> LentCamera {
        self.drawn = self.drawn.wrapping_add(1);
        let pictures = core::mem::replace(&mut self.job.pictures, Pictures::None);
        LentCamera { pictures, wanted: self.job.wanted(), number: self.drawn }
    }

    /// Takes the camera back with the next picture of a look. Returns whether the look has all of them; `None` without a picture
    /// yet.
    pub(crate) fn give_back(
        &mut self,
        camera: LentCamera,
        searched: Result<Option<Searched>, String>,
        look: &mut Look,
    ) -> Result<Option<bool>, Failure> {
        self.job.pictures = camera.pictures;
        match searched {
            Err(problem) => return self.fail(Failure::NoPicture, problem),
            Ok(None) => return Ok(None),
            Ok(Some((size, Ok(found)))) => {
                look.size = size;
                look.found.push(found);
            }
            Ok(Some((_, Err(why @ Unfound::Ambiguous(..))))) => {
                return self.fail(Failure::Ambiguous, why);
            }
            Ok(Some((_, Err(why)))) => {
                let text = format!("a {} was expected: {why}", camera.wanted.text());
                return self.fail(Failure::NoMark, text);
            }
        }
        Ok(Some(look.found.len() >= self.job.frames))
    }

    /// Ends a look: the mean of its pictures.
    fn mean(&mut self, look: &Look) -> Result<Mean, Failure> {
        average(&look.found).or_else(|why| self.fail(Failure::Scatter, why))
    }

    /// Refuses a look that had no picture for too long.
    pub(crate) fn no_picture(&mut self) -> Failure {
        self.problem = format!("no picture came within {} s", self.job.timeout);
        Failure::NoPicture
    }

    /// Ends a look at a mark.
    pub(crate) fn measure(
        &mut self,
        look: &Look,
        mark: u32,
        at: Vector,
        results: &mut Results,
    ) -> Result<(), Failure> {
        let index = self.index(mark)?;
        let mean = self.mean(look)?;
        let camera = self.job.camera;
        let place = camera.machine(at, look.size, mean.mark.centre);
        let off = place - at - camera.offset;
        (results.x, results.y, results.dx, results.dy) = (place.x, place.y, off.x, off.y);
        let (s, c) = libm::sincos(mean.mark.angle.to_radians());
        let side = camera.linear * Vector::new(c, s);
        let angle = libm::atan2(side.y, side.x).to_degrees();
        results.angle = angle - 90.0 * libm::round(angle / 90.0);
        results.scatter = mean.scatter;
        results.uncertainty = mean.mark.uncertainty / camera.pixels(1.0);
        self.forget_fit();
        if let Some(to) = self.measured.get_mut(index) {
            *to = Some(Measured { place, uncertainty: results.uncertainty });
        }
        Ok(())
    }

    /// Ends a look for the calibration.
    pub(crate) fn sight(&mut self, look: &Look, at: Vector) -> Result<(), Failure> {
        let mean = self.mean(look)?;
        if self.sights.len() >= MAX_SIGHTS {
            return self.fail(Failure::NoCamera, "there are 100 sights already: align.clear");
        }
        self.sights.push(Sight { position: at, pixel: mean.mark.centre });
        Ok(())
    }

    /// Calibrates the camera from the sights, and forgets them.
    pub(crate) fn calibrate(&mut self) -> Result<(), Failure> {
        match calibrate(&self.sights) {
            Err(why) => self.fail(Failure::NoCamera, why),
            Ok(Calibration { linear: m, residual }) => {
                self.job.camera.linear = m;
                self.sights.clear();
                self.clear();
                self.problem = format!(
                    "calibrated to {residual:.3} pixels: MATRIX = {} {} {} {}",
                    m.m11, m.m12, m.m21, m.m22
                );
                Ok(())
            }
        }
    }

    /// Adds a mark that was touched with the tool.
    pub(crate) fn touch(&mut self, mark: Mark) -> Result<(), String> {
        if !mark.file.is_usable() || !mark.machine.is_usable() {
            return Err("a coordinate is not a number below 1e9 mm".to_owned());
        }
        if self.touched.len() >= hal_align::MAX_MARKS {
            return Err("there are 1000 touched marks already".to_owned());
        }
        self.touched.push(mark);
        self.forget_fit();
        Ok(())
    }

    fn forget_fit(&mut self) {
        self.fit = None;
        self.live = None;
        self.guessed = None;
    }

    /// Forgets all marks.
    pub(crate) fn clear(&mut self) {
        self.measured.fill(None);
        self.touched.clear();
        self.forget_fit();
    }

    /// Returns the marks that are measured.
    pub(crate) fn marks(&self) -> Vec<Mark> {
        let pairs = self.job.marks.iter().zip(&self.measured);
        let seen = pairs.filter_map(|(file, m)| m.map(|m| Mark { file: *file, machine: m.place }));
        seen.chain(self.touched.iter().copied()).collect()
    }

    /// Computes the place of the part.
    pub(crate) fn solve(&mut self) -> Result<(), Failure> {
        self.forget_fit();
        let marks = self.marks();
        let options = self.job.options;
        match fit(&marks, &options) {
            Err(why) => self.fail(Failure::NoPlace, why),
            Ok(found) => {
                let model = if marks.len() == 1 { Model::Shift } else { Model::Rigid };
                let rigid = fit(&marks, &Conditions { model, ..options });
                self.problem = match &rigid {
                    Ok(_) => String::new(),
                    Err(why) => no_live(*why),
                };
                self.live = rigid.ok().filter(|_| !options.mirror).map(|f| f.transform);
                self.fit = Some(found);
                Ok(())
            }
        }
    }

    /// Fills in the results that follow from all marks; `mark` is the selected one.
    pub(crate) fn report(&mut self, mark: u32, results: &mut Results) {
        let marks = self.marks();
        results.marks = i32::try_from(marks.len()).unwrap_or(i32::MAX);
        let index = usize::try_from(mark).ok().and_then(|n| n.checked_sub(1));
        if let Some(index) = index {
            let guess = self.guess(&marks);
            if let Some(place) = self.expected(index, marks.len(), &guess) {
                let aim = place - self.job.camera.offset;
                (results.aim_x, results.aim_y) = (aim.x, aim.y);
            }
        }
        results.valid = self.fit.is_some();
        results.live = self.live.is_some();
        if let Some(fit) = &self.fit {
            let parts = fit.transform.parts();
            (results.theta, results.sx, results.sy) = (parts.turn, parts.scale_x, parts.scale_y);
            (results.shear, results.rms) = (parts.shear, fit.rms);
            (results.tx, results.ty) = (parts.shift.x, parts.shift.y);
        }
        if let Some(live) = &self.live {
            let parts = live.parts();
            results.live_theta = parts.turn;
            (results.live_x, results.live_y) = (parts.shift.x, parts.shift.y);
        }
    }

    /// Returns the place on the machine at which a mark of the job is expected, by the number of marks so far and the guess
    /// from them.
    pub(crate) fn expected(&self, index: usize, marks: usize, guess: &Transform) -> Option<Vector> {
        let file = self.job.marks.get(index)?;
        let expected = self.job.expected.get(index).copied().flatten();
        let expected = expected.filter(|_| marks < 3);
        Some(expected.unwrap_or_else(|| guess.apply(*file)))
    }

    /// Returns the place of the part by the marks so far. A fit of many marks takes too long for every period and for every
    /// request: one serves until the marks change.
    pub(crate) fn guess(&mut self, marks: &[Mark]) -> Transform {
        let guess = self.guessed.unwrap_or_else(|| self.fit_guess(marks));
        self.guessed = Some(guess);
        guess
    }

    fn fit_guess(&self, marks: &[Mark]) -> Transform {
        let options = |model| Conditions { model, tolerance: 1e9, mirror: self.job.options.mirror };
        for model in [Model::Affine, Model::Similarity, Model::Shift] {
            if let Ok(found) = fit(marks, &options(model)) {
                return found.transform;
            }
        }
        Transform { linear: Matrix::IDENTITY, shift: self.job.near }
    }

    /// Returns the text of a file with the marks.
    pub(crate) fn text(&self) -> Result<String, String> {
        let marks = self.marks();
        if self.fit.is_none() || marks.is_empty() {
            return Err("the place of the part is not known: align.solve first".to_owned());
        }
        Ok(Alignment { options: self.job.options, marks, given: None }.text())
    }
}

/// Returns why a coordinate system cannot hold the place of the part.
fn no_live(why: Misfit) -> String {
    match why {
        Misfit::Residual(rms, tolerance, ..) => format!(
            "a coordinate system cannot hold this part: turn and shift alone are {rms:.4} mm off, and {tolerance} mm are allowed; align.save and halgcode align rewrite the program"
        ),
        other => other.to_string(),
    }
}
