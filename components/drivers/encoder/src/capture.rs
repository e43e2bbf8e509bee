//! Realtime. Positions and speeds: the slow function of `encoder`.

use crate::{
    encoder::Pins,
    handover::{Notes, TimeBase},
};
use hal_component::{Period, Takes, Touch, Update, to_s32};
use std::sync::atomic::Ordering::{Acquire, Release};

/// Number of captures with counts before the speed is known.
const SURE: u32 = 2;

/// State of one channel in the slow function.
#[derive(Touch)]
pub(crate) struct Capture {
    pins: Pins,
    notes: Takes<Notes>,
    #[state]
    was: Memory,
}

/// Values kept from one capture to the next.
#[derive(Debug)]
struct Memory {
    raw: i32,
    at: u32,
    index: i32,
    latch: i32,
    /// Number of captures with counts since standstill, up to [`SURE`].
    sure: u32,
    scale: f64,
    /// Units per count.
    unit: f64,
    /// Pause between pulses that indicates missing teeth, in nanoseconds.
    pause: i32,
}

impl Capture {
    pub(crate) fn new(pins: Pins, notes: Takes<Notes>) -> Self {
        let (scale, unit) = (1.0, 1.0);
        let was = Memory { raw: 0, at: 0, index: 0, latch: 0, sure: 0, scale, unit, pause: 0 };
        Self { pins, notes, was }
    }

    fn run(&mut self, now: u32) {
        let (p, was) = (&self.pins, &mut self.was);
        let seen = self.notes.swap();
        // In all of these, `Acquire` and `swap` pair with the `Release` of the counting function.
        let counted = seen.counted.swap(false, Acquire);
        let (raw, at) = (seen.raw.load(Acquire), seen.at.load(Acquire));
        let scale = p.position_scale.get();
        if scale != was.scale {
            // Stored as given: a second 0 is not corrected and has no effect.
            was.scale = scale;
            if scale.abs() < 1e-20 {
                p.position_scale.set(1.0);
            }
            was.unit = 1.0 / p.position_scale.get();
        }
        if p.min_speed_estimate.get() == 0.0 {
            p.min_speed_estimate.set(1.0);
        }
        let moved = if p.reset.get() { 0 } else { raw.wrapping_sub(was.raw) };
        let lasted = at.wrapping_sub(was.at);
        if counted {
            (was.raw, was.at) = (raw, at);
        }
        if seen.indexed.swap(false, Acquire) {
            was.index = seen.index.load(Acquire);
            p.index_enable.set(false);
        }
        if p.reset.get() {
            was.index = was.raw;
        }
        if seen.latched.swap(false, Acquire) {
            was.latch = seen.latch.load(Acquire);
        }
        self.notes.armed.store(p.index_enable.get(), Release); // Pairs with counting.
        let still = now.wrapping_sub(was.at);
        if counted && was.sure < SURE {
            was.sure += 1;
        } else if counted {
            p.velocity.set(f64::from(moved) * was.unit / (f64::from(lasted) * 1e-9));
            if moved != 0 {
                let teeth = f64::from(p.missing_teeth.get()) + 0.5;
                let pause = teeth * f64::from(lasted) / f64::from(moved.cast_unsigned());
                // Infinite after counts that cancelled out.
                was.pause = to_s32(0.9 * f64::from(was.pause) + 0.1 * pause);
            }
            self.notes.pause.store(was.pause, Release); // Pairs with counting.
        } else if was.sure > 0 {
            let at_gap =
                p.missing_teeth.get() != 0 && still < was.pause.wrapping_mul(2).cast_unsigned();
            if at_gap {
                // The missing teeth would come now.
            } else if f64::from(still) < 1e9 / (p.min_speed_estimate.get() * was.unit) {
                let most = was.unit.abs() / (f64::from(still) * 1e-9);
                let velocity = p.velocity.get();
                if velocity.abs() > most {
                    p.velocity.set(if velocity < 0.0 { -most } else { most });
                }
            } else {
                p.velocity.set(0.0);
                was.sure = 0;
            }
        } else {
            p.velocity.set(0.0);
        }
        let velocity = p.velocity.get();
        p.velocity_rpm.set(velocity * 60.0);
        let counts = was.raw.wrapping_sub(was.index);
        p.counts.set(counts);
        p.position.set(f64::from(counts) * was.unit);
        let latched = was.latch.wrapping_sub(was.index);
        p.counts_latched.set(latched);
        p.position_latched.set(f64::from(latched) * was.unit);
        p.position_interpolated.set(p.position.get() + velocity * (f64::from(still) * 1e-9));
    }
}

/// `encoder.capture-position`.
#[derive(Touch)]
pub(crate) struct CapturePosition {
    pub(crate) channels: Vec<Capture>,
    pub(crate) time: Takes<TimeBase>,
}

impl Update for CapturePosition {
    fn update(&mut self, _: Period) {
        let now = self.time.now();
        for c in &mut self.channels {
            c.run(now);
        }
    }
}
