//! Search of a loaded module for kinematics, its second copy, and the offer of the service.

use super::{BothSolvers, Common, Entries, JOINTS, Solver, forward, inverse, switch};
use crate::{
    arguments,
    elf::Elf,
    load::{failed, set_up},
    loading::{self, Loading, Refusal},
    module::{self, Module},
    objects, outside, running,
    second_copy::{Input, SecondCopy},
    service::{self, ModuleService},
    system,
};
use core::{
    ffi::{CStr, c_int, c_void},
    sync::atomic::{AtomicBool, AtomicU32, Ordering::Relaxed},
};
use hal_component::abi::{ForeignFile, Host, Kinematics, Status, size};
use std::{path::Path, sync::Arc};

/// Highest number of kinematics types that are looked for.
const MAX_TYPES: c_int = 16;

/// Functions that motion needs.
const NEEDED: [&CStr; 3] = [c"kinematicsForward", c"kinematicsInverse", c"kinematicsType"];

impl Entries {
    /// Returns whether a file has kinematics, or a part of them.
    pub(crate) fn has_any(handle: *mut c_void) -> bool {
        NEEDED.iter().any(|name| system::defines(handle, name))
    }

    /// Returns the kinematics of a file.
    ///
    /// # Errors
    /// A function is missing; the error names it.
    pub(crate) fn read(handle: *mut c_void) -> Result<Self, String> {
        if let Some(name) = NEEDED.iter().find(|name| !system::defines(handle, name)) {
            return Err(format!(
                "it has kinematics without {}: motmod needs kinematicsForward, kinematicsInverse \
                 and kinematicsType",
                name.to_string_lossy()
            ));
        }
        let [forward, inverse, kind] = NEEDED.map(|name| system::symbol(handle, name));
        let [switchable, switch] = [c"kinematicsSwitchable", c"kinematicsSwitch"].map(|name| {
            let is_own = system::defines(handle, name);
            if is_own { system::symbol(handle, name) } else { core::ptr::null_mut() }
        });
        Ok(Self {
            // SAFETY: the header defines the type of this symbol, which is not null.
            forward: unsafe { core::mem::transmute::<*mut c_void, super::SolveFunction>(forward) },
            // SAFETY: as above.
            inverse: unsafe { core::mem::transmute::<*mut c_void, super::SolveFunction>(inverse) },
            // SAFETY: as above.
            kind: unsafe { core::mem::transmute::<*mut c_void, super::NumberFunction>(kind) },
            // SAFETY: as above; null is `None`.
            switchable: unsafe {
                core::mem::transmute::<*mut c_void, Option<super::NumberFunction>>(switchable)
            },
            // SAFETY: as above.
            switch: unsafe {
                core::mem::transmute::<*mut c_void, Option<super::SwitchFunction>>(switch)
            },
        })
    }

    /// Calls `kinematicsSwitchable`. Without it, and without `kinematicsSwitch`, returns zero.
    pub(crate) fn switchable(&self) -> c_int {
        self.switchable.filter(|_| self.switch.is_some()).map_or(0, |switchable| switchable())
    }

    /// Calls `kinematicsSwitch`.
    pub(crate) fn select(&self, to: c_int) -> c_int {
        self.switch.map_or(-1, |switch| switch(to))
    }

    /// Counts the types that `kinematicsSwitch` accepts, from 0.
    pub(crate) fn count_types(&self) -> c_int {
        (0..MAX_TYPES).find(|n| self.select(*n) != 0).unwrap_or(MAX_TYPES)
    }
}

/// Parts of a load that both copies of a module have in common.
pub(crate) struct Parts<'l> {
    pub(crate) host: Host,
    pub(crate) file: ForeignFile,
    pub(crate) path: &'l Path,
    pub(crate) elf: &'l Elf,
    pub(crate) words: &'l [String],
}

/// Offers the kinematics of a module whose setup has succeeded. `kind` is the result of its `kinematicsType`, and
/// `first` what its setup has made.
///
/// # Errors
/// The kinematics lack a direction, the second copy cannot be loaded, a type cannot be selected, or other kinematics are
/// offered already.
pub(crate) fn offer(
    load: &Parts<'_>,
    module: &Arc<Module>,
    entries: Entries,
    kind: c_int,
    first: SecondCopy,
) -> Result<(), Refusal> {
    let refuse = |why: String| (Status::EINVAL, why);
    let kind = usable(kind).map_err(refuse)?;
    let (second_copy, second_entries, inputs) = load_second(load, module, first)
        .map_err(|why| refuse(format!("its second copy, for the planner: {why}")))?;
    let types = select_first_type([(module, &entries), (&second_copy, &second_entries)]);
    let types = types.map_err(refuse)?;
    second_copy.quiet.store(false, Relaxed);
    let common =
        Arc::new(Common { types, selected: AtomicU32::new(0), has_flags: AtomicBool::new(false) });
    let table = Kinematics {
        size: size::<Kinematics>(),
        joints: u32::try_from(JOINTS).unwrap_or(0),
        // Joints are axes in one of several types at most.
        kind: if types > 1 { Kinematics::BOTH } else { kind },
        joint_of: [0; 12],
        ctx: core::ptr::null(),
        forward: Some(forward),
        inverse: Some(inverse),
        types,
        solutions: None,
        switch: Some(switch),
        worker_ctx: core::ptr::null(),
    };
    let inputs = inputs.into_boxed_slice();
    let solvers = BothSolvers {
        table,
        planner_copy: Solver::new(second_entries, inputs, common.clone(), second_copy),
        motion_copy: Solver::new(entries, Box::default(), common, module.clone()),
    };
    service::offer(&load.host, solvers)
}

impl ModuleService for BothSolvers {
    const NAME: &'static str = "kinematics";
    type Table = Kinematics;

    fn table(&mut self) -> &Kinematics {
        self.table.ctx = (&raw const self.motion_copy).cast();
        self.table.worker_ctx = (&raw const self.planner_copy).cast();
        &self.table
    }
}

/// Returns the kind of kinematics whose `kinematicsType` has returned `kind`.
///
/// # Errors
/// Motion cannot use them.
fn usable(kind: c_int) -> Result<u32, String> {
    let name = match kind.cast_unsigned() {
        usable @ (Kinematics::IDENTITY | Kinematics::BOTH) => return Ok(usable),
        Kinematics::FORWARD_ONLY => "KINEMATICS_FORWARD_ONLY",
        Kinematics::INVERSE_ONLY => "KINEMATICS_INVERSE_ONLY",
        _ => return Err(format!("kinematicsType returns {kind}, which is no KINEMATICS_TYPE")),
    };
    Err(format!(
        "its kinematics are {name}: motmod needs both directions (KINEMATICS_BOTH or \
         KINEMATICS_IDENTITY)"
    ))
}

/// Loads the file again, with variables of its own, and repeats the setup of the first copy.
fn load_second(
    load: &Parts<'_>,
    module: &Arc<Module>,
    first: SecondCopy,
) -> Result<(Arc<Module>, Entries, Vec<Input>), String> {
    let before = objects::mapped();
    let (handle, file) = system::open_copy(load.path)?;
    let second_copy = Arc::new(module.second_copy(handle, file));
    outside::redirect(&second_copy, &before)?;
    arguments::set(&second_copy, &load.elf.parameters, load.words)?;
    let (main, entries) = (module::main(handle)?, Entries::read(handle)?);
    let loading = Loading::of_second_copy(load.host, load.file, second_copy.clone(), first);
    let done = loading::within(&loading, || set_up(&second_copy, main, Some(entries), || ()));
    if let Some(why) = loading.second_copy.refusal(loading.refusals.into_inner()) {
        return Err(why);
    }
    done.map_err(failed)?;
    Ok((second_copy, entries, loading.second_copy.inputs.into_inner()))
}

/// Selects type 0 in both copies of a module: it may begin in another. Returns the number of types.
///
/// # Errors
/// A copy refuses the type.
fn select_first_type(copies: [(&Arc<Module>, &Entries); 2]) -> Result<u32, String> {
    let [_, (second_copy, entries)] = copies;
    let count = running::within(Arc::as_ptr(second_copy), || match entries.switchable() {
        0 => 0,
        _ => entries.count_types(),
    });
    for (copy, entries) in copies.into_iter().filter(|_| count > 0) {
        let was_quiet = copy.quiet.swap(true, Relaxed);
        let code = running::within(Arc::as_ptr(copy), || entries.select(0));
        copy.quiet.store(was_quiet, Relaxed);
        if code != 0 {
            return Err(format!("kinematicsSwitch does not select type 0 again ({code})"));
        }
    }
    Ok(count.max(1).cast_unsigned())
}
