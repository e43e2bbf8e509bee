//! Loaded C component: its file, the engine's functions, and its memory.

use crate::{docs::Docs, memory::Memory, port::Ports, registers::Registers, running, system};
use core::ffi::{c_int, c_void};
use hal_component::abi::{CallHost, ForeignFile, Host, Str, host_flags};
use std::{
    ffi::CString,
    os::fd::OwnedFd,
    path::PathBuf,
    sync::{
        Mutex, PoisonError,
        atomic::{AtomicBool, AtomicU32, Ordering::Relaxed},
    },
};

/// Type of `rtapi_app_main`.
pub(crate) type Main = extern "C" fn() -> c_int;
/// Type of `rtapi_app_exit`.
pub(crate) type Exit = extern "C" fn();

/// Locks of joints, a bit for each, for a homing module.
#[derive(Debug, Default)]
pub(crate) struct Locks {
    /// Number of joints.
    pub(crate) joints: AtomicU32,
    /// Joints with a lock.
    pub(crate) exists: AtomicU32,
    /// Joints whose lock is open.
    pub(crate) open: AtomicU32,
    /// Joints whose lock the module wants open.
    pub(crate) wanted: AtomicU32,
}

/// Loaded module.
#[derive(Debug)]
pub(crate) struct Module {
    /// Name of the component.
    pub(crate) name: CString,
    /// Number of the component.
    pub(crate) component: u32,
    /// Prefix of its names.
    pub(crate) prefix: String,
    calls: &'static CallHost,
    file: ForeignFile,
    /// Host flags for hardware and time.
    flags: u32,
    /// Handle of the open file.
    pub(crate) handle: *mut c_void,
    exit: Option<Exit>,
    pub(crate) memory: Memory,
    pub(crate) registers: Registers,
    pub(crate) ports: Ports,
    pub(crate) docs: Docs,
    /// Locks of joints, if it is a homing module.
    pub(crate) locks: Locks,
    /// Components that the module made with further calls of `hal_init`: their numbers and names.
    pub(crate) further: Mutex<Vec<(c_int, CString)>>,
    /// True once the module has called `hal_init`.
    pub(crate) named: AtomicBool,
    /// True if `rtapi_app_main` has succeeded.
    pub(crate) made: AtomicBool,
    /// True once the component is complete: no more pins can be made.
    pub(crate) ready: AtomicBool,
    /// True while one copy repeats what the other one does, so that its messages would appear twice.
    pub(crate) quiet: AtomicBool,
    /// True once a call that reaches outside was refused, with a message.
    pub(crate) told_refusal: AtomicBool,
    /// File of a second copy, held open so that no other file gets its number while it is mapped.
    second_copy_file: Option<OwnedFd>,
}

// SAFETY: it points to immutable data, or to the engine's, which any thread may access.
unsafe impl Send for Module {}
// SAFETY: as for `Send`.
unsafe impl Sync for Module {}

/// Returns `rtapi_app_main` of a file.
///
/// # Errors
/// The file has none.
pub(crate) fn main(handle: *mut c_void) -> Result<Main, String> {
    let main = system::symbol(handle, c"rtapi_app_main");
    // SAFETY: the interface defines the type of this symbol; null is `None`.
    let main = unsafe { core::mem::transmute::<*mut c_void, Option<Main>>(main) };
    main.ok_or_else(|| "no rtapi_app_main".to_owned())
}

/// Returns `rtapi_app_exit` of a file, if it has one.
pub(crate) fn exit(handle: *mut c_void) -> Option<Exit> {
    let exit = system::symbol(handle, c"rtapi_app_exit");
    // SAFETY: the interface defines the type of this symbol; null is `None`.
    unsafe { core::mem::transmute::<*mut c_void, Option<Exit>>(exit) }
}

/// Module that is loaded in this process, in any instance.
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

/// Returns whether a file is loaded: its static variables exist once per process.
pub(crate) fn is_loaded(path: &std::path::Path) -> bool {
    loaded().iter().any(|e| e.path == path)
}

/// Returns the numbers of the components in this process that define symbols which a module lacks.
///
/// # Errors
/// A symbol is defined by a component of another instance; the error is that symbol.
pub(crate) fn providers(instance: usize, lacks: &[CString]) -> Result<Vec<u32>, String> {
    let mut found = Vec::new();
    for e in loaded().iter() {
        for u in lacks {
            if !system::defines(e.handle as *mut c_void, u) {
                continue;
            }
            if e.instance != instance {
                return Err(u.to_string_lossy().into_owned());
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
            exit: exit(handle),
            memory: Memory::default(),
            registers: Registers::default(),
            ports: Ports::default(),
            docs: Docs::default(),
            locks: Locks::default(),
            further: Mutex::default(),
            named: AtomicBool::new(false),
            made: AtomicBool::new(false),
            ready: AtomicBool::new(false),
            quiet: AtomicBool::new(false),
            told_refusal: AtomicBool::new(false),
            second_copy_file: None,
        }
    }

    /// Returns whether this is a second copy.
    pub(crate) const fn is_second_copy(&self) -> bool {
        self.second_copy_file.is_some()
    }

    /// Returns a second copy of this module, opened from `file`. No other module takes symbols from it.
    pub(crate) fn second_copy(&self, handle: *mut c_void, file: OwnedFd) -> Self {
        Self {
            name: self.name.clone(),
            component: self.component,
            prefix: self.prefix.clone(),
            calls: self.calls,
            file: self.file,
            flags: self.flags,
            handle,
            exit: exit(handle),
            memory: Memory::default(),
            registers: Registers::default(),
            ports: Ports::default(),
            docs: Docs::default(),
            locks: Locks::default(),
            further: Mutex::default(),
            named: AtomicBool::new(false),
            made: AtomicBool::new(false),
            ready: AtomicBool::new(false),
            quiet: AtomicBool::new(true),
            told_refusal: AtomicBool::new(false),
            second_copy_file: Some(file),
        }
    }

    /// Returns the engine's functions for a file. Its texts have gone.
    pub(crate) const fn file(&self) -> ForeignFile {
        self.file
    }

    /// Returns the number of the component as a C int.
    pub(crate) fn id(&self) -> c_int {
        c_int::try_from(self.component).unwrap_or(c_int::MAX)
    }

    /// Returns whether hardware is simulated.
    pub(crate) const fn is_simulated(&self) -> bool {
        self.flags & host_flags::SIMULATED != 0
    }

    /// Returns whether machine time stands still during a function.
    pub(crate) const fn is_virtual(&self) -> bool {
        self.flags & host_flags::VIRTUAL != 0
    }

    /// Realtime. Returns machine time in nanoseconds.
    pub(crate) fn now(&self) -> i64 {
        // SAFETY: the engine's function with the engine's context.
        self.calls.now.map_or(0, |now| unsafe { now(self.calls.ctx) })
    }

    /// Realtime. Logs a message; level 0 is always shown.
    pub(crate) fn say(&self, level: u8, text: &str) {
        if let Some(say) = self.file.say.filter(|_| !self.quiet.load(Relaxed)) {
            // SAFETY: the engine's function; `text` lives across the call.
            unsafe { say(self.calls.ctx, level, Str::borrow(text)) };
        }
    }

    /// Realtime. Sets the highest level of messages that are shown, unless negative. Returns the previous level.
    pub(crate) fn level(&self, level: i32) -> i32 {
        // SAFETY: the engine's function with the engine's context.
        self.file.level.map_or(1, |f| unsafe { f(self.calls.ctx, level) })
    }

    /// Allocates a block of the component's memory.
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
        // The first copy says what there is to say.
        self.quiet.store(self.is_second_copy(), Relaxed);
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
        // Only now may another load begin: the static variables no longer exist.
        let handle = self.handle.addr();
        loaded().retain(|e| e.handle != handle);
    }
}
