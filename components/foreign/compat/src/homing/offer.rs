//! Search of a loaded module for homing, and the offer of the service.

use super::{
    Entries, Homer, JOINTS, ROOM, call, configure, get_rotary_unlock, put, record::JointRecord,
    set_rotary_unlock, state, take,
};
use crate::{
    dry_run,
    loading::{self, Loading, Refusal},
    module::Module,
    running,
    second_copy::{FirstValue, Made},
    service::{self, ModuleService},
    system,
};
use core::{
    cell::UnsafeCell,
    ffi::{CStr, c_int, c_void},
    sync::atomic::{
        AtomicPtr, AtomicU64,
        Ordering::{Relaxed, Release},
    },
};
use hal_component::abi::{
    ActionSpec, CallHost, Homing, Host, Record, ServiceRef, Status, Str, host_flags, size,
};
use std::sync::Arc;

/// Functions that motion needs, as LinuxCNC's motion controller does.
const NEEDED: [&CStr; 20] = [
    c"homing_init",
    c"homeMotFunctions",
    c"set_joint_homing_params",
    c"update_joint_homing_params",
    c"read_homing_in_pins",
    c"do_homing",
    c"write_homing_out_pins",
    c"do_home_joint",
    c"do_cancel_homing",
    c"set_unhomed",
    c"get_homing_is_active",
    c"get_homing",
    c"get_homed",
    c"get_home_is_idle",
    c"get_index_enable",
    c"get_homing_at_index_search_wait",
    c"get_allhomed",
    c"get_home_sequence",
    c"get_home_needs_unlock_first",
    c"get_home_is_synchronized",
];

/// Constant by which `homing.h` marks modules that know the joints of `motion.h`.
const MARK: &CStr = c"rtapi_info_joint_record";

/// LinuxCNC's homing module that touches no record of a joint.
const TOUCHES_NONE: &[u8] = b"homecomp";

const OTHER_RECORDS: &str = "it was compiled for joint records of another kind, such as those of a version of \
                             LinuxCNC: its source includes homing.h, and Ferrule's halcompile compiles it";

/// Number of the component whose pins a module creates as those of the motion controller.
const MOTION: c_int = c_int::MAX;

const _: () = assert!(size_of::<JointRecord>() * JOINTS <= ROOM);

macro_rules! function {
    ($handle:ident, $name:literal, $ty:ty) => {
        // SAFETY: `homing.h` defines the type of this symbol, which is not null.
        unsafe { core::mem::transmute::<*mut c_void, $ty>(system::symbol($handle, $name)) }
    };
}

impl Entries {
    /// Returns whether a file has homing, or a part of it.
    pub(crate) fn has_any(handle: *mut c_void) -> bool {
        [c"do_homing", c"homing_init"].iter().any(|name| system::defines(handle, name))
    }

    /// Returns the homing functions of a file.
    ///
    /// # Errors
    /// A function is missing; the error names it.
    pub(crate) fn read(handle: *mut c_void) -> Result<Self, String> {
        if let Some(name) = NEEDED.iter().find(|name| !system::defines(handle, name)) {
            return Err(format!(
                "it has homing without {}: motmod needs all functions of homing.h, each with \
                 EXPORT_SYMBOL",
                name.to_string_lossy()
            ));
        }
        let sequence = c"do_homing_sequence";
        let has_sequence = system::defines(handle, sequence);
        Ok(Self {
            init: function!(handle, c"homing_init", super::Init),
            locks: function!(handle, c"homeMotFunctions", super::Locks),
            set_settings: function!(handle, c"set_joint_homing_params", super::Settings),
            update_settings: function!(handle, c"update_joint_homing_params", super::Update),
            read_pins: function!(handle, c"read_homing_in_pins", super::OnAll),
            run_sequence: has_sequence
                .then(|| function!(handle, c"do_homing_sequence", extern "C" fn())),
            run: function!(handle, c"do_homing", super::OfAll),
            write_pins: function!(handle, c"write_homing_out_pins", super::OnAll),
            home: function!(handle, c"do_home_joint", super::OnAll),
            cancel: function!(handle, c"do_cancel_homing", super::OnAll),
            unhome: function!(handle, c"set_unhomed", super::Unhome),
            is_active: function!(handle, c"get_homing_is_active", super::OfAll),
            is_homing: function!(handle, c"get_homing", super::OnOne),
            is_homed: function!(handle, c"get_homed", super::OnOne),
            is_idle: function!(handle, c"get_home_is_idle", super::OnOne),
            index_enable: function!(handle, c"get_index_enable", super::OnOne),
            index_wait: function!(handle, c"get_homing_at_index_search_wait", super::OnOne),
        })
    }
}

fn knows_joints(handle: *mut c_void) -> bool {
    let mark = system::symbol(handle, MARK).cast::<u8>();
    // SAFETY: a text of one character in the file, unless it is missing.
    !mark.is_null() && unsafe { mark.read() } == b'1'
}

/// Offers the homing of a module whose setup has succeeded.
///
/// # Errors
/// Another module offers homing already, or the motion controller homes by itself already.
pub(crate) fn offer(host: &Host, module: &Arc<Module>, entries: Entries) -> Result<(), Refusal> {
    if has_motion(host) {
        let why = "it has homing, and motmod, which homes by itself, is loaded already: load it \
                   before motmod";
        return Err((Status::EINVAL, why.to_owned()));
    }
    let name = module.name.to_str().unwrap_or_default();
    let table = Homing {
        size: size::<Homing>(),
        flags: 0,
        ctx: core::ptr::null(),
        name: Str::borrow(name),
        open: Some(open),
        configure: Some(configure),
        put: Some(put),
        take: Some(take),
        call: Some(call),
        state: Some(state),
    };
    let homer = Homer {
        table,
        entries,
        records: Box::new(UnsafeCell::new([0; ROOM / 8])),
        knows_joints: knows_joints(module.handle),
        module: module.clone(),
    };
    service::offer(host, homer)
}

impl ModuleService for Homer {
    const NAME: &'static str = "homing";
    type Table = Homing;

    fn table(&mut self) -> &Homing {
        self.table.ctx = (&raw const *self).cast();
        &self.table
    }
}

/// Returns whether the motion controller is loaded.
fn has_motion(host: &Host) -> bool {
    let mut found = ServiceRef { table: core::ptr::null(), uses: core::ptr::null(), n_uses: 0 };
    let status = host.bind.map_or(Status::EINVAL, |bind| {
        // SAFETY: the engine's function; the result lives across the call.
        unsafe { bind(host.ctx, Str::new("motion"), 1, &raw mut found) }
    });
    status.is_ok() && !found.table.is_null()
}

/// Has the module create its pins, as those of the component that `host` creates.
///
/// # Safety
/// `ctx` must point to a live [`Homer`], `host` to the record of the component that is being created.
unsafe extern "C" fn open(
    ctx: *const c_void,
    host: *const Host,
    period: f64,
    joints: u32,
    extra: u32,
) -> Status {
    // SAFETY: this is the table's own context.
    let homer = unsafe { &*ctx.cast::<Homer>() };
    // SAFETY: guaranteed by the caller.
    let Some(host) = (unsafe { Host::read(host) }) else { return Status::EINVAL };
    let Err(why) = homer.open(host, period, [joints, extra]) else { return Status::OK };
    let name = homer.module.name.to_string_lossy();
    let text = format!("the homing module '{name}': {why}");
    if let Some(fail) = host.fail {
        // SAFETY: the engine's function; the text lives across the call.
        unsafe { fail(host.ctx, Str::borrow(&text)) };
    }
    Status::EINVAL
}

impl Homer {
    fn open(&self, host: Host, period: f64, joints: [u32; 2]) -> Result<(), String> {
        let module = &self.module;
        if !self.knows_joints && module.name.to_bytes() != TOUCHES_NONE {
            return Err(OTHER_RECORDS.to_owned());
        }
        let [all, extra] = numbers(joints)?;
        self.reset();
        module.locks.joints.store(joints[0], Relaxed);
        let records = self.records.get().cast();
        let init = || {
            (self.entries.locks)(set_rotary_unlock, get_rotary_unlock);
            (self.entries.init)(MOTION, period, all, extra, records)
        };
        let loading = Loading::new(host, module.file(), module.clone());
        let code = loading::within(&loading, || {
            if host.flags & host_flags::TRIAL != 0 {
                dry_run::of_call(&loading, "homing_init", init)?;
                self.reset();
            }
            Ok::<_, String>(running::within(Arc::as_ptr(module), init))
        })?;
        // Also of an init that has failed, whose pins end at once.
        leave_pins_later(&host, module, &loading.items.into_inner())?;
        if let Some(why) = loading.refusals.into_inner().into_iter().next() {
            return Err(why);
        }
        if code != 0 {
            return Err(format!("homing_init fails ({code})"));
        }
        Ok(())
    }

    /// Clears the records and the locks.
    fn reset(&self) {
        // SAFETY: no function of the controller runs yet.
        unsafe { &mut *self.records.get() }.fill(0);
        let locks = &self.module.locks;
        [&locks.open, &locks.exists, &locks.wanted].into_iter().for_each(|l| l.store(0, Relaxed));
    }
}

/// Returns numbers of joints for the module.
///
/// # Errors
/// They are more than its arrays hold.
pub(super) fn numbers(joints: [u32; 2]) -> Result<[c_int; 2], String> {
    let numbers = joints.map(|n| c_int::try_from(n).unwrap_or(c_int::MAX));
    match numbers.iter().find(|n| usize::try_from(**n).is_ok_and(|n| n > JOINTS)) {
        Some(many) => Err(format!("it homes {JOINTS} joints at most, not {many}")),
        None => Ok(numbers),
    }
}

/// Pointers of a module to pins that end with the motion controller, before the module does.
struct MotionPins {
    places: Vec<*const AtomicPtr<AtomicU64>>,
    /// Cell of the module's own for all of them from then on.
    spare: *mut AtomicU64,
    /// Reference that keeps the memory of both alive.
    _module: Arc<Module>,
}

/// Has the pointers to the pins lead to a cell of the module's own when the motion controller is unloaded: functs of the
/// module may run on.
fn leave_pins_later(host: &Host, module: &Arc<Module>, made: &[Made]) -> Result<(), String> {
    /// # Safety
    /// Called with any arguments.
    const unsafe extern "C" fn nothing(_: *mut c_void, _: *const CallHost) -> Status {
        Status::OK
    }
    /// # Safety
    /// The engine calls this once, with a state made below.
    unsafe extern "C" fn leave(state: *mut c_void) {
        // SAFETY: made by `Box::into_raw` as `MotionPins`; freed once.
        let pins = unsafe { Box::from_raw(state.cast::<MotionPins>()) };
        for place in &pins.places {
            // SAFETY: the module's memory for a pointer, which stays as long as the module.
            let place = unsafe { &**place };
            // Release pairs with each use by the module's code.
            place.store(pins.spare, Release);
        }
    }
    let place = |m: &Made| match m.from {
        FirstValue::Pin(place) if m.status.is_ok() => Some(place),
        FirstValue::Pin(_) | FirstValue::Param(_) => None,
    };
    let spare = module.take(8).ok_or("there is no memory left")?.cast();
    let places = made.iter().filter_map(place).collect();
    let pins = MotionPins { places, spare, _module: module.clone() };
    let spec = ActionSpec {
        size: size::<ActionSpec>(),
        flags: 0,
        run: Some(nothing),
        state: Box::into_raw(Box::new(pins)).cast(),
        free: Some(leave),
    };
    // SAFETY: the engine's function; ownership of the state passes with the call.
    let status =
        host.stop.map_or(Status::EINVAL, |stop| unsafe { stop(host.ctx, &raw const spec) });
    if status.is_ok() { Ok(()) } else { Err("the engine refused it".to_owned()) }
}
