//! Pins of `halui`, by what they belong to.

use crate::pins::{Button, Counter, group};
use hal_component::{Builder, Error, In, Out, Touch};

group! {
    /// Machine, e-stop, coolant, lubrication, abort, homing.
    General {
        /// Brakes everything, ends the program and switches coolant off.
        abort: Button = false, "abort";
        /// Homes all joints in their order.
        home_all: Button = false, "home-all";
        /// Switches the machine on.
        on: Button = false, "machine.on";
        /// Switches the machine off.
        off: Button = false, "machine.off";
        /// TRUE while the machine is on.
        is_on: Out<bool> = false, "machine.is-on";
        /// Machine units per millimetre.
        units_per_mm: Out<f64> = 1.0, "machine.units-per-mm";
        /// Puts the machine into e-stop.
        estop: Button = false, "estop.activate";
        /// Leaves e-stop, if nothing outside holds it.
        estop_reset: Button = false, "estop.reset";
        /// TRUE in e-stop.
        is_estop: Out<bool> = true, "estop.is-activated";
        /// Switches flood coolant on.
        flood_on: Button = false, "flood.on";
        /// Switches flood coolant off.
        flood_off: Button = false, "flood.off";
        /// TRUE while flood coolant is on.
        is_flood: Out<bool> = false, "flood.is-on";
        /// Switches mist coolant on.
        mist_on: Button = false, "mist.on";
        /// Switches mist coolant off.
        mist_off: Button = false, "mist.off";
        /// TRUE while mist coolant is on.
        is_mist: Out<bool> = false, "mist.is-on";
        /// Switches lubrication on.
        lube_on: Button = false, "lube.on";
        /// Switches lubrication off.
        lube_off: Button = false, "lube.off";
        /// TRUE while lubrication is on.
        is_lube: Out<bool> = false, "lube.is-on";
    }
}

group! {
    /// Modes.
    Modes {
        /// Requests mode manual.
        manual: Button = false, "mode.manual";
        /// Requests mode auto.
        auto: Button = false, "mode.auto";
        /// Requests mode MDI.
        mdi: Button = false, "mode.mdi";
        /// Lets jogs move joints.
        joint: Button = false, "mode.joint";
        /// Lets jogs move axes.
        teleop: Button = false, "mode.teleop";
        /// TRUE in mode manual.
        is_manual: Out<bool> = true, "mode.is-manual";
        /// TRUE in mode auto.
        is_auto: Out<bool> = false, "mode.is-auto";
        /// TRUE in mode MDI.
        is_mdi: Out<bool> = false, "mode.is-mdi";
        /// TRUE while jogs move joints.
        is_joint: Out<bool> = true, "mode.is-joint";
        /// TRUE while jogs move axes.
        is_teleop: Out<bool> = false, "mode.is-teleop";
    }
}

group! {
    /// The program.
    Program {
        /// Runs the open program.
        run: Button = false, "program.run";
        /// Pauses the program, or a path of commands.
        pause: Button = false, "program.pause";
        /// Goes on after a pause.
        resume: Button = false, "program.resume";
        /// Goes on to the next line, or to the next move of a path of commands.
        step: Button = false, "program.step";
        /// Ends the program.
        stop: Button = false, "program.stop";
        /// TRUE while no program runs.
        is_idle: Out<bool> = true, "program.is-idle";
        /// TRUE while a program runs.
        is_running: Out<bool> = false, "program.is-running";
        /// TRUE while a program pauses.
        is_paused: Out<bool> = false, "program.is-paused";
        /// Lets M1 pause.
        stop_on: Button = false, "program.optional-stop.on";
        /// Lets M1 do nothing.
        stop_off: Button = false, "program.optional-stop.off";
        /// TRUE while M1 pauses.
        is_stop: Out<bool> = false, "program.optional-stop.is-on";
        /// Leaves out lines that begin with /.
        delete_on: Button = false, "program.block-delete.on";
        /// Executes lines that begin with /.
        delete_off: Button = false, "program.block-delete.off";
        /// TRUE while lines that begin with / are left out.
        is_delete: Out<bool> = false, "program.block-delete.is-on";
    }
}

group! {
    /// The tool.
    Tool {
        /// Number of the tool in the spindle; 0 for none.
        number: Out<u32> = 0, "tool.number";
        /// Diameter of the tool in the spindle, in machine units.
        diameter: Out<f64> = 0.0, "tool.diameter";
    }
}

group! {
    /// A knob: counts of a wheel, or buttons, change a value.
    Dial {
        /// TRUE while counts change the value.
        enable: In<bool> = true, "count-enable";
        /// Counts of a wheel.
        counts: Counter = 0, "counts";
        /// TRUE: the value is counts times scale; FALSE: it changes with them.
        direct: In<bool> = false, "direct-value";
        /// Adds scale.
        increase: Button = false, "increase";
        /// Subtracts scale.
        decrease: Button = false, "decrease";
        /// The value: a factor without unit, or machine units/s.
        value: Out<f64> = 1.0, "value";
    }
}

group! {
    /// Button of a knob that returns to the programmed value.
    Reset {
        /// Sets the value to 1.
        reset: Button = false, "reset";
    }
}

group! {
    /// A spindle.
    Spindle {
        /// Turns the spindle forward, at the last speed.
        start: Button = false, "start";
        /// Stops the spindle.
        stop: Button = false, "stop";
        /// Turns the spindle forward, at the last speed.
        forward: Button = false, "forward";
        /// Turns the spindle in reverse, at the last speed.
        reverse: Button = false, "reverse";
        /// Adds 100 turns/min to the speed of a spindle that turns.
        increase: Button = false, "increase";
        /// Takes 100 turns/min from the speed of a spindle that turns.
        decrease: Button = false, "decrease";
        /// Closes the brake.
        brake_on: Button = false, "brake-on";
        /// Opens the brake.
        brake_off: Button = false, "brake-off";
        /// TRUE while the brake is closed.
        is_brake: Out<bool> = true, "brake-is-on";
        /// TRUE while the spindle turns.
        is_on: Out<bool> = false, "is-on";
        /// TRUE while it turns forward.
        is_forward: Out<bool> = false, "runs-forward";
        /// TRUE while it turns in reverse.
        is_backward: Out<bool> = false, "runs-backward";
    }
}

group! {
    /// Jogs of a joint or an axis, or of the selected one.
    Jog {
        /// Jogs in the positive direction at jog-speed while TRUE.
        plus: In<bool> = false, "plus";
        /// Jogs in the negative direction at jog-speed while TRUE.
        minus: In<bool> = false, "minus";
        /// Distance of increment-plus and increment-minus, in machine units.
        increment: In<f64> = 0.0, "increment";
        /// Jogs by increment.
        increment_plus: Button = false, "increment-plus";
        /// Jogs by increment in the negative direction.
        increment_minus: Button = false, "increment-minus";
    }
}

group! {
    /// Jogs by a joystick, and selection.
    Stick {
        /// Jogs at this fraction of jog-speed, beyond jog-deadband.
        analog: In<f64> = 0.0, "analog";
        /// Selects it.
        select: Button = false, "select";
    }
}

group! {
    /// Speeds of all jogs of joints, or of axes.
    Speeds {
        /// Speed of jogs in machine units/s.
        speed: In<f64> = 0.0, "jog-speed";
        /// Part of the joystick's range, 0 to 1 without sign, that does not count.
        deadband: In<f64> = 0.2, "jog-deadband";
        /// Number of the selected one, from 0.
        selected: Out<u32> = 0, "selected";
    }
}

group! {
    /// State and homing of a joint, or of the selected one.
    Joint {
        /// Homes the joint.
        home: Button = false, "home";
        /// Forgets where the joint is.
        unhome: Button = false, "unhome";
        /// TRUE while the joint is homed.
        is_homed: Out<bool> = false, "is-homed";
        /// TRUE while its amplifier has a fault.
        has_fault: Out<bool> = false, "has-fault";
        /// TRUE at its positive limit switch.
        at_max: Out<bool> = false, "on-hard-max-limit";
        /// TRUE at its negative limit switch.
        at_min: Out<bool> = false, "on-hard-min-limit";
        /// TRUE at or above its upper soft limit.
        above: Out<bool> = false, "on-soft-max-limit";
        /// TRUE at or below its lower soft limit.
        below: Out<bool> = false, "on-soft-min-limit";
        /// TRUE while limit switches do not switch the machine off.
        overrides: Out<bool> = false, "override-limits";
    }
}

group! {
    /// Lamp of a selection.
    Selected {
        /// TRUE while it is selected.
        is_selected: Out<bool> = false, "is-selected";
    }
}

group! {
    /// Positions of an axis.
    Positions {
        /// Commanded position in machine coordinates, in machine units or degrees.
        commanded: Out<f64> = 0.0, "pos-commanded";
        /// Position according to the encoders in machine coordinates, in machine units or degrees.
        feedback: Out<f64> = 0.0, "pos-feedback";
        /// Position according to the encoders in coordinates of the program, in machine units or degrees.
        relative: Out<f64> = 0.0, "pos-relative";
    }
}

/// A knob, with its step and the button that sets it to 1.
#[derive(Clone, Debug, Touch)]
pub(crate) struct Knob {
    dial: Dial,
    scale: In<f64>,
    reset: Option<Reset>,
}

impl Knob {
    /// Makes the knob of an override.
    pub(crate) fn factor(b: &mut Builder<'_>, prefix: &str) -> Result<Self, Error> {
        let reset = Some(Reset::make(b, prefix)?);
        Ok(Self { dial: Dial::make(b, prefix)?, scale: scale(b, prefix, 0.1)?, reset })
    }

    /// Makes the knob of a value that has no programmed one.
    pub(crate) fn value(b: &mut Builder<'_>, prefix: &str, now: f64) -> Result<Self, Error> {
        let dial = Dial::make(b, prefix)?;
        dial.value.set(shown(now));
        Ok(Self { dial, scale: scale(b, prefix, 0.0)?, reset: None })
    }

    /// Shows the value `now`. Returns a new value if the knob was turned; not below 0.
    pub(crate) fn turn(&mut self, now: f64) -> Option<f64> {
        let (dial, scale) = (&mut self.dial, self.scale.get());
        dial.value.set(shown(now));
        let counts = dial.counts.change();
        let buttons = f64::from(dial.increase.is_pressed()) - f64::from(dial.decrease.is_pressed());
        let mut value = now;
        if counts != 0 && dial.enable.get() {
            value = if dial.direct.get() {
                f64::from(dial.counts.get()) * scale
            } else {
                value + f64::from(counts) * scale
            };
        }
        value += buttons * scale;
        if self.reset.as_mut().is_some_and(|r| r.reset.is_pressed()) {
            value = 1.0;
        }
        let value = if value > 0.0 { value } else { 0.0 };
        (value != now && value.is_finite()).then_some(value)
    }
}

fn scale(b: &mut Builder<'_>, prefix: &str, initial: f64) -> Result<In<f64>, Error> {
    b.item(
        &format!("{prefix}scale"),
        "Step of the value for each of the counts and for the buttons, in its unit.",
        initial,
    )
}

/// Returns the value that a pin shows: without a limit, the largest number that there is.
const fn shown(value: f64) -> f64 {
    value.min(f64::MAX)
}
