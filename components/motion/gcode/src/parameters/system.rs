//! Parameters that the interpreter computes: its position, tool and modal state.

use crate::{
    axis::{Axis, Position},
    canon::{Direction, Plane, Unit},
    environment::Environment,
    error::Problem,
    parameters::{check_readable, number},
    state::{FeedMode, Side, State, modal::Spindle},
    text::evaluate::Values,
};

/// The parameters as a program sees them.
pub struct Reader<'a> {
    /// The state.
    pub state: &'a State,
    /// The world.
    pub environment: &'a dyn Environment,
}

impl Values for Reader<'_> {
    fn numbered(&self, index: i32) -> Result<f64, Problem> {
        check_readable(index)?;
        Ok(numbered(self.state, index))
    }

    fn named(&self, name: &str) -> Result<f64, Problem> {
        self.find(name).ok_or_else(|| Problem::NamedUndefined { name: name.into() })
    }

    fn exists(&self, name: &str) -> bool {
        self.find(name).is_some()
    }
}

impl Reader<'_> {
    /// Returns the pocket of the selected tool, -1 if none is selected or it has none.
    fn selected_pocket(&self) -> f64 {
        let number = self.state.selected.filter(|n| *n != 0);
        let pocket = number.and_then(|n| match self.state.changed_tools.get(&n) {
            Some(tool) => Some(tool.pocket),
            None => self.environment.tool(n).map(|t| t.pocket),
        });
        f64::from(pocket.filter(|p| *p != 0).unwrap_or(-1))
    }

    fn find(&self, name: &str) -> Option<f64> {
        if !name.starts_with('_') {
            return self.state.scope()?.locals.get(name).copied();
        }
        if let Some(rest) = name.strip_prefix("_ini[") {
            let (section, key) = rest.split_once(']')?;
            return self.environment.ini(section, key);
        }
        if let Some(item) = name.strip_prefix("_hal[").and_then(|r| r.strip_suffix(']')) {
            return self.environment.hal(item);
        }
        if name == SELECTED_POCKET {
            return Some(self.selected_pocket());
        }
        system(self.state, name).or_else(|| self.state.globals.get(name).copied())
    }
}

/// The name of the parameter whose value is in the tool table.
const SELECTED_POCKET: &str = "_selected_pocket";

/// Returns a numbered parameter as a program sees it.
pub fn numbered(state: &State, index: i32) -> f64 {
    let tool = &state.tool;
    match index {
        number::TOOL => f64::from(tool.number),
        5401..=5409 => coordinate(&tool.offset, index - 5401),
        5410 => tool.diameter,
        5411 => tool.front,
        5412 => tool.back,
        5413 => f64::from(tool.orientation),
        5420..=5428 => coordinate(&state.position, index - number::POSITION),
        _ => state.numbered.get(index),
    }
}

fn coordinate(position: &Position, index: i32) -> f64 {
    let axis = usize::try_from(index).ok().and_then(|i| Axis::ALL.get(i).copied());
    axis.map_or(0.0, |a| position[a])
}

/// Tells whether the name is one of the system's.
pub fn is_system(state: &State, name: &str) -> bool {
    system(state, name).is_some()
        || name == SELECTED_POCKET
        || name.starts_with("_ini[")
        || name.starts_with("_hal[")
}

/// Returns the value of a named parameter of the system.
fn system(state: &State, name: &str) -> Option<f64> {
    let modal = &state.modal;
    let truth = |t: bool| if t { 1.0 } else { 0.0 };
    let spindle: Option<&Spindle> = modal.spindles.first();
    let turning = |d: Direction| truth(spindle.is_some_and(|s| s.direction == d));
    if let Some(position) = position(state, name) {
        return Some(position);
    }
    Some(match name {
        "_vmajor" => 2.9,
        "_vminor" => 0.0,
        "_task" => truth(state.settings.task),
        "_remap_level" => state.levels.iter().filter(|l| l.remapped.is_some()).count() as f64,
        "_line" => f64::from(state.line),
        "_motion_mode" => f64::from(modal.motion),
        "_plane" => match modal.plane {
            Plane::Xy => 170.0,
            Plane::Xz => 180.0,
            Plane::Yz => 190.0,
            Plane::Uv => 171.0,
            Plane::Uw => 181.0,
            Plane::Vw => 191.0,
        },
        "_ccomp" => match state.compensation.side() {
            Side::Off => 400.0,
            Side::Left => 410.0,
            Side::Right => 420.0,
        },
        "_metric_machine" => truth(state.settings.unit == Unit::Millimetre),
        "_metric" => truth(modal.unit == Unit::Millimetre),
        "_imperial" => truth(modal.unit == Unit::Inch),
        "_absolute" => truth(modal.absolute),
        "_incremental" => truth(!modal.absolute),
        "_inverse_time" => truth(modal.feed_mode == FeedMode::InverseTime),
        "_units_per_minute" => truth(modal.feed_mode == FeedMode::PerMinute),
        "_units_per_rev" => truth(modal.feed_mode == FeedMode::PerRevolution),
        "_coord_system" => system_code(modal.system),
        "_tool_offset" => truth(modal.tool_offset),
        "_retract_r_plane" => truth(!modal.retract_old),
        "_retract_old_z" => truth(modal.retract_old),
        "_spindle_rpm_mode" => truth(!spindle.is_some_and(|s| s.css)),
        "_spindle_css_mode" => truth(spindle.is_some_and(|s| s.css)),
        "_ijk_absolute_mode" => truth(modal.ijk_absolute),
        "_lathe_diameter_mode" => truth(modal.diameter),
        "_lathe_radius_mode" => truth(!modal.diameter),
        "_spindle_on" => 1.0 - turning(Direction::Stopped),
        "_spindle_cw" => turning(Direction::Clockwise),
        "_mist" => truth(modal.mist),
        "_flood" => truth(modal.flood),
        "_speed_override" => truth(spindle.is_some_and(|s| s.speed_override)),
        "_feed_override" => truth(modal.feed_override),
        "_adaptive_feed" => truth(modal.adaptive_feed),
        "_feed_hold" => truth(modal.feed_hold),
        "_feed" => modal.feed,
        "_rpm" => spindle.map_or(0.0, |s| s.speed),
        "_current_tool" => f64::from(state.tool.number),
        "_current_pocket" => f64::from(state.tool.pocket),
        "_selected_tool" => f64::from(state.selected.unwrap_or(-1)),
        "_value" => state.returned.unwrap_or(0.0),
        "_value_returned" => truth(state.returned.is_some()),
        "_call_level" => state.call_level() as f64,
        _ => return None,
    })
}

fn system_code(system: u8) -> f64 {
    match system {
        0..=6 => 530.0 + 10.0 * f64::from(system),
        _ => 590.0 + f64::from(system) - 6.0,
    }
}

fn position(state: &State, name: &str) -> Option<f64> {
    let (letter, position) = match name.strip_prefix("_abs_") {
        Some(letter) => (letter, state.frame.machine(state.position)),
        None => (name.strip_prefix('_')?, state.position),
    };
    let mut letters = letter.chars();
    let first = letters.next()?;
    if letters.next().is_some() {
        return None;
    }
    Axis::ALL.iter().find(|a| a.letter() == first).map(|a| position[*a])
}
