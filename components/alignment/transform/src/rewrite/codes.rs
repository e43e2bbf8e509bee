//! G and M codes of a block: what they change, and which are refused.

use super::{
    Reason,
    modal::{ArcPlane, Modal, Motion},
    words::{Word, Words},
};

/// Use of the block's coordinates.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) enum Use {
    /// A motion.
    #[default]
    Motion,
    /// Machine coordinates (G53).
    Machine,
    /// A return to a stored place (G28, G30), in tenths.
    Return(i32),
    /// None that depends on the part.
    Free,
}

/// Codes of a block.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Codes {
    pub(super) usage: Use,
    /// Index of the word with the motion.
    pub(super) motion: Option<usize>,
    /// Indices of words G41 and G42.
    pub(super) sides: Vec<usize>,
    /// The block has M0, M1, M2, M30 or M60.
    pub(super) stops: bool,
    /// The block has M19, which takes the word R.
    pub(super) orients: bool,
}

/// Reads the codes of a block, and sets the modes that they change.
pub(super) fn codes(modal: &mut Modal, words: &Words) -> Result<Codes, (u32, Reason)> {
    let mut out = Codes::default();
    let before = modal.now;
    for (n, word) in words.list.iter().enumerate() {
        let Some(code) = tenths(word)? else { continue };
        if word.letter == b'm' {
            match code {
                0 | 10 | 600 => out.stops = true,
                20 | 300 => (out.stops, modal.ended) = (true, !words.deletable),
                190 => out.orients = true,
                720 | 730 => return Err((word.column(), Reason::RestoredModes(code / 10))),
                980 | 990 => return Err((word.column(), Reason::OtherFile)),
                _ => {}
            }
            continue;
        }
        if let Some(motion) = motion(code) {
            (modal.motion, modal.written, out.motion) = (motion, None, Some(n));
            continue;
        }
        let moves = words.has(b"xy");
        match code {
            170 => modal.now.plane = ArcPlane::Xy,
            180 => modal.now.plane = ArcPlane::Zx,
            190 => modal.now.plane = ArcPlane::Yz,
            171 | 181 | 191 => modal.now.plane = ArcPlane::Other,
            200 | 210 => (modal.now.inches, modal.has_unit) = (code == 200, true),
            900 => modal.now.incremental = false,
            910 => modal.now.incremental = true,
            901 => modal.now.centre_is_absolute = true,
            911 => modal.now.centre_is_absolute = false,
            930 => (modal.inverse_time, modal.any_inverse_time) = (true, true),
            940 | 950 => modal.inverse_time = false,
            280 | 300 => out.usage = Use::Return(code),
            530 => out.usage = Use::Machine,
            400 => modal.compensated = false,
            410 | 411 | 420 | 421 => {
                modal.compensated = true;
                out.sides.push(n);
            }
            540 | 550 | 560 | 570 | 580 | 590 | 591 | 592 | 593 => {
                if modal.system.is_some_and(|s| s != code) {
                    return Err((word.column(), Reason::SecondSystem));
                }
                modal.system = Some(code);
            }
            100 => {
                if words.has(b"xyr") && words.number(b'l')? != Some(1.0) {
                    return Err((word.column(), Reason::Code(code)));
                }
                out.usage = Use::Free;
            }
            431 | 520 | 920 if moves => return Err((word.column(), Reason::Code(code))),
            520 | 920 => out.usage = Use::Free,
            40 | 80 | 281 | 301 | 430 | 431 | 432 | 490 | 610 | 611 | 640 | 921 | 922 | 960
            | 970 | 980 | 990 => {}
            // Diameters, polar, scaled, mirrored and turned coordinates, G92.3, and codes that are not known.
            _ => return Err((word.column(), Reason::Code(code))),
        }
    }
    if words.deletable && modal.now != before {
        return Err((0, Reason::DeletedMode));
    }
    Ok(out)
}

/// Returns a G or M code in tenths.
fn tenths(word: &Word) -> Result<Option<i32>, (u32, Reason)> {
    if !matches!(word.letter, b'g' | b'm') {
        return Ok(None);
    }
    let shown = char::from(word.letter.to_ascii_uppercase());
    let value = word.value.ok_or((word.column(), Reason::Expression(shown)))?;
    let code = libm::round(value * 10.0);
    let known = (0.0..10_000.0).contains(&code) && libm::fabs(code - value * 10.0) < 1e-3;
    #[expect(clippy::cast_possible_truncation, reason = "the range is checked")]
    known.then_some(Some(code as i32)).ok_or((word.column(), Reason::Code(9999)))
}

/// Returns the motion of a G code.
fn motion(code: i32) -> Option<Motion> {
    Some(match code {
        0 | 10 | 330 | 331 => Motion::Line,
        20 => Motion::Arc(false),
        30 => Motion::Arc(true),
        382..=385 => Motion::Probe,
        730 | 740 | 810..=860 | 880 | 890 if code % 10 == 0 => Motion::Cycle,
        800 => Motion::None,
        50..=53 | 760 | 870 => Motion::Other(code),
        _ => return None,
    })
}
