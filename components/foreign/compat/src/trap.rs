//! Realtime. Emulation of port accesses that the processor refuses. All other faults go to the previous handler: the
//! engine's, which names the component and drives outputs to their safe levels.

use crate::running;
use core::{
    ffi::{c_int, c_void},
    mem::MaybeUninit,
    ptr,
};
use std::sync::{
    Once,
    atomic::{AtomicPtr, Ordering::Relaxed},
};

/// Previous handler.
static BEFORE: AtomicPtr<libc::sigaction> = AtomicPtr::new(ptr::null_mut());

/// Code of a fault that is not a memory access, such as a privileged instruction.
const REFUSED: c_int = 0x80;

/// Installs the fault handler, once.
pub(crate) fn watch() {
    static ONCE: Once = Once::new();
    ONCE.call_once(|| {
        let mut old = MaybeUninit::<libc::sigaction>::zeroed();
        // SAFETY: all zero is a valid action.
        let mut new = unsafe { MaybeUninit::<libc::sigaction>::zeroed().assume_init() };
        new.sa_sigaction = attend as *const () as usize;
        // The previous handler may itself fault, and needs the stack that it asked for.
        new.sa_flags = libc::SA_SIGINFO | libc::SA_ONSTACK | libc::SA_NODEFER;
        // SAFETY: a valid action and a place for the old one.
        if unsafe { libc::sigaction(libc::SIGSEGV, &raw const new, old.as_mut_ptr()) } == 0 {
            // SAFETY: filled by the system.
            let old = unsafe { old.assume_init() };
            BEFORE.store(Box::into_raw(Box::new(old)), Relaxed);
        }
    });
}

/// # Safety
/// The system calls this.
unsafe extern "C" fn attend(signal: c_int, info: *mut libc::siginfo_t, context: *mut c_void) {
    // SAFETY: the system's record.
    let refused = unsafe { info.as_ref() }.is_some_and(|i| i.si_code == REFUSED);
    if refused && running::module().is_some() && port_access(context) {
        return;
    }
    let before = BEFORE.load(Relaxed);
    // SAFETY: kept forever by `watch`, or null.
    if let Some(action) = unsafe { before.as_ref() }
        && action.sa_flags & libc::SA_SIGINFO != 0
    {
        type Attends = unsafe extern "C" fn(c_int, *mut libc::siginfo_t, *mut c_void);
        // SAFETY: its flags say that it is a function of this type.
        let attends = unsafe { core::mem::transmute::<usize, Attends>(action.sa_sigaction) };
        // SAFETY: called as the system would call it.
        unsafe { attends(signal, info, context) };
        return;
    }
    // SAFETY: the previous action, or the default one: the instruction is then executed again.
    unsafe { libc::sigaction(signal, before, ptr::null_mut()) };
}

/// Returns the name of a signal that ends a process.
pub(crate) const fn named(signal: c_int) -> &'static str {
    match signal {
        libc::SIGSEGV => "segmentation fault",
        libc::SIGBUS => "bus error",
        libc::SIGFPE => "arithmetic fault",
        libc::SIGILL => "illegal instruction",
        libc::SIGABRT => "it gave up (abort)",
        _ => "fault",
    }
}

/// Emulates a port access of prebuilt code, and skips the instruction.
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

/// Other processors have no port I/O.
#[cfg(not(target_arch = "x86_64"))]
fn port_access(_context: *mut c_void) -> bool {
    false
}

/// Decoded `in` or `out` instruction.
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
