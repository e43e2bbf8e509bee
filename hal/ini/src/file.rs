//! Files that users name: never larger than a limit, and never a device or pipe that nothing fills.

use std::{
    fs::{self, File},
    io::{self, Read},
    os::unix::fs::FileTypeExt,
    path::Path,
};

/// Beginnings of the paths of files that this process has open already, such as a pipe that a shell passes.
const OPEN: [&str; 3] = ["/dev/fd/", "/proc/self/fd/", "/dev/stdin"];

/// Reads a file of at most `most` bytes. Returns `None` if it is larger.
///
/// # Errors
/// The file cannot be read, or it is a device, or a pipe in a folder, whose end may never come.
pub fn contents(path: &Path, most: u64) -> io::Result<Option<Vec<u8>>> {
    let kind = fs::metadata(path)?.file_type();
    let is_open = || OPEN.iter().any(|begin| path.to_str().is_some_and(|p| p.starts_with(begin)));
    if kind.is_char_device() || kind.is_block_device() {
        return Err(io::Error::other("it is a device, not a file"));
    }
    if kind.is_fifo() && !is_open() {
        return Err(io::Error::other("it is a pipe, not a file"));
    }
    let mut bytes = Vec::new();
    let n = File::open(path)?.take(most.saturating_add(1)).read_to_end(&mut bytes)?;
    Ok(u64::try_from(n).is_ok_and(|n| n <= most).then_some(bytes))
}

/// Reads a file of at most [`MAX_BYTES`](crate::MAX_BYTES).
///
/// # Errors
/// Those of [`contents`], or the file is larger.
pub fn whole(path: &Path) -> io::Result<Vec<u8>> {
    let bytes = contents(path, crate::MAX_BYTES)?;
    bytes.ok_or_else(|| io::Error::other("it is larger than 64 MiB"))
}

#[cfg(test)]
mod tests {
    use super::{contents, whole};
    use std::path::Path;

    #[test]
    fn devices_and_large_files_are_refused() {
        let refused = |path: &str| whole(Path::new(path)).unwrap_err().to_string();
        assert_eq!(refused("/dev/zero"), "it is a device, not a file");
        let own = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/Cargo.toml"));
        assert_eq!(contents(own, 3).unwrap(), None);
        assert!(whole(own).unwrap().starts_with(b"[package]"));
    }
}
