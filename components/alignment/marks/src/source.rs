//! Origins of pictures: files in a folder.

use crate::picture::{MAX_BYTES, Picture, PictureProblem};
use core::fmt;
use std::{
    fs, io,
    path::{Path, PathBuf},
};

/// Origin of pictures.
pub trait Source: Send {
    /// Returns whether pictures come while they are taken.
    fn is_live(&self) -> bool;

    /// Forgets the pictures that are there already, if others come.
    fn skip(&mut self);

    /// Returns the next picture, if there is one yet.
    ///
    /// # Errors
    /// The picture cannot be read, or is none.
    fn take(&mut self) -> Result<Option<Picture>, SourceProblem>;

    /// Returns the file of the latest picture: of a folder that is filled the newest one, of another the one that was
    /// taken last, or the first.
    fn latest(&self) -> Option<PathBuf>;
}

/// Reason why a source has no picture.
#[derive(Debug)]
pub enum SourceProblem {
    /// A file or folder that cannot be read.
    File(PathBuf, io::Error),
    /// A file that is no picture.
    Picture(PathBuf, PictureProblem),
}

impl fmt::Display for SourceProblem {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::File(path, error) => {
                // The system's words without the number behind them.
                let text = error.to_string();
                let text = text.split(" (os error").next().unwrap_or_default();
                write!(f, "{}: {text}", path.display())
            }
            Self::Picture(path, problem) => write!(f, "{}: {problem}", path.display()),
        }
    }
}

/// Pictures of a folder, in the order of their names: files `.jpg`, `.jpeg` and `.png`.
#[derive(Debug)]
pub struct Files {
    folder: PathBuf,
    /// Name of the last picture that was taken or skipped.
    last: Option<PathBuf>,
    /// The folder is filled while it is read, so that older pictures say nothing.
    is_live: bool,
}

impl Files {
    /// Returns the pictures of a folder. With `is_live`, a look begins with pictures that are not there yet.
    ///
    /// # Errors
    /// The folder cannot be read.
    pub fn open(folder: &Path, is_live: bool) -> Result<Self, SourceProblem> {
        let out = Self { folder: folder.to_owned(), last: None, is_live };
        out.names()?;
        Ok(out)
    }

    fn names(&self) -> Result<Vec<PathBuf>, SourceProblem> {
        let problem = |e| SourceProblem::File(self.folder.clone(), e);
        let mut names = Vec::new();
        for entry in fs::read_dir(&self.folder).map_err(problem)? {
            let path = entry.map_err(problem)?.path();
            let ending = path.extension().and_then(|e| e.to_str()).map(str::to_ascii_lowercase);
            if matches!(ending.as_deref(), Some("jpg" | "jpeg" | "png")) {
                names.push(path);
            }
        }
        names.sort();
        Ok(names)
    }
}

impl Source for Files {
    fn is_live(&self) -> bool {
        self.is_live
    }

    fn skip(&mut self) {
        if self.is_live
            && let Ok(names) = self.names()
            && let Some(last) = names.last()
        {
            self.last = Some(last.clone());
        }
    }

    fn take(&mut self) -> Result<Option<Picture>, SourceProblem> {
        let names = self.names()?;
        let next = names.into_iter().find(|n| self.last.as_ref().is_none_or(|last| n > last));
        let Some(path) = next else { return Ok(None) };
        self.last = Some(path.clone());
        read_picture(&path).map(|(_, picture)| Some(picture))
    }

    fn latest(&self) -> Option<PathBuf> {
        let names = self.names().ok()?;
        let taken = self.last.clone().filter(|last| names.contains(last));
        if self.is_live { names.last().cloned() } else { taken.or_else(|| names.first().cloned()) }
    }
}

/// Reads a picture; returns its bytes too.
///
/// # Errors
/// The file cannot be read, or is no picture.
pub fn read_picture(path: &Path) -> Result<(Vec<u8>, Picture), SourceProblem> {
    let most = u64::try_from(MAX_BYTES).unwrap_or(u64::MAX);
    // A pipe would keep a worker until somebody writes.
    let bytes = hal_ini::file::contents(path, most)
        .map_err(|e| SourceProblem::File(path.to_owned(), e))?
        .ok_or_else(|| SourceProblem::Picture(path.to_owned(), PictureProblem::Large))?;
    let picture =
        Picture::decode(&bytes).map_err(|e| SourceProblem::Picture(path.to_owned(), e))?;
    Ok((bytes, picture))
}

#[cfg(test)]
mod tests {
    //! Names of pictures that are none.

    use super::{Files, Source as _};
    use std::{fs, os::unix::fs::symlink, process::Command};

    #[test]
    fn what_would_never_end_is_refused_by_name() {
        let folder = std::env::temp_dir().join(format!("marks-source-{}", std::process::id()));
        drop(fs::remove_dir_all(&folder));
        fs::create_dir_all(folder.join("c.jpeg")).unwrap();
        assert!(Command::new("mkfifo").arg(folder.join("a.jpg")).status().unwrap().success());
        symlink("/dev/zero", folder.join("b.png")).unwrap();
        let mut files = Files::open(&folder, false).unwrap();
        for why in [
            "a.jpg: it is a pipe, not a file",
            "b.png: it is a device, not a file",
            "c.jpeg: Is a directory",
        ] {
            let said = files.take().unwrap_err().to_string();
            assert_eq!(said, format!("{}/{why}", folder.display()));
        }
        assert!(files.take().unwrap().is_none());
        fs::remove_dir_all(folder).unwrap();
    }
}
