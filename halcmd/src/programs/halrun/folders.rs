//! Folders in which the HAL files of a machine, and plugins, are searched.

use hal_ini::beside;
use std::path::{Path, PathBuf};

/// Folders that contain HAL files of a machine.
pub(crate) struct Folders {
    /// Folder of the INI file, as the user wrote it.
    pub(super) named: PathBuf,
    /// Absolute path of that folder.
    pub(super) here: PathBuf,
    /// Libraries of HAL files.
    pub(crate) libraries: Vec<PathBuf>,
}

impl Folders {
    pub(crate) fn of(ini: &Path) -> Self {
        let named = ini.parent().map(Path::to_path_buf).unwrap_or_default();
        let here = std::path::absolute(ini)
            .ok()
            .and_then(|p| p.parent().map(Path::to_path_buf))
            .unwrap_or_else(|| named.clone());
        let asked = std::env::var("HALLIB_PATH").unwrap_or_default();
        let whole = |f: &str| std::path::absolute(f).unwrap_or_else(|_| f.into());
        let mut libraries: Vec<PathBuf> =
            asked.split(':').filter(|f| !f.is_empty()).map(whole).collect();
        if let Some(bin) = std::env::current_exe().ok().as_deref().and_then(Path::parent) {
            libraries.push(bin.join("../share/ferrule/hallib"));
        }
        libraries.push(LINUXCNC_LIBRARY.into());
        Self { named, here, libraries }
    }

    /// Finds a file beside the INI file or else in the libraries; `LIB:name` is searched in the
    /// libraries only. Returns the name for messages, and the path.
    pub(crate) fn find(&self, name: &str) -> Option<(String, PathBuf)> {
        let (name, library) = name.strip_prefix("LIB:").map_or((name, false), |n| (n, true));
        let own = beside(&self.here, name);
        if !library && own.is_file() {
            return Some((beside(&self.named, name).display().to_string(), own));
        }
        let found = self.libraries.iter().map(|l| l.join(name)).find(|p| p.is_file())?;
        Some((found.display().to_string(), found))
    }

    /// Lists the folders in which a file is searched.
    pub(super) fn searched(&self, name: &str) -> String {
        let own = (!name.starts_with("LIB:")).then_some(&self.here);
        let all: Vec<String> =
            own.into_iter().chain(&self.libraries).map(|p| p.display().to_string()).collect();
        all.join(", ")
    }
}

/// Folder of the HAL files of LinuxCNC's package.
const LINUXCNC_LIBRARY: &str = "/usr/share/linuxcnc/hallib";

/// Environment variable that adds the folder of LinuxCNC's package to the search path.
pub(super) const LINUXCNC_MODULES: &str = "HAL_LINUXCNC_MODULES";

/// Folder of LinuxCNC's components.
pub(super) const LINUXCNC_FOLDER: &str = "/usr/lib/linuxcnc/modules";

/// Returns the search path of plugins: `HAL_RTMOD_DIR`, then beside the program, installed with it,
/// or just built; and LinuxCNC's components in C if requested.
pub(crate) fn plugin_path(environment: &dyn Fn(&str) -> Option<String>) -> Vec<PathBuf> {
    let asked = environment("HAL_RTMOD_DIR").unwrap_or_default();
    let mut path: Vec<PathBuf> = asked
        .split(':')
        .filter(|folder| !folder.is_empty())
        .map(|folder| std::path::absolute(folder).unwrap_or_else(|_| folder.into()))
        .collect();
    if let Some(here) = std::env::current_exe().ok().as_deref().and_then(Path::parent) {
        path.push(here.to_path_buf());
        path.push(here.join("../lib/ferrule"));
        path.push(here.join("deps"));
    }
    if environment(LINUXCNC_MODULES).is_some_and(|asked| !["", "0"].contains(&&*asked)) {
        path.push(LINUXCNC_FOLDER.into());
    }
    path
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn files_are_beside_the_ini_file_or_in_a_library() {
        let folder = std::env::temp_dir().join(format!("ferrule-find-{}", std::process::id()));
        let (own, library) = (folder.join("own"), folder.join("lib"));
        for f in [&own, &library] {
            std::fs::create_dir_all(f).unwrap();
        }
        for f in
            [own.join("a.hal"), own.join("b.hal"), library.join("b.hal"), library.join("c.hal")]
        {
            std::fs::write(f, "").unwrap();
        }
        let folders =
            Folders { named: "x".into(), here: own.clone(), libraries: vec![library.clone()] };
        let found: Vec<_> = ["a.hal", "b.hal", "LIB:b.hal", "LIB:a.hal", "c.hal", "d.hal"]
            .map(|n| folders.find(n))
            .into();
        std::fs::remove_dir_all(&folder).unwrap();
        let at = |f: &Path, n: &str| Some((f.join(n).display().to_string(), f.join(n)));
        let want = [
            Some(("x/a.hal".to_owned(), own.join("a.hal"))),
            Some(("x/b.hal".to_owned(), own.join("b.hal"))),
            at(&library, "b.hal"),
            None,
            at(&library, "c.hal"),
            None,
        ];
        assert_eq!(found, want);
    }
}
