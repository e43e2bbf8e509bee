//! The service `interlock`: the e-stop state for realtime threads.

use crate::{
    Touch, Uses,
    abi::{self, Record, ServiceSpec, Str, Use},
    shim,
};
use core::ffi::c_void;

pub(crate) const NAME: &str = "interlock";
pub(crate) const VERSION: u32 = 1;

/// State of the e-stop. Motion is allowed only while it is released.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Estop {
    /// True while an e-stop is commanded.
    pub commanded: bool,
    /// True while the e-stop chain is open: `emc-enable-in` is FALSE.
    pub open: bool,
}

impl Estop {
    /// State of an interlock that returns no valid answer.
    const UNKNOWN: Self = Self { commanded: true, open: true };

    /// Returns whether the machine is out of e-stop.
    #[must_use]
    pub const fn is_released(self) -> bool {
        !self.commanded && !self.open
    }

    pub(crate) const fn bits(self) -> u32 {
        let commanded = if self.commanded { 0 } else { abi::Interlock::NOT_COMMANDED };
        let open = if self.open { 0 } else { abi::Interlock::ENABLED };
        commanded | open
    }

    /// Decodes an answer. An answer with unknown bits is invalid.
    pub(crate) const fn of(bits: u32) -> Self {
        if bits & !abi::Interlock::RELEASED != 0 {
            return Self::UNKNOWN;
        }
        Self {
            commanded: bits & abi::Interlock::NOT_COMMANDED == 0,
            open: bits & abi::Interlock::ENABLED == 0,
        }
    }
}

/// An interlock that a component offers. It must be reentrant, allocate nothing and take no locks.
pub trait Interlock: Touch + Send + Sync + 'static {
    /// Realtime. Returns the current state of the e-stop.
    fn state(&self) -> Estop;
}

struct Offered<I> {
    interlock: I,
    table: abi::Interlock,
}

pub(crate) fn offer<I: Interlock>(interlock: I, uses: &[Use]) -> ServiceSpec {
    let table = abi::Interlock {
        size: abi::size::<abi::Interlock>(),
        flags: 0,
        ctx: core::ptr::null(),
        state: Some(state::<I>),
    };
    let given = shim::give(Offered { interlock, table }).cast::<Offered<I>>();
    // SAFETY: the value was just created and is not shared yet.
    let offered = unsafe { &mut *given };
    offered.table.ctx = (&raw const offered.interlock).cast();
    ServiceSpec {
        size: abi::size::<ServiceSpec>(),
        version: VERSION,
        name: Str::new(NAME),
        table: (&raw const offered.table).cast(),
        state: given.cast(),
        free: Some(shim::free::<Offered<I>>),
        uses: uses.as_ptr(),
        n_uses: uses.len(),
    }
}

/// # Safety
/// `ctx` must point to a live `I`.
unsafe extern "C" fn state<I: Interlock>(ctx: *const c_void) -> u32 {
    // SAFETY: this is the table's own context.
    let interlock = unsafe { &*ctx.cast::<I>() };
    interlock.state().bits()
}

/// An interlock that another plugin offers. A function that holds it declares the pins that the
/// interlock accesses.
#[derive(Clone, Debug)]
pub struct InterlockRef {
    table: abi::Interlock,
    uses: Vec<Use>,
}

// SAFETY: the function is reentrant, the provider stays loaded as long as its user, and the uses
// are only compared.
unsafe impl Send for InterlockRef {}
// SAFETY: as for `Send`.
unsafe impl Sync for InterlockRef {}

/// # Safety
/// `table` must be null or the live table of a service of this name and version.
pub(crate) unsafe fn found(table: *const c_void, uses: Vec<Use>) -> Option<InterlockRef> {
    // SAFETY: guaranteed by the caller.
    let table = unsafe { abi::Interlock::read(table.cast()) }?;
    Some(InterlockRef { table, uses })
}

impl InterlockRef {
    /// Realtime. Returns the state of the e-stop. Without a valid answer, both conditions count as
    /// e-stop.
    #[must_use]
    pub fn state(&self) -> Estop {
        let Some(state) = self.table.state else { return Estop::UNKNOWN };
        // SAFETY: this is the provider's function with its own context.
        Estop::of(unsafe { state(self.table.ctx) })
    }
}

impl Touch for InterlockRef {
    fn touch(&self, uses: &mut Uses) {
        uses.0.extend_from_slice(&self.uses);
    }
}

#[cfg(test)]
mod tests {
    use super::{Estop, InterlockRef, abi};

    /// # Safety
    /// The function does not access its argument.
    unsafe extern "C" fn answer<const BITS: u32>(_: *const core::ffi::c_void) -> u32 {
        BITS
    }

    #[test]
    fn one_answer_alone_is_no_estop() {
        let table = |state| abi::Interlock {
            size: abi::size::<abi::Interlock>(),
            flags: 0,
            ctx: core::ptr::null(),
            state,
        };
        let released = |state| {
            let interlock = InterlockRef { table: table(state), uses: Vec::new() };
            interlock.state().is_released()
        };
        assert!(released(Some(answer::<{ abi::Interlock::RELEASED }>)));
        assert!(!released(None));
        assert!(!released(Some(answer::<0>)));
        assert!(!released(Some(answer::<{ abi::Interlock::NOT_COMMANDED }>)));
        assert!(!released(Some(answer::<{ abi::Interlock::ENABLED }>)));
        assert!(!released(Some(answer::<7>)));
        assert!(!released(Some(answer::<{ u32::MAX }>)));
        for commanded in [false, true] {
            for open in [false, true] {
                let state = Estop { commanded, open };
                assert_eq!(Estop::of(state.bits()), state);
            }
        }
    }
}
