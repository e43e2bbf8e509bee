//! Realtime. Commutation of one motor of `bldc`.
use crate::{bldc::Motor, drive::Field, hall, letters::Feedback};
use hal_component::{In, Io, ParamRo, ParamRw, Period, Update, to_s32};

/// Duration of an alignment in seconds, and the remaining times at which its phases end.
pub(crate) const ALIGN: f64 = 2.4;
const RAMP_ENDS: f64 = 2.0;
const BACK_ENDS: f64 = 1.2;
const FORTH_ENDS: f64 = 0.8;
const RETURN_ENDS: f64 = 0.4;

impl Update for Motor {
    fn update(&mut self, period: Period) {
        let counts = self.counter.as_ref().map_or(0, |c| c.rawcounts.get());
        let moved = counts.wrapping_sub(self.state.counts);
        self.state.counts = counts;
        let value = if self.rev.get() { -self.value.get() } else { self.value.get() };
        self.out_dir.set(value < 0.0);
        self.out_abs.set(value.abs());
        let begins = self.init.as_ref().is_some_and(|(init, _)| init.get() && !self.state.init);
        self.state.init = self.init.as_ref().is_some_and(|(init, _)| init.get());
        if !self.state.begun {
            self.begin();
            return;
        }
        let field = match self.state.feedback {
            Feedback::None => self.free(period),
            Feedback::Gray => self.sixteenth(value),
            Feedback::Counts if begins => {
                self.align_anew();
                return;
            }
            Feedback::Counts => self.counted(counts, moved, value),
            Feedback::Align | Feedback::Index if !self.state.init => return,
            Feedback::Align => {
                if let Some(field) = self.align(period) {
                    self.drive(field, self.out.get(), value < 0.0);
                } else {
                    self.measured(counts);
                }
                return;
            }
            Feedback::Index => {
                if self.index_enable.as_ref().is_some_and(Io::get) {
                    let field = self.search(period);
                    self.drive(field, self.out.get(), value < 0.0);
                    return;
                }
                self.measured(counts);
                self.turned(self.rotor_angle.get(), self.phase_angle.get())
            }
            Feedback::Hall | Feedback::HallThenCounts | Feedback::HallThenIndex => {
                let Some(field) = self.sensed(counts, value) else { return };
                field
            }
        };
        self.out.set(value);
        self.drive(field, value, value < 0.0);
    }
}

impl Motor {
    /// Shows the letters of `cfg=`; one cycle later, without the feedback letters that others override.
    fn begin(&mut self) {
        if self.in_type.get() == -1 {
            self.show_all();
        } else {
            self.in_type.set(self.letters.in_type());
        }
        self.state.begun = self.in_type.get() == self.letters.in_type();
    }

    fn show_all(&self) {
        let (in_type, out_type) = self.letters.given();
        self.in_type.set(in_type);
        self.out_type.set(out_type);
        self.ask_for_index();
    }

    /// Drives the motor; the first cycle only updates `out-type`, without the letters that others override.
    fn drive(&self, field: Field, out: f64, back: bool) {
        if self.out_type.get() == self.letters.out_type() {
            self.outputs.give(field, out, back);
        } else {
            self.out_type.set(self.letters.out_type());
        }
    }

    /// Returns the field for the angles of rotor and phase, and publishes them.
    fn turned(&self, rotor: f64, phase: f64) -> Field {
        self.rotor_angle.set(rotor);
        self.phase_angle.set(phase);
        let passed = [1.0, 3.0, 5.0, 7.0, 9.0, 11.0].iter().filter(|&&i| i / 12.0 < rotor).count();
        let phase = (!self.letters.any("T")).then_some(phase);
        Field { sector: (!rotor.is_nan()).then_some(passed % 6), rotor, phase }
    }

    /// Returns the field for a motor without feedback, whose rotor angle follows the field.
    fn free(&self, period: Period) -> Field {
        let frequency = self.frequency.as_ref().map_or(0.0, In::get);
        let angle = turn(self.before() + frequency * period.ns() as f64 / 1e9);
        self.turned(angle, angle)
    }

    /// Returns the last rotor angle, or 0 if it is not finite.
    fn before(&self) -> f64 {
        Some(self.rotor_angle.get()).filter(|angle| angle.is_finite()).unwrap_or(0.0)
    }

    fn sixteenth(&self, value: f64) -> Field {
        let code = self
            .gray
            .iter()
            .flatten()
            .rev()
            .fold(0_u8, |code, bit| code << 1 | (u8::from(bit.get()) ^ (code & 1)));
        let rotor = (f64::from(code) + 0.5) / 16.0;
        self.turned(rotor, ahead(rotor, 0.25, value))
    }

    fn counted(&self, counts: i32, moved: i32, value: f64) -> Field {
        let Some(counter) = &self.counter else { return self.turned(0.0, 0.0) };
        let offset = self.encoder_offset.as_ref().map_or(0, ParamRw::get);
        let measured = self.offset_measured.as_ref().map_or(0, ParamRo::get);
        // Position half a period later, when the output takes effect.
        let at = i64::from(counts) + i64::from(moved / 2) - i64::from(offset) - i64::from(measured);
        let half = at.wrapping_mul(i64::from(counter.poles.get())) / 2;
        let rotor = turn(half as f64 / f64::from(counter.scale.get()));
        let lead = counter.lead_angle.get() / 360.0;
        let value = if self.letters.any("T") { 0.0 } else { value };
        self.turned(rotor, ahead(rotor, lead, value))
    }

    /// Returns the field from the Hall sensors; none if their code is not in the pattern.
    fn sensed(&mut self, counts: i32, value: f64) -> Option<Field> {
        let halls = self.halls.as_ref()?;
        let pattern = halls.pattern.get();
        if pattern > hall::LAST {
            let text = "bldc: pattern is {}, and must be 0 to 47; it becomes 0";
            self.messages.error(text, &[f64::from(pattern)]);
            halls.pattern.set(0);
            return None;
        }
        if pattern != self.state.pattern {
            self.state.pattern = pattern;
            self.state.sector = None;
            halls.error.set(false);
        }
        let trapezoidal = self.letters.any("T");
        let sector = hall::sector(pattern, halls.code());
        let last = self.state.sector.replace(sector);
        let was = last.flatten();
        let follows = was.zip(sector).is_some_and(|(a, b)| a == b || hall::beside(a, b));
        if last.is_some() && !follows && !trapezoidal {
            halls.error.set(true);
        }
        let mut rotor = sector.map_or(0.0, |s| turn(end_of(s + 1)));
        let mut phase = ahead(rotor, -0.25, value);
        match self.state.feedback {
            Feedback::HallThenCounts if was.is_some() && was != sector && !trapezoidal => {
                if let (Some(was), Some(is)) = (was, sector) {
                    rotor = edge(was, is);
                }
                phase = ahead(rotor, 0.25, value);
                // Whole counts per electrical turn, as in LinuxCNC.
                let per_turn = self.counter.as_ref().map_or(0, |c| {
                    (2 * i64::from(c.scale.get())).checked_div(c.poles.get().into()).unwrap_or(0)
                });
                self.measured(to_s32(f64::from(counts) - rotor * per_turn as f64));
            }
            Feedback::HallThenIndex
                if !trapezoidal && !self.index_enable.as_ref().is_some_and(Io::get) =>
            {
                self.measured(counts);
            }
            _ => {}
        }
        self.rotor_angle.set(rotor);
        self.phase_angle.set(phase);
        Some(Field { sector, rotor, phase: None })
    }

    /// Pulls the motor back and forth to zero. Returns the field, until alignment is complete.
    fn align(&mut self, period: Period) -> Option<Field> {
        let left = self.state.left;
        let value = self.initvalue.as_ref().map_or(0.0, In::get);
        let mut out = value;
        let phase = if left > RAMP_ENDS {
            out = value * ((ALIGN - left) / (ALIGN - RAMP_ENDS));
            0.0
        } else if left > BACK_ENDS {
            1.0 - 0.25 * (RAMP_ENDS - left) / (RAMP_ENDS - BACK_ENDS)
        } else if left > FORTH_ENDS {
            -0.25 + 0.5 * (BACK_ENDS - left) / (BACK_ENDS - FORTH_ENDS)
        } else if left > RETURN_ENDS {
            0.25 - 0.25 * (FORTH_ENDS - left) / (FORTH_ENDS - RETURN_ENDS)
        } else if left > 0.0 {
            0.0
        } else {
            return None;
        };
        self.state.left = left - period.secs();
        self.out.set(out);
        self.out_abs.set(out.abs());
        let phase = turn(phase);
        let rotor = turn(phase - self.drive_offset.get() / 360.0);
        Some(self.turned(rotor, phase))
    }

    /// Turns the motor until its index comes, at one electrical turn per second.
    fn search(&self, period: Period) -> Field {
        let value = self.initvalue.as_ref().map_or(0.0, In::get);
        let step = period.ns() as f64 / 1e9;
        let angle = turn(self.before() + if value < 0.0 { -step } else { step });
        self.out.set(value.abs());
        self.out_abs.set(value.abs());
        self.turned(angle, angle)
    }

    /// Stores the measured zero of the rotor; from now on, counts give the angle.
    fn measured(&mut self, offset: i32) {
        if let Some(pin) = &self.offset_measured {
            pin.set(offset);
        }
        if let Some((_, done)) = &self.init {
            done.set(true);
        }
        self.state.left = ALIGN;
        self.state.feedback = Feedback::Counts;
        self.in_type.set(2);
    }

    fn align_anew(&mut self) {
        self.state.feedback = self.letters.feedback;
        if let Some((_, done)) = &self.init {
            done.set(false);
        }
        self.show_all();
    }

    fn ask_for_index(&self) {
        if let Some(pin) = &self.index_enable {
            pin.set(true);
        }
    }
}

/// Returns the angle at which sector `i` of the Hall sensors ends, counted from 1, in electrical turns.
fn end_of(i: usize) -> f64 {
    i as f64 / 6.0
}

/// Returns the angle at which the rotor entered a sector: from the one before it, or else from the one after.
fn edge(was: usize, is: usize) -> f64 {
    let other = if (was + 1) % 6 == is { is } else { is + 2 };
    turn((end_of(is + 1) + end_of(other)) / 2.0)
}

/// Reduces an angle to one turn.
fn turn(angle: f64) -> f64 {
    angle - libm::floor(angle)
}

/// Returns an angle ahead of the rotor, in the direction of drive.
fn ahead(rotor: f64, lead: f64, value: f64) -> f64 {
    turn(if value < 0.0 { rotor - lead } else { rotor + lead })
}
