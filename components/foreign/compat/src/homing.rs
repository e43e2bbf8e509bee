//! Realtime. Homing of a module in C as the service `homing`.

pub(crate) mod offer;
mod record;
#[cfg(test)]
mod tests;

use crate::{module::Module, running};
use core::{
    cell::UnsafeCell,
    ffi::{c_double, c_int, c_uint, c_void},
    sync::atomic::Ordering::Relaxed,
};
use hal_component::abi::{
    Homing, HomingJoint, HomingSettings, Record as _, homing_call, homing_flags, homing_state,
};
use record::JointRecord;
use std::sync::Arc;

/// Number of joints that a module may ask about.
const JOINTS: usize = 16;

/// Memory for the records of joints, in bytes. A module of LinuxCNC's, which has another record, stays within it.
const ROOM: usize = 1 << 18;

type OnAll = extern "C" fn(c_int);
type OnOne = extern "C" fn(c_int) -> bool;
type OfAll = extern "C" fn() -> bool;
type Init = extern "C" fn(c_int, c_double, c_int, c_int, *mut c_void) -> c_int;
type Locks = extern "C" fn(extern "C" fn(c_int, c_int), extern "C" fn(c_int) -> c_int);
type Unhome = extern "C" fn(c_int, c_uint);
type Settings =
    extern "C" fn(c_int, c_double, c_double, c_double, c_double, c_double, c_int, c_int, bool);
type Update = extern "C" fn(c_int, c_double, c_double, c_int);

/// Functions of a module, with the types of `homing.h`.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Entries {
    init: Init,
    locks: Locks,
    set_settings: Settings,
    update_settings: Update,
    read_pins: OnAll,
    /// Of older modules, which have it apart from `run`.
    run_sequence: Option<extern "C" fn()>,
    run: OfAll,
    write_pins: OnAll,
    home: OnAll,
    cancel: OnAll,
    unhome: Unhome,
    is_active: OfAll,
    is_homing: OnOne,
    is_homed: OnOne,
    is_idle: OnOne,
    index_enable: OnOne,
    index_wait: OnOne,
}

/// Offered service: the table and what its context points at.
struct Homer {
    table: Homing,
    entries: Entries,
    /// Records of the joints, as the module has them. Words, for their alignment.
    records: Box<UnsafeCell<[u64; ROOM / 8]>>,
    /// True if these are records as in `motion.h`.
    knows_joints: bool,
    module: Arc<Module>,
}

// SAFETY: the motion controller calls the functions that touch the records from one thread at a time.
unsafe impl Send for Homer {}
// SAFETY: as for `Send`.
unsafe impl Sync for Homer {}

impl Homer {
    /// Returns the place of a joint's record, if the module has records as in `motion.h`.
    fn record(&self, joint: u32) -> Option<*mut JointRecord> {
        let joint = usize::try_from(joint).ok().filter(|n| *n < JOINTS && self.knows_joints)?;
        let first = self.records.get().cast::<JointRecord>();
        // SAFETY: the memory has room for all joints.
        Some(unsafe { first.add(joint) })
    }

    fn within<T>(&self, code: impl FnOnce() -> T) -> Option<T> {
        let mut result = None;
        running::within(Arc::as_ptr(&self.module), || {
            result = Some(code());
            0
        });
        result
    }

    fn put(&self, joint: u32, from: &HomingJoint) {
        let bit = 1_u32.checked_shl(joint).unwrap_or(0);
        let locks = &self.module.locks;
        set(&locks.open, bit, from.flags & homing_flags::UNLOCKED != 0);
        set(&locks.exists, bit, from.flags & homing_flags::HAS_LOCK != 0);
        if let Some(to) = self.record(joint) {
            // SAFETY: the module runs in this thread only.
            unsafe { to.write(JointRecord::of(from)) };
        }
    }

    fn take(&self, joint: u32, to: &mut HomingJoint) {
        if let Some(from) = self.record(joint) {
            // SAFETY: written by `put`; every bit pattern is a record.
            unsafe { from.read() }.store(to);
        }
    }

    fn call(&self, what: u32, joint: i32) -> bool {
        let e = &self.entries;
        let joints = c_int::try_from(self.module.locks.joints.load(Relaxed)).unwrap_or(0);
        let code = || {
            match what {
                homing_call::READ_PINS => (e.read_pins)(joints),
                homing_call::RUN => {
                    if let Some(run_sequence) = e.run_sequence {
                        run_sequence();
                    }
                    (e.run)();
                    return (e.is_active)();
                }
                homing_call::WRITE_PINS => (e.write_pins)(joints),
                homing_call::HOME => (e.home)(joint),
                homing_call::CANCEL => (e.cancel)(joint),
                homing_call::UNHOME_OFF => (e.unhome)(joint, 0),
                homing_call::UNHOME_FREE => (e.unhome)(joint, 1),
                _ => {}
            }
            false
        };
        self.within(code).unwrap_or(false)
    }

    fn state(&self, joint: u32) -> u32 {
        let e = &self.entries;
        let n = c_int::try_from(joint).unwrap_or(c_int::MAX);
        let all = [
            (e.is_homed, homing_state::HOMED),
            (e.is_homing, homing_state::HOMING),
            (e.is_idle, homing_state::IDLE),
            (e.index_wait, homing_state::INDEX_WAIT),
            (e.index_enable, homing_state::INDEX_ENABLE),
        ];
        let bits = self
            .within(|| all.iter().filter(|(asks, _)| asks(n)).fold(0, |bits, (_, bit)| bits | bit));
        let wanted = self.module.locks.wanted.load(Relaxed);
        let unlock = wanted.checked_shr(joint).unwrap_or(0) & 1;
        bits.unwrap_or(0) | (unlock * homing_state::UNLOCK)
    }

    fn configure(&self, joint: u32, s: &HomingSettings, is_update: bool) {
        let e = &self.entries;
        let joint = c_int::try_from(joint).unwrap_or(c_int::MAX);
        self.within(|| {
            if is_update {
                (e.update_settings)(joint, s.offset, s.home, s.sequence);
            } else {
                (e.set_settings)(
                    joint,
                    s.offset,
                    s.home,
                    s.final_velocity,
                    s.search_velocity,
                    s.latch_velocity,
                    s.flags.cast_signed(),
                    s.sequence,
                    s.volatile_home != 0,
                );
            }
        });
    }
}

fn set(bits: &core::sync::atomic::AtomicU32, bit: u32, value: bool) {
    let before = bits.load(Relaxed);
    bits.store(if value { before | bit } else { before & !bit }, Relaxed);
}

/// Opens or closes the lock of a joint, for the module that runs.
extern "C" fn set_rotary_unlock(joint: c_int, unlock: c_int) {
    let Some(locks) = running::module().map(|module| &module.locks) else { return };
    let bit = u32::try_from(joint).ok().and_then(|n| 1_u32.checked_shl(n)).unwrap_or(0);
    set(&locks.wanted, bit & locks.exists.load(Relaxed), unlock != 0);
}

/// Returns whether the lock of a joint is open, for the module that runs.
extern "C" fn get_rotary_unlock(joint: c_int) -> c_int {
    let Some(locks) = running::module().map(|module| &module.locks) else { return 0 };
    let bit = u32::try_from(joint).ok().and_then(|n| 1_u32.checked_shl(n)).unwrap_or(0);
    c_int::from(locks.open.load(Relaxed) & bit != 0)
}

/// # Safety
/// `ctx` must point to a live [`Homer`], `from` to a live record.
unsafe extern "C" fn put(ctx: *const c_void, joint: u32, from: *const HomingJoint) {
    // SAFETY: this is the table's own context.
    let homer = unsafe { &*ctx.cast::<Homer>() };
    // SAFETY: guaranteed by the caller.
    if let Some(from) = unsafe { HomingJoint::read(from) } {
        homer.put(joint, &from);
    }
}

/// # Safety
/// `ctx` must point to a live [`Homer`], `to` to a live record that the caller alone uses.
unsafe extern "C" fn take(ctx: *const c_void, joint: u32, to: *mut HomingJoint) {
    // SAFETY: this is the table's own context.
    let homer = unsafe { &*ctx.cast::<Homer>() };
    // SAFETY: guaranteed by the caller.
    if let Some(to) = unsafe { to.as_mut() } {
        homer.take(joint, to);
    }
}

/// # Safety
/// `ctx` must point to a live [`Homer`].
unsafe extern "C" fn call(ctx: *const c_void, what: u32, joint: i32) -> u32 {
    // SAFETY: this is the table's own context.
    u32::from(unsafe { &*ctx.cast::<Homer>() }.call(what, joint))
}

/// # Safety
/// `ctx` must point to a live [`Homer`].
unsafe extern "C" fn state(ctx: *const c_void, joint: u32) -> u32 {
    // SAFETY: this is the table's own context.
    unsafe { &*ctx.cast::<Homer>() }.state(joint)
}

/// # Safety
/// `ctx` must point to a live [`Homer`], `settings` to a live record.
unsafe extern "C" fn configure(
    ctx: *const c_void,
    joint: u32,
    settings: *const HomingSettings,
    update: u32,
) {
    // SAFETY: this is the table's own context.
    let homer = unsafe { &*ctx.cast::<Homer>() };
    // SAFETY: guaranteed by the caller.
    if let Some(settings) = unsafe { HomingSettings::read(settings) } {
        homer.configure(joint, &settings, update != 0);
    }
}
