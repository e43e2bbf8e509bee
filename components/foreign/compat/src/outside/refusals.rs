//! Functions that reach outside, and what takes their place in simulation: each fails as a system without it would, with
//! "Operation not permitted".

use super::{files, tried::note};
use core::{
    ffi::{CStr, c_char, c_int, c_long, c_void},
    ptr,
};

/// Function that reaches outside.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Redirect {
    pub(crate) name: &'static str,
    /// Function that takes its place.
    pub(crate) with: *const c_void,
}

/// Functions by the kind of what they reach, as the page of the folder shows it.
type Kinds = &'static [(&'static str, &'static [Redirect])];

/// Makes rows of functions that are always refused, by the answer that they give.
macro_rules! refused {
    ($($kind:literal { $($answer:expr => $($name:ident)*;)* })*) => {
        &[$(($kind, &[$($({
            extern "C" fn refusal() -> isize {
                note(stringify!($name), "");
                fail();
                $answer
            }
            Redirect { name: stringify!($name), with: refusal as *const c_void }
        },)*)*]),)*]
    };
}

/// Makes rows of functions that serve what stays inside, and refuse the rest.
macro_rules! chosen {
    ($($kind:literal { $($code:path => $($name:ident)*;)* })*) => {
        &[$(($kind, &[$($(
            Redirect { name: stringify!($name), with: $code as *const c_void },
        )*)*]),)*]
    };
}

/// Error number of every refusal.
const REFUSED: isize = libc::EPERM as isize;

/// Answers: -1 or a null pointer with `errno`, an error number, an error of name resolution, nothing.
const MINUS_ONE: isize = -1;
const NULL: isize = 0;
const CODE: isize = REFUSED;
const NO_NAME: isize = libc::EAI_FAIL as isize;

/// Functions that are always refused.
const REFUSALS: Kinds = refused! {
    "network" {
        MINUS_ONE => socket socketpair connect bind listen accept accept4 send sendto sendmsg sendmmsg
            recv recvfrom recvmsg recvmmsg __recv_chk __recvfrom_chk getifaddrs
            res_query res_search res_send rcmd rcmd_af rexec rexec_af rresvport rresvport_af;
        NO_NAME => getaddrinfo getaddrinfo_a getnameinfo;
        CODE => gethostbyname_r gethostbyname2_r gethostbyaddr_r;
        NULL => gethostbyname gethostbyname2 gethostbyaddr if_nametoindex if_indextoname if_nameindex
            syslog vsyslog __syslog_chk __vsyslog_chk;
    }
    "files" {
        MINUS_ONE => creat creat64 mkstemp mkstemp64 mkostemp mkostemp64 mkstemps mkstemps64 mkostemps mkostemps64
            open_by_handle_at truncate truncate64 unlink unlinkat remove rename renameat renameat2 link linkat
            symlink symlinkat mkdir mkdirat rmdir mknod mknodat mkfifo mkfifoat chmod fchmodat chown lchown fchownat
            utime utimes lutimes utimensat futimesat lchmod __xmknod __xmknodat setxattr lsetxattr removexattr lremovexattr mount umount umount2
            swapon swapoff fsopen open_tree move_mount chroot pivot_root acct quotactl;
        NULL => freopen freopen64 tmpfile tmpfile64 mkdtemp;
    }
    "devices" {
        MINUS_ONE => ioctl tcsetattr tcsendbreak tcdrain tcflush tcflow posix_openpt getpt openpty login_tty
            iopl ioperm clock_settime settimeofday adjtime adjtimex ntp_adjtime clock_adjtime reboot
            init_module delete_module sethostname setdomainname;
    }
    "memory" {
        MINUS_ONE => shm_open shm_unlink shmget shmat msgget semget mq_open process_vm_readv process_vm_writev ptrace;
        NULL => sem_open;
    }
    "programs" {
        MINUS_ONE => fork vfork _Fork clone daemon forkpty execve execv execvp execvpe execl execlp execle execveat
            fexecve system killpg tgkill sigqueue pidfd_open pidfd_getfd pidfd_send_signal unshare setns;
        CODE => posix_spawn posix_spawnp wordexp;
        NULL => popen;
    }
};

/// Functions that are refused by what they are called with.
const CHOICES: Kinds = chosen! {
    "files" {
        open => open open64 __open_2 __open64_2;
        openat => openat openat64 __openat_2 __openat64_2;
        fopen => fopen fopen64;
    }
    "memory" {
        mmap => mmap mmap64;
    }
    "programs" {
        kill => kill;
    }
    "other ways" {
        syscall => syscall;
        dlopen => dlopen;
        dlmopen => dlmopen;
        dlsym => dlsym;
        dlvsym => dlvsym;
    }
};

/// Returns all rows.
pub(crate) fn rows() -> impl Iterator<Item = &'static Redirect> {
    REFUSALS.iter().chain(CHOICES).flat_map(|(_, rows)| rows.iter())
}

/// Returns what takes the place of a function in simulation. Some functions have a second name with two underscores.
pub(crate) fn find(name: &CStr) -> Option<*const c_void> {
    let name = name.to_str().ok()?;
    let find = |name: &str| rows().find(|row| row.name == name).map(|row| row.with);
    find(name).or_else(|| find(name.strip_prefix("__")?))
}

/// Sets `errno`.
fn fail() {
    crate::access::hardware::refused(libc::EPERM);
}

fn shown<'t>(text: *const c_char) -> &'t str {
    crate::pin::text(text).unwrap_or_default()
}

extern "C" fn open(path: *const c_char, flags: c_int) -> c_int {
    openat(libc::AT_FDCWD, path, flags)
}

extern "C" fn openat(folder: c_int, path: *const c_char, flags: c_int) -> c_int {
    if files::may_open(folder, path, flags) {
        // SAFETY: the module's own call, which creates no file.
        return unsafe { libc::openat(folder, path, flags) };
    }
    note("open", shown(path));
    fail();
    -1
}

extern "C" fn fopen(path: *const c_char, mode: *const c_char) -> *mut libc::FILE {
    if files::may_fopen(path, mode) {
        // SAFETY: the module's own call.
        return unsafe { libc::fopen(path, mode) };
    }
    note("fopen", shown(path));
    fail();
    ptr::null_mut()
}

extern "C" fn mmap(
    at: *mut c_void,
    size: usize,
    protection: c_int,
    flags: c_int,
    fd: c_int,
    offset: i64,
) -> *mut c_void {
    if flags & libc::MAP_ANONYMOUS != 0 || files::may_map(fd) {
        // SAFETY: the module's own call.
        return unsafe { libc::mmap(at, size, protection, flags, fd, offset) };
    }
    note("mmap", "");
    fail();
    libc::MAP_FAILED
}

extern "C" fn kill(process: libc::pid_t, signal: c_int) -> c_int {
    // SAFETY: queries a number.
    if process == unsafe { libc::getpid() } {
        // SAFETY: the module's own call.
        return unsafe { libc::kill(process, signal) };
    }
    note("kill", "");
    fail();
    -1
}

/// System calls that stay inside the process.
const INSIDE: &[c_long] = &[
    libc::SYS_clock_getres,
    libc::SYS_clock_gettime,
    libc::SYS_clock_nanosleep,
    libc::SYS_futex,
    libc::SYS_getcpu,
    libc::SYS_getpid,
    libc::SYS_getrandom,
    libc::SYS_gettid,
    libc::SYS_gettimeofday,
    libc::SYS_getuid,
    libc::SYS_membarrier,
    libc::SYS_nanosleep,
    libc::SYS_sched_getaffinity,
    libc::SYS_sched_yield,
];

extern "C" fn syscall(
    number: c_long,
    a: c_long,
    b: c_long,
    c: c_long,
    d: c_long,
    e: c_long,
    f: c_long,
) -> c_long {
    if INSIDE.contains(&number) {
        // SAFETY: the module's own call; arguments that it did not pass are not read.
        return unsafe { libc::syscall(number, a, b, c, d, e, f) };
    }
    note("syscall", "");
    fail();
    -1
}

extern "C" fn dlopen(path: *const c_char, flags: c_int) -> *mut c_void {
    if path.is_null() {
        // SAFETY: a handle of the program itself.
        return unsafe { libc::dlopen(path, flags) };
    }
    note("dlopen", shown(path));
    // Sets the text of `dlerror`.
    let refused = c"/a component in C opens no library under --virtual and --simulate";
    // SAFETY: a C string; there is no such file.
    unsafe { libc::dlopen(refused.as_ptr(), libc::RTLD_NOW) };
    fail();
    ptr::null_mut()
}

extern "C" fn dlmopen(_space: c_long, path: *const c_char, flags: c_int) -> *mut c_void {
    dlopen(path, flags)
}

extern "C" fn dlsym(handle: *mut c_void, name: *const c_char) -> *mut c_void {
    if let Some(with) = named(name) {
        return with;
    }
    // SAFETY: the module's own call.
    unsafe { libc::dlsym(handle, name) }
}

extern "C" fn dlvsym(
    handle: *mut c_void,
    name: *const c_char,
    version: *const c_char,
) -> *mut c_void {
    if let Some(with) = named(name) {
        return with;
    }
    // SAFETY: the module's own call.
    unsafe { libc::dlvsym(handle, name, version) }
}

fn named(name: *const c_char) -> Option<*mut c_void> {
    if name.is_null() {
        return None;
    }
    // SAFETY: the module passes a C string.
    find(unsafe { CStr::from_ptr(name) }).map(<*const c_void>::cast_mut)
}

#[cfg(test)]
mod tests {
    use super::{CHOICES, REFUSALS, find, rows};
    use std::{collections::BTreeSet, ffi::CString, fmt::Write, path::Path};

    #[test]
    fn every_name_is_there_once() {
        let names: Vec<&str> = rows().map(|row| row.name).collect();
        assert_eq!(names.iter().collect::<BTreeSet<_>>().len(), names.len());
        for name in names.iter().copied().chain(["__open", "__connect", "__send"]) {
            assert!(find(&CString::new(name).unwrap()).is_some(), "{name}");
        }
        for name in [c"printf", c"read", c"close", c"pthread_create", c"__", c""] {
            assert!(find(name).is_none(), "{name:?}");
        }
    }

    /// The page of the folder lists every function.
    #[test]
    fn the_page_lists_them() {
        let page = Path::new(env!("CARGO_MANIFEST_DIR")).join("../README.md");
        let page = std::fs::read_to_string(page).unwrap();
        let mut table = String::from("| kind | functions |\n|---|---|\n");
        for kind in ["network", "files", "devices", "memory", "programs", "other ways"] {
            let kinds = REFUSALS.iter().chain(CHOICES).filter(|(of, _)| *of == kind);
            let mut names: Vec<&str> =
                kinds.flat_map(|(_, rows)| rows.iter().map(|row| row.name)).collect();
            names.sort_unstable();
            writeln!(table, "| {kind} | `{}` |", names.join("` `")).unwrap();
        }
        assert!(page.contains(&table), "the table is to be:\n{table}");
    }
}
