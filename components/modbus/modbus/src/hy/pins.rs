//! Pins of an inverter, and what passes between its function and its worker.

use hal_component::{Builder, Error, In, Out, ParamRw, Plain, Touch};

/// Declares values that the worker reports, each with its pin: field, type, pin, documentation; then values without pins.
macro_rules! shown {
    ($($name:ident: $ty:ident, $pin:literal, $doc:literal;)* => $($inner:ident: $inner_ty:ident, $inner_doc:literal;)*) => {
        /// Latest values of the worker.
        #[derive(Clone, Copy, Debug, Default, PartialEq, Plain)]
        pub(crate) struct Results {
            $(#[doc = $doc] pub(crate) $name: $ty,)*
            $(#[doc = $inner_doc] pub(crate) $inner: $inner_ty,)*
        }

        /// Pins that show them.
        #[derive(Debug, Touch)]
        pub(crate) struct ResultPins {
            $($name: Out<$ty>,)*
        }

        impl ResultPins {
            pub(crate) fn make(b: &mut Builder<'_>, prefix: &str) -> Result<Self, Error> {
                Ok(Self { $($name: b.item(&format!("{prefix}.{}", $pin), $doc, $ty::default())?,)* })
            }

            /// Realtime.
            pub(crate) fn set(&self, values: &Results) {
                $(self.$name.set(values.$name);)*
            }
        }
    };
}

shown! {
    set_f: f64, "SetF", "Frequency that is set, in hertz.";
    out_f: f64, "OutF", "Frequency at the output, in hertz.";
    out_a: f64, "OutA", "Current at the output, in units of 1 A.";
    rott: f64, "Rott", "Turns per minute, as the inverter calculates them.";
    dcv: f64, "DCV", "Voltage of its direct current, in the inverter's unit: V or 0.1 V.";
    acv: f64, "ACV", "Voltage of its output, in the inverter's unit: V or 0.1 V.";
    cont: f64, "Cont", "Counter of the inverter, in counts.";
    tmp: f64, "Tmp", "Temperature of the inverter, in its unit.";
    cntr: f64, "CNTR", "Command, 0 to 255: 1 is forward, 17 reverse, 8 stop.";
    cnst: f64, "CNST", "State of the inverter after the last command, 0 to 255; the pins CNST-* are its bits.";
    cnst_run: bool, "CNST-run", "TRUE while it is commanded to run.";
    cnst_jog: bool, "CNST-jog", "TRUE while it is commanded to jog.";
    cnst_command_rf: bool, "CNST-command-rf", "TRUE while it is commanded to turn in reverse.";
    cnst_running: bool, "CNST-running", "TRUE while it runs.";
    cnst_jogging: bool, "CNST-jogging", "TRUE while it jogs.";
    cnst_running_rf: bool, "CNST-running-rf", "TRUE while it turns in reverse.";
    cnst_bracking: bool, "CNST-bracking", "TRUE while it brakes.";
    cnst_track_start: bool, "CNST-track-start", "TRUE while it takes up a motor that turns.";
    spindle_speed_fb: f64, "spindle-speed-fb", "Speed by the frequency at the output, in turns per minute, never negative.";
    frequency_command: f64, "frequency-command", "Frequency for speed-command within the inverter's limits, in units of 0.01 Hz.";
    max_freq: f64, "max-freq", "Greatest frequency (PD005), in hertz.";
    base_freq: f64, "base-freq", "Rated frequency of the motor (PD004), in hertz.";
    freq_lower_limit: f64, "freq-lower-limit", "Least frequency (PD011), in hertz.";
    rated_motor_voltage: f64, "rated-motor-voltage", "Rated voltage of the motor (PD141), in volts.";
    rated_motor_current: f64, "rated-motor-current", "Rated current of the motor (PD142), in units of 1 A.";
    rated_motor_rev: f64, "rated-motor-rev", "Turns per minute of the motor at the greatest frequency, from PD144 and PD005.";
    motor_poles: u32, "motor-poles", "Number of the motor's poles (PD143).";
    hycomm_ok: bool, "hycomm-ok", "TRUE while the last request was answered.";
    fault: bool, "fault", "TRUE while requests fail and none was answered for longer than timeout=, or the worker stands still: the motion controller is off then.";
    requests: u32, "requests", "Number of requests.";
    answers: u32, "answers", "Number of answers.";
    errors_silent: u32, "errors-silent", "Number of requests without an answer.";
    errors_other: u32, "errors-other", "Number of requests that another device answered.";
    errors_wrong: u32, "errors-wrong", "Number of answers to something else.";
    errors_noise: u32, "errors-noise", "Number of answers that were no frames.";
    errors_line: u32, "errors-line", "Number of times that the line was lost, such as a pulled adapter.";
    since_answer: f64, "since-answer", "Time since the last answer, in seconds.";
    =>
    last_error: i32, "Code of the last error.";
    ready: bool, "The settings are read, and the inverter answers.";
    lapses: u32, "Number of times after which a person has to command the spindle anew.";
}

impl Results {
    /// Returns the number of errors of all kinds.
    pub(crate) const fn errors(&self) -> u32 {
        self.errors_silent
            .saturating_add(self.errors_other)
            .saturating_add(self.errors_wrong)
            .saturating_add(self.errors_noise)
            .saturating_add(self.errors_line)
    }
}

/// Values that the function passes to the worker.
#[derive(Clone, Copy, Debug, Default, PartialEq, Plain)]
pub(crate) struct Inputs {
    /// The inverter is spoken to.
    pub(crate) enable: bool,
    /// Direction: 0 to stand, 1 forward, -1 reverse.
    pub(crate) run: i32,
    /// Speed in turns per minute.
    pub(crate) speed: f64,
    /// Number of lapses that the function has seen.
    pub(crate) seen: u32,
    /// Number of cycles of the function, 0 before the first.
    pub(crate) cycles: u32,
}

/// Pins that a machine sets.
#[derive(Debug, Touch)]
pub(crate) struct InputPins {
    pub(crate) enable: In<bool>,
    pub(crate) on: In<bool>,
    pub(crate) forward: In<bool>,
    pub(crate) reverse: In<bool>,
    pub(crate) speed: In<f64>,
    pub(crate) tolerance: In<f64>,
    pub(crate) at_speed: Out<bool>,
    pub(crate) error_count: ParamRw<i32>,
    pub(crate) retval: ParamRw<f64>,
}

impl InputPins {
    pub(crate) fn make(b: &mut Builder<'_>, prefix: &str) -> Result<Self, Error> {
        let name = |pin| format!("{prefix}.{pin}");
        Ok(Self {
            enable: b.item(
                &name("enable"),
                "TRUE speaks to the inverter; FALSE stops it, and then says nothing more.",
                false,
            )?,
            on: b.item(&name("spindle-on"), "TRUE runs the inverter, in the one direction that is TRUE.", false)?,
            forward: b.item(&name("spindle-forward"), "Direction forward.", false)?,
            reverse: b.item(
                &name("spindle-reverse"),
                "Direction reverse. Both or none of the directions stop the inverter.",
                false,
            )?,
            speed: b.item(
                &name("speed-command"),
                "Speed in turns per minute; its sign has no effect. At 0 the inverter stands.",
                0.0,
            )?,
            tolerance: b.item(
                &name("spindle-at-speed-tolerance"),
                "Largest difference at speed, as a fraction of speed-command.",
                0.02,
            )?,
            at_speed: b.item(
                &name("spindle-at-speed"),
                "TRUE while the inverter runs and spindle-speed-fb is within the tolerance of speed-command.",
                false,
            )?,
            error_count: b.item(
                &name("error-count"),
                "Number of errors of all kinds; may be set, such as to 0.",
                0,
            )?,
            retval: b.item(
                &name("retval"),
                "Code of the last error: -12 no answer, -16 a wrong one, else the negative number of the system; no unit.",
                0.0,
            )?,
        })
    }
}
