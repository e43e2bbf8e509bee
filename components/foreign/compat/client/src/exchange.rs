//! Component of a C program: joining an instance, and the thread that exchanges values.

use crate::item::Item;
use hal_protocol::{Client, Direction, Failure, Link, Place, Reply, Request, Value};
use std::{
    env,
    ffi::c_int,
    io::Write,
    sync::{
        Arc,
        atomic::{AtomicBool, Ordering},
    },
};

const EINVAL: c_int = -22;
/// Default interval of the exchange, in milliseconds of machine time.
const POLL_MS: u64 = 10;

/// Component of the program.
#[derive(Debug)]
pub(crate) struct Component {
    /// Connection, until `ready` hands it to the thread.
    client: Option<Client>,
    names: Vec<String>,
    pub(crate) items: Vec<Item>,
    left: Arc<AtomicBool>,
}

impl Component {
    /// Joins the instance that `HAL_INSTANCE` names.
    pub(crate) fn join(name: &str) -> Result<Self, Failure> {
        let place = Place::find(None).map_err(|why| Failure::new(EINVAL, why))?;
        let mut client = Client::connect(&place, "")?;
        let poll = env::var("HAL_POLL_MS").ok().and_then(|v| v.parse().ok()).unwrap_or(POLL_MS);
        let poll_ns = u64::max(poll, 1).saturating_mul(1_000_000);
        client.call(Request::Join { name: name.to_owned(), poll_ns })?;
        Ok(Self {
            client: Some(client),
            names: Vec::new(),
            items: Vec::new(),
            left: Arc::new(AtomicBool::new(false)),
        })
    }

    /// Makes a pin.
    pub(crate) fn add(&mut self, name: &str, item: &Item) -> Result<(), Failure> {
        let Some(client) = &mut self.client else {
            return Err(Failure::new(EINVAL, "called after hal_ready"));
        };
        let (ty, direction) = (item.ty, item.direction);
        client.call(Request::NewPin { name: name.to_owned(), ty, direction })?;
        self.names.push(name.to_owned());
        Ok(())
    }

    /// Sends the initial values of inputs, and starts the exchange.
    pub(crate) fn ready(&mut self) -> c_int {
        let Some(mut client) = self.client.take() else { return EINVAL };
        for (item, name) in self.items.iter().zip(&self.names) {
            let bits = item.cell.load(item.ty);
            if matches!(item.direction, Direction::In) && bits != 0 {
                let value = match Value::from_bits(item.ty, bits) {
                    Value::Bit(truth) => u8::from(truth).to_string(),
                    // All digits, because the usual format has only six.
                    Value::Float(x) => format!("{x:?}"),
                    other => other.to_string(),
                };
                if let Err(failure) = client.call(Request::Set { name: name.clone(), value }) {
                    return report(name, &failure);
                }
            }
        }
        if let Err(failure) = client.call(Request::Ready) {
            return report("hal_ready", &failure);
        }
        let (items, left) = (core::mem::take(&mut self.items), Arc::clone(&self.left));
        std::thread::spawn(move || exchange(client, items, &left));
        0
    }

    /// Ends the thread, and with it the connection.
    pub(crate) fn leave(&mut self) -> c_int {
        self.client = None;
        // Pairs with nothing: the thread reads the flag at its next exchange.
        self.left.store(true, Ordering::Relaxed);
        0
    }
}

/// Exchanges values until the program leaves or the instance ends; in the second case it asks the program to end too.
fn exchange(mut client: Client, mut items: Vec<Item>, left: &AtomicBool) {
    while !left.load(Ordering::Relaxed) {
        let written = items
            .iter_mut()
            .enumerate()
            .filter_map(|(i, item)| Some((u32::try_from(i).ok()?, item.written()?)));
        let writes = written.collect();
        let Ok(Reply::Values { values, .. }) = client.call(Request::Poll { writes }) else { break };
        for (item, value) in items.iter_mut().zip(&values) {
            item.read(value);
        }
    }
    if !left.load(Ordering::Relaxed) {
        let me = rustix::process::getpid();
        // A program that ignores the signal does so on purpose.
        rustix::process::kill_process(me, rustix::process::Signal::TERM).ok();
    }
}

/// Reports a refusal on standard error, and returns its error number.
pub(crate) fn report(what: &str, failure: &Failure) -> c_int {
    // A failed write to standard error cannot be reported.
    drop(writeln!(std::io::stderr(), "{what}: {failure}"));
    if failure.code < 0 { failure.code } else { EINVAL }
}
