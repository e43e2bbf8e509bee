//! Virtual is virtual: what a module on the virtual clock or with simulated hardware may not reach.
//!
//! After the module's file is opened, and before any other of its code runs, its own imports of functions that reach
//! outside are redirected to [`refusals`], and so are those of the libraries that came with it. The process itself and
//! the libraries that it had before keep theirs.

mod files;
mod libraries;
pub(crate) mod refusals;
mod tried;

use crate::{elf::Elf, module::Module, objects::Mapped, system};
use core::fmt;
use std::path::{Path, PathBuf};

pub(crate) use tried::{note, suffix};

/// Libraries of the C and C++ compilers: their initialisers reach nothing outside.
const OF_THE_COMPILER: &[&str] = &[
    "ld-linux",
    "libatomic.",
    "libc.",
    "libdl.",
    "libgcc_s.",
    "libm.",
    "libmvec.",
    "libpthread.",
    "librt.",
    "libstdc++.",
];

fn of_the_compiler(path: &Path) -> bool {
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    OF_THE_COMPILER.iter().any(|known| name.starts_with(known))
}

/// Checks a file before it is opened: code that runs while it is opened cannot be redirected yet, and addresses within code
/// not at all.
///
/// # Errors
/// The file, or a library that it brings, has such code, and one of them imports a function that reaches outside.
pub(crate) fn check(path: &Path, elf: &Elf) -> Result<(), OutsideError> {
    let mut files = vec![(path.to_owned(), elf.clone())];
    let unread = |why: String| OutsideError::Unread(why.into());
    for library in libraries::brought_by(path, &elf.needed).map_err(unread)? {
        let elf = Elf::read(&library).map_err(unread)?;
        files.push((library, elf));
    }
    files.retain(|(path, _)| !of_the_compiler(path));
    let reaches = files.iter().find_map(|(path, elf)| {
        let mut names = elf.undefined.iter().map(|name| &**name);
        Some((path, names.find(|name| refusals::find(name).is_some())?))
    });
    let Some((reaches, name)) = reaches else { return Ok(()) };
    let held = files.iter().find_map(|(path, elf)| match elf {
        _ if elf.runs_when_opened => Some((path, Unheld::Constructor)),
        _ if elf.relocates_text => Some((path, Unheld::WithinCode)),
        _ => None,
    });
    let Some((path, why)) = held else { return Ok(()) };
    let name = name.to_string_lossy().into_owned().into();
    Err(OutsideError::Unheld { path: path.clone(), why, reaches: reaches.clone(), name })
}

/// Code of a file that cannot be held back.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Unheld {
    /// Code that runs as the file is opened.
    Constructor,
    /// Code with the addresses of functions in itself.
    WithinCode,
}

/// Reason for which a file is not opened where hardware is simulated, or does not run.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum OutsideError {
    /// The file, or a library that it brings, cannot be read.
    Unread(Box<str>),
    /// The code of a file reaches outside and cannot be held back.
    Unheld {
        /// The file with that code.
        path: PathBuf,
        why: Unheld,
        /// The file that imports the function.
        reaches: PathBuf,
        /// The function that reaches outside.
        name: Box<str>,
    },
    /// The system does not let the call of this function be redirected.
    NotRedirected {
        /// The function.
        name: Box<str>,
        /// The reason of the system.
        why: Box<str>,
    },
}

impl fmt::Display for OutsideError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Unread(why) => f.write_str(why),
            Self::Unheld { path, why, reaches, name } => {
                let why = match why {
                    Unheld::Constructor => {
                        "has code that runs as it is opened (a constructor), which cannot be held back"
                    }
                    Unheld::WithinCode => {
                        "has addresses of functions within its code (compile it with -fPIC)"
                    }
                };
                let by = if reaches == path { "it".into() } else { reaches.display().to_string() };
                write!(
                    f,
                    "{}: it {why}, and {by} imports {name}: under --virtual and --simulate a component in C reaches \
                     nothing outside; {}",
                    path.display(),
                    tried::REMEDY
                )
            }
            Self::NotRedirected { name, why } => {
                write!(f, "the call of {name} cannot be redirected: {why}")
            }
        }
    }
}

impl core::error::Error for OutsideError {}

impl From<OutsideError> for String {
    fn from(why: OutsideError) -> Self {
        why.to_string()
    }
}

/// Redirects the imports of a module, and of the libraries that are here since `before`.
///
/// # Errors
/// The system does not allow it: the module must not run.
pub(crate) fn redirect(module: &Module, before: &[Mapped]) -> Result<(), OutsideError> {
    let own = usize::try_from(system::base(module.handle)).unwrap_or(0);
    for library in crate::objects::mapped() {
        let is_own = library.base == own;
        if is_own || module.is_simulated() && !before.contains(&library) {
            library.redirect(|name| {
                let ports = is_own.then(|| crate::access::of_ports(name)).flatten();
                let refused = || module.is_simulated().then(|| refusals::find(name)).flatten();
                ports.or_else(refused)
            })?;
        }
    }
    Ok(())
}
