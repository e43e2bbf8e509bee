//! Arcs: kept where they stay arcs, else lines within the tolerance.

use super::{
    Arcs, Program, Reason,
    block::New,
    codes::Codes,
    curve::Curve,
    edit::{Digits, letter},
    modal::{ArcPlane, Modal, Motion},
    transfer::{Displacement, Line, follow_z, is_coupled, straight, write},
    words::Word,
};
use crate::{Matrix, Vector};
use core::f64::consts::TAU;
use libm::{fabs, hypot, sqrt};

/// Distance of the ends of an arc, in millimetres, below which rounding could make a circle of it.
const SHORT: f64 = 0.001;

/// Arc of a block: lengths in millimetres of the file.
pub(super) struct Arc {
    pub(super) end: [Option<f64>; 3],
    pub(super) centre: [Option<f64>; 3],
    pub(super) radius: Option<f64>,
    /// Angle beyond the arc itself, in radians.
    pub(super) turns: f64,
    /// Counterclockwise.
    pub(super) left: bool,
}

pub(super) type Failure = (u32, Reason);

/// Rewrites a block with an arc.
pub(super) fn arc(
    program: &Program<'_>,
    modal: &mut Modal,
    mut line: Line<'_>,
    codes: &Codes,
    left: bool,
    end: &[u8],
) -> Result<New, Failure> {
    let mm = |name| line.mm(modal, name);
    let turns = line.words.number(b'p')?.map_or(1.0, libm::round);
    let arc = Arc {
        end: [mm(b'x')?, mm(b'y')?, None],
        centre: [mm(b'i')?, mm(b'j')?, mm(b'k')?],
        radius: mm(b'r')?,
        turns: (turns.max(1.0) - 1.0) * TAU,
        left,
    };
    let has_centre = arc.centre.iter().any(Option::is_some);
    if has_centre == arc.radius.is_some() || modal.now.plane == ArcPlane::Other {
        return Err((0, Reason::ArcWords));
    }
    let arc_word = codes.motion.and_then(|n| line.words.list.get(n)).copied();
    if keeps(program, modal, &arc)? {
        keep(program, modal, &mut line, &arc, arc_word)?;
        if line.words.deletable && codes.motion.is_some() {
            modal.motion = Motion::Unknown;
        }
        return Ok(New { text: line.edits.apply(line.raw), chords: 0 });
    }
    if program.options.arcs == Arcs::Refuse {
        return Err((0, Reason::Arc));
    }
    let new = chords(program, modal, line, &arc, arc_word, codes.stops, end)?;
    Ok(new)
}

/// Returns whether the arc stays one.
fn keeps(program: &Program<'_>, modal: &Modal, arc: &Arc) -> Result<bool, Failure> {
    let transform = program.transform;
    if modal.now.plane != ArcPlane::Xy {
        return Ok(transform.linear == Matrix::IDENTITY);
    }
    let start = modal.place();
    if let ([Some(x), Some(y), _], Some(start), false) = (arc.end, start, modal.now.incremental) {
        let apart = (Vector::new(x, y) - start).length();
        if 0.0 < apart && apart < SHORT {
            return Ok(false);
        }
    }
    if transform.is_even() {
        return Ok(true);
    }
    let [i, j, _] = arc.centre;
    let radius = match (arc.radius, modal.now.centre_is_absolute) {
        (Some(_), _) => return Ok(false),
        (None, false) => hypot(i.unwrap_or(0.0), j.unwrap_or(0.0)),
        (None, true) => {
            let start = start.ok_or((0, Reason::UnknownPosition('X')))?;
            let (Some(i), Some(j)) = (i, j) else { return Err((0, Reason::ArcWords)) };
            (Vector::new(i, j) - start).length()
        }
    };
    let (larger, smaller) = transform.linear.stretches();
    Ok(radius * (larger - smaller) <= program.options.tolerance)
}

/// Rewrites an arc that stays one.
fn keep(
    program: &Program<'_>,
    modal: &mut Modal,
    line: &mut Line<'_>,
    arc: &Arc,
    arc_word: Option<Word>,
) -> Result<(), Failure> {
    let transform = program.transform;
    let swaps = transform.linear.det() < 0.0;
    let goes_left = arc.left != swaps;
    if let Some(word) = arc_word.filter(|_| swaps) {
        line.edits.last_digit(line.raw, &word, if goes_left { '3' } else { '2' });
    }
    if modal.written == Some(Motion::Line)
        && let Some(first) = first_word(line)
    {
        let code = if goes_left { '3' } else { '2' };
        let text = format!("{}{code}", letter(line.raw, line.words, b'g'));
        line.edits.before(line.raw, &first, &text);
        modal.written = None;
    }
    centre(program, modal, line, arc)?;
    if let Some(radius) = arc.radius {
        let scaled = radius * sqrt(fabs(transform.linear.det()));
        if let Some(word) = line.words.get(b'r') {
            line.edits.value(word, Digits(modal.now.inches).write(scaled).0);
        }
    }
    let [x, y, _] = arc.end;
    if x.is_some() || y.is_some() {
        let step = Displacement { x, y, times: 1.0 };
        let closed =
            modal.place().filter(|at| !modal.now.incremental && x == Some(at.x) && y == Some(at.y));
        match closed {
            // A full circle ends at the very digits where it begins.
            Some(at) => {
                let carry = modal.carry;
                let want = transform.apply(at) - carry;
                write(line, modal, step, want, is_coupled(transform));
                modal.carry = carry;
            }
            None => straight(line, modal, transform, step)?,
        }
    }
    follow_z(modal, line.words);
    Ok(())
}

/// Rewrites the words of the centre.
fn centre(
    program: &Program<'_>,
    modal: &Modal,
    line: &mut Line<'_>,
    arc: &Arc,
) -> Result<(), Failure> {
    let transform = program.transform;
    let digits = Digits(modal.now.inches);
    let absolute = modal.now.centre_is_absolute;
    let [i, j, _] = arc.centre;
    if i.is_none() && j.is_none() {
        return Ok(());
    }
    if modal.now.plane != ArcPlane::Xy {
        // The linear part changes nothing here.
        if absolute {
            let text = |v: Option<f64>, by: f64| v.map(|v| digits.write(v + by).0);
            line.pair(*b"ij", [text(i, transform.shift.x), text(j, transform.shift.y)]);
        }
        return Ok(());
    }
    if absolute && (i.is_none() || j.is_none()) {
        return Err((0, Reason::ArcWords));
    }
    let at = Vector::new(i.unwrap_or(0.0), j.unwrap_or(0.0));
    let at = if absolute { transform.apply(at) } else { transform.linear * at };
    let coupled = is_coupled(transform);
    let text = |given: bool, v: f64| (given || coupled).then(|| digits.write(v).0);
    line.pair(*b"ij", [text(i.is_some(), at.x), text(j.is_some(), at.y)]);
    Ok(())
}

/// Returns the first word of an arc on a line.
fn first_word(line: &Line<'_>) -> Option<Word> {
    line.words.list.iter().find(|w| b"xyzijkrp".contains(&w.letter)).copied()
}

/// Writes an arc as lines.
fn chords(
    program: &Program<'_>,
    modal: &mut Modal,
    mut line: Line<'_>,
    arc: &Arc,
    arc_word: Option<Word>,
    stops: bool,
    end: &[u8],
) -> Result<New, Failure> {
    let has_z = line.words.has(b"z") || modal.now.plane != ArcPlane::Xy;
    let z = line.mm(modal, b'z')?;
    let incremental = modal.now.incremental;
    let start = start(modal, has_z, incremental)?;
    let goal = |at: f64, given: Option<f64>| match given {
        Some(by) if incremental => at + by,
        Some(to) => to,
        None => at,
    };
    let [x0, y0, z0] = start;
    let [x1, y1, _] = arc.end;
    let stop = [goal(x0, x1), goal(y0, y1), goal(z0, z)];
    let curve = Curve::new(modal, arc, start, stop)?;
    let (larger, _) = program.transform.linear.stretches();
    let larger = if modal.now.plane == ArcPlane::Xy { larger } else { larger.max(1.0) };
    let count = curve.count(larger, program.options.tolerance)?;
    if count > 1 && modal.inverse_time {
        return Err((0, Reason::InverseTime));
    }
    if count > 1 && stops {
        return Err((0, Reason::ArcAndStop));
    }
    let mut writer = Writer { last: start, carry_z: 0.0, has_z };
    let mut texts = Vec::with_capacity(count);
    for n in 1..=count {
        let at = if n == count { stop } else { curve.point(n as f64 / count as f64) };
        texts.push(writer.next(program, modal, at));
    }
    first(&mut line, modal, arc_word, texts.first().cloned().unwrap_or_default());
    let mut text = line.edits.apply(line.raw);
    let newline: &[u8] = if end.is_empty() { b"\n" } else { end };
    let small = |name| letter(line.raw, line.words, name);
    for words in texts.iter().skip(1) {
        text.extend(newline);
        let [x, y, z] = words;
        let slash = if line.words.deletable { "/" } else { "" };
        text.extend(format!("{slash}{}{x} {}{y}", small(b'x'), small(b'y')).bytes());
        if has_z {
            text.extend(format!(" {}{z}", small(b'z')).bytes());
        }
    }
    if count > 1 {
        text.extend(end);
    }
    modal.written = Some(Motion::Line);
    let known = !line.words.deletable;
    let is_known =
        |at: Option<f64>, given: bool| known && (at.is_some() || (given && !incremental));
    let [x, y, z_stop] = stop;
    modal.x = is_known(modal.x, x1.is_some()).then_some(x);
    modal.y = is_known(modal.y, y1.is_some()).then_some(y);
    modal.z = is_known(modal.z, z.is_some()).then_some(z_stop);
    if line.words.deletable {
        modal.motion = Motion::Unknown;
        modal.written = None;
    }
    Ok(New { text, chords: count })
}

/// Returns the start of an arc. Incremental arcs may start anywhere.
fn start(modal: &Modal, has_z: bool, incremental: bool) -> Result<[f64; 3], Failure> {
    let anywhere = incremental && !modal.now.centre_is_absolute;
    let known = |at: Option<f64>, name| match at {
        Some(at) => Ok(at),
        None if anywhere => Ok(0.0),
        None => Err((0, Reason::UnknownPosition(name))),
    };
    let z = if has_z { known(modal.z, 'Z')? } else { 0.0 };
    Ok([known(modal.x, 'X')?, known(modal.y, 'Y')?, z])
}

/// Writer of the ends of lines.
struct Writer {
    last: [f64; 3],
    carry_z: f64,
    has_z: bool,
}

impl Writer {
    /// Returns the words X Y Z of the line to a point of the file.
    fn next(&mut self, program: &Program<'_>, modal: &mut Modal, at: [f64; 3]) -> [String; 3] {
        let digits = Digits(modal.now.inches);
        let ([x, y, z], [x0, y0, z0]) = (at, self.last);
        let (want, want_z) = if modal.now.incremental {
            let by = program.transform.linear * Vector::new(x - x0, y - y0);
            (by + modal.carry, z - z0 + self.carry_z)
        } else {
            (program.transform.apply(Vector::new(x, y)), z)
        };
        let (text_x, said_x) = digits.write(want.x);
        let (text_y, said_y) = digits.write(want.y);
        let (text_z, said_z) = digits.write(want_z);
        modal.carry = Vector::new(want.x - said_x, want.y - said_y);
        self.carry_z = want_z - said_z;
        self.last = at;
        [text_x, text_y, if self.has_z { text_z } else { String::new() }]
    }
}

/// Makes the block of an arc its first line.
fn first(line: &mut Line<'_>, modal: &Modal, arc_word: Option<Word>, [x, y, z]: [String; 3]) {
    let raw = line.raw;
    let named = |name, text: &str| format!("{}{text}", letter(raw, line.words, name));
    match arc_word {
        Some(word) => line.edits.last_digit(raw, &word, '1'),
        None if modal.written != Some(Motion::Line) => {
            if let Some(word) = first_word(line) {
                line.edits.before(raw, &word, &named(b'g', "1"));
            }
        }
        None => {}
    }
    let has = |name| line.words.has(&[name]);
    // Words that the block does not have yet stand in the place of one that goes, or behind Y.
    let mut missing = Vec::new();
    if !has(b'x') && !has(b'y') {
        missing.push(named(b'x', &x));
        missing.push(named(b'y', &y));
    }
    if let Some(word) = line.words.get(b'z') {
        line.edits.value(word, z);
    } else if !z.is_empty() {
        missing.push(named(b'z', &z));
    }
    for word in line.words.list.iter().filter(|w| b"ijkrp".contains(&w.letter)) {
        if missing.is_empty() {
            line.edits.remove(raw, word);
        } else {
            line.edits.replace(word, missing.join(" "));
            missing.clear();
        }
    }
    line.pair(*b"xy", [Some(x), Some(y)]);
}
