//! The files, tools and values that a program sees.

use super::machine::Machine;
use hal_gcode::{Environment, Text, tool::Tool};
use std::{collections::BTreeMap, os::unix::fs::PermissionsExt, path::Path, sync::Arc};

/// The world of a program that runs without its machine.
pub(super) struct World {
    pub(super) machine: Machine,
    /// Values of HAL items, as options give them.
    pub(super) hal: BTreeMap<String, f64>,
}

/// The largest file that is read.
const MAX_BYTES: u64 = 2 << 30;

/// Reads a program.
///
/// # Errors
/// The file cannot be read or is too large.
pub(super) fn program(path: &Path) -> Result<Text, String> {
    let wrong = |e: &std::io::Error| format!("{}: {}", path.display(), hal_output::reason(e));
    let size = std::fs::metadata(path).map_err(|e| wrong(&e))?.len();
    if size > MAX_BYTES {
        return Err(format!("{}: more than {MAX_BYTES} bytes", path.display()));
    }
    let bytes = std::fs::read(path).map_err(|e| wrong(&e))?;
    Ok(Arc::new(bytes))
}

impl Environment for World {
    fn open(&self, name: &str) -> Option<Text> {
        // A program's own name comes as it was given; a subroutine's comes without ending.
        if name.ends_with(".ngc") || name.contains('/') {
            let as_given = Path::new(name);
            if as_given.is_file() {
                return program(as_given).ok();
            }
        }
        // Names of subroutines name no folder.
        let file = Path::new(name).file_name().filter(|f| *f == name)?;
        let mut file = file.to_owned();
        file.push(".ngc");
        let paths = self.machine.folders.iter().map(|f| f.join(&file));
        paths.filter(|p| p.is_file()).find_map(|p| program(&p).ok())
    }

    fn tool(&self, number: i32) -> Option<Tool> {
        self.machine.tools.find(number).cloned()
    }

    fn ini(&self, section: &str, key: &str) -> Option<f64> {
        let entries = self.machine.ini.as_ref()?.entries();
        let mut found = entries.filter(|e| {
            e.section.eq_ignore_ascii_case(section) && e.name.eq_ignore_ascii_case(key)
        });
        found.next()?.value.trim().parse().ok()
    }

    fn hal(&self, name: &str) -> Option<f64> {
        self.hal.get(&name.to_ascii_lowercase()).copied()
    }

    fn user_code(&self, code: u16) -> bool {
        let name = format!("M{code}");
        let runs = |folder: &std::path::PathBuf| {
            let file = std::fs::metadata(folder.join(&name));
            file.is_ok_and(|m| m.is_file() && m.permissions().mode() & 0o111 != 0)
        };
        self.machine.codes.iter().any(runs)
    }
}
