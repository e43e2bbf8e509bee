//! Realtime. Functions: read, write and reset.

use crate::{
    device::{ChipMessages, Device, LineGroup, Written},
    encoder::Encoder,
};
use hal_component::{Clock, Gives, In, Out, ParamRw, Period, Takes, Touch, Update};
use port::{LineEdge, LinePins, Lost, Report, pause, reset_time};
use std::sync::{
    Arc,
    atomic::Ordering::{Acquire, Release},
};

/// Pins of an input.
#[derive(Touch)]
pub(crate) struct InputPins {
    pub(crate) level: Out<bool>,
    /// Absent for `hal_pi_gpio`, whose inputs have one pin.
    pub(crate) not: Option<Out<bool>>,
}

/// Number of edges that are taken at once.
const AT_ONCE: usize = 64;
/// Largest number of times that edges are taken in a run: the kernel keeps no more of them.
const TIMES: usize = 16;

/// Function that reads inputs.
#[derive(Touch)]
pub(crate) struct GpioRead {
    #[state]
    pub(crate) device: Arc<Device>,
    /// By the place of the line.
    pub(crate) inputs: Vec<Option<InputPins>>,
    pub(crate) simulated: Vec<LinePins>,
    pub(crate) fault: Out<bool>,
    pub(crate) written: Gives<Written>,
    /// A report for each group of lines.
    pub(crate) reports: Vec<Report>,
}

impl Update for GpioRead {
    fn update(&mut self, _: Period) {
        let mut is_fault = false;
        for (group, report) in self.device.groups().iter().zip(&mut self.reports) {
            if group.inputs != 0 {
                let done = take(group, &self.inputs);
                is_fault |= done.is_err();
                note(report, done, group.inputs_failed);
            }
        }
        self.fault.set(self.written.note(READING, is_fault));
    }
}

/// Function that counts the edges of encoders.
#[derive(Touch)]
pub(crate) struct GpioCapture {
    #[state]
    pub(crate) device: Arc<Device>,
    pub(crate) encoders: Vec<Encoder>,
    pub(crate) simulated: Vec<LinePins>,
    pub(crate) fault: Out<bool>,
    pub(crate) written: Gives<Written>,
    /// A report for each group of lines.
    pub(crate) reports: Vec<Report>,
    #[state]
    pub(crate) edges: EdgeRoom,
}

/// Room for edges that are taken at once.
pub(crate) struct EdgeRoom([LineEdge; AT_ONCE]);

impl Default for EdgeRoom {
    fn default() -> Self {
        Self([LineEdge::default(); AT_ONCE])
    }
}

impl Update for GpioCapture {
    fn update(&mut self, period: Period) {
        let mut is_fault = false;
        for (group, report) in self.device.groups().iter().zip(&mut self.reports) {
            let encoder = group.encoder.and_then(|number| self.encoders.get_mut(number));
            let Some(encoder) = encoder else { continue };
            let done = count(group, encoder, &mut self.edges.0);
            encoder.tell(period);
            is_fault |= done.is_err();
            note(report, done, group.inputs_failed);
        }
        self.fault.set(self.written.note(COUNTING, is_fault));
    }
}

/// Distributes the levels of the inputs to the pins.
fn take(group: &LineGroup, inputs: &[Option<InputPins>]) -> Result<(), Lost> {
    let levels = group.lines.read(group.inputs)?;
    for (bit, place) in (0..64).zip(&group.places) {
        if let Some(Some(pins)) = inputs.get(*place) {
            let level = levels >> bit & 1 != 0;
            pins.level.set(level);
            if let Some(not) = &pins.not {
                not.set(!level);
            }
        }
    }
    Ok(())
}

/// Passes the waiting edges to an encoder.
fn count(
    group: &LineGroup,
    encoder: &mut Encoder,
    room: &mut [LineEdge; AT_ONCE],
) -> Result<(), Lost> {
    encoder.begin(group.initial);
    for _ in 0..TIMES {
        let count = group.lines.edges(room)?;
        for edge in room.iter().take(count) {
            encoder.edge(edge);
        }
        if count < AT_ONCE {
            break;
        }
    }
    Ok(())
}

/// Function that writes outputs.
#[derive(Touch)]
pub(crate) struct GpioWrite {
    #[state]
    pub(crate) device: Arc<Device>,
    /// By the place of the line.
    pub(crate) outputs: Vec<Option<In<bool>>>,
    pub(crate) simulated: Vec<LinePins>,
    pub(crate) fault: Out<bool>,
    pub(crate) written: Gives<Written>,
    pub(crate) clock: Clock,
    /// A report for each group of lines.
    pub(crate) reports: Vec<Report>,
}

impl Update for GpioWrite {
    fn update(&mut self, _: Period) {
        let mut is_fault = false;
        for (group, report) in self.device.groups().iter().zip(&mut self.reports) {
            if group.outputs == 0 {
                continue;
            }
            let is_on = |place: &usize| {
                self.outputs.get(*place).is_some_and(|o| o.is_some_and(|pin| pin.get()))
            };
            let on = (0..64).zip(&group.places).filter(|(_, place)| is_on(place));
            let done = group.put(on.map(|(bit, _)| 1 << bit).sum());
            is_fault |= done.is_err();
            note(report, done, group.outputs_failed);
        }
        self.written.at_ns.store(self.clock.now_ns(), Release); // Pairs with `GpioReset`.
        self.fault.set(self.written.note(WRITING, is_fault));
    }
}

/// Function that returns outputs to rest, a set time after they were written.
#[derive(Touch)]
pub(crate) struct GpioReset {
    #[state]
    pub(crate) device: Arc<Device>,
    pub(crate) time: ParamRw<u32>,
    /// By the place of the line: TRUE returns it to rest.
    pub(crate) marks: Vec<Option<ParamRw<bool>>>,
    pub(crate) simulated: Vec<LinePins>,
    pub(crate) fault: Out<bool>,
    pub(crate) written: Takes<Written>,
    pub(crate) clock: Clock,
    /// A report for each group of lines.
    pub(crate) reports: Vec<Report>,
}

impl Update for GpioReset {
    fn update(&mut self, period: Period) {
        let wait = reset_time(self.time, period);
        let mut is_fault = false;
        for (group, report) in self.device.groups().iter().zip(&mut self.reports) {
            let is_marked = |place: &usize| {
                self.marks.get(*place).is_some_and(|mark| mark.is_some_and(|mark| mark.get()))
            };
            let marked = (0..64).zip(&group.places).filter(|(_, place)| is_marked(place));
            let resets: u64 = marked.map(|(bit, _)| 1 << bit).sum();
            let last = group.last();
            if last & resets == 0 {
                // Nothing is left of a failure to write: the next write tells again.
                note(report, Ok(()), group.outputs_failed);
                continue;
            }
            let since = self.written.at_ns.load(Acquire); // Pairs with `GpioWrite`.
            pause(self.clock, since, wait);
            let done = group.put(last & !resets);
            is_fault |= done.is_err();
            note(report, done, group.outputs_failed);
        }
        self.fault.set(self.written.note(RESETTING, is_fault));
    }
}

/// Bits of the functions in [`Written`].
const READING: u32 = 1;
const WRITING: u32 = 2;
const RESETTING: u32 = 4;
const COUNTING: u32 = 8;

/// Records the result of an access; a chip that is gone has a message of its own.
fn note(report: &mut Report, done: Result<(), Lost>, messages: ChipMessages) {
    report.note(done, if done == Err(Lost::GONE) { messages.gone } else { messages.other });
}
