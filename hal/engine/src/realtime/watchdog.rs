//! Identification of a thread that does not return from a function. It works from outside the
//! thread, because on the virtual clock nothing else would report the thread.

use crate::{
    realtime::shared::Shared,
    realtime::thread::Thread,
    sync::{Arc, Ordering},
};
use hal_protocol::FaultInfo;
use std::{
    sync::mpsc::{RecvTimeoutError, Sender, channel},
    thread::JoinHandle,
    time::Duration,
};

/// Interval between observations.
const LOOK: Duration = Duration::from_millis(500);
/// Number of observations of the same cycle, in the same function, after which a thread is stuck.
/// Observations are counted and not seconds, because a machine that is busy or suspended is late
/// with them as well.
const LOOKS: u32 = 5;
/// Number of threads for which memory is reserved at the start.
const RESERVED_THREADS: usize = 64;

/// The observing thread; it ends when this value is dropped.
#[derive(Debug)]
pub(crate) struct Watchdog {
    end: Option<Sender<()>>,
    running: Option<JoinHandle<()>>,
}

/// Result of the last observation of a thread.
#[derive(Clone, Copy, Debug)]
struct Seen {
    thread: u32,
    cycles: u64,
    funct: u32,
    looks: u32,
}

impl Watchdog {
    /// Starts observing; returns `None` if the system cannot start a thread for it.
    pub(crate) fn begin(shared: Arc<Shared>) -> Option<Self> {
        let (end, ended) = channel();
        let (ready, is_ready) = channel::<()>();
        let run = move || {
            // Allocates all the memory that it needs for the first observation, so that a running
            // engine takes no more memory later.
            let mut seen = Vec::with_capacity(RESERVED_THREADS);
            look(&shared, &mut seen);
            drop(ready);
            while ended.recv_timeout(LOOK) == Err(RecvTimeoutError::Timeout) {
                look(&shared, &mut seen);
            }
        };
        let running = std::thread::Builder::new().name("hal-watchdog".into()).spawn(run).ok()?;
        // Nothing is sent: the channel closes when the first observation is over.
        is_ready.recv().unwrap_or_default();
        Some(Self { end: Some(end), running: Some(running) })
    }
}

impl Drop for Watchdog {
    fn drop(&mut self) {
        drop(self.end.take());
        if let Some(running) = self.running.take() {
            drop(running.join());
        }
    }
}

fn look(shared: &Shared, seen: &mut Vec<Seen>) {
    let threads = shared.threads.load_full();
    seen.retain(|s| threads.iter().any(|t| t.id == s.thread));
    let mut stuck = None;
    for t in threads.iter() {
        let (cycles, funct) = (t.cycles.load(Ordering::Relaxed), t.current.load(Ordering::Relaxed));
        let now = Seen { thread: t.id, cycles, funct, looks: 0 };
        let Some(last) = seen.iter_mut().find(|s| s.thread == t.id) else {
            seen.push(now);
            continue;
        };
        if !t.gate.is_inside() || last.cycles != cycles || last.funct != funct {
            if last.looks >= LOOKS {
                tracing::warn!(thread = t.name.as_str(), "thread '{}' has come back", t.name);
            }
            *last = now;
            continue;
        }
        last.looks = last.looks.saturating_add(1);
        if last.looks >= LOOKS && stuck.is_none() {
            stuck = Some((t, last.looks == LOOKS));
        }
    }
    let Some((thread, first)) = stuck else {
        shared.stuck.store(None);
        return;
    };
    if first && let Some(info) = named(thread) {
        tracing::error!(
            component = info.component.as_str(),
            thread = info.thread.as_str(),
            funct = info.funct.as_str(),
            "function '{}' of component '{}' does not come back: thread '{}' is stuck in it",
            info.funct,
            info.component,
            info.thread
        );
        shared.stuck.store(Some(Arc::new(info)));
    }
}

/// Names the function that a thread is in, with its component.
fn named(thread: &Thread) -> Option<FaultInfo> {
    let (component, funct) = thread.running()?;
    Some(FaultInfo {
        component: component.as_str().to_owned(),
        funct: funct.as_str().to_owned(),
        thread: thread.name.as_str().to_owned(),
        cause: "it does not come back".to_owned(),
    })
}
