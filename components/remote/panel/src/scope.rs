//! The scope: samples of the engine around a trigger, or as a stream, for one client.

use crate::{
    error::{Code, Error},
    pool::Seat,
};
use hal_protocol::{Client, Place, SampleSpec, Samples, Type, Value};
use hal_trace::{
    Trace,
    trigger::{Capture, Condition, HoldOff, Mode, Setup},
};
use serde::Deserialize;
use serde_json::{Value as Json, json};
use std::{
    collections::{BTreeSet, VecDeque},
    sync::mpsc::{Receiver, RecvTimeoutError, SyncSender, sync_channel},
    thread,
    time::Duration,
};
use tokio::sync::{OwnedSemaphorePermit, mpsc};

/// Number of scopes that run at the same time.
pub(crate) const MAX_SCOPES: usize = 8;
/// Number of channels of a scope.
const MAX_CHANNELS: usize = 16;
/// Longest name in bytes.
const MAX_NAME: usize = 256;
/// Longest condition of a trigger in bytes.
const MAX_CONDITION: usize = 1024;
/// Number of values in a capture.
const MAX_VALUES: f64 = 200_000.0;
/// Longest capture in seconds.
const MAX_SECONDS: f64 = 600.0;
/// Largest distance between samples in cycles.
const MAX_EVERY: u32 = 1_000_000;
/// Wait between two looks at the ring.
const LOOK: Duration = Duration::from_millis(20);
/// Machine time of a part of a stream, and least between two triggers, in nanoseconds.
const PART_NS: i64 = 50_000_000;
/// Least machine time without a trigger after which a capture begins by itself, in nanoseconds.
const AUTO_NS: i64 = 500_000_000;
/// Number of parts of a stream that wait for a client that reads slowly.
const MAX_PARTS: usize = 20;

/// Samples that a client wants.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Wanted {
    /// Pins, parameters and signals.
    names: Vec<String>,
    /// Thread after whose cycles values are taken; the fastest without it.
    #[serde(default)]
    thread: Option<String>,
    /// Take values after every n-th cycle.
    #[serde(default)]
    every: u32,
    /// Length of a capture in seconds of machine time.
    seconds: f64,
    #[serde(default)]
    trigger: Option<TriggerSpec>,
}

/// Trigger that a client wants.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct TriggerSpec {
    /// Condition, as `halscope` reads it.
    when: String,
    /// Seconds before the trigger.
    #[serde(default)]
    before: f64,
    /// Capture without the trigger where it does not come.
    #[serde(default)]
    auto: bool,
}

/// A scope that runs. It ends when this is dropped.
pub(crate) struct Scope {
    /// Messages for the client.
    pub(crate) samples: mpsc::Receiver<Json>,
    _end: SyncSender<()>,
    /// Places among all scopes and among the client's own work, which the next scope of the client may take at once.
    _places: (OwnedSemaphorePermit, Seat),
}

impl Scope {
    /// Starts a scope. Its description, or why there is none, is the answer.
    pub(crate) fn start(
        place: Place,
        id: u64,
        wanted: Wanted,
        answers: mpsc::Sender<Json>,
        places: (OwnedSemaphorePermit, Seat),
    ) -> Result<Self, Error> {
        let condition = wanted.check()?;
        let (out, samples) = mpsc::channel(1);
        let (end, ended) = sync_channel(0);
        let sample = move || {
            let answer = match Live::begin(&place, wanted, condition.as_ref()) {
                Ok(mut live) => {
                    let ok = live.description();
                    drop(answers.try_send(json!({ "type": "reply", "id": id, "ok": ok })));
                    live.run(id, &out, &ended);
                    None
                }
                Err(e) => Some(json!({ "type": "reply", "id": id, "error": e })),
            };
            // A client that reads no answers gets none.
            answer.map(|answer| answers.try_send(answer).is_ok());
        };
        let begun = thread::Builder::new().name("scope".to_owned()).spawn(sample);
        begun.map_err(|e| Error::new(Code::Refused, hal_output::reason(&e)))?;
        Ok(Self { samples, _end: end, _places: places })
    }
}

impl Wanted {
    /// Checks all that needs no engine; returns the trigger's condition.
    fn check(&self) -> Result<Option<Condition>, Error> {
        let malformed = |text: String| Err(Error::new(Code::Malformed, text));
        if self.names.is_empty() {
            return malformed("names is empty".to_owned());
        }
        if self.names.len() > MAX_CHANNELS || self.names.iter().any(|n| n.len() > MAX_NAME) {
            let text = format!("at most {MAX_CHANNELS} names of {MAX_NAME} bytes");
            return Err(Error::new(Code::TooLarge, text));
        }
        if let Some(name) = self.names.iter().find(|name| name.contains(['*', '?', '['])) {
            return malformed(format!("'{name}' is a pattern: the scope takes names"));
        }
        if !(self.seconds > 0.0 && self.seconds <= MAX_SECONDS) {
            return malformed(format!("seconds is {}, up to {MAX_SECONDS}", self.seconds));
        }
        if self.every > MAX_EVERY {
            return malformed(format!("every is {}, up to {MAX_EVERY}", self.every));
        }
        let Some(wish) = &self.trigger else { return Ok(None) };
        if !(0.0..=self.seconds).contains(&wish.before) {
            return malformed(format!("before is {}, 0 to {} seconds", wish.before, self.seconds));
        }
        if wish.when.len() > MAX_CONDITION {
            let text = format!("a condition has at most {MAX_CONDITION} bytes");
            return Err(Error::new(Code::TooLarge, text));
        }
        let condition = Condition::parse(&wish.when);
        condition.map(Some).map_err(|e| Error::new(Code::Malformed, e.to_string()))
    }

    /// Returns all names, those of the trigger too, each once.
    fn channels(&self, condition: Option<&Condition>) -> Vec<String> {
        let of_trigger = condition.map(Condition::names).unwrap_or_default();
        let all = self.names.iter().map(String::as_str).chain(of_trigger);
        let mut known = BTreeSet::new();
        all.filter(|name| known.insert(*name)).map(str::to_owned).collect()
    }

    /// Returns the settings of a capture with this distance between samples.
    fn setup(&self, distance_ns: i64, channels: usize) -> Result<Setup, Error> {
        let samples = |seconds: f64| (seconds * 1e9 / distance_ns.max(1) as f64).ceil();
        let length = samples(self.seconds).max(1.0);
        if length * channels as f64 > MAX_VALUES {
            let text =
                format!("{length} samples of {channels} values: at most {MAX_VALUES} in all");
            return Err(Error::new(Code::TooLarge, text));
        }
        let setup = Setup { length: whole(length), ..Setup::default() };
        Ok(match &self.trigger {
            None => {
                let part = (PART_NS as f64 / distance_ns.max(1) as f64).ceil().max(1.0);
                Setup { length: whole(part.min(length)), mode: Mode::Normal, ..setup }
            }
            Some(wish) => {
                let before = whole(samples(wish.before)).min(setup.length - 1);
                let all = distance_ns.saturating_mul(setup.length.cast_signed());
                let mode = if wish.auto { Mode::Auto(all.max(AUTO_NS)) } else { Mode::Normal };
                Setup { before, mode, hold_off: HoldOff::Time(PART_NS), ..setup }
            }
        })
    }
}

/// Returns a number of samples, which `MAX_VALUES` bounds.
#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "0 to 200000")]
fn whole(samples: f64) -> u64 {
    samples.min(MAX_VALUES) as u64
}

/// The thread of a scope: takes samples from the ring, and makes messages of them.
struct Live {
    client: Client,
    samples: Samples,
    capture: Capture,
    channels: Vec<(String, Type)>,
    has_trigger: bool,
    /// Captures that wait to be sent.
    ready: VecDeque<Trace>,
    captures: u64,
    /// Samples that were not sent, and all lost samples that the client knows of.
    dropped: u64,
    told: u64,
}

impl Live {
    fn begin(place: &Place, wanted: Wanted, condition: Option<&Condition>) -> Result<Self, Error> {
        let mut client = Client::connect(place, "").map_err(Error::from)?;
        let names = wanted.channels(condition);
        let spec = SampleSpec {
            thread: wanted.thread.clone(),
            every: wanted.every,
            names: names.clone(),
            ..SampleSpec::default()
        };
        let samples = client.sample(spec).map_err(Error::from)?;
        let info = samples.info();
        // A trigger refers to a channel as the client wrote it, for example `sig:x`.
        let types = info.channels.iter().map(|channel| channel.ty);
        let channels: Vec<_> = names.into_iter().zip(types).collect();
        let distance = info.period.saturating_mul(i64::from(info.every.max(1)));
        let setup = wanted.setup(distance, channels.len())?;
        let when = condition.map(|c| c.bind(&channels)).transpose();
        let when = when.map_err(|e| Error::new(Code::Malformed, e.to_string()))?;
        let has_trigger = when.is_some();
        let capture = Capture::new(&channels, when, setup);
        Ok(Self {
            client,
            samples,
            capture,
            channels,
            has_trigger,
            ready: VecDeque::new(),
            captures: 0,
            dropped: 0,
            told: 0,
        })
    }

    /// Describes the samples.
    fn description(&self) -> Json {
        let info = self.samples.info();
        let distance = info.period as f64 * f64::from(info.every.max(1));
        let (names, types): (Vec<_>, Vec<_>) =
            self.channels.iter().map(|(name, ty)| (name.as_str(), ty.name())).unzip();
        json!({ "thread": info.thread, "period": distance / 1e9, "names": names, "types": types })
    }

    /// Sends samples until the client ends the scope, or there are no more.
    fn run(&mut self, id: u64, out: &mpsc::Sender<Json>, ended: &Receiver<()>) {
        let mut record = Vec::new();
        while ended.recv_timeout(LOOK) == Err(RecvTimeoutError::Timeout) {
            // Before the samples are read, so that none taken before the end is missed.
            let is_over = self.samples.is_over() || self.client.is_gone();
            // No more than the ring holds: a busy thread fills it while it is read.
            for _ in 0..self.samples.info().depth {
                let Some(stamp) = self.samples.take_bits(&mut record) else { break };
                if let Some(trace) = self.capture.feed(stamp.time, &record, stamp.lost) {
                    self.keep(trace);
                }
            }
            if let Ok(place) = out.try_reserve()
                && let Some(trace) = self.ready.pop_front()
            {
                let message = self.message(id, &trace);
                place.send(message);
            }
            if is_over {
                let state = self.client.sample_state(self.samples.info().id);
                let why = state.ok().and_then(|state| state.ended);
                let why = why.unwrap_or_else(|| "the engine has ended".to_owned());
                drop(out.blocking_send(json!({ "type": "samples", "id": id, "ended": why })));
                return;
            }
        }
    }

    /// Keeps a capture until it is sent. A client that reads slowly misses the oldest.
    fn keep(&mut self, trace: Trace) {
        let most = if self.has_trigger { 1 } else { MAX_PARTS };
        if self.ready.len() == most
            && let Some(old) = self.ready.pop_front()
            && !self.has_trigger
        {
            self.dropped += old.len() as u64;
        }
        self.ready.push_back(trace);
    }

    fn message(&mut self, id: u64, trace: &Trace) -> Json {
        self.captures += 1;
        let lost = self.samples.lost() + self.dropped;
        let new = lost - self.told;
        self.told = lost;
        let first = trace.times().first().unwrap_or(0);
        let after = |time: i64| time.saturating_sub(first) as f64 / 1e9;
        let times: Vec<f64> = trace.times().iter().map(after).collect();
        let columns: Vec<Vec<Json>> = trace
            .channels()
            .iter()
            .map(|channel| (0..trace.len()).map(|n| json(channel.value(n))).collect())
            .collect();
        let trigger = trace.markers().first().map(|marker| after(marker.at));
        json!({
            "type": "samples", "id": id, "capture": self.captures, "start": first as f64 / 1e9,
            "times": times, "trigger": trigger, "lost": new, "columns": columns,
        })
    }
}

/// Returns a value as a number; `null` if it is not finite.
fn json(value: Option<Value>) -> Json {
    match value {
        Some(Value::Bit(on)) => u8::from(on).into(),
        Some(Value::S64(n)) => (n as f64).into(),
        Some(Value::U64(n) | Value::Port(n)) => (n as f64).into(),
        Some(value) => crate::status::number(&value).as_f64().into(),
        None => Json::Null,
    }
}
