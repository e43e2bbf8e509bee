//! The plugin `robot`: programs on an arm behind its own controller.
//!
//! | module | subject |
//! |---|---|
//! | `pins` | its pins, and what passes between function and worker |
//! | `gate` | Realtime: the function, which reads the pins and shows what the worker reports |
//! | `cause` | reasons why a connection or a run has ended |
//! | `orders` | commands `robot.*` |
//! | `session` | connection, program and run |
//! | `worker` | the worker: it keeps the session, and ends it where the machine's state demands that |
//! | `report`, `shown` | the state as lines and as JSON; what a session shows |

mod cause;
mod gate;
mod orders;
mod pins;
mod report;
mod session;
mod shown;
mod worker;

use crate::{Volume, check_address, volume::parse_volume};
use gate::{Gate, Shared};
use hal_component::{
    Arg, Builder, Component, Error, ParamRo,
    abi::{ArgSpec, component_flags},
};
use orders::Inbox;
use report::Report;
use std::sync::{Arc, Mutex};
use worker::{Halt, Settings, Worker};

/// Period of the worker, in nanoseconds.
const PERIOD_NS: i64 = 2_000_000;

/// `loadrt robot`.
#[derive(Debug)]
pub struct Robot;

impl Component for Robot {
    const NAME: &'static str = "robot";
    const DOC: &'static str = "\
Robot arm behind its own controller: runs G-code programs over the controller's line protocol, one line at a time.

`robot.connect` connects to the controller at `to`. The robot then takes the place of its tool as the part zero, which a person
has taught by moving the tool there, retracts by 50 mm, and says the part zero: `zero-x`, `zero-y`, `zero-z`, in the robot's
coordinates. `robot.load file=PATH` converts a program and checks every point, those on arcs included, against the work volume
and the joints; a program with a point outside is refused with file, line and point, and nothing moves. `robot.run` runs it; with
`from=N` from a line that had no answer, as `line` and the message of a stopped run name it: the tool then goes above the point
before that line first, and down to it. A run is refused if the part zero, `tool-length` or `cutting-speed` has changed since the load.

Each connection takes the place of the tool at that time as the part zero. Before `robot.connect` a person moves the tool back to it,
also after a stop, a lost link and a run: else the robot cuts beside the part. With `from=N` the part zero must be within 0.5 mm of that
of the load, and the rest of the part is displaced by as much. The simulated tool is at `sim.zero-x` to `-z` at each connection.

`robot.pause` lets the move under way end and sends nothing more; `paused` is TRUE when the robot stands. `robot.stop` ends the move
under way at once, and the connection. The connection also ends with the last line, so that `robot.connect` begins each run.

`enable` belongs to the e-stop chain: FALSE, for however short a time, sends EXIT, which stops the robot at once, and ends the
connection. Nothing connects while it is FALSE, because a robot moves when it is connected, and nothing resumes when it is TRUE
again. An order that was given before a stop and comes behind it is refused: the record `robot.stops` counts the stops, and a program
gives the number that it saw as `epoch`. `hold` TRUE has the effect of a pause for as long as it lasts; `remote.hold` is linked to it.

Values of `error`: 0 none, 1 stopped by a command, 2 enable is FALSE, 3 the connection was lost, 4 the controller does not answer,
5 it has refused a line, 6 another client is connected to it, 7 it cannot be reached, 8 the worker does not work, 9 the function
`robot` does not run, 10 the instance has stopped. The robot then stands, and `robot.status` has the details. With 8 alone it may
move to the end of the line under way: while `busy` is TRUE, nobody can stop it here; the connection ends when the worker works again.

`x`, `y` and `z` are the point of the last line that was executed, in the part's coordinates, and `joint.N` the joints for it: the
protocol does not say where the robot is in between. Positions are in mm, angles in degrees, speeds in mm/s.

On the virtual clock, and with `--simulate`, the controller is simulated: pins `sim.*` are its faults and its true state.

# Example

```hal
loadrt threads name1=servo period1=1000000
loadrt robot
addf robot servo
start
setp robot.enable TRUE
run 10ms
robot.connect --wait
getp robot.zero-x # -> -400
getp robot.ready # -> TRUE
robot.disconnect --wait
getp robot.connected # -> FALSE
```";
    const FLAGS: u32 = component_flags::ONCE;
    const ARGS: &'static [&'static ArgSpec] = &[
        &Arg::text("to", "Address and port of the controller.").or("127.0.0.1:55000"),
        &Arg::float("timeout", "Time for the answer to a line behind the end of its move.")
            .within(0.1, 3600.0)
            .unit("s")
            .or("20"),
        &Arg::float("connect_timeout", "Longest time for a connection.")
            .within(0.1, 60.0)
            .unit("s")
            .or("10"),
        &Arg::text(
            "volume",
            "Work volume in the robot's coordinates: least X,Y,Z, then greatest, in mm.",
        )
        .or("-550,-250,-100,-250,250,40"),
    ];

    fn create(b: &mut Builder<'_>) -> Result<(), Error> {
        let text = b.arg_text("volume").unwrap_or_default();
        let (min, max) =
            parse_volume(&text).map_err(|e| Error::new(format!("volume={text}: {e}")))?;
        let volume = Volume { min, max, ..Volume::default() };
        let to = b.arg_text("to").unwrap_or_default();
        check_address(&to).map_err(|e| Error::new(format!("to={to}: {e}")))?;
        let shared = Arc::new(Shared::default());
        let inbox = Arc::new(Mutex::new(Inbox::default()));
        let report = Arc::new(Mutex::new(Report::default()));
        let (gate, ends) = Gate::make(b, shared.clone())?;
        b.function("robot", "Reads the pins, and shows what the worker reports.", gate)?;
        orders::open(b, &inbox, &report, &shared)?;
        dimensions(b, &volume)?;
        let settings = Settings {
            to,
            timeout: b.arg_float("timeout").unwrap_or(20.0),
            connect: b.arg_float("connect_timeout").unwrap_or(10.0),
            volume,
            is_simulated: b.is_simulated(),
        };
        let halt = Arc::new(Halt::default());
        let stop = halt.clone();
        b.on_stop(move || stop.stop())?;
        let worker = Worker::make(b, settings, ends, shared, inbox, report, halt)?;
        b.worker(
            "robot",
            "Speaks with the controller, and converts programs.",
            PERIOD_NS,
            1,
            worker,
        )
    }
}

/// Declares the dimensions of the arm, by which the panel draws it.
fn dimensions(b: &mut Builder<'_>, volume: &Volume) -> Result<(), Error> {
    let arm = &volume.arm;
    let lengths = [
        ("A1", arm.a1, "Distance between the axes of joints 1 and 2, in mm."),
        ("A2", arm.a2, "Length of the upper arm, in mm."),
        ("A3", arm.a3, "Distance from the axis of joint 3 to that of the forearm, in mm."),
        ("D1", arm.d1, "Height of the axis of joint 2, in mm."),
        ("D4", arm.d4, "Length of the forearm, in mm."),
        ("D6", arm.d6, "Distance from the wrist to the flange, in mm."),
    ];
    for (name, length, doc) in lengths {
        let _: ParamRo<f64> = b.item(&format!("robot.{name}"), doc, length)?;
    }
    for (n, (offset, sign)) in arm.offset.iter().zip(&arm.sign).enumerate() {
        let doc = "Angle of the model at which the joint is at 0, in degrees.";
        let _: ParamRo<f64> = b.item(&format!("robot.offset-{n}"), doc, *offset)?;
        let doc = "Direction of the joint: 1 or -1.";
        let _: ParamRo<f64> = b.item(&format!("robot.sign-{n}"), doc, *sign)?;
    }
    Ok(())
}

#[cfg(test)]
mod tests;
