//! G-code in machine coordinates: what depends on X and Y is transformed, everything else stays byte for byte.

mod arc;
mod block;
mod codes;
mod curve;
mod edit;
mod modal;
mod reason;
mod transfer;
mod words;

pub use reason::Reason;

use crate::{Transform, Vector};
use hal_gcode::text::oword::{Action, Label};
use modal::Modal;
use std::collections::BTreeSet;
use words::{Known, Words};

/// Largest number of refusals that are reported.
pub const MAX_REFUSALS: usize = 100;
/// Largest size of a program in bytes, and of its result.
pub const MAX_BYTES: usize = 256 << 20;

/// Treatment of arcs that the transform makes parts of ellipses.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Arcs {
    /// Lines within the tolerance.
    #[default]
    Lines,
    /// A refusal.
    Refuse,
}

/// Conditions of a rewriting.
#[derive(Clone, Debug, PartialEq)]
pub struct Rules {
    /// Treatment of arcs that do not stay arcs.
    pub arcs: Arcs,
    /// Largest distance of lines, or of an arc that is kept, from the exact curve, in millimetres.
    pub tolerance: f64,
    /// Place of the tool before the program, in the file's coordinates, in millimetres.
    pub start: Option<Vector>,
    /// Evaluate expressions and parameters that the program itself sets.
    pub expand: bool,
    /// The machine's own unit, in which a program without G20 and G21 is, is the inch.
    pub inches: bool,
    /// Name of the source for a comment at the top, if there shall be one.
    pub header: Option<String>,
}

impl Default for Rules {
    fn default() -> Self {
        Self {
            arcs: Arcs::Lines,
            tolerance: 0.005,
            start: None,
            expand: false,
            inches: false,
            header: None,
        }
    }
}

/// Rewritten program.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Rewritten {
    /// The text.
    pub text: Vec<u8>,
    /// Number of blocks that were changed.
    pub changed: usize,
    /// Number of arcs that became lines, and of these lines.
    pub arcs: usize,
    /// Number of lines that stand for arcs.
    pub chords: usize,
    /// True if feeds of a program with unequal scales stay as they are.
    pub feed_is_uneven: bool,
    /// True if blocks were changed before the first G20 or G21, in the machine's unit.
    pub unit_is_assumed: bool,
}

/// Block that cannot be rewritten.
#[derive(Clone, Debug, PartialEq)]
pub struct Refusal {
    /// The line, from 1.
    pub line: u32,
    /// The column, from 1; 0 for the whole line.
    pub column: u32,
    /// The reason.
    pub reason: Reason,
}

/// Rewrites a program by a transform.
///
/// # Errors
/// The blocks that cannot be rewritten, with their reasons, at most [`MAX_REFUSALS`].
pub fn rewrite(
    text: &[u8],
    transform: &Transform,
    options: &Rules,
) -> Result<Rewritten, Vec<Refusal>> {
    let whole = |reason| vec![Refusal { line: 0, column: 0, reason }];
    if !transform.linear.is_usable()
        || transform.linear.inverse().is_none()
        || !transform.shift.is_usable()
    {
        return Err(whole(Reason::Singular));
    }
    let usual = 1e-5 <= options.tolerance && options.tolerance <= 10.0;
    if !usual {
        return Err(whole(Reason::Tolerance(options.tolerance)));
    }
    if text.len() > MAX_BYTES {
        return Err(whole(Reason::TooLong));
    }
    let program = Program { transform, options, flow: Flow::of(text) };
    program.run(text)
}

/// Program with its conditions.
struct Program<'a> {
    transform: &'a Transform,
    options: &'a Rules,
    flow: Flow,
}

impl Program<'_> {
    fn run(&self, text: &[u8]) -> Result<Rewritten, Vec<Refusal>> {
        let mut out = Rewritten::default();
        let mut refusals = Vec::new();
        let mut modal = Modal::new(self.options.start, self.options.inches);
        let mut known = Known::default();
        let mut words = Words::default();
        let (mut header, mut begun, mut ended) = (self.options.header.is_some(), false, false);
        // Behind a last % of a program without a first one, subroutines are found all the same.
        let mut is_framed = false;
        for (number, line) in (1_u32..).zip(text.split_inclusive(|b| *b == b'\n')) {
            let body = without_end(line);
            let end = line.get(body.len()..).unwrap_or_default();
            let percent = body.trim_ascii() == b"%";
            if header && !percent && !body.trim_ascii().is_empty() {
                out.text.extend(self.header(text).as_bytes());
                out.text.extend(if end.is_empty() { b"\n" } else { end });
                header = false;
            }
            if ended || percent {
                is_framed = is_framed || !begun;
                ended = ended || begun && is_framed;
                begun = begun || percent;
                out.text.extend(line);
                continue;
            }
            begun = begun || !body.trim_ascii().is_empty();
            let done = words.read(body, self.options.expand.then_some(&known)).and_then(|()| {
                if let Some(word) = &words.flow {
                    known.forget();
                    modal.forget_all();
                    // Flow control takes these modes to another O-word, before this one or behind it.
                    if word.action != Action::Bare {
                        modal.modes.insert(modal.now);
                    }
                    return self.flow.check(&words).map(|()| None);
                }
                block::block(self, &mut modal, &words, body, end)
            });
            match done {
                Ok(None) => out.text.extend(line),
                Ok(Some(new)) => {
                    out.text.extend(new.text);
                    out.text.extend(if new.chords > 1 { &[] } else { end });
                    out.changed += 1;
                    out.arcs += usize::from(new.chords > 0);
                    out.chords += new.chords;
                }
                Err((column, reason)) => {
                    refusals.push(Refusal { line: number, column, reason });
                    if refusals.len() >= MAX_REFUSALS {
                        return Err(refusals);
                    }
                    modal.forget_position();
                }
            }
            known.assign(&words, self.options.expand);
            ended = modal.ended && !self.flow.any;
            if out.text.len() > MAX_BYTES {
                refusals.push(Refusal { line: number, column: 0, reason: Reason::TooLong });
                return Err(refusals);
            }
        }
        if let Some(reason) = self.unclear(&modal, &out) {
            refusals.push(Refusal { line: self.flow.first, column: 0, reason });
        }
        out.unit_is_assumed = modal.unit_is_assumed;
        out.feed_is_uneven = modal.has_feed && !self.transform.is_even();
        if refusals.is_empty() { Ok(out) } else { Err(refusals) }
    }

    /// Returns what flow control makes unclear, at the end of the program.
    fn unclear(&self, modal: &Modal, out: &Rewritten) -> Option<Reason> {
        if !self.flow.any {
            return None;
        }
        if modal.modes.len() > 1 {
            Some(Reason::FlowWithModes)
        } else if modal.any_inverse_time && out.arcs > 0 {
            Some(Reason::InverseTime)
        } else {
            None
        }
    }

    /// Returns the comment at the top.
    fn header(&self, text: &[u8]) -> String {
        let name = self.options.header.as_deref().unwrap_or_default();
        let plain = |c: char| if matches!(c, '(' | ')') || c.is_control() { '_' } else { c };
        let name: String = name.chars().map(plain).collect();
        let parts = self.transform.parts();
        format!("(aligned: {parts}; source {name}, CRC-32 {:08x})", crc32(text))
    }
}

/// Returns a line without its end.
fn without_end(line: &[u8]) -> &[u8] {
    let line = line.strip_suffix(b"\n").unwrap_or(line);
    line.strip_suffix(b"\r").unwrap_or(line)
}

/// Returns the checksum CRC-32 of bytes, as zip files have it.
fn crc32(bytes: &[u8]) -> u32 {
    !bytes.iter().fold(u32::MAX, |crc, byte| {
        (0..8).fold(crc ^ u32::from(*byte), |c, _| {
            if c & 1 == 1 { (c >> 1) ^ 0xedb8_8320 } else { c >> 1 }
        })
    })
}

/// Flow control of a program.
#[derive(Default)]
struct Flow {
    /// The program has O-words.
    any: bool,
    /// Line of the first one.
    first: u32,
    /// Labels of its subroutines.
    subs: BTreeSet<Box<str>>,
}

impl Flow {
    fn of(text: &[u8]) -> Self {
        let mut out = Self::default();
        let mut words = Words::default();
        for (number, line) in (1_u32..).zip(text.split_inclusive(|b| *b == b'\n')) {
            let body = without_end(line);
            let begins = body.iter().find(|b| !b.is_ascii_whitespace());
            if !matches!(begins, Some(b'o' | b'O' | b'/' | b'n' | b'N')) {
                continue;
            }
            if words.read(body, None).is_err() {
                continue;
            }
            let Some(word) = &words.flow else { continue };
            if word.action == Action::Bare {
                continue;
            }
            if !out.any {
                (out.any, out.first) = (true, number);
            }
            if let (Action::Sub, Label::Name(name)) = (&word.action, &word.label) {
                out.subs.insert(name.clone());
            }
        }
        out
    }

    /// Checks that a line of flow control stays in this file.
    fn check(&self, words: &Words) -> Result<(), (u32, Reason)> {
        let Some(word) = &words.flow else { return Ok(()) };
        match (&word.action, &word.label) {
            (Action::Call(_), Label::Name(name)) if self.subs.contains(name) => Ok(()),
            (Action::Call(_), _) => Err((0, Reason::OtherFile)),
            _ => Ok(()),
        }
    }
}

#[cfg(test)]
mod tests;
