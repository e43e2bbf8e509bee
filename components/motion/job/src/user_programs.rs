//! Programs of users: M100 to M199.

use crate::places::Places;
use hal_beneath::{Beneath, FileName, check_guarded};
use std::path::{Path, PathBuf};

/// The folders of the programs M100 to M199.
#[derive(Clone, Debug, Default)]
pub struct UserPrograms {
    folders: Vec<PathBuf>,
    places: Option<Places>,
}

impl UserPrograms {
    /// Returns those of folders, in the order of the search. Nothing is run where others than the owner write.
    #[must_use]
    pub const fn new(folders: Vec<PathBuf>, places: Option<Places>) -> Self {
        Self { folders, places }
    }

    /// Finds the program of a code; `None` if there is none.
    ///
    /// # Errors
    /// The program is not run, with the reason: it is a link, others than the machine's owner could have written it, or it
    /// lies in a folder in which they do.
    pub fn find(&self, code: u16) -> Result<Option<PathBuf>, Box<str>> {
        let Ok(name) = FileName::parse(&format!("M{code}")) else { return Ok(None) };
        for folder in &self.folders {
            // The folder of a file in the working folder has no name.
            let folder = if folder.as_os_str().is_empty() { Path::new(".") } else { folder };
            let Ok(opened) = Beneath::open(folder) else { continue };
            if !check_guarded(&opened, &name).map_err(|why| why.to_string())? {
                continue;
            }
            let path = folder.join(name.as_str());
            if self.places.as_ref().is_some_and(|places| places.is_open_to_others(folder)) {
                return Err(format!(
                    "{}: in a folder of uploads or output, must be in one that only the machine's owner writes",
                    path.display()
                )
                .into());
            }
            return Ok(Some(std::path::absolute(&path).unwrap_or(path)));
        }
        Ok(None)
    }
}

#[cfg(test)]
mod tests {
    //! Programs that somebody else could have written.

    use super::{Places, UserPrograms};
    use hal_ini::Ini;
    use std::{
        fs,
        os::unix::fs::{PermissionsExt as _, symlink},
        path::Path,
    };

    fn mode(path: &Path, mode: u32) {
        fs::set_permissions(path, fs::Permissions::from_mode(mode)).unwrap();
    }

    #[test]
    fn a_program_is_run_only_if_nobody_else_could_write_it() {
        let folder = std::env::temp_dir().join(format!("hal-job-codes-{}", std::process::id()));
        let uploads = folder.join("nc_files/uploads");
        fs::create_dir_all(&uploads).unwrap();
        fs::create_dir_all(folder.join("open")).unwrap();
        fs::write(folder.join("m.ini"), "[EMC]\n").unwrap();
        let places = Places::read(&Ini::read(&folder.join("m.ini")).unwrap(), &folder).unwrap();
        let all =
            ["nc_files", "nc_files/uploads", "open", "above/codes"].map(|name| folder.join(name));
        let codes = UserPrograms::new(all.to_vec(), Some(places));
        let program = |name: &str, bits: u32| {
            fs::write(folder.join(name), "#!/bin/sh\n").unwrap();
            mode(&folder.join(name), bits);
        };
        program("nc_files/M101", 0o755);
        assert_eq!(codes.find(101).unwrap(), Some(folder.join("nc_files/M101")));
        program("nc_files/M102", 0o644);
        assert_eq!(codes.find(102), Ok(None), "no executable file");
        assert_eq!(codes.find(103), Ok(None));
        program("nc_files/M104", 0o757);
        program("nc_files/uploads/M105", 0o755);
        symlink("M101", folder.join("nc_files/M106")).unwrap();
        program("nc_files/M107", 0o755);
        fs::hard_link(folder.join("nc_files/M107"), folder.join("nc_files/uploads/a.ngc")).unwrap();
        program("open/M108", 0o755);
        mode(&folder.join("open"), 0o777);
        fs::create_dir_all(folder.join("above/codes")).unwrap();
        program("above/codes/M110", 0o755);
        mode(&folder.join("above"), 0o777);
        symlink(uploads.join("M105"), folder.join("nc_files/M109")).unwrap();
        for (code, why) in [
            (104, "M104: other users may write it (mode 0757)"),
            (105, "uploads/M105: in a folder of uploads"),
            (106, "M106: a symbolic link"),
            (107, "M107: the file has other names"),
            (108, "open: other users may write it (mode 0777)"),
            (109, "M109: a symbolic link"),
            (110, "above: other users may write it (mode 0777)"),
        ] {
            let said = codes.find(code).unwrap_err();
            assert!(said.contains(why), "{code}: {said}");
        }
        fs::remove_dir_all(&folder).unwrap();
    }
}
