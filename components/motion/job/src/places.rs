//! The folders of a machine's programs, and those in which others than the machine's owner write: uploads and output.

use crate::number::wrong;
use hal_beneath::{Beneath, FileName, OpenError, is_below};
use hal_ini::{Entry, Ini, beside};
use std::path::{Path, PathBuf};

/// Folder of programs where the INI file names none.
const PROGRAMS: &str = "nc_files";
/// Folder of uploads in the folder of programs.
const UPLOADS: &str = "uploads";
/// Folder of the files that programs write, beside the INI file.
const OUTPUT: &str = "output";

/// Folders of programs that are offered where that of the INI file is not there: LinuxCNC's, and the one beside the INI file.
const OFFERED: [&str; 2] = ["~/linuxcnc/nc_files", PROGRAMS];

/// Entries whose files and folders hold code of the machine.
const CODE: &[(&str, &str)] = &[
    ("DISPLAY", "PROGRAM_PREFIX"),
    ("RS274NGC", "SUBROUTINE_PATH"),
    ("RS274NGC", "USER_M_PATH"),
    ("PYTHON", "TOPLEVEL"),
    ("PYTHON", "PATH_APPEND"),
    ("PYTHON", "PATH_PREPEND"),
];

/// The folders of a machine's programs.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Places {
    /// Folder of programs, which the machine's owner writes.
    pub programs: PathBuf,
    /// Folder of programs that were sent: its files are programs and nothing else.
    pub uploads: PathBuf,
    /// Folder of the files that programs write.
    pub output: Output,
}

/// The folder of the files that programs write.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Output {
    folder: PathBuf,
    /// The INI file's folder, if the folder is the one beside it.
    beside: Option<PathBuf>,
}

/// A folder of programs that the INI file names and that is not there, such as one of another computer.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct NoPrograms<'a> {
    /// Entry that names the folder.
    pub entry: &'a Entry,
    /// Path of the folder.
    pub path: PathBuf,
    /// Value for the entry whose folder is there.
    pub offered: Option<&'static str>,
}

impl<'a> NoPrograms<'a> {
    /// Returns the folder of programs that an INI file in a folder names, if it is not there.
    #[must_use]
    pub fn of(ini: &'a Ini, folder: &Path) -> Option<Self> {
        let entry = ini.all("DISPLAY", "PROGRAM_PREFIX").next()?;
        let path = beside(folder, &entry.value);
        let is_there = |name: &str| beside(folder, name).is_dir();
        if entry.value.trim().is_empty() || path.is_dir() {
            return None;
        }
        Some(Self { entry, path, offered: OFFERED.into_iter().find(|name| is_there(name)) })
    }

    /// Returns what would be right.
    #[must_use]
    pub fn remedy(&self) -> String {
        let make = format!("make the folder {}", self.path.display());
        match self.offered {
            Some(name) => format!("write PROGRAM_PREFIX = {name}, which is there, or {make}"),
            None => format!(
                "{make}, or write PROGRAM_PREFIX = {PROGRAMS} for one beside the INI file, and make that"
            ),
        }
    }
}

impl Places {
    /// Returns the places of an INI file in a folder.
    ///
    /// # Errors
    /// A folder in which others write holds, or is, code of the machine.
    pub fn read(ini: &Ini, folder: &Path) -> Result<Self, String> {
        let prefix = ini.get("DISPLAY", "PROGRAM_PREFIX").unwrap_or(PROGRAMS);
        let programs = beside(folder, prefix);
        let uploads = Self::uploads_of(&programs);
        let named = ini.all("RS274NGC", "OUTPUT_DIR").next();
        let named = named.filter(|entry| !entry.value.trim().is_empty());
        let output = match named {
            Some(entry) => Output { folder: beside(folder, &entry.value), beside: None },
            None => Output { folder: folder.join(OUTPUT), beside: Some(folder.to_owned()) },
        };
        let out = Self { programs, uploads, output };
        if let Some(entry) = named {
            out.check_output(entry, ini, folder)?;
        }
        check_code(ini, folder, &out.open_to_others())?;
        Ok(out)
    }

    /// Returns the folders in which something is looked for: that of programs, and those of an entry.
    pub(crate) fn searched(&self, ini: &Ini, entry: &str, folder: &Path) -> Vec<PathBuf> {
        let named = ini.get("RS274NGC", entry).map(|value| value.split(':'));
        let named = named.into_iter().flatten().map(|name| beside(folder, name));
        core::iter::once(self.programs.clone()).chain(named).collect()
    }

    /// Returns the folder of uploads of a folder of programs.
    #[must_use]
    pub fn uploads_of(programs: &Path) -> PathBuf {
        programs.join(UPLOADS)
    }

    /// Refuses a folder of uploads in which the machine looks for code.
    ///
    /// # Errors
    /// An entry of the INI file in a folder names such code.
    pub fn check_uploads(ini: &Ini, folder: &Path, uploads: &Path) -> Result<(), String> {
        check_code(ini, folder, &[uploads])
    }

    /// Returns the folders in which others than the machine's owner write.
    #[must_use]
    pub fn open_to_others(&self) -> [&Path; 2] {
        [&self.uploads, &self.output.folder]
    }

    /// Returns whether a file lies in a folder in which others than the machine's owner write.
    #[must_use]
    pub fn is_open_to_others(&self, path: &Path) -> bool {
        self.open_to_others().iter().any(|folder| is_below(path, folder))
    }

    /// Refuses an output folder in which the machine has files of its own.
    fn check_output(&self, entry: &Entry, ini: &Ini, folder: &Path) -> Result<(), String> {
        let output = &self.output.folder;
        let own = [folder.to_owned(), self.uploads.clone()];
        let held = own.into_iter().chain(code(ini, folder).map(|(_, path)| path));
        match held.into_iter().find(|path| is_below(path, output)) {
            None if !is_below(output, &self.uploads) => Ok(()),
            None => Err(wrong(entry, "a folder outside that of uploads")),
            Some(path) => {
                let wanted = format!(
                    "a folder for output alone, such as {OUTPUT}: {} is in it, which programs could then replace",
                    path.display()
                );
                Err(wrong(entry, &wanted))
            }
        }
    }
}

/// Refuses code of the machine in folders in which others write.
fn check_code(ini: &Ini, folder: &Path, open: &[&Path]) -> Result<(), String> {
    for (entry, path) in code(ini, folder) {
        let Some(open) = open.iter().find(|open| is_below(&path, open)) else { continue };
        let wanted = format!(
            "outside {}, where programs and uploads are written and no code is looked for",
            open.display()
        );
        return Err(wrong(entry, &wanted));
    }
    Ok(())
}

/// Returns the files and folders with code that the INI file names.
fn code<'a>(ini: &'a Ini, folder: &'a Path) -> impl Iterator<Item = (&'a Entry, PathBuf)> {
    CODE.iter().flat_map(move |(section, name)| {
        ini.all(section, name).flat_map(move |entry| {
            let parts = entry.value.split(':').map(str::trim).filter(|part| !part.is_empty());
            parts.map(move |part| (entry, beside(folder, part)))
        })
    })
}

impl Output {
    /// Returns the path of the folder.
    #[must_use]
    pub fn path(&self) -> &Path {
        &self.folder
    }

    /// Opens the folder, which is made at its first use.
    ///
    /// # Errors
    /// A link or another file is there, or the system refuses.
    pub fn open(&self, make: bool) -> Result<Beneath, OpenError> {
        if let Some(beside) = &self.beside
            && let Ok(name) = FileName::parse(OUTPUT)
        {
            // The folder of a file in the working folder has no name.
            let beside = if beside.as_os_str().is_empty() { Path::new(".") } else { beside };
            return Beneath::open(beside)?.inside(&name, make);
        }
        if make {
            // What could not be made cannot be opened.
            std::fs::create_dir_all(&self.folder).unwrap_or_default();
        }
        Beneath::open(&self.folder)
    }
}

#[cfg(test)]
mod tests {
    //! Folders that are code and output at once.

    use super::Places;
    use hal_ini::Ini;
    use std::fs;

    #[test]
    fn code_and_what_others_write_are_apart() {
        let folder = std::env::temp_dir().join(format!("hal-job-places-{}", std::process::id()));
        fs::create_dir_all(folder.join("nc_files/uploads")).unwrap();
        std::os::unix::fs::symlink("nc_files/uploads", folder.join("link")).unwrap();
        let read = |text: &str| {
            fs::write(folder.join("m.ini"), text).unwrap();
            Places::read(&Ini::read(&folder.join("m.ini")).unwrap(), &folder)
        };
        for (text, line, why) in [
            ("[RS274NGC]\nUSER_M_PATH = nc_files/uploads", 2, "no code is looked for"),
            ("[RS274NGC]\nUSER_M_PATH = a:nc_files/uploads/b", 2, "no code is looked for"),
            ("[RS274NGC]\nSUBROUTINE_PATH = subs:link", 2, "no code is looked for"),
            ("[RS274NGC]\nSUBROUTINE_PATH = subs/../output/x", 2, "no code is looked for"),
            ("[PYTHON]\nTOPLEVEL = output/top.py", 2, "no code is looked for"),
            ("[RS274NGC]\nOUTPUT_DIR = .", 2, "a folder for output alone"),
            ("[RS274NGC]\nOUTPUT_DIR = /", 2, "a folder for output alone"),
            ("[RS274NGC]\nOUTPUT_DIR = nc_files/..", 2, "a folder for output alone"),
            ("[RS274NGC]\nOUTPUT_DIR = a\nUSER_M_PATH = a/b", 2, "a folder for output alone"),
            ("[RS274NGC]\nOUTPUT_DIR = nc_files", 2, "a folder for output alone"),
            ("[RS274NGC]\nOUTPUT_DIR = link/logs", 2, "outside that of uploads"),
        ] {
            let said = read(text).unwrap_err();
            let at = format!("m.ini:{line}: ");
            assert!(said.contains(&at) && said.contains(why), "{text}: {said}");
        }
        let good = read("[RS274NGC]\nOUTPUT_DIR = logs/a\nSUBROUTINE_PATH = subs").unwrap();
        assert_eq!(good.output.path(), folder.join("logs/a"));
        assert!(good.output.open(false).is_err() && good.output.open(true).is_ok());
        assert!(good.is_open_to_others(&folder.join("link/M101")));
        assert!(!good.is_open_to_others(&folder.join("nc_files/M101")));
        let usual = read("[EMC]\n").unwrap();
        assert_eq!(usual.uploads, folder.join("nc_files/uploads"));
        assert!(usual.output.open(true).unwrap().path().ends_with("output"));
        // A link in the place of the folder leads elsewhere.
        fs::remove_dir(folder.join("output")).unwrap();
        std::os::unix::fs::symlink("nc_files", folder.join("output")).unwrap();
        assert!(usual.output.open(true).unwrap_err().to_string().contains("symbolic link"));
        fs::remove_dir_all(&folder).unwrap();
    }
}
