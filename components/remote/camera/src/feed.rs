//! A thread that receives pictures. The newest wins: a reader that is slow loses older ones, and delays nothing.

use crate::{Address, Refused, http::get, parts::Parts};
use hal_marks::{MAX_BYTES, Picture};
use std::{
    io::Read,
    sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError},
    thread,
    time::Duration,
};

/// Kinds of cameras.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Delivery {
    /// Stream of pictures in one answer.
    Mjpeg,
    /// A picture in each answer.
    Shot,
}

/// Latest picture, as it came.
#[derive(Default)]
struct Slot {
    /// Latest bytes, until they are taken.
    bytes: Option<Vec<u8>>,
    /// Number of pictures that came.
    count: u64,
    /// Reason why no more will come.
    end: Option<Refused>,
    /// Nobody takes pictures any more.
    is_left: bool,
}

type Shared = Arc<(Mutex<Slot>, Condvar)>;

/// Pictures of a camera.
pub struct Feed {
    shared: Shared,
    timeout: Duration,
    /// Number of the last picture that was taken.
    taken: u64,
}

fn lock(shared: &Shared) -> MutexGuard<'_, Slot> {
    shared.0.lock().unwrap_or_else(PoisonError::into_inner)
}

impl Feed {
    /// Starts to receive pictures. No wait for bytes lasts longer than the time-out.
    #[must_use]
    pub fn start(kind: Delivery, address: Address, timeout: Duration) -> Self {
        let shared = Shared::default();
        let own = shared.clone();
        // The thread ends with the connection, or when nobody takes pictures.
        drop(thread::spawn(move || {
            let Err(refused) = receive(kind, &address, timeout, &own);
            lock(&own).end = Some(refused);
            own.1.notify_all();
        }));
        Self { shared, timeout, taken: 0 }
    }

    /// Returns the newest picture that was not taken yet: its bytes, the decoded picture, and the number of pictures that
    /// came and were lost since the last one.
    ///
    /// # Errors
    /// No more pictures come, or this one is broken.
    pub fn take(&mut self) -> Result<(Vec<u8>, Picture, u64), Refused> {
        let mut slot = lock(&self.shared);
        loop {
            if let Some(bytes) = slot.bytes.take() {
                let lost = slot.count - self.taken - 1;
                self.taken = slot.count;
                drop(slot);
                let picture = Picture::decode(&bytes)?;
                return Ok((bytes, picture, lost));
            }
            if let Some(end) = slot.end {
                return Err(end);
            }
            let waited = self.shared.1.wait_timeout(slot, self.timeout * 2);
            let (again, result) = waited.unwrap_or_else(PoisonError::into_inner);
            slot = again;
            if result.timed_out() && slot.bytes.is_none() && slot.end.is_none() {
                return Err(Refused::Timeout);
            }
        }
    }
}

impl Drop for Feed {
    fn drop(&mut self) {
        lock(&self.shared).is_left = true;
    }
}

/// Receives pictures until the connection ends.
fn receive(
    kind: Delivery,
    address: &Address,
    timeout: Duration,
    shared: &Shared,
) -> Result<core::convert::Infallible, Refused> {
    let put = |bytes: Vec<u8>| {
        let mut slot = lock(shared);
        slot.bytes = Some(bytes);
        slot.count += 1;
        shared.1.notify_all();
        if slot.is_left { Err(Refused::Ended) } else { Ok(()) }
    };
    match kind {
        Delivery::Mjpeg => {
            let answer = get(address, timeout)?;
            let content = answer.content.clone();
            let mut parts = Parts::new(&content, answer)?;
            loop {
                put(parts.part()?)?;
            }
        }
        Delivery::Shot => loop {
            put(shot(address, timeout)?)?;
            // The next one is asked for when this one is taken.
            let mut slot = lock(shared);
            while slot.bytes.is_some() && !slot.is_left {
                let waited = shared.1.wait_timeout(slot, Duration::from_millis(20));
                slot = waited.unwrap_or_else(PoisonError::into_inner).0;
            }
        },
    }
}

/// Returns the bytes of one picture.
fn shot(address: &Address, timeout: Duration) -> Result<Vec<u8>, Refused> {
    let mut bytes = Vec::new();
    let limit = u64::try_from(MAX_BYTES).unwrap_or(u64::MAX).saturating_add(1);
    get(address, timeout)?.take(limit).read_to_end(&mut bytes)?;
    if bytes.len() > MAX_BYTES { Err(Refused::Large) } else { Ok(bytes) }
}
