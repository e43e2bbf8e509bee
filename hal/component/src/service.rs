//! Services: tables of functions that a component offers to other plugins.

use crate::{
    Touch, Uses,
    abi::{self, Record, ServiceSpec, Str, Use},
    shim,
};
use core::ffi::c_void;

/// Table of the functions of a service.
pub(crate) trait Table: Record {
    /// Name of the service.
    const NAME: &'static str;
    /// Version of the service.
    const VERSION: u32;

    /// Returns the first argument of each function of the table.
    fn ctx(&mut self) -> &mut *const c_void;
}

/// Declares tables, with the name and the version of their services.
macro_rules! tables {
    ($($table:ident, $name:literal, $version:literal;)*) => {
        $(impl Table for abi::$table {
            const NAME: &'static str = $name;
            const VERSION: u32 = $version;

            fn ctx(&mut self) -> &mut *const c_void {
                &mut self.ctx
            }
        })*
    };
}

tables! {
    Homing, "homing", 1;
    Interlock, "interlock", 1;
    IoControl, "iocontrol", 1;
    Kinematics, "kinematics", 1;
    Motion, "motion", 1;
    Operator, "operator", 1;
}

struct Offered<T, F> {
    value: T,
    table: F,
}

/// Returns the description of a service: the functions of `table`, which get a pointer to `value`
/// and access `uses`. The description is valid as long as `uses`.
pub(crate) fn offer<T: Send + Sync + 'static, F: Table>(
    value: T,
    table: F,
    uses: &[Use],
) -> ServiceSpec {
    let given = shim::give(Offered { value, table }).cast::<Offered<T, F>>();
    // SAFETY: the value was just created and is not shared yet.
    let offered = unsafe { &mut *given };
    *offered.table.ctx() = (&raw const offered.value).cast();
    ServiceSpec {
        size: abi::size::<ServiceSpec>(),
        version: F::VERSION,
        name: Str::new(F::NAME),
        table: (&raw const offered.table).cast(),
        state: given.cast(),
        free: Some(shim::free::<Offered<T, F>>),
        uses: uses.as_ptr(),
        n_uses: uses.len(),
    }
}

/// Table of a service that another plugin offers, and what its functions access.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Found<F, U = Vec<Use>> {
    pub(crate) table: F,
    uses: U,
}

// SAFETY: the offered value is `Sync`, so its functions may be called from any thread; the provider
// stays loaded as long as its user, and the uses are only compared.
unsafe impl<F: Table, U: AsRef<[Use]>> Send for Found<F, U> {}
// SAFETY: as for `Send`.
unsafe impl<F: Table, U: AsRef<[Use]>> Sync for Found<F, U> {}

impl<F: Table, U> Found<F, U> {
    /// # Safety
    /// `table` must be null or the live table of a service of this name and version.
    pub(crate) unsafe fn read(table: *const c_void, uses: U) -> Option<Self> {
        // SAFETY: guaranteed by the caller.
        let table = unsafe { F::read(table.cast()) }?;
        Some(Self { table, uses })
    }
}

impl<F, U: AsRef<[Use]>> Touch for Found<F, U> {
    fn touch(&self, uses: &mut Uses) {
        uses.0.extend_from_slice(self.uses.as_ref());
    }
}
