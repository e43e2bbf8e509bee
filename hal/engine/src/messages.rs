//! Messages of components and of the engine: the control side takes them, joins those of the same
//! site, logs them, and keeps them until they are read.

pub(crate) mod join;
pub(crate) mod mailbox;
pub(crate) mod text;

use crate::{
    Engine,
    messages::join::{Said, kind_of},
    messages::mailbox::{Message, Spoken, Voice},
    name::Name,
    sync::Arc,
};
use hal_abi::level;

/// Largest number of lines that are kept until they are read.
const KEPT: usize = 1000;

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

impl Engine {
    /// Logs a message of the engine itself.
    pub(crate) fn notice(&mut self, text: String) {
        tracing::warn!("{text}");
        self.keep_message(text);
    }

    /// Returns the messages of components and of the engine since the last call. They are logged as
    /// well.
    pub fn take_messages(&mut self) -> Vec<String> {
        self.hear();
        let dropped = core::mem::take(&mut self.dropped_messages);
        let first = (dropped > 0).then(|| format!("{dropped} older messages are not kept"));
        first.into_iter().chain(self.messages.drain(..)).collect()
    }

    fn keep_message(&mut self, text: String) {
        if self.messages.len() >= KEPT {
            self.messages.pop_front();
            self.dropped_messages += 1;
        }
        self.messages.push_back(text);
    }

    /// Starts counting the messages of a component.
    pub(crate) fn listen_to(&mut self, component: u32, voice: Arc<Voice>) {
        self.voices.insert(component, voice);
    }

    /// Logs the last messages of a component that is about to be removed.
    pub(crate) fn hear_last_of(&mut self, component: u32) {
        self.hear();
        self.end_joins(Some(component));
        self.voices.remove(&component);
    }

    /// Logs the joined messages of a component, or of all, that are not due yet.
    pub(crate) fn end_joins(&mut self, component: Option<u32>) {
        let mut lines = Vec::new();
        self.joiner.end(component, &mut lines);
        self.log(lines);
    }

    /// Logs the messages of components.
    pub(crate) fn hear(&mut self) {
        let mut heard = Vec::new();
        while let Some(m) = self.shared.mailbox.message() {
            self.voices.get(&m.component).inspect(|voice| voice.heard());
            heard.push(Heard::Message(m));
        }
        while let Some(m) = self.shared.mailbox.text() {
            self.voices.get(&m.component).inspect(|voice| voice.heard_text());
            heard.push(Heard::Text(m));
        }
        // Each ring is ordered only by itself.
        heard.sort_by_key(Heard::at);
        let mut lines = Vec::new();
        let mut joiner = core::mem::take(&mut self.joiner);
        for m in heard {
            match m {
                Heard::Message(m) => {
                    // SAFETY: static in a library that is open: messages are read before it is
                    // closed.
                    let text = unsafe { m.text.get() }.unwrap_or("?");
                    let text = self.with_wiring(text);
                    let by = (m.component, self.speaker(m.component));
                    let said = Said::Numbers(m.numbers.iter().take(m.n).copied().collect());
                    joiner.say(m.at, by, (m.level, &text), said, &mut lines);
                }
                Heard::Text(m) => {
                    let text = String::from_utf8_lossy(m.bytes()).trim_end().to_owned();
                    let by = (m.component, self.speaker(m.component));
                    let site = kind_of(&text);
                    joiner.say(m.at, by, (m.level, &site), Said::Whole(text), &mut lines);
                }
            }
        }
        let now = self.shared.now();
        if self.shared.mailbox.take_lost() {
            for (component, voice) in &self.voices {
                let lost = voice.take_lost();
                if lost > 0 {
                    let by = (*component, self.speaker(*component));
                    joiner.say(now, by, (level::WARN, LOST), Said::Count(lost), &mut lines);
                }
            }
        }
        joiner.pass(now, &mut lines);
        self.joiner = joiner;
        self.log(lines);
    }

    fn log(&mut self, lines: Vec<join::Line>) {
        for line in lines {
            let text = line.text;
            match line.level {
                level::ERR => tracing::error!("{text}"),
                level::WARN => tracing::warn!("{text}"),
                0 | level::INFO => tracing::info!("{text}"),
                _ => tracing::debug!("{text}"),
            }
            self.keep_message(text);
        }
    }

    fn speaker(&self, component: u32) -> &str {
        let components = self.graph.components.values().chain(&self.left);
        components
            .filter_map(|ix| self.graph.component(*ix))
            .find(|c| c.id == component)
            .map(|c| &c.name)
            .or_else(|| self.gone.as_ref().filter(|(id, _)| *id == component).map(|(_, n)| n))
            .map_or("?", Name::as_str)
    }
}

const LOST: &str = "{} messages were lost: too many at once";
