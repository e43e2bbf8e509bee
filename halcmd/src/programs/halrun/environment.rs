//! Environment variables that the programs of a machine look for.

use crate::ini::Ini;
use std::{ffi::OsString, path::Path};

/// Variables with the folders of LinuxCNC's package. Its user interfaces read them.
const PACKAGE: &[(&str, &str)] = &[
    ("LINUXCNC_HOME", "/usr"),
    ("LINUXCNC_TCL_DIR", "/usr/lib/tcltk/linuxcnc"),
    ("LINUXCNC_LANG_DIR", "/usr/lib/tcltk/linuxcnc/msgs"),
    ("LINUXCNC_HELP_DIR", "/usr/share/doc/linuxcnc"),
    ("LINUXCNC_NCFILES_DIR", "/usr/share/linuxcnc/ncfiles"),
];

/// Variables with entries of the INI file.
const ENTRIES: &[(&str, &str, &str)] =
    &[("TRAJ_COORDINATES", "TRAJ", "COORDINATES"), ("KINS_KINEMATICS", "KINS", "KINEMATICS")];

/// Variables with a fixed value: the version whose language and modules are offered, the program for HAL commands, the
/// interpreter of Tcl with windows, and the window system of OpenGL in Python.
const FIXED: &[(&str, &str)] = &[
    ("LINUXCNCVERSION", "2.9"),
    ("HALCMD", "halcmd"),
    ("LINUXCNC_EMCSH", "wish"),
    ("PYOPENGL_PLATFORM", "x11"),
];

/// Returns the variables of a machine: its INI file and folder, a path with Ferrule's own programs first, and what
/// LinuxCNC's start script sets, where the user has not set it.
pub(super) fn variables(ini: &Ini, path: &Path, folder: &Path) -> Vec<(&'static str, OsString)> {
    of_machine(ini, path, folder, |name| std::env::var_os(name).is_some())
}

fn of_machine(
    ini: &Ini,
    path: &Path,
    folder: &Path,
    is_set: impl Fn(&str) -> bool,
) -> Vec<(&'static str, OsString)> {
    let whole = std::path::absolute(path).unwrap_or_else(|_| path.to_path_buf());
    let mut all = vec![("INI_FILE_NAME", whole.into()), ("CONFIG_DIR", folder.into())];
    let here = std::env::current_exe().ok().and_then(|p| p.parent().map(Path::to_path_buf));
    let before = std::env::var_os("PATH").unwrap_or_default();
    let paths = here.into_iter().chain(std::env::split_paths(&before));
    all.extend(std::env::join_paths(paths).ok().map(|path| ("PATH", path)));
    for (name, section, entry) in ENTRIES {
        all.push((name, ini.get(section, entry).unwrap_or_default().into()));
    }
    let folders = PACKAGE.iter().filter(|(_, folder)| Path::new(folder).is_dir());
    let free = folders.chain(FIXED).filter(|(name, _)| !is_set(name));
    all.extend(free.map(|(name, value)| (*name, OsString::from(value))));
    all
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn programs_find_the_machine_and_its_axes() {
        let text = b"[TRAJ]\nCOORDINATES = X Z\n[KINS]\nKINEMATICS = trivkins\n";
        let ini = Ini::parse("m.ini", text).unwrap();
        let file = Path::new("/a/m.ini");
        let all = of_machine(&ini, file, Path::new("/a"), |_| false);
        let value = |wanted| all.iter().find(|(name, _)| *name == wanted).unwrap().1.clone();
        assert_eq!(value("INI_FILE_NAME"), "/a/m.ini");
        assert_eq!(value("CONFIG_DIR"), "/a");
        assert_eq!(value("TRAJ_COORDINATES"), "X Z");
        assert_eq!(value("KINS_KINEMATICS"), "trivkins");
        let page = include_str!("../../../README.md");
        for (name, fixed) in FIXED {
            assert_eq!(value(name), *fixed);
        }
        for (name, folder) in PACKAGE {
            let has = all.iter().any(|(other, value)| other == name && value == folder);
            assert_eq!(has, Path::new(folder).is_dir(), "{name}");
        }
        for (name, _) in &all {
            assert!(page.contains(&format!("`{name}`")), "the README does not name {name}");
        }
        // What the user has set stays.
        let all = of_machine(&ini, file, Path::new("/a"), |_| true);
        assert!(FIXED.iter().chain(PACKAGE).all(|(name, _)| all.iter().all(|(n, _)| n != name)));
    }
}
