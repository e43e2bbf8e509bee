//! The folders of programs, uploads and output, and the files in them that the name in a request means.

use crate::{
    error::{Code, Error},
    options::Options,
};
use hal_beneath::{Beneath, FileName, Found, NewFile, OpenError, RelativeName};
use hal_ini::Ini;
use hal_job::places::{NoPrograms, Output, Places};
use std::{
    fs::File,
    io::{self, ErrorKind, Read as _},
    path::{Path, PathBuf},
};

/// Begin of the names of uploads.
const UPLOADS: &str = "uploads/";
/// Longest name of a program in bytes.
const MAX_NAME: usize = 200;
/// Number of files that are listed.
const MAX_LISTED: usize = 10_000;
/// Endings that an upload may have: those of programs, and of nothing that a machine runs or reads by itself.
const ENDINGS: &[&str] = &[
    "ngc",
    "nc",
    "gcode",
    "gco",
    "g",
    "tap",
    "cnc",
    "anc",
    "eia",
    "iso",
    "din",
    "mpf",
    "txt",
    "apt",
    "cl",
    "cls",
    "aptsource",
];

/// The folders, as far as the machine has them.
#[derive(Clone, Debug, Default)]
pub(crate) struct Folders {
    programs: Option<PathBuf>,
    /// Remedy for a folder that was not there at the start.
    absent: Option<Box<str>>,
    output: Option<Output>,
}

/// A program: of the machine's owner, or one that was sent.
#[derive(Clone, Debug)]
pub(crate) struct ProgramFile {
    programs: PathBuf,
    file: FileName,
    is_upload: bool,
}

impl Folders {
    /// Returns those of the options and the INI file.
    pub(crate) fn find(options: &Options, ini: Option<&Ini>) -> Result<Self, String> {
        let whole = |path: &Path| std::path::absolute(path).map_err(|e| hal_output::reason(&e));
        let folder = options.ini_file.as_deref().map(whole).transpose()?;
        let folder = folder.as_deref().and_then(Path::parent);
        let machine = match ini.zip(folder) {
            Some((ini, folder)) => Some(Places::read(ini, folder)?),
            None => None,
        };
        let is_named = ini.is_some_and(|ini| ini.get("DISPLAY", "PROGRAM_PREFIX").is_some());
        let named = machine.as_ref().filter(|_| is_named).map(|places| places.programs.clone());
        let absent = ini.zip(folder).filter(|_| options.programs.is_none());
        let absent = absent.and_then(|(ini, folder)| NoPrograms::of(ini, folder));
        let absent = absent.map(|absent| absent.remedy().into());
        // The engine's folder is another.
        let programs = options.programs.as_deref().map(whole).transpose()?.or(named);
        if let Some(programs) = &programs {
            let is_uploads = programs.file_name().is_some_and(|name| name == "uploads");
            if is_uploads {
                return Err(format!(
                    "{}: the folder of programs cannot have the name of the one for uploads in it",
                    programs.display()
                ));
            }
            if let Some((ini, folder)) = ini.zip(folder) {
                Places::check_uploads(ini, folder, &Places::uploads_of(programs))?;
            }
        }
        Ok(Self { programs, absent, output: machine.map(|places| places.output) })
    }

    /// Returns whether a file lies in a folder in which others than the machine's owner write.
    pub(crate) fn is_open_to_others(&self, path: &Path) -> bool {
        let uploads = self.programs.as_deref().map(Places::uploads_of);
        let output = self.output.as_ref().map(|output| output.path().to_owned());
        uploads.into_iter().chain(output).any(|folder| hal_beneath::is_below(path, &folder))
    }

    /// Returns the program that a name means: `uploads/NAME` one that was sent, `NAME` one of the machine, or, where it
    /// has none of that name, one that was sent.
    pub(crate) fn program(&self, name: &str) -> Result<ProgramFile, Error> {
        let (programs, plain) = (self.needed()?, name.strip_prefix(UPLOADS));
        let file = program_name(plain.unwrap_or(name), name)?;
        let is_upload = plain.is_some() || programs.join(file.as_str()).symlink_metadata().is_err();
        Ok(ProgramFile { programs: programs.to_owned(), file, is_upload })
    }

    /// Returns the program that a name means which is stored or removed: one that was sent, with a name of a program.
    pub(crate) fn upload(&self, name: &str) -> Result<ProgramFile, Error> {
        let (programs, plain) = (self.needed()?, name.strip_prefix(UPLOADS));
        let file = program_name(plain.unwrap_or(name), name)?;
        let ending = file.as_str().rsplit_once('.').map_or("", |(_, ending)| ending);
        if !ENDINGS.iter().any(|known| known.eq_ignore_ascii_case(ending)) {
            let known = ENDINGS.join(" .");
            let text =
                format!("'{name}' is no name of a program: it must end with one of .{known}");
            return Err(Error::new(Code::Malformed, text));
        }
        let is_own = plain.is_none() && programs.join(file.as_str()).symlink_metadata().is_ok();
        if is_own {
            let text = format!(
                "'{name}' is a program of the machine, which stays as it is: an upload is {UPLOADS}{name}"
            );
            return Err(Error::new(Code::Conflict, text));
        }
        Ok(ProgramFile { programs: programs.to_owned(), file, is_upload: true })
    }

    /// Lists the programs of the machine, and behind them those that were sent.
    pub(crate) fn programs(&self) -> Result<Vec<Found>, Error> {
        let Some(programs) = &self.programs else { return Ok(Vec::new()) };
        let programs = Beneath::open(programs).map_err(|e| match &self.absent {
            Some(remedy) if e.is_missing() => {
                let path = programs.display();
                let text = format!(
                    "{path}, the folder of programs ([DISPLAY]PROGRAM_PREFIX), is not there: {remedy}"
                );
                Error::new(Code::NotFound, text)
            }
            _ => refused(e),
        })?;
        let mut list = programs.list(0, MAX_LISTED).map_err(refused)?;
        if let Ok(name) = FileName::parse("uploads")
            && let Ok(uploads) = programs.inside(&name, false)
        {
            let sent = uploads.list(0, MAX_LISTED).map_err(refused)?.into_iter();
            list.extend(
                sent.map(|found| Found {
                    name: format!("{UPLOADS}{}", found.name).into(),
                    ..found
                }),
            );
        }
        list.retain(|found| self.program(&found.name).is_ok());
        Ok(list)
    }

    /// Lists the files that programs have written.
    pub(crate) fn written(&self) -> Result<Vec<Found>, Error> {
        let Some(output) = &self.output else { return Ok(Vec::new()) };
        match output.open(false) {
            // The folder is made at its first use.
            Err(e) if e.is_missing() => Ok(Vec::new()),
            opened => opened
                .and_then(|folder| folder.list(hal_beneath::MAX_DEPTH - 1, MAX_LISTED))
                .map_err(refused),
        }
    }

    /// Opens a file that a program has written.
    pub(crate) fn written_file(&self, name: &str) -> Result<File, Error> {
        let none = || Error::new(Code::NotFound, "there is no INI file, and so no output folder");
        let output = self.output.as_ref().ok_or_else(none)?;
        let file = RelativeName::parse(name)
            .map_err(|why| Error::new(Code::Malformed, format!("'{name}': {why}")))?;
        output.open(false).and_then(|folder| folder.read_sole(&file)).map_err(refused)
    }

    fn needed(&self) -> Result<&Path, Error> {
        self.programs.as_deref().ok_or_else(|| {
            let text = "there is no folder for programs: [DISPLAY]PROGRAM_PREFIX, or --programs";
            Error::new(Code::NotFound, text)
        })
    }
}

impl ProgramFile {
    /// Returns the name, as requests have it.
    pub(crate) fn name(&self) -> String {
        let before = if self.is_upload { UPLOADS } else { "" };
        format!("{before}{}", self.file.as_str())
    }

    /// Returns the name without a folder.
    pub(crate) fn plain(&self) -> &str {
        self.file.as_str()
    }

    /// Returns the path.
    pub(crate) fn path(&self) -> PathBuf {
        self.folder().join(self.file.as_str())
    }

    /// Opens the program to read it.
    pub(crate) fn open(&self) -> Result<File, Error> {
        let folder = Beneath::open(&self.folder());
        let name = self.file.clone().into();
        let opened = match self.is_upload {
            true => folder.and_then(|folder| folder.read_sole(&name)),
            false => folder.and_then(|folder| folder.read(&name)),
        };
        opened.map_err(|e| match e.is_missing() {
            true => Error::new(Code::NotFound, format!("there is no program '{}'", self.name())),
            false => refused(e),
        })
    }

    /// Begins to write an upload.
    pub(crate) fn create(&self) -> Result<NewFile, Error> {
        let uploads = FileName::parse("uploads").map_err(|_| Code::Malformed);
        let uploads = uploads.map_err(|code| Error::new(code, "uploads"))?;
        let folder =
            Beneath::open(&self.programs).and_then(|programs| programs.inside(&uploads, true));
        folder.and_then(|folder| folder.replace(&self.file)).map_err(refused)
    }

    /// Removes an upload.
    pub(crate) fn remove(&self) -> Result<(), Error> {
        let folder = Beneath::open(&self.folder());
        folder.and_then(|folder| folder.remove(&self.file)).map_err(|e| match e.is_missing() {
            true => Error::new(Code::NotFound, format!("there is no program '{}'", self.name())),
            false => refused(e),
        })
    }

    fn folder(&self) -> PathBuf {
        match self.is_upload {
            true => Places::uploads_of(&self.programs),
            false => self.programs.clone(),
        }
    }
}

/// Checks the name of a program; `whole` is the one of the request.
fn program_name(name: &str, whole: &str) -> Result<FileName, Error> {
    let usual = |c: char| c.is_alphanumeric() || "._- ".contains(c);
    let wrong = |why: &str| {
        let text = format!(
            "'{}' is no name of a program: letters, digits, '.', '_', '-', blanks{why}",
            whole.escape_debug()
        );
        Error::new(Code::Malformed, text)
    };
    if name.len() > MAX_NAME || !name.chars().all(usual) {
        return Err(wrong(""));
    }
    FileName::parse(name).map_err(|why| wrong(&format!("; {why}")))
}

/// Returns the refusal of a file.
pub(crate) fn refused(error: OpenError) -> Error {
    let code = match &error {
        OpenError::Missing { .. } => Code::NotFound,
        OpenError::Name { .. } => Code::Malformed,
        OpenError::System { .. } => Code::Disk,
        _ => Code::Conflict,
    };
    Error::new(code, error.to_string())
}

/// Reads a file of at most this many bytes.
pub(crate) fn whole(file: File, most: u64) -> io::Result<Vec<u8>> {
    let mut bytes = Vec::new();
    // One byte more tells that the file is longer, also where it grows meanwhile.
    let read = file.take(most.saturating_add(1)).read_to_end(&mut bytes)?;
    if read as u64 > most { Err(ErrorKind::FileTooLarge.into()) } else { Ok(bytes) }
}

#[cfg(test)]
mod tests;
