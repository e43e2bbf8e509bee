//! The control side: commands that move along a path, and commands for the path in progress.

use crate::{
    commands::call::Call,
    commands::command::{
        Arc, Follows, Move, Output, PathMode, Probe, Request, Run, Speed, Sync as SpindleSync,
    },
    commands::interface::{CommandInterface, EPOCH, Row, within},
    commands::numbers::{above, factor, number},
    pins::LETTERS,
};
use hal_component::{Arg, Error, abi::ArgSpec};

const INDEX: ArgSpec = Arg::int("index", "Number of the output, from 0.").required();
const SYNC: ArgSpec =
    Arg::bit("sync", "TRUE: when the moves that wait have ended, without a stop; FALSE: at once.")
        .or("FALSE");
const MODE: ArgSpec = Arg::text(
    "mode",
    "Path control at the end: stop (rests there), exact (within 0.002 mm of the path, as G61) or \
     blend (within tolerance of the path, as G64).",
)
.or("stop");
const TOLERANCE: ArgSpec = Arg::float(
    "tolerance",
    "Distance from the path in mode blend, in units, 0 or more; half of each move if missing.",
);
const CAM: ArgSpec = Arg::float(
    "cam-tolerance",
    "Distance from the path within which short lines in mode blend are joined, in units, as Q of G64; the larger of it \
     and tolerance holds.",
);
const LINE: ArgSpec = Arg::int("line", "Line of the program, for messages and status.").or("0");
const RAPID: ArgSpec =
    Arg::bit("rapid", "TRUE: as fast as the limits allow, without velocity or time.").or("FALSE");
const TIME: ArgSpec = Arg::float("time", "Time for the whole move in s, above 0, as G93.");
const VELOCITY: ArgSpec =
    Arg::float("velocity", "Velocity in units/s, above 0; default-velocity if missing.");
const SPINDLE: ArgSpec =
    Arg::int("spindle", "Number of the spindle that pitch or per-turn belongs to, from 0.").or("0");
const PER_TURN: ArgSpec = Arg::float(
    "per-turn",
    "Velocity in units per turn of the spindle, by its speed-in, above 0, as G95.",
);
const ACCELERATION: ArgSpec =
    Arg::float("acceleration", "Acceleration in units/s², above 0; as allowed if missing.");
const X: ArgSpec = Arg::float("x", "Position of x in units.");
const Y: ArgSpec = Arg::float("y", "Position of y in units.");
const Z: ArgSpec = Arg::float("z", "Position of z in units.");
const A: ArgSpec = Arg::float("a", "Position of a in degrees.");
const B: ArgSpec = Arg::float("b", "Position of b in degrees.");
const C: ArgSpec = Arg::float("c", "Position of c in degrees.");
const U: ArgSpec = Arg::float("u", "Position of u in units.");
const V: ArgSpec = Arg::float("v", "Position of v in units.");
const W: ArgSpec = Arg::float("w", "Position of w in units.");

/// Arguments of a command: a value for each axis, and more.
macro_rules! with_axes {
    ($($more:expr),* $(,)?) => { &[&X, &Y, &Z, &A, &B, &C, &U, &V, &W, $($more,)* &EPOCH] };
}

/// Commands of the path.
pub(super) const PATH_ROWS: &[Row] = &[
    Row {
        name: "motion.move",
        doc: "\
Moves in a straight line to a position of the axes, after the moves that wait already.

Letters that are not given stay. Velocity and acceleration hold along the line (of x y z; without
these of u v w; without these of a b c), less where a joint, an axis or the machine allows less. It
waits while a spindle that is on has no at-speed. A move beyond a limit is refused before it begins,
and so are the moves that wait behind it.

With pitch= the move follows the turns of a spindle from its index on, as G33: overrides do not count,
and a hold takes effect after it and the move behind it, the retract, if that move waits already.
Several such moves in a row are one thread. A pitch that is too fast for the axes, and a thread that is no longer than its
lead-in and run-out, are refused before they move, and so is a feed per turn that is too fast.",
        args: with_axes![
            &SPINDLE,
            &Arg::float("pitch", "Units in x y z per turn of the spindle, above 0, as G33."),
            &PER_TURN,
            &VELOCITY,
            &ACCELERATION,
            &RAPID,
            &TIME,
            &MODE,
            &TOLERANCE,
            &CAM,
            &LINE,
        ],
        read: |interface, call| Ok(Request::Move(move_to(interface, call, None)?)),
    },
    Row {
        name: "motion.tap",
        doc: "\
Taps a thread in a straight line with the turns of a spindle, and comes back, as G33.1.

The tap begins at the index of the spindle. At the depth the spindle is reversed, and the axes follow it
through the overrun and out again; then it turns as before, and the axes go back to the start. A hold
takes effect after it. motion.abort reverses the spindle at once, follows it out and stops. A pitch that is too fast for the
axes, and a tap that is no longer than its lead-in, are refused before they move.",
        args: with_axes![
            &SPINDLE,
            &Arg::float("pitch", "Units per turn of the spindle, above 0.").required(),
            &Arg::float("return", "Factor for the spindle's speed on the way out, above 0.")
                .or("1"),
            &LINE,
        ],
        read: |interface, call| {
            let back = above(call, "return")?.unwrap_or(1.0);
            let line = move_to(interface, call, None)?;
            let sync = line.sync.ok_or_else(|| Error::new("pitch= is missing"))?;
            let sync = SpindleSync { follows: Follows::Tap { back }, ..sync };
            Ok(Request::Move(Move { sync: Some(sync), ..line }))
        },
    },
    Row {
        name: "motion.arc",
        doc: "\
Moves along an arc, a helix or a full circle in x y z, after the moves that wait already.

The motion is counter-clockwise around the normal, as seen from its tip; clockwise=TRUE turns it
round. Without a normal the arc is in the plane of x and y. An arc that ends where it starts is a
full circle. All other axes move evenly along it.",
        args: with_axes![
            &Arg::float(
                "center-x",
                "Position of the centre in x, in units; if missing, of the start.",
            ),
            &Arg::float(
                "center-y",
                "Position of the centre in y, in units; if missing, of the start.",
            ),
            &Arg::float(
                "center-z",
                "Position of the centre in z, in units; if missing, of the start.",
            ),
            &Arg::float("normal-x", "Direction of the axis in x.").or("0"),
            &Arg::float("normal-y", "Direction of the axis in y.").or("0"),
            &Arg::float("normal-z", "Direction of the axis in z; 1 if no direction is given.")
                .or("0"),
            &Arg::bit("clockwise", "TRUE turns the other way.").or("FALSE"),
            &Arg::int("turns", "Additional full turns, 0 to 1000000.").or("0"),
            &SPINDLE,
            &PER_TURN,
            &VELOCITY,
            &ACCELERATION,
            &TIME,
            &MODE,
            &TOLERANCE,
            &CAM,
            &LINE,
        ],
        read: |interface, call| {
            let arc = arc(call)?;
            Ok(Request::Move(move_to(interface, call, Some(arc))?))
        },
    },
    Row {
        name: "motion.probe",
        doc: "\
Moves in a straight line until the probe changes, as G38.2 to G38.5 do.

The motion brakes along the line, and the path ends there. The snapshot motion.status has the pose of
that cycle, as measured and as commanded. The move fails if the probe is in that state already when
it begins.",
        args: with_axes![
            &VELOCITY,
            &Arg::bit("away", "TRUE: until motion.probe-input is FALSE; FALSE: until it is TRUE.")
                .or("FALSE"),
            &Arg::bit("optional", "TRUE: a move that ends without a change does not fail.")
                .or("FALSE"),
            &LINE,
        ],
        read: |interface, call| {
            let probe = Probe {
                away: call.bit("away").unwrap_or(false),
                must: !call.bit("optional").unwrap_or(false),
            };
            let line = move_to(interface, call, None)?;
            Ok(Request::Move(Move { probe: Some(probe), ..line }))
        },
    },
    Row {
        name: "motion.pause",
        doc: "\
Brakes along the path and holds there until motion.resume; the moves that wait, and those that still come, stay.

It takes effect in the next cycle, before all commands that wait. Jogs brake and homing ends. A jog, a home or a resume
that was given before it begins nothing. Meanwhile axes can be jogged: motion.resume first returns them to where they left
the path.",
        args: &[],
        read: |_, _| Ok(Request::Run(Run::Pause)),
    },
    Row {
        name: "motion.resume",
        doc: "\
Goes on along the path after motion.pause, motion.step or the stop of a spindle that the path needs.

Such a spindle turns again first, and the path waits for its at-speed. It is refused while `spindle.N.inhibit` is TRUE.",
        args: &[&EPOCH],
        read: |_, _| Ok(Request::Run(Run::Resume)),
    },
    Row {
        name: "motion.step",
        doc: "Goes on to the next move of a path, and pauses as it begins.",
        args: &[&EPOCH],
        read: |_, _| Ok(Request::Run(Run::Step)),
    },
    Row {
        name: "motion.reverse",
        doc: "\
Brakes, and goes back along the path, as far as it is kept or to its beginning.

Outputs and spindles stay as they are.",
        args: &[&EPOCH],
        read: |_, _| Ok(Request::Run(Run::Reverse)),
    },
    Row {
        name: "motion.forward",
        doc: "Goes forward along the path again.",
        args: &[&EPOCH],
        read: |_, _| Ok(Request::Run(Run::Forward)),
    },
    Row {
        name: "motion.tool-offset",
        doc: "\
Shows the tool offset of a program on the pins motion.tooloffset.*, when the moves that wait have ended.

Positions of moves contain it already: it moves nothing. Letters that are not given are 0.",
        args: with_axes![],
        read: |_, call| {
            let mut offset = [0.0; 9];
            for (place, letter) in offset.iter_mut().zip(LETTERS) {
                *place = number(call, letter.encode_utf8(&mut [0; 4]))?.unwrap_or(0.0);
            }
            Ok(Request::PathOutput(Output::ToolOffset(offset)))
        },
    },
    Row {
        name: "motion.digital-out",
        doc: "Sets a pin motion.digital-out-NN, as M62 to M65 do.",
        args: &[&INDEX, &Arg::bit("value", "TRUE or FALSE.").required(), &SYNC, &EPOCH],
        read: |interface, call| {
            let (n, value) = (output(call, interface.digital_out)?, call.bit("value"));
            Ok(put(call, Output::Digital(n, value.unwrap_or(false))))
        },
    },
    Row {
        name: "motion.analog-out",
        doc: "Sets a pin motion.analog-out-NN, as M67 and M68 do.",
        args: &[
            &INDEX,
            &Arg::float("value", "The value, in the output's unit; finite.").required(),
            &SYNC,
            &EPOCH,
        ],
        read: |interface, call| {
            let (n, value) = (output(call, interface.analog_out)?, number(call, "value")?);
            Ok(put(call, Output::Analog(n, value.unwrap_or(0.0))))
        },
    },
];

fn output(call: &Call<'_>, count: usize) -> Result<usize, Error> {
    within(call, "index", &format!("are {count} outputs"), count)
}

fn put(call: &Call<'_>, output: Output) -> Request {
    if call.bit("sync").unwrap_or(false) {
        Request::PathOutput(output)
    } else {
        Request::Output(output)
    }
}

fn move_to(interface: &CommandInterface, call: &Call<'_>, arc: Option<Arc>) -> Result<Move, Error> {
    let mut to = [f64::NAN; 9];
    for (n, (place, letter)) in to.iter_mut().zip(LETTERS).enumerate() {
        if let Some(value) = number(call, letter.encode_utf8(&mut [0; 4]))? {
            let joint = interface.has_joint(n);
            // An axis without a joint stays at 0: programs of such a machine name its place in each move.
            if joint.is_err() && value == 0.0 {
                continue;
            }
            joint?;
            *place = value;
        }
    }
    if arc.is_none() && to.iter().all(|p| p.is_nan()) {
        return Err(Error::new("a move needs at least one of x= y= z= a= b= c= u= v= w="));
    }
    let line = call.int("line").unwrap_or(0);
    let line = u32::try_from(line)
        .map_err(|_| Error::new(format!("line is {line}, must be 0 to 4294967295")))?;
    Ok(Move {
        to,
        arc,
        probe: None,
        speed: speed(call)?,
        acceleration: above(call, "acceleration")?,
        mode: mode(call)?,
        line,
        sync: sync(interface, call)?,
    })
}

fn sync(interface: &CommandInterface, call: &Call<'_>) -> Result<Option<SpindleSync>, Error> {
    let (pitch, follows) = match (above(call, "pitch")?, above(call, "per-turn")?) {
        (None, None) => return Ok(None),
        (Some(pitch), None) => (pitch, Follows::Place),
        (None, Some(feed)) => (feed, Follows::Speed),
        (Some(_), Some(_)) => return Err(Error::new("pitch= and per-turn= exclude each other")),
    };
    if speed(call)? != Speed::Default {
        return Err(Error::new("pitch= and per-turn= exclude velocity=, time= and rapid="));
    }
    let spindle = interface.number_of_spindle(call)?;
    // Only a program has spindles at constant surface speed.
    let is_at_surface = call.bit("surface").unwrap_or(false);
    Ok(Some(SpindleSync { spindle, pitch, follows, is_at_surface }))
}

fn speed(call: &Call<'_>) -> Result<Speed, Error> {
    let rapid = call.bit("rapid").unwrap_or(false);
    match (above(call, "velocity")?, above(call, "time")?, rapid) {
        (None, None, false) => Ok(Speed::Default),
        (None, None, true) => Ok(Speed::Rapid),
        (Some(v), None, false) => Ok(Speed::Feed(v)),
        (None, Some(t), false) => Ok(Speed::Time(t)),
        _ => Err(Error::new("velocity=, time= and rapid= exclude each other")),
    }
}

fn mode(call: &Call<'_>) -> Result<PathMode, Error> {
    let tolerance = number(call, "tolerance")?;
    let text = call.text("mode").unwrap_or_default();
    match (text.as_str(), tolerance) {
        // Commands without the argument stop.
        ("stop" | "", None) => Ok(PathMode::ExactStop),
        ("exact", None) => Ok(PathMode::Exact),
        ("blend", Some(p)) if p < 0.0 => {
            Err(Error::new(format!("tolerance is {p}, must be 0 or more")))
        }
        ("blend", None) => Ok(PathMode::Blend(f64::INFINITY)),
        ("blend", Some(p)) => {
            let cam = factor(call, "cam-tolerance")?.unwrap_or(0.0);
            Ok(PathMode::Blend(p.max(cam)))
        }
        ("stop" | "exact", Some(_)) => {
            Err(Error::new(format!("tolerance= belongs to mode=blend, not to mode={text}")))
        }
        (other, _) => Err(Error::new(format!("mode '{other}' is none of stop, exact and blend"))),
    }
}

fn arc(call: &Call<'_>) -> Result<Arc, Error> {
    let center = vector(call, ["center-x", "center-y", "center-z"], f64::NAN)?;
    let mut normal = vector(call, ["normal-x", "normal-y", "normal-z"], 0.0)?;
    if normal == [0.0; 3] {
        normal = [0.0, 0.0, 1.0];
    }
    if call.bit("clockwise").unwrap_or(false) {
        normal = normal.map(|n| -n);
    }
    let turns = call.int("turns").unwrap_or(0);
    let turns = u32::try_from(turns)
        .ok()
        .filter(|n| *n <= 1_000_000)
        .ok_or_else(|| Error::new(format!("turns is {turns}, must be 0 to 1000000")))?;
    Ok(Arc { center, normal, turns })
}

/// Returns three arguments; `missing` stands for one that is not given.
fn vector(call: &Call<'_>, names: [&str; 3], missing: f64) -> Result<[f64; 3], Error> {
    let mut vector = [missing; 3];
    for (place, name) in vector.iter_mut().zip(names) {
        *place = number(call, name)?.unwrap_or(missing);
    }
    Ok(vector)
}
