//! Setup of a second copy: its functions in place of the engine's, so that nothing reaches the graph.

use crate::{
    loading::{Loading, loading},
    module::Module,
    pin::refuse,
    running,
    second_copy::{Input, SecondCopy},
};
use core::ffi::{CStr, c_int, c_void};
use hal_component::abi::{
    ForeignFile, FunctSpec, Host, ItemSpec, Record, Status, Str, ThreadSpec, dir, ty,
};
use std::{ffi::CString, sync::Arc};

impl Loading {
    /// Returns the load of a second copy, for which nothing reaches the graph.
    pub(crate) fn of_second_copy(
        host: Host,
        file: ForeignFile,
        module: Arc<Module>,
        second_copy: SecondCopy,
    ) -> Self {
        let (host, file) = functions(host, file);
        Self { second_copy, ..Self::new(host, file, module) }
    }
}

/// Returns the functions for the setup of the second copy in place of the engine's. Those that are missing fail, and
/// ports of simulated hardware then get no pins.
fn functions(host: Host, file: ForeignFile) -> (Host, ForeignFile) {
    let host = Host {
        item: None,
        stream: None,
        offer: None,
        funct: Some(funct),
        thread: Some(thread),
        ..host
    };
    let file = ForeignFile {
        item: Some(item),
        rename: Some(rename),
        edit: Some(edit),
        join: Some(join),
        ..file
    };
    (host, file)
}

impl SecondCopy {
    /// Gives the second copy an item of the first.
    fn make(&self, l: &Loading, name: &str, spec: &ItemSpec, place: *mut *mut c_void) -> Status {
        let mut items = self.items.borrow_mut();
        let Some(at) = items.iter().position(|m| m.name == name && m.ty == spec.ty) else {
            let why = format!("'{name}': the first copy has not made it");
            return Status(refuse(Some(l), Status::EINVAL.0, &why));
        };
        let first = items.remove(at);
        if !first.status.is_ok() {
            return first.status;
        }
        let to = if place.is_null() {
            spec.storage
        } else {
            let Some(cell) = l.module.take(8) else { return Status::ENOMEM };
            // SAFETY: a block of 8 bytes, aligned.
            unsafe { cell.cast::<u64>().write(spec.initial) };
            // SAFETY: the module's memory for a pointer, which the caller has checked.
            unsafe { place.write(cell.cast()) };
            cell.cast()
        };
        let is_input = [dir::IN, dir::IO, dir::RW].contains(&spec.dir);
        if is_input && spec.ty != ty::PORT {
            self.inputs.borrow_mut().push(Input { from: first.from, to, ty: spec.ty });
        }
        Status::OK
    }
}

/// Returns the reason why the second copy has no further component of this name.
pub(crate) fn no_component(name: &str) -> String {
    format!("hal_init: the first copy has no component '{name}'")
}

/// Refuses a call of the second copy whose result both copies would use at the same time. Returns its error number.
pub(crate) fn refuse_shared(call: &str) -> Option<c_int> {
    running::module().filter(|m| m.is_second_copy())?;
    let why = format!("{call}: motion and the planner would use it at the same time");
    Some(refuse(loading(), Status::EBUSY.0, &why))
}

/// # Safety
/// Called during the setup of the second copy, with a live record and memory for a pointer, or null.
unsafe extern "C" fn item(
    _: *mut c_void,
    spec: *const ItemSpec,
    _owner: u32,
    place: *mut *mut c_void,
) -> Status {
    let Some(l) = loading() else { return Status::EINVAL };
    // SAFETY: the caller's record lives across its call.
    let Some(spec) = (unsafe { ItemSpec::read(spec) }) else { return Status::EINVAL };
    // SAFETY: as above.
    let name = unsafe { spec.name.get() }.unwrap_or_default();
    l.second_copy.make(l, name, &spec, place)
}

/// # Safety
/// Called during the setup of the second copy.
const unsafe extern "C" fn rename(_: *mut c_void, _name: Str) -> Status {
    Status::OK
}

/// # Safety
/// Called during the setup of the second copy.
const unsafe extern "C" fn edit(_: *mut c_void, _: u32, _: Str, _: Str, _: i64) -> Status {
    Status::OK
}

/// # Safety
/// Called during the setup of the second copy.
const unsafe extern "C" fn thread(_: *mut c_void, _: *const ThreadSpec) -> Status {
    Status::OK
}

/// Does not export a funct: those of the first copy run.
///
/// # Safety
/// Called during the setup of the second copy, with a live record.
unsafe extern "C" fn funct(_: *mut c_void, spec: *const FunctSpec) -> Status {
    // SAFETY: the caller's record lives across its call.
    let Some(spec) = (unsafe { FunctSpec::read(spec) }) else { return Status::EINVAL };
    if let Some(free) = spec.free {
        // SAFETY: ownership of the state has passed with the call.
        unsafe { free(spec.state) };
    }
    Status::OK
}

/// # Safety
/// Called during the setup of the second copy, with a live text and memory for a number.
unsafe extern "C" fn join(_: *mut c_void, name: Str, id: *mut u32) -> Status {
    let Some(l) = loading() else { return Status::EINVAL };
    // SAFETY: the caller's text lives across its call.
    let name = unsafe { name.get() }.unwrap_or_default();
    let known = |(_, known): &&(c_int, CString)| CStr::to_bytes(known) == name.as_bytes();
    let Some((number, _)) = l.second_copy.further.iter().find(known) else {
        return Status(refuse(Some(l), Status::EINVAL.0, &no_component(name)));
    };
    // SAFETY: guaranteed by the caller.
    unsafe { id.write(u32::try_from(*number).unwrap_or(u32::MAX)) };
    Status::OK
}
