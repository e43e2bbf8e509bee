//! Rings, seqlocks and plain records, as an author uses them.

use hal_bench::Bench;
use hal_component::{
    Builder, Component, Error, In, Out, Period, Plain, RingReader, RingWriter, SeqReader,
    SeqWriter, Touch, Update, abi::ty,
};

/// A record with every kind of field.
#[derive(Clone, Copy, Debug, Default, PartialEq, Plain)]
struct Point {
    /// Position in mm.
    position: [f64; 3],
    /// True at the last point.
    last: bool,
    /// Signed number.
    small: i32,
    /// Unsigned number.
    r#type: u64,
}

fn point(n: i32) -> Point {
    let x = f64::from(n);
    let number = u64::from(n.unsigned_abs());
    Point { position: [x, -x, x / 3.0], last: n % 2 == 0, small: -n, r#type: number }
}

#[derive(Touch)]
struct Give {
    number: In<i32>,
    refused: Out<u32>,
    ring: RingWriter<Point>,
    latest: SeqWriter<Point>,
}

impl Update for Give {
    fn update(&mut self, _: Period) {
        let point = point(self.number.get());
        self.latest.set(&point);
        if let Err(back) = self.ring.put(point) {
            assert_eq!(back, point);
            self.refused.set(self.refused.get() + 1);
        }
    }
}

#[derive(Touch)]
struct Take {
    from_ring: Out<i32>,
    from_lock: Out<i32>,
    taken: Out<u32>,
    waiting: Out<u64>,
    ring: RingReader<Point>,
    latest: SeqReader<Point>,
}

impl Update for Take {
    fn update(&mut self, _: Period) {
        self.waiting.set(self.ring.waiting());
        if let Some(taken) = self.ring.take() {
            let n = -taken.small;
            assert_eq!(taken, point(n), "a record arrives whole");
            self.from_ring.set(n);
            self.taken.set(self.taken.get() + 1);
        }
        let latest = self.latest.get();
        self.from_lock.set(-latest.small);
        assert!(latest == Point::default() || latest == point(-latest.small));
    }
}

struct Pair;

impl Component for Pair {
    const NAME: &'static str = "pair";
    const DOC: &'static str = "A writer and a reader.";
    fn create(b: &mut Builder<'_>) -> Result<(), Error> {
        let (ring, points) = b.ring(3);
        let (latest, copies) = b.seqlock(Point::default());
        let number = b.item("number", "Number of the record", 0)?;
        let refused = b.item("refused", "Records that did not fit", 0)?;
        b.function("give", "Writes", Give { number, refused, ring, latest })?;
        let take = Take {
            from_ring: b.item("from-ring", "Number of the record taken", 0)?,
            from_lock: b.item("from-lock", "Number of the latest record", 0)?,
            taken: b.item("taken", "Records taken", 0)?,
            waiting: b.item("waiting", "Records in the ring", 0)?,
            ring: points,
            latest: copies,
        };
        b.function("take", "Reads", take)
    }
}

#[test]
fn a_ring_keeps_order_and_refuses_when_full_and_a_seqlock_keeps_the_latest() {
    let mut bench = Bench::new();
    bench.load::<Pair>(&[]).unwrap();
    for n in 1..=5 {
        bench.set("pair.0.number", n);
        bench.run("pair.0.give", 1_000_000);
    }
    assert_eq!(bench.get::<u32>("pair.0.refused"), 2, "three fit");
    for (n, waiting) in [(1, 3_u64), (2, 2), (3, 1), (3, 0)] {
        bench.run("pair.0.take", 1_000_000);
        assert_eq!(bench.get::<i32>("pair.0.from-ring"), n);
        assert_eq!(bench.get::<u64>("pair.0.waiting"), waiting);
        assert_eq!(bench.get::<i32>("pair.0.from-lock"), 5);
    }
    assert_eq!(bench.get::<u32>("pair.0.taken"), 3);
    // Many times around the slots.
    for n in 1..1000 {
        bench.set("pair.0.number", n);
        bench.run("pair.0.give", 1_000_000);
        bench.run("pair.0.take", 1_000_000);
        assert_eq!(bench.get::<i32>("pair.0.from-ring"), n);
        assert_eq!(bench.get::<i32>("pair.0.from-lock"), n);
    }
}

#[test]
fn the_fields_of_a_record_are_known() {
    assert_eq!(Point::WORDS, 6);
    let fields: Vec<_> = Point::FIELDS.iter().map(|f| (f.ty, f.count)).collect();
    assert_eq!(fields, [(ty::FLOAT, 3), (ty::BIT, 1), (ty::S32, 1), (ty::U64, 1)]);
}

#[test]
fn the_words_of_a_record_make_it_again() {
    let mut words = Vec::new();
    point(-7).store(&mut |bits| words.push(bits));
    assert_eq!(words.len(), Point::WORDS);
    let mut from = words.into_iter();
    assert_eq!(Point::load(&mut || from.next().unwrap()), point(-7));
}
