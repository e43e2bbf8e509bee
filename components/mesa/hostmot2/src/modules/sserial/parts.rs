//! Realtime. Parts of a port: its pins, its remotes, and the registers that its two halves share.

use super::{data::Given, talk::CHANNELS};
use core::sync::atomic::AtomicU32;
use hal_component::{In, Out, ParamRw, Touch, Uses, pins};

pins! {
    /// Pins of a port.
    pub(crate) struct PortPins {
        /// TRUE to exchange data with the remotes. FALSE stops the port: the remotes switch their outputs off, and parameters that
        /// were changed are sent. FALSE and then TRUE begins again after a fault.
        run: In<bool> = "run", true;
        /// Level of faults: a cycle with one adds `fault-inc`, and each cycle takes `fault-dec`.
        level: Out<u32> = "fault-count", 0;
        /// State of the port: 0 off, 1 stops, 2 starts, 3 runs, 4 stopped by faults, 7 sends parameters.
        state: Out<u32> = "port_state", 0;
        /// Channels whose last exchange failed, bit 0 for channel 0.
        failing: Out<u32> = "port_state2", 0;
        /// Command that the port has not finished; 0 for none.
        command: Out<u32> = "port_state3", 0;
        /// Added to the level by a cycle with a fault.
        increment: ParamRw<u32> = "fault-inc", 10;
        /// Taken from the level by each cycle.
        decrement: ParamRw<u32> = "fault-dec", 1;
        /// Level at which the port is stopped.
        limit: ParamRw<u32> = "fault-lim", 200;
    }
}

/// Registers of a port as the last answer had them.
#[derive(Debug, Default)]
pub(crate) struct Seen {
    /// Number of answers, and of those to a question before which a packet of writes was lost.
    pub(crate) answers: AtomicU32,
    pub(crate) missed: AtomicU32,
    pub(crate) command: AtomicU32,
    pub(crate) data: AtomicU32,
    pub(crate) status: [AtomicU32; CHANNELS],
}

/// Number of the start to which the exchange of the last cycle belongs; 0 if there was none.
pub(crate) type Exchanged = AtomicU32;

/// Remote of a running port.
pub(crate) struct Remote {
    pub(crate) channel: usize,
    pub(crate) mode: u8,
    pub(crate) given: Vec<Given>,
    /// Number of registers that the data need.
    pub(crate) registers: usize,
    pub(crate) fault: Out<bool>,
    pub(crate) texts: Texts,
    /// True while faults of this row have been reported.
    pub(crate) reported: bool,
}

impl Touch for Remote {
    fn touch(&self, uses: &mut Uses) {
        for given in &self.given {
            given.touch(uses);
        }
        self.fault.touch(uses);
    }
}

/// Messages about a remote, with its names in them.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Texts {
    pub(crate) silent: &'static str,
    pub(crate) bitten: &'static str,
    pub(crate) fault: &'static str,
    pub(crate) stopped: &'static str,
    pub(crate) setting: &'static str,
}
