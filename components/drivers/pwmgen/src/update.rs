//! Realtime. Duty cycles: the slow function of `pwmgen`.

use crate::{
    handover::{Base, Mode, Wanted},
    pwmgen::Pins,
};
use hal_component::{Gives, Out, Period, Takes, Touch, Update};

/// State of one channel in the slow function.
#[derive(Touch)]
pub(crate) struct Duty {
    pins: Pins,
    dir: Option<Out<bool>>,
    wanted: Gives<Wanted>,
    /// True if negative values count as zero.
    #[state]
    is_single: bool,
    #[state]
    was: Was,
}

/// Settings from which a channel's timing was computed.
#[derive(Debug)]
struct Was {
    mode: Mode,
    freq: f64,
    scale: f64,
    per_scale: f64,
    /// PWM period, in nanoseconds.
    period: i64,
    /// PWM period, in thread cycles.
    runs: i64,
    /// Fraction of a PWM period that a thread cycle lasts; 0 before there was a period.
    per_run: f64,
}

impl Duty {
    pub(crate) fn new(
        pins: Pins,
        dir: Option<Out<bool>>,
        is_single: bool,
        wanted: Gives<Wanted>,
    ) -> Self {
        let was = Was {
            mode: Mode::Off,
            freq: -1.0,
            scale: f64::NAN,
            per_scale: 1.0,
            period: 0,
            runs: 0,
            per_run: 0.0,
        };
        Self { pins, dir, wanted, is_single, was }
    }

    /// Ensures 0 ≤ `min-dc` ≤ `max-dc` ≤ 1.
    fn limits(&self) -> (f64, f64) {
        let p = &self.pins;
        if !(0.0..=1.0).contains(&p.min_dc.get()) {
            p.min_dc.set(if p.min_dc.get() > 1.0 { 1.0 } else { 0.0 });
        }
        if !(0.0..=1.0).contains(&p.max_dc.get()) {
            p.max_dc.set(if p.max_dc.get() < 0.0 { 0.0 } else { 1.0 });
        }
        if p.min_dc.get() > p.max_dc.get() {
            p.min_dc.set(p.max_dc.get());
        }
        (p.min_dc.get(), p.max_dc.get())
    }

    /// Computes the mode and the length of its period.
    #[expect(clippy::cast_possible_truncation, reason = "a period beyond 64 bits cannot be")]
    fn timing(&mut self, base: i64, base_changed: bool) {
        let (p, was) = (&self.pins, &mut self.was);
        let most = 0.5e9 / base as f64;
        let freq = p.pwm_freq.get();
        if base_changed {
            p.pwm_freq.set(possible(freq, most));
        }
        let mode = if !p.enable.get() {
            Mode::Off
        } else if freq == 0.0 {
            Mode::Density
        } else if p.dither_pwm.get() {
            Mode::Dither
        } else {
            Mode::Pure
        };
        if !(mode != was.mode || freq != was.freq || base_changed) {
            return;
        }
        was.mode = mode;
        if mode == Mode::Off {
            self.wanted.ask(mode, was.period);
            return;
        }
        let freq = possible(freq, most);
        p.pwm_freq.set(freq);
        if freq == 0.0 {
            // After a frequency below 0: the next cycle uses pulse density.
            was.period = base;
        } else if mode == Mode::Dither {
            was.period = (1e9 / freq) as i64;
        } else {
            was.runs = ((1e9 / freq / base as f64) + 0.5) as i64;
            was.per_run = 1.0 / was.runs as f64;
            was.period = was.runs * base;
            p.pwm_freq.set(1e9 / was.period as f64);
        }
        was.freq = p.pwm_freq.get();
        self.wanted.ask(was.mode, was.period);
    }

    #[expect(clippy::cast_possible_truncation, reason = "a width within a period")]
    fn run(&mut self, base: i64, base_changed: bool) {
        let (min, max) = self.limits();
        self.timing(base, base_changed);
        let (p, was) = (&self.pins, &mut self.was);
        let scale = p.scale.get();
        if scale != was.scale {
            // Stored as given: a second 0 is not corrected and has no effect.
            was.scale = scale;
            if scale.abs() < 1e-20 {
                p.scale.set(1.0);
            }
            was.per_scale = 1.0 / p.scale.get();
        }
        let wanted = p.value.get() * was.per_scale + p.offset.get();
        let wanted = if self.is_single && wanted < 0.0 { 0.0 } else { wanted };
        let down = wanted < 0.0;
        if let Some(dir) = &self.dir {
            dir.set(down);
        }
        let duty = wanted.abs();
        let duty = if duty > max {
            max
        } else if duty < min {
            min
        } else {
            duty
        };
        let sign = if down { -1.0 } else { 1.0 };
        if was.mode == Mode::Pure {
            let high = (was.runs as f64 * duty + 0.5) as i64;
            self.wanted.width(high * base, down);
            p.curr_dc.set(sign * high as f64 * was.per_run);
        } else {
            self.wanted.width((was.period as f64 * duty + 0.5) as i64, down);
            p.curr_dc.set(sign * duty);
        }
    }
}

/// Returns the nearest possible frequency: from 0.5 to the maximum, or 0.
fn possible(freq: f64, most: f64) -> f64 {
    if freq <= 0.0 || freq.is_nan() {
        0.0
    } else if freq < 0.5 {
        0.5
    } else if freq > most {
        most
    } else {
        freq
    }
}

/// `pwmgen.update`.
#[derive(Touch)]
pub(crate) struct UpdateDuty {
    pub(crate) channels: Vec<Duty>,
    pub(crate) base: Takes<Base>,
    #[state]
    pub(crate) base_was: i64,
}

impl Update for UpdateDuty {
    fn update(&mut self, _: Period) {
        let base = self.base.ns().max(1);
        let changed = base != self.base_was;
        self.base_was = base;
        for c in &mut self.channels {
            c.run(base, changed);
        }
    }
}
