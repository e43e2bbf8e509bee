//! Realtime. The function: it reads the pins, passes events to the worker, and shows results.

use crate::{bench::Failure, pins::EyePins};
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
pub(crate) struct Event {
    pub(crate) number: u32,
    pub(crate) action: Action,
    pub(crate) mark: u32,
    pub(crate) x: f64,
    pub(crate) y: f64,
    pub(crate) scene: Scene,
    /// A command waits for the result, so that no message needs to tell it.
    pub(crate) is_awaited: bool,
}

/// Changes of what the simulated camera sees.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Scene {
    pub(crate) light: f64,
    pub(crate) x: f64,
    pub(crate) y: f64,
    pub(crate) stalls: bool,
}

/// Latest results.
#[derive(Clone, Copy, Debug, Default, Plain)]
pub(crate) struct Results {
    /// Number of the last event that is done.
    pub(crate) number: u32,
    /// Reason why the last action failed, 0 if it did not.
    pub(crate) error: i32,
    /// TRUE if the last look found the mark.
    pub(crate) found: bool,
    /// X of the last mark found, on the machine, in mm.
    pub(crate) x: f64,
    /// Y of the last mark found, on the machine, in mm.
    pub(crate) y: f64,
    /// Move in X that brings the last mark to the middle of the picture, in mm.
    pub(crate) dx: f64,
    /// Move in Y that brings the last mark to the middle of the picture, in mm.
    pub(crate) dy: f64,
    /// Angle of the last mark if it is a square, on the machine, in degrees from -45 to 45.
    pub(crate) angle: f64,
    /// Largest distance of a picture of the last mark from their mean, in pixels.
    pub(crate) scatter: f64,
    /// Standard deviation of the place of the last mark, in mm, from the noise of the pictures.
    pub(crate) uncertainty: f64,
    /// X at which the camera should see the selected mark, in mm.
    pub(crate) aim_x: f64,
    /// Y at which the camera should see the selected mark, in mm.
    pub(crate) aim_y: f64,
    /// Number of marks that are measured.
    pub(crate) marks: i32,
    /// TRUE while the place of the part holds; a new or forgotten mark ends it.
    pub(crate) valid: bool,
    /// Turn of the part, in degrees.
    pub(crate) theta: f64,
    /// Scale of the part along X.
    pub(crate) sx: f64,
    /// Scale of the part along Y; negative if it is mirrored.
    pub(crate) sy: f64,
    /// Squareness error of the part, in degrees.
    pub(crate) shear: f64,
    /// X of the file's origin on the machine, in mm.
    pub(crate) tx: f64,
    /// Y of the file's origin on the machine, in mm.
    pub(crate) ty: f64,
    /// Root of the mean square of the residuals, in mm.
    pub(crate) rms: f64,
    /// TRUE if turn and shift alone fit, so that a coordinate system can hold them.
    pub(crate) live: bool,
    /// Turn for G10 L2 R, in degrees.
    pub(crate) live_theta: f64,
    /// X for G10 L2, in mm.
    pub(crate) live_x: f64,
    /// Y for G10 L2, in mm.
    pub(crate) live_y: f64,
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
    events: Sender<Event>,
    results: SeqReader<Results>,
    #[state]
    shared: Arc<Shared>,
    #[state]
    was: Was,
}

/// Ends of the ways to and from the worker.
pub(crate) type Ends = (SeqWriter<Results>, Receiver<Event>);

impl Eye {
    /// Creates the pins and the ways to and from the worker.
    pub(crate) fn make(
        b: &mut Builder<'_>,
        orders: Receiver<Instruction>,
        shared: Arc<Shared>,
    ) -> Result<(Self, Ends), Error> {
        let (events, receiver) = b.queue(4);
        let (writer, results) = b.seqlock(Results::default());
        let pins = EyePins::make(b)?;
        let eye = Self { pins, orders, events, results, shared, was: Was::default() };
        Ok((eye, (writer, receiver)))
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
        let (x, y) = (self.pins.pos_x.get(), self.pins.pos_y.get());
        let mark = number(self.pins.mark.get());
        self.shared.mark.store(mark, Relaxed);
        let results = self.results.get();
        let busy = results.number != self.was.number;
        if busy {
            let way = libm::fabs(x - self.was.x) + libm::fabs(y - self.was.y);
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
                self.begin(order, mark, x, y);
            }
        }
        self.pins.show(&results, results.number != self.was.number);
        if results.number == self.was.number
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
    fn begin(&mut self, order: Instruction, mark: u32, x: f64, y: f64) {
        let scene = self.pins.scene();
        let event = Event {
            number: self.was.number.wrapping_add(1),
            action: order.action,
            mark,
            x,
            y,
            scene,
            is_awaited: order.ticket.is_some(),
        };
        self.shared.moved.store(!self.pins.still.get(), Relaxed);
        // There is one event at a time, so that there is room.
        if self.events.send(event).is_ok() {
            (self.was.number, self.was.x, self.was.y) = (event.number, x, y);
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
