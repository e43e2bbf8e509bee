//! Counts the calls of `malloc`, `calloc`, `realloc`, `free` and related functions by threads that
//! run HAL threads, for all libraries of a process, since every library's own allocator calls
//! these.
//!
//! Loaded before the C library with `LD_PRELOAD`. `hal_interpose_count` starts and stops counting,
//! and `hal_interpose_counted` returns the count.

use core::{
    cell::Cell,
    ffi::{c_char, c_int, c_void},
    sync::atomic::{AtomicBool, AtomicU64, Ordering::SeqCst},
};

unsafe extern "C" {
    fn __libc_malloc(size: usize) -> *mut c_void;
    fn __libc_calloc(n: usize, size: usize) -> *mut c_void;
    fn __libc_realloc(p: *mut c_void, size: usize) -> *mut c_void;
    fn __libc_memalign(align: usize, size: usize) -> *mut c_void;
    fn __libc_free(p: *mut c_void);
    fn backtrace(frames: *mut *mut c_void, most: c_int) -> c_int;
    fn backtrace_symbols_fd(frames: *const *mut c_void, count: c_int, fd: c_int);
    fn prctl(option: c_int, name: *mut c_char, ...) -> c_int;
}

const PR_GET_NAME: c_int = 16;
/// The name that the engine gives to its threads.
const NAME: &[u8] = b"hal-thread\0";

static COUNTING: AtomicBool = AtomicBool::new(false);
static CALLS: AtomicU64 = AtomicU64::new(0);

#[derive(Clone, Copy)]
enum Who {
    Unknown,
    Realtime,
    Other,
}

thread_local! {
    // A variable without destructor, in the memory that a thread has from its start: it allocates
    // nothing.
    static WHO: Cell<Who> = const { Cell::new(Who::Unknown) };
}

/// Returns whether this thread runs HAL threads. Such a thread has its name before it runs any code
/// of the engine.
fn is_realtime() -> bool {
    WHO.with(|who| {
        if matches!(who.get(), Who::Unknown) {
            let mut name = [0_u8; 16];
            // SAFETY: the kernel writes at most 16 bytes.
            unsafe { prctl(PR_GET_NAME, name.as_mut_ptr().cast()) };
            who.set(if name.starts_with(NAME) { Who::Realtime } else { Who::Other });
        }
        matches!(who.get(), Who::Realtime)
    })
}

/// Number of calls whose stacks are printed to standard error.
const SHOWN: u64 = 3;

fn note() {
    if COUNTING.load(SeqCst) && is_realtime() && CALLS.fetch_add(1, SeqCst) < SHOWN {
        show();
    }
}

/// Prints the stack of this thread: the library and the address of each caller.
fn show() {
    let mut frames = [core::ptr::null_mut(); 40];
    // SAFETY: room for as many frames, of which so many are read.
    unsafe {
        let count = backtrace(frames.as_mut_ptr(), 40);
        backtrace_symbols_fd(frames.as_ptr(), count, 2);
    }
}

/// Resets and starts the counter, or stops it.
#[unsafe(no_mangle)]
pub extern "C" fn hal_interpose_count(on: bool) {
    // The first call loads a library.
    let mut frame = core::ptr::null_mut();
    // SAFETY: room for one frame.
    unsafe { backtrace(&raw mut frame, 1) };
    CALLS.store(0, SeqCst);
    COUNTING.store(on, SeqCst);
}

/// Returns the number of counted calls.
#[unsafe(no_mangle)]
pub extern "C" fn hal_interpose_counted() -> u64 {
    CALLS.load(SeqCst)
}

macro_rules! interpose {
    ($($name:ident($($arg:ident: $ty:ty),*) $(-> $out:ty)? = $code:expr;)*) => {$(
        /// The C library's function, counted.
        ///
        /// # Safety
        /// As for the C library's function.
        #[unsafe(no_mangle)]
        pub unsafe extern "C" fn $name($($arg: $ty),*) $(-> $out)? {
            note();
            // SAFETY: the C library's own function, with the caller's promises.
            unsafe { $code }
        }
    )*};
}

interpose! {
    malloc(size: usize) -> *mut c_void = __libc_malloc(size);
    calloc(n: usize, size: usize) -> *mut c_void = __libc_calloc(n, size);
    realloc(p: *mut c_void, size: usize) -> *mut c_void = __libc_realloc(p, size);
    memalign(align: usize, size: usize) -> *mut c_void = __libc_memalign(align, size);
    aligned_alloc(align: usize, size: usize) -> *mut c_void = __libc_memalign(align, size);
    free(p: *mut c_void) = __libc_free(p);
}

const ENOMEM: c_int = 12;

/// The C library's function, counted.
///
/// # Safety
/// As for the C library's function.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn posix_memalign(out: *mut *mut c_void, align: usize, size: usize) -> c_int {
    note();
    // SAFETY: as the C library has it.
    let p = unsafe { __libc_memalign(align, size) };
    if p.is_null() {
        return ENOMEM;
    }
    // SAFETY: the caller's place.
    unsafe { out.write(p) };
    0
}
