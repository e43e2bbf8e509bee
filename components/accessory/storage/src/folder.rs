//! Images, state file and waiting jobs in a folder.

use crate::bay::{Bay, Side};
use std::{
    fs::{self, File, OpenOptions},
    io::{self, ErrorKind, Read as _},
    path::{Path, PathBuf},
};

/// Folder with `a.img`, `b.img`, `state` and the folder `waiting`.
#[derive(Clone, Debug)]
pub struct Folder {
    path: PathBuf,
    size: u64,
}

impl Folder {
    /// Returns the place in this folder; new images have this many bytes.
    ///
    /// # Errors
    /// There is no such folder, or nothing can be made in it.
    pub fn new(path: &Path, size: u64) -> io::Result<Self> {
        match fs::create_dir(path.join("waiting")) {
            Err(e) if e.kind() != ErrorKind::AlreadyExists => return Err(e),
            _ => {}
        }
        Ok(Self { path: path.to_owned(), size })
    }

    /// Returns the path of an image.
    #[must_use]
    pub fn image_path(&self, side: Side) -> PathBuf {
        self.path.join(side.file())
    }

    fn waiting_path(&self, name: &str) -> PathBuf {
        self.path.join("waiting").join(name)
    }
}

/// Reads a file of at most `most` bytes; a longer one is an error.
///
/// # Errors
/// The file cannot be read, is no regular file, or is longer.
pub fn read_bounded(path: &Path, most: u64) -> io::Result<Vec<u8>> {
    // A pipe would block the reader until somebody writes.
    let data = fs::metadata(path)?;
    if !data.is_file() {
        return Err(io::Error::new(ErrorKind::InvalidInput, "it is no regular file"));
    }
    let mut bytes = Vec::new();
    if data.len() <= most {
        File::open(path)?.take(most + 1).read_to_end(&mut bytes)?;
    }
    if data.len() > most || bytes.len() as u64 > most {
        return Err(io::Error::new(ErrorKind::FileTooLarge, "the file is too large"));
    }
    Ok(bytes)
}

impl Bay for Folder {
    type Image = File;

    fn blank(&mut self, side: Side) -> io::Result<()> {
        let path = self.image_path(side);
        let file = OpenOptions::new().write(true).create(true).truncate(true).open(path)?;
        file.set_len(self.size)
    }

    fn image(&mut self, side: Side) -> io::Result<File> {
        // An image keeps the length that it was made with: the host may see it, and its file system fills it.
        OpenOptions::new().read(true).write(true).open(self.image_path(side))
    }

    fn flush(&mut self, side: Side) -> io::Result<()> {
        File::open(self.image_path(side))?.sync_all()
    }

    fn state(&mut self) -> io::Result<Option<Vec<u8>>> {
        match read_bounded(&self.path.join("state"), 1 << 20) {
            Ok(bytes) => Ok(Some(bytes)),
            Err(e) if e.kind() == ErrorKind::NotFound => Ok(None),
            Err(e) => Err(e),
        }
    }

    fn set_state(&mut self, bytes: &[u8]) -> io::Result<()> {
        hal_output::write(&self.path.join("state"), bytes)
    }

    fn waiting(&mut self) -> io::Result<Vec<String>> {
        let mut names = Vec::new();
        for entry in fs::read_dir(self.path.join("waiting"))? {
            let entry = entry?;
            // A file that was not complete at a power cut has another name.
            let name = entry.file_name().to_str().map(str::to_owned);
            let name = name.filter(|n| crate::safe_name(n).as_deref() == Ok(n));
            if let Some(name) = name
                && entry.file_type()?.is_file()
            {
                names.push(name);
            }
        }
        names.sort();
        Ok(names)
    }

    fn job(&mut self, name: &str) -> io::Result<Vec<u8>> {
        read_bounded(&self.waiting_path(name), crate::storage::MOST_BYTES)
    }

    fn keep(&mut self, name: &str, bytes: &[u8]) -> io::Result<()> {
        hal_output::write(&self.waiting_path(name), bytes)
    }

    fn forget(&mut self, name: &str) -> io::Result<()> {
        fs::remove_file(self.waiting_path(name))
    }
}
