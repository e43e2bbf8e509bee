//! The command `modbus.probe`: one request to one device.

use hal_component::{Arg, Builder, Error, TicketHandle, abi::ArgSpec};
use hal_modbus::{Call, ModbusAnswer, ModbusRequest, ModbusTable};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

/// Largest number of probes that wait.
const MOST: usize = 8;

/// Probe that waits for its line, or for its answer.
#[derive(Clone, Debug)]
pub(crate) struct Probe {
    pub(crate) link: usize,
    pub(crate) request: ModbusRequest,
    pub(crate) ticket: TicketHandle,
}

/// Probes that wait.
pub(crate) type Inbox = Arc<Mutex<Vec<Probe>>>;

/// Takes the next probe for a line.
pub(crate) fn take(inbox: &Inbox, link: usize) -> Option<Probe> {
    let mut inbox = lock(inbox);
    let at = inbox.iter().position(|probe| probe.link == link)?;
    Some(inbox.remove(at))
}

fn lock(inbox: &Inbox) -> MutexGuard<'_, Vec<Probe>> {
    inbox.lock().unwrap_or_else(PoisonError::into_inner)
}

const ARGS: &[&ArgSpec] = &[
    &Arg::int("unit", "Number of the device.").within(1.0, 247.0).or("1"),
    &Arg::text("table", "coils, discretes, holding or inputs.").or("holding"),
    &Arg::int("first", "Address of the first element.").within(0.0, 65535.0).or("0"),
    &Arg::int("count", "Number of elements.").within(1.0, 16.0).or("1"),
    &Arg::int("line", "Number of the line, from 0, in the order of the transactions.")
        .within(0.0, 1000.0)
        .or("0"),
];

const TABLES: &[(&str, ModbusTable)] = &[
    ("coils", ModbusTable::Coils),
    ("discretes", ModbusTable::Discretes),
    ("holding", ModbusTable::Holding),
    ("inputs", ModbusTable::Inputs),
];

/// Declares the command.
pub(crate) fn open(b: &mut Builder<'_>, links: usize, inbox: &Inbox) -> Result<(), Error> {
    let inbox = inbox.clone();
    let doc = "Reads elements of one device once, between the requests of the line. The log has the values.";
    b.command("modbus.probe", doc, ARGS, move |call| {
        let int = |name| call.int(name).unwrap_or_default();
        let link = usize::try_from(int("line")).unwrap_or(usize::MAX);
        if links <= link {
            return Err(Error::new(format!(
                "line={link}: the lines are 0 to {}",
                links.saturating_sub(1)
            )));
        }
        let name = call.text("table").unwrap_or_default();
        let table =
            TABLES.iter().find(|(known, _)| *known == name).map(|(_, table)| *table).ok_or_else(
                || Error::new(format!("table={name}: coils, discretes, holding or inputs")),
            )?;
        let mut inbox = lock(&inbox);
        if MOST <= inbox.len() {
            return Err(Error::new("too many probes wait for their lines"));
        }
        let request = ModbusRequest {
            unit: u8::try_from(int("unit")).unwrap_or(1),
            call: Call::Read {
                table,
                first: u16::try_from(int("first")).unwrap_or_default(),
                count: u16::try_from(int("count")).unwrap_or(1),
            },
        };
        inbox.push(Probe { link, request, ticket: call.awaited_ticket()? });
        Ok(())
    })
}

/// Returns the values of an answer as words.
pub(crate) fn values(answer: &ModbusAnswer) -> String {
    let list = |all: Vec<String>| all.join(" ");
    match answer {
        ModbusAnswer::Bits(bits) => {
            list(bits.iter().map(|bit| u8::from(*bit).to_string()).collect())
        }
        ModbusAnswer::Words(words) => list(words.iter().map(ToString::to_string).collect()),
        ModbusAnswer::Written => "written".to_owned(),
        ModbusAnswer::Refused(exception) => exception.to_string(),
    }
}
