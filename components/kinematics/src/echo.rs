//! The pins that examples of kinematics have beside their own.

use crate::instances::prefixes;
use hal_component::{Builder, Error, In, Out, ParamRo, ParamRw, Period, Touch, Update, pins};

pins! {
    /// What shows how pins and parameters are made.
    pub(crate) struct Echo {
        /// Any number.
        input: In<u32> = "in", 0;
        /// The number, as it was when joints were last computed.
        output: Out<u32> = "out", 0;
        /// A parameter that is not used.
        own: ParamRo<f64> = "param-ro", 0.0;
        /// A parameter that is not used.
        user: ParamRw<f64> = "param-rw", 0.0;
    }
}

impl Echo {
    /// What comes in goes out.
    pub(crate) fn repeat(&self) {
        self.output.set(self.input.get());
    }
}

/// A function with a pin.
#[derive(Debug, Touch)]
struct Demo {
    pin: Out<i32>,
}

impl Update for Demo {
    fn update(&mut self, _: Period) {
        self.pin.set(0);
    }
}

/// For each instance a pin and a function that shows how they are made.
pub(crate) fn demonstrate(b: &mut Builder<'_>, name: &str) -> Result<(), Error> {
    for prefix in prefixes(b, name)? {
        let pin = b.item(&format!("{prefix}.fpin"), "Shows how a pin is made.", 0)?;
        b.function(&format!("{prefix}.fdemo"), "Shows how a function is made.", Demo { pin })?;
    }
    Ok(())
}
