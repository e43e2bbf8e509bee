//! The control side: commands for users.

use crate::{
    commands::arguments,
    commands::call::{Call, setting},
    commands::command::{
        Command, FeedChange, Jog, JogDistance, JogTarget, Joints, Mode, Request, SpindleChange,
    },
    commands::configure::{ConfigCache, Target},
    commands::numbers::{factor, number, share},
    commands::path_rows::PATH_ROWS,
    guards::stop_line::{Stop, StopLine},
    pins::LETTERS,
};
use hal_component::{
    Arg, Builder, Error, KinematicsRef, MotionCommand, MotionSource, Sender, StopEpoch,
    TicketHandle, abi::ArgSpec, motion_kind,
};
use std::sync::{Arc, Mutex, PoisonError};

/// Sender of commands to the realtime side.
#[derive(Clone, Debug)]
pub(crate) struct CommandInterface {
    pub(crate) to: Sender<Command>,
    pub(crate) joints: usize,
    pub(crate) spindles: usize,
    pub(crate) digital_out: usize,
    pub(crate) analog_out: usize,
    pub(crate) kinematics: KinematicsRef,
    pub(crate) cache: Arc<Mutex<ConfigCache>>,
    pub(crate) line: Arc<StopLine>,
}

/// Parser of a command's arguments.
pub(super) type Read = fn(&CommandInterface, &Call<'_>) -> Result<Request, Error>;

/// A command that takes a ticket.
pub(super) struct Row {
    pub(super) name: &'static str,
    pub(super) doc: &'static str,
    pub(super) args: &'static [&'static ArgSpec],
    pub(super) read: Read,
}

const JOINT: ArgSpec = Arg::int("joint", "Number of the joint, from 0.");
const JOINTS: ArgSpec = Arg::text("joint", "Number of the joint, from 0, or all.").required();
const AXIS: ArgSpec = Arg::text("axis", "Letter of the axis: x y z a b c u v w.");
const SPINDLE: ArgSpec = Arg::int("spindle", "Number of the spindle, from 0.").or("0");
pub(super) const EPOCH: ArgSpec = Arg::int(
    "epoch",
    "Stop epoch in which the order was given, as motion.status has it: after a stop since then it is refused. -1 is now.",
)
.or("-1");

const ROWS: &[Row] = &[
    Row {
        name: "motion.enable",
        doc: "Switches the machine on: forgets joint errors and sets amp-enable-out.",
        args: &[&EPOCH],
        read: |_, _| Ok(Request::Enable),
    },
    Row {
        name: "motion.disable",
        doc: "\
Switches the machine off: amplifiers, moves and spindles.

It takes effect in the next cycle, before all commands that wait. Orders that were given before it begin nothing.",
        args: &[],
        read: |_, _| Ok(Request::Disable),
    },
    Row {
        name: "motion.mode",
        doc: "\
Changes the mode, when the machine stands still.

Jogs and moves change it by themselves.",
        args: &[&Arg::text(
            "mode",
            "free (jogs move joints), teleop (jogs move axes) or coord (moves along a path).",
        )
        .required(), &EPOCH],
        read: |_, call| match call.text("mode").unwrap_or_default().as_str() {
            "free" => Ok(Request::Mode(Mode::Free)),
            "teleop" => Ok(Request::Mode(Mode::Teleop)),
            "coord" => Ok(Request::Mode(Mode::Coord)),
            other => Err(Error::new(format!("mode '{other}' is none of free, teleop and coord"))),
        },
    },
    Row {
        name: "motion.home",
        doc: "\
Homes joints, in the order of their home-sequence.

A joint with home-search-vel goes to its home switch, and with home-latch-vel to its edge: onto it when
both have one sign, after it has gone back, and off it otherwise. With home-use-index it goes on to the
encoder's index. Without a switch it is home where it stands. That place becomes home-offset, and the
joint then goes to home, and its limits hold. What ends it: a limit switch, unless home-ignore-limits,
and twice the way between the limits without a switch or an index.",
        args: &[&JOINTS, &EPOCH],
        read: |interface, call| Ok(Request::Home(interface.set(call)?)),
    },
    Row {
        name: "motion.unhome",
        doc: "Forgets where joints are: soft limits no longer hold.",
        args: &[&JOINTS],
        read: |interface, call| Ok(Request::Unhome(interface.set(call)?)),
    },
    Row {
        name: "motion.jog",
        doc: "\
Moves one joint, or one axis along the kinematics.

Without distance= and position= it goes in the direction of its velocity until it is stopped or at
a limit. A target beyond a limit ends at the limit.",
        args: &[
            &JOINT,
            &AXIS,
            &Arg::float("velocity", "Velocity in units/s; its sign is the direction.").required(),
            &Arg::float("distance", "How far, in units: added to where it goes already."),
            &Arg::float("position", "Where to, in units."),
            &EPOCH,
        ],
        read: CommandInterface::jog,
    },
    Row {
        name: "motion.jog-stop",
        doc: "Brakes the jog of a joint or axis; without either, all.",
        args: &[&JOINT, &AXIS],
        read: |interface, call| Ok(Request::JogStop(interface.jog_target(call)?)),
    },
    Row {
        name: "motion.abort",
        doc: "\
Brakes everything, forgets the moves that wait, and stops the spindles.

It takes effect in the next cycle, before all commands that wait. Orders that were given before it begin nothing.",
        args: &[],
        read: |_, _| Ok(Request::Abort),
    },
    Row {
        name: "motion.spindle",
        doc: "\
Turns or stops a spindle.

A stop while a path that needs the spindle is in progress pauses the path: motion.resume turns the spindle again. So does
`spindle.N.inhibit`.",
        args: &[
            &SPINDLE,
            &Arg::float("speed", "Turns per minute, negative in reverse; 0 stops and brakes."),
            &Arg::float("override", "Factor for the speed, 0 or more; at first 1."),
            &Arg::bit("brake", "Closes or opens the brake."),
            &EPOCH,
        ],
        read: CommandInterface::spindle,
    },
    Row {
        name: "motion.spindle-orient",
        doc: "Stops a spindle and turns it to an angle, with orient and is-oriented.",
        args: &[
            &SPINDLE,
            &Arg::float("angle", "Angle in degrees, 0 to 360.").required(),
            &Arg::int("mode", "Direction: 0 the shorter, 1 clockwise, 2 counterclockwise.").or("0"),
            &EPOCH,
        ],
        read: |interface, call| {
            let angle = number(call, "angle")?.unwrap_or(0.0);
            if !(0.0..=360.0).contains(&angle) {
                return Err(Error::new(format!("angle is {angle}, must be 0 to 360")));
            }
            let mode = i32::try_from(within(call, "mode", "are 0, 1 and 2", 3)?).unwrap_or(0);
            Ok(Request::Orient(interface.number_of_spindle(call)?, angle, mode))
        },
    },
    Row {
        name: "motion.feed",
        doc: "\
Changes how feeds and rapid moves of coordinated motion are scaled.

Adaptive feed and feed hold count for both.",
        args: &[
            &Arg::float("override", "Factor for feeds, 0 or more; at first 1."),
            &Arg::float("rapid-override", "Factor for rapid moves, 0 to 1; at first 1."),
            &Arg::bit("adaptive", "Whether motion.adaptive-feed counts; at first it does not."),
            &Arg::bit("hold", "Whether motion.feed-hold counts; at first it does."),
        ],
        read: |_, call| {
            Ok(Request::Feed(FeedChange {
                scale: factor(call, "override")?,
                rapid: share(call, "rapid-override")?,
                adaptive: call.bit("adaptive"),
                hold: call.bit("hold"),
            }))
        },
    },
    Row {
        name: "motion.override-limits",
        doc: "\
Lets a joint be jogged off a limit switch.

Closed limit switches do not switch the machine off until the next jog has ended.",
        args: &[&EPOCH],
        read: |_, _| Ok(Request::OverrideLimits),
    },
];

impl CommandInterface {
    /// Declares all commands.
    pub(crate) fn open(self, b: &mut Builder<'_>) -> Result<(), Error> {
        for row in ROWS.iter().chain(PATH_ROWS) {
            let (interface, read) = (self.clone(), row.read);
            b.command(row.name, row.doc, row.args, move |call| {
                let request = read(&interface, &Call::Text(call))?;
                let given = Call::Text(call).epoch();
                interface.send(request, MotionSource::Local, given, call.ticket()?)
            })?;
        }
        b.command("motion.configure", arguments::DOC, arguments::ARGS, move |call| {
            self.configure(Call::Text(call))
        })
    }

    /// Changes settings of a joint, an axis, a spindle, or of coordinated moves.
    pub(super) fn configure(&self, call: Call<'_>) -> Result<(), Error> {
        let mut cache = self.cache.lock().unwrap_or_else(PoisonError::into_inner);
        let command = cache.read(&call, self.joints, self.spindles)?;
        self.to.send(command).map_err(|_| full())?;
        cache.keep(&command);
        Ok(())
    }

    /// Returns a setting that a record names.
    pub(super) fn setting(&self, command: &MotionCommand) -> Result<f64, Error> {
        let call = Call::of(command)?;
        let name = setting(command).unwrap_or_default();
        let target = Target::of(&call, self.joints, self.spindles)?;
        let cache = self.cache.lock().unwrap_or_else(PoisonError::into_inner);
        let value = cache.setting(target, name);
        value.ok_or_else(|| Error::new(format!("this object has no {name}")))
    }

    /// Reads a command of the service: the text command with the name of its kind has the same arguments.
    pub(super) fn request(&self, kind: u32, call: Call<'_>) -> Result<Request, Error> {
        let name = usize::try_from(kind).ok().and_then(|n| motion_kind::NAMES.get(n)).copied();
        let name = name.unwrap_or_default();
        let is_named = |row: &&Row| row.name.strip_prefix("motion.") == Some(name);
        let row = ROWS.iter().chain(PATH_ROWS).find(is_named);
        let row = row.ok_or_else(|| Error::new(format!("motmod has no command motion.{name}")))?;
        (row.read)(self, &call)
    }

    /// Sends a request to the realtime side. A stop takes effect in the next cycle, whatever waits before it; one without a
    /// `given` epoch is given now.
    pub(super) fn send(
        &self,
        request: Request,
        source: MotionSource,
        given: Option<StopEpoch>,
        ticket: TicketHandle,
    ) -> Result<(), Error> {
        let stop = Stop::of(&request);
        if let Some(stop) = stop {
            self.line.pull(stop);
        }
        let given = given.unwrap_or_else(|| self.line.epoch());
        self.to.send(Command::Request(request, source, given, ticket)).map_err(|_| {
            ticket.fail("too many commands wait");
            if stop.is_some() { full_behind_stop() } else { full() }
        })
    }

    fn set(&self, call: &Call<'_>) -> Result<Joints, Error> {
        let text = call.text("joint").unwrap_or_default();
        if text == "all" {
            return Ok(Joints::MAX);
        }
        let n = text
            .parse()
            .map_err(|_| Error::new(format!("joint '{text}' is neither a number nor all")))?;
        joint(n, self.joints).map(|n| 1 << n)
    }

    fn jog_target(&self, call: &Call<'_>) -> Result<Option<JogTarget>, Error> {
        match (call.int("joint"), call.text("axis")) {
            (Some(_), Some(_)) => Err(Error::new("joint= and axis= exclude each other")),
            (Some(n), None) => joint(n, self.joints).map(|n| Some(JogTarget::Joint(n))),
            (None, Some(text)) => {
                let n = letter(&text)?;
                self.has_joint(n)?;
                Ok(Some(JogTarget::Axis(n)))
            }
            (None, None) => Ok(None),
        }
    }

    fn jog(&self, call: &Call<'_>) -> Result<Request, Error> {
        let target =
            self.jog_target(call)?.ok_or_else(|| Error::new("joint= or axis= is missing"))?;
        let velocity = number(call, "velocity")?.unwrap_or(0.0);
        let distance = match (number(call, "distance")?, number(call, "position")?) {
            (Some(_), Some(_)) => {
                return Err(Error::new("distance= and position= exclude each other"));
            }
            (Some(d), None) => JogDistance::Incremental(d),
            (None, Some(p)) => JogDistance::Absolute(p),
            (None, None) => JogDistance::Continuous,
        };
        if velocity == 0.0 {
            return Err(Error::new("velocity is 0, a jog needs one"));
        }
        if velocity < 0.0 && distance != JogDistance::Continuous {
            return Err(Error::new(format!(
                "velocity is {velocity}, must be above 0: distance= or position= is the direction"
            )));
        }
        Ok(Request::Jog(Jog { target, velocity, distance }))
    }

    /// Refuses an axis letter that no joint follows, if the kinematics declare their letters.
    pub(super) fn has_joint(&self, n: usize) -> Result<(), Error> {
        let k = &self.kinematics;
        let says = (0..LETTERS.len()).any(|l| k.joint_of(l).is_some());
        if !says || k.joint_of(n).is_some_and(|j| j < self.joints) {
            return Ok(());
        }
        let letter = LETTERS.get(n).copied().unwrap_or(' ');
        Err(Error::new(format!("axis {letter} has no joint in these kinematics")))
    }

    pub(super) fn number_of_spindle(&self, call: &Call<'_>) -> Result<usize, Error> {
        within(call, "spindle", &format!("are {}", self.spindles), self.spindles)
    }

    fn spindle(&self, call: &Call<'_>) -> Result<Request, Error> {
        let spindle = self.number_of_spindle(call)?;
        Ok(Request::Spindle(SpindleChange {
            spindle,
            speed: number(call, "speed")?,
            scale: factor(call, "override")?,
            brake: call.bit("brake"),
        }))
    }
}

/// Returns an argument below `count`, or an error that states the number of objects.
pub(super) fn within(call: &Call<'_>, name: &str, are: &str, count: usize) -> Result<usize, Error> {
    let given = call.int(name).unwrap_or(0);
    usize::try_from(given)
        .ok()
        .filter(|n| *n < count)
        .ok_or_else(|| Error::new(format!("there is no {name} {given}, there {are}")))
}

fn full() -> Error {
    Error::new("too many commands wait: is motion-command-handler in a running thread?")
}

fn full_behind_stop() -> Error {
    Error::new("the stop is in force, but too many commands wait for motion to tell its end")
}

/// Returns a joint number, checked against the number of joints.
pub(crate) fn joint(given: i64, joints: usize) -> Result<usize, Error> {
    usize::try_from(given).ok().filter(|n| *n < joints).ok_or_else(|| {
        Error::new(format!("there is no joint {given}, they are 0 to {}", joints.saturating_sub(1)))
    })
}

/// Returns the index of an axis letter.
pub(crate) fn letter(text: &str) -> Result<usize, Error> {
    let mut chars = text.chars();
    let found = match (chars.next(), chars.next()) {
        (Some(c), None) => LETTERS.iter().position(|l| *l == c.to_ascii_lowercase()),
        _ => None,
    };
    found.ok_or_else(|| Error::new(format!("axis '{text}' is none of x y z a b c u v w")))
}
