//! The loader: finds plugin files, checks them, and opens the one that offers a component.

use crate::{
    Error, PluginError,
    error::near::nearest,
    load::code::Library,
    load::offer,
    load::opening::{ToOpen, try_first, try_together},
    load::plugin_file::PluginFile,
    os,
    sync::Arc,
};
use hal_abi::{
    ABI_MAJOR, ABI_MINOR, ComponentType, ForeignLoader, Record, component_flags, panic_strategy,
};
use hal_protocol::{Offer, Patterns};
use libloading::os::unix;
use std::{
    collections::{BTreeMap, BTreeSet},
    path::{Path, PathBuf},
};

/// A component type, found in a library.
#[derive(Clone, Debug)]
pub(crate) struct Found {
    pub(crate) ty: ComponentType,
    pub(crate) library: Arc<Library>,
    /// True if the library has a language runtime of its own.
    pub(crate) private: bool,
}

impl Found {
    /// Returns whether the component is created once per load.
    pub(crate) const fn is_once(&self) -> bool {
        self.ty.flags & component_flags::ONCE != 0
    }
}

/// A file that is not a plugin, and the plugin that loads it.
#[derive(Clone, Debug)]
pub(crate) struct ForeignFound {
    pub(crate) file: PathBuf,
    /// Kind of the file, such as `component in C`.
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
    /// Files that offer components, by component name, as far as the search has gone.
    known: BTreeMap<String, PathBuf>,
    /// Files that have been examined.
    seen: BTreeSet<PathBuf>,
    /// Plugins that load files of another kind, by the symbol that those files export.
    loaders: BTreeMap<String, PathBuf>,
}

impl Loader {
    /// Creates a loader that searches these folders in order.
    pub(crate) fn new(path: Vec<PathBuf>) -> Self {
        Self { path, ..Self::default() }
    }

    /// Adds a library that is linked into this program.
    pub(crate) fn add_static(&mut self, library: &'static hal_abi::Library) {
        self.fixed.push(library);
    }

    /// Finds the component type of this name: linked in, in a file of its own, or in a family's
    /// file.
    pub(crate) fn find(&mut self, name: &str) -> Result<Found, Error> {
        for library in &self.fixed {
            // SAFETY: a static descriptor.
            if let Some(ty) = unsafe { contents(*library, "linked in") }?.types.remove(name) {
                return Ok(Found { ty, library: Arc::new(Library::Static), private: false });
            }
        }
        if !self.known.contains_key(name) {
            let plain = name.chars().all(|c| c.is_ascii_alphanumeric() || c == '_' || c == '-');
            for folder in self.path.clone().iter().filter(|_| plain) {
                for file in [format!("lib{name}.so"), format!("{name}.so")] {
                    if let Some(found) = self.own_file(&folder.join(file), name)? {
                        return Ok(found);
                    }
                }
            }
            self.look_into_families(Some(name));
        }
        match self.known.get(name) {
            Some(file) => open_type(file, name)?.ok_or_else(|| self.missing(name)),
            None => Err(self.missing(name)),
        }
    }

    /// Finds the component type of this name in the file named after it. The file is not opened if
    /// it declares other components only.
    fn own_file(&mut self, path: &Path, name: &str) -> Result<Option<Found>, Error> {
        let Some(file) = PluginFile::find(path)? else { return Ok(None) };
        let offers = match file.describe() {
            Ok(described) => described.names.is_none_or(|n| n.components.contains(name)),
            Err(_) if self.foreign_symbol(&file).is_some() => false,
            Err(e) => return Err(e.into()),
        };
        let found = if offers { open_type(path, name)? } else { None };
        if found.is_some() {
            self.known.insert(name.to_owned(), path.to_owned());
        }
        Ok(found)
    }

    /// Records the declared contents of the plugins on the path: of all of them, or of those up to
    /// the one that offers this component. No file is opened as a library for that. A file that is
    /// not a plugin is skipped here: it is an error only if it is requested by name.
    fn look_into_families(&mut self, until: Option<&str>) {
        for folder in self.path.clone() {
            let Ok(entries) = std::fs::read_dir(&folder) else { continue };
            let mut files: Vec<PathBuf> = entries.filter_map(|e| Some(e.ok()?.path())).collect();
            files.sort();
            for path in files {
                if until.is_some_and(|name| self.known.contains_key(name)) {
                    return;
                }
                let is_library = path.extension().is_some_and(|e| e == "so");
                if !is_library || !self.seen.insert(path.clone()) {
                    continue;
                }
                let Ok(Some(file)) = PluginFile::find(&path) else { continue };
                let Some(names) = file.describe().ok().and_then(|d| d.names) else { continue };
                for name in names.components {
                    self.known.entry(name).or_insert_with(|| path.clone());
                }
                for symbol in names.loaders {
                    self.loaders.entry(symbol).or_insert_with(|| path.clone());
                }
            }
        }
    }

    /// Returns the component types that can be loaded and match, by name.
    pub(crate) fn catalogue(&mut self, p: &Patterns) -> Vec<Offer> {
        self.look_into_families(None);
        let mut out = BTreeMap::new();
        let wanted = || self.known.iter().filter(|(name, _)| p.matches(name));
        try_together(&wanted().map(|(_, file)| file).collect());
        for (name, file) in wanted() {
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

    /// Returns the symbol by which a loader recognises a file that is not a plugin.
    fn foreign_symbol(&mut self, file: &PluginFile) -> Option<String> {
        self.look_into_families(None);
        file.exported(self.loaders.keys().map(String::as_str)).map(str::to_owned)
    }

    /// Returns the file of this name that a loader recognises, and the symbol by which it does.
    fn foreign_file(&mut self, name: &str) -> Result<Option<(PluginFile, String)>, PluginError> {
        if name.contains(['/', '\0']) || name.contains("..") {
            return Ok(None);
        }
        for folder in self.path.clone() {
            for file in [format!("{name}.so"), format!("lib{name}.so")] {
                if let Some(file) = PluginFile::find(&folder.join(file))?
                    && file.describe().is_err()
                    && let Some(symbol) = self.foreign_symbol(&file)
                {
                    return Ok(Some((file, symbol)));
                }
            }
        }
        Ok(None)
    }

    /// Finds a file of this name that a loader recognises. `loaded` are the files of its kind that
    /// are already loaded, from which it may take symbols. With `simulated` hardware, a file that its loader will
    /// refuse is not opened at all.
    pub(crate) fn find_foreign(
        &mut self,
        name: &str,
        loaded: &[PathBuf],
        simulated: bool,
    ) -> Result<ForeignFound, Error> {
        let (file, symbol) = self.foreign_file(name)?.ok_or_else(|| Error::InitFailed {
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
        let path = file.openable()?;
        let before = by.canonicalize().into_iter().chain(loaded.iter().cloned());
        let all = before.chain([path]).map(|path| ToOpen { path, global: true });
        if !simulated || library.opens_simulated(file.path()) {
            try_first(file.path(), file.identity(), &all.collect::<Vec<_>>())?;
        }
        Ok(ForeignFound { file: file.path().to_owned(), kind, load, library })
    }

    /// Does the same, unless a plugin offers a component of this name.
    pub(crate) fn find_only_foreign(
        &mut self,
        name: &str,
        loaded: &[PathBuf],
        simulated: bool,
    ) -> Result<Option<ForeignFound>, Error> {
        let ours = |library: &&'static hal_abi::Library| {
            // SAFETY: a static descriptor.
            unsafe { contents(*library, "linked in") }.is_ok_and(|l| l.types.contains_key(name))
        };
        if self.fixed.iter().any(ours) || self.known.contains_key(name) {
            return Ok(None);
        }
        if self.foreign_file(name)?.is_none() || self.known.contains_key(name) {
            return Ok(None);
        }
        self.find_foreign(name, loaded, simulated).map(Some)
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

/// Opens a file to create one of its components.
fn open_type(file: &Path, name: &str) -> Result<Option<Found>, Error> {
    let (mut found, library) = open(file, Stay::Mapped)?;
    Ok(found.types.remove(name).map(|ty| Found { ty, library, private: true }))
}

/// Component types and loaders of a library.
#[derive(Debug, Default)]
struct Contents {
    /// Component types by name.
    types: BTreeMap<String, ComponentType>,
    /// Loaders by the symbol of their files.
    loaders: BTreeMap<String, ForeignLoader>,
}

/// Lifetime of a library's mapping.
///
/// A library whose code has run stays mapped: its language runtime may have registered cleanup code
/// for the end of a thread, and closing would remove that code. Opening it again gives the same
/// mapping, so it is mapped once however often it is loaded.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Stay {
    Mapped,
    WhileOpen,
}

fn open(path: &Path, stay: Stay) -> Result<(Contents, Arc<Library>), Error> {
    let shown = path.display().to_string();
    let not =
        |why: String| PluginError::NotAPlugin { file: shown.as_str().into(), why: why.into() };
    let file = PluginFile::find(path)?.ok_or_else(|| not("it has gone".to_owned()))?;
    let described = file.describe()?;
    described.permit(path)?;
    let symbol = described.symbol;
    let whole = file.openable()?;
    try_first(path, file.identity(), &[ToOpen { path: whole.clone(), global: false }])?;
    let stays = if stay == Stay::Mapped { os::STAY_MAPPED } else { 0 };
    // SAFETY: a plugin's initialisers are ordinary code of its language runtime.
    let library = unsafe { unix::Library::open(Some(whole), os::RESOLVE_ALL | stays) };
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

/// Reads and checks the contents of a descriptor.
///
/// # Safety
/// `library` points at a live descriptor.
unsafe fn contents(library: *const hal_abi::Library, file: &str) -> Result<Contents, PluginError> {
    let not = |why: &str| PluginError::NotAPlugin { file: file.into(), why: why.into() };
    // SAFETY: the caller's promise. Size and versions come first in every major version.
    let head = unsafe { library.cast::<[u32; 3]>().read() };
    if head[1] != ABI_MAJOR {
        return Err(PluginError::WrongMajor { file: file.into(), has: head[1], want: ABI_MAJOR });
    }
    // SAFETY: the caller's promise.
    let l =
        unsafe { hal_abi::Library::read(library) }.ok_or_else(|| not("its descriptor is cut"))?;
    if l.abi_minor > ABI_MINOR {
        return Err(PluginError::NewerMinor {
            file: file.into(),
            has: l.abi_minor,
            want: ABI_MINOR,
        });
    }
    match l.panic {
        panic_strategy::UNWIND => {}
        panic_strategy::ABORT => return Err(PluginError::Aborts { file: file.into() }),
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
