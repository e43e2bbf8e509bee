//! Marks in pictures, without HAL.
//!
//! | module | subject |
//! |---|---|
//! | [`Picture`] | grey pictures, from JPEG and PNG files within limits |
//! | [`search()`] | circles and squares in a picture: sub-pixel centre, angle, uncertainty |
//! | [`choose`], [`average`] | the wanted mark among those found; several pictures of it |
//! | [`Camera`], [`calibrate`] | from pixels to the machine |
//! | [`Sheet`], [`View`] | drawn pictures of a sheet with marks: the simulated table |
//! | [`Source`] | origins of pictures: files, and the simulated table |
#![forbid(unsafe_code)]

mod camera;
mod draw;
mod measure;
mod moments;
mod picture;
mod random;
mod refine;
mod region;
mod search;
mod select;
mod source;
mod table;
mod threshold;

pub use camera::{Calibration, Camera, CameraProblem, Sight, calibrate};
pub use draw::{Figure, Sheet, View};
pub use measure::FoundMark;
pub use picture::{MAX_BYTES, MAX_SIDE, Picture, PictureProblem};
pub use search::{Ink, MarkKind, Rejected, Search, Seen, search};
pub use select::{Mean, Unfound, average, choose};
pub use source::{Files, Source, SourceProblem, read_picture};
pub use table::{Table, TableProblem};
