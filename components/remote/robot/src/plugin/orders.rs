//! Commands `robot.*`.

use super::{gate::Shared, report::Report};
use crate::link::lock;
use hal_component::{Arg, Builder, Call, Error, TicketHandle, abi::ArgSpec};
use std::{
    path::PathBuf,
    sync::{Arc, Mutex, atomic::Ordering::Relaxed},
};

/// Largest number of orders that wait.
const MAX_WAITING: usize = 16;

/// Order for the worker.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum RobotOrder {
    /// Connects.
    Connect,
    /// Ends the connection while nothing runs.
    Disconnect,
    /// Loads a program.
    Load(PathBuf),
    /// Runs the program from a line.
    Run(usize),
    /// Pauses behind the move under way.
    Pause,
    /// Resumes.
    Resume,
    /// Stops at once.
    Stop,
}

impl RobotOrder {
    /// Returns whether the robot may move by it.
    pub(crate) const fn begins_a_move(&self) -> bool {
        matches!(self, Self::Connect | Self::Run(_) | Self::Resume)
    }
}

/// Orders that wait.
pub(crate) type Inbox = Vec<Waiting>;

/// Order that waits, with the ticket that tells its end.
#[derive(Debug)]
pub(crate) struct Waiting {
    pub(crate) order: RobotOrder,
    pub(crate) ticket: TicketHandle,
    /// Machine time at which it came, in nanoseconds.
    pub(crate) since: i64,
}

/// Argument of an order by which the robot may move.
const EPOCH: ArgSpec = Arg::int(
    "epoch",
    "Stop epoch in which the order was given, as robot.stops has it: after a stop since then it is refused. -1 is now.",
)
.or("-1");

/// Returns whether an order is from before a stop.
fn is_from_before_a_stop(call: &Call<'_>, epoch: u64) -> bool {
    call.int("epoch").is_some_and(|given| u64::try_from(given).is_ok_and(|given| given < epoch))
}

struct OrderRow {
    name: &'static str,
    doc: &'static str,
    args: &'static [&'static ArgSpec],
    order: fn(&Call<'_>) -> RobotOrder,
}

const ROWS: &[OrderRow] = &[
    OrderRow {
        name: "robot.connect",
        doc: "Connects to the controller: the robot takes the place of its tool as the part zero, and retracts. With --wait, until it is ready.",
        args: &[&EPOCH],
        order: |_| RobotOrder::Connect,
    },
    OrderRow {
        name: "robot.disconnect",
        doc: "Ends the connection while no run is in progress.",
        args: &[],
        order: |_| RobotOrder::Disconnect,
    },
    OrderRow {
        name: "robot.load",
        doc: "Converts a program, and checks every point; a refusal names file, line and point.",
        args: &[&Arg::text("file", "G-code program.").required()],
        order: |call| RobotOrder::Load(PathBuf::from(call.text("file").unwrap_or_default())),
    },
    OrderRow {
        name: "robot.run",
        doc: "Runs the loaded program. With --wait, until its end.",
        args: &[
            &Arg::int("from", "Line to the robot to begin with, from 0.").within(0.0, 1e9).or("0"),
            &EPOCH,
        ],
        order: |call| {
            RobotOrder::Run(call.int("from").and_then(|n| usize::try_from(n).ok()).unwrap_or(0))
        },
    },
    OrderRow {
        name: "robot.pause",
        doc: "Lets the move under way end, and sends nothing more. With --wait, until the robot stands.",
        args: &[],
        order: |_| RobotOrder::Pause,
    },
    OrderRow {
        name: "robot.resume",
        doc: "Resumes a run that was paused.",
        args: &[&EPOCH],
        order: |_| RobotOrder::Resume,
    },
    OrderRow {
        name: "robot.stop",
        doc: "Stops the move under way at once, and ends the connection.",
        args: &[],
        order: |_| RobotOrder::Stop,
    },
];

/// Declares the commands.
pub(crate) fn open(
    b: &mut Builder<'_>,
    inbox: &Arc<Mutex<Inbox>>,
    report: &Arc<Mutex<Report>>,
    shared: &Arc<Shared>,
) -> Result<(), Error> {
    let clock = b.clock();
    for row in ROWS {
        let (inbox, shared) = (inbox.clone(), shared.clone());
        b.command(row.name, row.doc, row.args, move |call| {
            let mut inbox = lock(&inbox);
            // A stop finds room always.
            let order = (row.order)(call);
            if matches!(order, RobotOrder::Load(_)) && call.is_from_afar() {
                return Err(Error::new(
                    "a program is loaded at the machine or by the panel, and not from afar",
                ));
            }
            if order.begins_a_move() && is_from_before_a_stop(call, shared.epoch.load(Relaxed)) {
                return Err(Error::new("the robot was stopped after this order was given"));
            }
            if order.begins_a_move() && shared.loads.load(Relaxed) {
                return Err(Error::new("a program is being loaded: wait until it is"));
            }
            if inbox.len() >= MAX_WAITING && order != RobotOrder::Stop {
                return Err(Error::new("too many commands wait for the worker of robot"));
            }
            // What ends at once must not be refused unseen.
            let ends_at_once =
                matches!(order, RobotOrder::Load(_) | RobotOrder::Resume | RobotOrder::Disconnect);
            let ticket = if ends_at_once { call.awaited_ticket()? } else { call.ticket()? };
            if order == RobotOrder::Stop {
                shared.epoch.fetch_add(1, Relaxed);
            }
            inbox.push(Waiting { order, ticket, since: clock.now_ns() });
            Ok(())
        })?;
    }
    let report = report.clone();
    let doc = "Returns the state, the program, the part zero, and the last problem.";
    const JSON: &[&ArgSpec] = &[&Arg::bit("json", "As JSON, in one line.").or("FALSE")];
    b.command("robot.status", doc, JSON, move |call| {
        let report = lock(&report);
        match call.bit("json").unwrap_or(false) {
            true => call.reply(&report.json().to_string()),
            false => report.lines().iter().for_each(|line| call.reply(line)),
        }
        Ok(())
    })
}
