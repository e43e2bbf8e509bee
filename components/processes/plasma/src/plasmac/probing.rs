//! Realtime. States 1 to 5: probe the surface, then move to the pierce height.

use super::{
    machine::Cutter,
    numbers::at_most,
    state::{State, Stop},
};
use hal_component::Period;

impl Cutter {
    /// Returns whether the tip touches the surface.
    pub(super) fn tip_touches(&self) -> bool {
        self.probe.ohmic_probe.get() && self.probe.ohmic_probe_enable.get()
    }

    /// Returns whether the float switch or the tip reports contact.
    pub(super) fn touches(&self) -> bool {
        self.probe.float_switch.get() || self.tip_touches()
    }

    /// Returns whether the contact counts: the tip reports it, or the ohmic attempts are used up.
    fn counts_as_contact(&mut self) -> bool {
        let tip = self.probe.ohmic_probe_enable.get();
        if tip && !self.tip_touches() && self.attempts < self.probe.ohmic_max_attempts.get() {
            self.attempts += 1;
            return false;
        }
        self.by_tip = self.tip_touches();
        true
    }

    pub(super) fn probe_height(&mut self, period: Period) {
        self.drive.ohmic_enable.set(self.probe.ohmic_probe_enable.get());
        let there = self.probe_out(period);
        if self.touches() && !there {
            self.messages.error(
                "plasmac: contact before the offset probe is out: probe-start-height {} is too low",
                &[self.probe.start_height.get()],
            );
            self.drive.program_pause.set(!self.at.is_paused.get());
            self.end(Stop::Fault, State::MaxHeight);
            return;
        }
        if self.touches() && self.attempts == 0 {
            self.early = true;
            self.go(State::ProbeUp);
            return;
        }
        if self.entered {
            let low = self.at.z_min.get() - self.base;
            self.goal = self.counts(low + self.probe.start_height.get());
            self.entered = false;
        }
        // After an attempt that did not count, the state lasts one cycle longer.
        let stays = if self.attempts > 0 { f64::MIN_POSITIVE } else { 0.0 };
        if self.toward(self.setup()) && self.is_there() && self.lasted(stays, period) {
            self.go(State::ProbeDown);
        }
    }

    pub(super) fn probe_down(&mut self, period: Period) {
        let out = self.is_out(period);
        if self.touches() {
            if self.counts_as_contact() {
                self.early = false;
                if self.room(self.at.z.get()) < self.least_room() {
                    self.too_high();
                } else {
                    self.go(State::ProbeUp);
                }
            } else {
                self.go(State::ProbeHeight);
            }
            return;
        }
        if !out {
            return;
        }
        let speed = self.speed(self.probe.feed_rate.get()).min(self.setup());
        let next = self.at.z.get() - self.units(speed);
        if next >= self.at.z_min.get() + 0.25 * self.at.units_per_mm.get() {
            self.shift(speed.saturating_neg());
        } else if self.entered {
            self.entered = false;
        } else if self.tests {
            self.status.probe_test_error.set(true);
            self.go(State::ProbeTest);
        } else {
            self.messages.error("plasmac: Z is at its lowest, and no surface was found", &[]);
            self.fault();
        }
    }

    pub(super) fn probe_up(&mut self) {
        if self.touches() {
            let by = if self.early { 10 } else { at_most(self.probe.final_speed.get(), 10) };
            self.shift(by.saturating_mul(self.resolution()));
            self.entered = false;
        } else if self.early {
            self.go(State::ProbeDown);
        } else {
            self.drive.ohmic_enable.set(false);
            self.go(State::ZeroHeight);
            self.find();
            let surface = self.at.z.get() + self.units(self.surface - self.drive.z_counts.get());
            let (room, safe) = (self.room(surface), self.cut.safe_height.get());
            if safe > 0.0 && room < self.least_room() {
                self.too_high();
            } else if room < safe {
                let heights = [room, safe];
                self.messages
                    .warn("plasmac: the safe height is {}, not {}: Z ends there", &heights);
            }
        }
    }

    /// Returns the room above a Z position for the torch, in machine units.
    fn room(&self, z: f64) -> f64 {
        let free = f64::from(self.cut.max_offset.get()) * self.at.units_per_mm.get();
        self.at.z_max.get() - free - z
    }

    /// Returns the room that a cut needs: 1 mm above the pierce height, in machine units.
    fn least_room(&self) -> f64 {
        self.cut.pierce_height.get() + self.at.units_per_mm.get()
    }

    fn too_high(&mut self) {
        self.messages.error("plasmac: the surface is too high to pierce below the highest Z", &[]);
        self.fault();
    }

    pub(super) fn zero_height(&mut self) {
        if self.toward(self.setup()) {
            self.go(State::PierceHeight);
        }
    }

    /// Sets the surface height from the Z where contact ended, plus the travel of the switch or the offset of the tip.
    fn find(&mut self) {
        let travel = if self.by_tip {
            self.probe.ohmic_probe_offset.get()
        } else {
            self.probe.float_switch_travel.get()
        };
        self.goal = self.drive.z_counts.get().saturating_add(self.counts(travel));
        self.surface = self.goal;
        self.drift = 0;
        let free = f64::from(self.cut.max_offset.get()) * self.at.units_per_mm.get();
        let left = self.at.z_max.get() - self.at.z.get() - free;
        let here = f64::from(self.drive.z_counts.get());
        self.highest = here + left / self.drive.offset_scale.get();
        self.known = true;
    }

    /// Converts a height above the surface to an offset in counts.
    #[expect(clippy::cast_possible_truncation, reason = "what does not fit is at its end")]
    pub(super) fn above(&self, height: f64) -> i32 {
        (f64::from(self.surface.saturating_add(self.drift))
            + height / self.drive.offset_scale.get()) as i32
    }

    /// Sets the target to a height above the surface, in the first cycle of a state.
    pub(super) fn aim(&mut self, height: f64) {
        if self.entered {
            self.goal = self.above(height);
            self.entered = false;
        }
    }

    pub(super) fn pierce_height(&mut self, period: Period) {
        let cut = &self.cut;
        let heights = [cut.pierce_height.get(), cut.cut_height.get(), cut.cut_volts.get()];
        if !heights.iter().all(|n| *n > 0.0) {
            self.messages.error(
                "plasmac: pierce-height {}, cut-height {} and cut-volts {} must be above 0",
                &heights,
            );
            self.fault();
            return;
        }
        let (back, swung) = self.probe_back(period);
        self.aim(self.cut.pierce_height.get());
        if swung && self.toward(self.setup()) && back {
            self.starts = 0;
            if self.tests {
                self.go(State::ProbeTest);
            } else if self.cut.torch_enable.get() {
                self.go(State::TorchOn);
            } else {
                self.go(State::PierceDelay);
            }
        }
    }
}
