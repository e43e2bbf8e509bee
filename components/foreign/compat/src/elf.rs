//! Contents of a library file that are read before any of its code runs.

use crate::docs;
use object::{Architecture, Object, ObjectSymbol, ObjectSymbolTable, RelocationTarget};
use std::{ffi::CString, path::Path};

/// Symbol that the file imports.
#[derive(Clone, Debug)]
pub(crate) struct Undefined {
    pub(crate) name: CString,
    /// Places that hold its address, as offsets from the file's base in memory.
    pub(crate) places: Vec<u64>,
}

/// Relevant contents of a file.
#[derive(Debug, Default)]
pub(crate) struct Elf {
    /// Names of its module parameters.
    pub(crate) parameters: Vec<String>,
    /// Symbols of its descriptions.
    pub(crate) descriptions: Vec<String>,
    /// Symbols that the file imports.
    pub(crate) undefined: Vec<Undefined>,
}

const HERE: Architecture = if cfg!(target_arch = "x86_64") {
    Architecture::X86_64
} else if cfg!(target_arch = "aarch64") {
    Architecture::Aarch64
} else {
    Architecture::Unknown
};

impl Elf {
    /// Reads a file.
    ///
    /// # Errors
    /// The file cannot be read, is not a dynamic library, or is for another processor architecture.
    pub(crate) fn read(path: &Path) -> Result<Self, String> {
        let shown = path.display();
        let bytes = std::fs::read(path).map_err(|e| format!("{shown}: {e}"))?;
        let elf = object::File::parse(&*bytes)
            .map_err(|e| format!("{shown}: it is not a dynamic library ({e})"))?;
        let built = elf.architecture();
        if built != HERE {
            return Err(format!(
                "{shown} is built for {}, and this machine is {}",
                spelt(built),
                spelt(HERE)
            ));
        }
        let mut out = Self::default();
        for s in elf.dynamic_symbols() {
            let Ok(name) = s.name() else { continue };
            if s.is_definition()
                && let Some(parameter) = name.strip_prefix("rtapi_info_type_")
            {
                out.parameters.push(parameter.to_owned());
            }
            if s.is_definition() && name.starts_with(docs::PREFIX) {
                out.descriptions.push(name.to_owned());
            }
            if s.is_undefined() && !name.is_empty() {
                let name = CString::new(name).unwrap_or_default();
                out.undefined.push(Undefined { name, places: Vec::new() });
            }
        }
        out.parameters.sort();
        let table = elf.dynamic_symbol_table();
        for (place, r) in elf.dynamic_relocations().into_iter().flatten() {
            let RelocationTarget::Symbol(index) = r.target() else { continue };
            let symbol = table.as_ref().and_then(|t| t.symbol_by_index(index).ok());
            let Some(name) = symbol.and_then(|s| s.name().ok()) else { continue };
            let known = out.undefined.iter_mut().find(|u| u.name.to_bytes() == name.as_bytes());
            if let Some(u) = known {
                u.places.push(place);
            }
        }
        Ok(out)
    }

    /// Returns the places that hold the address of an imported symbol.
    pub(crate) fn places(&self, name: &str) -> &[u64] {
        let found = self.undefined.iter().find(|u| u.name.to_bytes() == name.as_bytes());
        found.map_or(&[], |u| &u.places)
    }
}

fn spelt(architecture: Architecture) -> String {
    format!("{architecture:?}").to_lowercase()
}
