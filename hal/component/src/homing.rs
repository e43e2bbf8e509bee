//! The service `homing`: a module homes the joints in the place of the motion controller.

use crate::{
    abi::{self, HomingJoint, HomingSettings, Host, Status, homing_state},
    service::Found,
};

/// Homing module that another plugin offers.
#[derive(Clone, Debug)]
pub struct HomingRef(pub(crate) Found<abi::Homing>);

/// State of a joint that a homing module reports.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct HomingState(u32);

impl HomingState {
    /// Returns whether the joint is homed.
    #[must_use]
    pub const fn is_homed(self) -> bool {
        self.0 & homing_state::HOMED != 0
    }

    /// Returns whether the joint is being homed.
    #[must_use]
    pub const fn is_homing(self) -> bool {
        self.0 & homing_state::HOMING != 0
    }

    /// Returns whether the module has nothing to do with the joint.
    #[must_use]
    pub const fn is_idle(self) -> bool {
        self.0 & homing_state::IDLE != 0
    }

    /// Returns whether the joint waits for an index, and whether that has not come yet.
    #[must_use]
    pub const fn index(self) -> (bool, bool) {
        (self.0 & homing_state::INDEX_WAIT != 0, self.0 & homing_state::INDEX_ENABLE != 0)
    }

    /// Returns whether the joint's lock is wanted open.
    #[must_use]
    pub const fn wants_open_lock(self) -> bool {
        self.0 & homing_state::UNLOCK != 0
    }
}

impl HomingRef {
    /// Returns the name of the module.
    #[must_use]
    pub fn name(&self) -> &str {
        // SAFETY: the provider keeps the name as long as its service, which outlives this handle.
        unsafe { self.0.table.name.get() }.unwrap_or_default()
    }

    /// Has the module create its pins with this host.
    pub(crate) fn open(&self, host: &Host, period: f64, joints: u32, extra: u32) -> Status {
        let Some(open) = self.0.table.open else { return Status::EINVAL };
        // SAFETY: this is the provider's function with its own context; the host lives for the call.
        unsafe { open(self.0.table.ctx, &raw const *host, period, joints, extra) }
    }

    /// Realtime. Sets the settings of a joint; `update` if only offset, position and sequence have
    /// changed.
    pub fn configure(&self, joint: usize, settings: &HomingSettings, update: bool) {
        let Some(configure) = self.0.table.configure else { return };
        // SAFETY: this is the provider's function; the record lives for the duration of the call.
        unsafe { configure(self.0.table.ctx, number(joint), settings, u32::from(update)) }
    }

    /// Realtime. Writes the record of a joint.
    pub fn put(&self, joint: usize, record: &HomingJoint) {
        let Some(put) = self.0.table.put else { return };
        // SAFETY: this is the provider's function; the record lives for the duration of the call.
        unsafe { put(self.0.table.ctx, number(joint), record) }
    }

    /// Realtime. Reads the record of a joint into `record`, which must have been written before.
    pub fn take(&self, joint: usize, record: &mut HomingJoint) {
        let Some(take) = self.0.table.take else { return };
        // SAFETY: this is the provider's function; the record lives for the duration of the call.
        unsafe { take(self.0.table.ctx, number(joint), record) }
    }

    /// Realtime. Calls a function of the module, one of [`abi::homing_call`], for a joint, or for all
    /// with a number below 0. [`abi::homing_call::RUN`] returns whether the module homes any joint.
    pub fn call(&self, what: u32, joint: i32) -> bool {
        // SAFETY: this is the provider's function with its own context.
        self.0.table.call.is_some_and(|call| unsafe { call(self.0.table.ctx, what, joint) } != 0)
    }

    /// Realtime. Returns the state of a joint.
    #[must_use]
    pub fn state(&self, joint: usize) -> HomingState {
        let state = self.0.table.state;
        // SAFETY: this is the provider's function with its own context.
        HomingState(state.map_or(0, |state| unsafe { state(self.0.table.ctx, number(joint)) }))
    }
}

fn number(joint: usize) -> u32 {
    u32::try_from(joint).unwrap_or(u32::MAX)
}
