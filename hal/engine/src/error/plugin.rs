//! Errors of files on the plugin path that are not opened.

/// The reason why a file on the plugin path is not opened.
#[derive(Clone, Debug, PartialEq, Eq)]
#[expect(missing_docs, reason = "the sentence of each variant is its documentation")]
pub enum PluginError {
    NotAPlugin { file: Box<str>, why: Box<str> },
    Irregular { file: Box<str>, what: &'static str },
    WrongMajor { file: Box<str>, has: u32, want: u32 },
    NewerMinor { file: Box<str>, has: u32, want: u32 },
    OtherRelease { file: Box<str>, has: Box<str>, runs: &'static str },
    Aborts { file: Box<str> },
    Owner { file: Box<str>, path: Box<str>, owner: u32 },
    Writable { file: Box<str>, path: Box<str>, mode: u32 },
    Dies { file: Box<str>, how: Box<str> },
    Ending { file: Box<str> },
}

impl PluginError {
    /// Returns a suggested correction.
    pub(crate) fn hint(&self) -> Option<String> {
        match self {
            Self::Owner { path, .. } => Some(format!(
                "root opens files of root's and, under sudo, of the user's who called it: chown \
                 root {path}"
            )),
            Self::Writable { path, .. } => Some(format!("chmod go-w {path}")),
            Self::NotAPlugin { .. }
            | Self::Irregular { .. }
            | Self::WrongMajor { .. }
            | Self::NewerMinor { .. }
            | Self::OtherRelease { .. }
            | Self::Aborts { .. }
            | Self::Dies { .. }
            | Self::Ending { .. } => None,
        }
    }
}

impl core::fmt::Display for PluginError {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        match self {
            Self::NotAPlugin { file, why } => write!(f, "{file}: not a plugin: {why}"),
            Self::Irregular { file, what } => {
                write!(f, "{file}: not a plugin: it is {what}, not a regular file")
            }
            Self::WrongMajor { file, has, want } => write!(
                f,
                "{file}: built for major version {has} of the plugin contract, this engine has {want}"
            ),
            Self::NewerMinor { file, has, want } => write!(
                f,
                "{file}: built for minor version {has} of the plugin contract, this engine has \
                 only {want}"
            ),
            Self::OtherRelease { file, has, runs } => write!(
                f,
                "{file}: part of Ferrule {has}, and this instance runs {runs}: restart the machine, which then \
                 uses {has}"
            ),
            Self::Aborts { file } => write!(
                f,
                "{file}: built with panic=abort: a panic in it would end the machine's process"
            ),
            Self::Owner { file, path, owner } => {
                write!(f, "{file}: not opened as root: {path} belongs to user {owner}")
            }
            Self::Writable { file, path, mode } => write!(
                f,
                "{file}: not opened as root: other users can change {path} (mode {mode:04o})"
            ),
            Self::Dies { file, how } => {
                write!(f, "{file}: opened in a process of its own first, it {how}")
            }
            Self::Ending { file } => write!(f, "{file}: not opened: the instance is ending"),
        }
    }
}
