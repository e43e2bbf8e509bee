//! The ring and the seqlock that `hal-component` offers to authors, and the seqlock of shared pages.

#[path = "../../../hal/component/src/ring.rs"]
mod ring;
#[path = "../../../hal/abi/src/seqlock.rs"]
mod seqlock;

use crate::sync::{AtomicU64, Ordering::Relaxed};
use loom::{sync::Arc, thread};
use std::sync::atomic::{AtomicUsize, Ordering};

fn words(n: usize) -> Box<[AtomicU64]> {
    (0..n).map(|_| AtomicU64::new(0)).collect()
}

/// Checks every interleaving with at most four involuntary switches of thread.
fn checked(model: impl Fn() + Sync + Send + 'static) {
    let mut checker = loom::model::Builder::new();
    checker.preemption_bound = Some(4);
    checker.check(model);
}

/// Records arrive whole, in order, and each once; a full ring refuses.
#[test]
fn records_of_a_ring_arrive_whole_and_in_order() {
    static REFUSED: AtomicUsize = AtomicUsize::new(0);
    static WRAPPED: AtomicUsize = AtomicUsize::new(0);
    checked(|| {
        let ring = Arc::new(ring::Slots::over(words(4), 2));
        let reader = {
            let ring = Arc::clone(&ring);
            thread::spawn(move || {
                let mut last = 0;
                for _ in 0..2 {
                    let taken = ring.take(|slot| (slot[0].load(Relaxed), slot[1].load(Relaxed)));
                    if let Some((a, b)) = taken {
                        assert_eq!(a, b, "a record is whole");
                        assert_eq!(a, last + 1, "no record is lost or doubled");
                        last = a;
                    }
                }
            })
        };
        let put = |n: u64| ring.put(|slot| slot.iter().for_each(|w| w.store(n, Relaxed)));
        assert!(put(1) && put(2), "two records fit");
        let seen = if put(3) { &WRAPPED } else { &REFUSED };
        seen.fetch_add(1, Ordering::Relaxed);
        assert!(ring.waiting() <= 2);
        reader.join().unwrap();
    });
    let seen = (REFUSED.load(Ordering::Relaxed), WRAPPED.load(Ordering::Relaxed));
    assert!(seen.0 > 0 && seen.1 > 0, "the model is too small: {seen:?}");
}

/// A copy is the record of one write, and later copies are not older.
#[test]
fn a_reader_of_a_seqlock_gets_the_record_of_one_write() {
    static COPIED: AtomicUsize = AtomicUsize::new(0);
    static BUSY: AtomicUsize = AtomicUsize::new(0);
    checked(|| {
        let shared = Arc::new((AtomicU64::new(0), words(2)));
        let writer = {
            let shared = Arc::clone(&shared);
            thread::spawn(move || {
                let (sequence, words) = &*shared;
                let mut number = 0;
                for n in [1, 2] {
                    seqlock::begin(sequence, number);
                    words.iter().for_each(|w| w.store(n, Relaxed));
                    seqlock::end(sequence, &mut number);
                }
            })
        };
        let (sequence, words) = &*shared;
        let mut last = 0;
        for _ in 0..2 {
            let mut copy = [0; 2];
            let number = seqlock::read(sequence, || {
                copy = [words[0].load(Relaxed), words[1].load(Relaxed)];
            });
            match number {
                Some(number) => {
                    assert_eq!(copy, [number / 2; 2], "the record of one write");
                    assert!(number >= last);
                    last = number;
                    COPIED.fetch_add(1, Ordering::Relaxed);
                }
                None => {
                    BUSY.fetch_add(1, Ordering::Relaxed);
                }
            }
        }
        writer.join().unwrap();
    });
    assert!(COPIED.load(Ordering::Relaxed) > 0 && BUSY.load(Ordering::Relaxed) > 0);
}
