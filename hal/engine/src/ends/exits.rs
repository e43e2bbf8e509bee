//! Replacements of the C library's functions that end a process. They take precedence in this
//! program and in every library that it loads, so that the component that calls one can be
//! identified.

use super::{
    crash::{self, Cause},
    process::is_ours,
    sys::{self, Registers},
};
use core::ffi::{CStr, c_int, c_void};

/// Defines a function that ends the process: `$name` passes its status, the address that it was
/// called from and the caller's stack to `$ours`.
macro_rules! replaced {
    ($name:ident, $ours:ident, $own_name:literal, $way:expr) => {
        /// # Safety
        /// As the C library's.
        #[cfg(target_arch = "x86_64")]
        #[unsafe(no_mangle)]
        #[unsafe(naked)]
        unsafe extern "C" fn $name(status: c_int) -> ! {
            core::arch::naked_asm!(
                "mov rsi, [rsp]",
                "lea rdx, [rsp + 8]",
                "jmp {ours}",
                ours = sym $ours
            )
        }

        /// # Safety
        /// As the C library's.
        #[cfg(target_arch = "aarch64")]
        #[unsafe(no_mangle)]
        #[unsafe(naked)]
        unsafe extern "C" fn $name(status: c_int) -> ! {
            core::arch::naked_asm!("mov x1, x30", "mov x2, sp", "b {ours}", ours = sym $ours)
        }

        /// # Safety
        /// As the C library's.
        #[cfg(not(any(target_arch = "x86_64", target_arch = "aarch64")))]
        #[unsafe(no_mangle)]
        unsafe extern "C" fn $name(status: c_int) -> ! {
            $ours(status, 0, 0)
        }

        extern "C" fn $ours(status: c_int, code: usize, stack: usize) -> ! {
            attend($own_name, $way, status, Registers { code, stack })
        }
    };
}

/// Method by which the C library's function ends the process.
#[derive(Clone, Copy)]
enum Way {
    /// By a function of its own, of this name.
    Function(&'static CStr),
    /// At once.
    AtOnce,
    /// By SIGABRT.
    Abort,
}

replaced!(exit, our_exit, "exit", Way::Function(c"exit"));
replaced!(quick_exit, our_quick_exit, "quick_exit", Way::Function(c"quick_exit"));
replaced!(_exit, our_exit_at_once, "_exit", Way::AtOnce);
replaced!(_Exit, our_exit_in_c, "_Exit", Way::AtOnce);
replaced!(abort, our_abort, "abort", Way::Abort);

fn attend(function: &'static str, way: Way, status: c_int, place: Registers) -> ! {
    if is_ours() {
        let status = (!matches!(way, Way::Abort)).then_some(status);
        crash::crash(&Cause::Exit { function, status }, place);
    }
    match way {
        Way::Function(name) => {
            type Exit = extern "C" fn(c_int) -> !;
            // SAFETY: a text that ends in zero.
            let theirs = unsafe { libc::dlsym(libc::RTLD_NEXT, name.as_ptr()) };
            // SAFETY: the C library's function of this kind; null is `None`.
            let theirs = unsafe { core::mem::transmute::<*mut c_void, Option<Exit>>(theirs) };
            theirs.map_or_else(|| sys::leave(status), |theirs| theirs(status))
        }
        Way::AtOnce => sys::leave(status),
        Way::Abort => sys::abort(),
    }
}

/// Makes `exit` noticed also where the C library itself calls it.
pub(super) fn watch() {
    unsafe extern "C" {
        safe fn on_exit(attends: extern "C" fn(c_int, *mut c_void), with: *mut c_void) -> c_int;
    }
    extern "C" fn attends(status: c_int, _: *mut c_void) {
        if is_ours() {
            let place = Registers { code: 0, stack: sys::stack() };
            crash::crash(&Cause::Exit { function: "exit", status: Some(status) }, place);
        }
    }
    // If `on_exit` has no room for another function, only the replacements above remain.
    on_exit(attends, core::ptr::null_mut());
    // Named here so that the linker includes them in the program.
    core::hint::black_box(ours());
}

fn ours() -> [(&'static CStr, *const c_void); 5] {
    [
        (c"exit", exit as *const c_void),
        (c"quick_exit", quick_exit as *const c_void),
        (c"_exit", _exit as *const c_void),
        (c"_Exit", _Exit as *const c_void),
        (c"abort", abort as *const c_void),
    ]
}

#[cfg(test)]
mod tests {
    #[test]
    fn libraries_find_our_functions() {
        for (name, ours) in super::ours() {
            // SAFETY: a text that ends in zero.
            let found = unsafe { libc::dlsym(libc::RTLD_DEFAULT, name.as_ptr()) };
            assert!(core::ptr::eq(found, ours), "{name:?}");
        }
    }
}
