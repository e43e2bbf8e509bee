//! FAT32 images: made, listed, read, written and compared without being mounted.

use fatfs::{Dir, FatType, FileSystem, FormatVolumeOptions, FsOptions};
use std::{
    io::{self, ErrorKind, Read, Seek, SeekFrom, Write},
    panic::{AssertUnwindSafe, catch_unwind},
};

/// Smallest image in bytes: FAT32 needs 65,525 clusters.
pub const LEAST: u64 = 36 << 20;
/// Largest image in bytes.
pub const MOST: u64 = 32 << 30;
/// Largest number of entries that are read from a folder.
const ENTRIES: usize = 8192;

/// Image that can be read and written.
pub trait Disk: Read + Write + Seek {}
impl<T: Read + Write + Seek> Disk for T {}

/// File in the top folder of an image.
#[derive(Clone, PartialEq, Eq, PartialOrd, Ord, Debug)]
pub struct ImageFile {
    /// Name of the file.
    pub name: String,
    /// Length in bytes.
    pub len: u64,
}

/// Does something with the file system of an image. An image may come from anywhere, and the crate that reads it does not
/// promise to survive every wrong one.
fn with<T, R>(mut disk: T, work: impl FnOnce(&Dir<'_, T>) -> io::Result<R>) -> io::Result<R>
where
    T: Disk,
{
    let all = AssertUnwindSafe(move || {
        disk.seek(SeekFrom::Start(0))?;
        let system = FileSystem::new(disk, FsOptions::new())?;
        let result = work(&system.root_dir());
        system.unmount()?;
        result
    });
    catch_unwind(all).unwrap_or_else(|_| Err(wrong("the file system is damaged")))
}

fn wrong(text: &'static str) -> io::Error {
    io::Error::new(ErrorKind::InvalidData, text)
}

/// Makes an empty file system.
///
/// # Errors
/// The image cannot be written, or its size is none for FAT32.
pub fn format(mut disk: impl Disk) -> io::Result<()> {
    if !(LEAST..=MOST).contains(&disk.seek(SeekFrom::End(0))?) {
        return Err(wrong("the size is not 36 MiB to 32 GiB"));
    }
    disk.seek(SeekFrom::Start(0))?;
    let options = FormatVolumeOptions::new()
        .fat_type(FatType::Fat32)
        .volume_id(0x4645_5252)
        .volume_label(*b"JOBS       ");
    let all = AssertUnwindSafe(move || fatfs::format_volume(disk, options));
    catch_unwind(all).unwrap_or_else(|_| Err(wrong("the size is none for FAT32")))
}

/// Returns the files, sorted by name.
///
/// # Errors
/// The image has no file system, or a damaged one.
pub fn list(disk: impl Disk) -> io::Result<Vec<ImageFile>> {
    with(disk, |root| {
        let mut found = Vec::new();
        for (n, entry) in root.iter().enumerate() {
            if n >= ENTRIES {
                return Err(wrong("the folder has too many entries"));
            }
            let entry = entry?;
            if entry.is_file() {
                found.push(ImageFile { name: entry.file_name(), len: entry.len() });
            }
        }
        found.sort();
        Ok(found)
    })
}

/// Returns a file of at most `most` bytes.
///
/// # Errors
/// There is no such file, it is longer, or the file system is damaged.
pub fn read(disk: impl Disk, name: &str, most: u64) -> io::Result<Vec<u8>> {
    with(disk, |root| {
        let mut bytes = Vec::new();
        root.open_file(name)?.take(most + 1).read_to_end(&mut bytes)?;
        if bytes.len() as u64 > most {
            return Err(io::Error::new(ErrorKind::FileTooLarge, "the file is too large"));
        }
        Ok(bytes)
    })
}

/// Writes a file, and replaces one of the same name.
///
/// # Errors
/// The image has no room, or cannot be written.
pub fn write(disk: impl Disk, name: &str, bytes: &[u8]) -> io::Result<()> {
    with(disk, |root| {
        let mut file = root.create_file(name)?;
        file.truncate()?;
        file.write_all(bytes)?;
        file.flush()
    })
}
