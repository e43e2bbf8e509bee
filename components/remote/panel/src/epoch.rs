//! The stop epoch of motion: an order is stamped with the one in which its message arrived.

use hal_lease::EpochPage;
use hal_protocol::{Client, Place};
use std::{
    sync::{
        Mutex, PoisonError,
        atomic::{AtomicU64, AtomicUsize, Ordering::SeqCst},
    },
    time::Duration,
};
use tokio::time::sleep;

/// Cycles of motion after a stop was commanded until its record has the epoch.
const CYCLES: u64 = 2;
/// Time between two looks at a record that has not got there, and their number: where time stands still, it never does.
const LOOK: Duration = Duration::from_millis(1);
const MAX_LOOKS: u32 = 50;

/// The epoch of an order.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Given {
    /// The epoch in which it was given; `None` where motion has none.
    In(Option<u64>),
    /// A stop of this panel is on its way: the next one is that of the order.
    AfterStop,
}

/// The epochs of motion.
#[derive(Debug, Default)]
pub(crate) struct Epochs {
    page: Mutex<Option<EpochPage>>,
    /// Number of stops of this panel that the engine has not answered.
    on_way: AtomicUsize,
    /// Cycle from which on the record has the epoch of this panel's last stop.
    settled_at: AtomicU64,
}

impl Epochs {
    /// Opens the record of motion, if there is one.
    pub(crate) fn open(place: &Place) -> Self {
        let client = Client::connect(place, "");
        let page = client.ok().and_then(|mut client| EpochPage::open(&mut client));
        Self { page: Mutex::new(page), ..Self::default() }
    }

    fn read(&self) -> Option<(u64, u64)> {
        self.page.lock().unwrap_or_else(PoisonError::into_inner).as_mut()?.read()
    }

    /// Notes that this panel stops the machine.
    pub(crate) fn begin_stop(&self) {
        self.on_way.fetch_add(1, SeqCst);
    }

    /// Notes that the engine has answered a stop.
    pub(crate) fn end_stop(&self) {
        let cycle = self.read().map_or(0, |(cycle, _)| cycle);
        self.settled_at.fetch_max(cycle + CYCLES, SeqCst);
        self.on_way.fetch_sub(1, SeqCst);
    }

    /// Returns the epoch of an order that arrives now.
    pub(crate) fn now(&self) -> Given {
        let is_stopping = self.on_way.load(SeqCst) != 0;
        match self.read() {
            None => Given::In(None),
            Some((cycle, _)) if is_stopping || cycle < self.settled_at.load(SeqCst) => {
                Given::AfterStop
            }
            Some((_, epoch)) => Given::In(Some(epoch)),
        }
    }

    /// Returns the epoch of an order, after the stops of this panel that came before it.
    pub(crate) async fn settled(&self, given: Given) -> Option<u64> {
        let mut given = given;
        for _ in 0..MAX_LOOKS {
            match given {
                Given::In(epoch) => return epoch,
                Given::AfterStop => sleep(LOOK).await,
            }
            given = self.now();
        }
        None
    }
}
