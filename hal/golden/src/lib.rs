//! Golden files: expected text that a test compares with, and that `UPDATE_EXPECT=1` writes.
//!
//! Every test and benchmark of the workspace accepts new output in this one way. (`haltest --accept` does the same for the waveforms of
//! a machine's tests, which their users have without this workspace.)

#![forbid(unsafe_code)]
#![expect(
    clippy::unwrap_used,
    clippy::panic,
    clippy::print_stderr,
    reason = "whatever fails here fails a test, and a skipped test says so"
)]

pub mod rights;
pub mod tools;

use std::{fs, path::Path};

/// Folder of the workspace.
const ROOT: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../..");

/// Returns whether this run writes golden files instead of comparing with them.
#[must_use]
pub fn is_update() -> bool {
    std::env::var_os("UPDATE_EXPECT").is_some()
}

/// Compares `got` with a golden file, or writes the file.
///
/// # Errors
/// The file is missing or cannot be read; or the two differ: the file, the first lines that differ with some context, and the
/// command that accepts them.
pub fn compare(path: &Path, got: &str) -> Result<(), String> {
    judge(path, got, is_update())
}

fn judge(path: &Path, got: &str, is_update: bool) -> Result<(), String> {
    let expected = fs::read_to_string(path);
    if expected.as_deref().ok() == Some(got) {
        return Ok(());
    }
    if is_update {
        fs::create_dir_all(path.parent().unwrap()).unwrap();
        fs::write(path, got).unwrap();
        return Ok(());
    }
    let root = fs::canonicalize(ROOT).unwrap();
    let shown = path.strip_prefix(root).unwrap_or(path).display();
    let expected = match expected {
        Ok(expected) => expected,
        Err(e) => return Err(format!("{shown}: {e} (UPDATE_EXPECT=1 writes the file)")),
    };
    let difference = match difference(&expected, got) {
        same if expected.lines().eq(got.lines()) => {
            format!("{same}they differ in line ends only\n")
        }
        difference => difference,
    };
    Err(format!("{shown} (UPDATE_EXPECT=1 accepts what came):\n{difference}"))
}

/// Asserts that `got` is what a golden file holds, or writes the file.
///
/// # Panics
/// The two differ.
pub fn check(path: &Path, got: &str) {
    compare(path, got).unwrap_or_else(|difference| panic!("{difference}"));
}

/// Asserts that the part of a file between two marks is `got`, or writes that part.
///
/// # Panics
/// The two differ, or a mark is missing.
pub fn check_part(path: &Path, begin: &str, end: &str, got: &str) {
    let text = fs::read_to_string(path).unwrap();
    let (head, rest) = text.split_once(begin).unwrap();
    let (_, tail) = rest.split_once(end).unwrap();
    check(path, &format!("{head}{begin}{got}{end}{tail}"));
}

/// Replaces the part of a file between two marks by what `new` makes of it.
///
/// # Panics
/// The file cannot be read or written, or a mark is missing.
pub fn rewrite_part(path: &Path, begin: &str, end: &str, new: impl FnOnce(&str) -> String) {
    let text = fs::read_to_string(path).unwrap();
    let (head, rest) = text.split_once(begin).unwrap();
    let (old, tail) = rest.split_once(end).unwrap();
    fs::write(path, format!("{head}{begin}{}{end}{tail}", new(old))).unwrap();
}

/// Returns the first lines that differ, with some context.
#[must_use]
pub fn difference(expected: &str, got: &str) -> String {
    differing(expected, got, |a, b| a == b)
}

/// Returns the same as [`difference`], with another rule for equal lines.
#[must_use]
pub fn differing(expected: &str, got: &str, same: fn(&str, &str) -> bool) -> String {
    let (expected, got): (Vec<&str>, Vec<&str>) =
        (expected.lines().collect(), got.lines().collect());
    let same = expected.iter().zip(&got).take_while(|(e, g)| same(e, g)).count();
    let part = |mark: &str, lines: &[&str], n: usize| {
        lines.iter().take(n).fold(String::new(), |t, l| t + mark + l + "\n")
    };
    let from = same.saturating_sub(3);
    part("  ", got.get(from..same).unwrap_or_default(), 3)
        + &part("- ", expected.get(same..).unwrap_or_default(), 10)
        + &part("+ ", got.get(same..).unwrap_or_default(), 10)
}

#[cfg(test)]
mod tests {
    use super::judge;
    use std::fs;

    #[test]
    fn a_missing_file_is_no_empty_text() {
        let folder = std::env::temp_dir().join(format!("ferrule-golden-{}", std::process::id()));
        let path = folder.join("expected");
        let missing = judge(&path, "", false).unwrap_err();
        assert!(missing.contains("UPDATE_EXPECT=1 writes the file"), "{missing}");
        judge(&path, "", true).unwrap();
        assert_eq!(judge(&path, "", false), Ok(()));
        fs::write(&path, "one\ntwo\n").unwrap();
        for ends in ["one\ntwo", "one\r\ntwo\n"] {
            let told = judge(&path, ends, false).unwrap_err();
            assert!(told.contains("line ends only"), "{told}");
        }
        let told = judge(&path, "one\nthree\n", false).unwrap_err();
        assert!(told.contains("- two") && told.contains("+ three"), "{told}");
        fs::write(&path, [0xff]).unwrap();
        assert!(judge(&path, "", false).is_err());
        fs::remove_dir_all(&folder).unwrap();
    }
}
