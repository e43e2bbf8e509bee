//! `tap` and `feed`: shared rings, four slots deep.
use hal_component::{
    Builder, Component, Error, In, Out, Period, StreamIn, StreamOut, Touch, Update, abi::ty,
};

/// Writes a record of two values in every cycle: the number of records written, and ten times that.
#[derive(Debug)]
pub(crate) struct Tap;

#[derive(Debug, Touch)]
struct Write {
    on: In<bool>,
    cycles: Out<u32>,
    lost: Out<u32>,
    ring: StreamOut,
}

impl Component for Tap {
    const NAME: &'static str = "tap";
    const DOC: &'static str = "Writes a record in every cycle.";

    fn create(b: &mut Builder<'_>) -> Result<(), Error> {
        let write = Write {
            on: b.item("on", "Whether it writes.", true)?,
            cycles: b.item("cycles", "How many records it wanted to write.", 0)?,
            lost: b.item("lost", "How many found no room.", 0)?,
            ring: b.stream_out("", 5, &[ty::U32, ty::U32])?,
        };
        b.function("", "Writes.", write)
    }
}

impl Update for Write {
    fn update(&mut self, _: Period) {
        if !self.on.get() {
            return;
        }
        let n = self.cycles.get().wrapping_add(1);
        self.cycles.set(n);
        if !self.ring.put(|i| u64::from(if i == 0 { n } else { n.wrapping_mul(10) })) {
            self.lost.set(self.lost.get().wrapping_add(1));
        }
    }
}

/// Reads a record in every cycle.
#[derive(Debug)]
pub(crate) struct Feed;

#[derive(Debug, Touch)]
struct Read {
    on: In<bool>,
    first: Out<u32>,
    second: Out<u32>,
    taken: Out<u32>,
    empty: Out<u32>,
    ring: StreamIn,
}

impl Component for Feed {
    const NAME: &'static str = "feed";
    const DOC: &'static str = "Reads a record in every cycle.";

    fn create(b: &mut Builder<'_>) -> Result<(), Error> {
        let read = Read {
            on: b.item("on", "Whether it reads.", true)?,
            first: b.item("first", "The first value of the last record.", 0)?,
            second: b.item("second", "The second value of the last record.", 0)?,
            taken: b.item("taken", "How many records came.", 0)?,
            empty: b.item("empty", "How many cycles found none.", 0)?,
            ring: b.stream_in("", 5, &[ty::U32, ty::U32])?,
        };
        b.function("", "Reads.", read)
    }
}

impl Update for Read {
    fn update(&mut self, _: Period) {
        if !self.on.get() {
            return;
        }
        let mut record = [0; 2];
        let got = self.ring.take(|i, bits| {
            if let Some(place) = record.get_mut(i) {
                *place = u32::try_from(bits).unwrap_or(u32::MAX);
            }
        });
        let counter = if got { &self.taken } else { &self.empty };
        counter.set(counter.get().wrapping_add(1));
        if got {
            self.first.set(record[0]);
            self.second.set(record[1]);
        }
    }
}
