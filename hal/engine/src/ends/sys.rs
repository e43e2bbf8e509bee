//! System calls for the end of a process. Every function here may be called in a signal handler.

use core::{
    ffi::{CStr, c_int, c_void},
    ptr::{null, null_mut},
};

/// Code address and stack pointer at the moment of an event.
#[derive(Clone, Copy, Debug)]
pub(super) struct Registers {
    pub(super) code: usize,
    pub(super) stack: usize,
}

/// Opens a file for reading.
pub(super) fn open_read(path: &CStr) -> Option<c_int> {
    // SAFETY: a text that ends in zero.
    let file = unsafe { libc::open(path.as_ptr(), libc::O_RDONLY | libc::O_CLOEXEC) };
    (file >= 0).then_some(file)
}

/// Reads into `bytes`. Returns the number of bytes, 0 at the end and on an error.
pub(super) fn read(file: c_int, bytes: &mut [u8]) -> usize {
    loop {
        // SAFETY: a live buffer.
        let n = unsafe { libc::read(file, bytes.as_mut_ptr().cast(), bytes.len()) };
        if n >= 0 || errno() != libc::EINTR {
            return usize::try_from(n).unwrap_or(0);
        }
    }
}

/// Closes a file.
pub(super) fn close(file: c_int) {
    // SAFETY: a number; it is not used again.
    unsafe { libc::close(file) };
}

/// Writes to standard error. Errors are ignored, and so is a reader that does not read: there is no
/// one left to report them to.
pub(crate) fn report(text: &str) {
    let mut rest = text.as_bytes();
    while !rest.is_empty() {
        let mut look = libc::pollfd { fd: libc::STDERR_FILENO, events: libc::POLLOUT, revents: 0 };
        // SAFETY: a live record.
        if unsafe { libc::poll(&raw mut look, 1, 100) } == 0 {
            return;
        }
        // SAFETY: a live text.
        let n = unsafe { libc::write(libc::STDERR_FILENO, rest.as_ptr().cast(), rest.len()) };
        match usize::try_from(n) {
            Ok(n) if n > 0 => rest = rest.get(n..).unwrap_or_default(),
            _ if errno() == libc::EINTR => {}
            _ => return,
        }
    }
}

fn errno() -> c_int {
    // SAFETY: this thread's own variable.
    let place = unsafe { libc::__errno_location() };
    // SAFETY: as above.
    unsafe { place.read() }
}

/// Runs `act` in a signal handler without changing the `errno` of the interrupted code.
pub(super) fn unseen(act: impl FnOnce()) {
    let before = errno();
    act();
    // SAFETY: this thread's own variable.
    let place = unsafe { libc::__errno_location() };
    // SAFETY: as above.
    unsafe { place.write(before) };
}

/// Returns the process ID.
pub(super) fn process() -> c_int {
    // SAFETY: always answers.
    unsafe { libc::getpid() }
}

/// Returns the thread ID.
pub(super) fn thread() -> c_int {
    // SAFETY: always answers.
    unsafe { libc::gettid() }
}

/// Returns the name of this thread.
pub(super) fn thread_name(room: &mut [u8; 16]) -> &str {
    // SAFETY: 16 bytes are what the system wants.
    unsafe { libc::prctl(libc::PR_GET_NAME, room.as_mut_ptr()) };
    let end = room.iter().position(|b| *b == 0).unwrap_or(room.len());
    core::str::from_utf8(room.get(..end).unwrap_or_default()).unwrap_or("?")
}

/// Sleeps for at most `ms` milliseconds.
pub(super) fn nap(ms: i64) {
    let time = libc::timespec { tv_sec: ms / 1000, tv_nsec: ms % 1000 * 1_000_000 };
    // SAFETY: `time` lives across the call.
    unsafe { libc::nanosleep(&raw const time, null_mut()) };
}

/// Removes a file.
pub(super) fn remove(path: &CStr) {
    // SAFETY: a text that ends in zero.
    unsafe { libc::unlink(path.as_ptr()) };
}

/// Copies words of this process's memory. Returns the number of words that could be read.
pub(super) fn peek(from: usize, words: &mut [usize]) -> usize {
    let local = libc::iovec { iov_base: words.as_mut_ptr().cast(), iov_len: size_of_val(words) };
    let base = core::ptr::without_provenance_mut(from);
    let remote = libc::iovec { iov_base: base, iov_len: size_of_val(words) };
    // SAFETY: the system checks the address that it reads; the words are a live buffer.
    let n =
        unsafe { libc::process_vm_readv(process(), &raw const local, 1, &raw const remote, 1, 0) };
    usize::try_from(n).unwrap_or(0) / size_of::<usize>()
}

/// Ends this process at once, without regard to its other threads.
pub(super) fn leave(status: c_int) -> ! {
    loop {
        // SAFETY: nothing of this process is left to look after.
        unsafe { libc::syscall(libc::SYS_exit_group, status) };
    }
}

/// Ends this process by a signal with its default action.
pub(super) fn die(signal: c_int) -> ! {
    set_default(signal);
    let mut only = empty_set();
    add(&mut only, signal);
    // SAFETY: a live set.
    unsafe { libc::pthread_sigmask(libc::SIG_UNBLOCK, &raw const only, null_mut()) };
    // SAFETY: ends the process.
    unsafe { libc::raise(signal) };
    // The default action is to ignore this signal.
    leave(128 + signal)
}

/// Restores the default action of a signal.
pub(super) fn set_default(signal: c_int) {
    // SAFETY: the default is always valid.
    unsafe { libc::signal(signal, libc::SIG_DFL) };
}

/// Arranges that the process ends after `seconds`, if it still exists then.
pub(super) fn end_in(seconds: u32) {
    set_default(libc::SIGALRM);
    // SAFETY: a request to the system.
    unsafe { libc::alarm(seconds) };
}

/// Returns the empty set of signals.
pub(super) fn empty_set() -> libc::sigset_t {
    // SAFETY: all zero is a valid set.
    let mut set = unsafe { core::mem::zeroed() };
    // SAFETY: a live set.
    unsafe { libc::sigemptyset(&raw mut set) };
    set
}

/// Maps new memory that is shared with forked copies of this process; null if there is none.
pub(super) fn shared(bytes: usize) -> *mut c_void {
    let (prot, flags) = (
        libc::PROT_READ | libc::PROT_WRITE,
        libc::MAP_SHARED | libc::MAP_ANONYMOUS | libc::MAP_NORESERVE,
    );
    // SAFETY: new memory.
    let at = unsafe { libc::mmap(null_mut(), bytes, prot, flags, -1, 0) };
    if at == libc::MAP_FAILED { null_mut() } else { at }
}

/// Signal handler.
pub(super) type Attends = unsafe extern "C" fn(c_int, *mut libc::siginfo_t, *mut c_void);

/// Installs a handler for a signal.
pub(super) fn attend(signal: c_int, attends: Attends, flags: c_int) {
    let mut action = no_action();
    action.sa_sigaction = attends as *const () as usize;
    action.sa_flags = flags;
    // SAFETY: a valid action. A signal that cannot be caught keeps its own effect.
    unsafe { libc::sigaction(signal, &raw const action, null_mut()) };
}

/// Returns whether a signal is ignored.
pub(super) fn is_ignored(signal: c_int) -> bool {
    let mut now = no_action();
    // SAFETY: a place for the action.
    unsafe { libc::sigaction(signal, null(), &raw mut now) };
    now.sa_sigaction == libc::SIG_IGN
}

fn no_action() -> libc::sigaction {
    // SAFETY: all zero is a valid action.
    unsafe { core::mem::zeroed() }
}

/// Adds a signal to a set.
pub(super) fn add(set: &mut libc::sigset_t, signal: c_int) {
    // SAFETY: a live set.
    unsafe { libc::sigaddset(set, signal) };
}

/// Blocks these signals in this thread.
pub(super) fn block(set: &libc::sigset_t) {
    // SAFETY: a live set.
    unsafe { libc::pthread_sigmask(libc::SIG_BLOCK, set, null_mut()) };
}

/// Returns where a thread was when a signal arrived, and the value of its register DX.
#[cfg(target_arch = "x86_64")]
pub(super) fn place(context: *mut c_void) -> (Registers, u64) {
    // SAFETY: the system's record of the thread.
    let context = unsafe { context.cast::<libc::ucontext_t>().as_ref() };
    let register = |which: c_int| {
        let registers = context.map(|c| &c.uc_mcontext.gregs);
        let value = registers.and_then(|r| r.get(usize::try_from(which).unwrap_or(0)));
        value.copied().unwrap_or(0).cast_unsigned()
    };
    let address = |which| usize::try_from(register(which)).unwrap_or(0);
    let place = Registers { code: address(libc::REG_RIP), stack: address(libc::REG_RSP) };
    (place, register(libc::REG_RDX))
}

/// Returns where a thread was when a signal arrived.
#[cfg(target_arch = "aarch64")]
pub(super) fn place(context: *mut c_void) -> (Registers, u64) {
    // SAFETY: the system's record of the thread.
    let context = unsafe { context.cast::<libc::ucontext_t>().as_ref() };
    let at = |value: Option<u64>| usize::try_from(value.unwrap_or(0)).unwrap_or(0);
    let code = at(context.map(|c| c.uc_mcontext.pc));
    (Registers { code, stack: at(context.map(|c| c.uc_mcontext.sp)) }, 0)
}

/// Unknown on other processors.
#[cfg(not(any(target_arch = "x86_64", target_arch = "aarch64")))]
pub(super) fn place(_: *mut c_void) -> (Registers, u64) {
    (Registers { code: 0, stack: 0 }, 0)
}

/// Returns the port that the instruction at this address accesses, and whether it writes; `None`
/// for other instructions.
pub(super) fn port_at(code: usize, dx: u64) -> Option<(u16, bool)> {
    let mut bytes = [0];
    let read = peek(code, &mut bytes);
    if read == 0 || !cfg!(target_arch = "x86_64") {
        return None;
    }
    let [first, second, third, ..] = bytes.first()?.to_le_bytes();
    let (operation, port) = if first == 0x66 { (second, third) } else { (first, second) };
    let [low, high, ..] = dx.to_le_bytes();
    match operation {
        0xE4..=0xE7 => Some((u16::from(port), operation & 2 != 0)),
        0xEC..=0xEF => Some((u16::from_le_bytes([low, high]), operation & 2 != 0)),
        _ => None,
    }
}

/// Raises SIGABRT as the C library does, with its current handler, and then ends by it.
pub(super) fn abort() -> ! {
    let mut only = empty_set();
    add(&mut only, libc::SIGABRT);
    // SAFETY: a live set.
    unsafe { libc::pthread_sigmask(libc::SIG_UNBLOCK, &raw const only, null_mut()) };
    // SAFETY: a signal to this thread.
    unsafe { libc::raise(libc::SIGABRT) };
    die(libc::SIGABRT)
}

/// Returns an address near this thread's stack pointer.
pub(super) fn stack() -> usize {
    let here = 0_u8;
    (&raw const here).addr()
}

/// Creates a descriptor that becomes readable by [`wake`] and stays so; -1 if the system refuses.
pub(super) fn waker() -> c_int {
    // SAFETY: a request to the system.
    unsafe { libc::eventfd(0, libc::EFD_CLOEXEC | libc::EFD_NONBLOCK) }
}

/// Makes the descriptor of [`waker`] readable.
pub(super) fn wake(waker: c_int) {
    let one = 1_u64;
    // SAFETY: a live number.
    unsafe { libc::write(waker, (&raw const one).cast(), size_of::<u64>()) };
}

/// Waits until the descriptor of [`waker`] is readable, at most `ms` milliseconds.
pub(super) fn wait(waker: c_int, ms: c_int) {
    let mut look = libc::pollfd { fd: waker, events: libc::POLLIN, revents: 0 };
    // SAFETY: a live record.
    unsafe { libc::poll(&raw mut look, 1, ms) };
}

/// Separate signal stack of a thread, since code of the thread may have used up its normal stack.
#[derive(Debug)]
pub(crate) struct Stack(*mut c_void);

impl Stack {
    const BYTES: usize = 64 << 10;

    /// Installs a signal stack for this thread, until the value is dropped.
    pub(crate) fn new() -> Self {
        let (prot, flags) =
            (libc::PROT_READ | libc::PROT_WRITE, libc::MAP_PRIVATE | libc::MAP_ANONYMOUS);
        // SAFETY: new memory.
        let at = unsafe { libc::mmap(null_mut(), Self::BYTES, prot, flags, -1, 0) };
        if at == libc::MAP_FAILED {
            return Self(null_mut());
        }
        let stack = libc::stack_t { ss_sp: at, ss_flags: 0, ss_size: Self::BYTES };
        // SAFETY: memory that nothing else uses.
        unsafe { libc::sigaltstack(&raw const stack, null_mut()) };
        Self(at)
    }
}

impl Drop for Stack {
    fn drop(&mut self) {
        if self.0.is_null() {
            return;
        }
        let none = libc::stack_t { ss_sp: null_mut(), ss_flags: libc::SS_DISABLE, ss_size: 0 };
        // SAFETY: no signal handler runs on it.
        unsafe { libc::sigaltstack(&raw const none, null_mut()) };
        // SAFETY: mapped by `new`, and no longer in use.
        unsafe { libc::munmap(self.0, Self::BYTES) };
    }
}
