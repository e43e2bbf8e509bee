//! Pins of the component, and what passes between its function and its worker.

use hal_component::{Builder, Decl, Error, In, Out, Plain, Touch};

/// Declares values that the worker reports, each with its pin: field, type, first value, pin, documentation.
macro_rules! shown {
    ($record:ident, $pins:ident: $($name:ident: $ty:ident = $first:tt, $pin:literal, $doc:literal;)*) => {
        /// Latest values of the worker.
        #[derive(Clone, Copy, Debug, PartialEq, Plain)]
        pub(crate) struct $record {
            $(#[doc = $doc] pub(crate) $name: $ty,)*
        }

        impl Default for $record {
            fn default() -> Self {
                Self { $($name: $first,)* }
            }
        }

        /// Pins that show them.
        #[derive(Debug, Touch)]
        pub(crate) struct $pins {
            $(pub(crate) $name: Out<$ty>,)*
        }

        impl $pins {
            pub(crate) fn make(b: &mut Builder<'_>) -> Result<Self, Error> {
                Ok(Self { $($name: b.item($pin, $doc, $first)?,)* })
            }

            /// Realtime.
            pub(crate) fn set(&self, values: &$record) {
                $(self.$name.set(values.$name);)*
            }
        }
    };
}

shown! {
    Results, ResultPins:
    connected: bool = false, "robot.connected", "TRUE while the controller is connected.";
    ready: bool = false, "robot.ready", "TRUE while the controller waits for a run; the part zero is known.";
    running: bool = false, "robot.running", "TRUE while lines are executed.";
    paused: bool = false, "robot.paused", "TRUE while a run is paused and the robot stands.";
    busy: bool = false, "robot.busy", "TRUE while the robot may move: from the begin of a connection until it is ready, and from the begin of a run to its end, also while it is paused; remote.job is linked to it.";
    connecting: bool = false, "robot.connecting", "TRUE from the begin of a connection until the robot has retracted and is ready.";
    ended: bool = false, "robot.ended", "TRUE after the last line of a run, until the next connection.";
    stopped: bool = false, "robot.stopped", "TRUE after a run or a connection has ended otherwise; error has the reason.";
    error: i32 = 0, "robot.error", "Reason why a run or a connection has ended, 0 without one.";
    line: i32 = 0, "robot.line", "Number of the first line to the robot that is not known to be executed, from 0.";
    lines: i32 = 0, "robot.lines", "Number of lines to the robot in the loaded program.";
    program_line: i32 = 0, "robot.program-line", "Line of the G-code program that the line to the robot comes from, from 1.";
    x: f64 = 0.0, "robot.x", "X of the last point, in the part's coordinates, in mm.";
    y: f64 = 0.0, "robot.y", "Y of the last point, in the part's coordinates, in mm.";
    z: f64 = 0.0, "robot.z", "Z of the last point, in the part's coordinates, in mm.";
    zero_x: f64 = 0.0, "robot.zero-x", "X of the part zero, in the robot's coordinates, as the controller says it, in mm.";
    zero_y: f64 = 0.0, "robot.zero-y", "Y of the part zero, in the robot's coordinates, as the controller says it, in mm.";
    zero_z: f64 = 0.0, "robot.zero-z", "Z of the part zero, in the robot's coordinates, as the controller says it, in mm.";
    speed: f64 = 0.0, "robot.speed", "Cutting speed that the controller has, 0 before the first, in mm/s.";
    joint_0: f64 = 0.0, "robot.joint.0", "Joint 1 at the last point, in degrees.";
    joint_1: f64 = 0.0, "robot.joint.1", "Joint 2 at the last point, in degrees.";
    joint_2: f64 = 0.0, "robot.joint.2", "Joint 3 at the last point, in degrees.";
    joint_3: f64 = 0.0, "robot.joint.3", "Joint 4 at the last point, in degrees.";
    joint_4: f64 = 0.0, "robot.joint.4", "Joint 5 at the last point, in degrees.";
    joint_5: f64 = 0.0, "robot.joint.5", "Joint 6 at the last point, in degrees.";
}

shown! {
    SimResults, SimResultPins:
    x: f64 = 0.0, "robot.sim.x", "X of the simulated tool now, in the part's coordinates, in mm.";
    y: f64 = 0.0, "robot.sim.y", "Y of the simulated tool now, in the part's coordinates, in mm.";
    z: f64 = 0.0, "robot.sim.z", "Z of the simulated tool now, in the part's coordinates, in mm.";
    moving: bool = false, "robot.sim.moving", "TRUE while the simulated tool moves.";
    moves: i32 = 0, "robot.sim.moves", "Number of moves that the simulated robot has executed to their end.";
}

/// Faults and place of the simulated robot.
#[derive(Clone, Copy, Debug, Default, Plain)]
pub(crate) struct SimInputs {
    /// Share of answers that are lost.
    pub(crate) lost: f64,
    /// Share of answers that come twice.
    pub(crate) doubled: f64,
    /// Longest delay of an answer, in seconds.
    pub(crate) delay: f64,
    /// The link is down.
    pub(crate) cut: bool,
    /// Place of the tool when it is connected, in robot coordinates.
    pub(crate) zero: [f64; 3],
}

/// Pins of the simulated controller.
#[derive(Debug, Touch)]
pub(crate) struct SimPins {
    lost: In<f64>,
    doubled: In<f64>,
    delay: In<f64>,
    cut: In<bool>,
    zero_x: In<f64>,
    zero_y: In<f64>,
    zero_z: In<f64>,
    pub(crate) shown: SimResultPins,
}

impl SimPins {
    pub(crate) fn make(b: &mut Builder<'_>) -> Result<Self, Error> {
        let taught = |axis| {
            format!(
                "{axis} of the place to which a person moves the tool before it is connected, in the robot's coordinates, in mm."
            )
        };
        Ok(Self {
            lost: b.item("robot.sim.lost", "Share of answers that are lost, 0 to 1.", 0.0)?,
            doubled: b.item(
                "robot.sim.doubled",
                "Share of answers that come twice, 0 to 1.",
                0.0,
            )?,
            delay: b.item("robot.sim.delay", "Longest delay of an answer, in seconds.", 0.0)?,
            cut: b.item(
                "robot.sim.cut",
                "TRUE: the link is down, and a connection is lost.",
                false,
            )?,
            zero_x: b.item("robot.sim.zero-x", &taught("X"), -400.0)?,
            zero_y: b.item("robot.sim.zero-y", &taught("Y"), 0.0)?,
            zero_z: b.item("robot.sim.zero-z", &taught("Z"), -30.0)?,
            shown: SimResultPins::make(b)?,
        })
    }

    /// Realtime. Returns what they say.
    pub(crate) fn inputs(&self) -> SimInputs {
        SimInputs {
            lost: self.lost.get(),
            doubled: self.doubled.get(),
            delay: self.delay.get(),
            cut: self.cut.get(),
            zero: [self.zero_x.get(), self.zero_y.get(), self.zero_z.get()],
        }
    }
}

/// Pins that a machine sets.
#[derive(Debug, Touch)]
pub(crate) struct InputPins {
    pub(crate) enable: In<bool>,
    pub(crate) hold: In<bool>,
    pub(crate) run: In<bool>,
    pub(crate) pause: In<bool>,
    pub(crate) resume: In<bool>,
    pub(crate) stop: In<bool>,
}

impl InputPins {
    pub(crate) fn make(b: &mut Builder<'_>) -> Result<Self, Error> {
        let enable = Decl::new(
            "robot.enable",
            "E-stop chain: FALSE stops the robot at once and ends the connection; nothing resumes when it is TRUE again.",
        );
        Ok(Self {
            enable: b.declare(enable.safety(), false)?,
            hold: b.item("robot.hold", "While TRUE, nothing is sent after the line under way; remote.hold is linked to it.", false)?,
            run: b.item("robot.run", "A rising edge runs the loaded program from its begin.", false)?,
            pause: b.item("robot.pause", "A rising edge pauses the run behind the move under way.", false)?,
            resume: b.item("robot.resume", "A rising edge resumes a paused run.", false)?,
            stop: b.item("robot.stop", "A rising edge stops the move under way at once, and ends the connection.", false)?,
        })
    }
}
