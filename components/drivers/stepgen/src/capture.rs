//! Realtime. `stepgen.capture-position`: converts the pulses made so far to counts and position.

use crate::{
    freq::Scale,
    handover::{HALF, Made, STEP, steps},
    stepgen::Channel,
};
use hal_component::{Error, Out, Period, Takes, Touch, Update};

/// Function `stepgen.capture-position`.
#[derive(Touch)]
pub(crate) struct CapturePosition {
    pub(crate) channels: Vec<Capture>,
}

impl Update for CapturePosition {
    fn update(&mut self, _: Period) {
        for c in &self.channels {
            let accum = c.made.accum();
            c.counts.set(steps(accum));
            c.position_fb.set(position(accum) * (1.0 / c.scale.get()));
        }
    }
}

/// State of one channel.
#[derive(Touch)]
pub(crate) struct Capture {
    counts: Out<i32>,
    position_fb: Out<f64>,
    scale: Scale,
    made: Takes<Made>,
}

impl Capture {
    pub(crate) fn new(
        c: &mut Channel<'_, '_>,
        scale: Scale,
        made: Takes<Made>,
    ) -> Result<Self, Error> {
        const COUNTS: &str = "Position in steps, as of the last capture-position; it wraps";
        const FB: &str = "Position in length units, as of the last capture-position; it moves on \
            between two steps";
        Ok(Self {
            counts: c.item("counts", COUNTS, 0)?,
            position_fb: c.item("position-fb", FB, 0.0)?,
            scale,
            made,
        })
    }
}

/// Converts an accumulator to steps.
pub(crate) const fn position(accum: i64) -> f64 {
    accum.wrapping_sub(HALF) as f64 / STEP as f64
}
