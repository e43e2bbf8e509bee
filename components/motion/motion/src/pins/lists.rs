//! Pins whose number or names come from the arguments.

use super::{make, pins};
use crate::setup::{Names, Setup};
use hal_component::{Builder, Error, Field, In, Out, Touch};

pins! {
    /// Pins of a joint in `unlock_joints_mask`.
    UnlockPins {
        /// TRUE to open the joint's lock: while homing with locking-indexer moves the joint, until it is at rest.
        unlock: Out<bool> = false, "unlock" was "unlock";
        /// TRUE when the joint's lock is open. While it is closed, jogs of axes that move the joint are refused, and a
        /// coordinated move ends where the joint would begin to move.
        is_unlocked: In<bool> = false, "is-unlocked" was "is-unlocked";
    }
}

pins! {
    /// Pins of an extra joint.
    ExtraPins {
        /// Position command of the joint in machine units once it is homed; NaN and infinity leave it unchanged. A step
        /// longer than the joint's max-velocity allows in one cycle switches the machine off and is not written. That
        /// includes the first step from the joint's position after it is homed or the machine is switched on.
        posthome_cmd: In<f64> = 0.0, "posthome-cmd";
    }
}

/// Digital and analog inputs and outputs, and further causes to switch off.
#[derive(Clone, Debug, Touch)]
pub(crate) struct Lists {
    pub(crate) digital_in: Vec<In<bool>>,
    pub(crate) digital_out: Vec<Out<bool>>,
    pub(crate) analog_in: Vec<In<f64>>,
    pub(crate) analog_out: Vec<Out<f64>>,
    pub(crate) misc_errors: Vec<In<bool>>,
}

impl Lists {
    pub(crate) fn make(b: &mut Builder<'_>, setup: &Setup) -> Result<Self, Error> {
        Ok(Self {
            digital_in: list(
                b,
                &setup.digital_in,
                ["digital-in-", "din-"],
                "Digital input for programs; motion.status shows it.",
                false,
            )?,
            digital_out: list(
                b,
                &setup.digital_out,
                ["digital-out-", "dout-"],
                "Digital output, as motion.digital-out last set it.",
                false,
            )?,
            analog_in: list(
                b,
                &setup.analog_in,
                ["analog-in-", "ain-"],
                "Analog input for programs, in the unit of its source, to be waited for or read. Not used \
                 yet.",
                false,
            )?,
            analog_out: list(
                b,
                &setup.analog_out,
                ["analog-out-", "aout-"],
                "Analog output, as motion.analog-out last set it, in whatever unit that means.",
                false,
            )?,
            misc_errors: list(
                b,
                &setup.misc_errors,
                ["misc-error-", "err-"],
                "TRUE switches the machine off: for a sensor or component that no other input \
                 stands for.",
                true,
            )?,
        })
    }
}

fn list<F: Field>(
    b: &mut Builder<'_>,
    names: &Names,
    [numbered, named]: [&str; 2],
    doc: &str,
    safety: bool,
) -> Result<Vec<F>, Error>
where
    F::Value: Default,
{
    let tails: Vec<String> = match names {
        Names::Count(n) => (0..*n).map(|i| format!("{numbered}{i:02}")).collect(),
        Names::Given(list) => list.iter().map(|n| format!("{named}{n}")).collect(),
    };
    let initial = F::Value::default;
    tails.iter().map(|t| make(b, &["motion.", t], &[], doc, safety, initial())).collect()
}
