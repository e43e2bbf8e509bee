//! A component in C that is loaded: its file, what it may call, its memory.

use crate::{elf::Undefined, memory::Memory, registers::Registers, running, system};
use core::ffi::{c_int, c_void};
use hal_component::abi::{CallHost, ForeignFile, Host, Str, host_flags};
use std::{
    ffi::CString,
    path::PathBuf,
    sync::{
        Mutex, PoisonError,
        atomic::{AtomicBool, Ordering::Relaxed},
    },
};

/// `rtapi_app_main`.
pub(crate) type Main = extern "C" fn() -> c_int;
/// `rtapi_app_exit`.
pub(crate) type Exit = extern "C" fn();

/// One loaded module.
#[derive(Debug)]
pub(crate) struct Module {
    /// The component's name.
    pub(crate) name: CString,
    /// Its number.
    pub(crate) component: u32,
    /// What its names begin with.
    pub(crate) prefix: String,
    calls: &'static CallHost,
    file: ForeignFile,
    /// What the engine says of hardware and time.
    flags: u32,
    /// The file, open.
    pub(crate) handle: *mut c_void,
    exit: Option<Exit>,
    pub(crate) memory: Memory,
    pub(crate) registers: Registers,
    /// Whether `rtapi_app_main` has succeeded.
    pub(crate) made: AtomicBool,
    /// Whether it is complete: no pins any more.
    pub(crate) ready: AtomicBool,
}

// SAFETY: what it points at is immutable, or the engine's and open to every thread.
unsafe impl Send for Module {}
// SAFETY: as for `Send`.
unsafe impl Sync for Module {}

/// A module that is loaded somewhere in this process.
#[derive(Debug)]
struct Entry {
    path: PathBuf,
    instance: usize,
    component: u32,
    handle: usize,
}

static LOADED: Mutex<Vec<Entry>> = Mutex::new(Vec::new());

fn loaded() -> std::sync::MutexGuard<'static, Vec<Entry>> {
    LOADED.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Whether a file is loaded: its statics are there once in a process.
pub(crate) fn is_loaded(path: &std::path::Path) -> bool {
    loaded().iter().any(|e| e.path == path)
}

/// Who else in this process defines what a module lacks: the numbers of the components.
///
/// # Errors
/// One belongs to another instance: the symbol.
pub(crate) fn providers(instance: usize, lacks: &[Undefined]) -> Result<Vec<u32>, String> {
    let mut found = Vec::new();
    for e in loaded().iter() {
        for u in lacks {
            if !system::defines(e.handle as *mut c_void, &u.name) {
                continue;
            }
            if e.instance != instance {
                return Err(u.name.to_string_lossy().into_owned());
            }
            found.push(e.component);
            break;
        }
    }
    Ok(found)
}

impl Module {
    pub(crate) fn new(
        host: &Host,
        file: ForeignFile,
        (path, name, prefix): (PathBuf, &str, &str),
        handle: *mut c_void,
        exit: Option<Exit>,
    ) -> Self {
        let (instance, component) = (file.instance.addr(), file.component);
        loaded().push(Entry { path, instance, component, handle: handle.addr() });
        // SAFETY: the engine keeps the record until the component is unloaded.
        let calls = unsafe { &*host.calls };
        Self {
            name: CString::new(format!("{prefix}{name}")).unwrap_or_default(),
            component: file.component,
            prefix: prefix.to_owned(),
            calls,
            file,
            flags: host.flags,
            handle,
            exit,
            memory: Memory::default(),
            registers: Registers::default(),
            made: AtomicBool::new(false),
            ready: AtomicBool::new(false),
        }
    }

    /// Its number, as C has it.
    pub(crate) fn id(&self) -> c_int {
        c_int::try_from(self.component).unwrap_or(c_int::MAX)
    }

    /// Whether hardware is simulated.
    pub(crate) const fn is_simulated(&self) -> bool {
        self.flags & host_flags::SIMULATED != 0
    }

    /// Whether machine time stands still within a function.
    pub(crate) const fn is_virtual(&self) -> bool {
        self.flags & host_flags::VIRTUAL != 0
    }

    /// Realtime. Machine time in nanoseconds.
    pub(crate) fn now(&self) -> i64 {
        // SAFETY: the engine's function with the engine's context.
        self.calls.now.map_or(0, |now| unsafe { now(self.calls.ctx) })
    }

    /// Realtime. Says something; level 0 is always shown.
    pub(crate) fn say(&self, level: u8, text: &str) {
        if let Some(say) = self.file.say {
            // SAFETY: the engine's function; `text` lives across the call.
            unsafe { say(self.calls.ctx, level, Str::borrow(text)) };
        }
    }

    /// Realtime. Sets up to which level messages are shown, unless negative; what it was.
    pub(crate) fn level(&self, level: i32) -> i32 {
        // SAFETY: the engine's function with the engine's context.
        self.file.level.map_or(1, |f| unsafe { f(self.calls.ctx, level) })
    }

    /// A block of memory of the component's own.
    pub(crate) fn take(&self, bytes: usize) -> Option<*mut u8> {
        let at = self.memory.take(bytes)?;
        if let Some(account) = self.file.account {
            let bytes = i64::try_from(bytes).unwrap_or(0);
            // SAFETY: the engine's function with the engine's context.
            unsafe { account(self.calls.ctx, bytes) };
        }
        Some(at)
    }
}

impl Drop for Module {
    fn drop(&mut self) {
        if self.made.load(Relaxed)
            && let Some(exit) = self.exit
        {
            running::within(&raw const *self, || {
                exit();
                0
            });
        }
        crate::message::forget_handler(self.handle);
        if !system::close(self.handle) {
            let name = self.name.to_string_lossy();
            let text = format!("{name}: its file stays mapped; loaded again it is as it is now");
            self.say(hal_component::abi::level::WARN, &text);
        }
        // Only now may another load begin: the statics are gone.
        let handle = self.handle.addr();
        loaded().retain(|e| e.handle != handle);
    }
}
