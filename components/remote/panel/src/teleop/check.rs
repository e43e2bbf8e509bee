//! The check of a program before it starts, and the lengths of its moves.

use hal_gcode::{
    Error, Interpreter, Issued, Request, Step, axis::Position, canon::Unit, error::Problem,
};
use hal_job::{
    Files, Machine, World,
    run::{Answers, start},
    way::{Way, distance},
    world,
};
use std::path::Path;
use teleop::{Code, Reason};
use tokio::time::{Duration, Instant};

/// Longest time for one program.
const MAX_TIME: Duration = Duration::from_secs(60);
/// Steps of the program between two looks at the time and the machine.
const LOOK: u32 = 256;
/// Number of moves whose lengths are kept.
const MAX_MOVES: usize = 2_000_000;

/// The moves of a program: line, and the length of the path up to the move's end, in machine units.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Lengths(pub(crate) Vec<(u32, f64)>);

/// Reads a program as the task would, from where the machine is. `pose` is in machine units. Again and again it asks
/// whether the job `may` still begin.
///
/// # Errors
/// The program has an error, or leaves the machine's travel; a file cannot be read; or the job may not begin.
pub(crate) fn read(
    ini: Option<&Path>,
    file: &Path,
    pose: [f64; 9],
    may: &dyn Fn() -> Result<(), Reason>,
) -> Result<Lengths, Reason> {
    let fail = |text: String| Reason::new(Code::Falla, text);
    let machine = Machine::read(&Files { ini, ..Files::default() }).map_err(fail)?;
    let to_mm = machine.settings.unit.to(Unit::Millimetre);
    let mut it = Interpreter::new(machine.settings.clone(), machine.numbered.clone());
    // Functions in Python have effects, which are the job's alone.
    let world = World { machine, hal: std::collections::BTreeMap::new(), functions: None };
    start(&mut it, &world).map_err(fail)?;
    let [x, y, z, a, b, c, u, v, w] = pose;
    let here = Position { x, y, z, a, b, c, u, v, w };
    let in_unit = it.state.frame.unit.millimetres();
    it.state.position = it.state.frame.program(here.scaled(to_mm / in_unit));
    it.load(&file.display().to_string(), world::program(file).map_err(fail)?);
    let mut way = Way::new(it.state.frame, it.state.position);
    let mut lengths = Lengths::default();
    let (mut beyond, mut length, mut out) = (None, 0.0, Vec::new());
    let begun = Instant::now();
    for n in 0_u32.. {
        let going = step(&mut it, &world, &mut out);
        for issued in out.drain(..) {
            let (mut from, before) = (way.at, length);
            way.follow(&issued.call, &mut |_, to| {
                length += distance(from, to) / to_mm;
                from = to;
                let limit = world.machine.beyond(to).next();
                if let Some(limit) = limit.filter(|_| world.machine.kinematics.is_none())
                    && beyond.is_none()
                {
                    let text = world.machine.excess(limit, to[limit.0]);
                    beyond = Some(format!("{} {text}", issued.line));
                }
            });
            if length > before && lengths.0.len() < MAX_MOVES {
                lengths.0.push((issued.line, length));
            }
        }
        match going {
            Ok(true) => {}
            Ok(false) => break,
            Err(error) => {
                let text = format!("{} {}", error.place.line, error.problem);
                return Err(Reason::new(Code::Sintaxis, text));
            }
        }
        if !n.is_multiple_of(LOOK) {
            continue;
        }
        may()?;
        if begun.elapsed() > MAX_TIME {
            return Err(fail(format!("reading it takes more than {} s", MAX_TIME.as_secs())));
        }
    }
    match beyond {
        Some(text) => Err(Reason::new(Code::Limite, text)),
        None => Ok(lengths),
    }
}

/// Runs one step with the answers of a machine that stands still; returns whether there are more. What follows a value of
/// HAL that only the machine knows, or a call of a function in Python, is not read: the task checks it as it comes.
fn step(it: &mut Interpreter, world: &World, out: &mut Vec<Issued>) -> Result<bool, Error> {
    let answers = Answers { probe_trips: true, functions: None };
    let mut step = match it.next(world, out) {
        // It may be a function.
        Err(Error { problem: Problem::LabelMissing { .. }, .. })
            if world.machine.python.is_some() =>
        {
            return Ok(false);
        }
        step => step?,
    };
    while let Step::Ask(request) = step {
        if matches!(request, Request::Hal { .. } | Request::Function { .. }) {
            return Ok(false);
        }
        let answer = answers.answer(&request, it, world);
        step = it.answer(&answer, world, out)?;
    }
    Ok(step != Step::Ended)
}

/// Returns the reason of a task that refuses a program: `FILE:LINE: TEXT` becomes the line and the text.
pub(crate) fn reason(file: &Path, text: &str) -> Reason {
    let place = format!("{}:", file.display());
    let Some((_, rest)) = text.split_once(&place) else {
        return Reason::new(Code::Falla, text);
    };
    let rest = rest.lines().next().unwrap_or_default();
    let (line, why) = rest.split_once(": ").unwrap_or(("", rest));
    let line = line.split(':').next().unwrap_or_default();
    let code = if why.contains(" beyond [") { Code::Limite } else { Code::Sintaxis };
    Reason::new(code, format!("{line} {why}"))
}

/// Progress of a job along its path.
#[derive(Clone, Debug, Default)]
pub(crate) struct Progress {
    lengths: Lengths,
    /// Number of the move that was seen last.
    at: usize,
    done: f64,
}

impl Progress {
    pub(crate) const fn new(lengths: Lengths) -> Self {
        Self { lengths, at: 0, done: 0.0 }
    }

    /// Notes the line of the current move and the distance to its end, in machine units.
    pub(crate) fn look(&mut self, line: u32, to_go: f64) {
        let Lengths(moves) = &self.lengths;
        // A loop comes to the same line again.
        let found = moves.iter().enumerate().skip(self.at).find(|(_, (of, _))| *of == line);
        let Some((n, (_, end))) = found else { return };
        let before = n.checked_sub(1).and_then(|n| moves.get(n)).map_or(0.0, |(_, length)| *length);
        let done = end - to_go;
        // A feed hold that runs back, or a distance to go of the move before, is no way back here.
        if before <= done && self.done <= done {
            (self.at, self.done) = (n, done);
        }
    }

    /// Returns the progress in percent, rounded down.
    pub(crate) fn percent(&self) -> u8 {
        let total = self.lengths.0.last().map_or(0.0, |(_, length)| *length);
        let percent = (100.0 * self.done / total).floor();
        // Without a path it is NaN.
        if percent >= 99.0 {
            99
        } else if percent > 0.0 {
            #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "1 to 98")]
            let percent = percent as u8;
            percent
        } else {
            0
        }
    }
}

#[cfg(test)]
mod tests;
