//! Search of a loaded module for kinematics, its second copy, and the offer of the service.

use super::{BothSolvers, Common, Entries, JOINTS, Solver, forward, inverse, switch};
use crate::{
    access, arguments,
    elf::Elf,
    loading::{self, Loading, Refusal},
    mirror::{Made, Mirror},
    module::{self, Module},
    running, system,
};
use core::{
    ffi::{CStr, c_int, c_void},
    sync::atomic::{AtomicBool, AtomicU32, Ordering::Relaxed},
};
use hal_component::abi::{ForeignFile, Host, Kinematics, ServiceSpec, Status, Str, size};
use std::{path::Path, sync::Arc};

/// Highest number of kinematics types that are looked for.
const MAX_TYPES: u32 = 16;

/// Result of `kinematicsType` for kinematics in both directions whose joints are axes.
const IDENTITY: c_int = 1;
/// Result of `kinematicsType` for kinematics in both directions.
const BOTH: c_int = 4;

/// Returns the kinematics of a file, if it has any.
///
/// # Errors
/// A function is missing; the error names it.
pub(crate) fn entries(handle: *mut c_void) -> Result<Option<Entries>, String> {
    let symbol = |name: &CStr| {
        if system::defines(handle, name) {
            system::symbol(handle, name)
        } else {
            core::ptr::null_mut()
        }
    };
    let needed = [c"kinematicsForward", c"kinematicsInverse", c"kinematicsType"];
    let found = needed.map(symbol);
    if found.iter().all(|f| f.is_null()) {
        return Ok(None);
    }
    if let Some((name, _)) = needed.iter().zip(&found).find(|(_, f)| f.is_null()) {
        return Err(format!(
            "it has kinematics without {}: motmod needs kinematicsForward, kinematicsInverse and \
             kinematicsType",
            name.to_string_lossy()
        ));
    }
    let [forward, inverse, kind] = found;
    let [switchable, switch] = [c"kinematicsSwitchable", c"kinematicsSwitch"].map(symbol);
    Ok(Some(Entries {
        // SAFETY: the header defines the type of this symbol, which is not null.
        forward: unsafe { core::mem::transmute::<*mut c_void, super::Solve>(forward) },
        // SAFETY: as above.
        inverse: unsafe { core::mem::transmute::<*mut c_void, super::Solve>(inverse) },
        // SAFETY: as above.
        kind: unsafe { core::mem::transmute::<*mut c_void, super::Ask>(kind) },
        // SAFETY: as above; null is `None`.
        switchable: unsafe { core::mem::transmute::<*mut c_void, Option<super::Ask>>(switchable) },
        // SAFETY: as above.
        switch: unsafe { core::mem::transmute::<*mut c_void, Option<super::Select>>(switch) },
    }))
}

/// Parts of a load that its second copy repeats.
pub(crate) struct Repeat<'l> {
    pub(crate) host: Host,
    pub(crate) file: ForeignFile,
    pub(crate) path: &'l Path,
    pub(crate) elf: &'l Elf,
    pub(crate) words: &'l [String],
}

/// Offers the kinematics of a module whose setup has succeeded. `kind` is the result of its `kinematicsType`, and
/// `items` are its pins and parameters.
///
/// # Errors
/// The kinematics lack a direction, the second copy cannot be loaded, or other kinematics are offered already.
pub(crate) fn offer(
    load: &Repeat<'_>,
    module: &Arc<Module>,
    entries: Entries,
    kind: c_int,
    items: Vec<Made>,
) -> Result<(), Refusal> {
    let refuse = |why: String| (Status::EINVAL, why);
    is_complete(kind).map_err(refuse)?;
    let (twin, again, mirror) = second(load, module, items)
        .map_err(|why| refuse(format!("its second copy, for the planner: {why}")))?;
    let mut types = 1;
    running::within(Arc::as_ptr(&twin), || {
        types = accepted(&again);
        0
    });
    twin.quiet.store(false, Relaxed);
    let common =
        Arc::new(Common { types, selected: AtomicU32::new(0), has_flags: AtomicBool::new(false) });
    let inputs = mirror.inputs.into_inner().into_boxed_slice();
    let table = Kinematics {
        size: size::<Kinematics>(),
        joints: u32::try_from(JOINTS).unwrap_or(0),
        kind: kind.cast_unsigned(),
        joint_of: [0; 12],
        ctx: core::ptr::null(),
        forward: Some(forward),
        inverse: Some(inverse),
        types,
        solutions: None,
        switch: Some(switch),
        worker_ctx: core::ptr::null(),
    };
    let service = Box::into_raw(Box::new(BothSolvers {
        table,
        apart: Solver::new(again, inputs, common.clone(), twin),
        own: Solver::new(entries, Box::default(), common, module.clone()),
    }));
    // SAFETY: made just now, and not shared yet.
    let made = unsafe { &mut *service };
    made.table.ctx = (&raw const made.own).cast();
    made.table.worker_ctx = (&raw const made.apart).cast();
    let spec = ServiceSpec {
        size: size::<ServiceSpec>(),
        version: 1,
        name: Str::new("kinematics"),
        table: (&raw const made.table).cast(),
        state: service.cast(),
        free: Some(free),
        uses: core::ptr::null(),
        n_uses: 0,
    };
    // SAFETY: the engine's function; ownership of the state passes with the call.
    let status =
        load.host.offer.map_or(Status::EINVAL, |f| unsafe { f(load.host.ctx, &raw const spec) });
    // The engine has a text of its own for its refusal.
    if status.is_ok() { Ok(()) } else { Err((status, String::new())) }
}

/// # Safety
/// The engine calls this once, with a state made by [`offer`].
unsafe extern "C" fn free(state: *mut c_void) {
    // SAFETY: made by `Box::into_raw` as a `BothSolvers`; freed once.
    drop(unsafe { Box::from_raw(state.cast::<BothSolvers>()) });
}

/// Refuses kinematics that motion cannot use.
fn is_complete(kind: c_int) -> Result<(), String> {
    let name = match kind {
        IDENTITY | BOTH => return Ok(()),
        2 => "KINEMATICS_FORWARD_ONLY",
        3 => "KINEMATICS_INVERSE_ONLY",
        _ => return Err(format!("kinematicsType returns {kind}, which is no KINEMATICS_TYPE")),
    };
    Err(format!(
        "its kinematics are {name}: motmod needs both directions (KINEMATICS_BOTH or \
         KINEMATICS_IDENTITY)"
    ))
}

/// Loads the file again, with variables of its own, and runs its setup on the values of the first copy.
fn second(
    load: &Repeat<'_>,
    module: &Arc<Module>,
    items: Vec<Made>,
) -> Result<(Arc<Module>, Entries, Mirror), String> {
    let (handle, file) = system::open_copy(load.path)?;
    let twin = Arc::new(module.twin(handle, file));
    access::take_over(&twin, load.elf);
    arguments::set(&twin, &load.elf.parameters, load.words)?;
    let (Some(again), (Some(main), _)) = (entries(handle)?, module::entries(handle)) else {
        return Err("it has no kinematics".to_owned());
    };
    let mut loading = Loading::new(load.host, load.file, twin.clone());
    loading.mirror = Some(Mirror::new(items));
    let code = loading::within(&loading, || {
        let code = running::within(Arc::as_ptr(&twin), || main());
        if code >= 0 {
            running::within(Arc::as_ptr(&twin), || (again.kind)());
        }
        code
    });
    if code < 0 {
        return Err(format!("rtapi_app_main: {} ({code})", system::explained(code)));
    }
    twin.made.store(true, Relaxed);
    loading.mirror.map(|mirror| (twin, again, mirror)).ok_or_else(String::new)
}

/// Counts the types that a module accepts, from 0, and selects type 0 again.
fn accepted(of: &Entries) -> u32 {
    let (Some(switchable), Some(switch)) = (of.switchable, of.switch) else { return 1 };
    if switchable() == 0 {
        return 1;
    }
    let is_type = |n: &u32| switch(c_int::try_from(*n).unwrap_or(c_int::MAX)) == 0;
    let count = (0..MAX_TYPES).take_while(is_type).count();
    switch(0);
    u32::try_from(count).unwrap_or(1).max(1)
}
