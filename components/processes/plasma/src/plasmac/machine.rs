//! Realtime. State of a plasma cutter, and one cycle of it.

use super::{
    inputs,
    numbers::{at_most, later, short, sooner},
    offset::Offset,
    outputs, settings,
    state::{State, Stop},
    steady::Steady,
    thc::Thc,
    times::Times,
    volts::Volts,
};
use hal_component::{Builder, Error, Messages, Period, Touch, Update};

/// State of a plasma cutter.
#[derive(Touch)]
pub(super) struct Cutter {
    pub(super) arc: inputs::Arc,
    pub(super) at: inputs::MachinePins,
    pub(super) probe: inputs::Probe,
    pub(super) cut: settings::Cut,
    pub(super) thc: settings::Thc,
    pub(super) jobs: settings::Jobs,
    pub(super) drive: outputs::Drive,
    pub(super) status: outputs::Status,
    pub(super) messages: Messages,
    pub(super) volts: Volts,
    pub(super) control: Thc,
    pub(super) steady: Steady,
    pub(super) times: Times,
    pub(super) offset: Offset,
    #[state]
    pub(super) state: State,
    #[state]
    pub(super) stop: Stop,
    /// Seconds in this state, or since an event in it.
    #[state]
    pub(super) timer: f32,
    /// True in the first cycle of a state.
    #[state]
    pub(super) entered: bool,
    /// Z without its offset, as of the last cycle without an offset.
    #[state]
    pub(super) base: f64,
    /// Z offset at the surface, in counts; valid while `known`.
    #[state]
    pub(super) surface: i32,
    #[state]
    pub(super) known: bool,
    /// Upper limit of the Z offset, in counts.
    #[state]
    pub(super) highest: f64,
    /// Counts by which height control has moved Z away from the cut height; positive is up.
    #[state]
    pub(super) drift: i32,
    /// Target Z offset of this state, in counts.
    #[state]
    pub(super) goal: i32,
    /// Seconds until the torch may be lit again.
    #[state]
    pub(super) restart: f32,
    /// Seconds since the voltage of a spot reached its threshold; `None` before.
    #[state]
    pub(super) spot: Option<f32>,
    /// Number of torch starts in this cut.
    #[state]
    pub(super) starts: i32,
    /// True if contact came during the move to the start height.
    #[state]
    pub(super) early: bool,
    /// Number of ohmic probe attempts in this cut.
    #[state]
    pub(super) attempts: i32,
    /// True if the tip made the contact, false if the float switch did.
    #[state]
    pub(super) by_tip: bool,
    /// True if a program has run since the last idle state.
    #[state]
    pub(super) ran: bool,
    /// True if a program ran in the previous cycle.
    #[state]
    pub(super) runs: bool,
    /// True if a sensor ended the cut.
    #[state]
    pub(super) tripped: bool,
    /// True if the sensor that ended the cut is off again.
    #[state]
    pub(super) eases: bool,
    /// True during a probe test.
    #[state]
    pub(super) tests: bool,
    /// True while the torch moves to the position where a cut resumes.
    #[state]
    pub(super) recovers: bool,
    /// Laser position during recovery, as X and Y offsets in counts.
    #[state]
    pub(super) laser: (i32, i32),
    /// X and Y at the end of the last cut, in machine units.
    #[state]
    pub(super) last: Option<(f64, f64)>,
    /// Contact of the tip in the previous cycle.
    #[state]
    pub(super) tip: bool,
    /// Number of cycles for which the contact relay has been on, and off.
    #[state]
    pub(super) sensed: (i32, i32),
    /// Arc voltage of this cycle, in volts.
    #[state]
    pub(super) now: f64,
    /// Seconds for which the arc may still be missing.
    #[state]
    pub(super) left: f32,
}

impl Cutter {
    pub(super) fn new(b: &mut Builder<'_>) -> Result<Self, Error> {
        Ok(Self {
            arc: inputs::Arc::make(b, "plasmac")?,
            at: inputs::MachinePins::make(b, "plasmac")?,
            probe: inputs::Probe::make(b, "plasmac")?,
            cut: settings::Cut::make(b, "plasmac")?,
            thc: settings::Thc::make(b, "plasmac")?,
            jobs: settings::Jobs::make(b, "plasmac")?,
            drive: outputs::Drive::make(b, "plasmac")?,
            status: outputs::Status::make(b, "plasmac")?,
            messages: b.messages(),
            volts: Volts::default(),
            control: Thc::default(),
            steady: Steady::default(),
            times: Times::default(),
            offset: Offset::default(),
            state: State::Idle,
            stop: Stop::None,
            timer: 0.0,
            entered: true,
            base: 0.0,
            surface: 0,
            known: false,
            highest: 0.0,
            drift: 0,
            goal: 0,
            restart: 0.0,
            spot: None,
            starts: 0,
            early: false,
            attempts: 0,
            by_tip: false,
            ran: false,
            runs: false,
            tripped: false,
            eases: false,
            tests: false,
            recovers: false,
            laser: (0, 0),
            last: None,
            tip: false,
            sensed: (0, 0),
            now: 0.0,
            left: 0.0,
        })
    }

    /// Enters a state, which acts from the next cycle on.
    pub(super) fn go(&mut self, state: State) {
        self.state = state;
        self.entered = true;
        self.timer = 0.0;
        self.status.state.set(state as i32);
    }

    /// Records the stop reason and publishes it.
    pub(super) fn stops(&mut self, stop: Stop) {
        self.stop = stop;
        self.status.stop_type.set(stop as i32);
    }

    /// Turns the torch off and clears arc OK.
    pub(super) fn torch_off(&mut self) {
        self.drive.torch_on.set(false);
        self.status.arc_ok.set(false);
        self.volts.torch_off();
    }

    /// Returns whether the time has passed, counting this cycle.
    pub(super) fn waited(&mut self, seconds: f64, period: Period) -> bool {
        self.pass(period);
        f64::from(self.timer) >= seconds
    }

    /// Returns whether the time has passed, counting from the next cycle.
    pub(super) fn lasted(&mut self, seconds: f64, period: Period) -> bool {
        let over = f64::from(self.timer) >= seconds;
        self.pass(period);
        over
    }

    fn pass(&mut self, period: Period) {
        self.timer = later(self.timer, period);
    }

    /// Returns the `resolution` pin, limited to 1 to 1000.
    pub(super) fn resolution(&self) -> i32 {
        at_most(self.cut.resolution.get(), 1000)
    }

    /// Returns the counts per cycle for a speed in machine units per minute. The factor is rounded to single precision,
    /// as in LinuxCNC.
    pub(super) fn pace(&self, rate: f64) -> f64 {
        let factor = f64::from(self.resolution()) / self.at.units_per_mm.get() / 60.0;
        rate * f64::from(short(factor))
    }

    /// Returns the counts per cycle for a speed in machine units per minute, truncated to an integer.
    #[expect(clippy::cast_possible_truncation, reason = "what does not fit is at its end")]
    pub(super) fn speed(&self, rate: f64) -> i32 {
        self.pace(rate) as i32
    }

    /// Returns the setup speed of Z, in counts per cycle.
    pub(super) fn setup(&self) -> i32 {
        self.speed(self.cut.setup_feed_rate.get())
    }

    /// Converts a distance in machine units to counts.
    #[expect(clippy::cast_possible_truncation, reason = "what does not fit is at its end")]
    pub(super) fn counts(&self, distance: f64) -> i32 {
        (distance / self.drive.offset_scale.get()) as i32
    }

    /// Converts counts to machine units.
    pub(super) fn units(&self, counts: i32) -> f64 {
        f64::from(counts) * self.drive.offset_scale.get()
    }

    /// Moves Z one step toward the target. Returns whether Z was already there.
    pub(super) fn toward(&self, speed: i32) -> bool {
        let now = self.drive.z_counts.get();
        let left = self.goal.saturating_sub(now);
        let most = speed.saturating_abs();
        self.drive.z_counts.set(now.saturating_add(left.max(-most).min(most)));
        left == 0
    }

    /// Moves Z by this number of counts.
    pub(super) fn shift(&self, by: i32) {
        self.drive.z_counts.set(self.drive.z_counts.get().saturating_add(by));
    }

    /// Returns whether a cut or a spot is requested.
    pub(super) fn wanted(&self) -> bool {
        self.jobs.cutting_start.get() || self.jobs.spotting_start.get()
    }

    /// Returns whether a cut continues without an arc.
    pub(super) fn ignores_arc(&self) -> bool {
        self.arc.ignore_ok_0.get()
            || self.arc.ignore_ok_1.get()
            || (self.cut.mesh_enable.get() && self.cut.mesh_arc_ok.get())
    }

    fn read(&mut self, period: Period) {
        let resolution = f64::from(self.resolution());
        self.drive.offset_scale.set(self.at.units_per_mm.get() * period.secs() / resolution);
        self.now = self.volts.read(&self.arc, period);
        self.status.arc_voltage.set(self.now);
        self.status.current_feed_rate.set(self.at.velocity.get() * 60.0);
        let enabled = self.thc.enable.get()
            && !self.thc.disable.get()
            && !self.arc.ignore_ok_0.get()
            && !self.arc.ignore_ok_1.get()
            && !self.cut.mesh_enable.get()
            && self.left == short(self.arc.lost_delay.get());
        self.status.thc_enabled.set(enabled);
        let cuts = matches!(self.state, State::Cut | State::CutByHand);
        self.status.thc_active.set(self.control.active && enabled && cuts);
        self.debounce_ohmic();
        let sensor = self.probe.float_switch.get() || self.tip || self.probe.breakaway.get();
        self.status.sensor_active.set(sensor);
        if self.at.is_paused.get() {
            self.drive.program_pause.set(false);
        }
    }

    /// Updates arc OK from the voltage or the arc OK input, with the allowed loss time.
    fn look(&mut self, period: Period) {
        if self.cut.torch_off.get() {
            self.drive.torch_on.set(false);
        }
        let lit = self.drive.torch_on.get();
        if !lit || self.volts.arc(&self.arc, self.cut.mode.get(), self.now) {
            self.left = short(self.arc.lost_delay.get());
            self.status.arc_ok.set(lit);
        } else if self.status.arc_ok.get() {
            if self.left <= 0.0 {
                self.status.arc_ok.set(false);
            } else {
                self.left = sooner(self.left, period);
            }
        }
    }

    /// Debounces the relay of the ohmic contact.
    fn debounce_ohmic(&mut self) {
        let (on, off) = self.sensed;
        if self.probe.ohmic_sense_in.get() {
            self.sensed = (on.saturating_add(1), 0);
            if self.sensed.0 > self.probe.ohmic_sense_on_delay.get() {
                self.drive.ohmic_sense_out.set(true);
            }
        } else {
            self.sensed = (0, off.saturating_add(1));
            if self.sensed.1 > self.probe.ohmic_sense_off_delay.get() {
                self.drive.ohmic_sense_out.set(false);
            }
        }
    }

    fn act(&mut self, period: Period) {
        match self.state {
            State::Idle => self.idle(),
            State::ProbeHeight => self.probe_height(period),
            State::ProbeDown => self.probe_down(period),
            State::ProbeUp => self.probe_up(),
            State::ZeroHeight => self.zero_height(),
            State::PierceHeight => self.pierce_height(period),
            State::TorchOn => self.torch_on(period),
            State::ArcOk => self.arc_ok(period),
            State::PierceDelay => self.pierce_delay(period),
            State::PuddleJump => self.puddle_jump(period),
            State::CutHeight => self.cut_height(),
            State::Cut => self.cutting(period),
            State::CutByHand => self.by_hand(),
            State::PauseAtEnd => self.pause_at_end(period),
            State::SafeHeight => self.safe_height(),
            State::MaxHeight => self.max_height(),
            State::EndCut => self.end_cut(),
            State::EndJob => self.end_job(),
            State::TorchPulse => self.torch_pulse(period),
            State::PausedMotion => self.paused_motion(),
            State::OhmicTest => self.ohmic_test(),
            State::ProbeTest => self.probe_test(),
            State::Scribing => self.scribing(period),
            State::ConsumablesOut => self.consumables_out(),
            State::ConsumablesBack => self.consumables_back(),
            State::RecoveryOut => self.recovery_out(),
            State::RecoveryBack => self.recovery_back(),
        }
    }

    /// Turns the torch off and clears all offsets, for a machine that is off.
    fn off(&mut self) {
        self.drive.program_pause.set(false);
        self.drive.z_counts.set(0);
        self.drive.x_counts.set(0);
        self.drive.y_counts.set(0);
        self.drive.torch_on.set(false);
        self.stops(Stop::None);
        if self.state != State::Idle {
            self.go(State::Idle);
        }
    }
}

impl Update for Cutter {
    fn update(&mut self, period: Period) {
        self.read(period);
        self.status.z_height.set(if self.known {
            self.at.z_offset_current.get() - self.units(self.surface)
        } else {
            self.at.z.get() - self.at.z_min.get()
        });
        let is_on = self.at.is_on.get();
        if is_on && self.state != State::Idle {
            self.drive.z_enable.set(true);
        }
        let acts = is_on && !self.interrupted();
        let stands = !matches!(self.state, State::ProbeDown | State::ProbeUp);
        let may = self.at.is_idle.get() && stands && !self.jobs.override_jog.get();
        self.drive.jog_inhibit.set(self.status.sensor_active.get() && may);
        self.look(period);
        let lit = self.drive.torch_on.get();
        self.steady.keep(lit, self.now);
        self.count(period);
        if acts {
            if self.state != State::PausedMotion {
                self.drive.adaptive_feed.set(1.0);
            }
            self.act(period);
        } else if !is_on {
            self.drive.adaptive_feed.set(1.0);
            self.off();
        }
        self.runs = self.at.is_running.get();
        self.tip = self.tip_touches();
    }
}
