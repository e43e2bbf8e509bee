//! Parameters that are TRUE while a sensor measures the value of a pin.

use crate::{Builder, Decl, Error, Item, ParamRo, Value, builder::check, item::Dir};

impl Builder<'_> {
    /// Declares a parameter that is TRUE while a sensor measures the value of `pin`. It is FALSE while the pin has no
    /// writer, or while its value comes from commands alone, as the count of a step generator does. The engine keeps it,
    /// also when links change.
    ///
    /// # Errors
    /// As [`Self::item`].
    pub fn measured<T: Value, D: Dir>(
        &mut self,
        pin: &Item<T, D>,
        decl: Decl<'_>,
    ) -> Result<ParamRo<bool>, Error> {
        let answer: ParamRo<bool> = self.declare(decl, false)?;
        if let Some(measured) = self.host.measured {
            // SAFETY: this is the engine's function; both are slots of this instance.
            check(unsafe { measured(self.host.ctx, pin.slot(), answer.slot()) })?;
        }
        Ok(answer)
    }
}
