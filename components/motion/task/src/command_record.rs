//! Orders as records of the service `motion`.

use crate::outside::{Move, Order, PathEnd, Shape, Speed};
use hal_component::abi::{MotionCommand, motion_flags as flag, motion_kind as kind};

/// All letters of a pose.
const ALL_LETTERS: u32 = 0x1ff;
/// Axis letters of the machine that motion may be sent.
pub(crate) type Letters = u32;

/// Returns the record of an order. Moves name the axes in `letters` alone.
pub(crate) fn record(order: &Order, letters: Letters) -> MotionCommand {
    let new = MotionCommand::new;
    let bit = |on: bool, bit: u32| if on { bit } else { 0 };
    match *order {
        Order::Enable => new(kind::ENABLE),
        Order::Disable => new(kind::DISABLE),
        Order::Home(None) => MotionCommand { flags: flag::ALL, ..new(kind::HOME) },
        Order::Home(Some(index)) => MotionCommand { index, ..new(kind::HOME) },
        Order::Abort => new(kind::ABORT),
        Order::Pause => new(kind::PAUSE),
        Order::Resume => new(kind::RESUME),
        Order::Step => new(kind::STEP),
        Order::Move(ref m) => of_move(m, letters),
        Order::Spindle { spindle, speed } => MotionCommand {
            index: spindle.into(),
            speed,
            flags: flag::HAS_SPEED,
            ..new(kind::SPINDLE)
        },
        Order::SpindleScale { spindle, scale } => MotionCommand {
            index: spindle.into(),
            scale,
            flags: flag::HAS_SCALE,
            ..new(kind::SPINDLE)
        },
        Order::Orient { spindle, degrees, mode } => MotionCommand {
            index: spindle.into(),
            value: degrees,
            mode: mode.into(),
            ..new(kind::ORIENT)
        },
        Order::FeedScale { feed, rapid } => MotionCommand {
            scale: feed.unwrap_or_default(),
            value: rapid.unwrap_or_default(),
            flags: bit(feed.is_some(), flag::HAS_SCALE) | bit(rapid.is_some(), flag::HAS_RAPID),
            ..new(kind::FEED)
        },
        Order::AdaptiveFeed(on) => {
            MotionCommand { flags: flag::HAS_ADAPTIVE | bit(on, flag::ADAPTIVE), ..new(kind::FEED) }
        }
        Order::FeedHold(on) => {
            MotionCommand { flags: flag::HAS_HOLD | bit(on, flag::HOLD), ..new(kind::FEED) }
        }
        Order::Digital { index, on, with_motion } => MotionCommand {
            index,
            flags: bit(on, flag::ON) | bit(with_motion, flag::SYNC),
            ..new(kind::DIGITAL_OUT)
        },
        Order::Analog { index, value, with_motion } => MotionCommand {
            index,
            value,
            flags: bit(with_motion, flag::SYNC),
            ..new(kind::ANALOG_OUT)
        },
        Order::ToolOffset(pose) => {
            MotionCommand { pose, letters: ALL_LETTERS, ..new(kind::TOOL_OFFSET) }
        }
    }
}

fn of_move(m: &Move, letters: Letters) -> MotionCommand {
    let mut out = MotionCommand::new(match m.shape {
        Shape::Line => kind::MOVE,
        Shape::Arc { .. } => kind::ARC,
        Shape::Probe { .. } => kind::PROBE,
        Shape::Tap { .. } => kind::TAP,
    });
    (out.pose, out.letters, out.line) = (m.to, letters, m.line);
    (out.speed_kind, out.speed) = match m.speed {
        Speed::Rapid => (1, 0.0),
        Speed::Feed(v) => (2, v),
    };
    (out.mode, out.tolerance) = match m.end {
        PathEnd::Stop => (0, 0.0),
        PathEnd::Exact => (1, 0.0),
        PathEnd::Blend(tolerance) => (2, tolerance),
    };
    out.cam_tolerance = m.cam_tolerance;
    match m.shape {
        Shape::Line => {}
        Shape::Arc { center, normal, clockwise, turns } => {
            (out.center, out.normal, out.count) = (center, normal, turns);
            let centre = 7 * flag::CENTER_X;
            out.flags = centre | if clockwise { flag::CLOCKWISE } else { 0 };
        }
        Shape::Probe { away, must } => {
            out.flags = if away { flag::AWAY } else { 0 } | if must { 0 } else { flag::OPTIONAL };
        }
        Shape::Tap { retract_scale } => out.scale = retract_scale,
    }
    if let Some(pitch) = m.pitch {
        (out.index, out.pitch) = (pitch.spindle.into(), pitch.travel);
        out.flags |= if pitch.velocity_mode { flag::VELOCITY_MODE } else { 0 };
        out.flags |= if pitch.is_at_surface { flag::SURFACE } else { 0 };
    }
    out
}
