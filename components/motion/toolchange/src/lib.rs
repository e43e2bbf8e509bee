//! E-stop, coolant and tool changers: the controls of a machine other than motion.
#![forbid(unsafe_code)]

mod carousel;
mod changer;
mod commands;
mod estop;
mod pins;
mod service;
mod task;

use estop::{Service, Shared};
use hal_component::{
    Arg, Builder, Component, Error,
    abi::{ArgSpec, component_flags},
};
use pins::Pins;
use service::{RESULTS, Results};
use std::time::Duration;
use task::Task;

/// Documentation of the component under one of its names.
macro_rules! doc {
    ($name:literal) => {
        concat!(
            "\
E-stop, coolant and tool changer.

The machine comes up in e-stop: `iocontrol.estop-reset` asks the outside to leave it, by
`iocontrol.0.user-enable-out`, and the machine is out of e-stop while
`iocontrol.0.emc-enable-in` is TRUE. `iocontrol.estop` puts it back, and fails when
`emc-enable-in` stays TRUE: lead `user-enable-out` to `emc-enable-in`, directly or through the
chain of e-stop contacts.

With `interlock=1`, which a start from an INI file gives, the motion controller that is loaded after
it reads the e-stop in every servo cycle: motion is never enabled in e-stop, and goes off in the
cycle in which it comes, whatever else is wired. Afterwards it stays off until `motion.enable`. While
the motion controller is loaded, this component cannot be unloaded then. Without it, only signals
stop motion: link `user-enable-out` to `motion.enable`, too.

A tool is prepared and changed by handshakes: a request goes
TRUE, the changer answers, the request goes FALSE. Link `tool-prepare` to `tool-prepared` and
`tool-change` to `tool-changed` where nothing answers.

It works in the background every `cycle_time`, not in a thread. `io` and `iov2` are other names for
it; the further pins that `iov2` once had are not there.

# Example

```hal
loadrt ",
            $name,
            "
loadrt threads name1=servo period1=1000000
start
setp iocontrol.0.emc-enable-in 1
iocontrol.estop-reset
run 1s
getp iocontrol.0.user-enable-out # -> TRUE
```"
        )
    };
}

const ARGS: &[&ArgSpec] = &[
    &Arg::float("cycle_time", "How often it looks at its pins, in seconds: 0.001 to 10.").or("0.1"),
    &Arg::bit(
        "interlock",
        "Motion that is loaded afterwards is off in e-stop, whatever is wired. A start from an INI \
         file says so.",
    )
    .or("0"),
];

/// Capacity of the command queue to the task.
const QUEUE_LEN: usize = 64;

macro_rules! names {
    ($($(#[$about:meta])* $ty:ident = $name:literal;)*) => {$(
        $(#[$about])*
        #[derive(Debug)]
        pub struct $ty;

        impl Component for $ty {
            const NAME: &'static str = $name;
            const DOC: &'static str = doc!($name);
            const FLAGS: u32 = component_flags::ONCE | component_flags::PARALLEL;
            const ARGS: &'static [&'static ArgSpec] = ARGS;
            fn create(b: &mut Builder<'_>) -> Result<(), Error> {
                create(b)
            }
        }
    )*};
}
names! {
    /// `loadrt iocontrol`.
    Iocontrol = "iocontrol";
    /// `loadrt io`: the same.
    Io = "io";
    /// `loadrt iov2`: the same.
    Iov2 = "iov2";
}

fn create(b: &mut Builder<'_>) -> Result<(), Error> {
    let seconds = b.arg_float("cycle_time").unwrap_or(0.1);
    let period = Duration::try_from_secs_f64(seconds).unwrap_or_default();
    if !(Duration::from_millis(1)..=Duration::from_secs(10)).contains(&period) {
        return Err(Error::new(format!("cycle_time is {seconds}, must be between 0.001 and 10")));
    }
    let pins = Pins::make(b)?;
    let (to, from) = b.queue(QUEUE_LEN);
    let (shared, read) = b.shared(Shared::new());
    commands::open(b, &to, pins, &shared)?;
    if b.needs_interlock() || b.arg_int("interlock").is_some_and(|on| on != 0) {
        b.offer_interlock(Service { emc_enable_in: pins.emc_enable_in, shared: read })?;
    }
    let (to_service, results) = b.queue(RESULTS);
    b.offer_iocontrol(service::Service::new(pins, shared.clone(), to.clone(), results))?;
    let period_ns = i64::try_from(period.as_nanos()).unwrap_or(i64::MAX);
    b.task(
        "iocontrol",
        "Looks at e-stop and the tool changer, and carries out commands.",
        period_ns,
        Task::new(pins, from, shared, b.messages(), Results(to_service)),
    )
}

hal_component::export!(Iocontrol, Io, Iov2, carousel::Carousel);

#[cfg(test)]
mod tests;
