//! Samples: records of pins, signals and parameters that a client receives through a shared ring.

mod reading;

use crate::{
    Engine, Error,
    error::watch::WatchError,
    graph::Ix,
    name::Name,
    observe::probe::{Probe, Source},
    observe::probes::{At, Watching},
    observe::ring::Memory,
    os,
    serve::hold::Hold,
    sync::Arc,
};
use hal_abi::Ring;
use hal_protocol::{
    ChannelInfo, Failure, MAX_CHANNELS, Patterns, SampleInfo, SampleSpec, SampleState, Samples,
    Type,
};
pub(crate) use reading::Sample;
use std::os::fd::OwnedFd;

/// Largest memory of the rings of all samples together, in bytes.
const MAX_BYTES: usize = 1 << 30;
/// Largest default size of a sample's ring, in bytes.
const DEFAULT_BYTES: usize = 16 << 20;
/// Smallest default number of samples that a ring holds.
const FEWEST: u32 = 64;
/// Client number of this process itself.
const NOBODY: u64 = 0;

/// A channel of a sample.
struct Channel {
    info: ChannelInfo,
    source: Source,
    node: Ix,
}

impl Engine {
    /// Samples for a reader in this process. The sample ends with the engine, or with
    /// [`hal_protocol::Request::EndSample`]; time does not wait for its reader.
    ///
    /// # Errors
    /// As [`hal_protocol::Client::sample`].
    pub fn sample(&mut self, spec: &SampleSpec) -> Result<Samples, Failure> {
        let spec = SampleSpec { wait: false, ..spec.clone() };
        let (info, fd) = self.begin_sample(NOBODY, &spec)?;
        Ok(Samples::map(&fd, info).map_err(|why| Error::Protocol { why: why.into() })?)
    }

    /// Starts a sample for a client.
    pub(crate) fn begin_sample(
        &mut self,
        client: u64,
        spec: &SampleSpec,
    ) -> Result<(SampleInfo, OwnedFd), Error> {
        let thread = match &spec.thread {
            Some(name) => self.model.graph().find_thread(name)?,
            None => self.fastest().ok_or(WatchError::NoThread)?,
        };
        let Some(node) = self.model.graph().thread(thread) else {
            return Err(WatchError::NoThread.into());
        };
        let (thread_name, period) = (node.name.as_str().to_owned(), node.thread.period_ns);
        let channels = self.channels(&spec.names)?;
        let every = spec.every.max(1);
        let depth = self.depth(spec.depth, channels.len(), period.saturating_mul(every.into()))?;
        let width = u32::try_from(channels.len() + 1).unwrap_or(u32::MAX);
        let no_memory = |why: String| Error::Protocol { why: why.into() };
        let memory = Arc::new(Memory::new(depth + 1, width, [0; 24]).map_err(no_memory)?);
        let fd = memory.file().map_err(|e| Error::System {
            what: "the ring cannot be handed over",
            why: os::said(&e),
        })?;
        let sources = channels.iter().map(|c| c.source).collect();
        let probe = Arc::new(Probe::records(sources, every, memory.clone()));
        let lossless = spec.wait && self.runtime.is_virtual();
        let id = self.begin_watching(Watching {
            probe: probe.clone(),
            at: At::Thread(thread),
            nodes: channels.iter().map(|c| c.node).collect(),
            lossless,
        })?;
        let bytes = Ring::bytes(depth + 1, width);
        self.observers.samples.insert(
            id,
            Sample { client, probe, memory, bytes, hold: (0, Hold::NONE), ended: None },
        );
        let channels = channels.into_iter().map(|c| c.info).collect();
        let (thread, wait) = (thread_name, lossless);
        Ok((SampleInfo { id, thread, period, every, depth, wait, channels }, fd))
    }

    /// Returns the fastest thread.
    fn fastest(&self) -> Option<Ix> {
        let threads = self.model.graph().threads.values().copied();
        let key =
            |ix: &Ix| self.model.graph().thread(*ix).map(|t| (t.thread.period_ns, t.thread.id));
        threads.min_by_key(key)
    }

    /// Returns the number of samples that a ring is to hold.
    fn depth(&self, asked: u32, channels: usize, every_ns: i64) -> Result<u32, Error> {
        let one = (channels + 2) * 8;
        let used: usize = self.observers.samples.values().map(|s| s.bytes).sum();
        let most = MAX_BYTES.saturating_sub(used) / one;
        let most = u32::try_from(most).unwrap_or(u32::MAX).saturating_sub(2).min(1 << 26);
        if asked == 0 {
            let second = u32::try_from(1_000_000_000 / every_ns.max(1)).unwrap_or(u32::MAX);
            let usual = u32::try_from(DEFAULT_BYTES / one).unwrap_or(u32::MAX);
            let depth = second.min(usual).max(FEWEST);
            return if depth <= most {
                Ok(depth)
            } else {
                Err(WatchError::TooDeep { depth, most }.into())
            };
        }
        if asked <= most {
            Ok(asked)
        } else {
            Err(WatchError::TooDeep { depth: asked, most }.into())
        }
    }

    /// Resolves names and patterns to channels, in their order.
    fn channels(&self, names: &[String]) -> Result<Vec<Channel>, Error> {
        let mut channels = Vec::new();
        for word in names {
            if word.contains(['*', '?', '[']) {
                let before = channels.len();
                self.matching(word, &mut channels);
                if channels.len() == before {
                    return Err(WatchError::NoMatch { pattern: word.as_str().into() }.into());
                }
                continue;
            }
            channels.push(self.channel(word)?);
        }
        if channels.is_empty() {
            return Err(WatchError::NoNames.into());
        }
        if channels.len() > MAX_CHANNELS {
            return Err(WatchError::TooMany { channels: channels.len() }.into());
        }
        Ok(channels)
    }

    fn channel(&self, word: &str) -> Result<Channel, Error> {
        let node = self.watchable(word)?;
        let name = word.strip_prefix("sig:").unwrap_or(word);
        self.open_channel(node, name).ok_or_else(|| WatchError::Port { name: name.into() }.into())
    }

    /// Finds the pin, parameter or signal of this name.
    pub(crate) fn watchable(&self, word: &str) -> Result<Ix, Error> {
        let found = match word.strip_prefix("sig:") {
            Some(name) => self.model.graph().signal_named(name),
            None => {
                let graph = self.model.graph();
                let item = graph.item_named(false, word).or_else(|| graph.item_named(true, word));
                item.or_else(|| graph.signal_named(word))
            }
        };
        found.ok_or_else(|| {
            let graph = self.model.graph();
            let all = graph.all_item_names().chain(graph.signal_names());
            let all = all.map(|(name, _)| name.as_str());
            let (what, near) = ("pin, parameter or signal", graph.near(word, all));
            Error::NotFound { what, name: word.into(), near }
        })
    }

    /// Makes a channel of this name from a node; `None` for ports, which have no values.
    fn open_channel(&self, node: Ix, name: &str) -> Option<Channel> {
        let item = self.model.graph().item(node).map(|i| i.ty);
        let ty = item.or_else(|| self.model.graph().signal(node).map(|s| s.ty))?;
        let source = self.source(node)?;
        let info = ChannelInfo { name: name.to_owned(), ty };
        (ty != Type::Port).then_some(Channel { info, source, node })
    }

    /// Appends all channels that match a pattern: pins and parameters by name, then signals by
    /// name. Skips the engine's time items, simulated registers that the pattern does not spell
    /// out, and nodes that `out` already has.
    fn matching(&self, word: &str, out: &mut Vec<Channel>) {
        let (pattern, signals_only) = match word.strip_prefix("sig:") {
            Some(pattern) => (pattern, true),
            None => (word, false),
        };
        let pattern = Patterns::new(&[pattern.to_owned()]);
        let wanted = |name: &Name, ix: Ix| {
            // An item with two names must not occur twice.
            self.model.graph().item(ix).is_none_or(|item| {
                let simulated = item.hidden() && !pattern.spell(".sim", name.as_str());
                item.shown() == name && !item.times && !simulated
            }) && pattern.names(name.as_str())
        };
        let graph = self.model.graph();
        let items = graph.all_item_names().filter(|_| !signals_only);
        let all = items.chain(graph.signal_names());
        for (name, ix) in all.filter(|(name, ix)| wanted(name, *ix)) {
            let known = out.iter().any(|c| c.node == ix);
            out.extend(self.open_channel(ix, name.as_str()).filter(|_| !known));
        }
    }

    fn sample_of(&self, client: u64, id: u64) -> Result<&Sample, Error> {
        let own = self.observers.samples.get(&id).filter(|s| s.client == client);
        own.ok_or_else(|| WatchError::NoSample { id }.into())
    }

    /// Returns the state of a sample.
    pub(crate) fn sample_state(&self, client: u64, id: u64) -> Result<SampleState, Error> {
        let s = self.sample_of(client, id)?;
        let ended = s.ended.map(str::to_owned);
        Ok(SampleState { samples: s.probe.samples(), lost: s.probe.lost(), ended })
    }

    /// Ends a sample and returns its final state.
    pub(crate) fn end_sample(&mut self, client: u64, id: u64) -> Result<SampleState, Error> {
        self.sample_of(client, id)?;
        self.end_watching(id);
        let mut state = self.sample_state(client, id)?;
        state.ended.get_or_insert_with(|| "its reader has ended it".to_owned());
        if let Some(s) = self.observers.samples.remove(&id) {
            s.memory.ring().close();
        }
        Ok(state)
    }

    /// Ends the samples of a client that has disconnected.
    pub(crate) fn end_samples_of(&mut self, client: u64) {
        let its = self.observers.samples.iter().filter(|(_, s)| s.client == client);
        for id in its.map(|(id, _)| *id).collect::<Vec<_>>() {
            self.end_watching(id);
            self.observers.samples.remove(&id);
        }
    }

    /// Ends a sample because something that it watched has been removed, and informs its reader.
    pub(crate) fn sample_parted(&mut self, id: u64) {
        if let Some(s) = self.observers.samples.get_mut(&id) {
            s.ended = Some("something that was sampled has been unloaded or deleted");
            s.memory.ring().close();
        }
    }
}
