//! A block: its codes, its motion, and its words in the result.

use crate::Matrix;

use super::{
    Program, Reason, arc,
    codes::{Codes, Use, codes},
    edit::Edits,
    modal::{ArcPlane, Modal, Motion},
    transfer::{ChangedLine, Displacement, follow_z, is_coupled, straight},
    words::Words,
};

/// Block of the result.
pub(super) struct New {
    /// The text; the end of the line is in it if there are several lines.
    pub(super) text: Vec<u8>,
    /// Number of lines that stand for an arc.
    pub(super) chords: usize,
}

/// Rewrites a block. Returns `None` if it stays as it is.
pub(super) fn block(
    program: &Program<'_>,
    modal: &mut Modal,
    words: &Words,
    raw: &[u8],
    end: &[u8],
) -> Result<Option<New>, (u32, Reason)> {
    let codes = codes(modal, words)?;
    modal.has_feed |= words.has(b"f");
    if let Some(polar) = words.list.iter().find(|w| matches!(w.letter, b'@' | b'^')) {
        return Err((polar.column(), Reason::Polar));
    }
    if let Some(second) = words.list.iter().find(|w| matches!(w.letter, b'u' | b'v')) {
        let shown = char::from(second.letter.to_ascii_uppercase());
        return Err((second.column(), Reason::SecondPair(shown)));
    }
    let mut line = ChangedLine { raw, words, edits: Edits::default() };
    let swaps = program.transform.linear.det() < 0.0;
    for side in codes.sides.iter().filter_map(|n| words.list.get(*n)).filter(|_| swaps) {
        let is_left = side.value.is_some_and(|v| v < 41.5);
        line.edits.last_digit(raw, side, if is_left { '2' } else { '1' });
    }
    let swapped = swaps && !codes.sides.is_empty();
    let moves = words.has(b"xy");
    let changed = match codes.usage {
        Use::Free => false,
        Use::Machine => {
            if moves || words.has(b"z") {
                let z = modal.z.filter(|_| !words.has(b"z"));
                modal.forget_position();
                modal.z = z;
            }
            false
        }
        Use::Return(code) => {
            let changed = moves && go_back(&mut line, modal, program, code)?;
            modal.forget_position();
            changed
        }
        Use::Motion => {
            let is_turned = program.transform.linear != Matrix::IDENTITY;
            if modal.compensated && is_turned && modal.now.plane != ArcPlane::Xy {
                return Err((0, Reason::CompensationPlane));
            }
            if let Motion::Arc(left) = modal.motion
                && takes_arc(modal, words)
            {
                modal.rewrote();
                return arc::arc(program, modal, line, &codes, left, end).map(Some);
            }
            motion(&mut line, modal, program, &codes, moves)?
        }
    };
    if changed {
        modal.rewrote();
    }
    let new = || New { text: line.edits.apply(raw), chords: 0 };
    Ok((changed || swapped).then(new))
}

/// Returns whether a block has words of an arc.
fn takes_arc(modal: &Modal, words: &Words) -> bool {
    words.has(b"xyij")
        || (words.has(b"r") && !words.has(b"m"))
        || (words.has(b"zk") && (modal.now.plane != ArcPlane::Xy || modal.written.is_some()))
}

/// Rewrites a return by way of a point.
fn go_back(
    line: &mut ChangedLine<'_>,
    modal: &mut Modal,
    program: &Program<'_>,
    code: i32,
) -> Result<bool, (u32, Reason)> {
    let step = Displacement { x: line.mm(modal, b'x')?, y: line.mm(modal, b'y')?, times: 1.0 };
    let single = step.x.is_some() != step.y.is_some();
    if single && is_coupled(program.transform) {
        let stays = modal.now.incremental && step.x.or(step.y) == Some(0.0);
        return if stays { Ok(false) } else { Err((0, Reason::OneAxisReturn(code))) };
    }
    straight(line, modal, program.transform, step)?;
    Ok(true)
}

/// Rewrites a motion that is no arc. Returns whether the line changes.
fn motion(
    line: &mut ChangedLine<'_>,
    modal: &mut Modal,
    program: &Program<'_>,
    codes: &Codes,
    moves: bool,
) -> Result<bool, (u32, Reason)> {
    let words = line.words;
    let refused = |letters: &[u8]| {
        let found = words.list.iter().find(|w| letters.contains(&w.letter));
        found.map(|w| (w.column(), w.letter.to_ascii_uppercase()))
    };
    let of_arc: &[u8] = if codes.orients { b"ij" } else { b"ijr" };
    match modal.motion {
        Motion::Line if words.has(b"k") => {}
        Motion::Unknown | Motion::Line | Motion::Probe => {
            if let Some((column, letter)) = refused(of_arc) {
                let is_known = modal.motion != Motion::Unknown;
                let letter = char::from(letter);
                let reason = if is_known { Reason::Word(letter) } else { Reason::UnknownMotion };
                return Err((column, reason));
            }
        }
        Motion::Cycle => {
            if let Some((column, letter)) = refused(b"ij") {
                return Err((column, Reason::Word(char::from(letter))));
            }
            if moves && modal.now.plane != ArcPlane::Xy {
                return Err((0, Reason::CyclePlane));
            }
        }
        Motion::None => {
            if let Some((column, letter)) = refused(b"xyij") {
                return Err((column, Reason::Word(char::from(letter))));
            }
        }
        Motion::Other(code) => {
            if codes.motion.is_some() || words.has(b"xyijr") {
                return Err((0, Reason::Code(code)));
            }
        }
        Motion::Arc(_) => {}
    }
    if moves {
        let times = match modal.motion {
            Motion::Cycle => words.number(b'l')?.unwrap_or(1.0),
            _ => 1.0,
        };
        let step = Displacement { x: line.mm(modal, b'x')?, y: line.mm(modal, b'y')?, times };
        straight(line, modal, program.transform, step)?;
    }
    match modal.motion {
        Motion::Probe if moves || words.has(b"z") => modal.forget_position(),
        Motion::Cycle if moves || words.has(b"zr") => modal.z = None,
        _ => follow_z(modal, words),
    }
    if words.deletable && codes.motion.is_some() {
        modal.motion = Motion::Unknown;
    }
    Ok(moves)
}
