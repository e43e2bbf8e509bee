//! Realtime. Output pins of the machine as a whole.

use crate::{
    commands::command::Mode,
    pins::{GeneralPins, Pins, Shown, packed},
    state::State,
};
use hal_component::MotionStatus;

/// Groups of pins that change seldom.
#[derive(Debug, Default)]
pub(crate) struct Outputs {
    state: Shown<1>,
    segment: Shown<6>,
    feed: Shown<3>,
    tool: Shown<1>,
    digital: Shown<1>,
    /// Velocity along the current move.
    along: f64,
}

impl Outputs {
    /// Writes the pins of axes, spindles and the machine.
    pub(crate) fn write_pins(&mut self, s: &mut State, pins: &Pins, status: &MotionStatus) {
        for (lock, pins) in s.joints.iter().map(|j| &j.lock).filter(|l| l.exists).zip(&pins.unlocks)
        {
            lock.write_pins(pins);
        }
        for ((axis, pins), pos) in s.axes.iter_mut().zip(&pins.axes).zip(s.pose) {
            axis.write_pins(pins, pos);
        }
        for (spindle, pins) in s.spindles.iter_mut().zip(&pins.spindles) {
            spindle.write_pins(pins);
        }
        if self.digital.changes([status.digital_out]) {
            for (pin, value) in pins.lists.digital_out.iter().zip(&s.digital_out) {
                pin.set(*value);
            }
        }
        for (pin, value) in pins.lists.analog_out.iter().zip(&s.analog_out) {
            pin.set(*value);
        }
        self.write_state(s, &pins.general, status);
        self.write_path(s, pins, status);
        self.write_tool(s, &pins.general);
    }

    fn write_state(&mut self, s: &State, g: &GeneralPins, status: &MotionStatus) {
        let (active, limited) = s.is_offset();
        let state = [
            s.is_on(),
            status.in_position,
            s.mode() == Mode::Coord,
            s.mode() == Mode::Teleop,
            status.reverse,
            s.coord_error,
            s.on_soft_limit,
            active,
            limited,
            status.all_homed,
            status.jogging,
        ];
        if !self.state.changes([packed(state)]) {
            return;
        }
        let all = [
            &g.motion_enabled,
            &g.in_position,
            &g.coord_mode,
            &g.teleop_mode,
            &g.tp_reverse,
            &g.coord_error,
            &g.on_soft_limit,
            &g.eoffset_active,
            &g.eoffset_limited,
            &g.is_all_homed,
            &g.jog_is_active,
        ];
        for (pin, value) in all.into_iter().zip(state) {
            pin.set(value);
        }
    }

    fn write_path(&mut self, s: &State, pins: &Pins, status: &MotionStatus) {
        let (g, t) = (&pins.general, &pins.traces);
        g.current_vel.set(status.velocity);
        g.distance_to_go.set(status.distance_to_go);
        let (heading, left) = s.path.headings();
        g.interp_heading.set(heading);
        g.interp_normal_heading.set(left);
        let (travelled, along) = s.path.along();
        t.tc_0_pos.set(travelled);
        t.tc_0_vel.set(along);
        t.tc_0_acc.set((along - core::mem::replace(&mut self.along, along)) / s.dt);
        t.traj_pos_out.set(travelled);
        t.traj_vel_out.set(along);
        let ([x, y, z], radius) = s.path.circle();
        let segment = [
            u64::from(status.segment) << 32 | u64::from(status.line),
            u64::from(status.motion_type),
            x.to_bits(),
            y.to_bits(),
            z.to_bits(),
            radius.to_bits(),
        ];
        if self.segment.changes(segment) {
            g.motion_type.set(status.motion_type.cast_signed());
            g.program_line.set(status.line.cast_signed());
            g.interp_iscircle.set(status.motion_type == 3);
            g.interp_arc_center_x.set(x);
            g.interp_arc_center_y.set(y);
            g.interp_arc_center_z.set(z);
            g.interp_arc_radius.set(radius);
            g.interp_line_number.set(status.line.cast_signed());
            g.interp_motion_type.set(status.motion_type.cast_signed());
            t.traj_active_tc.set(status.segment);
        }
        let (requested, feed) = s.path.feeds();
        let units = s.traj.units_per_mm;
        if self.feed.changes([requested.to_bits(), feed.to_bits(), units.to_bits()]) {
            g.requested_vel.set(requested);
            g.interp_feedrate.set(requested);
            write_feed(g, feed, units);
        }
    }

    fn write_tool(&mut self, s: &State, g: &GeneralPins) {
        if !self.tool.changes([s.tool_offsets.into()]) {
            return;
        }
        let tool = [
            &g.tooloffset_x,
            &g.tooloffset_y,
            &g.tooloffset_z,
            &g.tooloffset_a,
            &g.tooloffset_b,
            &g.tooloffset_c,
            &g.tooloffset_u,
            &g.tooloffset_v,
            &g.tooloffset_w,
        ];
        for (pin, offset) in tool.into_iter().zip(&s.tool_offset) {
            pin.set(*offset);
        }
    }
}

fn write_feed(g: &GeneralPins, feed: f64, units_per_mm: f64) {
    let mm = feed / units_per_mm;
    let inches = mm / 25.4;
    g.feed_upm.set(feed * 60.0);
    g.feed_mm_per_second.set(mm);
    g.feed_mm_per_minute.set(mm * 60.0);
    g.feed_inches_per_second.set(inches);
    g.feed_inches_per_minute.set(inches * 60.0);
}
