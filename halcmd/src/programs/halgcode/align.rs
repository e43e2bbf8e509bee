//! `halgcode align`: a program in the coordinates of a part whose marks were measured.

use crate::{
    Stdio, Terminal,
    programs::options::{Opt, mixed, plain, usage},
    terminal::print_error,
};
use hal_align::{
    Alignment, Fit, Mark, Matrix, Model, Transform, Vector,
    rewrite::{Arcs, MAX_REFUSALS, Rewritten, Rules, rewrite},
};
use hal_job::number;
use std::{
    path::{Path, PathBuf},
    process::ExitCode,
};

/// Words that the command takes.
pub(super) const ARGUMENTS: &str = "[options] FILE";
/// Description.
pub(super) const HELP: &str = "a program moved, turned and scaled to a part by its marks";

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Setting {
    Ini,
    Marks,
    Mark,
    Matrix,
    Model,
    Mirror,
    Arcs,
    Tolerance,
    Start,
    Expand,
    Inch,
    Header,
    Output,
    Help,
}

const OPTIONS: &[Opt<Setting>] = &[
    Opt {
        long: Some("ini"),
        help: "the machine: its unit of length, and the marks of the file [ALIGN]MARKS",
        ..Opt::short_with(Setting::Ini, 'I', "FILE")
    },
    Opt {
        long: Some("marks"),
        help: "the marks, or a matrix: an INI file with a section [ALIGN]",
        ..Opt::short_with(Setting::Marks, 'm', "FILE")
    },
    Opt {
        long: Some("mark"),
        help: "a mark: X,Y in the file and X,Y on the machine, in mm; several times",
        ..Opt::short_with(Setting::Mark, 'k', "X,Y,X,Y")
    },
    Opt {
        long: Some("matrix"),
        help: "instead of marks: rows of the linear part, and the shift in mm",
        ..Opt::short_with(Setting::Matrix, 'M', "A,B,C,D,X,Y")
    },
    Opt {
        long: Some("model"),
        help: "auto, shift, rigid, similarity, scale-xy or affine",
        ..Opt::short_with(Setting::Model, 'l', "NAME")
    },
    Opt {
        long: Some("mirror"),
        help: "the part lies on its back",
        ..Opt::flag(Setting::Mirror, 'r')
    },
    Opt {
        long: Some("arcs"),
        help: "arcs of a part with unequal scales: lines (the default) or refuse",
        ..Opt::short_with(Setting::Arcs, 'a', "HOW")
    },
    Opt {
        long: Some("tolerance"),
        help: "largest distance of these lines from the curve in mm, 0.005",
        ..Opt::short_with(Setting::Tolerance, 't', "MM")
    },
    Opt {
        long: Some("start"),
        help: "place of the tool before the program, in the file's mm",
        ..Opt::short_with(Setting::Start, 's', "X,Y")
    },
    Opt {
        long: Some("expand"),
        help: "evaluate expressions and parameters that the program sets",
        ..Opt::flag(Setting::Expand, 'e')
    },
    Opt {
        long: Some("inch"),
        help: "the machine's own unit, in force until G20 or G21, is the inch",
        ..Opt::flag(Setting::Inch, 'i')
    },
    Opt {
        long: Some("header"),
        help: "a comment with the place of the part and the source",
        ..Opt::flag(Setting::Header, 'H')
    },
    Opt {
        long: Some("output"),
        help: "the file to write, instead of standard output",
        ..Opt::short_with(Setting::Output, 'o', "FILE")
    },
    Opt { long: Some("help"), help: "print this", ..Opt::flag(Setting::Help, 'h') },
];

/// Returns the options for completion.
pub(super) fn completable() -> Vec<Opt<()>> {
    plain(OPTIONS)
}

/// Runs `align` with these words. The status is 1 if the marks or the program cannot be aligned; nothing is written then.
pub(super) fn main(words: &[String]) -> Result<ExitCode, String> {
    let (given, rest) = mixed("halgcode", OPTIONS, words).map_err(|e| e.to_string())?;
    let last = |wanted| {
        let found = given.iter().rev().find(|(id, _)| *id == wanted)?;
        found.1.as_deref()
    };
    let is_given = |wanted| given.iter().any(|(id, _)| *id == wanted);
    if is_given(Setting::Help) {
        let text = super::help::usage_of("align", ARGUMENTS, HELP, &usage(OPTIONS));
        Stdio.out(&text)?;
        return Ok(ExitCode::SUCCESS);
    }
    let [file] = rest.as_slice() else {
        return Err("which file? halgcode align [options] FILE".into());
    };
    let marks =
        given.iter().filter(|(id, _)| *id == Setting::Mark).filter_map(|(_, v)| v.as_deref());
    let marks: Vec<&str> = marks.collect();
    let machine = last(Setting::Ini).map(Machine::read).transpose()?;
    let is_placed = !marks.is_empty() || last(Setting::Matrix).is_some();
    let saved = machine.as_ref().filter(|_| !is_placed).and_then(|m| m.marks.as_deref());
    let file_of_marks = last(Setting::Marks).or(saved);
    let (mut alignment, name) = alignment(file_of_marks, &marks, last(Setting::Matrix))?;
    if let Some(model) = last(Setting::Model) {
        let usual = "auto, shift, rigid, similarity, scale-xy or affine";
        let model = Model::of(model).ok_or_else(|| format!("--model '{model}': {usual}"))?;
        alignment.options.model = model;
    }
    alignment.options.mirror |= is_given(Setting::Mirror);
    let mut options = Rules {
        expand: is_given(Setting::Expand),
        inches: is_given(Setting::Inch) || machine.as_ref().is_some_and(|m| m.is_inch),
        header: is_given(Setting::Header).then(|| name_of(file)),
        ..Rules::default()
    };
    match last(Setting::Arcs) {
        None | Some("lines") => {}
        Some("refuse") => options.arcs = Arcs::Refuse,
        Some(other) => return Err(format!("--arcs '{other}': lines or refuse")),
    }
    if let Some(text) = last(Setting::Tolerance) {
        [options.tolerance] = numbers("--tolerance", text)?;
    }
    if let Some(text) = last(Setting::Start) {
        let [x, y] = numbers("--start", text)?;
        options.start = Some(Vector::new(x, y));
    }
    let text = hal_ini::file::whole(Path::new(file));
    let text = text.map_err(|e| format!("{file}: {}", hal_output::reason(&e)))?;
    let (transform, fit) = match alignment.solve(&name) {
        Ok(solved) => solved,
        Err(problem) => {
            print_error(&format!("{problem}\n"));
            return Ok(ExitCode::FAILURE);
        }
    };
    let done = match rewrite(&text, &transform, &options) {
        Ok(done) => done,
        Err(refusals) => {
            for refusal in &refusals {
                let column =
                    if refusal.column > 0 { format!(":{}", refusal.column) } else { String::new() };
                print_error(&format!("{file}:{}{column}: {}\n", refusal.line, refusal.reason));
            }
            if refusals.len() >= MAX_REFUSALS {
                print_error("there may be more\n");
            }
            return Ok(ExitCode::FAILURE);
        }
    };
    let mut report = report(&transform, fit.as_ref(), &done);
    if done.unit_is_assumed && !options.inches && machine.is_none() {
        report.push_str(
            "warning: X and Y before the first G20 or G21 are taken as mm; --inch if the machine's unit is the inch\n",
        );
    }
    match last(Setting::Output).map(PathBuf::from) {
        None => {
            print_error(&report);
            let text = std::str::from_utf8(&done.text);
            Stdio.out(text.map_err(|_| format!("{file} is not UTF-8: use --output"))?)?;
        }
        Some(path) => {
            let written = hal_output::write(&path, &done.text);
            written.map_err(|e| format!("{}: {}", path.display(), hal_output::reason(&e)))?;
            Stdio.out(&report)?;
        }
    }
    Ok(ExitCode::SUCCESS)
}

/// Facts of a machine that its INI file states.
#[derive(Debug, PartialEq, Eq)]
struct Machine {
    is_inch: bool,
    /// File with the marks that `align.save` wrote.
    marks: Option<String>,
}

impl Machine {
    fn read(file: &str) -> Result<Self, String> {
        let ini = hal_ini::Ini::read(Path::new(file)).map_err(|e| e.to_string())?;
        Self::of(&ini, Path::new(file))
    }

    /// Takes the facts from an INI file; a relative name of a file is relative to its folder.
    fn of(ini: &hal_ini::Ini, path: &Path) -> Result<Self, String> {
        let is_inch = ini.is_inch().map_err(number::not_a_unit)?;
        let named = ini.get("ALIGN", "MARKS").map(str::trim).filter(|name| !name.is_empty());
        let folder = path.parent().unwrap_or(Path::new(""));
        let marks = named.map(|name| hal_ini::beside(folder, name).display().to_string());
        Ok(Self { is_inch, marks })
    }
}

/// Returns the alignment from a file or from options, and its name for messages.
fn alignment(
    file: Option<&str>,
    marks: &[&str],
    matrix: Option<&str>,
) -> Result<(Alignment, String), String> {
    let mut out = Alignment::default();
    match (file, marks, matrix) {
        (Some(file), [], None) => {
            let read = Alignment::read(Path::new(file)).map_err(|e| e.to_string())?;
            return Ok((read, file.to_owned()));
        }
        (None, [_, ..], None) => {
            for text in marks {
                let [x, y, to_x, to_y] = numbers("--mark", text)?;
                let mark = Mark { file: Vector::new(x, y), machine: Vector::new(to_x, to_y) };
                out.marks.push(mark);
            }
        }
        (None, [], Some(text)) => {
            let [m11, m12, m21, m22, x, y] = numbers("--matrix", text)?;
            let linear = Matrix::new(m11, m12, m21, m22);
            out.given = Some(Transform { linear, shift: Vector::new(x, y) });
        }
        _ => {
            let one_of = "--marks FILE, --mark (several), --matrix, or --ini with [ALIGN]MARKS";
            return Err(format!("where is the part? One of {one_of}"));
        }
    }
    Ok((out, "marks".to_owned()))
}

/// Reads numbers separated by commas.
fn numbers<const N: usize>(option: &str, text: &str) -> Result<[f64; N], String> {
    let wrong = || format!("{option} '{text}': {N} numbers separated by commas are needed");
    let mut out = [0.0; N];
    let mut words = text.split(',');
    for to in &mut out {
        let number = words.next().and_then(|w| w.trim().parse::<f64>().ok());
        *to = number.filter(|n| n.abs() < 1e9).ok_or_else(wrong)?;
    }
    if words.next().is_some() { Err(wrong()) } else { Ok(out) }
}

/// Returns the last part of a path.
fn name_of(file: &str) -> String {
    let name = Path::new(file).file_name();
    name.map_or_else(|| file.to_owned(), |n| n.to_string_lossy().into_owned())
}

/// Returns what was found and done, as lines.
fn report(transform: &Transform, fit: Option<&Fit>, done: &Rewritten) -> String {
    let mut out = format!("{}\n", transform.parts());
    if let Some(fit) = fit {
        out.push_str(&format!("model {}, rms {:.4} mm\n", fit.model.name(), fit.rms));
        for (n, r) in (1..).zip(&fit.residuals) {
            out.push_str(&format!("mark {n}: residual {r} mm\n"));
        }
    }
    out.push_str(&format!("{} blocks changed", done.changed));
    if done.arcs > 0 {
        out.push_str(&format!(", {} arcs as {} lines", done.arcs, done.chords));
    }
    out.push('\n');
    for warning in transform.warnings() {
        out.push_str(&format!("warning: {warning}\n"));
    }
    if done.feed_is_uneven {
        out.push_str("warning: the scales differ, and feeds stay as they are\n");
    }
    out
}
