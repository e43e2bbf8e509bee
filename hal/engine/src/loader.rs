//! Plugin files: where they are, whether they are plugins, and which offers a component.

use crate::{Error, code::Library, near::nearest, offer, os, sync::Arc};
use hal_abi::{
    ABI_MAJOR, ABI_MINOR, ComponentType, ForeignLoader, Record, component_flags, panic_strategy,
};
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

/// A file that is no plugin, and who loads it.
#[derive(Clone, Debug)]
pub(crate) struct ForeignFound {
    pub(crate) file: PathBuf,
    /// What it is, such as `component in C`.
    pub(crate) kind: String,
    pub(crate) load: hal_abi::Load,
    /// The library that loads it.
    pub(crate) library: Arc<Library>,
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
    /// Plugins that load files of another kind, by the symbol that those export.
    loaders: BTreeMap<String, PathBuf>,
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
            if let Some(ty) = unsafe { contents(*library, "linked in") }?.types.remove(name) {
                return Ok(Found { ty, library: Arc::new(Library::Static), private: false });
            }
        }
        if let Some(file) = self.known.get(name).cloned() {
            return open_type(&file, name)?.ok_or_else(|| self.missing(name));
        }
        let plain = name.chars().all(|c| c.is_ascii_alphanumeric() || c == '_' || c == '-');
        if plain {
            for folder in self.path.clone() {
                for file in [format!("lib{name}.so"), format!("{name}.so")] {
                    let file = folder.join(file);
                    if !file.is_file() {
                        continue;
                    }
                    match open_type(&file, name) {
                        Ok(Some(found)) => {
                            self.known.insert(name.to_owned(), file);
                            return Ok(found);
                        }
                        Ok(None) => {}
                        Err(_) if self.foreign_symbol(&file).is_some() => {}
                        Err(e) => return Err(e),
                    }
                }
            }
        }
        self.look_into_families(Some(name));
        match self.known.get(name).cloned() {
            Some(file) => open_type(&file, name)?.ok_or_else(|| self.missing(name)),
            None => Err(self.missing(name)),
        }
    }

    /// Notes what the plugins on the path offer: all of them, or those up to the one that offers this
    /// component. What is not a plugin is passed over here: it is only an error when it is asked for
    /// by name.
    fn look_into_families(&mut self, until: Option<&str>) {
        for folder in self.path.clone() {
            let Ok(entries) = std::fs::read_dir(&folder) else { continue };
            let mut files: Vec<PathBuf> = entries.filter_map(|e| Some(e.ok()?.path())).collect();
            files.sort();
            for file in files {
                if until.is_some_and(|name| self.known.contains_key(name)) {
                    return;
                }
                let is_library = file.extension().is_some_and(|e| e == "so");
                if !is_library || !self.seen.insert(file.clone()) {
                    continue;
                }
                if let Ok((library, _open)) = open(&file, Stay::WhileOpen) {
                    for name in library.types.into_keys() {
                        self.known.entry(name).or_insert_with(|| file.clone());
                    }
                    for symbol in library.loaders.into_keys() {
                        self.loaders.entry(symbol).or_insert_with(|| file.clone());
                    }
                }
            }
        }
    }

    /// The component types that could be loaded and match, by name.
    pub(crate) fn catalogue(&mut self, p: &Patterns) -> Vec<Offer> {
        self.look_into_families(None);
        let mut out = BTreeMap::new();
        for (name, file) in self.known.iter().filter(|(name, _)| p.matches(name)) {
            let Ok((found, _library)) = open(file, Stay::WhileOpen) else { continue };
            let stem = file.file_stem().and_then(|s| s.to_str()).unwrap_or_default();
            let library = stem.strip_prefix("lib").unwrap_or(stem);
            if let Some(ty) = found.types.get(name) {
                out.insert(name.clone(), offer::of(name, library, ty));
            }
        }
        for library in &self.fixed {
            // SAFETY: a static descriptor.
            let types = unsafe { contents(*library, "linked in") }.unwrap_or_default().types;
            for (name, ty) in types.iter().filter(|(name, _)| p.matches(name)) {
                out.insert(name.clone(), offer::of(name, "", ty));
            }
        }
        out.into_values().collect()
    }

    /// The symbol by which a file that is no plugin is known to a loader.
    fn foreign_symbol(&mut self, file: &Path) -> Option<String> {
        self.look_into_families(None);
        self.loaders.keys().find(|symbol| exports(file, symbol).unwrap_or(false)).cloned()
    }

    /// The file of this name that a loader knows, and the symbol by which it does.
    fn foreign_file(&mut self, name: &str) -> Option<(PathBuf, String)> {
        if name.contains(['/', '\0']) || name.contains("..") {
            return None;
        }
        for folder in self.path.clone() {
            for file in [format!("{name}.so"), format!("lib{name}.so")] {
                let file = folder.join(file);
                if file.is_file()
                    && descriptor(&file).is_err()
                    && let Some(symbol) = self.foreign_symbol(&file)
                {
                    return Some((file, symbol));
                }
            }
        }
        None
    }

    /// A file of this name that a loader knows.
    pub(crate) fn find_foreign(&mut self, name: &str) -> Result<ForeignFound, Error> {
        let (file, symbol) = self.foreign_file(name).ok_or_else(|| Error::InitFailed {
            name: name.into(),
            why: format!("no component in C of this name (searched {})", self.searched()).into(),
            code: hal_abi::Status::ENOENT.0,
        })?;
        let by = self.loaders.get(&symbol).cloned().unwrap_or_default();
        let (found, library) = open(&by, Stay::Mapped)?;
        let loader = found.loaders.get(&symbol).ok_or_else(|| self.missing(name))?;
        let load = loader.load.ok_or_else(|| self.missing(name))?;
        // SAFETY: a string of an open library's descriptor.
        let kind = unsafe { loader.kind.get() }.unwrap_or_default().to_owned();
        Ok(ForeignFound { file, kind, load, library })
    }

    /// The same, unless a plugin offers a component of this name.
    pub(crate) fn find_only_foreign(&mut self, name: &str) -> Result<Option<ForeignFound>, Error> {
        let ours = |library: &&'static hal_abi::Library| {
            // SAFETY: a static descriptor.
            unsafe { contents(*library, "linked in") }.is_ok_and(|l| l.types.contains_key(name))
        };
        if self.fixed.iter().any(ours) || self.known.contains_key(name) {
            return Ok(None);
        }
        if self.foreign_file(name).is_none() || self.known.contains_key(name) {
            return Ok(None);
        }
        self.find_foreign(name).map(Some)
    }

    fn searched(&self) -> String {
        let searched: Vec<String> = self.path.iter().map(|p| p.display().to_string()).collect();
        if searched.is_empty() { "nowhere".into() } else { searched.join(", ") }
    }

    fn missing(&self, name: &str) -> Error {
        let searched = self.searched();
        let mut names: Vec<String> = self.known.keys().cloned().collect();
        for library in &self.fixed {
            // SAFETY: a static descriptor.
            let found = unsafe { contents(*library, "linked in") }.unwrap_or_default();
            names.extend(found.types.into_keys());
        }
        let near = nearest(name, names.iter().map(String::as_str));
        Error::NoModule { name: name.into(), searched: searched.into(), near }
    }
}

/// Opens a file for a component of it that is to be made.
fn open_type(file: &Path, name: &str) -> Result<Option<Found>, Error> {
    let (mut found, library) = open(file, Stay::Mapped)?;
    Ok(found.types.remove(name).map(|ty| Found { ty, library, private: true }))
}

/// The symbol that a plugin file exports, if it does; nothing of the file is run.
fn descriptor(file: &Path) -> Result<String, Error> {
    let not =
        |why: &str| Error::NotAPlugin { file: file.display().to_string().into(), why: why.into() };
    let stem = file.file_stem().and_then(|s| s.to_str()).unwrap_or_default();
    let symbol =
        format!("hal_library_{}", stem.strip_prefix("lib").unwrap_or(stem).replace('-', "_"));
    match exports(file, &symbol) {
        Ok(true) => Ok(symbol),
        Ok(false) => Err(not(&format!("it exports no '{symbol}' (was the file renamed?)"))),
        Err(why) => Err(not(&why)),
    }
}

/// Whether a dynamic library exports a symbol.
fn exports(file: &Path, symbol: &str) -> Result<bool, String> {
    // Only the parts that are looked at are read.
    let parts = std::fs::File::open(file).map_err(|e| e.to_string())?;
    let parts = object::ReadCache::new(parts);
    let elf = object::File::parse(&parts).map_err(|_| "it is not a dynamic library")?;
    Ok(elf.dynamic_symbols().any(|s| s.is_definition() && s.name() == Ok(symbol)))
}

/// What a library offers.
#[derive(Debug, Default)]
struct Contents {
    /// Component types by name.
    types: BTreeMap<String, ComponentType>,
    /// Loaders by the symbol of their files.
    loaders: BTreeMap<String, ForeignLoader>,
}

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

fn open(file: &Path, stay: Stay) -> Result<(Contents, Arc<Library>), Error> {
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
    let found = unsafe { contents(address.cast(), &shown) }?;
    Ok((found, Arc::new(Library::File(library))))
}

/// What a descriptor offers, checked.
///
/// # Safety
/// `library` points at a live descriptor.
unsafe fn contents(library: *const hal_abi::Library, file: &str) -> Result<Contents, Error> {
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
    let mut out = Contents::default();
    for i in 0..l.components.len() {
        // SAFETY: a live descriptor's list.
        let ty = unsafe { l.components.get(i) }.ok_or_else(|| not("a component type is cut"))?;
        // SAFETY: a live descriptor's string.
        let name = unsafe { ty.name.get() }.ok_or_else(|| not("a name is not UTF-8"))?;
        if ty.create.is_none() || name.is_empty() {
            return Err(not("a component type has no name or no code"));
        }
        out.types.insert(name.to_owned(), ty);
    }
    for i in 0..l.loaders.len() {
        // SAFETY: a live descriptor's list.
        let loader = unsafe { l.loaders.get(i) }.ok_or_else(|| not("a loader is cut"))?;
        // SAFETY: a live descriptor's string.
        let symbol = unsafe { loader.symbol.get() }.ok_or_else(|| not("a name is not UTF-8"))?;
        out.loaders.insert(symbol.to_owned(), loader);
    }
    Ok(out)
}
