//! The state of the machine: the snapshots of motion and of the task, as JSON.

use crate::holds::Gates;
use hal_protocol::{Client, Place, Snapshot, Value};
use serde::Serialize;
use serde_json::{Map, Value as Json};
use std::{sync::Arc, thread, time::Duration};
use tokio::sync::watch;

/// Interval between two looks at the snapshots.
const INTERVAL: Duration = Duration::from_millis(50);
/// Looks between two attempts to find an engine, when there is none.
const SEARCH: u32 = 20;
/// Fields whose words are a text.
const TEXTS: &[&str] = &["command", "file", "message", "wait_text"];

/// Progress of the connection to the engine.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub(crate) enum Joined {
    /// The engine answers.
    Joined,
    /// The engine has ended.
    #[default]
    Gone,
}

/// State of the machine.
#[derive(Clone, Debug, Default)]
pub(crate) struct Machine {
    pub(crate) engine: Joined,
    pub(crate) motion: Option<Map<String, Json>>,
    pub(crate) task: Option<Map<String, Json>>,
    /// Pins that hold feeds.
    pub(crate) gates: Gates,
}

/// Starts the thread that looks at the snapshots.
pub(crate) fn observe(place: &Place) -> Result<watch::Receiver<Arc<Machine>>, String> {
    let mut client = Client::connect(place, "").map_err(|e| e.to_string())?;
    let (out, seen) = watch::channel(Arc::default());
    let look = move || {
        let mut pages = [None, None];
        for n in 0_u32.. {
            if out.is_closed() || client.is_gone() {
                break;
            }
            if n.is_multiple_of(SEARCH) {
                for (page, name) in pages.iter_mut().zip(["motion.status", "task.status"]) {
                    if page.is_none() {
                        *page = client.snapshot(name).ok().map(Page::new);
                    }
                }
            }
            let [motion, task] = pages.each_mut().map(|page| page.as_mut().and_then(Page::read));
            let gates = Gates::read(&mut client, motion.as_ref());
            out.send_replace(Arc::new(Machine { engine: Joined::Joined, motion, task, gates }));
            pause(INTERVAL);
        }
        out.send_replace(Arc::default());
    };
    let begun = thread::Builder::new().name("status".to_owned()).spawn(look);
    begun.map_err(|e| hal_output::reason(&e))?;
    Ok(seen)
}

#[expect(
    clippy::disallowed_methods,
    reason = "people look while the engine's clock stands still, too"
)]
fn pause(time: Duration) {
    thread::sleep(time);
}

/// A snapshot with its last record.
struct Page {
    snapshot: Snapshot,
    values: Vec<Value>,
}

impl Page {
    const fn new(snapshot: Snapshot) -> Self {
        Self { snapshot, values: Vec::new() }
    }

    /// Returns the latest record, or `None` where the component does not end it.
    fn read(&mut self) -> Option<Map<String, Json>> {
        self.snapshot.wait(&mut self.values)?;
        let mut values = self.values.as_slice();
        let fields = self.snapshot.info().fields.iter();
        let object = fields.map(|field| {
            let count = values.len().min(field.count as usize);
            let (words, rest) = values.split_at(count);
            values = rest;
            let value = if TEXTS.contains(&field.name.as_str()) {
                Snapshot::text(words).into()
            } else if field.count == 1 {
                words.first().map(number).unwrap_or_default()
            } else {
                words.iter().map(number).collect()
            };
            (field.name.clone(), value)
        });
        Some(object.collect())
    }
}

/// Returns a value as JSON; numbers beyond JSON's are texts.
pub(crate) fn number(value: &Value) -> Json {
    match *value {
        Value::Bit(b) => b.into(),
        Value::Float(f) if f.is_finite() => f.into(),
        Value::S32(i) => i.into(),
        Value::U32(u) => u.into(),
        // Beyond 2^53 a browser would round them.
        Value::S64(i) if i.unsigned_abs() < 1 << 53 => i.into(),
        Value::U64(u) | Value::Port(u) if u < 1 << 53 => u.into(),
        other => other.to_string().into(),
    }
}

/// Returns the fields of `now` that differ from those of `before`.
pub(crate) fn changes(
    before: Option<&Map<String, Json>>,
    now: Option<&Map<String, Json>>,
) -> Option<Json> {
    let Some(now) = now else { return before.map(|_| Json::Null) };
    let Some(before) = before else { return Some(now.clone().into()) };
    let changed = now.iter().filter(|(name, value)| before.get(*name) != Some(*value));
    let changed: Map<_, _> = changed.map(|(name, value)| (name.clone(), value.clone())).collect();
    (!changed.is_empty()).then(|| changed.into())
}
