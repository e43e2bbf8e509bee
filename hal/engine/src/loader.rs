//! Plugin files: where they are, whether they are plugins, and which offers a component.

use crate::{Error, code::Library, near::nearest, offer, os, sync::Arc};
use hal_abi::{ABI_MAJOR, ABI_MINOR, ComponentType, Record, component_flags, panic_strategy};
use hal_protocol::{Offer, Patterns};
use libloading::os::unix;
use object::{Object, ObjectSymbol};
use std::{
    collections::{BTreeMap, BTreeSet},
    path::{Path, PathBuf},
};

/// A component type, found in a library.
#[derive(Clone, Debug)]
pub(crate) struct Found {
    pub(crate) ty: ComponentType,
    pub(crate) library: Arc<Library>,
    /// Whether the library has a language runtime of its own.
    pub(crate) private: bool,
}

impl Found {
    /// Whether it is created once per load.
    pub(crate) const fn is_once(&self) -> bool {
        self.ty.flags & component_flags::ONCE != 0
    }
}

/// Finds component types.
#[derive(Debug, Default)]
pub(crate) struct Loader {
    path: Vec<PathBuf>,
    fixed: Vec<&'static hal_abi::Library>,
    /// Which file offers a component, as far as has been looked.
    known: BTreeMap<String, PathBuf>,
    /// Files that have been looked into.
    seen: BTreeSet<PathBuf>,
}

impl Loader {
    /// Searches these folders in order.
    pub(crate) fn new(path: Vec<PathBuf>) -> Self {
        Self { path, ..Self::default() }
    }

    /// Adds a library that is linked into this program.
    pub(crate) fn add_static(&mut self, library: &'static hal_abi::Library) {
        self.fixed.push(library);
    }

    /// The component type of this name: linked in, in a file of its own, or in a family.
    pub(crate) fn find(&mut self, name: &str) -> Result<Found, Error> {
        for library in &self.fixed {
            // SAFETY: a static descriptor.
            if let Some(ty) = unsafe { types(*library, "linked in") }?.remove(name) {
                return Ok(Found { ty, library: Arc::new(Library::Static), private: false });
            }
        }
        if let Some(file) = self.known.get(name).cloned() {
            return open_type(&file, name)?.ok_or_else(|| self.missing(name));
        }
        let plain = name.chars().all(|c| c.is_ascii_alphanumeric() || c == '_' || c == '-');
        if plain {
            for folder in &self.path {
                for file in [format!("lib{name}.so"), format!("{name}.so")] {
                    let file = folder.join(file);
                    if !file.is_file() {
                        continue;
                    }
                    if let Some(found) = open_type(&file, name)? {
                        self.known.insert(name.to_owned(), file);
                        return Ok(found);
                    }
                }
            }
        }
        self.look_into_families();
        match self.known.get(name).cloned() {
            Some(file) => open_type(&file, name)?.ok_or_else(|| self.missing(name)),
            None => Err(self.missing(name)),
        }
    }

    /// Notes what every plugin on the path offers. What is not a plugin is passed over here: it
    /// is only an error when it is asked for by name.
    fn look_into_families(&mut self) {
        for folder in self.path.clone() {
            let Ok(entries) = std::fs::read_dir(&folder) else { continue };
            let mut files: Vec<PathBuf> = entries.filter_map(|e| Some(e.ok()?.path())).collect();
            files.sort();
            for file in files {
                let is_library = file.extension().is_some_and(|e| e == "so");
                if !is_library || !self.seen.insert(file.clone()) || descriptor(&file).is_err() {
                    continue;
                }
                if let Ok((types, _)) = open(&file, Stay::WhileOpen) {
                    for name in types.into_keys() {
                        self.known.entry(name).or_insert_with(|| file.clone());
                    }
                }
            }
        }
    }

    /// The component types that could be loaded and match, by name.
    pub(crate) fn catalogue(&mut self, p: &Patterns) -> Vec<Offer> {
        self.look_into_families();
        let mut out = BTreeMap::new();
        for (name, file) in self.known.iter().filter(|(name, _)| p.matches(name)) {
            let Ok((types, _library)) = open(file, Stay::WhileOpen) else { continue };
            let stem = file.file_stem().and_then(|s| s.to_str()).unwrap_or_default();
            let library = stem.strip_prefix("lib").unwrap_or(stem);
            if let Some(ty) = types.get(name) {
                out.insert(name.clone(), offer::of(name, library, ty));
            }
        }
        for library in &self.fixed {
            // SAFETY: a static descriptor.
            let types = unsafe { types(*library, "linked in") }.unwrap_or_default();
            for (name, ty) in types.iter().filter(|(name, _)| p.matches(name)) {
                out.insert(name.clone(), offer::of(name, "", ty));
            }
        }
        out.into_values().collect()
    }

    fn missing(&self, name: &str) -> Error {
        let searched: Vec<String> = self.path.iter().map(|p| p.display().to_string()).collect();
        let searched = if searched.is_empty() { "nowhere".into() } else { searched.join(", ") };
        let mut names: Vec<String> = self.known.keys().cloned().collect();
        for library in &self.fixed {
            // SAFETY: a static descriptor.
            names.extend(unsafe { types(*library, "linked in") }.unwrap_or_default().into_keys());
        }
        let near = nearest(name, names.iter().map(String::as_str));
        Error::NoModule { name: name.into(), searched: searched.into(), near }
    }
}

/// Opens a file for a component of it that is to be made.
fn open_type(file: &Path, name: &str) -> Result<Option<Found>, Error> {
    let (mut types, library) = open(file, Stay::Mapped)?;
    Ok(types.remove(name).map(|ty| Found { ty, library, private: true }))
}

/// The symbol that a plugin file exports, if it does; nothing of the file is run.
fn descriptor(file: &Path) -> Result<String, Error> {
    let not =
        |why: &str| Error::NotAPlugin { file: file.display().to_string().into(), why: why.into() };
    let stem = file.file_stem().and_then(|s| s.to_str()).unwrap_or_default();
    let symbol =
        format!("hal_library_{}", stem.strip_prefix("lib").unwrap_or(stem).replace('-', "_"));
    // Only the parts that are looked at are read.
    let parts = std::fs::File::open(file).map_err(|e| not(&e.to_string()))?;
    let parts = object::ReadCache::new(parts);
    let elf = object::File::parse(&parts).map_err(|_| not("it is not a dynamic library"))?;
    let exported = elf.dynamic_symbols().any(|s| s.is_definition() && s.name() == Ok(&symbol));
    if exported {
        Ok(symbol)
    } else {
        Err(not(&format!("it exports no '{symbol}' (was the file renamed?)")))
    }
}

type Types = BTreeMap<String, ComponentType>;

/// Whether a library stays when nothing of it is in use any more.
///
/// One whose code has run stays mapped: its language runtime may have registered what a thread is
/// to run when that ends, and that would be gone. Opening it again gives the same mapping, so it
/// is there once however often it is loaded.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Stay {
    Mapped,
    WhileOpen,
}

fn open(file: &Path, stay: Stay) -> Result<(Types, Arc<Library>), Error> {
    let symbol = descriptor(file)?;
    let shown = file.display().to_string();
    let not = |why: String| Error::NotAPlugin { file: shown.as_str().into(), why: why.into() };
    let stays = if stay == Stay::Mapped { os::STAY_MAPPED } else { 0 };
    // SAFETY: a plugin's initialisers are ordinary code of its language runtime.
    let library = unsafe { unix::Library::open(Some(file), os::RESOLVE_ALL | stays) };
    let library = library.map(libloading::Library::from).map_err(|e| not(e.to_string()))?;
    // SAFETY: only its address is used.
    let found = unsafe { library.get::<*const hal_abi::Library>(symbol.as_bytes()) };
    let found = found.map_err(|e| not(e.to_string()))?;
    // SAFETY: the address is used only while the library is open.
    let address = unsafe { found.try_as_raw_ptr() };
    let address = address.ok_or_else(|| not("its descriptor is null".into()))?;
    // SAFETY: the symbol names a descriptor, whose first field is its size.
    let types = unsafe { types(address.cast(), &shown) }?;
    Ok((types, Arc::new(Library::File(library))))
}

/// The component types of a descriptor, checked.
///
/// # Safety
/// `library` points at a live descriptor.
unsafe fn types(library: *const hal_abi::Library, file: &str) -> Result<Types, Error> {
    let not = |why: &str| Error::NotAPlugin { file: file.into(), why: why.into() };
    // SAFETY: the caller's promise. Size and versions come first in every major version.
    let head = unsafe { library.cast::<[u32; 3]>().read() };
    if head[1] != ABI_MAJOR {
        return Err(Error::WrongMajor { file: file.into(), has: head[1], want: ABI_MAJOR });
    }
    // SAFETY: the caller's promise.
    let l =
        unsafe { hal_abi::Library::read(library) }.ok_or_else(|| not("its descriptor is cut"))?;
    if l.abi_minor > ABI_MINOR {
        return Err(Error::NewerMinor { file: file.into(), has: l.abi_minor, want: ABI_MINOR });
    }
    match l.panic {
        panic_strategy::UNWIND => {}
        panic_strategy::ABORT => return Err(Error::Aborts { file: file.into() }),
        _ => return Err(not("it does not say how it panics")),
    }
    let mut out = Types::new();
    for i in 0..l.components.len() {
        // SAFETY: a live descriptor's list.
        let ty = unsafe { l.components.get(i) }.ok_or_else(|| not("a component type is cut"))?;
        // SAFETY: a live descriptor's string.
        let name = unsafe { ty.name.get() }.ok_or_else(|| not("a name is not UTF-8"))?;
        if ty.create.is_none() || name.is_empty() {
            return Err(not("a component type has no name or no code"));
        }
        out.insert(name.to_owned(), ty);
    }
    Ok(out)
}
