//! Requests to one inverter.

use crate::station::Question;
use hal_modbus::{
    Miss,
    huanyang::{self, Ask},
};

/// Request to one inverter.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct HyQuestion {
    pub(crate) unit: u8,
    pub(crate) ask: Ask,
}

impl Question for HyQuestion {
    type Answer = u16;

    fn answer_len(&self) -> usize {
        huanyang::MAX_ANSWER
    }

    fn find(&self, bytes: &[u8]) -> Result<Option<u16>, Miss> {
        Ok(huanyang::find(self.unit, self.ask, bytes))
    }

    fn miss(&self, bytes: &[u8]) -> Miss {
        huanyang::miss(self.unit, bytes)
    }
}
