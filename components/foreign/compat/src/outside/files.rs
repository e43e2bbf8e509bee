//! Files that a module may read in simulation: ordinary files, and nothing that is a device or the kernel.
//!
//! Tables and settings are read by modules without hardware too, and a read of an ordinary file changes nothing. A write
//! does. A device acts as soon as it is opened (a serial port raises a line), and files of the kernel are devices by
//! other names: a read in `/sys` can read a pin or a register of a card.

use core::{
    ffi::{CStr, c_char, c_int},
    mem::MaybeUninit,
};

/// File systems whose files are the kernel's: `proc`, `sysfs`, `debugfs`, `tracefs`, `configfs`, `securityfs`,
/// `efivarfs`, `cgroup` and its second version.
const OF_THE_KERNEL: [i64; 9] = [
    0x9fa0,
    0x6265_6572,
    0x6462_6720,
    0x7472_6163,
    0x6265_6570,
    0x7363_6673,
    0xde5e_81e4,
    0x27_e0eb,
    0x6367_7270,
];

/// Devices that hold nothing: `/dev/null` and `/dev/zero`.
const EMPTY: [(u32, u32); 2] = [(1, 3), (1, 5)];

/// Returns whether `open` with these flags only reads an ordinary file. What does not exist, or may not be read, counts
/// as one: the system then says what is wrong.
pub(super) fn may_open(folder: c_int, path: *const c_char, flags: c_int) -> bool {
    let makes = libc::O_CREAT | libc::O_TRUNC | (libc::O_TMPFILE & !libc::O_DIRECTORY);
    let reads = flags & libc::O_ACCMODE == libc::O_RDONLY && flags & makes == 0;
    if path.is_null() {
        return true;
    }
    // A descriptor of this kind opens no device.
    // SAFETY: the module passes a C string.
    let fd = unsafe { libc::openat(folder, path, libc::O_PATH | libc::O_CLOEXEC) };
    if fd < 0 {
        return reads;
    }
    let allowed = may_use(fd, reads);
    // SAFETY: opened above, closed once.
    unsafe { libc::close(fd) };
    allowed
}

/// Returns whether `fopen` in this mode only reads an ordinary file.
pub(super) fn may_fopen(path: *const c_char, mode: *const c_char) -> bool {
    if mode.is_null() {
        return true;
    }
    // SAFETY: the module passes a C string.
    let mode = unsafe { CStr::from_ptr(mode) }.to_bytes();
    let reads = mode.first() == Some(&b'r') && !mode.contains(&b'+');
    may_open(libc::AT_FDCWD, path, if reads { libc::O_RDONLY } else { libc::O_RDWR })
}

/// Returns whether the memory of this file may be mapped: the module could open the file only to read it.
pub(super) fn may_map(fd: c_int) -> bool {
    may_use(fd, true)
}

fn may_use(fd: c_int, reads: bool) -> bool {
    let mut about = MaybeUninit::<libc::stat>::zeroed();
    // SAFETY: memory for the answer.
    if unsafe { libc::fstat(fd, about.as_mut_ptr()) } != 0 {
        return true;
    }
    // SAFETY: filled by the system.
    let about = unsafe { about.assume_init() };
    match about.st_mode & libc::S_IFMT {
        libc::S_IFCHR => EMPTY.contains(&(libc::major(about.st_rdev), libc::minor(about.st_rdev))),
        libc::S_IFREG => reads && !is_of_the_kernel(fd),
        libc::S_IFDIR => reads,
        _ => false,
    }
}

fn is_of_the_kernel(fd: c_int) -> bool {
    let mut about = MaybeUninit::<libc::statfs>::zeroed();
    // SAFETY: memory for the answer.
    if unsafe { libc::fstatfs(fd, about.as_mut_ptr()) } != 0 {
        return true;
    }
    // SAFETY: filled by the system.
    let about = unsafe { about.assume_init() };
    OF_THE_KERNEL.contains(&about.f_type)
}
