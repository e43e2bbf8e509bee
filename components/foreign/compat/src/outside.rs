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
use std::path::Path;

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
pub(crate) fn check(path: &Path, elf: &Elf) -> Result<(), String> {
    let mut files = vec![(path.to_owned(), elf.clone())];
    for library in libraries::brought_by(path, &elf.needed)? {
        let elf = Elf::read(&library)?;
        files.push((library, elf));
    }
    files.retain(|(path, _)| !of_the_compiler(path));
    let reaches = files.iter().find_map(|(path, elf)| {
        let mut names = elf.undefined.iter().map(|name| &**name);
        Some((path, names.find(|name| refusals::find(name).is_some())?))
    });
    let Some((reaches, name)) = reaches else { return Ok(()) };
    let why = files.iter().find_map(|(path, elf)| {
        if elf.runs_when_opened {
            return Some((
                path,
                "has code that runs as it is opened (a constructor), which cannot be held back",
            ));
        }
        let calls = "has addresses of functions within its code (compile it with -fPIC)";
        elf.relocates_text.then_some((path, calls))
    });
    let Some((path, why)) = why else { return Ok(()) };
    let name = name.to_string_lossy();
    let reaches = if reaches == path { "it".into() } else { reaches.display().to_string() };
    Err(format!(
        "{}: it {why}, and {reaches} imports {name}: under --virtual and --simulate a component in C reaches \
         nothing outside; {}",
        path.display(),
        tried::REMEDY
    ))
}

/// Redirects the imports of a module, and of the libraries that are here since `before`.
///
/// # Errors
/// The system does not allow it: the module must not run.
pub(crate) fn redirect(module: &Module, before: &[Mapped]) -> Result<(), String> {
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
