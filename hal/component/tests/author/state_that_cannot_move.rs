use hal_component::{Component, Out, Period, Update};
use std::rc::Rc;

/// Holds what may not move to a realtime thread.
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
