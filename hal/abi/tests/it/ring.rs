//! Shared rings: capacity, lost records, and corruption by the other side.
#![expect(unsafe_code, clippy::cast_possible_truncation, reason = "both sides of a ring")]

use core::cell::UnsafeCell;
use hal_abi::{Consumer, Got, Producer, RING_MAGIC, Ring};

/// Memory of a ring, as a program that maps it sees it.
struct Memory {
    words: Box<[UnsafeCell<u64>]>,
    depth: u32,
    width: u32,
}

/// Offsets of the two indices, in words.
const WRITTEN: usize = 8;
const TAKEN: usize = 16;

impl Memory {
    fn new(depth: u32, width: u32) -> Self {
        // Extra words for the alignment of the header.
        let n = Ring::bytes(depth, width) / 8 + 8;
        let memory = Self { words: (0..n).map(|_| UnsafeCell::new(0)).collect(), depth, width };
        // SAFETY: aligned, in bounds, not shared yet.
        unsafe { memory.ring().cast_mut().write(Ring::new(depth, width, [4; 24])) };
        memory
    }

    fn ring(&self) -> *const Ring {
        let first = self.words.as_ptr();
        // SAFETY: `align_offset` stays within the eight spare words.
        unsafe { first.add(first.align_offset(64)) }.cast()
    }

    fn producer(&self) -> Producer {
        // SAFETY: the memory lives as long as the test, which uses one writer at a time.
        unsafe { Producer::new(self.ring(), self.depth, self.width) }
    }

    fn consumer(&self) -> Consumer {
        // SAFETY: as above, one reader at a time.
        unsafe { Consumer::new(self.ring(), self.depth, self.width) }
    }

    fn word(&self, i: usize) -> *mut u64 {
        // SAFETY: tests access only words of the ring, so the offset is in bounds.
        unsafe { self.ring().cast_mut().cast::<u64>().add(i) }
    }

    fn scribble(&self, i: usize, word: u64) {
        // SAFETY: the test has one thread, and both sides hold only pointers.
        unsafe { self.word(i).write(word) };
    }

    fn read(&self, i: usize) -> u64 {
        // SAFETY: as above.
        unsafe { self.word(i).read() }
    }

    fn lost(&self) -> u64 {
        self.read(core::mem::offset_of!(Ring, lost) / 8)
    }
}

fn put(p: &mut Producer, n: u64) -> bool {
    p.put(|i| n * 10 + i as u64)
}

/// Takes the next record and returns its number and first value. Checks that its values are those
/// of `put`.
fn take(c: &mut Consumer) -> Result<(u64, u64), Got> {
    let mut values = Vec::new();
    match c.take(|i, bits| values.push((i as u64, bits))) {
        Got::Sample(number) => {
            let first = values.first().map_or(0, |v| v.1);
            assert!(values.iter().all(|(i, bits)| *bits == first + i), "{values:?}");
            Ok((number, first / 10))
        }
        other => Err(other),
    }
}

#[test]
fn the_head_says_what_it_is() {
    let m = Memory::new(5, 3);
    assert_eq!(m.read(0), RING_MAGIC);
    assert_eq!(m.read(0).to_le_bytes(), *b"elurref\x01");
    assert_eq!((m.read(1) as u32, (m.read(1) >> 32) as u32), (5, 3));
    assert_eq!(m.read(2).to_ne_bytes(), [4; 8]);
    assert_eq!(Ring::bytes(5, 3), 192 + 5 * (3 + 1) * 8);
}

#[test]
fn a_ring_holds_one_record_less_than_it_has_slots() {
    for (depth, width) in [(2, 1), (3, 2), (5, 4), (8, 21), (100, 1)] {
        let m = Memory::new(depth, width);
        let (mut p, mut c) = (m.producer(), m.consumer());
        let most = u64::from(depth) - 1;
        let (mut written, mut sample, mut lost) = (0, 0, 0);
        // Several times around, from empty to full and back.
        for _ in 0..50 {
            assert_eq!((u64::from(p.room()), p.waiting(), c.waiting()), (most, 0, 0));
            let mut kept = Vec::new();
            for n in 0..most + 3 {
                sample += 1;
                let fits = put(&mut p, sample);
                assert_eq!(fits, n < most, "{depth}: record {n}");
                if fits {
                    kept.push(sample);
                    written += 1;
                } else {
                    lost += 1;
                }
            }
            assert_eq!((p.room(), u64::from(p.waiting()), m.lost()), (0, most, lost));
            assert_eq!((u64::from(c.waiting()), m.read(WRITTEN)), (most, written));
            for number in kept {
                assert_eq!(take(&mut c), Ok((number, number)), "numbers skip what was lost");
            }
            assert_eq!(take(&mut c), Err(Got::Nothing));
            assert_eq!(m.read(TAKEN), written);
        }
    }
}

#[test]
fn a_side_that_is_new_goes_on_where_the_last_one_was() {
    let m = Memory::new(4, 1);
    let (mut p, mut c) = (m.producer(), m.consumer());
    assert!(put(&mut p, 1) && put(&mut p, 2));
    assert_eq!(take(&mut c), Ok((1, 1)));
    let mut c = m.consumer();
    assert_eq!(take(&mut c), Ok((2, 2)));
    assert_eq!(take(&mut c), Err(Got::Nothing));
    let mut p = m.producer();
    assert!(put(&mut p, 3));
    assert_eq!(take(&mut c), Ok((3, 3)));
}

/// Invalid indices, as seen by a side whose own index is 7, in a ring for 4 records.
const NONSENSE: [u64; 8] = [0, 1, 2, 12, 1 << 32, 1 << 63, u64::MAX - 3, u64::MAX];

/// Fills a ring of depth 5 with seven records, of which the last two have not been taken.
fn seven(m: &Memory) -> (Producer, Consumer) {
    let (mut p, mut c) = (m.producer(), m.consumer());
    for n in 1..=7 {
        assert!(put(&mut p, n));
        if n <= 5 {
            assert_eq!(take(&mut c), Ok((n, n)));
        }
    }
    (p, c)
}

#[test]
fn a_writer_believes_no_index_that_cannot_be() {
    for index in NONSENSE {
        let m = Memory::new(5, 2);
        let (mut p, mut c) = seven(&m);
        m.scribble(TAKEN, index);
        m.scribble(WRITTEN, index);
        assert_eq!((p.room(), p.waiting()), (0, 4), "{index}");
        assert!(!put(&mut p, 8), "{index}: refused");
        assert_eq!((m.lost(), m.read(WRITTEN)), (1, 7), "{index}: counted, and stated again");
        // A reader that did not trust the index either is not affected.
        assert_eq!(take(&mut c), Ok((6, 6)));
        assert_eq!(take(&mut c), Ok((7, 7)));
        assert!(put(&mut p, 9));
        assert_eq!(take(&mut c), Ok((9, 9)), "number 8 was lost");
    }
}

#[test]
fn a_reader_believes_no_index_that_cannot_be() {
    for index in NONSENSE {
        let m = Memory::new(5, 2);
        let (mut p, mut c) = seven(&m);
        m.scribble(TAKEN, index);
        m.scribble(WRITTEN, index);
        assert_eq!(c.waiting(), 0, "{index}");
        assert_eq!(take(&mut c), Err(Got::Nonsense), "{index}: refused");
        assert_eq!(m.read(TAKEN), 5, "{index}: stated again");
        assert!(put(&mut p, 8));
        for n in 6..=8 {
            assert_eq!(take(&mut c), Ok((n, n)));
        }
    }
}

#[test]
fn a_program_that_comes_after_a_scribbler_follows_the_engine() {
    for (index, word) in NONSENSE.iter().zip([0, 7, 8, u64::MAX, 3, 1 << 40, 5, 100]) {
        // The engine writes.
        let m = Memory::new(5, 2);
        let (mut p, _) = seven(&m);
        m.scribble(TAKEN, *index);
        m.scribble(WRITTEN, word);
        let mut next = m.consumer();
        for n in 8..20 {
            put(&mut p, n);
            next.follow();
            while take(&mut next).is_ok() {}
        }
        assert!(put(&mut p, 20));
        next.follow();
        assert_eq!(take(&mut next), Ok((20, 20)), "{index} {word}");

        // The engine reads.
        let m = Memory::new(5, 2);
        let (_, mut c) = seven(&m);
        m.scribble(TAKEN, *index);
        m.scribble(WRITTEN, word);
        let mut next = m.producer();
        for n in 8..20 {
            next.follow();
            put(&mut next, n);
            while c.take(|_, _| ()) == Got::Nothing && c.waiting() > 0 {}
            while matches!(c.take(|_, _| ()), Got::Sample(_)) {}
        }
        next.follow();
        assert!(put(&mut next, 20));
        assert_eq!(take(&mut c).map(|r| r.1), Ok(20), "{index} {word}");
    }
}

#[test]
fn records_are_whole_and_in_order_between_threads() {
    let m = Memory::new(8, 3);
    let (mut p, mut c) = (m.producer(), m.consumer());
    let writer = std::thread::spawn(move || (1..=20_000).filter(|n| put(&mut p, *n)).count());
    let (mut last, mut seen) = (0, 0);
    let mut see = |c: &mut Consumer| {
        while let Ok((number, n)) = take(c) {
            assert_eq!(number, n);
            assert!(number > last, "{number} after {last}");
            (last, seen) = (number, seen + 1);
        }
    };
    while !writer.is_finished() {
        see(&mut c);
    }
    see(&mut c);
    let written = writer.join().unwrap_or(0);
    assert_eq!((seen, written as u64 + m.lost()), (written, 20_000));
}
