//! Pairs of coordinates: a point or a direction, from the words of a block to those of the result.

use super::{
    Reason,
    edit::{Digits, Edits, letter},
    modal::Modal,
    words::Words,
};
use crate::{Transform, Vector};

/// Returns whether a coordinate of the result depends on both coordinates of the file.
pub(super) fn is_coupled(transform: &Transform) -> bool {
    transform.linear.m12 != 0.0 || transform.linear.m21 != 0.0
}

/// Line that is being changed.
pub(super) struct Line<'a> {
    pub(super) raw: &'a [u8],
    pub(super) words: &'a Words,
    pub(super) edits: Edits,
}

impl Line<'_> {
    /// Writes two words; the first one stands before the second one.
    pub(super) fn pair(&mut self, names: [u8; 2], texts: [Option<String>; 2]) {
        let [first, second] = names;
        let [one, other] = texts;
        let named = |name, text: String| format!("{}{text}", letter(self.raw, self.words, name));
        match (self.words.get(first), self.words.get(second)) {
            (Some(a), b) => {
                if let Some(text) = one {
                    self.edits.value(a, text);
                }
                match (b, other) {
                    (Some(b), Some(text)) => self.edits.value(b, text),
                    (None, Some(text)) => {
                        let text = named(second, text);
                        self.edits.behind(self.raw, a, &text);
                    }
                    (_, None) => {}
                }
            }
            (None, Some(b)) => {
                if let Some(text) = one {
                    let text = named(first, text);
                    self.edits.before(self.raw, b, &text);
                }
                if let Some(text) = other {
                    self.edits.value(b, text);
                }
            }
            (None, None) => {}
        }
    }

    /// Returns the value of a word in millimetres.
    pub(super) fn mm(&self, modal: &Modal, name: u8) -> Result<Option<f64>, (u32, Reason)> {
        Ok(self.words.number(name)?.map(|v| v * modal.now.unit()))
    }
}

/// Move in X and Y, in millimetres of the file.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Displacement {
    /// Words that are given.
    pub(super) x: Option<f64>,
    pub(super) y: Option<f64>,
    /// Repetitions of an incremental move.
    pub(super) times: f64,
}

/// Rewrites X and Y of a block, and follows the position.
pub(super) fn straight(
    line: &mut Line<'_>,
    modal: &mut Modal,
    transform: &Transform,
    step: Displacement,
) -> Result<(), (u32, Reason)> {
    let coupled = is_coupled(transform);
    let want = if modal.now.incremental {
        let by = Vector::new(step.x.unwrap_or(0.0), step.y.unwrap_or(0.0));
        let carry = if step.times == 1.0 { modal.carry } else { Vector::ZERO };
        transform.linear * by + carry
    } else {
        let place = |given: Option<f64>, modal: Option<f64>, name| match given.or(modal) {
            Some(at) => Ok(at),
            None if !coupled => Ok(0.0),
            None => Err((0, Reason::UnknownPosition(name))),
        };
        let at = Vector::new(place(step.x, modal.x, 'X')?, place(step.y, modal.y, 'Y')?);
        transform.apply(at)
    };
    write(line, modal, step, want, coupled);
    follow(modal, step, line.words.deletable);
    Ok(())
}

/// Writes X and Y, and keeps the rest that the digits leave.
pub(super) fn write(
    line: &mut Line<'_>,
    modal: &mut Modal,
    step: Displacement,
    want: Vector,
    coupled: bool,
) {
    let digits = Digits(modal.now.inches);
    let (x, said_x) = digits.write(want.x);
    let (y, said_y) = digits.write(want.y);
    let x = (coupled || step.x.is_some()).then_some(x);
    let y = (coupled || step.y.is_some()).then_some(y);
    if !line.words.deletable {
        if x.is_some() {
            modal.carry.x = (want.x - said_x) * step.times;
        }
        if y.is_some() {
            modal.carry.y = (want.y - said_y) * step.times;
        }
    }
    line.pair(*b"xy", [x, y]);
}

/// Follows the position in the file.
fn follow(modal: &mut Modal, step: Displacement, deletable: bool) {
    let incremental = modal.now.incremental;
    let move_to = |at: &mut Option<f64>, given: Option<f64>| {
        let Some(by) = given else { return };
        *at = if incremental { at.map(|a| a + by * step.times) } else { Some(by) };
    };
    move_to(&mut modal.x, step.x);
    move_to(&mut modal.y, step.y);
    if deletable {
        (modal.x, modal.y) = (None, None);
    }
}

/// Follows the position of Z, whose word stays as it is.
pub(super) fn follow_z(modal: &mut Modal, words: &Words) {
    let Some(word) = words.get(b'z') else { return };
    let value = word.value.map(|v| v * modal.now.unit());
    modal.z = match (value, modal.now.incremental) {
        (Some(by), true) => modal.z.map(|z| z + by),
        (value, _) => value,
    };
    if words.deletable {
        modal.z = None;
    }
}
