//! Demonstration pins of the kinematics that serve as templates.

use crate::instances::prefixes;
use hal_component::{Builder, Error, In, Out, ParamRo, ParamRw, Period, Touch, Update, pins};

pins! {
    /// Pins and parameters that show how each kind is made.
    pub(crate) struct Echo {
        /// Any number.
        input: In<u32> = "in", 0;
        /// Value of `in` when joints were last computed.
        output: Out<u32> = "out", 0;
        /// Parameter without effect.
        own: ParamRo<f64> = "param-ro", 0.0;
        /// Parameter without effect.
        user: ParamRw<f64> = "param-rw", 0.0;
    }
}

impl Echo {
    /// Copies `in` to `out`.
    pub(crate) fn repeat(&self) {
        self.output.set(self.input.get());
    }
}

/// Function with a pin.
#[derive(Debug, Touch)]
struct Demo {
    pin: Out<i32>,
}

impl Update for Demo {
    fn update(&mut self, _: Period) {
        self.pin.set(0);
    }
}

/// Makes a demonstration pin and function for each instance.
pub(crate) fn demonstrate(b: &mut Builder<'_>, name: &str) -> Result<(), Error> {
    for prefix in prefixes(b, name)? {
        let pin = b.item(&format!("{prefix}.fpin"), "Shows how a pin is made.", 0)?;
        b.function(&format!("{prefix}.fdemo"), "Shows how a function is made.", Demo { pin })?;
    }
    Ok(())
}
