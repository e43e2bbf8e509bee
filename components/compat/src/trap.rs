//! Realtime. What the processor refuses: a port access that is to be simulated, or the end of the
//! process, with the component named and outputs at their safe levels.

use crate::running;
use core::{
    ffi::{CStr, c_int, c_void},
    mem::MaybeUninit,
    ptr,
};
use std::sync::{
    Once,
    atomic::{AtomicPtr, AtomicUsize, Ordering::Relaxed},
};

/// What ends a process.
const SIGNALS: [(c_int, &str); 5] = [
    (libc::SIGSEGV, "segmentation fault"),
    (libc::SIGBUS, "bus error"),
    (libc::SIGFPE, "arithmetic fault"),
    (libc::SIGILL, "illegal instruction"),
    (libc::SIGABRT, "it gave up (abort)"),
];

/// What was there before, by position in [`SIGNALS`].
static BEFORE: [AtomicPtr<libc::sigaction>; 5] = [const { AtomicPtr::new(ptr::null_mut()) }; 5];

/// The code of a fault that is no access to memory, such as an instruction that is not allowed.
const REFUSED: c_int = 0x80;

/// Stacks on which signals are attended to: a component may have used up its own.
const STACK: usize = 64 << 10;
const STACKS: usize = 256;
static FIRST_STACK: AtomicPtr<c_void> = AtomicPtr::new(ptr::null_mut());
static STACKS_TAKEN: AtomicUsize = AtomicUsize::new(0);

/// Watches for what ends a process, from now on.
pub(crate) fn watch() {
    static ONCE: Once = Once::new();
    ONCE.call_once(|| {
        let (prot, flags) =
            (libc::PROT_READ | libc::PROT_WRITE, libc::MAP_PRIVATE | libc::MAP_ANONYMOUS);
        // SAFETY: new memory.
        let stacks = unsafe {
            libc::mmap(ptr::null_mut(), STACK * STACKS, prot, flags | libc::MAP_NORESERVE, -1, 0)
        };
        if stacks != libc::MAP_FAILED {
            FIRST_STACK.store(stacks, Relaxed);
        }
        for ((signal, _), before) in SIGNALS.iter().zip(&BEFORE) {
            let mut old = MaybeUninit::<libc::sigaction>::zeroed();
            // SAFETY: all zero is a valid action.
            let mut new = unsafe { MaybeUninit::<libc::sigaction>::zeroed().assume_init() };
            new.sa_sigaction = attend as *const () as usize;
            new.sa_flags = libc::SA_SIGINFO | libc::SA_ONSTACK;
            // SAFETY: a valid action and a place for the old one.
            if unsafe { libc::sigaction(*signal, &raw const new, old.as_mut_ptr()) } == 0 {
                // SAFETY: filled by the system.
                let old = unsafe { old.assume_init() };
                before.store(Box::into_raw(Box::new(old)), Relaxed);
            }
        }
    });
}

/// From `shim.c`, once for each thread that runs a component's function: a stack for signals.
#[unsafe(no_mangle)]
extern "C" fn ferrule_prepare_thread() {
    let first = FIRST_STACK.load(Relaxed);
    let mine = STACKS_TAKEN.fetch_add(1, Relaxed);
    if first.is_null() || mine >= STACKS {
        return;
    }
    let stack =
        libc::stack_t { ss_sp: first.wrapping_byte_add(mine * STACK), ss_flags: 0, ss_size: STACK };
    // SAFETY: memory that is nobody else's.
    unsafe { libc::sigaltstack(&raw const stack, ptr::null_mut()) };
}

/// # Safety
/// Called by the system.
unsafe extern "C" fn attend(signal: c_int, info: *mut libc::siginfo_t, context: *mut c_void) {
    if running::module().is_none() {
        // Not in a component: as if this were not here.
        let position = SIGNALS.iter().position(|(s, _)| *s == signal).unwrap_or(0);
        let before = BEFORE.get(position).map_or(ptr::null_mut(), |b| b.load(Relaxed));
        // SAFETY: the action that was there, or the default.
        unsafe { libc::sigaction(signal, before, ptr::null_mut()) };
        return;
    }
    // SAFETY: the system's record.
    let refused = unsafe { info.as_ref() }.is_some_and(|i| i.si_code == REFUSED);
    if signal == libc::SIGSEGV && refused && port_access(context) {
        return;
    }
    report(signal, info);
    // SAFETY: ends the process, with its status.
    unsafe { libc::signal(signal, libc::SIG_DFL) };
    // SAFETY: as above.
    unsafe { libc::raise(signal) };
}

/// A signal in words.
pub(crate) fn named(signal: c_int) -> &'static str {
    SIGNALS.iter().find(|(s, _)| *s == signal).map_or("fault", |(_, name)| name)
}

/// Names the component, and drives outputs to their safe levels.
fn report(signal: c_int, info: *const libc::siginfo_t) {
    let Some(module) = running::module() else { return };
    // Whatever happens now, the process ends.
    // SAFETY: requests to the system.
    unsafe { libc::signal(libc::SIGALRM, libc::SIG_DFL) };
    // SAFETY: as above.
    unsafe { libc::alarm(2) };
    let what = named(signal);
    // SAFETY: the system's record.
    let address = unsafe { info.as_ref() }.map_or(0, |i| unsafe { i.si_addr() }.addr());
    let (mut digits, funct) = ([0; 16], running::funct());
    let funct = if funct.is_null() {
        c"?"
    } else {
        // SAFETY: the name of the function that runs.
        unsafe { CStr::from_ptr(funct) }
    };
    let (name, funct) = (module.name.to_str().unwrap_or("?"), funct.to_str().unwrap_or("?"));
    let at = hex(address, &mut digits);
    let at: &[&str] =
        if [libc::SIGSEGV, libc::SIGBUS].contains(&signal) { &[" at address 0x", at] } else { &[] };
    write_error(&["component '", name, "' (in C), function '", funct, "': ", what]);
    write_error(at);
    write_error(&["; outputs go to their safe levels, and this process ends\n"]);
    module.crash();
}

fn hex(mut n: usize, digits: &mut [u8; 16]) -> &str {
    let mut used = 0;
    for place in digits.iter_mut().rev() {
        let digit = u8::try_from(n & 15).unwrap_or(0);
        *place = if digit < 10 { b'0' + digit } else { b'a' + digit - 10 };
        (n, used) = (n >> 4, used + 1);
        if n == 0 {
            break;
        }
    }
    let text = digits.get(16 - used..).unwrap_or_default();
    core::str::from_utf8(text).unwrap_or("?")
}

/// Writes to standard error, from wherever.
pub(crate) fn write_error(parts: &[&str]) {
    for part in parts {
        // SAFETY: a live text.
        unsafe { libc::write(2, part.as_ptr().cast(), part.len()) };
    }
}

/// A port access of prebuilt code: carried out here, and stepped over.
#[cfg(target_arch = "x86_64")]
fn port_access(context: *mut c_void) -> bool {
    use crate::access;
    // SAFETY: the system's record of the thread.
    let Some(context) = (unsafe { context.cast::<libc::ucontext_t>().as_mut() }) else {
        return false;
    };
    let registers = &mut context.uc_mcontext.gregs;
    let index = |r: c_int| usize::try_from(r).unwrap_or(0);
    let (rip, rax, rdx) = (index(libc::REG_RIP), index(libc::REG_RAX), index(libc::REG_RDX));
    let (Some(at), Some(a), Some(d)) =
        (registers.get(rip).copied(), registers.get(rax).copied(), registers.get(rdx).copied())
    else {
        return false;
    };
    let code = ptr::with_exposed_provenance::<[u8; 3]>(usize::try_from(at).unwrap_or(0));
    if code.is_null() {
        return false;
    }
    // SAFETY: an instruction that the processor has read and refused, at the end of a page at worst
    // with nothing behind it: then the fault ends the process, as it would have.
    let bytes = unsafe { code.read_unaligned() };
    let Some(access) = PortAccess::decode(bytes, d.cast_unsigned()) else { return false };
    let simulated = running::module().is_some_and(crate::module::Module::is_simulated);
    if !simulated {
        return access::hardware::permit_here(access.port, access.width);
    }
    let a = a.cast_unsigned();
    let mask = if access.width == 4 { u64::MAX } else { (1 << (access.width * 8)) - 1 };
    if access.out {
        let [w, x, y, z, ..] = a.to_le_bytes();
        access::write(access.port, access.width, u32::from_le_bytes([w, x, y, z]));
    } else {
        let value = u64::from(access::read(access.port, access.width));
        if let Some(place) = registers.get_mut(rax) {
            *place = (a & !mask | value & mask).cast_signed();
        }
    }
    if let Some(place) = registers.get_mut(rip) {
        *place = at.wrapping_add(access.length);
    }
    true
}

/// Other processors have no such ports.
#[cfg(not(target_arch = "x86_64"))]
fn port_access(_context: *mut c_void) -> bool {
    false
}

/// An `in` or `out` instruction.
#[cfg(target_arch = "x86_64")]
#[derive(Debug, PartialEq, Eq)]
struct PortAccess {
    out: bool,
    port: u16,
    width: u16,
    length: i64,
}

#[cfg(target_arch = "x86_64")]
impl PortAccess {
    fn decode(bytes: [u8; 3], dx: u64) -> Option<Self> {
        let [first, second, third] = bytes;
        let (short, code, next) =
            if first == 0x66 { (1, second, third) } else { (0, first, second) };
        let wide = if short == 1 { 2 } else { 4 };
        let width = if code & 1 == 0 { 1 } else { wide };
        let out = code & 2 != 0;
        let [low, high, ..] = dx.to_le_bytes();
        match code {
            0xE4..=0xE7 => Some(Self { out, port: u16::from(next), width, length: 2 + short }),
            0xEC..=0xEF => {
                let port = u16::from_le_bytes([low, high]);
                Some(Self { out, port, width, length: 1 + short })
            }
            _ => None,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::hex;

    #[test]
    fn addresses_in_hexadecimal() {
        for n in [0, 8, 0xdead_beef, usize::MAX] {
            assert_eq!(hex(n, &mut [0; 16]), format!("{n:x}"));
        }
    }

    #[cfg(target_arch = "x86_64")]
    #[test]
    fn port_instructions_are_known() {
        use super::PortAccess;
        let a = |out, port, width, length| Some(PortAccess { out, port, width, length });
        let dx = 0xFFFF_0378;
        for (bytes, access) in [
            ([0xEC, 0, 0], a(false, 0x378, 1, 1)),
            ([0xED, 0, 0], a(false, 0x378, 4, 1)),
            ([0x66, 0xED, 0], a(false, 0x378, 2, 2)),
            ([0xEE, 0, 0], a(true, 0x378, 1, 1)),
            ([0xEF, 0, 0], a(true, 0x378, 4, 1)),
            ([0x66, 0xEF, 0], a(true, 0x378, 2, 2)),
            ([0xE4, 0x61, 0], a(false, 0x61, 1, 2)),
            ([0x66, 0xE7, 0x61], a(true, 0x61, 2, 3)),
            ([0x90, 0xEC, 0], None),
        ] {
            assert_eq!(PortAccess::decode(bytes, dx), access, "{bytes:x?}");
        }
    }
}
