//! A capture: a trigger and the samples around it.

use super::{Cause, Setup, Trigger, When};
use crate::Trace;
use hal_protocol::Type;

/// Maximum number of samples before a trigger for which memory is allocated in advance.
const AT_ONCE: usize = 1 << 16;

/// Receives samples and returns a trace for each trigger.
#[derive(Debug)]
pub struct Capture {
    trigger: Trigger,
    /// A trace with the channels but without samples.
    blank: Trace,
    width: usize,
    /// Ring buffer of the samples before the trigger: number lost before the sample, time, values.
    /// Once it is full, the oldest sample is at index `oldest`.
    history: Vec<u64>,
    oldest: usize,
    /// Capture that has fired and is not complete yet.
    current: Option<Trace>,
}

impl Capture {
    /// Returns a capture of channels with these names and types. Without a condition it starts at
    /// once.
    #[must_use]
    pub fn new(channels: &[(String, Type)], when: Option<When>, setup: Setup) -> Self {
        let mut blank = Trace::default();
        for (name, ty) in channels {
            blank.add(name, *ty);
        }
        let trigger = Trigger::new(when, setup, channels.len());
        let width = channels.len() + 2;
        let before = usize::try_from(trigger.setup().before).unwrap_or(usize::MAX);
        let history = Vec::with_capacity(before.min(AT_ONCE).saturating_mul(width));
        Self { trigger, blank, width, history, oldest: 0, current: None }
    }

    /// Returns the trigger, for forcing, arming and disarming.
    pub const fn trigger(&mut self) -> &mut Trigger {
        &mut self.trigger
    }

    /// Aborts the current capture and arms the trigger again.
    pub fn arm(&mut self) {
        self.current = None;
        self.trigger.arm();
    }

    /// Aborts the current capture and arms the trigger for another condition.
    pub fn arm_for(&mut self, when: Option<When>) {
        self.current = None;
        self.trigger.arm_for(when);
    }

    /// Adds a sample: its time, the value of each channel, and the number of samples lost before
    /// it. Returns a trace if this sample completes one. Its markers give the time and cause of the
    /// trigger.
    pub fn feed(&mut self, time: i64, record: &[u64], lost: u64) -> Option<Trace> {
        let step = self.trigger.feed(time, record);
        if let Some(cause) = step.fired {
            self.begin(cause, time);
        }
        let mut done = None;
        if let Some(trace) = self.current.as_mut().filter(|_| step.kept) {
            trace.lose(lost);
            // If time does not advance or the trace is full, the capture ends with the samples that
            // it has.
            if trace.push(time, record).is_err() || step.complete {
                done = self.current.take();
            }
        }
        self.remember(time, record, lost);
        done
    }

    /// Takes the capture that has fired and is not complete yet.
    pub const fn rest(&mut self) -> Option<Trace> {
        self.current.take()
    }

    /// Returns the samples before a trigger that has not fired yet, as a trace.
    #[must_use]
    pub fn so_far(&self) -> Trace {
        let mut trace = self.blank.clone();
        self.recall(&mut trace);
        trace
    }

    fn begin(&mut self, cause: Cause, time: i64) {
        let mut trace = self.blank.clone();
        self.recall(&mut trace);
        match (cause, self.trigger.when()) {
            (Cause::Condition, Some(when)) => {
                trace.mark(time, &format!("trigger: {}", when.text()));
            }
            (Cause::Condition, None) => {}
            (Cause::Force, _) => trace.mark(time, "trigger: forced"),
            (Cause::Auto, _) => trace.mark(time, "trigger: none came; captured without one"),
        }
        self.current = Some(trace);
    }

    fn recall(&self, trace: &mut Trace) {
        let (new, old) = self.history.split_at(self.oldest * self.width);
        for sample in old.chunks(self.width).chain(new.chunks(self.width)) {
            if let [lost, time, record @ ..] = sample {
                if !trace.is_empty() {
                    trace.lose(*lost);
                }
                // As above: a sample that the trace refuses is dropped.
                let _: Result<(), crate::Refusal> = trace.push(time.cast_signed(), record);
            }
        }
    }

    fn remember(&mut self, time: i64, record: &[u64], lost: u64) {
        let most = usize::try_from(self.trigger.setup().before).unwrap_or(usize::MAX);
        if most == 0 || record.len() + 2 != self.width {
            return;
        }
        let head = [lost, time.cast_unsigned()];
        if self.history.len() / self.width < most {
            self.history.extend(head);
            self.history.extend_from_slice(record);
            return;
        }
        let place = self.history.chunks_mut(self.width).nth(self.oldest);
        for (old, new) in place.into_iter().flatten().zip(head.iter().chain(record)) {
            *old = *new;
        }
        self.oldest = (self.oldest + 1) % most;
    }
}
