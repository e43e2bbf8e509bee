//! Realtime. Switching between the types of kinematics that a machine has.

use crate::{command::Mode, state::State};
use hal_component::{Builder, Decl, Error, In, Touch};

/// `motion.switchkins-type`, where there is something to switch.
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

/// The type in force.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Switch {
    is: u32,
    /// What was refused last, so that it is said once.
    refused: Option<f64>,
}

impl State {
    /// Switches to the type that the pin names, once nothing moves; from then on the pose is
    /// what the new type makes of the joints.
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

/// Without its fraction; none for what is below 0 then, or no number.
fn whole(wanted: f64) -> Option<u32> {
    (0..=MOST).find(|n| f64::from(*n) == libm::trunc(wanted))
}

/// No kinematics have more types.
const MOST: u32 = 15;
