//! The place of the two images, of the state file and of waiting jobs.

use core::fmt;
use std::io::{self, Read, Seek, Write};

/// Side of the storage: image A or image B.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Side {
    /// Image A.
    A,
    /// Image B.
    B,
}

impl Side {
    /// Returns the other image.
    #[must_use]
    pub const fn other(self) -> Self {
        match self {
            Self::A => Self::B,
            Self::B => Self::A,
        }
    }

    /// Returns the name of the image's file.
    #[must_use]
    pub const fn file(self) -> &'static str {
        match self {
            Self::A => "a.img",
            Self::B => "b.img",
        }
    }
}

impl fmt::Display for Side {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::A => "A",
            Self::B => "B",
        })
    }
}

/// Place of images, state file and waiting jobs.
pub trait Bay {
    /// Image that can be read and written.
    type Image: Read + Write + Seek;

    /// Makes an image all zero. The crate for FAT does not clear the memory into which a folder grows.
    ///
    /// # Errors
    /// The image cannot be made or written.
    fn blank(&mut self, side: Side) -> io::Result<()>;

    /// Opens an image. A new one is made with the size of images, all zero.
    ///
    /// # Errors
    /// The image cannot be opened or made.
    fn image(&mut self, side: Side) -> io::Result<Self::Image>;

    /// Returns after everything that was written to an image is on the disk.
    ///
    /// # Errors
    /// The disk does not take it.
    fn flush(&mut self, side: Side) -> io::Result<()>;

    /// Returns the state file; `None` if there is none.
    ///
    /// # Errors
    /// It cannot be read.
    fn state(&mut self) -> io::Result<Option<Vec<u8>>>;

    /// Replaces the state file as a whole.
    ///
    /// # Errors
    /// It cannot be written; the old one stays.
    fn set_state(&mut self, bytes: &[u8]) -> io::Result<()>;

    /// Returns the names of the waiting jobs, sorted.
    ///
    /// # Errors
    /// They cannot be listed.
    fn waiting(&mut self) -> io::Result<Vec<String>>;

    /// Returns a waiting job.
    ///
    /// # Errors
    /// It cannot be read.
    fn job(&mut self, name: &str) -> io::Result<Vec<u8>>;

    /// Keeps a waiting job as a whole, or replaces it.
    ///
    /// # Errors
    /// It cannot be written.
    fn keep(&mut self, name: &str, bytes: &[u8]) -> io::Result<()>;

    /// Removes a waiting job.
    ///
    /// # Errors
    /// It cannot be removed.
    fn forget(&mut self, name: &str) -> io::Result<()>;
}
