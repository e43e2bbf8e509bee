//! The service `interlock`: the e-stop state for realtime threads.

use crate::{Touch, Uses, abi, service::Found};
use core::ffi::c_void;

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

/// Returns the table for a value of this type.
pub(crate) const fn table<I: Interlock>() -> abi::Interlock {
    abi::Interlock {
        size: abi::size::<abi::Interlock>(),
        flags: 0,
        ctx: core::ptr::null(),
        state: Some(state::<I>),
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
pub struct InterlockRef(pub(crate) Found<abi::Interlock>);

impl InterlockRef {
    /// Realtime. Returns the state of the e-stop. Without a valid answer, both conditions count as
    /// e-stop.
    #[must_use]
    pub fn state(&self) -> Estop {
        let Some(state) = self.0.table.state else { return Estop::UNKNOWN };
        // SAFETY: this is the provider's function with its own context.
        Estop::of(unsafe { state(self.0.table.ctx) })
    }
}

impl Touch for InterlockRef {
    fn touch(&self, uses: &mut Uses) {
        self.0.touch(uses);
    }
}

#[cfg(test)]
mod tests {
    use super::{Estop, Found, InterlockRef, abi};

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
            let table = table(state);
            // SAFETY: the table lives during the call.
            let found = unsafe { Found::read((&raw const table).cast(), Vec::new()) };
            InterlockRef(found.unwrap()).state().is_released()
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
