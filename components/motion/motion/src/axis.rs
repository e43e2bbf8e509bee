//! Realtime. One axis: its limits, and its planner in teleop mode.

use crate::{
    commands::config::AxisConfig,
    jogger::{By, Jogger, WheelPins},
    offset::{Offset, OffsetPins},
    pins::{AxisPins, Shown},
};

/// State of one axis.
#[derive(Debug, Default)]
pub(crate) struct Axis {
    pub(crate) config: AxisConfig,
    pub(crate) teleop: Jogger,
    pub(crate) offset: Offset,
    shown: Shown<6>,
}

impl Axis {
    /// Writes the pins.
    pub(crate) fn write_pins(&mut self, pins: &AxisPins, pos: f64) {
        let (tp, by) = (&self.teleop.tp, self.teleop.by);
        let [request, now] = self.offset.values();
        pins.pos_cmd.set(pos);
        let changed = self.shown.changes([
            u64::from(tp.enable) << 8 | u64::from(by as u8),
            tp.target.to_bits(),
            tp.vel.to_bits(),
            tp.max_vel.to_bits(),
            request.to_bits(),
            now.to_bits(),
        ]);
        if changed {
            pins.teleop_pos_cmd.set(tp.target);
            pins.teleop_vel_cmd.set(tp.vel);
            pins.teleop_vel_lim.set(tp.max_vel);
            pins.teleop_tp_enable.set(tp.enable);
            pins.kb_jog_active.set(by == By::Command);
            pins.wheel_jog_active.set(by == By::Wheel);
            pins.eoffset_request.set(request);
            pins.eoffset.set(now);
        }
    }
}

/// Returns the jog-wheel pins of an axis.
pub(crate) const fn wheel(pins: &AxisPins) -> WheelPins {
    WheelPins {
        counts: pins.jog_counts,
        enable: pins.jog_enable,
        scale: pins.jog_scale,
        vel_mode: pins.jog_vel_mode,
        accel_fraction: pins.jog_accel_fraction,
    }
}

/// Returns the external-offset pins of an axis.
pub(crate) const fn offset(pins: &AxisPins) -> OffsetPins {
    OffsetPins {
        enable: pins.eoffset_enable,
        clear: pins.eoffset_clear,
        counts: pins.eoffset_counts,
        scale: pins.eoffset_scale,
    }
}
