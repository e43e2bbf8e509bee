//! Dynamic libraries as files: their exported symbols, read without running any of their code.
//!
//! The amount of data read is limited, whatever the file declares: it may be corrupt on purpose.

use core::cell::Cell;
use object::{
    Endianness, ReadRef,
    elf::{self, FileHeader64, ProgramHeader64, Sym64},
    read::{
        ReadCache,
        elf::{FileHeader, ProgramHeader, SectionHeader, Sym},
    },
};
use std::fs::File;

/// Largest number of bytes that are read of one file.
const MAX_READ: u64 = 64 << 20;
/// The kind of machine that this program is built for.
const MACHINE: u16 = if cfg!(target_arch = "x86_64") {
    elf::EM_X86_64
} else if cfg!(target_arch = "aarch64") {
    elf::EM_AARCH64
} else if cfg!(target_arch = "riscv64") {
    elf::EM_RISCV
} else {
    elf::EM_NONE
};

/// The parts of a file that have been read.
#[derive(Debug)]
pub(crate) struct Parts<'f> {
    cache: ReadCache<&'f File>,
    /// Number of bytes that may still be read.
    left: Cell<u64>,
}

impl<'f> Parts<'f> {
    /// Creates a reader of this file that has read nothing yet.
    pub(crate) fn new(file: &'f File) -> Self {
        Self { cache: ReadCache::new(file), left: Cell::new(MAX_READ) }
    }

    fn charge(&self, bytes: u64) -> Result<(), ()> {
        self.left.set(self.left.get().checked_sub(bytes).ok_or(())?);
        Ok(())
    }
}

impl<'p> ReadRef<'p> for &'p Parts<'_> {
    fn len(self) -> Result<u64, ()> {
        self.cache.len()
    }

    fn read_bytes_at(self, offset: u64, size: u64) -> Result<&'p [u8], ()> {
        self.charge(size)?;
        self.cache.read_bytes_at(offset, size)
    }

    fn read_bytes_at_until(
        self,
        range: core::ops::Range<u64>,
        delimiter: u8,
    ) -> Result<&'p [u8], ()> {
        self.charge(range.end.saturating_sub(range.start))?;
        self.cache.read_bytes_at_until(range, delimiter)
    }
}

/// A dynamic library.
#[derive(Debug)]
pub(crate) struct Elf<'p> {
    parts: &'p Parts<'p>,
    endian: Endianness,
    segments: &'p [ProgramHeader64<Endianness>],
    symbols: &'p [Sym64<Endianness>],
    /// The names of the symbols.
    strings: &'p [u8],
    fits: bool,
}

impl<'p> Elf<'p> {
    /// Reads the headers and the tables of symbols.
    pub(crate) fn read(parts: &'p Parts<'p>) -> Result<Self, &'static str> {
        let none = "it is not a dynamic library";
        let header = FileHeader64::<Endianness>::parse(parts).map_err(|_| none)?;
        let endian = header.endian().map_err(|_| none)?;
        if header.e_type(endian) != elf::ET_DYN {
            return Err(none);
        }
        let broken = "it is a broken dynamic library";
        let segments = header.program_headers(endian, parts).map_err(|_| broken)?;
        let sections = header.section_headers(endian, parts).map_err(|_| none)?;
        let table = sections.iter().find(|s| s.sh_type(endian) == elf::SHT_DYNSYM).ok_or(none)?;
        let symbols = table.data_as_array(endian, parts).map_err(|_| broken)?;
        let strings = usize::try_from(table.sh_link(endian)).ok().and_then(|i| sections.get(i));
        let strings = strings.ok_or(broken)?.data(endian, parts).map_err(|_| broken)?;
        let fits = header.e_machine(endian) == MACHINE;
        Ok(Self { parts, endian, segments, symbols, strings, fits })
    }

    /// Returns whether the library is built for the kind of machine that this program runs on. The
    /// loader of a foreign file reports by itself what is wrong with a file for another one.
    pub(crate) const fn fits(&self) -> bool {
        self.fits
    }

    /// Returns whether the library defines a symbol.
    pub(crate) fn exports(&self, name: &str) -> bool {
        self.symbol(name).is_some()
    }

    /// Returns the bytes of a symbol; `None` if the library does not define it, if it is longer
    /// than `most`, or if its bytes are not in the file.
    pub(crate) fn bytes(&self, name: &str, most: usize) -> Option<&'p [u8]> {
        let symbol = self.symbol(name)?;
        let (address, size) = (symbol.st_value(self.endian), symbol.st_size(self.endian));
        if size > u64::try_from(most).ok()? {
            return None;
        }
        let offset = self.segments.iter().find_map(|segment| {
            let from = segment.p_vaddr(self.endian);
            let ahead = address.checked_sub(from)?;
            let whole = ahead.checked_add(size)? <= segment.p_filesz(self.endian);
            let loaded = segment.p_type(self.endian) == elf::PT_LOAD && whole;
            loaded.then(|| segment.p_offset(self.endian).checked_add(ahead))?
        })?;
        self.parts.read_bytes_at(offset, size).ok()
    }

    fn symbol(&self, name: &str) -> Option<&'p Sym64<Endianness>> {
        let is = |symbol: &&Sym64<Endianness>| {
            let at = usize::try_from(symbol.st_name(self.endian)).ok();
            let rest = at.and_then(|at| self.strings.get(at..));
            let after = rest.and_then(|rest| rest.strip_prefix(name.as_bytes()));
            after.is_some_and(|after| after.first() == Some(&0))
                && symbol.is_definition(self.endian)
        };
        self.symbols.iter().find(is)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::{
        fs,
        os::unix::fs::FileExt,
        path::{Path, PathBuf},
    };

    /// Creates a file with its own name for one test.
    fn file(name: &str, bytes: &[u8]) -> (PathBuf, File) {
        let path = std::env::temp_dir().join(format!("hal-elf-{}-{name}", std::process::id()));
        fs::write(&path, bytes).unwrap();
        let file = File::options().read(true).write(true).open(&path).unwrap();
        (path, file)
    }

    /// Makes every query of a file.
    fn ask(file: &File) -> Result<(bool, Option<usize>), &'static str> {
        let parts = Parts::new(file);
        let elf = Elf::read(&parts)?;
        Ok((elf.exports("malloc"), elf.bytes("environ", 100).map(<[u8]>::len)))
    }

    /// Returns the contents of the C library that this test runs with.
    fn library() -> Vec<u8> {
        let maps = fs::read_to_string("/proc/self/maps").unwrap();
        let line = maps.lines().find(|l| l.contains("/libc.so") || l.contains("/libc-")).unwrap();
        fs::read(Path::new(line.split_whitespace().nth(5).unwrap())).unwrap()
    }

    #[test]
    fn what_a_library_exports_is_read_from_its_file() {
        let (path, whole) = file("whole", &library());
        let parts = Parts::new(&whole);
        let elf = Elf::read(&parts).unwrap();
        assert!(elf.exports("malloc") && elf.exports("dlopen"));
        assert!(!elf.exports("mallo") && !elf.exports("malloc2") && !elf.exports(""));
        // `_libc_intl_domainname` is a constant of the C library; `environ` is all zero and has no
        // bytes in the file.
        assert_eq!(elf.bytes("_libc_intl_domainname", 100), Some(&b"libc\0"[..]));
        assert_eq!(elf.bytes("_libc_intl_domainname", 4), None, "longer than is asked for");
        assert_eq!(elf.bytes("environ", 100), None);
        fs::remove_file(path).unwrap();
    }

    #[test]
    fn a_broken_file_is_refused_and_nothing_else_happens() {
        let whole = library();
        let (path, changed) = file("broken", &whole);
        assert_eq!(ask(&changed), Ok((true, None)));
        // Truncate the file at many lengths.
        for cut in (0..200).chain([1000, 10_000, whole.len() / 2, whole.len() - 1]).rev() {
            changed.set_len(cut as u64).unwrap();
            assert!(ask(&changed).is_err(), "{cut}");
        }
        fs::write(&path, &whole).unwrap();
        // Change every byte of the header, and of the first headers of segments and sections.
        let sections =
            usize::try_from(u64::from_le_bytes(whole[40..48].try_into().unwrap())).unwrap();
        for at in (0..64 + 4 * 56).chain(sections..(sections + 12 * 64).min(whole.len())) {
            for value in [0, 1, 0x7f, 0xff] {
                let put = |byte: u8| changed.write_all_at(&[byte], at as u64).unwrap();
                put(value);
                // The file is read without a panic and within bounds, whatever it declares now.
                let _: Result<(bool, Option<usize>), &str> = ask(&changed);
                put(whole[at]);
            }
        }
        // A table larger than that of any library is not read, although the file is that large.
        let section = |at: usize| &whole[sections + at * 64..sections + (at + 1) * 64];
        let dynsym = (0..60).find(|i| section(*i)[4..8] == 11_u32.to_le_bytes()).unwrap();
        changed.set_len(1 << 36).unwrap();
        let size = (24_u64 << 31).to_le_bytes();
        changed.write_all_at(&size, (sections + dynsym * 64 + 32) as u64).unwrap();
        assert_eq!(ask(&changed), Err("it is a broken dynamic library"));
        fs::remove_file(path).unwrap();
    }

    #[test]
    fn other_files_are_none() {
        for (name, bytes) in
            [("empty", &b""[..]), ("text", b"#!/bin/sh\necho\n"), ("zeros", &[0; 4096])]
        {
            let (path, file) = file(name, bytes);
            assert_eq!(ask(&file), Err("it is not a dynamic library"), "{name}");
            fs::remove_file(path).unwrap();
        }
        let own = File::open(std::env::current_exe().unwrap()).unwrap();
        assert!(matches!(ask(&own), Ok((false, None)) | Err(_)));
    }
}
