//! Locking of memory: pages that stay present, and are touched before the first cycle.

use core::ptr::{NonNull, null_mut};

/// Smallest page size in bytes; with larger pages, some are touched more than once.
const PAGE: usize = 4096;

/// Returns whether this process may lock any amount of memory, now and later: `RLIMIT_MEMLOCK` is
/// unlimited, or the process is privileged. Tests this by locking more than the limit.
pub(crate) fn may_lock_all() -> bool {
    let Some(limit) = lock_limit() else { return true };
    let Ok(bytes) = usize::try_from(limit) else { return true };
    let bytes = bytes.saturating_add(PAGE).next_multiple_of(PAGE);
    // SAFETY: a fresh anonymous mapping without access.
    let p = unsafe {
        libc::mmap(
            null_mut(),
            bytes,
            libc::PROT_NONE,
            libc::MAP_PRIVATE | libc::MAP_ANONYMOUS | libc::MAP_NORESERVE | libc::MAP_LOCKED,
            -1,
            0,
        )
    };
    if p == libc::MAP_FAILED {
        return false;
    }
    // SAFETY: the mapping that was just made.
    unsafe { libc::munmap(p, bytes) };
    true
}

/// Returns the number of bytes that an unprivileged process may lock; `None` if unlimited.
pub(crate) fn lock_limit() -> Option<u64> {
    rustix::process::getrlimit(rustix::process::Resource::Memlock).current
}

/// Locks all present and future memory of the process; pages are made present at once.
pub(crate) fn lock_all() -> bool {
    // SAFETY: no pointer is involved.
    unsafe { libc::mlockall(libc::MCL_CURRENT | libc::MCL_FUTURE) == 0 }
}

/// Locks each accessible mapping of the process, as far as the limit allows.
pub(crate) fn lock_present() {
    let maps = std::fs::read_to_string("/proc/self/maps").unwrap_or_default();
    for (start, end) in maps.lines().filter_map(usable) {
        // SAFETY: locking changes no content; the kernel refuses a mapping that no longer exists.
        unsafe { libc::mlock(core::ptr::without_provenance(start), end - start) };
    }
}

/// Returns the addresses of a line of `/proc/self/maps`; `None` for a mapping without access.
fn usable(line: &str) -> Option<(usize, usize)> {
    let (range, rest) = line.split_once(' ')?;
    if rest.starts_with("---") || rest.ends_with("[vvar]") || rest.ends_with("[vsyscall]") {
        return None;
    }
    let (start, end) = range.split_once('-')?;
    let number = |text| usize::from_str_radix(text, 16).ok();
    Some((number(start)?, number(end)?)).filter(|(start, end)| start < end)
}

/// Removes the lock from a reservation, which `lock_all` puts on every new mapping: parts are
/// locked as they get memory.
pub(crate) fn unlock(at: NonNull<u8>, bytes: usize) {
    // SAFETY: a mapping of ours; no content changes.
    unsafe { libc::munlock(at.as_ptr().cast(), bytes) };
}

/// Makes this thread's whole stack present, and locks it if the system allows.
pub(crate) fn keep_stack() {
    // SAFETY: all zero is a valid place for attributes.
    let mut attributes: libc::pthread_attr_t = unsafe { core::mem::zeroed() };
    // SAFETY: never fails.
    let me = unsafe { libc::pthread_self() };
    // SAFETY: `attributes` lives across the call.
    if unsafe { libc::pthread_getattr_np(me, &raw mut attributes) } != 0 {
        return;
    }
    let (mut at, mut size) = (null_mut(), 0);
    // SAFETY: the attributes were just filled in; both places live across the call.
    let known =
        unsafe { libc::pthread_attr_getstack(&raw const attributes, &raw mut at, &raw mut size) };
    // SAFETY: filled in above.
    unsafe { libc::pthread_attr_destroy(&raw mut attributes) };
    if known != 0 {
        return;
    }
    // SAFETY: this thread's own stack; a refusal only means that pages may be pushed out.
    unsafe { libc::mlock(at, size) };
    let here = core::ptr::from_ref(&attributes).addr();
    let lowest = at.addr();
    // The stack below this frame, except for a page for the calls made here.
    let mut page = lowest;
    while page + 2 * PAGE < here {
        let byte = at.cast::<u8>().wrapping_add(page - lowest);
        // SAFETY: below the stack pointer, where nothing is kept, and within the stack.
        let value = unsafe { byte.read_volatile() };
        // SAFETY: as above; a write brings in a page of its own.
        unsafe { byte.write_volatile(value) };
        page += PAGE;
    }
}

/// Returns the numbers of locked and of present bytes of this process. Memory that the kernel
/// itself maps into every process counts as neither.
pub(crate) fn locked_and_present() -> Option<(u64, u64)> {
    std::fs::read_to_string("/proc/self/smaps").ok().map(|text| sums(&text))
}

fn sums(smaps: &str) -> (u64, u64) {
    let (mut locked, mut present, mut own) = (0, 0, 0);
    let mut of_kernel = false;
    for line in smaps.lines() {
        let mut words = line.split_ascii_whitespace();
        match words.next() {
            Some("Rss:") => own = words.next().and_then(|n| n.parse::<u64>().ok()).unwrap_or(0),
            Some("VmFlags:") if !of_kernel => {
                present += own;
                locked += if words.any(|flag| flag == "lo") { own } else { 0 };
            }
            Some(first) if !first.ends_with(':') => {
                of_kernel = ["[vvar]", "[vvar_vclock]", "[vdso]", "[vsyscall]"]
                    .iter()
                    .any(|name| line.ends_with(name));
            }
            _ => {}
        }
    }
    (locked << 10, present << 10)
}

#[cfg(test)]
mod tests {
    use super::{sums, usable};

    #[test]
    fn what_is_locked_is_counted_by_mapping() {
        let text = "\
55d0-55d8 r--p 00000000 08:01 131 /usr/bin/halrun
Size:                 32 kB
Rss:                  24 kB
VmFlags: rd mr mw me lo
7f00-7f80 ---p 00000000 00:00 0
Rss:                   0 kB
VmFlags: mr mw me nr
7f90-7fa0 rw-p 00000000 00:00 0 [heap]
Rss:                  40 kB
VmFlags: rd wr mr mw me ac
7ff0-7ff4 r-xp 00000000 00:00 0 [vdso]
Rss:                   8 kB
VmFlags: rd ex mr mw me de
";
        assert_eq!(sums(text), (24 << 10, 64 << 10));
        assert_eq!(sums(""), (0, 0));
    }

    #[test]
    fn mappings_that_may_be_locked() {
        for (line, want) in [
            ("1000-3000 rw-p 00000000 00:00 0 [heap]", Some((0x1000, 0x3000))),
            ("1000-3000 ---p 00000000 00:00 0", None),
            ("1000-3000 r--p 00000000 00:00 0 [vvar]", None),
            ("3000-1000 rw-p 00000000 00:00 0", None),
            ("", None),
        ] {
            assert_eq!(usable(line), want, "{line}");
        }
    }
}
