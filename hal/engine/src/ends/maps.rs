//! Lookup of the library that an address belongs to, in `/proc/self/maps` and without heap memory.

use super::sys;

/// Longest line of the file that is read; the rest of a longer line is ignored.
const LINE: usize = 512;

/// Executable range of a library.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Code {
    /// First address.
    from: usize,
    /// First address behind the range.
    to: usize,
}

impl Code {
    pub(super) const fn holds(&self, address: usize) -> bool {
        self.from <= address && address < self.to
    }
}

/// Passes the address range and the path of every executable mapping of a file to `look`, until it
/// returns true.
pub(super) fn each(mut look: impl FnMut(Code, &str) -> bool) {
    let Some(file) = sys::open_read(c"/proc/self/maps") else { return };
    let (mut line, mut used) = ([0_u8; LINE], 0);
    let mut chunk = [0_u8; 1024];
    'all: loop {
        let n = sys::read(file, &mut chunk);
        let Some(read) = chunk.get(..n).filter(|c| !c.is_empty()) else { break };
        for byte in read {
            if *byte != b'\n' {
                if let Some(place) = line.get_mut(used) {
                    *place = *byte;
                    used += 1;
                }
                continue;
            }
            let text = core::str::from_utf8(line.get(..used).unwrap_or_default());
            if let Some((code, path)) = text.ok().and_then(parsed)
                && look(code, path)
            {
                break 'all;
            }
            used = 0;
        }
    }
    sys::close(file);
}

/// Parses a line, if it describes code that comes from a file.
fn parsed(line: &str) -> Option<(Code, &str)> {
    let mut words = line.splitn(6, ' ');
    let (range, rights) = (words.next()?, words.next()?);
    let path = words.nth(3)?.trim_start();
    if !rights.contains('x') || !path.starts_with('/') {
        return None;
    }
    let (from, to) = range.split_once('-')?;
    let number = |text| usize::from_str_radix(text, 16).ok();
    Some((Code { from: number(from)?, to: number(to)? }, path))
}

/// Returns the file that contains an address of code.
pub(crate) fn file_of(address: usize) -> Option<Box<str>> {
    let mut found = None;
    each(|code, path| {
        let here = code.holds(address);
        if here {
            found = Some(path.into());
        }
        here
    });
    found
}

#[cfg(test)]
mod tests {
    use super::{file_of, parsed};

    #[test]
    fn lines_of_code_are_understood() {
        let line = "7f00-7fff r-xp 00001000 fe:00 1234      /usr/lib/x y.so";
        let (code, path) = parsed(line).unwrap();
        assert_eq!((code.from, code.to, path), (0x7f00, 0x7fff, "/usr/lib/x y.so"));
        for other in [
            "7f00-7fff r--p 00001000 fe:00 1234      /usr/lib/x.so",
            "7f00-7fff r-xp 00000000 00:00 0         [vdso]",
            "7f00-7fff r-xp 00000000 00:00 0",
            "",
        ] {
            assert!(parsed(other).is_none(), "{other}");
        }
    }

    #[test]
    fn own_code_lies_in_the_own_program() {
        let own = std::env::current_exe().unwrap().canonicalize().unwrap();
        let found = file_of(own_code_lies_in_the_own_program as *const () as usize);
        assert_eq!(found.as_deref(), own.to_str());
        assert_eq!(file_of(8), None);
    }
}
