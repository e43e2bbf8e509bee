//! The way of presses to the function: those of one sender stay together, and STOP passes all that wait.

use hal_component::{Builder, Receiver, Sender, TicketHandle, Touch};
use hal_handheld::{Press, keys::STOP};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

/// Largest number of presses that wait.
pub(crate) const WAITING: usize = 64;
/// Largest number of presses of STOP that wait.
const STOPS: usize = 8;
/// Reason why a press before STOP has no effect.
pub(crate) const STOPPED: &str = "STOP was pressed";

/// Press that waits.
#[derive(Clone, Copy)]
pub(crate) struct WaitingPress {
    pub(crate) press: Press,
    /// Ticket of the command, at its last press.
    pub(crate) ticket: Option<TicketHandle>,
    /// Number in the order of all presses.
    number: u64,
}

/// End of the senders: commands and the pipe's worker, never a realtime thread.
#[derive(Clone)]
pub(crate) struct Presses {
    waiting: Sender<WaitingPress>,
    stops: Sender<WaitingPress>,
    order: Arc<Mutex<Turns>>,
}

/// Numbers of presses.
#[derive(Default)]
struct Turns {
    /// Number of the last press.
    last: u64,
    /// Number of the last press of STOP.
    stop: u64,
}

impl Presses {
    /// Returns both ends.
    pub(crate) fn make(b: &mut Builder<'_>) -> (Self, PressQueue) {
        let (waiting, receiver) = b.queue(WAITING);
        let (stops, stop_receiver) = b.queue(STOPS);
        let queue = PressQueue {
            receiver,
            stop_receiver,
            waiting: waiting.clone(),
            stops: stops.clone(),
            stop: None,
            ahead: None,
        };
        (Self { waiting, stops, order: Arc::default() }, queue)
    }

    /// Keeps other senders out, from a look at the room to the last press.
    pub(crate) fn lock(&self) -> SendingPresses<'_> {
        let order = self.order.lock().unwrap_or_else(PoisonError::into_inner);
        SendingPresses { presses: self, order }
    }
}

/// Sender that is alone.
pub(crate) struct SendingPresses<'a> {
    presses: &'a Presses,
    order: MutexGuard<'a, Turns>,
}

impl<'a> SendingPresses<'a> {
    /// Returns the number of the last press of STOP.
    pub(crate) fn stop(&self) -> u64 {
        self.order.stop
    }

    /// Returns how many such presses have room.
    pub(crate) fn room(&self, presses: &[Press]) -> usize {
        let (queue, room) = self.queue(presses);
        room.saturating_sub(queue.waiting())
    }

    /// Sends presses, for which there is room. `ticket` is that of the last one.
    pub(crate) fn send(&mut self, presses: &[Press], mut ticket: Option<TicketHandle>) {
        for (left, press) in (0..presses.len()).rev().zip(presses) {
            let number = self.order.last.wrapping_add(1);
            self.order.last = number;
            if is_stop(presses) {
                self.order.stop = number;
            }
            let ticket = if left == 0 { ticket.take() } else { None };
            // No other sender has come in between, and the function only takes: it has room.
            let sent = self.queue(presses).0.send(WaitingPress { press: *press, ticket, number });
            if let Some(ticket) = sent.err().and_then(|lost| lost.ticket) {
                ticket.fail("the queue is full");
            }
        }
    }

    fn queue(&self, presses: &[Press]) -> (&'a Sender<WaitingPress>, usize) {
        if is_stop(presses) {
            (&self.presses.stops, STOPS)
        } else {
            (&self.presses.waiting, WAITING)
        }
    }
}

fn is_stop(presses: &[Press]) -> bool {
    matches!(presses, [press] if press.key == STOP)
}

/// End of the function.
#[derive(Touch)]
pub(crate) struct PressQueue {
    receiver: Receiver<WaitingPress>,
    stop_receiver: Receiver<WaitingPress>,
    #[state]
    waiting: Sender<WaitingPress>,
    #[state]
    stops: Sender<WaitingPress>,
    /// Press of STOP that comes next.
    #[state]
    stop: Option<WaitingPress>,
    /// First press after that STOP.
    #[state]
    ahead: Option<WaitingPress>,
}

impl PressQueue {
    /// Realtime. Returns the number of presses that wait.
    pub(crate) fn waiting(&self) -> u32 {
        let held = usize::from(self.stop.is_some()) + usize::from(self.ahead.is_some());
        u32::try_from(self.waiting.waiting() + self.stops.waiting() + held).unwrap_or(u32::MAX)
    }

    /// Realtime. Takes the next press.
    pub(crate) fn take(&mut self) -> Option<WaitingPress> {
        self.stop.take().or_else(|| self.ahead.take()).or_else(|| self.receiver.take())
    }

    /// Realtime. Looks for a press of STOP, which forgets what was sent before it. Returns true if there is a new one.
    pub(crate) fn look_for_stop(&mut self) -> bool {
        if self.stop.is_some() {
            return false;
        }
        let Some(stop) = self.stop_receiver.take() else { return false };
        for _ in 0..=WAITING {
            let Some(next) = self.ahead.take().or_else(|| self.receiver.take()) else { break };
            if next.number > stop.number {
                self.ahead = Some(next);
                break;
            }
            if let Some(ticket) = next.ticket {
                ticket.fail(STOPPED);
            }
        }
        self.stop = Some(stop);
        true
    }

    /// Realtime. Forgets all presses; their commands fail for this reason.
    pub(crate) fn forget(&mut self, why: &'static str) {
        for _ in 0..=WAITING + STOPS + 2 {
            let Some(next) = self.take().or_else(|| self.stop_receiver.take()) else { return };
            if let Some(ticket) = next.ticket {
                ticket.fail(why);
            }
        }
    }
}
