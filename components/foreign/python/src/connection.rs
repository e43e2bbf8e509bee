//! Connection and values of a component, which its pins share.

use hal_protocol::{Client, Failure, Link, MAX_PAGE_PINS, PinPage, Reply, Request};
use pyo3::{exceptions::PyRuntimeError, prelude::*};
use std::{
    sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError},
    thread::{self, ThreadId},
};

/// Number of pins for which the first page has space.
const FIRST_PINS: u32 = 64;

/// State of a component that its pins share.
#[derive(Debug, Default)]
pub(crate) struct Core {
    /// Thread that has the turn.
    holder: Mutex<Holder>,
    /// Notified when a turn ends.
    ended: Condvar,
    /// Connection; `None` before the component joins and after it has left. Locked only by the thread that has the turn.
    client: Mutex<Option<Client>>,
    /// Page of values; `None` before the first pin and after `exit`.
    page: Mutex<Option<PinPage>>,
}

/// Thread that has the turn, and whether its connection closes with the turn.
#[derive(Debug, Default)]
struct Holder {
    thread: Option<ThreadId>,
    leaves: bool,
}

/// Right to send requests and to change the component. One thread has it at a time.
#[derive(Debug)]
pub(crate) struct Turn<'c>(&'c Core);

impl Drop for Turn<'_> {
    fn drop(&mut self) {
        let mut holder = locked(&self.0.holder);
        holder.thread = None;
        if holder.leaves {
            *locked(&self.0.client) = None;
        }
        self.0.ended.notify_one();
    }
}

/// Locks a value whose holder never leaves it half changed.
pub(crate) fn locked<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Sends a request, and looks for signals while it waits; the outer error is that of a signal's handler. The caller does not
/// hold Python's lock.
pub(crate) fn call(client: &mut Client, request: Request) -> PyResult<Result<Reply, Failure>> {
    let mut signalled = None;
    let reply = client.call_while(request, &mut || {
        signalled = Python::attach(|py| py.check_signals().err());
        signalled.is_none()
    });
    signalled.map_or(Ok(reply), Err)
}

pub(crate) fn closed() -> PyErr {
    PyRuntimeError::new_err("Invalid operation on closed HAL component")
}

impl Core {
    #[inline]
    pub(crate) fn get(&self, pin: usize) -> PyResult<u64> {
        locked(&self.page).as_ref().map(|page| page.get(pin)).ok_or_else(closed)
    }

    #[inline]
    pub(crate) fn set(&self, pin: usize, bits: u64) -> PyResult<()> {
        let mut page = locked(&self.page);
        let is_set = page.as_mut().is_some_and(|page| page.set(pin, bits));
        if is_set { Ok(()) } else { Err(closed()) }
    }

    /// Waits for the turn while other threads of Python run. Returns `None` if this thread has it: the caller is a signal's
    /// handler that runs while a request waits.
    fn wait_for_turn(&self, py: Python<'_>) -> Option<Turn<'_>> {
        let me = thread::current().id();
        py.detach(|| {
            let mut holder = locked(&self.holder);
            while holder.thread.is_some_and(|thread| thread != me) {
                holder = self.ended.wait(holder).unwrap_or_else(PoisonError::into_inner);
            }
            holder.thread.replace(me).is_none().then(|| Turn(self))
        })
    }

    /// Waits for the turn while other threads of Python run.
    pub(crate) fn turn(&self, py: Python<'_>) -> PyResult<Turn<'_>> {
        self.wait_for_turn(py).ok_or_else(|| {
            PyRuntimeError::new_err("a request of this component is waiting in this thread")
        })
    }

    /// Begins with a connection.
    pub(crate) fn open(&self, _: &Turn<'_>, client: Client) {
        *locked(&self.client) = Some(client);
    }

    /// Sends a request while other threads of Python run.
    pub(crate) fn ask(&self, py: Python<'_>, request: Request) -> PyResult<Result<(), Failure>> {
        self.ask_in(py, &self.turn(py)?, request)
    }

    /// Sends a request in a turn.
    pub(crate) fn ask_in(
        &self,
        py: Python<'_>,
        _: &Turn<'_>,
        request: Request,
    ) -> PyResult<Result<(), Failure>> {
        py.detach(|| {
            let mut client = locked(&self.client);
            let client = client.as_mut().ok_or_else(closed)?;
            Ok(call(client, request)?.map(drop))
        })
    }

    /// Returns whether the instance runs on the virtual clock.
    pub(crate) fn is_virtual(&self) -> bool {
        locked(&self.page).as_ref().is_some_and(|page| page.info().is_virtual)
    }

    /// Ensures that the page has space for this number of pins.
    pub(crate) fn share(
        &self,
        py: Python<'_>,
        _: &Turn<'_>,
        pins: usize,
    ) -> PyResult<Result<(), Failure>> {
        let fits = |page: &PinPage| page.info().pins as usize >= pins;
        if locked(&self.page).as_ref().is_some_and(fits) {
            return Ok(Ok(()));
        }
        let pins = u32::try_from(pins).unwrap_or(u32::MAX);
        if pins > MAX_PAGE_PINS {
            let why = format!("a component in Python has at most {MAX_PAGE_PINS} pins");
            return Ok(Err(Failure::new(-12, why)));
        }
        // The maximum is a power of two as well.
        let space = pins.next_power_of_two().max(FIRST_PINS);
        py.detach(|| {
            let mut client = locked(&self.client);
            let client = client.as_mut().ok_or_else(closed)?;
            // Locked until the new page is there, so that no other thread finds none.
            let mut page = locked(&self.page);
            let new = client.share_pins(space, page.as_ref());
            Ok(new.map(|new| *page = Some(new)))
        })
    }

    /// Leaves the instance. A signal's handler leaves when the request that waits has ended.
    pub(crate) fn leave(self: &Arc<Self>, py: Python<'_>) -> PyResult<()> {
        let left = if let Some(turn) = self.wait_for_turn(py) {
            // If the instance has ended, there is nothing to leave.
            let left = self.ask_in(py, &turn, Request::Leave);
            locked(&self.holder).leaves = true;
            left.map(drop)
        } else {
            locked(&self.holder).leaves = true;
            Ok(())
        };
        *locked(&self.page) = None;
        left
    }
}
