//! The log of an instance: messages of components, and of the engine, until they are read.

use crate::{
    graph::{Graph, Ix},
    messages::join::{Joiner, LogLine, Said, kind_of},
    messages::mailbox::{Message, Spoken, Voice},
    name::Name,
    realtime::shared::Shared,
    sync::Arc,
};
use hal_abi::level;
use std::collections::{BTreeMap, VecDeque};

/// Largest number of lines that are kept until they are read.
const KEPT: usize = 1000;

/// Message about messages of a component that found no room.
const LOST: &str = "{} messages were lost: too many at once";

/// A message or a text, as the rings hold them.
enum Heard {
    Message(Message),
    Text(Spoken),
}

impl Heard {
    const fn at(&self) -> i64 {
        match self {
            Self::Message(m) => m.at,
            Self::Text(m) => m.at,
        }
    }
}

/// The messages of an instance.
#[derive(Debug, Default)]
pub(crate) struct Log {
    lines: VecDeque<String>,
    /// Number of older messages that were discarded.
    dropped: u64,
    joiner: Joiner,
    /// Message counts of each component, by the component's number.
    voices: BTreeMap<u32, Arc<Voice>>,
    /// The component that was removed last: messages of it may still arrive.
    departed: Option<(u32, Name)>,
}

impl Log {
    /// Logs a message of the engine itself.
    pub(crate) fn notice(&mut self, text: String) {
        tracing::warn!("{text}");
        self.keep(text);
    }

    /// Takes the messages since the last call.
    pub(crate) fn take(&mut self) -> Vec<String> {
        let dropped = core::mem::take(&mut self.dropped);
        let first = (dropped > 0).then(|| format!("{dropped} older messages are not kept"));
        first.into_iter().chain(self.lines.drain(..)).collect()
    }

    /// Starts counting the messages of a component.
    pub(crate) fn listen_to(&mut self, component: u32, voice: Arc<Voice>) {
        self.voices.insert(component, voice);
    }

    /// Logs the joined messages of a component that is about to be removed, and forgets its counts.
    pub(crate) fn end_of(&mut self, component: u32) {
        self.end_joins(Some(component));
        self.voices.remove(&component);
    }

    /// Records the component that was removed last.
    pub(crate) fn has_gone(&mut self, component: Option<(u32, Name)>) {
        self.departed = component;
    }

    /// Logs the joined messages of a component, or of all, that are not due yet.
    pub(crate) fn end_joins(&mut self, component: Option<u32>) {
        let mut lines = Vec::new();
        self.joiner.end(component, &mut lines);
        self.log(lines);
    }

    /// Logs the messages of components. `left` are components without a name that may still send
    /// some.
    pub(crate) fn drain_messages(&mut self, shared: &Shared, graph: &Graph, left: &[Ix]) {
        let mut heard = Vec::new();
        while let Some(m) = shared.mailbox.message() {
            self.voices.get(&m.component).inspect(|voice| voice.heard());
            heard.push(Heard::Message(m));
        }
        while let Some(m) = shared.mailbox.text() {
            self.voices.get(&m.component).inspect(|voice| voice.heard_text());
            heard.push(Heard::Text(m));
        }
        // Each ring is ordered only by itself.
        heard.sort_by_key(Heard::at);
        let mut lines = Vec::new();
        let mut joiner = core::mem::take(&mut self.joiner);
        let sender = |component| self.name_of(component, graph, left);
        for m in heard {
            match m {
                Heard::Message(m) => {
                    // SAFETY: static in a library that is open: messages are read before it is
                    // closed.
                    let text = unsafe { m.text.get() }.unwrap_or("?");
                    let text = graph.with_wiring(text);
                    let by = (m.component, sender(m.component));
                    let said = Said::Numbers(m.numbers.iter().take(m.n).copied().collect());
                    joiner.add(m.at, by, (m.level, &text), said, &mut lines);
                }
                Heard::Text(m) => {
                    let text = String::from_utf8_lossy(m.bytes()).trim_end().to_owned();
                    let by = (m.component, sender(m.component));
                    let site = kind_of(&text);
                    joiner.add(m.at, by, (m.level, &site), Said::Whole(text), &mut lines);
                }
            }
        }
        let now = shared.now();
        if shared.mailbox.take_lost() {
            for (component, voice) in &self.voices {
                let lost = voice.take_lost();
                if lost > 0 {
                    let by = (*component, sender(*component));
                    joiner.add(now, by, (level::WARN, LOST), Said::Count(lost), &mut lines);
                }
            }
        }
        joiner.pass(now, &mut lines);
        self.joiner = joiner;
        self.log(lines);
    }

    fn log(&mut self, lines: Vec<LogLine>) {
        for line in lines {
            let (text, component) = (line.text, line.component.as_str());
            match line.level {
                level::ERR => tracing::error!(component, "{text}"),
                level::WARN => tracing::warn!(component, "{text}"),
                level::NOTICE | level::INFO => tracing::info!(component, "{text}"),
                _ => tracing::debug!(component, "{text}"),
            }
            self.keep(text);
        }
    }

    fn keep(&mut self, text: String) {
        if self.lines.len() >= KEPT {
            self.lines.pop_front();
            self.dropped += 1;
        }
        self.lines.push_back(text);
    }

    fn name_of<'n>(&'n self, component: u32, graph: &'n Graph, left: &[Ix]) -> &'n str {
        let components = graph.components.values().chain(left);
        components
            .filter_map(|ix| graph.component(*ix))
            .find(|c| c.id == component)
            .map(|c| &c.name)
            .or_else(|| self.departed.as_ref().filter(|(id, _)| *id == component).map(|(_, n)| n))
            .map_or("?", Name::as_str)
    }
}
