//! `witness`.
use hal_component::{Builder, Clock, Component, Error, In, Out, Period, Touch, Update};

/// Checks that a change to the wiring is applied as a whole: its two inputs are always linked
/// together.
#[derive(Debug)]
pub(crate) struct Witness;

#[derive(Debug, Touch)]
struct Look {
    a: In<u32>,
    b: In<u32>,
    ns: In<i64>,
    torn: Out<u32>,
    changes: Out<u32>,
    cycles: Out<u32>,
    clock: Clock,
    #[state]
    last: u32,
}

impl Component for Witness {
    const NAME: &'static str = "witness";
    const DOC: &'static str = "Sees whether a change to the wiring is whole.";

    fn create(b: &mut Builder<'_>) -> Result<(), Error> {
        let look = Look {
            a: b.item("a", "The same as b.", 0)?,
            b: b.item("b", "The same as a.", 0)?,
            ns: b.item("ns", "How long it looks, in nanoseconds.", 0)?,
            torn: b.item("torn", "How often they differed, or changed within a cycle.", 0)?,
            changes: b.item("changes", "How often they had changed since the last cycle.", 0)?,
            cycles: b.item("cycles", "Cycles run.", 0)?,
            clock: b.clock(),
            last: 0,
        };
        b.function("", "Looks.", look)
    }
}

impl Update for Look {
    fn update(&mut self, _: Period) {
        let first = self.a.get();
        let end = self.clock.now_ns().wrapping_add(self.ns.get());
        let mut torn = false;
        loop {
            torn |= self.a.get() != first || self.b.get() != first;
            if self.clock.is_virtual() || self.clock.now_ns() >= end {
                break;
            }
        }
        if torn {
            self.torn.set(self.torn.get().wrapping_add(1));
        }
        if first != self.last {
            self.last = first;
            self.changes.set(self.changes.get().wrapping_add(1));
        }
        self.cycles.set(self.cycles.get().wrapping_add(1));
    }
}
