//! Realtime. Functions of a port.

use crate::{
    device::{Device, Register, Written},
    lines::{self, Input, Output, Pulse},
};
use hal_component::{Clock, Gives, Out, ParamRw, Period, Takes, Touch, Update};
use port::{Driven, Report, Shown, pause, reset_time};
use std::sync::Arc;

/// Pins of the simulated registers that the write function sets.
pub(crate) type Sets = Option<(Vec<Shown>, Out<u32>)>;

/// Function that reads the lines of one port.
#[derive(Clone, Touch)]
pub(crate) struct Read {
    #[state]
    pub(crate) device: Arc<Device>,
    /// Registers with input lines.
    #[state]
    pub(crate) registers: Vec<Register>,
    /// Input lines of each of these registers.
    pub(crate) lines: Vec<Vec<Input>>,
    pub(crate) asks: Option<(Vec<Driven>, Out<u32>)>,
    pub(crate) report: Report,
}

impl Update for Read {
    fn update(&mut self, _: Period) {
        let mut done = Ok(());
        for (register, lines) in self.registers.iter().zip(&self.lines) {
            match self.device.read(*register) {
                Ok(levels) => lines::take(lines, levels),
                Err(lost) => done = Err(lost),
            }
        }
        self.report.note(done, READING_FAILED);
    }
}

/// Function that writes the lines of one port.
#[derive(Clone, Touch)]
pub(crate) struct Write {
    #[state]
    pub(crate) device: Arc<Device>,
    pub(crate) written: Gives<Written>,
    /// Empty if the data lines are inputs.
    pub(crate) data: Vec<Output>,
    /// Empty if the control lines are inputs.
    pub(crate) control: Vec<Output>,
    pub(crate) sets: Sets,
    pub(crate) clock: Clock,
    pub(crate) report: Report,
}

impl Update for Write {
    fn update(&mut self, _: Period) {
        let ((data, idle_data), (control, idle_control)) =
            (lines::levels(&self.data), lines::levels(&self.control));
        self.device.note_idle(idle_data, idle_control);
        let put = |register, levels| self.written.put(&self.device, self.clock, register, levels);
        let data = if self.data.is_empty() { Ok(()) } else { put(Register::Data, data) };
        let control = put(Register::Control, self.device.control(control));
        self.report.note(data.and(control), WRITING_FAILED);
    }
}

/// Function that resets lines of one port, a set time after they were written.
#[derive(Touch)]
pub(crate) struct Reset {
    #[state]
    pub(crate) device: Arc<Device>,
    pub(crate) written: Takes<Written>,
    pub(crate) data: Vec<Pulse>,
    pub(crate) control: Vec<Pulse>,
    /// `None` if the data lines are inputs: then there is no wait.
    pub(crate) time: Option<ParamRw<u32>>,
    pub(crate) sets: Sets,
    pub(crate) clock: Clock,
    pub(crate) report: Report,
}

impl Update for Reset {
    fn update(&mut self, period: Period) {
        let wait = self.time.map_or(0, |time| reset_time(time, period));
        let mut done = Ok(());
        for (register, pulses) in [(Register::Data, &self.data), (Register::Control, &self.control)]
        {
            let Some((levels, since)) = self.written.last(register) else { continue };
            let rest = lines::reset(pulses, levels);
            if rest == levels {
                continue;
            }
            pause(self.clock, since, wait);
            done = done.and(self.written.put(&self.device, self.clock, register, rest));
        }
        self.report.note(done, WRITING_FAILED);
    }
}

/// Function that reads or writes every port.
#[derive(Touch)]
pub(crate) struct All<F: Touch> {
    pub(crate) ports: Vec<F>,
}

impl<F: Update> Update for All<F> {
    fn update(&mut self, period: Period) {
        for port in &mut self.ports {
            port.update(period);
        }
    }
}

const READING_FAILED: &str = "error {} when reading parport.{}: its inputs keep their values";
const WRITING_FAILED: &str = "error {} when writing parport.{}: it is tried again";
