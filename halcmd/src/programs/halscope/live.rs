//! Capture from a running machine.

use super::plan::Plan;
use crate::{
    session::remote::{lost_words, pause},
    terminal::termination::ending_flag,
};
use hal_protocol::{Client, Failure, Link, Place, Reply, Request, SampleSpec, Samples, Type};
use hal_trace::{Trace, trigger::Capture};
use signal_hook::{consts::SIGUSR1, flag};
use std::{
    sync::{
        Arc,
        atomic::{AtomicBool, Ordering::Relaxed},
    },
    thread::JoinHandle,
};

/// Interval between two checks for samples, in milliseconds, and number of these intervals between
/// two checks whether the engine still runs.
const WAIT_MS: u32 = 2;
const LOOK_EVERY: u32 = 50;

/// Result of a capture.
pub(super) enum End {
    /// The complete capture.
    Whole(Trace),
    /// A capture that was triggered but ended too early, and the reason.
    Part(Trace, String),
    /// No trigger occurred. The trace holds what was sampled before the machine ended, if it ended.
    Nothing(Option<Trace>, String),
}

/// Result of a poll.
pub(super) enum Polled {
    /// No complete capture yet.
    Nothing,
    /// A complete capture.
    Whole(Trace),
    /// No more samples will come; with the incomplete capture, if any, and the reason.
    Over(Option<Trace>, String),
}

/// Connection that captures samples.
pub(super) struct Live {
    place: Place,
    client: Client,
    samples: Samples,
    capture: Capture,
    /// Channels, under the names that the user wrote.
    asked: Vec<(String, Type)>,
    polls: u32,
    record: Vec<u64>,
    /// Machine time at the start, and the time to wait for a trigger, in nanoseconds.
    began: i64,
    timeout: Option<i64>,
    /// Thread that advances the clock, on a connection of its own.
    running: Option<JoinHandle<Result<(), String>>>,
    /// Reason why the clock was not advanced, if it was not.
    not_run: Option<String>,
    run: Option<u64>,
    ending: Arc<AtomicBool>,
    force: Arc<AtomicBool>,
}

fn told(failure: &Failure) -> String {
    let text = failure.to_string();
    let hint = failure.hint.as_ref().filter(|h| !text.contains(h.as_str()));
    let hint = hint.map(|h| format!("\n{h}")).unwrap_or_default();
    format!("{text}{hint}")
}

impl Live {
    /// Starts to sample.
    pub(super) fn begin(plan: &Plan) -> Result<Self, String> {
        let ending = ending_flag();
        let force = Arc::new(AtomicBool::new(false));
        drop(flag::register(SIGUSR1, Arc::clone(&force)));
        let place = Place::find(plan.instance.as_deref()).map_err(|e| e.to_string())?;
        let connect = || Client::connect_unless(&place, "", Some(ending.clone()));
        let mut client = connect().map_err(|f| told(&f))?;
        let began = machine_time(&mut client)?;
        let spec = SampleSpec {
            thread: plan.thread.clone(),
            every: plan.every,
            depth: plan.depth,
            names: plan.names.clone(),
            wait: true,
        };
        let samples = client.sample(spec).map_err(|f| told(&f))?;
        let info = samples.info();
        let channels = info.channels.iter().map(|c| (c.name.clone(), c.ty));
        let channels: Vec<(String, Type)> = channels.collect();
        let setup = plan.setup(info.period.saturating_mul(i64::from(info.every)))?;
        // A trigger refers to a channel as the user wrote it, for example `sig:x`.
        let mut asked = channels.clone();
        for (channel, name) in asked.iter_mut().zip(plan.whole_names()) {
            name.clone_into(&mut channel.0);
        }
        let when = plan.condition.as_ref().map(|c| c.bind(&asked)).transpose();
        let when = when.map_err(|e| e.to_string())?;
        let capture = Capture::new(&channels, when, setup);
        let running = match plan.run {
            None => None,
            Some(ns) => {
                let mut other = connect().map_err(|f| told(&f))?;
                Some(std::thread::spawn(move || {
                    other.call(Request::Run { ns }).map(drop).map_err(|f| told(&f))
                }))
            }
        };
        Ok(Self {
            place,
            client,
            samples,
            capture,
            asked,
            polls: 0,
            record: Vec::new(),
            began,
            timeout: plan.timeout.map(|ns| i64::try_from(ns).unwrap_or(i64::MAX)),
            running,
            not_run: None,
            run: plan.run,
            ending,
            force,
        })
    }

    /// Polls without waiting. Returns a capture once it is complete, or that no more samples will
    /// come.
    pub(super) fn poll(&mut self) -> Result<Polled, String> {
        // Checked before the samples are read, so that none taken before the end is missed.
        let is_over = self.samples.is_over();
        self.polls = self.polls.wrapping_add(1);
        // The view continues while the engine does not respond.
        let is_lost = self.polls.is_multiple_of(LOOK_EVERY) && self.client.is_gone();
        while let Some(stamp) = self.samples.take_bits(&mut self.record) {
            if let Some(trace) = self.capture.feed(stamp.time, &self.record, stamp.lost) {
                return Ok(Polled::Whole(trace));
            }
        }
        if !is_over && !is_lost {
            return Ok(Polled::Nothing);
        }
        let (why, _) = self.why();
        let rest = self.capture.rest().or_else(|| self.before());
        Ok(Polled::Over(rest, why))
    }

    /// Returns the capture, in order to arm it, force it or change its trigger.
    pub(super) const fn capture(&mut self) -> &mut Capture {
        &mut self.capture
    }

    /// Returns the channels, under the names that a trigger uses.
    pub(super) fn channels(&self) -> &[(String, Type)] {
        &self.asked
    }

    /// Waits for the next capture.
    pub(super) fn next(&mut self) -> Result<End, String> {
        let mut empty = 0;
        let mut is_over = false;
        loop {
            if self.force.swap(false, Relaxed) {
                self.capture.trigger().force();
            }
            if self.ending.load(Relaxed) {
                return Ok(self.interrupted());
            }
            if let Some(stamp) = self.samples.take_bits(&mut self.record) {
                empty = 0;
                let done = self.capture.feed(stamp.time, &self.record, stamp.lost);
                if let Some(trace) = done {
                    return Ok(End::Whole(trace));
                }
                if self.is_late(stamp.time) {
                    return Ok(End::Nothing(None, self.waited()));
                }
                continue;
            }
            if is_over {
                return self.over();
            }
            // Checked before the samples are read, so that none taken before the end is missed.
            is_over = self.samples.is_over() || self.has_run();
            if is_over {
                continue;
            }
            pause(WAIT_MS);
            empty += 1;
            if empty % LOOK_EVERY == 0 {
                match machine_time(&mut self.client) {
                    Ok(now) if self.is_late(now) && self.samples.waiting() == 0 => {
                        return Ok(End::Nothing(None, self.waited()));
                    }
                    Ok(_) => {}
                    // Samples in the ring can still be read.
                    Err(_) => is_over = true,
                }
            }
        }
    }

    /// Ends the sampling, so that the machine continues, and waits until the clock has been
    /// advanced.
    pub(super) fn leave(mut self) {
        let id = self.samples.info().id;
        drop(self.client.end_sample(id));
        if let Some(running) = self.running.take() {
            drop(running.join());
        }
    }

    /// Ends the sampling without waiting for a machine that does not respond.
    pub(super) fn leave_at_once(self) {
        self.ending.store(true, Relaxed);
        self.leave();
    }

    /// Returns whether the time to wait for a trigger has passed.
    fn is_late(&mut self, now: i64) -> bool {
        let waited = now.saturating_sub(self.began);
        self.capture.trigger().is_armed() && self.timeout.is_some_and(|t| waited >= t)
    }

    fn waited(&self) -> String {
        format!("after {} s", self.timeout.unwrap_or(0) as f64 / 1e9)
    }

    /// Returns whether the advance of the clock has finished or failed.
    fn has_run(&mut self) -> bool {
        if !self.running.as_ref().is_some_and(JoinHandle::is_finished) {
            return false;
        }
        if let Some(Ok(Err(why))) = self.running.take().map(JoinHandle::join) {
            self.not_run = Some(why);
        }
        true
    }

    /// Returns why there are no more samples, and whether that is because the machine has ended.
    fn why(&mut self) -> (String, bool) {
        let id = self.samples.info().id;
        let Ok(state) = self.client.sample_state(id) else {
            return (lost_words(&self.place).to_owned(), true);
        };
        let why = match (state.ended, self.not_run.take(), self.run) {
            (Some(why), _, _) | (None, Some(why), _) => why,
            (None, None, Some(ns)) => format!("after {} s", ns as f64 / 1e9),
            (None, None, None) => "sampling ended".to_owned(),
        };
        (why, false)
    }

    /// Returns the result of the capture when no more samples will come.
    fn over(&mut self) -> Result<End, String> {
        let is_refused = self.not_run.is_some();
        let (why, is_lost) = self.why();
        Ok(match self.capture.rest() {
            Some(trace) => End::Part(trace, why),
            None if is_lost => End::Nothing(self.before(), why),
            None if is_refused => return Err(why),
            None => End::Nothing(None, why),
        })
    }

    /// Returns what was sampled before the trigger, if anything.
    fn before(&self) -> Option<Trace> {
        Some(self.capture.so_far()).filter(|trace| !trace.is_empty())
    }

    fn interrupted(&mut self) -> End {
        let why = "interrupted".to_owned();
        match self.capture.rest() {
            Some(trace) => End::Part(trace, why),
            None => End::Nothing(self.before(), why),
        }
    }
}

fn machine_time(client: &mut Client) -> Result<i64, String> {
    match client.call(Request::Status) {
        Ok(Reply::Status(status)) => Ok(i64::try_from(status.time).unwrap_or(i64::MAX)),
        Ok(_) => Err("the engine's answer does not match the request".to_owned()),
        Err(f) => Err(told(&f)),
    }
}
