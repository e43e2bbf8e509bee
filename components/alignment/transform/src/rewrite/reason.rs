//! Reasons why a block cannot be rewritten.

use core::fmt;
use hal_gcode::error::Problem;

/// Reason why a block cannot be rewritten.
#[derive(Clone, Debug, PartialEq)]
pub enum Reason {
    /// The line is not G-code.
    Syntax(Problem),
    /// The value of a word is an expression.
    Expression(char),
    /// Only one coordinate was ever given.
    UnknownPosition(char),
    /// The block moves in an unknown mode.
    UnknownMotion,
    /// The code sets or uses coordinates of its own.
    Code(i32),
    /// A second coordinate system.
    SecondSystem,
    /// Polar coordinates.
    Polar,
    /// A second pair of axes.
    SecondPair(char),
    /// A cycle in another plane.
    CyclePlane,
    /// Compensation of the tool's radius in another plane.
    CompensationPlane,
    /// An arc that does not stay one.
    Arc,
    /// An arc that is not complete, or contradicts itself.
    ArcWords,
    /// An arc that would become lines in inverse time feed.
    InverseTime,
    /// An arc that would become lines, on a block that ends or pauses the program.
    ArcAndStop,
    /// Modes that block delete may leave out.
    DeletedMode,
    /// M72 or M73, which restore modes that were saved.
    RestoredModes(i32),
    /// Flow control between blocks in different modes.
    FlowWithModes,
    /// A subroutine that is not in this file.
    OtherFile,
    /// A word that the motion does not take.
    Word(char),
    /// A return with one axis only.
    OneAxisReturn(i32),
    /// The transform has no inverse.
    Singular,
    /// A tolerance that makes no sense.
    Tolerance(f64),
    /// Too many lines for an arc, or too long a program.
    TooLong,
}

impl fmt::Display for Reason {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Syntax(problem) => {
                let remedy = problem.remedy();
                write!(f, "{problem}")?;
                if remedy.is_empty() { Ok(()) } else { write!(f, " ({remedy})") }
            }
            Self::Expression(letter) => write!(
                f,
                "the value of {letter} is an expression: 'expand' evaluates those whose parameters this program sets on its way"
            ),
            Self::UnknownPosition(letter) => write!(
                f,
                "the turned block needs {letter} too, and it is not known here: give both X and Y, or the start of the program"
            ),
            Self::UnknownMotion => f.write_str(
                "an arc or a straight line: the motion in force is not known here; repeat its G code on this line",
            ),
            Self::Code(code) => {
                write!(f, "{} has coordinates of its own, which cannot be aligned", name(*code))
            }
            Self::SecondSystem => {
                f.write_str("a second coordinate system: only one can be aligned")
            }
            Self::Polar => f.write_str("polar coordinates cannot be aligned: write X and Y"),
            Self::SecondPair(letter) => {
                write!(f, "{letter} belongs to a second pair of axes, which cannot be aligned")
            }
            Self::CyclePlane => f.write_str("a cycle can be aligned in the plane G17 only"),
            Self::CompensationPlane => f.write_str(
                "the tool's radius is compensated in another plane than G17, which does not turn with the part",
            ),
            Self::Arc => f.write_str(
                "the aligned part has unequal scales or is not square, so that this arc would be part of an ellipse: arcs=lines allows lines instead",
            ),
            Self::ArcWords => {
                f.write_str("an arc needs its end, and its centre (I J K) or its radius (R)")
            }
            Self::InverseTime => f.write_str(
                "this arc must become lines, and its feed is given as inverse time (G93): use G94",
            ),
            Self::ArcAndStop => f.write_str(
                "this arc must become lines, and its block ends or pauses the program: write M0, M1, M2, M30 or M60 on a line of its own",
            ),
            Self::DeletedMode => f.write_str(
                "block delete (/) may leave out this mode, so that the blocks behind it are unclear",
            ),
            Self::RestoredModes(code) => write!(
                f,
                "M{code} restores modes, so that the blocks behind it are unclear: write the modes instead"
            ),
            Self::FlowWithModes => f.write_str(
                "a program with O-words must keep one plane, one unit and one distance mode: G17, G20 or G21, G90 or G91, G90.1 or G91.1 at all its O-words and moves in X and Y",
            ),
            Self::OtherFile => f.write_str(
                "this subroutine is not in this file, and would run without alignment: put it into the file",
            ),
            Self::Word(letter) => write!(f, "{letter} has no meaning for this motion"),
            Self::OneAxisReturn(code) => write!(
                f,
                "{} with one of X and Y would move both after the turn: give both, or G91 and 0",
                name(*code)
            ),
            Self::Singular => f.write_str("the transform has no inverse"),
            Self::Tolerance(t) => {
                write!(f, "the tolerance of arcs is {t}, must be between 0.00001 and 10 mm")
            }
            Self::TooLong => f.write_str(
                "the result is too long: an arc has at most 100000 lines, a program 256 MiB",
            ),
        }
    }
}

/// Returns a G code, given in tenths, as it is written.
fn name(code: i32) -> String {
    if code % 10 == 0 { format!("G{}", code / 10) } else { format!("G{}.{}", code / 10, code % 10) }
}
