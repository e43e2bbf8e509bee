//! Realtime. The function: it reads the pins, passes events to the worker, and shows results.

use crate::{
    bench::Failure,
    pins::{EyePins, Results},
};
use hal_align::Vector;
use hal_component::{
    Builder, Error, Period, Plain, Receiver, Sender, SeqReader, SeqWriter, TicketHandle, Touch,
    Update,
};
use std::sync::{
    Arc,
    atomic::{AtomicBool, AtomicU32, Ordering::Relaxed},
};

/// Distance in mm by which the machine may move during a look.
const STILL: f64 = 1e-3;

/// Actions of the worker.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Action {
    /// Finds the selected mark, or this one.
    Look(Option<u32>),
    /// Computes the place of the part.
    Solve,
    /// Forgets all marks.
    Clear,
    /// Finds a mark for the calibration of the camera.
    Sight,
    /// Calibrates the camera.
    Calibrate,
}

/// Instruction of a command.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Instruction {
    pub(crate) action: Action,
    pub(crate) ticket: Option<TicketHandle>,
}

/// Event for the worker.
#[derive(Clone, Copy, Debug)]
pub(crate) struct EyeEvent {
    pub(crate) number: u32,
    pub(crate) action: Action,
    pub(crate) mark: u32,
    pub(crate) station: Station,
    /// A command waits for the result, so that no message needs to report it.
    pub(crate) is_awaited: bool,
}

/// Place of the machine, and what the simulated camera sees there.
#[derive(Clone, Copy, Debug, Default, Plain)]
pub(crate) struct Station {
    /// X of the machine, in mm.
    pub(crate) x: f64,
    /// Y of the machine, in mm.
    pub(crate) y: f64,
    /// Light on the simulated table.
    pub(crate) light: f64,
    /// Shift of the part on the simulated table in X, in mm.
    pub(crate) part_x: f64,
    /// Shift of the part on the simulated table in Y, in mm.
    pub(crate) part_y: f64,
    /// TRUE: the simulated camera takes no picture.
    pub(crate) stalls: bool,
}

impl Station {
    /// Returns the place of the machine.
    pub(crate) const fn at(&self) -> Vector {
        Vector::new(self.x, self.y)
    }
}

/// Values that function and worker share.
#[derive(Debug, Default)]
pub(crate) struct Shared {
    /// The machine has moved since the last event.
    pub(crate) moved: AtomicBool,
    /// Number of the selected mark.
    pub(crate) mark: AtomicU32,
}

/// The function.
#[derive(Debug, Touch)]
pub(crate) struct Eye {
    pins: EyePins,
    orders: Receiver<Instruction>,
    events: Sender<EyeEvent>,
    results: SeqReader<Results>,
    station: SeqWriter<Station>,
    #[state]
    shared: Arc<Shared>,
    #[state]
    was: Was,
}

/// The worker's ends of the ways to and from it.
#[derive(Debug)]
pub(crate) struct Ends {
    pub(crate) results: SeqWriter<Results>,
    pub(crate) events: Receiver<EyeEvent>,
    pub(crate) station: SeqReader<Station>,
}

impl Eye {
    /// Creates the pins and the ways to and from the worker.
    pub(crate) fn make(
        b: &mut Builder<'_>,
        orders: Receiver<Instruction>,
        shared: Arc<Shared>,
    ) -> Result<(Self, Ends), Error> {
        let (events, receiver) = b.queue(4);
        let (writer, results) = b.seqlock(Results::default());
        let (station, reader) = b.seqlock(Station::default());
        let pins = EyePins::make(b)?;
        let eye = Self { pins, orders, events, results, station, shared, was: Was::default() };
        Ok((eye, Ends { results: writer, events: receiver, station: reader }))
    }
}

/// Inputs of the cycle before, and the event in progress.
#[derive(Clone, Copy, Debug, Default)]
struct Was {
    look: bool,
    solve: bool,
    clear: bool,
    number: u32,
    x: f64,
    y: f64,
    ticket: Option<TicketHandle>,
}

impl Update for Eye {
    fn update(&mut self, _: Period) {
        let rises = |now: bool, was: &mut bool| !core::mem::replace(was, now) && now;
        let looks = rises(self.pins.look.get(), &mut self.was.look);
        let solves = rises(self.pins.solve.get(), &mut self.was.solve);
        let clears = rises(self.pins.clear.get(), &mut self.was.clear);
        let station = self.pins.station();
        self.station.set(&station);
        let mark = number(self.pins.mark.get());
        self.shared.mark.store(mark, Relaxed);
        let results = self.results.get();
        let busy = results.looks != self.was.number;
        if busy {
            let way = libm::fabs(station.x - self.was.x) + libm::fabs(station.y - self.was.y);
            // Not a number is a move, too.
            if !self.pins.still.get() || way.is_nan() || way > STILL {
                self.shared.moved.store(true, Relaxed);
            }
        } else {
            let action = if looks {
                Some(Action::Look(None))
            } else if solves {
                Some(Action::Solve)
            } else if clears {
                Some(Action::Clear)
            } else {
                None
            };
            let pressed = action.map(|action| Instruction { action, ticket: None });
            if let Some(order) = pressed.or_else(|| self.orders.take()) {
                self.begin(order, mark, station);
            }
        }
        self.pins.show(&results, results.looks != self.was.number);
        if results.looks == self.was.number
            && let Some(ticket) = self.was.ticket.take()
        {
            match Failure::text_of(results.error) {
                None => ticket.done(),
                Some(text) => ticket.fail(text),
            }
        }
    }
}

impl Eye {
    /// Passes an event to the worker.
    fn begin(&mut self, order: Instruction, mark: u32, station: Station) {
        let event = EyeEvent {
            number: self.was.number.wrapping_add(1),
            action: order.action,
            mark,
            station,
            is_awaited: order.ticket.is_some(),
        };
        self.shared.moved.store(!self.pins.still.get(), Relaxed);
        // There is one event at a time, so that there is room.
        if self.events.send(event).is_ok() {
            (self.was.number, self.was.x, self.was.y) = (event.number, station.x, station.y);
            self.was.ticket = order.ticket;
        } else if let Some(ticket) = order.ticket {
            ticket.fail("the worker of align takes no orders");
        }
    }
}

/// Returns the number of a mark; 0 for what is none.
fn number(value: f64) -> u32 {
    let rounded = libm::round(value);
    if (1.0..1e6).contains(&rounded) {
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "in range")]
        return rounded as u32;
    }
    0
}
