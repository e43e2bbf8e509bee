//! Pages of shared memory through which clients exchange the values of their pins.
//!
//! The engine believes nothing that a client writes there. A page that the client is writing, or has
//! left half written, is taken at a later exchange.

use crate::{
    Engine, Error,
    graph::{Graph, Item, Ix},
    observe::ring::Sealed,
    os,
    serve::client::Client,
    sync::Ordering,
};
use hal_abi::{Page, PageReader, PageWriter};
use hal_protocol::{Direction, PinPageInfo, Type, Value};
use std::os::fd::OwnedFd;

/// The engine's side of a page.
#[derive(Debug)]
pub(crate) struct Shared {
    sealed: Sealed,
    pins: u32,
    writer: PageWriter,
    reader: PageReader,
    /// Sequence number of the client's half when it was last taken.
    taken: u64,
    /// For each pin, the number of the client's writes that the engine has taken.
    counts: Vec<u64>,
    /// Copy of the client's half.
    copy: Vec<u64>,
    /// Words that the engine published last, and its next words.
    published: Vec<u64>,
    next: Vec<u64>,
    /// Machine time of the next exchange on the real clock.
    due: i64,
}

// SAFETY: the mapping belongs to this value, and its words are atomics.
unsafe impl Send for Shared {}

impl Shared {
    /// Creates a page, in place of the one that the client had before.
    pub(crate) fn new(info: &PinPageInfo, before: Option<&Self>) -> Result<Self, Error> {
        let sealed = Sealed::shared("hal-pins", info.bytes()).map_err(|e| refused(&e))?;
        let words = info.pins * 2;
        let (first, second) =
            (sealed.address.cast::<Page>(), sealed.address.wrapping_byte_add(info.second()));
        let second = second.cast::<Page>();
        for half in [first, second] {
            // SAFETY: mapped, page-aligned, not yet shared. The words after it are zero.
            unsafe { half.write(Page::new(0, words)) };
        }
        let mut counts = before.map(|page| page.counts.clone()).unwrap_or_default();
        counts.resize(info.pins as usize, 0);
        Ok(Self {
            // SAFETY: mapped with this number of words as long as this value lives; the client is not believed to
            // leave this half alone, but nothing that it holds is read back.
            writer: unsafe { PageWriter::new(first, words) },
            // SAFETY: as above.
            reader: unsafe { PageReader::new(second, words) },
            sealed,
            pins: info.pins,
            taken: 0,
            counts,
            copy: vec![0; words as usize],
            published: Vec::new(),
            next: Vec::with_capacity(words as usize),
            due: 0,
        })
    }

    /// Returns the page's descriptor, for the client.
    pub(crate) fn file(&self) -> Result<OwnedFd, Error> {
        self.sealed.fd.try_clone().map_err(|e| refused(&e))
    }

    fn sequence(&self) -> u64 {
        let half = self.sealed.address.wrapping_byte_add(self.info().second()).cast::<Page>();
        // SAFETY: the client's half, mapped as long as this value lives.
        unsafe { &(*half).sequence }.load(Ordering::Acquire) // Pairs with the client's `seqlock::end`.
    }

    const fn info(&self) -> PinPageInfo {
        PinPageInfo { pins: self.pins, is_virtual: false }
    }

    /// Sets the pins that the client has written since the last exchange.
    fn take(&mut self, graph: &Graph, pins: &[Ix]) {
        if self.sequence() == self.taken {
            return;
        }
        let copy = &mut self.copy;
        let copied = self.reader.copy(|i, bits| {
            if let Some(word) = copy.get_mut(i) {
                *word = bits;
            }
        });
        let Some(sequence) = copied else { return };
        self.taken = sequence;
        let pairs = self.copy.as_chunks().0.iter().zip(&mut self.counts);
        for (ix, ([bits, count], taken)) in pins.iter().zip(pairs) {
            if count == taken {
                continue;
            }
            *taken = *count;
            if let Some(item) = graph.item(*ix).filter(|item| may_write(graph, *ix, item)) {
                item.put(Value::from_bits(item.ty, *bits).bits());
            }
        }
    }

    /// Publishes the values of the client's pins.
    pub(crate) fn publish(&mut self, graph: &Graph, pins: &[Ix]) {
        self.next.clear();
        for (ix, count) in pins.iter().zip(&self.counts) {
            let bits = graph.item(*ix).map_or(0, |i| Graph::value(i.ty, i.bits()).bits());
            self.next.extend([bits, *count]);
        }
        if self.next == self.published {
            return;
        }
        let next = &self.next;
        self.writer.put(|words| {
            for (word, bits) in words.iter().zip(next) {
                word.store(*bits, Ordering::Relaxed);
            }
        });
        core::mem::swap(&mut self.next, &mut self.published);
    }
}

/// Returns whether a program may set this pin of its own: an input only while nothing else drives it.
fn may_write(graph: &Graph, ix: Ix, item: &Item) -> bool {
    let is_driven = || {
        let signal = graph.signal_of(ix).and_then(|signal| graph.signal(signal));
        signal.is_some_and(|signal| signal.writers > 0)
    };
    item.ty != Type::Port && (item.direction != Direction::In || !is_driven())
}

fn refused(why: &std::io::Error) -> Error {
    Error::System { what: "a page for a program's pins cannot be created", why: os::said(why) }
}

impl Client {
    /// Returns the time after an exchange at which the next one is due on the virtual clock: a
    /// program with a page sleeps as long as it likes, and the clock waits until it does.
    pub(crate) const fn poll_after(&self) -> i64 {
        if self.page.is_some() { 0 } else { self.poll_ns }
    }

    /// Takes the values that this client has written to its page.
    pub(crate) fn take_page(&mut self, engine: &Engine) {
        if let Some(page) = &mut self.page {
            page.take(engine.model.graph(), &self.pins);
        }
    }

    /// Publishes the values of this client's pins in its page.
    pub(crate) fn publish_page(&mut self, engine: &Engine) {
        if let Some(page) = &mut self.page {
            page.publish(engine.model.graph(), &self.pins);
        }
    }
}

impl Engine {
    /// Takes what clients have written to their pages, in the order in which they connected.
    pub(crate) fn take_pages(&mut self) {
        let Some(mut server) = self.clients.server.take() else { return };
        for c in &mut server.clients {
            c.take_page(self);
        }
        self.clients.server = Some(server);
    }
}

/// Returns the machine time at which a page is due for an exchange on the real clock.
pub(crate) fn next_exchange(clients: &[Client]) -> i64 {
    clients.iter().filter_map(|c| c.page.as_ref()).map(|page| page.due).min().unwrap_or(i64::MAX)
}

/// Exchanges the values of all pages on the real clock if one is due.
pub(crate) fn exchange_due(engine: &Engine, clients: &mut [Client]) {
    let now = engine.runtime.now();
    if engine.runtime.is_virtual() || next_exchange(clients) > now {
        return;
    }
    for c in clients.iter_mut() {
        c.take_page(engine);
    }
    for c in clients {
        c.publish_page(engine);
        if let Some(page) = &mut c.page {
            page.due = now.saturating_add(c.poll_ns.max(MIN_PERIOD_NS));
        }
    }
}

/// Shortest interval between two exchanges on the real clock, in nanoseconds.
const MIN_PERIOD_NS: i64 = 1_000_000;

/// Returns whether the pages of `other` are exchanged at a request of the client: on the virtual
/// clock, only pages of its own process, because others would depend on the speed of their programs.
fn concerns(engine: &Engine, pid: i32, other: &Client) -> bool {
    other.page.is_some() && (!engine.runtime.is_virtual() || other.pid == pid)
}

/// Takes the pages that a request of client `i` must see.
pub(crate) fn take_before(engine: &Engine, clients: &mut [Client], i: usize) {
    let Some(pid) = clients.get(i).map(|c| c.pid) else { return };
    for c in clients.iter_mut().filter(|c| concerns(engine, pid, c)) {
        c.take_page(engine);
    }
}

/// Publishes the pages that a request of client `i` may have changed.
pub(crate) fn publish_after(engine: &Engine, clients: &mut [Client], i: usize) {
    let Some(pid) = clients.get(i).map(|c| c.pid) else { return };
    for c in clients.iter_mut().filter(|c| concerns(engine, pid, c)) {
        c.publish_page(engine);
    }
}
