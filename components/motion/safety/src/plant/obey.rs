//! Reports of a body to its machine, and its obedience to the machine's answers.

use super::{Decide, Plant, PlantMotion, Way};
use crate::{Answer, Event, Facts, Mode, Parked, Resume, Shift, Stop};

impl Plant {
    /// Tells the machine of an event, and obeys it.
    pub(super) fn tell(&mut self, event: Event, decide: Decide) -> Answer {
        let facts = self.facts(event);
        let answer = decide(&mut self.machine, event, &facts);
        self.obey(&answer, event);
        answer
    }

    fn facts(&self, event: Event) -> Facts {
        let mode = match event {
            Event::Order(order, ..) => order.mode(),
            _ => None,
        };
        Facts {
            epoch: self.epoch,
            estop: self.estop,
            enable: self.enable,
            jog_inhibit: false,
            homing_inhibit: false,
            configured: true,
            jogs: self.jog != PlantMotion::Rests,
            homes: self.homes,
            path: self.way != Way::None,
            rests_on_path: self.paused && self.way == Way::Waits && self.parked == Parked::No,
            parked: self.parked,
            claimed: self.claimed,
            target: true,
            place: matches!(mode, None | Some(Mode::Free)) || self.has_place(),
            rests: !self.moves(),
            moving: u32::from(self.moves()),
            open_loop: u32::from(self.config.is_open_loop),
            volatile: u32::from(self.config.is_volatile),
        }
    }

    fn obey(&mut self, answer: &Answer, event: Event) {
        if answer.raises && !core::mem::replace(&mut self.has_risen, true) {
            self.epoch.stops = self.epoch.stops.wrapping_add(1);
        }
        if answer.pauses {
            self.epoch.pauses = self.epoch.pauses.wrapping_add(1);
        }
        if answer.unhome != 0 {
            self.homed = false;
        }
        match answer.stop {
            Stop::None => {}
            Stop::Jogs => self.brake_jog(),
            Stop::JogsAtOnce => self.jog = PlantMotion::Rests,
            Stop::Homing => self.end_homing(),
            Stop::Path => self.paused |= self.way != Way::None,
            Stop::Pause => {
                self.brake_jog();
                self.end_homing();
                self.paused |= self.way != Way::None;
            }
            Stop::Motion | Stop::Ramp => self.brake(),
            Stop::Abort => {
                self.brake();
                self.claimed = false;
            }
            Stop::Drop => {
                self.leave();
                (self.jog, self.homes) = (PlantMotion::Rests, false);
            }
        }
        match answer.shift {
            Shift::Stay => {}
            // The path that the axes are back on stays.
            Shift::To(_) if event == Event::Back => {}
            Shift::To(_) => self.leave(),
            Shift::Park => (self.parked, self.strayed) = (Parked::Away, false),
        }
        match answer.resume {
            Resume::No => {}
            Resume::Path => self.paused = false,
            Resume::Return => {
                self.parked = Parked::Returns;
                if self.strayed {
                    self.jog = PlantMotion::Runs;
                }
            }
        }
    }

    fn brake_jog(&mut self) {
        if self.jog == PlantMotion::Runs {
            self.jog = PlantMotion::Brakes;
        }
    }

    fn end_homing(&mut self) {
        if self.homes {
            (self.homes, self.jog) = (false, PlantMotion::Brakes);
        }
    }

    /// Brakes everything; the path ends.
    fn brake(&mut self) {
        self.brake_jog();
        self.end_homing();
        if matches!(self.way, Way::Moves | Way::Brakes) {
            self.way = Way::Ends;
        } else if self.way != Way::Ends {
            self.leave();
        }
    }

    /// Ends the path.
    pub(super) fn leave(&mut self) {
        (self.way, self.parked) = (Way::None, Parked::No);
        (self.paused, self.strayed, self.spindle_lost) = (false, false, false);
    }
}
