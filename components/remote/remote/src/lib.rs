//! The plugin `remote`: the control lease of remote operators, and the dead man of their jogs.
#![forbid(unsafe_code)]

mod commands;
mod keeper;
mod lease;
mod numbers;
mod pins;
mod watch;

use hal_component::{
    Arg, Builder, Component, Error,
    abi::{ArgSpec, component_flags},
};
use hal_safety::lease::Rules;
use keeper::Keeper;
use lease::{Lease, Loss};
use pins::Pins;
use std::{
    sync::{Arc, Mutex},
    time::Duration,
};
use watch::Watch;

/// Period of the task, in nanoseconds.
const PERIOD_NS: i64 = 10_000_000;

/// `loadrt remote`.
#[derive(Debug)]
pub struct Remote;

impl Component for Remote {
    const NAME: &'static str = "remote";
    const DOC: &'static str = "\
The control lease of remote operators, and the dead man of their jogs.

It is loaded after `motmod`; `halpanel` loads and wires it where the machine's files have not. A machine whose robot moves by
its own controller has no `motmod`: with `motion=0`, `hold`, `abort` and `job` are linked to the component `robot`, and nothing jogs. One
remote operator at a time has the lease. Local controls need none: what they command ends remote
motion.

Its function runs in the servo thread, before `motion-controller`. In every cycle it writes machine time
in milliseconds to `pulse`. The operator's page sends each number back, and it arrives at `beat`. A
jog that lasts while a button is held is permitted as long as that number is younger than
`jog_timeout`: all delays on the way to the page and back count. When the page, the network, or a
program on the way fails, the jog brakes within this time, and only a new command begins one again.

Without a beat for `lease_timeout` the lease ends. A program that was started under it then does what its start said
(`remote.start on-loss=`), or else `on_loss`: it holds until `remote.release` ends the hold or the program is aborted, goes
on, or ends. FALSE at `allow-motion` has the same effects, and refuses new jogs.

`jog-stop` is linked to `motion.jog-stop`, and `hold` to `motion.feed-inhibit`. A program that is paused
moves nothing: `job`, linked to `task.job`, shows that it has not ended, and `abort`, linked to `task.abort`,
ends it. `tool-changed` is linked to the button that answers a tool change while it is pressed, and `tool-change`
to the request, with whose end the press ends.

# Example

```hal
loadrt trivkins coordinates=XYZ
loadrt motmod num_joints=3
loadrt remote
addf motion-command-handler servo-thread
addf remote servo-thread
addf motion-controller servo-thread
net x joint.0.motor-pos-cmd joint.0.motor-pos-fb
net jog-stop remote.jog-stop motion.jog-stop
net hold remote.hold motion.feed-inhibit
start
motion.configure joint=0 max-velocity=100 max-acceleration=1000 min-limit=-500 max-limit=500 ferror=1 min-ferror=1
motion.enable
run 50ms
remote.take holder=ana # -> lease=1
run 10ms
getp remote.present # -> TRUE
remote.jog lease=1 joint=0 velocity=20 distance=1
run 1s
# No beat has kept the lease.
run 1s
getp remote.present # -> FALSE
```";
    const FLAGS: u32 = component_flags::ONCE;
    const ARGS: &'static [&'static ArgSpec] = &[
        &Arg::float("jog_timeout", "Age of a beat up to which a held jog is permitted.")
            .or("0.095")
            .within(0.02, 0.1)
            .unit("s"),
        &Arg::float("lease_timeout", "Age of a beat up to which the lease lasts.")
            .or("1")
            .within(0.2, 60.0)
            .unit("s"),
        &Arg::text(
            "on_loss",
            "Effect of a lost lease on a program whose start says nothing else: hold, continue or abort.",
        )
        .or("hold"),
        &Arg::bit("motion", "FALSE for a machine without motmod.").or("TRUE"),
    ];

    fn create(b: &mut Builder<'_>) -> Result<(), Error> {
        let jog_ms = milliseconds(b, "jog_timeout");
        let lease_ms = milliseconds(b, "lease_timeout");
        let on_loss = b.arg_text("on_loss").unwrap_or_default();
        let preset = Loss::named(&on_loss).ok_or_else(|| {
            Error::new(format!("on_loss is {on_loss}, must be hold, continue or abort"))
        })?;
        let motion = if b.arg_int("motion") == Some(0) {
            None
        } else {
            let missing = "there is no motion controller for it: loadrt motmod first, or motion=0";
            Some(b.motion()?.ok_or_else(|| Error::new(missing))?)
        };
        let lease = Arc::new(Lease::new(Rules { jog_ms, lease_ms }));
        let watch = Watch::make(b, lease.clone())?;
        b.function("remote", "Judges the beats, and ends remote motion.", watch)?;
        let pins = Pins::make(b)?;
        let keeper = Keeper::new(lease, motion, pins, b.clock(), b.messages(), preset);
        let keeper = Arc::new(Mutex::new(keeper));
        commands::open(b, &keeper)?;
        b.task(
            "remote-keeper",
            "Follows remote motion until its end.",
            PERIOD_NS,
            keeper::Step(keeper),
        )
    }
}

/// Returns an argument in seconds as milliseconds.
fn milliseconds(b: &Builder<'_>, name: &str) -> u32 {
    let seconds = b.arg_float(name).unwrap_or_default();
    let time = Duration::try_from_secs_f64(seconds).unwrap_or_default();
    u32::try_from(time.as_millis()).unwrap_or(u32::MAX)
}

hal_component::export!(Remote);

#[cfg(test)]
mod tests;
