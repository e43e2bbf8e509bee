//! The answers from which a machine is written.

use super::{
    boards::board,
    questions::{is_second, joints},
    sheet::Sheet,
};

/// Motors of the joints.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Motors {
    /// Stepper motors, an axis each.
    Steppers,
    /// Servo motors with encoders, an axis each.
    Servos,
    /// Stepper motors of the six joints of an arm.
    Arm,
}

/// The board with the inputs and outputs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Driver {
    Parport,
    Viagpio,
}

/// Unit of length.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Units {
    Mm,
    Inch,
}

/// A machine as its builder describes it.
#[derive(Clone, Debug)]
pub(super) struct Answers {
    /// Name of the machine, of its folder and of its files.
    pub(super) name: String,
    pub(super) kind: Motors,
    pub(super) driver: Driver,
    /// Addresses and directions of parallel ports, as `378 out`.
    pub(super) ports: Vec<String>,
    pub(super) units: Units,
    /// The largest jitter that a latency test showed, in nanoseconds.
    pub(super) latency: f64,
    /// Longest base period that the board bears, in nanoseconds.
    pub(super) longest: f64,
    /// Model of the arm.
    pub(super) model: String,
    /// Times of the drives for steps.
    pub(super) pulse: Pulse,
    /// Lines of the board that belong to the whole machine.
    pub(super) pins: MachineLines,
    pub(super) spindle: Spindle,
    /// The axes of an arm. Other machines have an axis for each joint.
    pub(super) axis: Vec<Axis>,
    pub(super) joint: Vec<Joint>,
}

/// Times that a drive needs for a step, in nanoseconds.
#[derive(Clone, Copy, Debug)]
pub(super) struct Pulse {
    pub(super) length: f64,
    pub(super) space: f64,
    /// From the end of a step to a change of the direction.
    pub(super) hold: f64,
    /// From a change of the direction to the next step.
    pub(super) setup: f64,
}

impl Default for Pulse {
    fn default() -> Self {
        Self { length: 5000.0, space: 5000.0, hold: 20_000.0, setup: 20_000.0 }
    }
}

/// Lines that belong to the whole machine; each is none if it is not wired.
#[derive(Clone, Debug, Default)]
pub(super) struct MachineLines {
    /// Input that is TRUE while the e-stop chain is closed.
    pub(super) estop: Option<String>,
    /// Output of a relay in the e-stop chain.
    pub(super) estop_out: Option<String>,
    /// Output with a square wave while all is well.
    pub(super) charge_pump: Option<String>,
    /// Output that switches the drives on.
    pub(super) enable: Option<String>,
    /// Inputs of a touch probe and of a tool setter.
    pub(super) probe: Option<String>,
    pub(super) setter: Option<String>,
    /// Outputs of the spindle: on, backward, speed as pulse width.
    pub(super) spindle: Option<String>,
    pub(super) spindle_reverse: Option<String>,
    pub(super) spindle_pwm: Option<String>,
}

/// Spindle with a pulse width for its speed.
#[derive(Clone, Copy, Debug)]
pub(super) struct Spindle {
    /// Speed at full pulse width, in turns a minute.
    pub(super) speed: f64,
    /// Frequency, in hertz.
    pub(super) frequency: f64,
}

/// An axis of an arm: its work volume and its speeds.
#[derive(Clone, Debug)]
pub(super) struct Axis {
    pub(super) letter: String,
    pub(super) min: f64,
    pub(super) max: f64,
    pub(super) velocity: f64,
    pub(super) acceleration: f64,
}

/// A joint with its motor. Lengths are in the units of the machine; those of an arm are degrees.
#[derive(Clone, Debug)]
pub(super) struct Joint {
    /// Letter of its axis; not for an arm.
    pub(super) axis: Option<String>,
    /// True for the second motor of a gantry.
    pub(super) is_second: bool,
    /// Full steps of a turn of the motor, or edges of the encoder.
    pub(super) turn: f64,
    pub(super) microsteps: f64,
    /// Turns of the motor for a turn of the screw.
    pub(super) gear: f64,
    /// Way of a turn of the screw.
    pub(super) pitch: f64,
    pub(super) velocity: f64,
    pub(super) acceleration: f64,
    /// Acceleration that the step generator may use; 1.25 times `acceleration` if it is missing.
    pub(super) drive_acceleration: Option<f64>,
    pub(super) min: f64,
    pub(super) max: f64,
    pub(super) home: f64,
    /// Velocity with its sign at which homing looks for the switch.
    pub(super) search: Option<f64>,
    // Outputs: steps, or the power of a servo; the direction; the enable.
    pub(super) step: Option<String>,
    pub(super) direction: Option<String>,
    pub(super) enable: Option<String>,
    /// Input: the switch at both ends, which is the home switch as well.
    pub(super) switch: Option<String>,
    // Inputs of an encoder.
    pub(super) a: Option<String>,
    pub(super) b: Option<String>,
    /// Speed of a servo at full power.
    pub(super) full_speed: Option<f64>,
}

impl Joint {
    /// Returns the steps, or the edges of the encoder, of a unit of length.
    pub(super) fn scale(&self) -> f64 {
        self.turn * self.microsteps * self.gear / self.pitch
    }
}

impl Answers {
    /// Returns the machine of these answers; joints whose steps are not known yet are left out.
    pub(super) fn of(sheet: &Sheet) -> Self {
        let text = |key: &str| sheet.some(key).map(str::to_owned);
        let number = |key: &str| sheet.number(key);
        let pin = |name: &str| text(&format!("pins.{name}"));
        let usual = Pulse::default();
        let kind = match sheet.get("kind") {
            Some("servos") => Motors::Servos,
            Some("arm") => Motors::Arm,
            _ => Motors::Steppers,
        };
        let letters = sheet.letters();
        let axis =
            letters.iter().enumerate().filter(|_| kind == Motors::Arm).filter_map(|(n, l)| {
                let number = |name: &str| number(&format!("axis.{n}.{name}"));
                Some(Axis {
                    letter: l.to_string(),
                    min: number("min")?,
                    max: number("max")?,
                    velocity: number("velocity")?,
                    acceleration: number("acceleration")?,
                })
            });
        Self {
            name: text("name").unwrap_or_default(),
            kind,
            driver: match sheet.get("driver") {
                Some("viagpio") => Driver::Viagpio,
                _ => Driver::Parport,
            },
            ports: sheet
                .get("ports")
                .unwrap_or("378 out")
                .split(',')
                .map(|port| port.trim().to_owned())
                .collect(),
            units: if sheet.get("units") == Some("inch") { Units::Inch } else { Units::Mm },
            latency: number("latency").unwrap_or_default(),
            longest: board(sheet.get("board")).map_or(100_000.0, |board| board.longest),
            model: text("model").unwrap_or_default(),
            pulse: Pulse {
                length: number("pulse.length").unwrap_or(usual.length),
                space: number("pulse.space").unwrap_or(usual.space),
                hold: number("pulse.hold").unwrap_or(usual.hold),
                setup: number("pulse.setup").unwrap_or(usual.setup),
            },
            pins: MachineLines {
                estop: pin("estop"),
                estop_out: pin("estop-out"),
                charge_pump: pin("charge-pump"),
                enable: pin("enable"),
                probe: pin("probe"),
                setter: pin("setter"),
                spindle: pin("spindle"),
                spindle_reverse: pin("spindle-reverse"),
                spindle_pwm: pin("spindle-pwm"),
            },
            spindle: Spindle {
                speed: number("spindle.speed").unwrap_or(24_000.0),
                frequency: number("spindle.frequency").unwrap_or(100.0),
            },
            axis: axis.collect(),
            joint: (0..joints(sheet)).filter_map(|n| joint(sheet, kind, n)).collect(),
        }
    }
}

/// Returns a joint; the second motor of a gantry has the figures of the first.
fn joint(sheet: &Sheet, kind: Motors, n: usize) -> Option<Joint> {
    let is_second = is_second(sheet, n);
    let figures = if is_second { n - 1 } else { n };
    let number = |name: &str| sheet.number(&format!("joint.{figures}.{name}"));
    let text = |name: &str| sheet.some(&format!("joint.{n}.{name}")).map(str::to_owned);
    let letter = sheet.letters().get(n).map(char::to_string);
    Some(Joint {
        axis: letter.filter(|_| kind != Motors::Arm),
        is_second,
        turn: number("turn")?,
        microsteps: number("microsteps")?,
        gear: number("gear")?,
        pitch: number("pitch")?,
        velocity: number("velocity")?,
        acceleration: number("acceleration")?,
        drive_acceleration: number("drive-acceleration"),
        min: number("min")?,
        max: number("max")?,
        home: number("home").unwrap_or_default(),
        search: number("search").filter(|_| text("switch").is_some()),
        step: text("step"),
        direction: text("direction"),
        enable: text("enable"),
        switch: text("switch"),
        a: text("a"),
        b: text("b"),
        full_speed: number("full-speed"),
    })
}
