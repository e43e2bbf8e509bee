//! The state of the interpreter at a line, as previews read it.

use hal_gcode::{
    State,
    canon::{Direction, Plane},
};
use pyo3::prelude::*;

/// The modal codes in force at a line. A code of -1 is none.
#[pyclass(module = "gcode", name = "linecode", frozen, get_all)]
pub(super) struct LineCode {
    sequence_number: u32,
    feed_rate: f64,
    speed: f64,
    motion_mode: i32,
    block: i32,
    plane: i32,
    cutter_side: i32,
    units: i32,
    distance_mode: i32,
    feed_mode: i32,
    origin: i32,
    tool_length_offset: i32,
    retract_mode: i32,
    path_mode: i32,
    stopping: i32,
    spindle: i32,
    toolchange: i32,
    mist: i32,
    flood: i32,
    overrides: i32,
    gcodes: [i32; 17],
    mcodes: [i32; 10],
}

impl LineCode {
    /// Returns the state at a line.
    pub(super) fn of(state: &State, line: u32) -> Self {
        let codes = state.g_codes().map(|code| i32::try_from(code).unwrap_or(-1));
        let [motion, plane, units, side, offset, origin, path, diameter, ..] = codes;
        let [.., distance, arcs, feed, css, retract] = codes;
        let modal = &state.modal;
        let spindle = modal.spindles.first();
        let turning = match spindle.map(|s| s.direction) {
            Some(Direction::Clockwise) => 3,
            Some(Direction::Counterclockwise) => 4,
            _ => 5,
        };
        let speed_override = spindle.is_none_or(|s| s.speed_override);
        let (override_code, other) = match (modal.feed_override, speed_override) {
            (true, true) => (48, -1),
            (false, false) => (49, -1),
            (true, false) => (50, 51),
            (false, true) => (50, -1),
        };
        let mist = if modal.mist {
            7
        } else if modal.flood {
            -1
        } else {
            9
        };
        let flood = if modal.flood { 8 } else { -1 };
        let number = i32::try_from(line).unwrap_or(i32::MAX);
        Self {
            sequence_number: line,
            feed_rate: modal.feed,
            speed: spindle.map_or(0.0, |s| s.speed),
            motion_mode: motion,
            block: -1,
            plane,
            cutter_side: side,
            units,
            distance_mode: distance,
            feed_mode: feed,
            origin,
            tool_length_offset: offset,
            retract_mode: retract,
            path_mode: path,
            stopping: -1,
            spindle: turning,
            toolchange: -1,
            mist,
            flood,
            overrides: override_code,
            gcodes: [
                number, motion, -1, plane, side, units, distance, feed, origin, offset, retract,
                path, -1, css, arcs, diameter, 922,
            ],
            mcodes: [number, -1, turning, -1, mist, flood, override_code, other, 53, 0],
        }
    }
}

/// Returns the number of a plane in canonical calls.
pub(super) const fn plane_number(plane: Plane) -> i32 {
    match plane {
        Plane::Xy => 1,
        Plane::Yz => 2,
        Plane::Xz => 3,
        Plane::Uv => 4,
        Plane::Vw => 5,
        Plane::Uw => 6,
    }
}
