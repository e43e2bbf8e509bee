//! Realtime. Causes of stops, kept until somebody reads them.

use hal_component::Sender;

/// Number of causes that are kept; later ones are lost until these are read.
pub(crate) const MAX_STOPS: usize = 16;

/// A stop and its cause.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Stop {
    /// Machine time in nanoseconds.
    pub(crate) time_ns: i64,
    pub(crate) cause: &'static str,
}

/// Sender of causes to the control side.
#[derive(Debug)]
pub(crate) struct Stops(Sender<Stop>);

impl Stops {
    pub(crate) const fn new(to: Sender<Stop>) -> Self {
        Self(to)
    }

    /// Keeps a cause. The first causes count: they explain the later ones.
    pub(crate) fn keep(&self, time_ns: i64, cause: &'static str) {
        let _is_full = self.0.send(Stop { time_ns, cause });
    }
}
