//! Words of `check` about a program that was written for another control.

use hal_gcode::{Dialect, Text, foreign};
use hal_job::world::World;

/// Returns the control that a program was written for, and what of it means nothing here; nothing for a program of LinuxCNC.
///
/// # Errors
/// The file cannot be read.
pub(super) fn told(file: &str, text: &Text, world: &World) -> Result<String, String> {
    let settings = &world.machine.settings;
    if settings.dialect != Dialect::LinuxCnc {
        return Ok(String::new());
    }
    let found = foreign::survey(text, &settings.remaps, world);
    let Some(found) = found.map_err(|reason| format!("{file}: {reason}"))? else {
        return Ok(String::new());
    };
    let mut out = format!("{file}: warning: {}\n", found.sentence());
    if !found.is_whole {
        out.push_str(&format!("  the first {} lines have:\n", found.lines));
    }
    for unread in &found.unread {
        out.push_str(&format!("  {unread}\n"));
    }
    Ok(out)
}
