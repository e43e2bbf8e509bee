//! Commands `remote.*`.

use crate::{keeper::Keeper, lease::Loss};
use hal_component::{
    Arg, Builder, Call, Error, MotionCommand, abi::ArgSpec, motion_flags, motion_kind,
};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError, atomic::Ordering::Relaxed};

const LEASE: ArgSpec = Arg::int("lease", "Number of the lease.").required();

const EPOCH: ArgSpec = Arg::int(
    "epoch",
    "Stop epoch in which the order was given, as motion.status has it: after a stop since then it is refused. -1 is now.",
)
.or("-1");

type Shared = Arc<Mutex<Keeper>>;

fn lock(shared: &Shared) -> MutexGuard<'_, Keeper> {
    shared.lock().unwrap_or_else(PoisonError::into_inner)
}

fn lease(call: &Call<'_>) -> u32 {
    call.int("lease").and_then(|n| u32::try_from(n).ok()).unwrap_or(0)
}

/// Returns the stop epoch in which an order was given; `None` means now.
fn epoch(call: &Call<'_>) -> Option<u64> {
    u64::try_from(call.int("epoch")?).ok()
}

struct Row {
    name: &'static str,
    doc: &'static str,
    args: &'static [&'static ArgSpec],
    run: fn(&mut Keeper, &Call<'_>) -> Result<(), Error>,
}

const ROWS: &[Row] = &[
    Row {
        name: "remote.take",
        doc: "Takes the control lease; the answer has its number.",
        args: &[
            &Arg::text("holder", "Name of the operator.").required(),
            &Arg::int("from", "Number of the lease that its holder hands over."),
        ],
        run: |keeper, call| {
            let from = call.int("from").map(|n| u32::try_from(n).unwrap_or(0));
            let number = keeper.take(&call.text("holder").unwrap_or_default(), from)?;
            call.reply(&format!("lease={number}"));
            Ok(())
        },
    },
    Row {
        name: "remote.give",
        doc: "Ends the control lease: remote jogs stop, and a program is treated as on_loss says.",
        args: &[&LEASE],
        run: |keeper, call| keeper.give(lease(call)),
    },
    Row {
        name: "remote.beat",
        doc: "\
Sends a pulse back, as the pin remote.beat does, for a program without that pin.

The answer has the number of the pulse to send back next, and the one that came back last.",
        args: &[&LEASE, &Arg::int("pulse", "Number of the pulse that is sent back.")],
        run: |keeper, call| {
            keeper.check(lease(call))?;
            if let Some(pulse) = call.int("pulse") {
                let pulse =
                    u32::try_from(pulse).map_err(|_| Error::new("pulse is no such number"))?;
                // A number that the servo thread has not made yet would count later, for another lease too.
                if keeper.lease.pulse.load(Relaxed).wrapping_sub(pulse).cast_signed() >= 0 {
                    keeper.lease.beat.store(pulse, Relaxed);
                }
            }
            let permit = if keeper.lease.permit.load(Relaxed) { "TRUE" } else { "FALSE" };
            let (pulse, beat) = (&keeper.lease.pulse, &keeper.lease.beat);
            let (pulse, beat) = (pulse.load(Relaxed), beat.load(Relaxed));
            call.reply(&format!("pulse={pulse} permit={permit} beat={beat}"));
            Ok(())
        },
    },
    Row {
        name: "remote.jog",
        doc: "\
Jogs a joint or an axis under the lease.

Without distance and position it lasts until motion.jog-stop, and only while beats arrive.",
        args: &[
            &LEASE,
            &Arg::int("joint", "Number of the joint, from 0."),
            &Arg::text("axis", "Letter of the axis."),
            &Arg::float("velocity", "Velocity with its sign, in units/s.").required(),
            &Arg::float("distance", "Distance with its sign, in units."),
            &Arg::float("position", "Position, in units."),
            &EPOCH,
        ],
        run: |keeper, call| {
            let epoch = epoch(call).unwrap_or(0);
            keeper.jog(lease(call), &MotionCommand { epoch, ..command(call)? })
        },
    },
    Row {
        name: "remote.start",
        doc: "\
Says that a program, a line or homing is about to start under the lease, or to go on.

With release it first ends the hold of a program: both, or neither. The answer says what a lost lease does to it.",
        args: &[
            &LEASE,
            &Arg::bit("release", "TRUE ends a hold."),
            &Arg::text(
                "on-loss",
                "Effect of a lost lease on it: hold, continue or abort; without it on_loss, or what the start of the program said.",
            ),
            &EPOCH,
        ],
        run: |keeper, call| {
            let given = call.text("on-loss");
            let on_loss = given.as_deref().map(|name| {
                let why = format!("on-loss is {name}, must be hold, continue or abort");
                Loss::named(name).ok_or_else(|| Error::new(why))
            });
            let release = call.bit("release").unwrap_or(false);
            keeper.check_epoch(epoch(call), release)?;
            let on_loss = keeper.start(lease(call), release, on_loss.transpose()?)?;
            call.reply(&format!("on-loss={}", on_loss.name()));
            Ok(())
        },
    },
    Row {
        name: "remote.refused",
        doc: "Says that what remote.start has announced was refused: there is nothing that a lost lease would hold.",
        args: &[&LEASE],
        run: |keeper, call| keeper.refused(lease(call)),
    },
    Row {
        name: "remote.tool-changed",
        doc: "Answers a tool change: presses the button at remote.tool-changed for 0.2 s, or until remote.tool-change falls.",
        args: &[&LEASE],
        run: |keeper, call| keeper.tool_changed(lease(call)),
    },
    Row {
        name: "remote.release",
        doc: "Ends the hold of a program since the lease was lost: its motion goes on.",
        args: &[&EPOCH],
        run: |keeper, call| {
            keeper.check_epoch(epoch(call), true)?;
            keeper.release()
        },
    },
    Row {
        name: "remote.status",
        doc: "Tells the lease, its holder, whether a program is held, and what a lost lease does to the program in progress or the next one.",
        args: &[],
        run: |keeper, call| {
            let number = keeper.lease.number.load(Relaxed);
            let holder = if number == 0 { "" } else { keeper.holder.as_str() };
            let bit = |on: bool| if on { "TRUE" } else { "FALSE" };
            call.reply(&format!(
                "lease={number} holder={holder} permit={} hold={} on-loss={}",
                bit(keeper.lease.permit.load(Relaxed)),
                bit(keeper.lease.hold.load(Relaxed)),
                keeper.on_loss().name(),
            ));
            Ok(())
        },
    },
];

/// Declares all commands.
pub(crate) fn open(b: &mut Builder<'_>, shared: &Shared) -> Result<(), Error> {
    for row in ROWS {
        let (shared, run) = (shared.clone(), row.run);
        b.command(row.name, row.doc, row.args, move |call| run(&mut lock(&shared), call))?;
    }
    Ok(())
}

fn command(call: &Call<'_>) -> Result<MotionCommand, Error> {
    let (flags, index) = match (call.int("joint"), call.text("axis")) {
        (Some(n), None) => {
            let why = |_| Error::new(format!("there is no joint {n}"));
            (motion_flags::JOINT, u32::try_from(n).map_err(why)?)
        }
        (None, Some(axis)) => {
            let letters = ["x", "y", "z", "a", "b", "c", "u", "v", "w"];
            let found = (0..).zip(letters).find(|(_, l)| axis.eq_ignore_ascii_case(l));
            let why = || Error::new(format!("axis is {axis}, must be one of xyzabcuvw"));
            (motion_flags::AXIS, found.map(|(n, _)| n).ok_or_else(why)?)
        }
        (Some(_), Some(_)) | (None, None) => {
            return Err(Error::new("a jog is of a joint or of an axis: joint=N or axis=LETTER"));
        }
    };
    let (extent, value) = match (call.float("distance"), call.float("position")) {
        (None, None) => (0, 0.0),
        (Some(distance), None) => (1, distance),
        (None, Some(position)) => (2, position),
        (Some(_), Some(_)) => {
            return Err(Error::new("a jog goes by a distance or to a position, not both"));
        }
    };
    let speed = call.float("velocity").unwrap_or(0.0);
    Ok(MotionCommand { flags, index, extent, value, speed, ..MotionCommand::new(motion_kind::JOG) })
}
