//! Entries of an INI file about functions in Python: its section `PYTHON`.

use hal_ini::{Ini, beside};
use serde::Serialize;
use std::{
    path::{Path, PathBuf},
    time::Duration,
};

/// Seconds that a function may take from one step to the next, if the INI file says nothing.
pub const TIMEOUT: f64 = 10.0;
/// Largest number of these seconds.
const MAX_TIMEOUT: f64 = 86_400.0;

/// Facts about the functions of a machine.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Setup {
    /// The folder of the INI file, in which the functions run.
    #[serde(skip)]
    pub folder: PathBuf,
    /// Folders of modules before and behind all others.
    pub prepend: Vec<PathBuf>,
    /// Folders behind all others.
    pub append: Vec<PathBuf>,
    /// The script that imports the modules `remap` and `oword`.
    pub toplevel: Option<PathBuf>,
    /// The machine moves: `self.task` is 1.
    pub task: u8,
    /// Longest time from one step of a function to the next.
    #[serde(skip)]
    pub timeout: Duration,
    /// The instance stands still while a function works: a function that asks it is refused at once.
    #[serde(skip)]
    pub stands_still: bool,
}

impl Setup {
    /// Reads the section; `None` if the INI file has none. Relative names are those of its folder.
    ///
    /// # Errors
    /// An entry has no meaning.
    pub fn read(ini: &Ini, folder: &Path) -> Result<Option<Self>, String> {
        let is_there = ini.entries().any(|e| e.section == "PYTHON");
        if !is_there {
            return Ok(None);
        }
        // The folder of a file in the working folder has no name.
        let named = if folder.as_os_str().is_empty() { Path::new(".") } else { folder };
        let folder = std::path::absolute(named).unwrap_or_else(|_| named.into());
        let paths = |name: &str| {
            let entries = ini.all("PYTHON", name).flat_map(|e| e.value.split(':'));
            entries.map(str::trim).filter(|p| !p.is_empty()).map(|p| beside(&folder, p)).collect()
        };
        let mut timeout = TIMEOUT;
        if let Some(entry) = ini.all("PYTHON", "TIMEOUT").next() {
            let seconds = entry.value.trim().parse::<f64>().ok();
            timeout = seconds.filter(|s| 0.0 < *s && *s <= MAX_TIMEOUT).ok_or_else(|| {
                format!(
                    "{}:{}: [PYTHON]TIMEOUT = {}: must be seconds above 0, at most {MAX_TIMEOUT}",
                    entry.file, entry.line, entry.value
                )
            })?;
        }
        let toplevel = ini.all("PYTHON", "TOPLEVEL").next();
        let toplevel = toplevel.map(|entry| {
            let path = beside(&folder, &entry.value);
            if path.is_file() {
                return Ok(path);
            }
            let (file, line) = (&entry.file, entry.line);
            Err(format!("{file}:{line}: [PYTHON]TOPLEVEL: there is no file {}", path.display()))
        });
        Ok(Some(Self {
            prepend: paths("PATH_PREPEND"),
            append: paths("PATH_APPEND"),
            toplevel: toplevel.transpose()?,
            task: 0,
            timeout: Duration::from_secs_f64(timeout),
            stands_still: false,
            folder,
        }))
    }
}
