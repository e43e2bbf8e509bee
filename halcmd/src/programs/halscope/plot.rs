//! `halscope plot`: channels over time as a picture for a report, in SVG or PNG.

mod draw;
mod lane;

use super::{names, time, unwritten};
use crate::{
    Stdio, Terminal,
    programs::{
        options::{Opt, mixed, plain, usage},
        picture::{Kind, size},
    },
};
use draw::Plot;
use hal_trace::{FileError, Trace};
use std::{
    path::{Path, PathBuf},
    process::ExitCode,
};

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Id {
    Output,
    From,
    To,
    Zero,
    Title,
    Size,
    Measure,
    Help,
}

const OPTIONS: &[Opt<Id>] = &[
    Opt {
        long: Some("output"),
        help: "the picture, FILE.svg or FILE.png; the trace's name with .svg if none is given",
        ..Opt::short_with(Id::Output, 'o', "FILE")
    },
    long(Id::From, "from", "TIME", "where the picture begins, as 1.5ms in machine time"),
    long(Id::To, "to", "TIME", "where it ends"),
    long(Id::Zero, "zero", "TIME", "where the axis has its 0; a trigger's place if there is one"),
    long(Id::Title, "title", "TEXT", "its title"),
    long(
        Id::Size,
        "size",
        "WIDTHxHEIGHT",
        "in pixels; 1200 wide, and as high as its channels need",
    ),
    Opt {
        long: Some("measure"),
        help: "write frequency, duty cycle or extremes below each name",
        ..Opt::flag(Id::Measure, 'm')
    },
    Opt { help: "print this", long: Some("help"), ..Opt::flag(Id::Help, 'h') },
];

const fn long(id: Id, name: &'static str, value: &'static str, help: &'static str) -> Opt<Id> {
    Opt { id, short: None, long: Some(name), value: Some(value), variable: None, help }
}

/// Returns the options for completion.
pub(super) fn completable() -> Vec<Opt<()>> {
    plain(OPTIONS)
}

/// Runs `halscope plot [options] FILE [CHANNEL...]`.
pub(super) fn main(words: &[String]) -> Result<ExitCode, String> {
    let (given, rest) = mixed("halscope", OPTIONS, words).map_err(|e| e.to_string())?;
    let value = |wanted| given.iter().rev().find(|(id, _)| *id == wanted)?.1.as_deref();
    let is_given = |wanted| given.iter().any(|(id, _)| *id == wanted);
    if is_given(Id::Help) {
        let head = "Usage: halscope plot [options] FILE [CHANNEL...]\n\noptions:\n";
        Stdio.out(&format!("{head}{}", usage(OPTIONS)))?;
        return Ok(ExitCode::SUCCESS);
    }
    let (file, patterns) =
        rest.split_first().ok_or("which file? halscope plot [options] FILE [CHANNEL...]")?;
    let path = Path::new(file);
    let output = value(Id::Output).map_or_else(|| path.with_extension("svg"), PathBuf::from);
    let kind = Kind::of(&output)?;
    let trace = super::load(path)?;
    let lanes = names::chosen(&trace, patterns, file)?;
    let time = |id| value(id).map(|text| time(&trace, text)).transpose();
    let (first, last) = ends(&trace, file)?;
    let (from, to) = (time(Id::From)?.unwrap_or(first), time(Id::To)?.unwrap_or(last));
    if from >= to {
        return Err(format!("the picture would end ({to} ns) before it begins ({from} ns)"));
    }
    let title = value(Id::Title).map_or_else(|| stem(path), str::to_owned);
    let mut plot = Plot::new(&trace, lanes, from, to, title);
    plot.measures = is_given(Id::Measure);
    if let Some(zero) = time(Id::Zero)? {
        plot.zero = zero;
    }
    if let Some(text) = value(Id::Size) {
        (plot.width, plot.height) = size(text)?;
    }
    let bytes = match kind {
        Kind::Svg => plot.svg()?.into_bytes(),
        Kind::Png => plot.png()?,
    };
    hal_output::write(&output, &bytes).map_err(|e| unwritten(&FileError::of(&output, &e)))?;
    Ok(ExitCode::SUCCESS)
}

fn ends(trace: &Trace, file: &str) -> Result<(i64, i64), String> {
    let nothing = || format!("{file}: there is no time in it to draw");
    let times = trace.times();
    let (first, last) = times.first().zip(times.last()).ok_or_else(nothing)?;
    if first == last { Err(nothing()) } else { Ok((first, last)) }
}

fn stem(path: &Path) -> String {
    path.file_stem().map(|s| s.to_string_lossy().into_owned()).unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use super::{Kind, size};
    use std::path::Path;

    #[test]
    fn what_is_no_picture_and_no_size() {
        let no_kind = |name: &str| Kind::of(Path::new(name)).err();
        assert_eq!(no_kind("a.jpg").as_deref(), Some("a.jpg: a picture ends in .svg or .png"));
        assert!(no_kind("a").is_some() && no_kind("a.SVG").is_none());
        assert_eq!(size("800x600"), Ok((800, 600)));
        for wrong in ["", "800", "x", "800x", "800x99", "20000x600", "-1x600", "8e2x600"] {
            assert!(size(wrong).is_err_and(|e| e.starts_with(&format!("'{wrong}' is not a size"))));
        }
    }
}
