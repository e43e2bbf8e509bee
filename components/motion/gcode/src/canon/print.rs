//! Canonical calls as text, in the form that `rs274` prints.

use core::fmt;

use super::{Call, Direction, PathMode, Plane, Unit};
use crate::axis::Position;

/// A number with four digits behind the point: the text of `{:.4}`, in less time.
struct Four(f64);

impl fmt::Display for Four {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let scaled = libm::fabs(self.0) * 1e4;
        let whole = libm::floor(scaled);
        let rest = scaled - whole;
        // Near a half, or far out, the product's rounding could decide: leave it to the exact way.
        if scaled.is_nan() || scaled >= 1e13 || libm::fabs(rest - 0.5) < 0.01 {
            return write!(f, "{:.4}", self.0);
        }
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "0 to 1e13")]
        let mut left = whole as u64 + u64::from(rest > 0.5);
        let mut text = [b'0'; 24];
        let mut length = 0usize;
        for slot in text.iter_mut().rev() {
            if length == 4 {
                *slot = b'.';
            } else {
                if length > 5 && left == 0 {
                    break;
                }
                *slot = b'0' + u8::try_from(left % 10).unwrap_or(0);
                left /= 10;
            }
            length += 1;
        }
        if self.0.is_sign_negative() {
            f.write_str("-")?;
        }
        let digits = text.get(24 - length..).unwrap_or_default();
        f.write_str(core::str::from_utf8(digits).unwrap_or_default())
    }
}

/// The first six coordinates with four digits.
struct Six<'a>(&'a Position);

impl fmt::Display for Six<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let p = self.0;
        for value in [p.x, p.y, p.z, p.a, p.b] {
            Four(value).fmt(f)?;
            f.write_str(", ")?;
        }
        Four(p.c).fmt(f)
    }
}

/// Nine coordinates in three groups.
struct Nine<'a>(&'a Position);

impl fmt::Display for Nine<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let p = self.0;
        write!(f, "{:.4} {:.4} {:.4}, {:.4} {:.4} {:.4}, ", p.x, p.y, p.z, p.a, p.b, p.c)?;
        write!(f, "{:.4} {:.4} {:.4}", p.u, p.v, p.w)
    }
}

impl fmt::Display for Call {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::UseLengthUnits(unit) => f.write_str(match unit {
                Unit::Inch => "USE_LENGTH_UNITS(CANON_UNITS_INCHES)",
                Unit::Millimetre => "USE_LENGTH_UNITS(CANON_UNITS_MM)",
            }),
            Self::SelectPlane(plane) => {
                let name = match plane {
                    Plane::Xy => "XY",
                    Plane::Xz => "XZ",
                    Plane::Yz => "YZ",
                    Plane::Uv => "UV",
                    Plane::Uw => "UW",
                    Plane::Vw => "VW",
                };
                write!(f, "SELECT_PLANE(CANON_PLANE_{name})")
            }
            Self::SetG5xOffset { system, offset } => {
                write!(f, "SET_G5X_OFFSET({system}, {})", Six(offset))
            }
            Self::SetG92Offset(p) => write!(f, "SET_G92_OFFSET({})", Six(p)),
            Self::SetXyRotation(r) => write!(f, "SET_XY_ROTATION({r:.4})"),
            Self::UseToolLengthOffset(p) => write!(f, "USE_TOOL_LENGTH_OFFSET({})", Nine(p)),
            Self::StraightTraverse(p) => {
                f.write_str("STRAIGHT_TRAVERSE(")?;
                Six(p).fmt(f)?;
                f.write_str(")")
            }
            Self::StraightFeed(p) => {
                f.write_str("STRAIGHT_FEED(")?;
                Six(p).fmt(f)?;
                f.write_str(")")
            }
            Self::StraightProbe { end, .. } => write!(f, "STRAIGHT_PROBE({})", Six(end)),
            Self::RigidTap { end, .. } => {
                write!(f, "RIGID_TAP({:.4}, {:.4}, {:.4})", end.x, end.y, end.z)
            }
            Self::ArcFeed { .. } | Self::NurbsFeed { .. } => curve(self, f),
            Self::SetFeedRate(r) => write!(f, "SET_FEED_RATE({})", Four(*r)),
            Self::SetFeedMode { spindle, per_revolution } => {
                write!(f, "SET_FEED_MODE({spindle}, {})", u8::from(*per_revolution))
            }
            Self::SetPathMode(mode) => match mode {
                PathMode::ExactPath => f.write_str("SET_MOTION_CONTROL_MODE(CANON_EXACT_PATH)"),
                PathMode::ExactStop => f.write_str("SET_MOTION_CONTROL_MODE(CANON_EXACT_STOP)"),
                PathMode::Continuous { tolerance } => {
                    write!(f, "SET_MOTION_CONTROL_MODE(CANON_CONTINUOUS, {tolerance:.6})")
                }
            },
            Self::SetNaiveCamTolerance(t) => write!(f, "SET_NAIVECAM_TOLERANCE({t:.4})"),
            Self::StartSpeedFeedSync { pitch, velocity_mode, .. } => {
                write!(f, "START_SPEED_FEED_SYNC({pitch:.6},{})", u8::from(*velocity_mode))
            }
            Self::StopSpeedFeedSync => f.write_str("STOP_SPEED_FEED_SYNCH()"),
            Self::Dwell(s) => write!(f, "DWELL({s:.4})"),
            Self::SetSpindleSpeed { .. }
            | Self::SetSpindleMode { .. }
            | Self::TurnSpindle { .. }
            | Self::OrientSpindle { .. }
            | Self::WaitSpindleOrient { .. } => spindle(self, f),
            Self::SelectTool(n) => write!(f, "SELECT_TOOL({n})"),
            Self::StartChange => f.write_str("START_CHANGE()"),
            Self::ChangeTool(n) => write!(f, "CHANGE_TOOL({n})"),
            Self::ChangeToolNumber(n) => write!(f, "CHANGE_TOOL_NUMBER({n})"),
            Self::SetToolTableEntry { pocket, tool, offset, front, back, orientation, .. } => {
                write!(f, "SET_TOOL_TABLE_ENTRY({pocket}, {tool}, ")?;
                let p = offset;
                write!(f, "{:.4} {:.4} {:.4} {:.4} {:.4} {:.4} ", p.x, p.y, p.z, p.a, p.b, p.c)?;
                write!(f, "{:.4} {:.4} {:.4}, ", p.u, p.v, p.w)?;
                write!(f, "{front:.4}, {back:.4}, {orientation})")
            }
            Self::ReloadToolData => f.write_str("RELOAD_TOOLDATA()"),
            Self::Mist(on) => f.write_str(if *on { "MIST_ON()" } else { "MIST_OFF()" }),
            Self::Flood(on) => f.write_str(if *on { "FLOOD_ON()" } else { "FLOOD_OFF()" }),
            Self::FeedOverride(on) => write!(f, "{}_FEED_OVERRIDE()", able(*on)),
            Self::SpeedOverride { spindle, on } => {
                write!(f, "{}_SPEED_OVERRIDE({spindle})", able(*on))
            }
            Self::AdaptiveFeed(on) => write!(f, "{}_ADAPTIVE_FEED()", able(*on)),
            Self::FeedHold(on) => write!(f, "{}_FEED_HOLD()", able(*on)),
            Self::DigitalOutput { index, on, with_motion } => {
                let verb = if *on { "SET" } else { "CLEAR" };
                write!(f, "{verb}_{}_OUTPUT_BIT({index})", kind(*with_motion))
            }
            Self::AnalogOutput { index, value, with_motion } => {
                write!(f, "SET_{}_OUTPUT_VALUE({index},{value:.6})", kind(*with_motion))
            }
            Self::Wait { index, analog, mode, timeout } => {
                write!(f, "WAIT({index}, {}, {mode}, {timeout:.4})", u8::from(*analog))
            }
            Self::UserCode { code, p, q } => write!(f, "USER_CODE(M{code}, {p:.4}, {q:.4})"),
            Self::TurnProbeOn => f.write_str("TURN_PROBE_ON()"),
            Self::TurnProbeOff => f.write_str("TURN_PROBE_OFF()"),
            Self::ProgramStop => f.write_str("PROGRAM_STOP()"),
            Self::OptionalProgramStop => f.write_str("OPTIONAL_PROGRAM_STOP()"),
            Self::PalletShuttle => f.write_str("PALLET_SHUTTLE()"),
            Self::ProgramEnd => f.write_str("PROGRAM_END()"),
            Self::Finish => f.write_str("FINISH()"),
            Self::Message(text) => write!(f, "MESSAGE(\"{text}\")"),
            Self::Print(text) => f.write_str(text),
            Self::Log(text) => write!(f, "LOG(\"{text}\")"),
            Self::LogOpen { name, append } => {
                write!(f, "{}(\"{name}\")", if *append { "LOGAPPEND" } else { "LOGOPEN" })
            }
            Self::LogClose => f.write_str("LOGCLOSE()"),
            Self::ProbeOpen(name) => write!(f, "COMMENT(\"probeopen {name}\")"),
            Self::ProbeClose => f.write_str("COMMENT(\"probeclose\")"),
            Self::Comment(text) => write!(f, "COMMENT(\"{text}\")"),
        }
    }
}

fn able(on: bool) -> &'static str {
    if on { "ENABLE" } else { "DISABLE" }
}

fn kind(with_motion: bool) -> &'static str {
    if with_motion { "MOTION" } else { "AUX" }
}

fn curve(call: &Call, f: &mut fmt::Formatter<'_>) -> fmt::Result {
    match call {
        Call::ArcFeed { plane, end, centre_first, centre_second, turns } => {
            let (first, second, along) = plane.axes();
            write!(f, "ARC_FEED({}, {}, ", Four(end[first]), Four(end[second]))?;
            write!(f, "{}, {}, {turns}, ", Four(*centre_first), Four(*centre_second))?;
            let [along, a, b, c] = [end[along], end.a, end.b, end.c].map(Four);
            write!(f, "{along}, {a}, {b}, {c})")
        }
        Call::NurbsFeed { points, .. } => write!(f, "NURBS_FEED({}, ...)", points.len()),
        _ => Ok(()),
    }
}

fn spindle(call: &Call, f: &mut fmt::Formatter<'_>) -> fmt::Result {
    match call {
        Call::SetSpindleSpeed { spindle, speed } => {
            write!(f, "SET_SPINDLE_SPEED({spindle}, {speed:.4})")
        }
        Call::SetSpindleMode { spindle, css_max } => {
            write!(f, "SET_SPINDLE_MODE({spindle} {css_max:.4})")
        }
        Call::TurnSpindle { spindle, direction } => match direction {
            Direction::Stopped => write!(f, "STOP_SPINDLE_TURNING({spindle})"),
            Direction::Clockwise => write!(f, "START_SPINDLE_CLOCKWISE({spindle})"),
            Direction::Counterclockwise => {
                write!(f, "START_SPINDLE_COUNTERCLOCKWISE({spindle})")
            }
        },
        Call::OrientSpindle { spindle, degrees, mode } => {
            write!(f, "ORIENT_SPINDLE({spindle}, {degrees:.4}, {mode})")
        }
        Call::WaitSpindleOrient { spindle, timeout } => {
            write!(f, "SPINDLE.{spindle}.WAIT_ORIENT_COMPLETE({timeout:.4})")
        }
        _ => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn four_digits_are_those_of_the_standard_library() {
        let mut seed = 1u64;
        for _ in 0..200_000 {
            seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
            let digits = (seed >> 33) as f64;
            let scale = [1e-9, 1e-5, 1.0, 1e4, 5e-5, -1e-5, 1e-4][(seed >> 20) as usize % 7];
            let value = digits * scale;
            assert_eq!(Four(value).to_string(), format!("{value:.4}"));
        }
        for value in [0.0, -0.0, 0.00005, 0.00015, -0.00001, 9.99995, 1e13, f64::NAN, f64::INFINITY]
        {
            assert_eq!(Four(value).to_string(), format!("{value:.4}"));
        }
    }
}
