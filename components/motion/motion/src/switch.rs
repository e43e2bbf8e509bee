//! Realtime. Switching between the kinematics types of a machine.

use crate::{commands::command::Mode, state::State};
use hal_component::{Builder, Decl, Error, In, Touch};

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
    is: u32,
    /// Last refused request, so that it is reported only once.
    refused: Option<f64>,
}

impl State {
    /// Switches to the type that the pin names, once nothing moves; the pose is then computed from the joints with the
    /// new type.
    pub(crate) fn switch_kinematics(&mut self, pins: &SwitchPins) {
        let Some(wanted) = pins.wanted.first().map(In::get) else { return };
        if self.switch.refused.is_some_and(|r| r.to_bits() == wanted.to_bits()) {
            return;
        }
        let Some(to) = whole(wanted).filter(|to| *to < self.kinematics.types()) else {
            self.switch.refused = Some(wanted);
            self.say.error("there are no kinematics of type {}", &[wanted]);
            return;
        };
        self.switch.refused = None;
        if to == self.switch.is || !self.is_idle() {
            return;
        }
        let before = self.switch.is;
        if !self.kinematics.switch(to) || !self.find_pose() {
            self.kinematics.switch(before);
            self.find_pose();
            self.switch.refused = Some(wanted);
            self.say.error("the kinematics of type {} have no pose for these joints", &[wanted]);
            return;
        }
        if self.mode != Mode::Free
            && let Err(why) = self.needs_pose()
        {
            self.kinematics.switch(before);
            self.find_pose();
            self.switch.refused = Some(wanted);
            self.say.error("cannot switch to kinematics of type {}", &[wanted]);
            why.say(&self.say);
            return;
        }
        self.switch.is = to;
        self.sync("the kinematics have changed");
    }
}

/// Truncates a number to an integer; `None` for negative results and NaN.
fn whole(wanted: f64) -> Option<u32> {
    (0..=MOST).find(|n| f64::from(*n) == libm::trunc(wanted))
}

/// Largest number of a type in any kinematics.
const MOST: u32 = 15;
