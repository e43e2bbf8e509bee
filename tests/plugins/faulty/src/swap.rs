//! `swap`.
use hal_component::{Builder, Component, Error, In, Out, Period, Touch, Update};

/// Checks that a change to values, links and functions is applied as a whole. Its inputs are always
/// equal, and only one of its functions `one` and `two` is in a thread: `one` while they are odd.
#[derive(Debug)]
pub(crate) struct Swap;

#[derive(Debug, Touch)]
struct Mark {
    ran: Out<u32>,
    #[state]
    digit: u32,
}

#[derive(Debug, Touch)]
struct Look {
    a: In<u32>,
    b: In<u32>,
    c: In<u32>,
    ran: Out<u32>,
    torn: Out<u32>,
    changes: Out<u32>,
    #[state]
    last: u32,
}

impl Component for Swap {
    const NAME: &'static str = "swap";
    const DOC: &'static str = "Sees whether a change to values, links and functions is whole.";

    fn create(b: &mut Builder<'_>) -> Result<(), Error> {
        let ran = b.item("ran", "What ran in this cycle, a digit each.", 0)?;
        let look = Look {
            a: b.item("a", "The same as the others.", 1)?,
            b: b.item("b", "The same as the others.", 1)?,
            c: b.item("c", "The same as the others.", 1)?,
            ran,
            torn: b.item("torn", "In how many cycles something did not fit.", 0)?,
            changes: b.item("changes", "In how many cycles there was something new.", 0)?,
            last: 1,
        };
        b.function("look", "Looks.", look)?;
        b.function("one", "Leaves a mark.", Mark { ran, digit: 1 })?;
        b.function("two", "Leaves another mark.", Mark { ran, digit: 2 })
    }
}

impl Update for Mark {
    fn update(&mut self, _: Period) {
        self.ran.set(self.ran.get().wrapping_mul(10).wrapping_add(self.digit));
    }
}

impl Update for Look {
    fn update(&mut self, _: Period) {
        let now = self.a.get();
        let runs = if now % 2 == 1 { 1 } else { 2 };
        if self.b.get() != now || self.c.get() != now || self.ran.get() != runs {
            self.torn.set(self.torn.get().wrapping_add(1));
        }
        if now != self.last {
            self.last = now;
            self.changes.set(self.changes.get().wrapping_add(1));
        }
        self.ran.set(0);
    }
}
