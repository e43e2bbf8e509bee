//! Realtime. A card that is simulated in the process.

use core::time::Duration;
use crossbeam::atomic::AtomicCell;
use hal_card::{Board, Card};
use hal_lbp16::MAX_PACKET;
use port::{Exchange, Lost};

/// Simulated card, and the answers that it has given.
struct Inside {
    card: Card,
    /// Moment up to which its time has gone on, in nanoseconds.
    now: Option<i64>,
    answers: [Answer; ANSWERS],
    /// Number of answers that wait, the oldest first.
    waiting: usize,
}

/// Most answers that wait: those to more questions are lost, as in a network.
const ANSWERS: usize = 4;

#[derive(Clone, Copy)]
struct Answer {
    bytes: [u8; MAX_PACKET],
    len: usize,
}

/// Way to a simulated card. One thread at a time has the card; another one finds nobody there.
pub(crate) struct SimulatedCard(AtomicCell<Option<Box<Inside>>>);

impl SimulatedCard {
    pub(crate) fn new(board: &Board) -> Self {
        let empty = Answer { bytes: [0; MAX_PACKET], len: 0 };
        let inside =
            Inside { card: Card::new(board), now: None, answers: [empty; ANSWERS], waiting: 0 };
        Self(AtomicCell::new(Some(Box::new(inside))))
    }

    /// Runs `f` with the card.
    fn with<T>(&self, f: impl FnOnce(&mut Inside) -> T) -> Result<T, Lost> {
        let mut inside = self.0.take().ok_or(BUSY)?;
        let done = f(&mut inside);
        self.0.store(Some(inside));
        Ok(done)
    }
}

/// Error of a card that another thread has (EBUSY).
const BUSY: Lost = Lost(16);

impl Exchange for SimulatedCard {
    fn send(&self, packet: &[u8]) -> Result<(), Lost> {
        self.with(|inside| {
            let waiting = inside.waiting;
            let mut none = [0; MAX_PACKET];
            match inside.answers.get_mut(waiting) {
                Some(answer) => {
                    if let Some(len) = inside.card.answer(packet, &mut answer.bytes) {
                        answer.len = len;
                        inside.waiting += 1;
                    }
                }
                None => {
                    let _ = inside.card.answer(packet, &mut none);
                }
            }
        })
    }

    fn receive(&self, into: &mut [u8], _: Duration) -> Result<usize, Lost> {
        self.with(|inside| {
            let [answer, ..] = &inside.answers;
            if inside.waiting == 0 {
                return 0;
            }
            let len = answer.len;
            for (to, from) in into.iter_mut().zip(answer.bytes.get(..len).unwrap_or_default()) {
                *to = *from;
            }
            inside.answers.rotate_left(1);
            inside.waiting -= 1;
            len
        })
    }

    fn advance(&self, now_ns: i64) {
        // A card that another thread has goes on at the next call.
        let _ = self.with(|inside| {
            let passed = now_ns.saturating_sub(inside.now.unwrap_or(now_ns));
            inside.now = Some(now_ns);
            inside.card.advance(u64::try_from(passed).unwrap_or(0));
        });
    }
}
