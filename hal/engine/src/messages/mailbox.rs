//! Realtime. Component messages on their way to the control side: rings of fixed size, in which a
//! component that floods leaves room for the others.

use crate::sync::{AtomicBool, AtomicU8, AtomicU32, AtomicU64, Ordering};
use crossbeam::queue::ArrayQueue;
use hal_abi::Str;

/// Capacities of the rings of messages and of texts.
const MESSAGES: usize = 4096;
const TEXTS: usize = 512;

/// Number of messages that a component may have waiting for each free place. A component that
/// floods is stopped while places are left: one such component takes three quarters of the ring,
/// `n` of them leave one place in `3n + 1`.
const SHARE: usize = 3;

/// A message: a static text with numbers.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Message {
    /// Machine time in nanoseconds.
    pub(crate) at: i64,
    pub(crate) level: u8,
    pub(crate) component: u32,
    pub(crate) text: Str,
    pub(crate) numbers: [f64; 8],
    pub(crate) n: usize,
}

/// A text that a component formatted at run time.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Spoken {
    /// Machine time in nanoseconds.
    pub(crate) at: i64,
    pub(crate) level: u8,
    pub(crate) component: u32,
    len: u16,
    bytes: [u8; 240],
}

impl Spoken {
    /// Creates a text; one that is too long is cut.
    pub(crate) fn new(at: i64, level: u8, component: u32, text: &str) -> Self {
        let mut m = Self { at, level, component, len: 0, bytes: [0; 240] };
        for (place, b) in m.bytes.iter_mut().zip(text.bytes()) {
            *place = b;
            m.len += 1;
        }
        m
    }

    /// Returns the bytes of the text.
    pub(crate) fn bytes(&self) -> &[u8] {
        self.bytes.get(..usize::from(self.len)).unwrap_or_default()
    }
}

/// The counts of one component's messages.
#[derive(Debug, Default)]
pub(crate) struct Voice {
    /// Number of waiting messages.
    messages: AtomicU32,
    /// Number of waiting texts.
    texts: AtomicU32,
    /// Number of messages and texts that found no room.
    lost: AtomicU64,
}

impl Voice {
    /// Control side: returns the number of messages that found no room since the last call.
    pub(crate) fn take_lost(&self) -> u64 {
        self.lost.swap(0, Ordering::Relaxed)
    }

    /// Control side: counts a message as taken.
    pub(crate) fn heard(&self) {
        self.messages.fetch_sub(1, Ordering::Relaxed);
    }

    /// Control side: counts a text as taken.
    pub(crate) fn heard_text(&self) {
        self.texts.fetch_sub(1, Ordering::Relaxed);
    }
}

/// The rings of an instance.
#[derive(Debug)]
pub(crate) struct Mailbox {
    messages: ArrayQueue<Message>,
    texts: ArrayQueue<Spoken>,
    /// True if messages have found no room since the control side last checked.
    has_lost: AtomicBool,
    /// Highest level of messages that are kept.
    pub(crate) level: AtomicU8,
}

impl Mailbox {
    pub(crate) fn new() -> Self {
        Self {
            messages: ArrayQueue::new(MESSAGES),
            texts: ArrayQueue::new(TEXTS),
            has_lost: AtomicBool::new(false),
            level: AtomicU8::new(hal_abi::level::ERR),
        }
    }

    /// Returns whether messages of a level are kept.
    pub(crate) fn keeps(&self, level: u8) -> bool {
        level <= self.level.load(Ordering::Relaxed)
    }

    /// Keeps a message for the control side, or counts it as lost.
    pub(crate) fn send(&self, voice: &Voice, m: Message) {
        if !push(&self.messages, &voice.messages, m) {
            self.lose(voice);
        }
    }

    /// Keeps a text for the control side, or counts it as lost.
    pub(crate) fn say_text(&self, voice: &Voice, m: Spoken) {
        if !push(&self.texts, &voice.texts, m) {
            self.lose(voice);
        }
    }

    fn lose(&self, voice: &Voice) {
        voice.lost.fetch_add(1, Ordering::Relaxed);
        self.has_lost.store(true, Ordering::Relaxed);
    }

    /// Control side: removes and returns the oldest message.
    pub(crate) fn message(&self) -> Option<Message> {
        self.messages.pop()
    }

    /// Control side: removes and returns the oldest text.
    pub(crate) fn text(&self) -> Option<Spoken> {
        self.texts.pop()
    }

    /// Control side: returns whether messages found no room since the last call.
    pub(crate) fn take_lost(&self) -> bool {
        self.has_lost.swap(false, Ordering::Relaxed)
    }

    /// Returns whether the control side should take messages before more cycles run.
    pub(crate) fn is_filling(&self) -> bool {
        self.messages.len() >= MESSAGES / 4 || self.texts.len() >= TEXTS / 4
    }
}

/// Appends a message, unless the component has more than its share of the free room.
fn push<T>(queue: &ArrayQueue<T>, waiting: &AtomicU32, message: T) -> bool {
    let free = queue.capacity().saturating_sub(queue.len());
    let own = waiting.fetch_add(1, Ordering::Relaxed) as usize;
    if own < SHARE * free && queue.push(message).is_ok() {
        return true;
    }
    waiting.fetch_sub(1, Ordering::Relaxed);
    false
}

#[cfg(test)]
mod tests {
    use super::*;

    fn message(component: u32) -> Message {
        let text = Str::new("full");
        Message { at: 0, level: 1, component, text, numbers: [0.0; 8], n: 0 }
    }

    /// A component that rarely sends a message is heard, however many others flood.
    #[test]
    fn floods_leave_room() {
        for floods in [1, 2, 10, 500] {
            let mailbox = Mailbox::new();
            let voices: Vec<Voice> = (0..floods).map(|_| Voice::default()).collect();
            for _ in 0..2 * MESSAGES {
                for (n, voice) in (0..).zip(&voices) {
                    mailbox.send(voice, message(n));
                }
            }
            let quiet = Voice::default();
            mailbox.send(&quiet, message(1000));
            assert_eq!(quiet.take_lost(), 0, "beside {floods}");
            // Each message is either lost or present, and all components have about equally many
            // present.
            let mut there = vec![0; floods];
            let mut heard = false;
            while let Some(m) = mailbox.message() {
                match there.get_mut(m.component as usize) {
                    Some(n) => *n += 1,
                    None => heard = true,
                }
            }
            assert!(heard);
            let total: u64 = voices.iter().zip(&there).map(|(v, n)| v.take_lost() + n).sum();
            assert_eq!(total, 2 * (MESSAGES * floods) as u64);
            let (least, most) = (there.iter().min().unwrap(), there.iter().max().unwrap());
            assert!(most - least <= 1 + most / 2, "{least} to {most} of {floods}");
        }
    }

    #[test]
    fn room_is_given_back() {
        let (mailbox, voice) = (Mailbox::new(), Voice::default());
        for _ in 0..10 {
            for _ in 0..1000 {
                mailbox.send(&voice, message(0));
            }
            assert!(mailbox.is_filling() == (mailbox.messages.len() >= 1024));
            while mailbox.message().is_some() {
                voice.heard();
            }
        }
        assert_eq!(voice.take_lost(), 0);
        assert!(!mailbox.take_lost());
    }
}
