//! Values that the conversation shows on pins.

use super::{Drive, Stage};
use crate::hy::pins::Results;
use hal_modbus::huanyang::state;

impl Drive {
    /// Returns what the pins show.
    pub(crate) fn results(&self, now: i64) -> Results {
        let [.., poles, _] = self.settings;
        let [top, base, low, voltage, current, ..] = self.settings.map(f64::from);
        let [set, out, amperes, turns, dc, ac, counter, temperature] = self.measured.map(f64::from);
        let (command, frequency) = self.command();
        let is = |bit: u8| self.state & bit != 0;
        let speed_fb = if top == 0.0 { 0.0 } else { out / top * self.turns() };
        Results {
            set_f: set * 0.01,
            out_f: out * 0.01,
            out_a: amperes * 0.1,
            rott: turns,
            dcv: dc,
            acv: ac,
            cont: counter,
            tmp: temperature,
            cntr: f64::from(if self.stage == Stage::Round { command } else { 0 }),
            cnst: f64::from(self.state),
            cnst_run: is(state::RUN),
            cnst_jog: is(state::JOG),
            cnst_command_rf: is(state::COMMAND_REVERSE),
            cnst_running: is(state::RUNNING),
            cnst_jogging: is(state::JOGGING),
            cnst_running_rf: is(state::RUNNING_REVERSE),
            cnst_bracking: is(state::BRAKING),
            cnst_track_start: is(state::TRACKING),
            spindle_speed_fb: speed_fb,
            frequency_command: frequency.map_or(0.0, f64::from),
            max_freq: top * 0.01,
            base_freq: base * 0.01,
            freq_lower_limit: low * 0.01,
            rated_motor_voltage: voltage * 0.1,
            rated_motor_current: current * 0.1,
            rated_motor_rev: self.turns(),
            motor_poles: u32::from(poles),
            hycomm_ok: self.is_answered,
            fault: self.is_lost,
            requests: self.requests,
            answers: self.answers,
            errors_silent: self.errors[0],
            errors_other: self.errors[1],
            errors_wrong: self.errors[2],
            errors_noise: self.errors[3],
            errors_line: self.losses,
            since_answer: now.saturating_sub(self.last_answer) as f64 * 1e-9,
            last_error: self.last_error,
            ready: self.stage == Stage::Round && !self.is_lost,
            lapses: self.lapses,
        }
    }
}
