//! G70 to G72.2: turning cycles along a profile.

use crate::{
    error::Problem,
    interpret::{Run, block::Block},
};

impl Run<'_> {
    pub(super) fn profile(&mut self, _: &Block, _: u16) -> Result<(), Problem> {
        Err(Problem::Unsupported { thing: "G70 to G72.2" })
    }
}
