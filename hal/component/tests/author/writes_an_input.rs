use hal_component::{Component, In, Out, Period, Update};

/// Writes an input.
#[derive(Component)]
struct Wrong {
    /// Input.
    in_: In<bool>,
    /// Output.
    out: Out<bool>,
}

impl Update for Wrong {
    fn update(&mut self, _: Period) {
        self.in_.set(self.out.get());
    }
}

fn main() {}
