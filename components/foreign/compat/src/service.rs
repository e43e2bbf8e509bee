//! Services of a module in C: their offer to other plugins.

use crate::loading::Refusal;
use core::ffi::c_void;
use hal_component::abi::{Host, Record, ServiceSpec, Status, Str, size};

/// Value of an offered service, with the table of its functions.
pub(crate) trait ModuleService {
    /// Name of the service.
    const NAME: &'static str;

    /// Record of the functions.
    type Table: Record;

    /// Returns the table, whose contexts point into this value, which no longer moves.
    fn table(&mut self) -> &Self::Table;
}

/// Offers a service, version 1. It lives until the engine frees it.
///
/// # Errors
/// Another component offers it already.
pub(crate) fn offer<S: ModuleService>(host: &Host, service: S) -> Result<(), Refusal> {
    /// # Safety
    /// The engine calls this once, with a state made by [`offer`].
    unsafe extern "C" fn free<S>(state: *mut c_void) {
        // SAFETY: made by `Box::into_raw`; freed once.
        drop(unsafe { Box::from_raw(state.cast::<S>()) });
    }
    let service = Box::into_raw(Box::new(service));
    // SAFETY: made just now, and not shared yet.
    let table = unsafe { &mut *service }.table();
    let spec = ServiceSpec {
        size: size::<ServiceSpec>(),
        version: 1,
        name: Str::new(S::NAME),
        table: (&raw const *table).cast(),
        state: service.cast(),
        free: Some(free::<S>),
        uses: core::ptr::null(),
        n_uses: 0,
    };
    // SAFETY: the engine's function; ownership of the state passes with the call.
    let status = host.offer.map_or(Status::EINVAL, |f| unsafe { f(host.ctx, &raw const spec) });
    // The engine has a text of its own for its refusal.
    if status.is_ok() { Ok(()) } else { Err((status, String::new())) }
}
