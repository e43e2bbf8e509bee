//! The task controller: states, modes and jobs of a machine.
//!
//! | module | subject |
//! |---|---|
//! | `core` | the core, without HAL: states, modes, jobs, their steps and their end |
//! | `convert` | from canonical calls to steps in machine coordinates |
//! | `outside` | the interface of the core to everything outside |
//! | `worker`, `command_record` | the worker; orders as records of the service `motion` |
//! | `journal_file` | the file of the journal |
//! | `programs` | programs of users |
//! | `commands`, `pins`, `status`, `codes` | commands and pins `task.*`; the snapshot `task.status`; G codes in force |
#![forbid(unsafe_code)]

mod codes;
mod command_record;
mod commands;
mod convert;
mod core;
mod error;
mod journal_file;
mod outside;
mod pins;
mod programs;
mod setup;
mod status;
mod worker;

use ::core::time::Duration;
use hal_component::{
    Arg, Builder, Component, Error,
    abi::{ArgSpec, component_flags},
};
use pins::Pins;
use std::collections::BTreeMap;
use worker::{Shared, Worker};

/// Largest number of steps of a job in one step of the worker.
const ITEMS: u32 = 400;

const ARGS: &[&ArgSpec] = &[
    &Arg::text("ini", "INI file of the machine: units, axes, tool table, parameters, subroutines.")
        .or(""),
    &Arg::float("cycle_time", "Period of the worker in seconds: 0.0001 to 1.").or("0.005"),
];

/// `loadrt task`.
#[derive(Debug)]
pub struct Task;

impl Component for Task {
    const NAME: &'static str = "task";
    const DOC: &'static str = "\
The task controller: runs programs and lines of G-code.

It is loaded after `iocontrol`, `motmod` and, if there is one, `halui`, which then cannot be unloaded. A start from an INI file
loads it, with the machine's `ini=`. A machine whose INI file has no section RS274NGC keeps its parameters, its journal and the
record of its spindle in the user's state folder, and on the virtual clock nowhere. Its commands switch the machine on, home it, open a
program, run, pause, step and abort it, and execute single lines; `task.status` shows the state, as
does the snapshot of this name.

A program is read ahead of the motion, except where it depends on the machine: a probe, a tool change,
an input, a user's program. Moves join as the program says (G61, G64). Spindle, coolant, dwells,
outputs without motion and pauses wait until the moves before them have ended. A program that is wrong, as far as
the task can know without the machine, does not begin; the message has all reasons with their places. A
program ends at an error that only the machine can show, after the lines before it.

An abort, an error, an e-stop and a machine that goes off end the job: the rest of the path is gone,
spindles and coolant stop, lines of MDI that wait are forgotten, and modal state and numbered
parameters are those of the line that was in execution. Only a new command begins anything.

Motion holds the overrides. An operator changes them with a knob of `halui`, with `motion.feed`, or with
`task.feed-override` and `task.rapid-override`. The feed override scales feeds alone, and rapid moves have their own. While a
program forbids overrides (M49, M50 P0, M51 P0), motion runs at 100 %, and the task applies the change when the program
allows overrides again; M49 and M50 P0 forbid that of rapid moves too, as in LinuxCNC.

Only the task writes the tool table and the parameter file, each as a whole.

# Example

```hal
loadrt iocontrol interlock=1
loadrt trivkins coordinates=XYZ
loadrt motmod num_joints=3
loadrt task
addf motion-command-handler servo-thread
addf motion-controller servo-thread
net x joint.0.motor-pos-cmd joint.0.motor-pos-fb
net y joint.1.motor-pos-cmd joint.1.motor-pos-fb
net z joint.2.motor-pos-cmd joint.2.motor-pos-fb
net estop iocontrol.0.user-enable-out iocontrol.0.emc-enable-in
motion.configure max-velocity=100 max-acceleration=1000
motion.configure joint=0 max-velocity=100 max-acceleration=1000 min-limit=-500 max-limit=500 ferror=1 min-ferror=1
motion.configure joint=1 max-velocity=100 max-acceleration=1000 min-limit=-500 max-limit=500 ferror=1 min-ferror=1
motion.configure joint=2 max-velocity=100 max-acceleration=1000 min-limit=-500 max-limit=500 ferror=1 min-ferror=1
start
task.estop-reset --wait
task.on --wait
task.home joint=all --wait
task.mode mode=mdi --wait
task.mdi text='G0 X10 Y5' --wait
getp joint.0.motor-pos-cmd # -> 10
```";
    const FLAGS: u32 = component_flags::ONCE;
    const ARGS: &'static [&'static ArgSpec] = ARGS;

    fn create(b: &mut Builder<'_>) -> Result<(), Error> {
        create(b)
    }
}

fn create(b: &mut Builder<'_>) -> Result<(), Error> {
    let seconds = b.arg_float("cycle_time").unwrap_or(0.005);
    let period = Duration::try_from_secs_f64(seconds).unwrap_or_default();
    if !(Duration::from_micros(100)..=Duration::from_secs(1)).contains(&period) {
        return Err(Error::new(format!("cycle_time is {seconds}, must be between 0.0001 and 1")));
    }
    let motion = b.motion()?;
    let motion = motion.ok_or_else(|| Error::new("no motion is loaded: load motmod first"))?;
    let io = b.iocontrol()?;
    let io = io.ok_or_else(|| Error::new("no iocontrol is loaded: load it first"))?;
    let operator = b.operator()?;
    let shared = Shared::default();
    let now = motion.clone();
    commands::open(b, &shared, move || now.epoch())?;
    let ini = b.arg_text("ini").filter(|ini| !ini.is_empty());
    let opened = shared.clone();
    let is_virtual = b.clock().is_virtual();
    let letters = letters(b);
    b.on_open(move |_| {
        let made = setup::read(ini.as_deref(), letters.as_deref(), is_virtual);
        let made = made.map_err(Error::new)?;
        opened.lock().opened = Some(made);
        Ok(())
    })?;
    let snapshot =
        b.snapshot("task.status", status::VERSION, "State of the task at each change.")?;
    let pins = Pins::make(b)?;
    let worker = Worker::new(shared, motion, io, operator, b, pins, snapshot);
    let period_ns = i64::try_from(period.as_nanos()).unwrap_or(i64::MAX);
    b.worker("task", "Reads programs and runs jobs.", period_ns, ITEMS, worker)
}

/// Returns the letters of the joints, if the kinematics say so. A joint without a letter of its own has that before it, as
/// the second one of a gantry.
fn letters(b: &mut Builder<'_>) -> Option<String> {
    let kinematics = b.kinematics().ok()?;
    let joint = |(n, letter): (usize, char)| Some((kinematics.joint_of(n)?, letter));
    let known: BTreeMap<usize, char> = "xyzabcuvw".chars().enumerate().filter_map(joint).collect();
    let (last, _) = known.last_key_value()?;
    let of = |n: usize| known.range(..=n).next_back().map(|(_, letter)| *letter);
    (0..=*last).map(of).collect()
}

hal_component::export!(Task);

#[cfg(test)]
mod tests;
