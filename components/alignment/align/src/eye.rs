//! Realtime. The function: it reads the pins, passes events to the worker, and shows results.

use hal_component::{
    Builder, Error, In, Out, Period, Plain, Receiver, Sender, SeqReader, SeqWriter, TicketHandle,
    Touch, Update,
};
use std::sync::atomic::{AtomicBool, AtomicU32, Ordering::Relaxed};

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

/// Order of a command.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Order {
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
    pub(crate) ticket: Option<TicketHandle>,
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
    pub(crate) error: i32,
    pub(crate) found: bool,
    pub(crate) x: f64,
    pub(crate) y: f64,
    pub(crate) dx: f64,
    pub(crate) dy: f64,
    pub(crate) angle: f64,
    pub(crate) scatter: f64,
    pub(crate) uncertainty: f64,
    pub(crate) aim_x: f64,
    pub(crate) aim_y: f64,
    pub(crate) marks: i32,
    pub(crate) valid: bool,
    pub(crate) theta: f64,
    pub(crate) sx: f64,
    pub(crate) sy: f64,
    pub(crate) shear: f64,
    pub(crate) tx: f64,
    pub(crate) ty: f64,
    pub(crate) rms: f64,
    pub(crate) live: bool,
    pub(crate) live_theta: f64,
    pub(crate) live_x: f64,
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

/// Pins of the simulated camera.
#[derive(Debug, Touch)]
struct Simulated {
    light: In<f64>,
    x: In<f64>,
    y: In<f64>,
    stall: In<bool>,
}

macro_rules! pins {
    ($($field:ident: $dir:ident<$ty:ty>, $pin:literal, $start:expr, $doc:literal;)*) => {
        /// The function with its pins.
        #[derive(Debug, Touch)]
        pub(crate) struct Eye {
            $($field: $dir<$ty>,)*
            simulated: Option<Simulated>,
            orders: Receiver<Order>,
            events: Sender<Event>,
            results: SeqReader<Results>,
            #[state]
            shared: std::sync::Arc<Shared>,
            #[state]
            was: Was,
        }

        impl Eye {
            /// Creates the pins and the ways to and from the worker.
            pub(crate) fn make(
                b: &mut Builder<'_>,
                orders: Receiver<Order>,
                shared: std::sync::Arc<Shared>,
            ) -> Result<(Self, SeqWriter<Results>, Receiver<Event>), Error> {
                let (events, receiver) = b.queue(4);
                let (writer, results) = b.seqlock(Results::default());
                let simulated = if b.is_simulated() { Some(Simulated::make(b)?) } else { None };
                let eye = Self {
                    $($field: b.item($pin, $doc, $start)?,)*
                    simulated,
                    orders,
                    events,
                    results,
                    shared,
                    was: Was::default(),
                };
                Ok((eye, writer, receiver))
            }
        }
    };
}

pins! {
    pos_x: In<f64>, "align.pos-x", 0.0, "X of the machine, in mm.";
    pos_y: In<f64>, "align.pos-y", 0.0, "Y of the machine, in mm.";
    still: In<bool>, "align.still", true, "TRUE while the machine stands.";
    mark: In<f64>, "align.mark", 1.0, "Number of the selected mark, from 1; a float, as the analog outputs of programs are.";
    look: In<bool>, "align.look", false, "A rising edge finds the selected mark; while busy it has no effect.";
    solve: In<bool>, "align.solve", false, "A rising edge computes the place of the part; while busy it has no effect.";
    clear: In<bool>, "align.clear", false, "A rising edge forgets all marks; while busy it has no effect.";
    busy: Out<bool>, "align.busy", false, "TRUE from an edge or a command until its result.";
    found: Out<bool>, "align.found", false, "TRUE if the last look found the mark.";
    error: Out<i32>, "align.error", 0, "Reason why the last action failed, 0 if it did not.";
    looks: Out<u32>, "align.looks", 0, "Number of actions that are done.";
    x: Out<f64>, "align.x", 0.0, "X of the last mark found, on the machine, in mm.";
    y: Out<f64>, "align.y", 0.0, "Y of the last mark found, on the machine, in mm.";
    dx: Out<f64>, "align.dx", 0.0, "Move in X that brings the last mark to the middle of the picture, in mm.";
    dy: Out<f64>, "align.dy", 0.0, "Move in Y that brings the last mark to the middle of the picture, in mm.";
    angle: Out<f64>, "align.angle", 0.0, "Angle of the last mark if it is a square, on the machine, in degrees from -45 to 45.";
    scatter: Out<f64>, "align.scatter", 0.0, "Largest distance of a picture of the last mark from their mean, in pixels.";
    uncertainty: Out<f64>, "align.uncertainty", 0.0, "Standard deviation of the place of the last mark, in mm, from the noise of the pictures.";
    aim_x: Out<f64>, "align.aim-x", 0.0, "X at which the camera should see the selected mark, in mm.";
    aim_y: Out<f64>, "align.aim-y", 0.0, "Y at which the camera should see the selected mark, in mm.";
    marks: Out<i32>, "align.marks", 0, "Number of marks that are measured.";
    valid: Out<bool>, "align.valid", false, "TRUE while the place of the part holds; a new or forgotten mark ends it.";
    theta: Out<f64>, "align.theta", 0.0, "Turn of the part, in degrees.";
    sx: Out<f64>, "align.sx", 1.0, "Scale of the part along X.";
    sy: Out<f64>, "align.sy", 1.0, "Scale of the part along Y; negative if it is mirrored.";
    shear: Out<f64>, "align.shear", 0.0, "Squareness error of the part, in degrees.";
    tx: Out<f64>, "align.tx", 0.0, "X of the file's origin on the machine, in mm.";
    ty: Out<f64>, "align.ty", 0.0, "Y of the file's origin on the machine, in mm.";
    rms: Out<f64>, "align.rms", 0.0, "Root of the mean square of the residuals, in mm.";
    live: Out<bool>, "align.live", false, "TRUE if turn and shift alone fit, so that a coordinate system can hold them.";
    live_theta: Out<f64>, "align.live-theta", 0.0, "Turn for G10 L2 R, in degrees.";
    live_x: Out<f64>, "align.live-x", 0.0, "X for G10 L2, in mm.";
    live_y: Out<f64>, "align.live-y", 0.0, "Y for G10 L2, in mm.";
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
}

impl Simulated {
    fn make(b: &mut Builder<'_>) -> Result<Self, Error> {
        Ok(Self {
            light: b.item("align.sim.light", "Light on the simulated table, 0 to 2; 1 is usual.", 1.0)?,
            x: b.item("align.sim.x", "Shift of the part on the simulated table in X, in mm.", 0.0)?,
            y: b.item("align.sim.y", "Shift of the part on the simulated table in Y, in mm.", 0.0)?,
            stall: b.item("align.sim.stall", "TRUE: the simulated camera takes no picture.", false)?,
        })
    }
}

impl Update for Eye {
    fn update(&mut self, _: Period) {
        let rises = |now: bool, was: &mut bool| !core::mem::replace(was, now) && now;
        let looks = rises(self.look.get(), &mut self.was.look);
        let solves = rises(self.solve.get(), &mut self.was.solve);
        let clears = rises(self.clear.get(), &mut self.was.clear);
        let (x, y) = (self.pos_x.get(), self.pos_y.get());
        let mark = number(self.mark.get());
        self.shared.mark.store(mark, Relaxed);
        let results = self.results.get();
        let busy = results.number != self.was.number;
        if busy {
            let way = libm::fabs(x - self.was.x) + libm::fabs(y - self.was.y);
            // Not a number is a move, too.
            if !self.still.get() || way.is_nan() || way > STILL {
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
            let pressed = action.map(|action| Order { action, ticket: None });
            if let Some(order) = pressed.or_else(|| self.orders.take()) {
                self.begin(order, mark, x, y);
            }
        }
        self.show(&results);
    }
}

impl Eye {
    /// Passes an event to the worker.
    fn begin(&mut self, order: Order, mark: u32, x: f64, y: f64) {
        let scene = self.simulated.as_ref().map_or(
            Scene { light: 1.0, x: 0.0, y: 0.0, stalls: false },
            |s| Scene { light: s.light.get(), x: s.x.get(), y: s.y.get(), stalls: s.stall.get() },
        );
        let event = Event {
            number: self.was.number.wrapping_add(1),
            action: order.action,
            mark,
            x,
            y,
            scene,
            ticket: order.ticket,
        };
        self.shared.moved.store(!self.still.get(), Relaxed);
        // There is one event at a time, so that there is room.
        if self.events.send(event).is_ok() {
            (self.was.number, self.was.x, self.was.y) = (event.number, x, y);
        }
    }

    fn show(&self, r: &Results) {
        self.busy.set(r.number != self.was.number);
        self.looks.set(r.number);
        self.error.set(r.error);
        self.found.set(r.found);
        self.x.set(r.x);
        self.y.set(r.y);
        self.dx.set(r.dx);
        self.dy.set(r.dy);
        self.angle.set(r.angle);
        self.scatter.set(r.scatter);
        self.uncertainty.set(r.uncertainty);
        self.aim_x.set(r.aim_x);
        self.aim_y.set(r.aim_y);
        self.marks.set(r.marks);
        self.valid.set(r.valid);
        self.theta.set(r.theta);
        self.sx.set(r.sx);
        self.sy.set(r.sy);
        self.shear.set(r.shear);
        self.tx.set(r.tx);
        self.ty.set(r.ty);
        self.rms.set(r.rms);
        self.live.set(r.live);
        self.live_theta.set(r.live_theta);
        self.live_x.set(r.live_x);
        self.live_y.set(r.live_y);
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
