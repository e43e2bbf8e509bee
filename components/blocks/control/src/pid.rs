//! `pid`.
use crate::tune::Tuner;
use hal_component::{
    Arg, Builder, Channels, Component, Error, In, InSet, Io, Out, Period, Touch, Update,
    abi::{ArgSpec, component_flags},
    pins,
};

#[cfg(test)]
mod closed;

const LOOPS: Channels = Channels { prefix: "pid", usual: 3 };

/// Closed-loop controller.
pub(crate) struct Pid;

impl Component for Pid {
    const NAME: &'static str = "pid";
    const DOC: &'static str = "Closed loop: proportional, integral, derivative and feedforward, \
        with automatic tuning.\n\n\
        `num_chan=2` makes `pid.0` and `pid.1`, `names=x,y` makes `x` and `y`, nothing makes three; \
        at most 16. Each has a function `pid.N.do-pid-calcs`. `debug=1` adds pins that show the \
        integral and the derivatives.\n\n\
        The output is `bias`, plus each gain times what it belongs to, within ±`maxoutput`: `Pgain` \
        the error, `Igain` its integral, `Dgain` its rate of change, `FF0` the command, and `FF1` to \
        `FF3` the command's first to third derivative. A limit of 0 means no limit. The integral \
        is held while the output is limited.\n\n\
        Tuning: with `enable` and `tune-mode` true, `tune-start` lets the output switch between \
        `bias` plus and minus `tune-effort` as the error changes sign; after `tune-cycles` half \
        cycles the gains are computed from the measured oscillation, and `tune-start` becomes \
        false.\n\n\
        # Pins\n\n\
        ```hal\n\
        loadrt pid num_chan=1 debug=1\n\
        ```\n\n\
        # Example\n\n\
        ```hal\n\
        loadrt pid num_chan=1\n\
        loadrt threads name1=servo period1=1000000\n\
        addf pid.0.do-pid-calcs servo\n\
        start\n\
        setp pid.0.Pgain 10\n\
        setp pid.0.maxoutput 40\n\
        setp pid.0.enable 1\n\
        setp pid.0.command 3\n\
        setp pid.0.feedback 1\n\
        run 2ms\n\
        getp pid.0.error # -> 2\n\
        getp pid.0.output # -> 20\n\
        setp pid.0.feedback -9\n\
        run 2ms\n\
        getp pid.0.output # -> 40\n\
        getp pid.0.saturated # -> TRUE\n\
        ```";
    const FLAGS: u32 = component_flags::ONCE | component_flags::PARALLEL;
    const ARGS: &'static [&'static ArgSpec] = &[
        &Arg::int("num_chan", "Number of loops; 0 is taken as 3.").within(0.0, 16.0),
        &Arg::texts("names", "Names of the loops, instead of `num_chan=`; at most 16.").at_most(16),
        &Arg::int("debug", "1: also pins for the integral and the derivatives.").or("0"),
    ];

    fn create(b: &mut Builder<'_>) -> Result<(), Error> {
        let debug = b.arg_int("debug").unwrap_or(0) != 0;
        LOOPS.names(b)?.iter().try_for_each(|name| Loop::create(b, name, debug))
    }
}

pins! {
    /// Pins of a loop.
    pub(crate) struct Pins {
        /// TRUE enables the loop; while FALSE, the output is 0 and the integral is reset.
        enable: In<bool> = "enable", false;
        /// Commanded position, in units.
        command: In<f64> = "command", 0.0;
        /// Feedback position, in units.
        feedback: In<f64> = "feedback", 0.0;
        /// Derivative of the command, in units per second; computed if nothing is linked.
        command_deriv: InSet<f64> = "command-deriv", 0.0;
        /// Derivative of the feedback, in units per second; computed if nothing is linked.
        feedback_deriv: InSet<f64> = "feedback-deriv", 0.0;
        /// TRUE computes the error from the command of the previous cycle, which is the one that a motion controller's
        /// feedback responds to.
        error_previous_target: In<bool> = "error-previous-target", true;
        /// Index search of this axis: on its falling edge, the jump of the command does not count as speed.
        index_enable: In<bool> = "index-enable", false;
        /// Error: command minus feedback, in units.
        error: Out<f64> = "error", 0.0;
        /// Output for the actuator, in the unit that the gains give.
        output: Out<f64> = "output", 0.0;
        /// True while the output is at its limit.
        saturated: Out<bool> = "saturated", false;
        /// Time for which the output has been at its limit, in seconds.
        saturated_s: Out<f64> = "saturated-s", 0.0;
        /// Number of consecutive cycles for which the output has been at its limit.
        saturated_count: Out<i32> = "saturated-count", 0;
        /// Deadband: a smaller error counts as 0, and a larger one is reduced by it; in units.
        deadband: In<f64> = "deadband", 0.0;
        /// Limit of the error, in units; 0: no limit.
        maxerror: In<f64> = "maxerror", 0.0;
        /// Limit of the integrated error, in units times seconds; 0: no limit.
        maxerror_i: In<f64> = "maxerrorI", 0.0;
        /// Limit of the error's derivative, in units per second; 0: no limit.
        maxerror_d: In<f64> = "maxerrorD", 0.0;
        /// Limit of the command's first derivative, in units per second; 0: no limit.
        maxcmd_d: In<f64> = "maxcmdD", 0.0;
        /// Limit of the command's second derivative, in units per second²; 0: no limit.
        maxcmd_dd: In<f64> = "maxcmdDD", 0.0;
        /// Limit of the command's third derivative, in units per second³; 0: no limit.
        maxcmd_ddd: In<f64> = "maxcmdDDD", 0.0;
        /// Limit of the output in both directions, in the output's unit; 0: no limit.
        maxoutput: In<f64> = "maxoutput", 0.0;
        /// Constant added to the output, in the output's unit.
        bias: In<f64> = "bias", 0.0;
        /// Proportional gain: output per unit of error. Tuning sets it.
        p_gain: InSet<f64> = "Pgain", 1.0;
        /// Integral gain: output per unit of integrated error. Tuning sets it.
        i_gain: InSet<f64> = "Igain", 0.0;
        /// Derivative gain: output per unit of the error's derivative. Tuning sets it.
        d_gain: InSet<f64> = "Dgain", 0.0;
        /// Feedforward of order 0: output per unit of the command. Tuning clears it.
        ff0: InSet<f64> = "FF0", 0.0;
        /// Feedforward of order 1: output per unit of the command's first derivative. Tuning sets it.
        ff1: InSet<f64> = "FF1", 0.0;
        /// Feedforward of order 2: output per unit of the command's second derivative. Tuning clears it.
        ff2: InSet<f64> = "FF2", 0.0;
        /// Feedforward of order 3: output per unit of the command's third derivative.
        ff3: In<f64> = "FF3", 0.0;
        /// Output in both directions during tuning, in the output's unit; a negative value counts as positive.
        tune_effort: Io<f64> = "tune-effort", 0.5;
        /// Number of half cycles that tuning measures; at least 2.
        tune_cycles: Io<u32> = "tune-cycles", 50;
        /// Result of tuning: 0 sets P, I and D; 1 sets P, I and `FF1`.
        tune_type: Io<u32> = "tune-type", 0;
        /// TRUE hands the loop over to tuning; the loop then does not control.
        tune_mode: In<bool> = "tune-mode", false;
        /// Starts tuning; becomes false when tuning is complete.
        tune_start: Io<bool> = "tune-start", false;
    }
}

pins! {
    /// Pins that `debug=1` adds.
    struct Inside {
        /// Integral of the error, in units times seconds.
        error_i: Out<f64> = "errorI", 0.0;
        /// Derivative of the error, in units per second.
        error_d: Out<f64> = "errorD", 0.0;
        /// First derivative of the command, in units per second.
        command_d: Out<f64> = "commandD", 0.0;
        /// Second derivative of the command, in units per second².
        command_dd: Out<f64> = "commandDD", 0.0;
        /// Third derivative of the command, in units per second³.
        command_ddd: Out<f64> = "commandDDD", 0.0;
        /// Ultimate gain found by tuning, at which the loop would oscillate: output per unit of error.
        ultimate_gain: Out<f64> = "ultimate-gain", 0.0;
        /// Ultimate period found by tuning: the period of that oscillation, in seconds.
        ultimate_period: Out<f64> = "ultimate-period", 0.0;
    }
}

/// State of a loop from one cycle to the next.
#[derive(Debug, Default)]
struct Memory {
    command: f64,
    feedback: f64,
    error_i: f64,
    error_d: f64,
    cmd_d: f64,
    cmd_dd: f64,
    cmd_ddd: f64,
    /// 1 at the upper limit of the output, -1 at the lower limit, else 0.
    limited: f64,
    index_enable: bool,
}

impl Memory {
    /// Resets the part of the state that tuning invalidates.
    fn forget(&mut self) {
        (self.command, self.limited) = (0.0, 0.0);
        (self.error_i, self.error_d, self.cmd_d, self.cmd_dd) = (0.0, 0.0, 0.0, 0.0);
    }
}

/// Control loop.
#[derive(Touch)]
struct Loop {
    pins: Pins,
    inside: Option<Inside>,
    #[state]
    was: Memory,
    #[state]
    tuner: Tuner,
}

impl Loop {
    fn create(b: &mut Builder<'_>, name: &str, debug: bool) -> Result<(), Error> {
        let pins = Pins::make(b, name)?;
        let inside = if debug { Some(Inside::make(b, name)?) } else { None };
        let own = Self { pins, inside, was: Memory::default(), tuner: Tuner::default() };
        b.function(&format!("{name}.do-pid-calcs"), "Computes the output.", own)
    }

    /// Returns the effective error: limited, and reduced by the deadband.
    fn error(&self, raw: f64) -> f64 {
        let error = limited(raw, self.pins.maxerror.get());
        let deadband = self.pins.deadband.get();
        if error > deadband {
            error - deadband
        } else if error < -deadband {
            error + deadband
        } else {
            0.0
        }
    }

    /// Updates the derivatives of error and command.
    fn derivatives(&mut self, command: f64, feedback: f64, index_fell: bool, per_s: f64) {
        let p = &self.pins;
        if !index_fell {
            p.command_deriv.set_own((command - self.was.command) * per_s);
            p.feedback_deriv.set_own((feedback - self.was.feedback) * per_s);
        }
        (self.was.command, self.was.feedback) = (command, feedback);
        let rate = p.command_deriv.get();
        self.was.error_d = limited(rate - p.feedback_deriv.get(), p.maxerror_d.get());
        let cmd_d = limited(rate, p.maxcmd_d.get());
        let cmd_dd = limited((cmd_d - self.was.cmd_d) * per_s, p.maxcmd_dd.get());
        let cmd_ddd = limited((cmd_dd - self.was.cmd_dd) * per_s, p.maxcmd_ddd.get());
        (self.was.cmd_d, self.was.cmd_dd, self.was.cmd_ddd) = (cmd_d, cmd_dd, cmd_ddd);
    }

    /// Returns the sum of all terms, within the limit.
    fn output(&mut self, error: f64, command: f64) -> f64 {
        let (p, was) = (&self.pins, &mut self.was);
        let feedback = p.bias.get()
            + p.p_gain.get() * error
            + was.error_i * p.i_gain.get()
            + was.error_d * p.d_gain.get();
        let forward = command * p.ff0.get()
            + was.cmd_d * p.ff1.get()
            + was.cmd_dd * p.ff2.get()
            + was.cmd_ddd * p.ff3.get();
        let sum = feedback + forward;
        let most = p.maxoutput.get();
        if most == 0.0 {
            return sum;
        }
        let (out, limited) = if sum > most {
            (most, 1.0)
        } else if sum < -most {
            (-most, -1.0)
        } else {
            (sum, 0.0)
        };
        was.limited = limited;
        out
    }

    fn show(&self, dt: f64) {
        let (p, was) = (&self.pins, &self.was);
        let limited = was.limited != 0.0;
        p.saturated.set(limited);
        p.saturated_s.set(if limited { p.saturated_s.get() + dt } else { 0.0 });
        p.saturated_count.set(if limited { p.saturated_count.get().saturating_add(1) } else { 0 });
        self.show_inside();
    }

    fn show_inside(&self) {
        let was = &self.was;
        if let Some(i) = &self.inside {
            i.error_i.set(was.error_i);
            i.error_d.set(was.error_d);
            i.command_d.set(was.cmd_d);
            i.command_dd.set(was.cmd_dd);
            i.command_ddd.set(was.cmd_ddd);
            i.ultimate_gain.set(self.tuner.gain);
            i.ultimate_period.set(self.tuner.period);
        }
    }
}

impl Update for Loop {
    fn update(&mut self, period: Period) {
        let dt = period.secs();
        let enable = self.pins.enable.get();
        let (command, feedback) = (self.pins.command.get(), self.pins.feedback.get());
        let index = self.pins.index_enable.get();
        let index_fell = self.was.index_enable && !index;
        let before = self.pins.error_previous_target.get() && !index_fell;
        let before = before && !self.tuner.is_on();
        let raw = if before { self.was.command } else { command } - feedback;
        self.pins.error.set(raw);
        if self.tuner.is_on() || self.pins.tune_mode.get() {
            #[expect(clippy::cast_possible_truncation, reason = "the time wraps")]
            self.tuner.run(&self.pins, raw, period.ns().cast_unsigned() as u32);
            self.was.forget();
            self.show_inside();
            return;
        }
        self.was.index_enable = index;
        let error = self.error(raw);
        if !enable {
            self.was.error_i = 0.0;
        } else {
            // Anti-windup: while the output is at its limit, the integral does not grow further in that direction. Its
            // own limit always applies.
            let more = if error * self.was.limited <= 0.0 { error * dt } else { 0.0 };
            self.was.error_i = limited(self.was.error_i + more, self.pins.maxerror_i.get());
        }
        self.derivatives(command, feedback, index_fell, 1.0 / dt);
        if enable {
            let out = self.output(error, command);
            self.pins.output.set(out);
        } else {
            self.pins.output.set(0.0);
            self.was.limited = 0.0;
        }
        self.show(dt);
    }
}

/// Limits `x` to plus and minus `most`; 0 means no limit.
fn limited(x: f64, most: f64) -> f64 {
    if most == 0.0 {
        x
    } else if x > most {
        most
    } else if x < -most {
        -most
    } else {
        x
    }
}

#[cfg(test)]
mod tests {
    use super::Pid;
    use hal_bench::{Bench, trace::replay};

    #[test]
    fn as_recorded() {
        assert_eq!(replay::<Pid>(include_str!("../traces/pid.txt")), 2658);
    }

    #[test]
    fn names_and_numbers() {
        for (args, wanted) in [
            (&[][..], Ok(3)),
            (&["num_chan=0"], Ok(3)),
            (&["num_chan=16"], Ok(16)),
            (&["names=a,,b"], Ok(1)),
            (&["num_chan=17"], Err("`17' out of range for parameter `num_chan=17'")),
            (&["num_chan=-1"], Err("`-1' out of range for parameter `num_chan=-1'")),
            (&["num_chan=1", "names=a"], Err("num_chan= and names= are mutually exclusive")),
        ] {
            let mut bench = Bench::new();
            let made = bench.load::<Pid>(args).map(|()| bench.functs().len());
            assert_eq!(made, wanted.map_err(str::to_owned), "{args:?}");
        }
        let mut bench = Bench::new();
        bench.load::<Pid>(&["names=x"]).unwrap();
        assert_eq!(bench.functs(), ["x.do-pid-calcs"]);
        assert_eq!(bench.names().len(), 33);
        let mut bench = Bench::new();
        bench.load::<Pid>(&["names=x", "debug=1"]).unwrap();
        assert_eq!(bench.names().len(), 40);
    }
}
