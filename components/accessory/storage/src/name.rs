//! Names of jobs that every medium can hold.

use core::fmt;

/// Longest name in characters.
pub const LONGEST: usize = 64;
/// Names of devices, which some systems do not open as files.
const DEVICES: [&str; 4] = ["CON", "PRN", "AUX", "NUL"];

/// Reason why a text is no name.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum WrongName {
    /// Nothing is left of it.
    Empty,
    /// Longer than [`LONGEST`].
    Long,
}

impl fmt::Display for WrongName {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Empty => f.write_str("the name has no letter or digit"),
            Self::Long => write!(f, "the name is longer than {LONGEST} characters"),
        }
    }
}

/// Returns the name under which a job is stored: the part after the last `/` or `\`, in which each character but ASCII
/// letters, digits, blanks and `._-+()` is an underscore.
///
/// # Errors
/// The name is too long, or has no letter or digit.
pub fn safe_name(text: &str) -> Result<String, WrongName> {
    let last = text.rsplit(['/', '\\']).next().unwrap_or_default();
    if last.chars().count() > LONGEST {
        return Err(WrongName::Long);
    }
    let is_safe = |c: char| c.is_ascii_alphanumeric() || " ._-+()".contains(c);
    let kept: String = last.chars().map(|c| if is_safe(c) { c } else { '_' }).collect();
    // A file that begins with a dot is hidden; ends with a blank or a dot are lost on FAT.
    let kept = kept.trim_start_matches(['.', ' ']).trim_end_matches(['.', ' ']);
    if !kept.chars().any(|c| c.is_ascii_alphanumeric()) {
        return Err(WrongName::Empty);
    }
    let stem = kept.split('.').next().unwrap_or_default().trim_end().to_ascii_uppercase();
    let is_numbered = |port: &str| {
        stem.strip_prefix(port)
            .is_some_and(|n| n.len() == 1 && n.bytes().all(|b| b.is_ascii_digit()))
    };
    let is_device = DEVICES.contains(&stem.as_str()) || is_numbered("COM") || is_numbered("LPT");
    Ok(if is_device { format!("_{kept}") } else { kept.to_owned() })
}

/// Returns whether two names are the same file on FAT.
#[must_use]
pub const fn is_same(a: &str, b: &str) -> bool {
    a.eq_ignore_ascii_case(b)
}
