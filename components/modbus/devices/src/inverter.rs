//! Huanyang's inverter: ramps, trips, and a time-out by its own clock.

use crate::Device;
use hal_modbus::huanyang::{
    COMMAND_REVERSE, COMMAND_RUN, STOP, measured, parts, push_frame, setting, state,
};

/// Values of a spindle of 2.2 kW that turns 24000 times a minute at 400 Hz.
const SETTINGS: &[(u8, u16)] = &[
    (setting::BASE_FREQUENCY, 40_000),
    (setting::MAX_FREQUENCY, 40_000),
    (setting::MIN_FREQUENCY, 10_000),
    (setting::ACCELERATION, 40),
    (setting::DECELERATION, 20),
    (setting::MOTOR_VOLTAGE, 2200),
    (setting::MOTOR_CURRENT, 70),
    (setting::MOTOR_POLES, 2),
    (setting::MOTOR_TURNS, 3000),
];

/// Inverter with a motor.
#[derive(Clone, Debug)]
pub struct Inverter {
    /// Number of the device.
    pub unit: u8,
    /// Trip: the output is off, whatever is commanded. Its end is a reset at the panel: the next command to run starts it again.
    pub trip: bool,
    /// Time without a frame after which it stops by itself, in nanoseconds; 0 for never.
    pub timeout_ns: i64,
    settings: [u16; 256],
    set: u16,
    command: u8,
    /// Frequency at the output, in 0.01 Hz; negative in reverse.
    output: f64,
    /// A trip that was not reset since.
    has_tripped: bool,
    now: i64,
    /// Time of the last frame for it.
    heard: i64,
    /// Number of times that it has begun to run.
    starts: u32,
    /// Number of frames for it.
    frames: u32,
}

impl Inverter {
    /// Returns an inverter at rest.
    #[must_use]
    pub fn new(unit: u8) -> Self {
        let mut settings = [0; 256];
        for (number, value) in SETTINGS {
            if let Some(setting) = settings.get_mut(usize::from(*number)) {
                *setting = *value;
            }
        }
        Self {
            unit,
            trip: false,
            timeout_ns: 0,
            settings,
            set: 0,
            command: STOP,
            output: 0.0,
            has_tripped: false,
            now: 0,
            heard: 0,
            starts: 0,
            frames: 0,
        }
    }

    /// Returns a setting.
    #[must_use]
    pub fn setting(&self, number: u8) -> u16 {
        self.settings.get(usize::from(number)).copied().unwrap_or_default()
    }

    /// Returns the frequency at the output, in Hz, negative in reverse.
    #[must_use]
    pub fn hz(&self) -> f64 {
        self.output / 100.0
    }

    /// Returns whether it is commanded to run, and does.
    #[must_use]
    pub const fn runs(&self) -> bool {
        self.command & COMMAND_RUN != 0 && !self.trip
    }

    /// Returns the number of times that it has begun to run.
    #[must_use]
    pub const fn starts(&self) -> u32 {
        self.starts
    }

    /// Returns the number of frames that were for it.
    #[must_use]
    pub const fn frames(&self) -> u32 {
        self.frames
    }

    fn control(&mut self, command: u8) {
        let did_run = self.runs();
        self.command = command;
        if !did_run && self.runs() {
            self.starts = self.starts.wrapping_add(1);
        }
    }

    fn state(&self) -> u8 {
        let bit = |is: bool, bit: u8| if is { bit } else { 0 };
        let is_reverse = self.command & COMMAND_REVERSE != 0;
        bit(self.command & COMMAND_RUN != 0, state::RUN)
            | bit(is_reverse, state::COMMAND_REVERSE)
            | bit(self.output != 0.0, state::RUNNING)
            | bit(self.output < 0.0, state::RUNNING_REVERSE)
            | bit(self.output != 0.0 && !self.runs(), state::BRAKING)
    }

    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "within u16")]
    fn measure(&self, number: u8) -> u16 {
        let hundredths = self.output.abs().min(65535.0) as u16;
        match number {
            measured::SET_FREQUENCY => self.set,
            measured::FREQUENCY => hundredths,
            measured::CURRENT => hundredths / 2000,
            measured::TURNS => {
                let turns = u32::from(hundredths) * u32::from(self.setting(setting::MOTOR_TURNS));
                u16::try_from(turns / 5000).unwrap_or(u16::MAX)
            }
            measured::DC => 3110,
            measured::AC => hundredths / 20,
            measured::TEMPERATURE => 31,
            _ => 0,
        }
    }
}

impl Device for Inverter {
    fn advance(&mut self, now_ns: i64) {
        let seconds = (now_ns - self.now).max(0) as f64 * 1e-9;
        self.now = self.now.max(now_ns);
        if self.has_tripped && !self.trip {
            self.command = STOP;
        }
        self.has_tripped = self.trip;
        if 0 < self.timeout_ns && self.timeout_ns < now_ns - self.heard {
            self.command = STOP;
        }
        let top = self.setting(setting::MAX_FREQUENCY);
        let low = self.setting(setting::MIN_FREQUENCY).min(top);
        let target = match (self.runs(), self.command & COMMAND_REVERSE != 0) {
            (false, _) => 0.0,
            (true, false) => f64::from(self.set.max(low).min(top)),
            (true, true) => -f64::from(self.set.max(low).min(top)),
        };
        if self.trip {
            self.output = 0.0;
            return;
        }
        let is_faster = self.output.abs() < target.abs() && 0.0 <= self.output * target;
        let number = if is_faster { setting::ACCELERATION } else { setting::DECELERATION };
        let whole = f64::from(self.setting(number).max(1)) * 0.1;
        let step = f64::from(top) / whole * seconds;
        // A turn into the other direction goes through rest.
        let next = if self.output * target < 0.0 { 0.0 } else { target };
        self.output = if (next - self.output).abs() <= step {
            next
        } else if self.output < next {
            self.output + step
        } else {
            self.output - step
        };
    }

    fn hear(&mut self, bytes: &[u8], now_ns: i64, answer: &mut Vec<u8>) -> bool {
        let Some((unit, function, data)) = parts(bytes).filter(|(unit, ..)| *unit == self.unit)
        else {
            return false;
        };
        self.heard = now_ns;
        self.frames = self.frames.wrapping_add(1);
        let mut value = |number: u8, value: u16| {
            let [high, low] = value.to_be_bytes();
            push_frame(answer, unit, function, &[number, high, low]);
        };
        match (function, data) {
            (1, [number, ..]) => value(*number, self.setting(*number)),
            (2, [number, high, low]) => {
                let written = u16::from_be_bytes([*high, *low]);
                if let Some(setting) = self.settings.get_mut(usize::from(*number)) {
                    *setting = written;
                }
                value(*number, written);
            }
            (3, [command]) => {
                self.control(*command);
                push_frame(answer, unit, 3, &[self.state()]);
            }
            (4, [number, ..]) => value(*number, self.measure(*number)),
            (5, [high, low]) => {
                self.set = u16::from_be_bytes([*high, *low]);
                push_frame(answer, unit, 5, data);
            }
            _ => return false,
        }
        true
    }
}
