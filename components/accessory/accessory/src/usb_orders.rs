//! Commands `usbjobs.*`, and the state that they share with the worker.

use crate::usbjobs::Opened;
use hal_component::{Arg, Builder, Call, Error, TicketHandle, abi::ArgSpec};
use hal_storage::safe_name;
use std::{
    collections::VecDeque,
    sync::{Arc, Mutex, MutexGuard, PoisonError},
};

/// Largest number of orders that wait.
const ORDERS: usize = 64;

/// Order to the worker.
pub(crate) enum UsbOrder {
    Send { path: String, name: String },
    Cancel(String),
    Finish(String),
    Retry,
}

/// State that commands and the worker share.
#[derive(Default)]
pub(crate) struct InboxState {
    pub(crate) orders: VecDeque<(UsbOrder, TicketHandle)>,
    pub(crate) opened: Option<Opened>,
    /// Lines of `usbjobs.status`.
    pub(crate) status: Vec<String>,
}

/// State that commands and the worker share.
#[derive(Clone, Default)]
pub(crate) struct Inbox(Arc<Mutex<InboxState>>);

impl Inbox {
    pub(crate) fn lock(&self) -> MutexGuard<'_, InboxState> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn put(&self, call: &Call<'_>, order: UsbOrder) -> Result<(), Error> {
        if self.lock().orders.len() >= ORDERS {
            return Err(Error::new(format!("{ORDERS} orders wait already")));
        }
        let ticket = call.awaited_ticket()?;
        self.lock().orders.push_back((order, ticket));
        Ok(())
    }
}

const SEND: &[&ArgSpec] = &[
    &Arg::text("file", "Path of the file, 1 byte to 16 MiB.").required(),
    &Arg::text("job", "Name of the job; that of the file without it."),
];
const JOB: ArgSpec = Arg::text("job", "Name of the job.").required();

/// Declares the commands. Without a storage each is refused.
///
/// # Errors
/// A name is taken.
pub(crate) fn declare(b: &mut Builder<'_>, inbox: &Inbox, has_storage: bool) -> Result<(), Error> {
    let refused = move || {
        if has_storage {
            return Ok(());
        }
        Err(Error::new("usbjobs has no storage: load it with folder=PATH"))
    };
    let shared = inbox.clone();
    b.command("usbjobs.send", "Sends a file as a job.", SEND, move |call| {
        if call.is_from_afar() {
            return Err(Error::new("a file is named at the machine, and not from afar"));
        }
        refused()?;
        let path = call.text("file").unwrap_or_default();
        let name = call.text("job").filter(|name| !name.is_empty());
        let name = name.unwrap_or_else(|| path.clone());
        if let Err(why) = safe_name(&name) {
            return Err(Error::new(format!("job '{name}': {why}")));
        }
        shared.put(call, UsbOrder::Send { path, name })
    })?;
    let shared = inbox.clone();
    b.command(
        "usbjobs.cancel",
        "Takes a job that waits out of the queue.",
        &[&JOB],
        move |call| {
            refused()?;
            shared.put(call, UsbOrder::Cancel(call.text("job").unwrap_or_default()))
        },
    )?;
    let shared = inbox.clone();
    b.command(
        "usbjobs.finish",
        "Marks a job of the image as finished: it may be deleted when an image is full.",
        &[&JOB],
        move |call| {
            refused()?;
            shared.put(call, UsbOrder::Finish(call.text("job").unwrap_or_default()))
        },
    )?;
    let shared = inbox.clone();
    b.command("usbjobs.retry", "Goes on after a failure.", &[], move |call| {
        refused()?;
        shared.put(call, UsbOrder::Retry)
    })?;
    let shared = inbox.clone();
    b.command(
        "usbjobs.status",
        "Prints the state, the jobs, and the last failure.",
        &[],
        move |call| {
            refused()?;
            shared.lock().status.iter().for_each(|line| call.reply(line));
            Ok(())
        },
    )
}
