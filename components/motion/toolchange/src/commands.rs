//! Commands for users.

use crate::{
    changer::Tool,
    estop::{self, Shared},
    pins::Pins,
    service::Reply,
    task::Request,
};
use hal_component::{Arg, Builder, Call, Error, Gives, Sender, TicketHandle, abi::ArgSpec};

type To = Sender<(Request, Reply)>;

/// A command that the task executes.
struct Row {
    name: &'static str,
    doc: &'static str,
    args: &'static [&'static ArgSpec],
    read: fn(&Call<'_>) -> Result<Request, Error>,
}

const TOOL: ArgSpec = Arg::int("tool", "Number of the tool, 0 for none.").required();
const POCKET: ArgSpec =
    Arg::int("pocket", "Pocket that the tool is kept in; the tool's number if missing.");

const ROWS: &[Row] = &[
    Row {
        name: "iocontrol.prepare",
        doc: "Asks the changer to prepare a tool, and waits for it.",
        args: &[
            &TOOL,
            &POCKET,
            &Arg::int("index", "Place in the tool table; the pocket if missing."),
        ],
        read: |call| tool(call).map(Request::Prepare),
    },
    Row {
        name: "iocontrol.change",
        doc: "\
Asks the changer to put the prepared tool into the spindle, and waits for it.

Nothing happens when it is there already.",
        args: &[],
        read: |_| Ok(Request::Change),
    },
    Row {
        name: "iocontrol.set-tool",
        doc: "Says which tool is in the spindle; nothing is changed.",
        args: &[&TOOL, &POCKET],
        read: |call| tool(call).map(Request::SetTool),
    },
    Row {
        name: "iocontrol.coolant",
        doc: "Switches coolant and lubrication; what is not given stays.",
        args: &[
            &Arg::bit("mist", "Mist coolant."),
            &Arg::bit("flood", "Flood coolant."),
            &Arg::bit("lube", "Lubrication."),
        ],
        read: |call| {
            Ok(Request::Coolant {
                mist: call.bit("mist"),
                flood: call.bit("flood"),
                lube: call.bit("lube"),
            })
        },
    },
    Row {
        name: "iocontrol.abort",
        doc: "Switches coolant off and withdraws what the changer was asked.",
        args: &[],
        read: |_| Ok(Request::Abort),
    },
];

/// Declares all commands.
pub(crate) fn open(
    b: &mut Builder<'_>,
    to: &To,
    pins: Pins,
    shared: &Gives<Shared>,
) -> Result<(), Error> {
    for row in ROWS {
        let (to, read) = (to.clone(), row.read);
        b.command(row.name, row.doc, row.args, move |call| ask(&to, read(call)?, call))?;
    }
    let (to_stop, to_reset) = (to.clone(), to.clone());
    let (stopped, reset, told) = (shared.clone(), shared.clone(), shared.clone());
    b.command("iocontrol.estop", ESTOP, &[], move |call| {
        estop::command(&stopped, &pins);
        let reads = stopped.reads();
        // Contacts that do not open at once may never open: the caller waits for the result.
        let ticket = if pins.emc_enable_in.get() || stopped.is_unread() {
            call.awaited_ticket()?
        } else {
            call.ticket()?
        };
        send(&to_stop, Request::Estop { reads }, ticket)
    })?;
    b.command(
        "iocontrol.estop-reset",
        "Leaves e-stop, if nothing outside holds it.",
        &[],
        move |call| ask(&to_reset, Request::EstopReset { stops: reset.stops() }, call),
    )?;
    b.command(
        "iocontrol.status",
        "Tells e-stop, coolant, and the tools in the spindle and prepared.",
        &[],
        move |call| {
            status(&pins, !estop::state(&told, pins.emc_enable_in).is_released(), call);
            Ok(())
        },
    )
}

const ESTOP: &str = "\
Puts the machine into e-stop at once: all outputs of iocontrol go FALSE.

It fails if emc-enable-in stays TRUE, which says that the chain of e-stop contacts does not follow
user-enable-out, and if motion no longer reads the interlock. While emc-enable-in is TRUE the
caller waits for the answer, with --wait or without, for ten cycles of iocontrol at the most.";

fn ask(to: &To, request: Request, call: &Call<'_>) -> Result<(), Error> {
    send(to, request, call.ticket()?)
}

fn send(to: &To, request: Request, ticket: TicketHandle) -> Result<(), Error> {
    let is_estop = matches!(request, Request::Estop { .. });
    to.send((request, Reply::Ticket(ticket))).map_err(|_| {
        ticket.fail("too many commands wait");
        Error::new(if is_estop {
            "the machine is in e-stop, but too many commands wait for iocontrol to see whether \
             emc-enable-in follows"
        } else {
            "too many commands wait for iocontrol"
        })
    })
}

fn tool(call: &Call<'_>) -> Result<Tool, Error> {
    let number = number("tool", call.int("tool").unwrap_or(0))?;
    if number == 0 {
        return Ok(Tool { number, pocket: 0, index: 0 });
    }
    let pocket = match call.int("pocket") {
        Some(given) => self::number("pocket", given)?,
        None => number,
    };
    let index = match call.int("index") {
        Some(given) => self::number("index", given)?,
        None => pocket,
    };
    Ok(Tool { number, pocket, index })
}

fn number(name: &str, given: i64) -> Result<i32, Error> {
    i32::try_from(given)
        .ok()
        .filter(|n| *n >= 0)
        .ok_or_else(|| Error::new(format!("{name} is {given}, must be between 0 and {}", i32::MAX)))
}

fn status(p: &Pins, in_estop: bool, call: &Call<'_>) {
    let bit = |value: bool| if value { "TRUE" } else { "FALSE" };
    call.reply(&format!(
        "machine estop={} mist={} flood={} lube={}",
        bit(in_estop),
        bit(p.coolant_mist.get()),
        bit(p.coolant_flood.get()),
        bit(p.lube.get()),
    ));
    call.reply(&format!(
        "tool number={} from-pocket={} prepared={} waits-for={}",
        p.tool_number.get(),
        p.tool_from_pocket.get(),
        p.tool_prep_number.get(),
        match (p.tool_prepare.get(), p.tool_change.get()) {
            (true, _) => "tool-prepared",
            (false, true) => "tool-changed",
            (false, false) => "nothing",
        },
    ));
}
