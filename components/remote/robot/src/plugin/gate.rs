//! Realtime. The function: it passes the pins to the worker, and shows what the worker reports.

use super::{
    cause::Cause,
    pins::{InputPins, ResultPins, Results, SimInputs, SimPins, SimResults},
};
use hal_component::{
    Builder, Clock, Error, Period, Plain, SeqReader, SeqWriter, Snapshot, StillWatch, Touch, Update,
};
use std::sync::{
    Arc,
    atomic::{AtomicBool, AtomicU32, AtomicU64, Ordering::Relaxed},
};

/// Time without a step of the worker after which it is taken for dead, in nanoseconds.
const DEAD_NS: i64 = 1_000_000_000;
/// The same while it reads a program, in nanoseconds: without a line for longer, the controller ends the connection.
const LOAD_NS: i64 = 60_000_000_000;

/// Buttons that a machine presses, as bits.
pub(crate) mod press {
    /// Begins a run.
    pub(crate) const RUN: u32 = 1;
    /// Pauses it.
    pub(crate) const PAUSE: u32 = 2;
    /// Resumes it.
    pub(crate) const RESUME: u32 = 4;
    /// Stops it.
    pub(crate) const STOP: u32 = 8;
}

/// Values that function and worker share. Each stands alone: none publishes another.
#[derive(Debug, Default)]
pub(crate) struct Shared {
    /// Number of cycles of the function, 0 before the first.
    pub(crate) cycles: AtomicU32,
    /// Number of steps of the worker.
    pub(crate) steps: AtomicU32,
    /// Value of `enable`.
    pub(crate) enabled: AtomicBool,
    /// `enable` was FALSE since the worker looked.
    pub(crate) dropped: AtomicBool,
    /// The worker reads a program, which may take long; nothing moves meanwhile.
    pub(crate) loads: AtomicBool,
    /// The worker was taken for dead since it looked: it ends the connection.
    pub(crate) dead: AtomicBool,
    /// Value of `hold`.
    pub(crate) hold: AtomicBool,
    /// Buttons pressed since the worker looked, of [`press`].
    pub(crate) presses: AtomicU32,
    /// Number of stops so far, by a command, the pin `stop` or `enable`: an order from before the last one is refused.
    pub(crate) epoch: AtomicU64,
}

/// The record of stops, by which a program stamps its orders.
#[derive(Clone, Copy, Debug, Default, Plain)]
pub(crate) struct Stops {
    /// Number of the cycle.
    cycle: u64,
    /// Number of stops so far.
    pub(crate) epoch: u64,
}

/// The function.
#[derive(Debug, Touch)]
pub(crate) struct Gate {
    inputs: InputPins,
    shown: ResultPins,
    results: SeqReader<Results>,
    simulated: Option<Simulated>,
    clock: Clock,
    stops: Snapshot<Stops>,
    #[state]
    shared: Arc<Shared>,
    #[state]
    was: Was,
}

/// Ways to and from the simulated controller.
#[derive(Debug, Touch)]
struct Simulated {
    pins: SimPins,
    inputs: SeqWriter<SimInputs>,
    results: SeqReader<SimResults>,
}

/// The worker's ends of the ways to and from it.
#[derive(Debug)]
pub(crate) struct Ends {
    pub(crate) results: SeqWriter<Results>,
    pub(crate) simulated: Option<(SeqReader<SimInputs>, SeqWriter<SimResults>)>,
}

/// Values of the cycle before.
#[derive(Clone, Copy, Debug, Default)]
struct Was {
    buttons: u32,
    enabled: bool,
    cycle: u64,
    worker: StillWatch,
}

impl Gate {
    /// Creates the pins and the ways to and from the worker.
    pub(crate) fn make(b: &mut Builder<'_>, shared: Arc<Shared>) -> Result<(Self, Ends), Error> {
        let (writer, results) = b.seqlock(Results::default());
        let (mut simulated, mut far) = (None, None);
        if b.is_simulated() {
            let pins = SimPins::make(b)?;
            let (to, from) = b.seqlock(pins.inputs());
            let (back, shown) = b.seqlock(SimResults::default());
            simulated = Some(Simulated { pins, inputs: to, results: shown });
            far = Some((from, back));
        }
        let gate = Self {
            inputs: InputPins::make(b)?,
            shown: ResultPins::make(b)?,
            results,
            simulated,
            clock: b.clock(),
            stops: b.snapshot("robot.stops", 1, "Stops of the robot so far, in each cycle.")?,
            shared,
            was: Was::default(),
        };
        Ok((gate, Ends { results: writer, simulated: far }))
    }

    /// Returns whether the worker has stopped working.
    fn is_worker_dead(&mut self) -> bool {
        let steps = self.shared.steps.load(Relaxed);
        let longest = if self.shared.loads.load(Relaxed) { LOAD_NS } else { DEAD_NS };
        self.was.worker.still_ns(steps, self.clock.now_ns()) > longest
    }
}

impl Update for Gate {
    fn update(&mut self, _: Period) {
        let shared = &self.shared;
        let enabled = self.inputs.enable.get();
        shared.enabled.store(enabled, Relaxed);
        if !enabled {
            shared.dropped.store(true, Relaxed);
        }
        let was_enabled = core::mem::replace(&mut self.was.enabled, enabled);
        shared.hold.store(self.inputs.hold.get(), Relaxed);
        let bit = |is: bool, bit: u32| if is { bit } else { 0 };
        let buttons = bit(self.inputs.run.get(), press::RUN)
            | bit(self.inputs.pause.get(), press::PAUSE)
            | bit(self.inputs.resume.get(), press::RESUME)
            | bit(self.inputs.stop.get(), press::STOP);
        let mut pressed = buttons & !core::mem::replace(&mut self.was.buttons, buttons);
        if self.shared.loads.load(Relaxed) {
            // They would begin a move long after a person has pressed them.
            pressed &= !(press::RUN | press::RESUME);
        }
        if pressed != 0 {
            shared.presses.fetch_or(pressed, Relaxed);
        }
        if was_enabled && !enabled || pressed & press::STOP != 0 {
            shared.epoch.fetch_add(1, Relaxed);
        }
        self.was.cycle = self.was.cycle.wrapping_add(1);
        self.stops.set(&Stops { cycle: self.was.cycle, epoch: shared.epoch.load(Relaxed) });
        if let Some(simulated) = &mut self.simulated {
            simulated.inputs.set(&simulated.pins.inputs());
            simulated.pins.shown.set(&simulated.results.get());
        }
        let mut results = self.results.get();
        if self.is_worker_dead() {
            // Nobody speaks with the controller, and the move under way goes on: a run is busy, so that what holds or aborts it
            // lasts, until the worker has ended the connection.
            self.shared.dead.store(true, Relaxed);
            let (stopped, error) = (true, Cause::Worker.number());
            let (connected, ready, running, paused, ended) = (false, false, false, false, false);
            results =
                Results { connected, ready, running, paused, ended, stopped, error, ..results };
        }
        self.shown.set(&results);
        let cycles = &self.shared.cycles;
        cycles.store(cycles.load(Relaxed).wrapping_add(1).max(1), Relaxed);
    }
}
