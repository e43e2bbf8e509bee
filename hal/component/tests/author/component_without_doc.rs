use hal_component::{Component, Out, Period, Update};

#[derive(Component)]
struct Wrong {
    /// Output.
    out: Out<bool>,
}

impl Update for Wrong {
    fn update(&mut self, _: Period) {
        self.out.set(true);
    }
}

fn main() {}
