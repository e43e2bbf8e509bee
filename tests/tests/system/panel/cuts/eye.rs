//! The machine's own view of a jog: samples of every servo cycle, in machine time.

use hal_protocol::{Client, SampleSpec, Samples};
use hal_tests::scratch::{Scratch, until};

/// Names of the values of a sample, in this order.
const NAMES: [&str; 5] =
    ["remote.pulse", "remote.beat", "remote.permit", "joint.0.pos-cmd", "joint.0.vel-cmd"];
/// Samples that the ring holds: half a minute.
const DEPTH: u32 = 30_000;
/// Cycles within which a jog that was accepted begins.
const BEGIN: usize = 500;
/// Cycles for which a machine that rests is watched.
const REST: usize = 20;

/// Values after a cycle of the servo thread.
#[derive(Clone, Copy, Debug)]
pub(super) struct Seen {
    /// Machine time in nanoseconds.
    pub(super) ns: i64,
    /// Age of the number that has returned last, in milliseconds.
    pub(super) age: u32,
    /// Commanded position and velocity of X.
    pub(super) x: f64,
    pub(super) v: f64,
}

/// A reader of samples.
pub(super) struct Eye {
    samples: Samples,
    record: Vec<u64>,
    /// True if samples were lost since the last `forget`: nobody read them for half a minute.
    has_lost: bool,
    /// Samples since the last `forget`.
    pub(super) seen: Vec<Seen>,
    _client: Client,
}

impl Eye {
    pub(super) fn open(scratch: &Scratch) -> Self {
        let place = scratch.place("default");
        let mut client = Client::connect(&place, "").unwrap();
        let spec = SampleSpec {
            thread: Some("servo-thread".to_owned()),
            depth: DEPTH,
            names: NAMES.map(str::to_owned).to_vec(),
            ..SampleSpec::default()
        };
        let samples = client.sample(spec).unwrap();
        Self { samples, record: Vec::new(), has_lost: false, seen: Vec::new(), _client: client }
    }

    /// Reads all samples so far; returns the latest.
    pub(super) fn look(&mut self) -> Option<Seen> {
        while let Some(stamp) = self.samples.take_bits(&mut self.record) {
            self.has_lost |= stamp.lost > 0;
            let [pulse, beat, _, x, v] = self.record[..] else { panic!("{:?}", self.record) };
            let short = |n: u64| u32::try_from(n & u64::from(u32::MAX)).unwrap();
            self.seen.push(Seen {
                ns: stamp.time,
                age: short(pulse).wrapping_sub(short(beat)),
                x: f64::from_bits(x),
                v: f64::from_bits(v),
            });
        }
        self.seen.last().copied()
    }

    /// Returns all samples since the last `forget`.
    pub(super) fn all(&self) -> &[Seen] {
        assert!(!self.has_lost, "samples of the cut were lost");
        &self.seen
    }

    /// Forgets all samples but the latest.
    pub(super) fn forget(&mut self) {
        self.look();
        self.has_lost = false;
        let keep = self.seen.len().saturating_sub(1);
        self.seen.drain(..keep);
    }

    /// Waits for so many further samples.
    pub(super) fn pass(&mut self, cycles: usize) {
        self.look();
        let from = self.seen.len();
        until("cycles pass", || {
            self.look();
            from + cycles <= self.seen.len()
        });
    }

    /// Waits until X moves at a constant speed; returns false if it comes to rest before.
    pub(super) fn moves(&mut self, cycles: usize) -> bool {
        let steady = |seen: &[Seen]| {
            let last = seen.len().saturating_sub(cycles);
            let (tail, speed) = (&seen[last..], seen.last().map_or(0.0, |s| s.v));
            tail.len() == cycles && speed != 0.0 && tail.iter().all(|s| s.v == speed)
        };
        self.forget();
        let mut has_moved = false;
        let mut ends = false;
        until("X moves", || {
            self.look();
            has_moved |= self.seen.iter().any(|s| s.v != 0.0);
            // On a busy computer the dead man may end a jog before it has begun.
            let rests = self.seen.last().is_some_and(|s| s.v == 0.0);
            ends = rests && (has_moved || BEGIN < self.seen.len());
            ends || steady(&self.seen)
        });
        !ends
    }

    /// Waits until X rests.
    pub(super) fn rests(&mut self) {
        until("X rests", || {
            self.look();
            let last = self.seen.len().saturating_sub(REST);
            self.seen.len() > REST && self.seen[last..].iter().all(|s| s.v == 0.0)
        });
    }
}
