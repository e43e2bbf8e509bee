use hal_component::{Component, Out, Period, Update};
use std::rc::Rc;

/// Holds state that must not move to a realtime thread.
#[derive(Component)]
struct Wrong {
    /// Output.
    out: Out<bool>,
    #[state]
    shared: Rc<bool>,
}

impl Update for Wrong {
    fn update(&mut self, _: Period) {
        self.out.set(*self.shared);
    }
}

fn main() {}
