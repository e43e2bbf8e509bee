//! The stop that needs no worker.

use crate::line::{OpenLine, PAUSE};
use arc_swap::ArcSwapOption;
use hal_component::Clock;
use hal_modbus::huanyang::{Ask, STOP, find};
use port::Exchange as _;
use std::sync::{
    Arc,
    atomic::{AtomicBool, Ordering::Relaxed},
};

/// Number of last stops.
const LAST: usize = 3;
/// Largest number of pieces in which an answer comes.
const PIECES: usize = 20;

/// Line of an inverter, for those who stop it while its worker may be dead.
#[derive(Debug)]
pub(crate) struct Halt {
    unit: u8,
    frame: Vec<u8>,
    way: ArcSwapOption<OpenLine>,
    clock: Clock,
    /// The inverter may turn.
    pub(crate) may_run: AtomicBool,
    /// A stop was sent without the worker, which has not noticed it yet.
    pub(crate) has_stopped: AtomicBool,
}

impl Halt {
    pub(crate) fn new(unit: u8, clock: Clock) -> Self {
        Self {
            unit,
            frame: Ask::Control(STOP).frame(unit),
            way: ArcSwapOption::empty(),
            clock,
            may_run: AtomicBool::new(false),
            has_stopped: AtomicBool::new(false),
        }
    }

    /// Notes the line.
    pub(crate) fn on(&self, way: Option<Arc<OpenLine>>) {
        self.way.store(way);
    }

    /// Realtime. Sends a stop if the inverter may turn: one system call, which does not wait.
    pub(crate) fn stop(&self) {
        self.has_stopped.store(true, Relaxed);
        if !self.may_run.load(Relaxed) {
            return;
        }
        if let Some(way) = &*self.way.load() {
            way.advance(self.clock.now_ns());
            // A lost line takes nothing; the inverter's own time-out is what is left then.
            let _ = way.send(&self.frame);
        }
    }

    /// Sends a stop if the inverter may turn, after whatever is under way on the line: 0.04 s later. Allocates nothing and takes
    /// no lock on a real line.
    pub(crate) fn stop_action(&self) {
        self.has_stopped.store(true, Relaxed);
        if !self.may_run.load(Relaxed) {
            return;
        }
        if let Some(way) = &*self.way.load() {
            way.advance(self.clock.now_ns());
            let _ = way.send_last(&self.frame);
        }
    }

    /// Sends stops until one is answered, at most three: when the component goes. Takes at most 0.5 s.
    pub(crate) fn last_stop(&self) {
        let Some(way) = self.way.swap(None) else { return };
        for _ in 0..LAST {
            if !self.may_run.load(Relaxed) {
                return;
            }
            way.advance(self.clock.now_ns());
            let mut came = Vec::new();
            let mut wait = |within| -> Option<()> {
                let mut into = [0; 64];
                let count = way.receive(&mut into, within).ok()?;
                came.extend(into.get(..count)?);
                (count != 0).then_some(())
            };
            // Noise without an end must not hold the end of the component.
            (0..PIECES).take_while(|_| wait(PAUSE).is_some()).for_each(drop);
            if way.send(&self.frame).is_err() {
                return;
            }
            (0..PIECES).take_while(|_| wait(2 * PAUSE).is_some()).for_each(drop);
            if find(self.unit, Ask::Control(STOP), &came).is_some() {
                self.may_run.store(false, Relaxed);
            }
        }
    }
}
