//! Libraries in this process: which there are, and the places that hold the addresses of what each one imports.

use crate::outside::OutsideError;
use core::ffi::{CStr, c_char, c_int, c_void};
use std::ffi::CString;

/// Library in this process, as the dynamic linker lists it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Mapped {
    /// Address to which the addresses in its file are relative.
    pub(crate) base: usize,
    /// Path of its file; empty for the program itself.
    pub(crate) path: CString,
    /// Address of its dynamic section.
    dynamic: usize,
    /// Memory that the linker makes read-only once the library is bound.
    relro: core::ops::Range<usize>,
}

/// Returns the libraries in this process.
pub(crate) fn mapped() -> Vec<Mapped> {
    /// # Safety
    /// `dl_iterate_phdr` calls this with its record and the list.
    unsafe extern "C" fn note(
        info: *mut libc::dl_phdr_info,
        _size: usize,
        list: *mut c_void,
    ) -> c_int {
        // SAFETY: the linker's record lives across the call.
        let Some(info) = (unsafe { info.as_ref() }) else { return 0 };
        // SAFETY: the list of `mapped`, which only this call uses.
        let Some(list) = (unsafe { list.cast::<Vec<Mapped>>().as_mut() }) else { return 0 };
        let base = usize::try_from(info.dlpi_addr).unwrap_or(0);
        // SAFETY: a C string of the linker's.
        let path = unsafe { CStr::from_ptr(info.dlpi_name) }.to_owned();
        let mut one = Mapped { base, path, dynamic: 0, relro: 0..0 };
        for i in 0..usize::from(info.dlpi_phnum) {
            // SAFETY: one of the headers that the record counts.
            let header = unsafe { &*info.dlpi_phdr.wrapping_add(i) };
            let begin = base.wrapping_add(usize::try_from(header.p_vaddr).unwrap_or(0));
            let size = usize::try_from(header.p_memsz).unwrap_or(0);
            match header.p_type {
                libc::PT_DYNAMIC => one.dynamic = begin,
                libc::PT_GNU_RELRO => one.relro = begin..begin.wrapping_add(size),
                _ => {}
            }
        }
        list.push(one);
        0
    }
    let mut list: Vec<Mapped> = Vec::new();
    let place = (&raw mut list).cast();
    // SAFETY: a function of the type that the linker calls, and its list.
    unsafe { libc::dl_iterate_phdr(Some(note), place) };
    list
}

/// Entry of a dynamic section.
#[repr(C)]
#[derive(Clone, Copy)]
struct DynamicEntry {
    tag: u64,
    value: u64,
}

/// Entry of a table of relocations.
#[repr(C)]
#[derive(Clone, Copy)]
struct RelaEntry {
    place: u64,
    info: u64,
    addend: i64,
}

/// Entry of a table of symbols.
#[repr(C)]
#[derive(Clone, Copy)]
struct SymbolEntry {
    name: u32,
    info: u8,
    other: u8,
    section: u16,
    value: u64,
    size: u64,
}

/// Tags of a dynamic section.
mod tag {
    pub(super) const END: u64 = 0;
    pub(super) const PLT_SIZE: u64 = 2;
    pub(super) const STRINGS: u64 = 5;
    pub(super) const SYMBOLS: u64 = 6;
    pub(super) const RELA: u64 = 7;
    pub(super) const RELA_SIZE: u64 = 8;
    pub(super) const PLT: u64 = 23;
}

/// Types of relocations that hold the address of a symbol: data, table entry, call.
#[cfg(target_arch = "x86_64")]
const ADDRESSES: [u32; 3] = [1, 6, 7];
/// The same for AArch64.
#[cfg(target_arch = "aarch64")]
const ADDRESSES: [u32; 3] = [257, 1025, 1026];

/// Reads a record of a library's read-only tables.
fn record<T: Copy>(at: usize) -> T {
    let at = core::ptr::with_exposed_provenance::<T>(at);
    // SAFETY: an entry of a table that the library's dynamic section describes, mapped while the library is.
    unsafe { at.read_unaligned() }
}

/// Tables of a library.
#[derive(Default)]
struct Tables {
    strings: usize,
    symbols: usize,
    /// Tables of relocations: address and size.
    relocations: [(usize, usize); 2],
}

impl Mapped {
    fn tables(&self) -> Tables {
        let mut t = Tables::default();
        let mut at = self.dynamic;
        // The linker has turned the addresses into those of this process, but not in a section that is read-only.
        let absolute = |value: u64| {
            let value = usize::try_from(value).unwrap_or(0);
            if value < self.base { self.base + value } else { value }
        };
        let [(rela, rela_size), (plt, plt_size)] = &mut t.relocations;
        while at != 0 {
            let entry: DynamicEntry = record(at);
            let size = usize::try_from(entry.value).unwrap_or(0);
            match entry.tag {
                tag::END => break,
                tag::STRINGS => t.strings = absolute(entry.value),
                tag::SYMBOLS => t.symbols = absolute(entry.value),
                tag::RELA => *rela = absolute(entry.value),
                tag::RELA_SIZE => *rela_size = size,
                tag::PLT => *plt = absolute(entry.value),
                tag::PLT_SIZE => *plt_size = size,
                _ => {}
            }
            at += size_of::<DynamicEntry>();
        }
        t
    }

    /// Calls `each` with every place that holds the address of an import, and the import's name.
    fn imports(&self, mut each: impl FnMut(usize, &CStr)) {
        let t = self.tables();
        if t.strings == 0 || t.symbols == 0 {
            return;
        }
        for (table, size) in t.relocations.into_iter().filter(|(at, _)| *at != 0) {
            for i in 0..size / size_of::<RelaEntry>() {
                let r: RelaEntry = record(table + i * size_of::<RelaEntry>());
                let (index, kind) = ((r.info >> 32) as usize, r.info & u64::from(u32::MAX));
                if index == 0 || !ADDRESSES.iter().any(|a| u64::from(*a) == kind) {
                    continue;
                }
                let symbol: SymbolEntry = record(t.symbols + index * size_of::<SymbolEntry>());
                if symbol.section != 0 {
                    continue;
                }
                let name = core::ptr::with_exposed_provenance::<c_char>(
                    t.strings + usize::try_from(symbol.name).unwrap_or(0),
                );
                // SAFETY: a C string in the library's table of strings.
                let name = unsafe { CStr::from_ptr(name) };
                each(self.base.wrapping_add(usize::try_from(r.place).unwrap_or(0)), name);
            }
        }
    }

    /// Replaces the addresses of imports: `with` returns what takes the place of a name. None of the library's code but
    /// its initialisers may have run.
    ///
    /// # Errors
    /// The system does not let the memory be written.
    pub(crate) fn redirect(
        &self,
        with: impl Fn(&CStr) -> Option<*const c_void>,
    ) -> Result<(), OutsideError> {
        let mut failed = None;
        self.imports(|place, name| {
            if let Some(with) = with(name)
                && !self.write(place, with)
            {
                failed = Some(OutsideError::NotRedirected {
                    name: name.to_string_lossy().into_owned().into(),
                    why: std::io::Error::last_os_error().to_string().into(),
                });
            }
        });
        failed.map_or(Ok(()), Err)
    }

    /// Writes one address, also where the linker has made memory read-only.
    fn write(&self, place: usize, with: *const c_void) -> bool {
        // SAFETY: queries a constant.
        let page = usize::try_from(unsafe { libc::sysconf(libc::_SC_PAGESIZE) }).unwrap_or(4096);
        let begin = place / page * page;
        let size = (place + size_of::<usize>()).next_multiple_of(page) - begin;
        let range = core::ptr::with_exposed_provenance_mut::<c_void>(begin);
        let protect = |how| {
            // SAFETY: whole pages of the library's data, which nothing else runs in.
            unsafe { libc::mprotect(range, size, how) == 0 }
        };
        if !protect(libc::PROT_READ | libc::PROT_WRITE) {
            return false;
        }
        let at = core::ptr::with_exposed_provenance_mut::<*const c_void>(place);
        // SAFETY: the place of one address, by the library's own table of relocations, made writable just now.
        unsafe { at.write_unaligned(with) };
        // The linker protects whole pages only.
        let end = self.relro.end / page * page;
        let read_only = self.relro.start / page * page <= begin && begin + size <= end;
        !read_only || protect(libc::PROT_READ)
    }
}
