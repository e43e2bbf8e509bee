//! Load of one file, which either succeeds completely or changes nothing.

use crate::{
    arguments, board, capability,
    docs::Docs,
    dry_run::dry_run_of,
    elf::Elf,
    funct, homing,
    kinematics::{Entries, offer},
    loading::{self, Loading, Refusal},
    module::{self, Main, Module},
    objects, outside, running,
    second_copy::SecondCopy,
    system, trap,
};
use core::ffi::{c_int, c_void};
use hal_component::abi::{
    ActionSpec, CallHost, ForeignFile, Host, Record, Status, Str, host_flags, level, size,
};
use std::{
    panic::catch_unwind,
    path::PathBuf,
    sync::{Arc, PoisonError, atomic::Ordering::Relaxed},
};

/// Loads a file; the entry point for the engine.
///
/// # Safety
/// The engine calls this with its own records.
pub(crate) unsafe extern "C" fn load(host: *const Host, file: *const ForeignFile) -> Status {
    // SAFETY: the engine's record lives across the call.
    let Some(host) = (unsafe { Host::read(host) }) else { return Status::EINVAL };
    // SAFETY: as above.
    let Some(file) = (unsafe { ForeignFile::read(file) }) else { return Status::EINVAL };
    let loaded = catch_unwind(|| load_file(host, file));
    let (status, why) = match loaded {
        Ok(Ok(())) => return Status::OK,
        Ok(Err(refusal)) => refusal,
        Err(_) => (Status::EFAULT, "its loader panicked".to_owned()),
    };
    if let Some(fail) = host.fail.filter(|_| !why.is_empty()) {
        // SAFETY: the engine's function; the text lives across the call.
        unsafe { fail(host.ctx, Str::borrow(&why)) };
    }
    status
}

/// Returns whether a file may be opened where hardware is simulated; the entry point for the engine, which opens files
/// in a separate process first. What is wrong with the file is said when it is loaded.
#[unsafe(export_name = "hal_opens_simulated")]
extern "C" fn opens_simulated(path: Str) -> bool {
    let path = PathBuf::from(text(path));
    let may = || Elf::read(&path).is_ok_and(|elf| outside::check(&path, &elf).is_ok());
    catch_unwind(may).unwrap_or(false)
}

fn text(s: Str) -> String {
    // SAFETY: a string of the engine's, alive during the load.
    unsafe { s.get() }.unwrap_or_default().to_owned()
}

fn load_file(host: Host, file: ForeignFile) -> Result<(), Refusal> {
    let refuse = |status: Status| move |why: String| (status, why);
    let path = PathBuf::from(text(file.path));
    let path = path.canonicalize().unwrap_or(path);
    let (name, prefix) = (text(file.name), text(file.prefix));
    if module::is_loaded(&path) {
        let why = format!(
            "{} is loaded already in this process, and there is one of its variables: unload it \
             first, or give all its instances on one line",
            path.display()
        );
        return Err((Status::EEXIST, why));
    }
    let elf = Elf::read(&path).map_err(refuse(Status(-libc::ENOEXEC)))?;
    system::offer_symbols().map_err(refuse(Status::EFAULT))?;
    trap::watch();
    let simulated = host.flags & host_flags::SIMULATED != 0;
    if simulated {
        outside::check(&path, &elf).map_err(String::from).map_err(refuse(Status(-libc::EPERM)))?;
    }
    let before = objects::mapped();
    let handle =
        system::open(&path).map_err(|why| lacking(&why)).map_err(refuse(Status(-libc::ENOEXEC)))?;
    let docs = Docs::read(handle, &elf.descriptions);
    if let Some(describe) = file.describe {
        // SAFETY: the engine's function; the text lives across the call.
        unsafe { describe(host.ctx, Str::borrow(&docs.component)) };
    }
    let mut module = Module::new(&host, file, (path.clone(), &name, &prefix), handle);
    module.docs = docs;
    let module = Arc::new(module);
    let main = module::main(handle)
        .map_err(|why| (Status::EINVAL, format!("{}: {why}", path.display())))?;
    find_providers(&host, &file, &elf)?;
    outside::redirect(&module, &before)
        .map_err(String::from)
        .map_err(refuse(Status(-libc::EPERM)))?;
    // SAFETY: the engine's words, alive during the load.
    let words = unsafe { core::slice::from_raw_parts(file.words, file.n_words) };
    let words: Vec<String> = words.iter().map(|w| text(*w)).collect();
    arguments::set(&module, &elf.parameters, &words).map_err(refuse(Status::EINVAL))?;

    let in_dry_run = host.flags & host_flags::TRIAL != 0;
    let has_kinematics = prefix.is_empty() && Entries::has_any(handle);
    let kinematics = has_kinematics.then(|| Entries::read(handle)).transpose();
    let kinematics = kinematics.map_err(refuse(Status::EINVAL))?;
    let has_homing = prefix.is_empty() && homing::Entries::has_any(handle);
    let homing = has_homing.then(|| homing::Entries::read(handle)).transpose();
    let homing = homing.map_err(refuse(Status::EINVAL))?;
    let loading = Loading::new(host, file, module.clone());
    let done = loading::within(&loading, || {
        prepared(&module, &path)?;
        if in_dry_run {
            dry_run_of(&loading, main, kinematics, module::exit(handle))?;
        }
        Ok(set_up(&module, main, kinematics, || ()))
    });
    let tried = outside::suffix(&name, &loading.tried.borrow());
    let kind = done
        .map_err(|why| (Status::EINVAL, why))
        .and_then(|done| {
            let lacks =
                |code| if simulated { "" } else { capability::lacking(code, &elf.undefined) };
            done.map_err(|code| (Status(code), failed(code) + lacks(code)))
        })
        .map_err(|(status, why)| (status, why + &tried))?;
    let Loading { ports, items, refusals, .. } = loading;
    module.ports.complete(ports.into_inner().into());
    if let (Some(entries), Some(kind)) = (kinematics, kind) {
        let load = offer::Parts { host, file, path: &path, elf: &elf, words: &words };
        let further = module.further.lock().unwrap_or_else(PoisonError::into_inner).clone();
        let first = SecondCopy::new(items.into_inner(), further, refusals.into_inner());
        offer::offer(&load, &module, entries, kind, first)?;
    }
    if let Some(entries) = homing {
        homing::offer::offer(&host, &module, entries)?;
    }
    report_without_effect(&module, handle);
    hold_until_unload(&host, module)
}

/// Runs `rtapi_app_main`, and then `kinematicsType` of kinematics, because some modules make their pins there. Calls
/// `before_type` between the two. Returns the type.
///
/// # Errors
/// `rtapi_app_main` fails; the error is its result.
pub(crate) fn set_up(
    module: &Module,
    main: Main,
    kinematics: Option<Entries>,
    before_type: impl FnOnce(),
) -> Result<Option<c_int>, c_int> {
    let code = running::within(module, || main());
    if code < 0 {
        return Err(code);
    }
    module.made.store(true, Relaxed);
    let Some(kinematics) = kinematics else { return Ok(None) };
    before_type();
    Ok(Some(running::within(module, || (kinematics.kind)())))
}

/// Returns the reason of a setup that has failed.
pub(crate) fn failed(code: c_int) -> String {
    format!("rtapi_app_main: {} ({code})", system::explained(code))
}

/// Adds the source and a remedy to the dynamic linker's message.
fn lacking(why: &str) -> String {
    let why = format!("dlopen: {why}");
    let Some((_, symbol)) = why.split_once("undefined symbol: ") else { return why };
    if symbol.starts_with("hm2_") {
        return why + "; hostmot2 defines it and comes first: `loadrt hostmot2` before this line";
    }
    why + "; if another component in C defines it, such as kinematics for motmod, load that first"
}

/// Sets the registers of simulated hardware to their power-on contents.
fn prepared(module: &Module, path: &std::path::Path) -> Result<(), String> {
    if module.is_simulated() { board::prepare(path, &module.registers) } else { Ok(()) }
}

/// Keeps modules loaded while this one uses their symbols.
fn find_providers(host: &Host, file: &ForeignFile, elf: &Elf) -> Result<(), Refusal> {
    let found = module::providers(file.instance.addr(), &elf.undefined).map_err(|symbol| {
        let why = format!(
            "it takes '{symbol}' from a component of another instance in this process: one \
             instance a process for components that use each other"
        );
        (Status::EBUSY, why)
    })?;
    for number in found {
        if let Some(need) = file.need {
            // SAFETY: the engine's function with the engine's context.
            unsafe { need(host.ctx, number) };
        }
    }
    Ok(())
}

/// Reports a planner module, because motion takes none.
fn report_without_effect(module: &Module, handle: *mut c_void) {
    if !system::symbol(handle, c"tpRunCycle").is_null() {
        let text = "this trajectory planner module has no effect on motmod, which has its own \
                    trajectory planner; only LinuxCNC's motmod takes it";
        module.say(level::ERR, text);
    }
}

/// Ties the life of a module to its component: registers a stop action that does nothing but hold a reference.
fn hold_until_unload(host: &Host, module: Arc<Module>) -> Result<(), Refusal> {
    /// # Safety
    /// The engine calls this with the state that was registered.
    unsafe extern "C" fn nothing(_: *mut c_void, _: *const CallHost) -> Status {
        Status::OK
    }
    let spec = ActionSpec {
        size: size::<ActionSpec>(),
        flags: 0,
        run: Some(nothing),
        state: Arc::into_raw(module).cast_mut().cast(),
        free: Some(funct::free_module),
    };
    // SAFETY: the engine's function; ownership of the state passes with the call.
    let status =
        host.stop.map_or(Status::EINVAL, |stop| unsafe { stop(host.ctx, &raw const spec) });
    if status.is_ok() { Ok(()) } else { Err((status, "the engine refused it".to_owned())) }
}
