//! Realtime. The pin that selects the kinematics type of a machine, and the type in force.

use hal_component::{Builder, Decl, Error, In, Messages, Touch};

/// Pin `motion.switchkins-type`, if the kinematics have several types.
#[derive(Clone, Debug, Touch)]
pub(crate) struct SwitchPins {
    wanted: Vec<In<f64>>,
}

impl SwitchPins {
    pub(crate) fn make(b: &mut Builder<'_>, types: u32) -> Result<Self, Error> {
        let mut wanted = Vec::new();
        if types > 1 {
            let decl = Decl::new(
                "motion.switchkins-type",
                "Which type of the kinematics is in force, without its fraction: 0 their own, 1 \
                 and 2 as they say. Changes take effect when the machine stands still; a type \
                 that there is not is refused.",
            );
            wanted.push(b.declare(decl, 0.0)?);
        }
        Ok(Self { wanted })
    }
}

/// Current type.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Switch {
    pub(crate) is: u32,
    /// Last refused request, so that it is reported only once.
    refused: Option<f64>,
}

impl Switch {
    /// Returns the type that the pin names, and the pin's value. Reports a type that does not exist, once.
    pub(crate) fn requested(
        &mut self,
        pins: &SwitchPins,
        types: u32,
        say: &Messages,
    ) -> Option<(u32, f64)> {
        let wanted = pins.wanted.first().map(In::get)?;
        if self.refused.is_some_and(|r| r.to_bits() == wanted.to_bits()) {
            return None;
        }
        let Some(to) = whole(wanted).filter(|to| *to < types) else {
            self.refuse(wanted, "there are no kinematics of type {}", say);
            return None;
        };
        self.refused = None;
        Some((to, wanted))
    }

    /// Refuses a request, and reports the reason.
    pub(crate) fn refuse(&mut self, wanted: f64, why: &'static str, say: &Messages) {
        self.refused = Some(wanted);
        say.error(why, &[wanted]);
    }
}

/// Truncates a number to an integer; `None` for negative results and NaN.
fn whole(wanted: f64) -> Option<u32> {
    (0..=MAX_TYPE).find(|n| f64::from(*n) == libm::trunc(wanted))
}

/// Largest number of a type in any kinematics.
const MAX_TYPE: u32 = 15;
