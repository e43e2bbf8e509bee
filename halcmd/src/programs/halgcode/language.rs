//! The option `--dialect` of all commands that run a program.

use crate::programs::options::Opt;
use hal_gcode::Dialect;
use hal_job::machine::Machine;

/// Returns the option.
pub(super) const fn option<T: Copy>(id: T) -> Opt<T> {
    Opt {
        long: Some("dialect"),
        help: "the language of the program, linuxcnc or rs274d; that of [RS274NGC]DIALECT if none is given",
        ..Opt::short_with(id, 'd', "NAME")
    }
}

/// Sets the language that the option states.
///
/// # Errors
/// There is no language of this name.
pub(super) fn set(machine: &mut Machine, name: Option<&str>) -> Result<(), String> {
    let Some(name) = name else { return Ok(()) };
    let dialect = Dialect::named(name);
    machine.settings.dialect =
        dialect.ok_or_else(|| format!("'{name}' is no dialect: {}", Dialect::NAMES))?;
    Ok(())
}
