//! The Python module `gcode`: a program's canonical calls, given to an object of the caller, for previews.

mod arc;
mod calls;
mod extents;
mod line;
mod preview;

use crate::connection::locked;
use calls::Canon;
use hal_gcode::{Call, Interpreter, Issued};
use hal_job::{Files, run, world};
use preview::Preview;
use pyo3::{exceptions::PyKeyboardInterrupt, prelude::*};
use std::{path::Path, sync::Mutex};

/// Results of `parse`.
mod result {
    pub(super) const OK: i32 = 0;
    /// The program reached its end.
    pub(super) const EXIT: i32 = 1;
    /// The highest result that is no error.
    pub(super) const END_OF_FILE: i32 = 3;
    pub(super) const NOT_OPEN: i32 = 4;
    pub(super) const FAILED: i32 = 5;
}

/// Text of the last error.
static LAST_ERROR: Mutex<String> = Mutex::new(String::new());

/// Number of lines between two questions whether the preview is still wanted.
const LINES_PER_CHECK: u32 = 50;

/// Lines of G-code that come before a file.
#[derive(FromPyObject)]
enum Codes {
    /// A single line.
    Line(String),
    /// Lines.
    Lines(Vec<String>),
}

impl Codes {
    fn lines(self) -> Vec<String> {
        match self {
            Self::Line(line) => vec![line],
            Self::Lines(lines) => lines,
        }
    }
}

/// `parse(FILE, CANON[, UNITCODE[, INITCODE[, INTERPRETER]]])` or `parse(FILE, CANON, CODES[, INTERPRETER])`: runs lines of
/// G-code and then a file, and calls the methods of CANON. Returns the result and the last line.
#[pyfunction]
#[pyo3(signature = (file, canon, unitcode=None, initcode=None, _interpreter=None, /))]
fn parse<'py>(
    py: Python<'py>,
    file: &str,
    canon: Bound<'py, PyAny>,
    unitcode: Option<Codes>,
    initcode: Option<Codes>,
    _interpreter: Option<&str>,
) -> PyResult<(i32, u32)> {
    let mut canon = Canon::new(canon)?;
    let parameters: Option<String> = canon.attribute("parameter_file")?;
    let ini = std::env::var_os("INI_FILE_NAME");
    let files = Files {
        ini: ini.as_deref().map(Path::new),
        table: None,
        parameters: parameters.as_deref().map(Path::new),
        ..Files::default()
    };
    let mut machine = match hal_job::Machine::read(&files) {
        Ok(machine) => machine,
        Err(why) => return Ok(failed(why, 0)),
    };
    canon.apply_settings(&mut machine)?;
    let in_spindle = canon.tools(&mut machine.tools)?;
    let mut interpreter = Interpreter::new(machine.settings.clone(), machine.numbered.clone());
    // A line without a feed is shown, although it would not run.
    interpreter.state.modal.feed = 1.0;
    if let Some(tool) = in_spindle {
        interpreter.state.tool = tool;
    }
    let mut job = Job { canon, interpreter, world: Preview::new(machine), lines: 0 };
    job.preamble(py)?;
    // After a list comes the name of an interpreter.
    let initcode = initcode.filter(|_| !matches!(unitcode, Some(Codes::Lines(_))));
    let codes = [unitcode, initcode].into_iter().flatten().flat_map(Codes::lines);
    for code in codes.filter(|code| !code.is_empty()) {
        job.interpreter.mdi(&code);
        match job.run(py)? {
            (result::OK | result::END_OF_FILE, _) if !job.is_at_end() => {}
            other => return Ok(other),
        }
    }
    let Ok(text) = world::program(Path::new(file)) else {
        failed("File not open".to_owned(), 1);
        return Ok((result::NOT_OPEN, 1));
    };
    job.interpreter.load(file, text);
    job.run(py)
}

/// A preview in progress.
struct Job<'py> {
    canon: Canon<'py>,
    interpreter: Interpreter,
    world: Preview,
    /// Number of lines since the last question whether the preview is still wanted.
    lines: u32,
}

impl<'py> Job<'py> {
    /// Shows the offsets that are in force at the start.
    fn preamble(&mut self, py: Python<'py>) -> PyResult<()> {
        self.canon.next_line(py, &self.interpreter.state, 0)?;
        let calls = self.interpreter.preamble().into_iter();
        for call in calls.filter(|call| !matches!(call, Call::UseToolLengthOffset(_))) {
            self.canon.call(&call, &self.world)?;
        }
        Ok(())
    }

    /// Tells whether the program said that it ends.
    fn is_at_end(&self) -> bool {
        self.canon.ended
    }

    fn run(&mut self, py: Python<'py>) -> PyResult<(i32, u32)> {
        let mut out: Vec<Issued> = Vec::new();
        let mut last = 0;
        loop {
            let functions = self.world.functions();
            let answers = run::Answers { probe_trips: false, functions };
            let going = run::step(&mut self.interpreter, &self.world, answers, &mut out);
            for issued in out.drain(..) {
                if issued.line != last {
                    last = issued.line;
                    self.canon.next_line(py, &self.interpreter.state, last)?;
                }
                self.canon.call(&issued.call, &self.world)?;
            }
            self.check(py)?;
            match going {
                Ok(true) => {}
                Ok(false) => {
                    let line = self.interpreter.state.line;
                    return Ok((if self.canon.ended { result::EXIT } else { result::OK }, line));
                }
                Err(error) => {
                    let line = error.place.line;
                    return Ok(failed(error.problem.to_string(), line));
                }
            }
        }
    }

    /// Asks now and then whether the preview is still wanted.
    fn check(&mut self, py: Python<'py>) -> PyResult<()> {
        self.lines += 1;
        if self.lines < LINES_PER_CHECK {
            return Ok(());
        }
        self.lines = 0;
        py.check_signals()?;
        if self.canon.is_aborted()? {
            return Err(PyKeyboardInterrupt::new_err("the preview was aborted"));
        }
        Ok(())
    }
}

fn failed(why: String, line: u32) -> (i32, u32) {
    *locked(&LAST_ERROR) = why;
    (result::FAILED, line)
}

/// `strerror(RESULT)`: returns the text of the last error, or an empty text for a result that is none.
#[pyfunction]
#[pyo3(signature = (result, /))]
fn strerror(result: i32) -> String {
    match result {
        ..=result::END_OF_FILE => String::new(),
        _ => locked(&LAST_ERROR).clone(),
    }
}

/// Canonical calls of programs.
#[pymodule]
fn gcode(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add("MIN_ERROR", result::END_OF_FILE)?;
    module.add("MAX_ERROR", -1)?;
    module.add_class::<line::LineCode>()?;
    module.add_function(wrap_pyfunction!(parse, module)?)?;
    module.add_function(wrap_pyfunction!(strerror, module)?)?;
    module.add_function(wrap_pyfunction!(arc::arc_to_segments, module)?)?;
    module.add_function(wrap_pyfunction!(extents::calc_extents, module)?)
}
