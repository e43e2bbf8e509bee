//! The facts of an INI file that only the task needs.

use hal_gcode::state::modal::MAX_SPINDLES;

/// Facts of an INI file that only the task needs.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Rules {
    /// Programs and MDI need homed joints.
    pub(crate) needs_homing: bool,
    /// Seconds that a spindle may take to reach its speed.
    pub(crate) at_speed_timeout: f64,
    /// Spindles whose top speed the INI file states.
    pub(crate) has_top_speed: [bool; MAX_SPINDLES],
    /// Place for tool changes in machine units; axes without a coordinate stay where they are.
    pub(crate) change_position: Option<[Option<f64>; 9]>,
    /// Height in machine units for moves over the part, before a start in the middle of a program.
    pub(crate) safe_height: Option<f64>,
    /// Programs of users have the owner's rights, also in jobs that people elsewhere have begun.
    pub(crate) has_full_codes: bool,
}
