//! Simulated devices of a line.

use crate::line::{SimulatedFaultPins, SimulatedLine};
use hal_component::Touch;
use hal_modbus_devices::{Device, Slave};

/// Simulated devices of a line.
#[derive(Debug)]
pub(crate) struct Slaves {
    pub(crate) list: Vec<Slave>,
    /// Frames are those of TCP.
    pub(crate) is_tcp: bool,
}

impl Device for Slaves {
    fn advance(&mut self, _: i64) {}

    fn hear(&mut self, frame: &[u8], now_ns: i64, answer: &mut Vec<u8>) -> bool {
        if !self.is_tcp {
            return self.list.hear(frame, now_ns, answer);
        }
        let slave = self.list.iter_mut().find(|slave| frame.get(6) == Some(&slave.unit));
        let served = slave.and_then(|slave| slave.hear_tcp(frame));
        answer.extend(served.iter().flatten());
        served.is_some()
    }
}

/// Simulation of a line.
#[derive(Debug, Touch)]
pub(crate) struct Simulation {
    pub(crate) faults: SimulatedFaultPins,
    #[state]
    pub(crate) line: SimulatedLine<Slaves>,
}
