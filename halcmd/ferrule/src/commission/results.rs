//! The results of steps, in a file beside the INI file: a line each, with the date.

use crate::failure::Failure;
use hal_output::checksum::Checksum;
use std::{
    fs,
    path::{Path, PathBuf},
    time::SystemTime,
};
use time::OffsetDateTime;

/// Results so far.
pub(crate) struct Results {
    path: PathBuf,
    machine: PathBuf,
    /// Lines `DATE STEP RESULT MACHINE what was found`.
    lines: Vec<String>,
}

impl Results {
    /// Reads the results of a machine; none if they are to be forgotten.
    pub(crate) fn read(machine: &Path, forget: bool) -> Result<Self, Failure> {
        let path = machine.with_extension("commission");
        let text = match fs::read_to_string(&path) {
            Ok(text) => text,
            Err(e) if e.kind() == std::io::ErrorKind::NotFound => String::new(),
            Err(e) => return Err(Failure::file(&path, &e)),
        };
        let mut lines: Vec<String> = text.lines().map(str::to_owned).collect();
        if forget {
            lines.clear();
        }
        let wrong = lines.iter().position(|line| line.split(' ').count() < 4);
        match wrong {
            Some(n) => Err(Failure::Results { path, line: n + 1 }),
            None => Ok(Self { path, machine: machine.to_owned(), lines }),
        }
    }

    pub(crate) fn path(&self) -> &Path {
        &self.path
    }

    /// Returns the date at which a step has passed, if nothing has changed in the machine's files since, but for what the
    /// steps themselves have changed.
    pub(crate) fn passed(&self, step: &str) -> Option<String> {
        let files = fingerprint(&self.machine);
        let last = self.lines.last()?.split(' ').nth(3)?;
        if last != files {
            return None;
        }
        let of_step = self.lines.iter().rev().find(|line| line.split(' ').nth(1) == Some(step))?;
        let mut words = of_step.split(' ');
        let (date, result) = (words.next()?, words.nth(1)?);
        (result == "passed").then(|| date.to_owned())
    }

    /// Adds a result, and writes the file.
    pub(crate) fn add(&mut self, step: &str, result: &str, text: &str) -> Result<(), Failure> {
        let files = fingerprint(&self.machine);
        // A machine that was changed by hand is commissioned from the first step.
        if result != "changed"
            && self.lines.last().is_some_and(|l| l.split(' ').nth(3) != Some(&files))
        {
            self.lines.retain(|line| line.split(' ').nth(3) == Some(&files));
        }
        if result == "changed" {
            // What has passed before stays so: the change is its own.
            let before = self.lines.last().and_then(|l| l.split(' ').nth(3)).map(str::to_owned);
            for line in &mut self.lines {
                let mut words: Vec<&str> = line.split(' ').collect();
                if let Some(word) = words.get_mut(3).filter(|w| Some(**w) == before.as_deref()) {
                    *word = &files;
                }
                *line = words.join(" ");
            }
        }
        let text = text.replace(['\n', '\r'], " ");
        self.lines.push(format!("{} {step} {result} {files} {text}", date(SystemTime::now())));
        let whole: String = self.lines.iter().map(|line| format!("{line}\n")).collect();
        hal_output::write(&self.path, whole.as_bytes()).map_err(|e| Failure::file(&self.path, &e))
    }
}

/// Returns a figure of the INI file and of the HAL files beside it, which is another one when they change.
fn fingerprint(machine: &Path) -> String {
    let folder = machine.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let entries = fs::read_dir(folder).into_iter().flatten().flatten().map(|entry| entry.path());
    let is_part =
        |path: &PathBuf| path.extension().is_some_and(|e| e == "hal" || e == "tcl" || e == "inc");
    let mut files: Vec<PathBuf> = entries.filter(is_part).collect();
    files.sort();
    files.push(machine.to_owned());
    let mut sum = Checksum::default();
    for file in files {
        let bytes = hal_ini::file::whole(&file).unwrap_or_default();
        // Text that goes from one file to another is a change.
        sum.add(&bytes.len().to_le_bytes());
        sum.add(&bytes);
    }
    format!("{:016x}", sum.value())
}

/// Returns a date and time in UTC, as `2026-03-01T12:00:00Z`.
fn date(at: SystemTime) -> String {
    let at = OffsetDateTime::from(at);
    let (date, hour, minute, second) = (at.date(), at.hour(), at.minute(), at.second());
    format!("{date}T{hour:02}:{minute:02}:{second:02}Z")
}

#[cfg(test)]
mod tests {
    use super::{Results, date};
    use std::{
        fs,
        time::{Duration, UNIX_EPOCH},
    };

    #[test]
    fn dates_are_those_of_the_calendar() {
        let at = |seconds| date(UNIX_EPOCH + Duration::from_secs(seconds));
        assert_eq!(at(951_782_400), "2000-02-29T00:00:00Z");
        assert_eq!(at(1_735_689_599), "2024-12-31T23:59:59Z");
    }

    #[test]
    fn results_hold_for_the_files_that_they_were_found_with() {
        let folder = std::env::temp_dir().join(format!("ferrule-results-{}", std::process::id()));
        fs::create_dir_all(&folder).unwrap();
        let ini = folder.join("m.ini");
        fs::write(&ini, "[EMC]\n").unwrap();
        let mut results = Results::read(&ini, false).unwrap();
        results.add("estop", "passed", "pressed\nand seen").unwrap();
        let again = Results::read(&ini, false).unwrap();
        assert!(again.passed("estop").is_some() && again.passed("switches").is_none());
        // A change of a step itself keeps what has passed; one by hand does not.
        fs::write(&ini, "[EMC]\nX = 1\n").unwrap();
        let mut results = Results::read(&ini, false).unwrap();
        assert!(results.passed("estop").is_none());
        results.add("scale", "changed", "X").unwrap();
        assert!(Results::read(&ini, false).unwrap().passed("estop").is_some());
        fs::write(folder.join("m.hal"), "# another wire\n").unwrap();
        assert!(Results::read(&ini, false).unwrap().passed("estop").is_none());
        assert!(Results::read(&ini, true).unwrap().passed("estop").is_none());
        fs::remove_dir_all(folder).unwrap();
    }
}
