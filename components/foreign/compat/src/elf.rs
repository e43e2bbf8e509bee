//! Contents of a library file that are read before any of its code runs.

use crate::docs;
use core::ffi::CStr;
use object::{
    Architecture, Object, ObjectSection, ObjectSymbol, StringTable, elf,
    read::elf::{Dyn, ElfFile64, ProgramHeader},
};
use std::{ffi::CString, path::Path};

/// Relevant contents of a file.
#[derive(Clone, Debug, Default)]
pub(crate) struct Elf {
    /// Names of its module parameters.
    pub(crate) parameters: Vec<String>,
    /// Symbols of its descriptions.
    pub(crate) descriptions: Vec<String>,
    /// Symbols that the file imports.
    pub(crate) undefined: Vec<CString>,
    /// Names of the libraries that it needs.
    pub(crate) needed: Vec<String>,
    /// True if addresses of imports may lie within its code.
    pub(crate) relocates_text: bool,
    /// True if code of its own runs as it is opened.
    pub(crate) runs_when_opened: bool,
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
        let file = object::File::parse(&*bytes)
            .map_err(|e| format!("{shown}: it is not a dynamic library ({e})"))?;
        let built = file.architecture();
        if built != HERE {
            return Err(format!(
                "{shown} is built for {}, and this machine is {}",
                spelt(built),
                spelt(HERE)
            ));
        }
        let mut out = Self::default();
        for s in file.dynamic_symbols() {
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
                out.undefined.push(CString::new(name).unwrap_or_default());
            }
        }
        out.parameters.sort();
        let object::File::Elf64(file) = file else { return Ok(out) };
        out.read_dynamic(&file).map_err(|e| format!("{shown}: its dynamic section: {e}"))?;
        Ok(out)
    }

    /// Reads the dynamic section.
    fn read_dynamic(&mut self, file: &ElfFile64<'_>) -> Result<(), object::Error> {
        let (endian, data) = (file.endian(), file.data());
        let entries =
            file.elf_program_headers().iter().find_map(|h| h.dynamic(endian, data).transpose());
        let entries = entries.transpose()?.unwrap_or_default();
        let strings = file.elf_section_table().dynamic(endian, data)?;
        let strings = match strings {
            Some((_, link)) => file.elf_section_table().strings(endian, data, link)?,
            None => StringTable::default(),
        };
        // The files that the compiler adds have one entry in the list, and one function of a few bytes.
        let has = |name: &CStr| self.undefined.iter().any(|n| n.as_c_str() == name);
        let entries_of_the_compiler = u64::from(has(c"_ITM_registerTMCloneTable")) * WORD;
        let init = file.section_by_name(".init").filter(|s| s.size() <= MAX_INIT);
        let init = init.map(|s| s.address()).filter(|_| has(c"__gmon_start__"));
        for entry in entries {
            let value = entry.d_val(endian);
            match u32::try_from(entry.d_tag(endian)).unwrap_or(0) {
                elf::DT_NEEDED => {
                    let name = entry.string(endian, strings)?;
                    self.needed.push(String::from_utf8_lossy(name).into_owned());
                }
                elf::DT_INIT => self.runs_when_opened |= init != Some(value),
                elf::DT_INIT_ARRAYSZ => self.runs_when_opened |= value > entries_of_the_compiler,
                elf::DT_TEXTREL => self.relocates_text = true,
                elf::DT_FLAGS => self.relocates_text |= value & u64::from(elf::DF_TEXTREL) != 0,
                elf::DT_PREINIT_ARRAYSZ => self.runs_when_opened |= value > 0,
                _ => {}
            }
        }
        Ok(())
    }
}

/// Size of an address.
const WORD: u64 = 8;
/// Largest size of the compiler's own function in `.init`.
const MAX_INIT: u64 = 32;

fn spelt(architecture: Architecture) -> String {
    format!("{architecture:?}").to_lowercase()
}
